//! How large the boxes of the landmarks are that a drive has taught a map of.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::map::SpacePoint;

use crate::{run::RunRecord, scene::Scene};

/// Figures that are shares of a map's landmarks, each with the volume in m³ below which a box counts: those by which paper 4 tells its landmarks.
const SHARES: [(&str, f64); 3] = [
    ("map_boxes_below_0_001_m3_share", 0.001),
    ("map_boxes_below_0_004_m3_share", 0.004),
    ("map_boxes_below_0_008_m3_share", 0.008),
];

/// Figures of the map that a drive which teaches leaves; empty for other drives, and where nothing was learnt. Where half of the boxes are unbounded,
/// their median is no figure.
pub(super) fn metrics(scene: &Scene, record: &RunRecord) -> BTreeMap<String, f64> {
    if !scene.localizer.teaches_map() || record.space_points.is_empty() {
        return BTreeMap::new();
    }
    let points: Vec<SpacePoint> = record.space_points.iter().map(|(_, point)| *point).collect();
    figures(&points)
        .into_iter()
        .filter(|(_, figure)| figure.is_finite())
        .map(|(name, one)| (name.to_owned(), one))
        .collect()
}

fn figures(points: &[SpacePoint]) -> BTreeMap<&'static str, f64> {
    let mut volumes_m3: Vec<f64> = points.iter().map(volume_m3).collect();
    volumes_m3.sort_by(f64::total_cmp);
    let n_points = points.len() as f64;
    let share = |(name, most_m3): (&'static str, f64)| {
        (name, volumes_m3.partition_point(|volume_m3| *volume_m3 < most_m3) as f64 / n_points)
    };
    // Of an even number the greater of the two in the middle: a box that there is.
    let median_m3 = volumes_m3[volumes_m3.len() / 2];
    SHARES.into_iter().map(share).chain([("map_landmarks", n_points), ("map_box_median_m3", median_m3)]).collect()
}

/// Volume of the hull of all places in the world that a landmark may have; infinite where its depth may be.
fn volume_m3(point: &SpacePoint) -> f64 {
    point.place_m().map_or(f64::INFINITY, |place_m| place_m.map(Interval::width).into_iter().product())
}

#[cfg(test)]
mod tests {
    use localizer::map::Anchor;

    use super::*;

    /// A landmark with depths of 2 to 2.5 m along x, and per metre of depth up to `slope` to either side along y, and 0.2 m along z.
    fn point(slope: f64) -> SpacePoint {
        let anchor = Anchor { from_m: [1.0, 2.0, 0.3], axis: 0, is_positive: true };
        SpacePoint { anchor, value: [Interval::centred(0.0, slope), Interval::point(0.2), Interval::new(0.4, 0.5)] }
    }

    #[test]
    fn the_boxes_of_a_map_are_as_large_as_by_hand() {
        // 0.5 m by 2 · 0.1 · 2.5 m by 0.2 · 0.5 m, and boxes with a tenth and a fiftieth of that slope.
        assert!((volume_m3(&point(0.1)) - 0.025).abs() < 1e-9);
        let far = SpacePoint { value: [Interval::ZERO, Interval::ZERO, Interval::new(0.0, 0.5)], ..point(0.1) };
        let all = figures(&[point(0.1), far, point(0.01), point(0.002)]);
        let shares = SHARES.map(|(name, _)| all[name]);
        assert_eq!((shares, all["map_landmarks"]), ([0.25, 0.5, 0.5], 4.0));
        assert!((all["map_box_median_m3"] - 0.025).abs() < 1e-9);
        assert_eq!(figures(&[far])["map_box_median_m3"], f64::INFINITY);
    }
}
