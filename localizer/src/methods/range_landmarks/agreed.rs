//! Columns at which a reading certainly shows a landmark, although the code of a sighting may be wrong.
//!
//! At least `wrong_spacing` right uses of a landmark's code lie between two wrong ones, so that of `wrong_spacing + 1` consecutive uses at most one is
//! wrong. Each use but that one bounds the columns at which the latest reading shows the landmark, if it is carried to that reading by the robot's
//! motion since. The columns that all uses but one allow are the 1-relaxed intersection.
//!
//! **Carrying.** Let a landmark be seen X to the right and Z ahead of the camera, in columns u = f·X/Z and w = f·(X − b)/Z, and let the robot then move by
//! d and turn by φ, both in the robot frame before. With a the camera's place in the robot frame, ψ its yaw and δ = u − w, so that 1/Z = δ/(f·b),
//! the landmark is seen afterwards at
//!
//! Z′ = c·Z − s·X + t_ahead,   X′ = s·Z + c·X − t_left,   c = cos φ, s = sin φ,   t = R(−ψ)·((R(−φ) − 1)·a − R(−φ)·d) ± r,
//!
//! hence in columns u′ = (f·s + c·u − t_left·δ/b)/κ and w′ = (f·s + w + (c − 1)·u − t_left·δ/b)/κ, and with a disparity δ′ = δ/κ, where κ = Z′/Z =
//! c − s·u/f + t_ahead·δ/(f·b). The distance r is what the body's tilts and the stamps' errors make at both readings, and what the turn makes of the
//! tilt of the mount. The disparity is carried by itself: that of a landmark hardly depends on how the robot moved, while either column does.

use interval::{Interval, IntervalBox};

use crate::{
    graph::{Columns, Stray},
    method::Earlier,
    motion::Motion,
    reading::LandmarkId,
};

use super::{
    Shows,
    sight::{Sensor, length},
};

/// A sighting with a landmark's code.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    pub(super) landmark: LandmarkId,
    /// Number of the use among those of this code.
    pub(super) number: usize,
    pub(super) columns: Columns,
}

/// For each use of the latest reading, the columns at which that reading certainly shows the landmark, where several of the latest uses of its code
/// tell them. They stand at the last use of a code in the reading.
pub(super) fn agreed_columns(
    sensor: &Sensor,
    (stamp_s, stray): (f64, &Stray),
    uses: &[Use],
    earlier: &[Earlier],
) -> Vec<Option<Columns>> {
    let of_code = |latest: &Use| {
        let consecutive =
            |one: &&Use| one.landmark == latest.landmark && latest.number - one.number <= sensor.camera.wrong_spacing;
        let now = uses.iter().filter(|one| one.landmark == latest.landmark);
        if now.clone().any(|one| one.number > latest.number) {
            return None;
        }
        // A reading that came twice counts once.
        let each = earlier.chunk_by(|one, next| one.stamp_s == next.stamp_s).filter_map(<[Earlier]>::first);
        let before = each.filter(|one| one.stamp_s < stamp_s).filter_map(|one| Some((one, one.shown::<Shows>()?)));
        let carried = before.flat_map(|(reading, shows)| {
            let uses = shows.uses.iter().filter(consecutive);
            uses.filter_map(|one| carried(sensor, one.columns, &reading.moved, [&shows.stray, stray]))
        });
        let all: Vec<Columns> = now.filter(consecutive).map(|one| one.columns).chain(carried).collect();
        despite_one(&all)
    };
    uses.iter().map(of_code).collect()
}

/// The columns at which a reading shows a landmark that an earlier one showed in the given columns, before the robot moved. `None` where the disparity
/// may be 0, and where the landmark may be beside or behind the camera.
fn carried(sensor: &Sensor, columns: Columns, moved: &Motion, strays: [&Stray; 2]) -> Option<Columns> {
    let camera = &sensor.camera;
    let Columns { first_px: u, second_px: w, disparity_px: disparity } = columns;
    if disparity.lo() <= 0.0 {
        return None;
    }
    let (cosine, sine) = (moved[2].cos(), moved[2].sin());
    let cosine_rest = cosine - Interval::ONE;
    let [forward, left] = camera.position_m;
    let step = [
        cosine_rest * forward + sine * left - (cosine * moved[0] + sine * moved[1]),
        cosine_rest * left - sine * forward - (cosine * moved[1] - sine * moved[0]),
    ];
    let (cos_yaw, sin_yaw) = (camera.yaw_rad.cos(), camera.yaw_rad.sin());
    let blur_m = displaced_m(sensor, &columns, moved, strays)?;
    let ahead = (cos_yaw * step[0] + sin_yaw * step[1]).inflate(blur_m);
    let left = (cos_yaw * step[1] - sin_yaw * step[0]).inflate(blur_m);
    let nearer = cosine - sine * u / camera.focal_px + ahead * disparity / (camera.focal_px * camera.baseline_m);
    if nearer.lo() <= 0.0 {
        return None;
    }
    let across = camera.focal_px * sine - left * disparity / camera.baseline_m;
    Some(Columns {
        first_px: (across + cosine * u) / nearer,
        second_px: (across + w + cosine_rest * u) / nearer,
        disparity_px: disparity / nearer,
    })
}

/// Greatest distance by which the landmark may be displaced from where the robot's motion alone would carry it.
fn displaced_m(sensor: &Sensor, columns: &Columns, moved: &Motion, strays: [&Stray; 2]) -> Option<f64> {
    let before = sensor.in_view(columns, sensor.camera.yaw_rad)?;
    let turn_rad = moved[2].magnitude();
    let travel_m = length([moved[0], moved[1]]) + turn_rad * (length(before) + length(sensor.camera.position_m));
    let after = before.map(|side| side.inflate(travel_m));
    Some(
        sensor.sway_m(before, strays[0])? + sensor.sway_m(after, strays[1])? + turn_rad * sensor.mount_displacement_m(),
    )
}

/// The hull of what all but one of several columns allow; `None` for a single one, and where more than one must be wrong.
fn despite_one(all: &[Columns]) -> Option<Columns> {
    let boxes: Vec<IntervalBox<3>> =
        all.iter().map(|one| IntervalBox::from([one.first_px, one.second_px, one.disparity_px])).collect();
    let without = |wrong: usize| {
        let others = boxes.iter().enumerate().filter(|(at, _)| *at != wrong);
        others.fold(IntervalBox::from([Interval::ENTIRE; 3]), |common, (_, one)| common.intersect(one))
    };
    let hull = (0..boxes.len()).map(without).reduce(|hull, one| hull.hull(&one)).filter(|hull| !hull.is_empty())?;
    let [first_px, second_px, disparity_px] = [0, 1, 2].map(|side| hull[side]);
    disparity_px.is_bounded().then_some(Columns { first_px, second_px, disparity_px })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{
        PoseBox,
        graph::trial::{Draw, camera, reach, rounds},
        methods::range_landmarks::codes::RightCodes,
        robot::{BodyModel, RangeCameraModel},
    };

    fn sensor(draw: &mut Draw, wrong_spacing: usize) -> Sensor {
        let around = |middle: f64, half: f64, draw: &mut Draw| {
            let half = draw.or_zero(half);
            Interval::centred(middle + draw.within(Interval::centred(0.0, half)), half)
        };
        let camera = RangeCameraModel {
            focal_px: around(400.0, 2.0, draw),
            baseline_m: around(0.12, 0.001, draw),
            yaw_rad: around(draw.between(-0.5, 0.5), 0.01, draw),
            position_m: [around(0.1, 0.01, draw), around(0.06, 0.01, draw)],
            tilt_rad: draw.or_zero(0.01),
            wrong_spacing,
            ..camera()
        };
        let body = BodyModel { tilt_rad: draw.or_zero(0.01), heave_m: draw.or_zero(0.001), clearance_m: 0.1 };
        Sensor { camera, body, reach: reach() }
    }

    fn columns(first_px: [f64; 2], second_px: [f64; 2], disparity_px: [f64; 2]) -> Columns {
        let side = |[lo, hi]: [f64; 2]| Interval::new(lo, hi);
        Columns { first_px: side(first_px), second_px: side(second_px), disparity_px: side(disparity_px) }
    }

    #[test]
    fn a_landmark_is_carried_to_where_the_next_reading_shows_it() {
        let mut draw = Draw::new(20_261_129);
        let (mut n_carried, mut nearest) = (0, 0.0_f64);
        for round in 0..rounds(50_000) {
            let sensor = sensor(&mut draw, 4);
            let camera = &sensor.camera;
            let truly = |side: Interval, draw: &mut Draw| draw.within(side);
            let (focal_px, baseline_m) = (truly(camera.focal_px, &mut draw), truly(camera.baseline_m, &mut draw));
            let yaw_rad = truly(camera.yaw_rad, &mut draw);
            let place_m = camera.position_m.map(|side| truly(side, &mut draw));
            // Columns by a place in the robot frame, by the pinhole's formulas.
            let seen = |[x_m, y_m]: [f64; 2]| {
                let (x_m, y_m) = (x_m - place_m[0], y_m - place_m[1]);
                let ahead_m = x_m * yaw_rad.cos() + y_m * yaw_rad.sin();
                let right_m = x_m * yaw_rad.sin() - y_m * yaw_rad.cos();
                (ahead_m > 0.2).then(|| [focal_px * right_m / ahead_m, focal_px * (right_m - baseline_m) / ahead_m])
            };
            let wide = |[u, w]: [f64; 2], half: f64| {
                columns([u - half, u + half], [w - half, w + half], [u - w - 2.0 * half, u - w + 2.0 * half])
            };
            let (away_m, towards) = (draw.size(0.4, 5.0), yaw_rad + draw.between(-0.7, 0.7));
            let before_m = [place_m[0] + away_m * towards.cos(), place_m[1] + away_m * towards.sin()];
            let half_px = draw.or_zero(0.1);
            let Some(at_px) = seen(before_m) else { continue };
            let first = wide(at_px, half_px);
            let half = [0.01, 0.01, 0.005].map(|half| draw.or_zero(half));
            let middle = [draw.between(-0.2, 0.2), draw.between(-0.05, 0.05), draw.between(-0.3, 0.3)];
            let moved = PoseBox::from([0, 1, 2].map(|axis| Interval::centred(middle[axis], half[axis])));
            let [x_m, y_m, turn_rad] = [0, 1, 2].map(|axis| draw.within(moved[axis]));
            let strays = [0, 1].map(|_| Stray { metres: draw.or_zero(0.001), radians: draw.or_zero(0.002) });
            // Tilts and stamps displace what either reading shows by as much as they may.
            let in_view = sensor.in_view(&first, camera.yaw_rad).unwrap();
            let (Some(before_sway_m), Some(after_sway_m)) =
                (sensor.sway_m(in_view, &strays[0]), sensor.sway_m(in_view, &strays[1]))
            else {
                continue;
            };
            let to = |length_m: f64, draw: &mut Draw| {
                let angle = draw.between(0.0, std::f64::consts::TAU);
                [length_m * angle.cos(), length_m * angle.sin()]
            };
            let (sway, sway_after) = (to(before_sway_m, &mut draw), to(after_sway_m, &mut draw));
            let from = [before_m[0] + sway[0] - x_m, before_m[1] + sway[1] - y_m];
            let (sine, cosine) = turn_rad.sin_cos();
            let after_m =
                [cosine * from[0] + sine * from[1] + sway_after[0], cosine * from[1] - sine * from[0] + sway_after[1]];
            let Some([u, w]) = seen(after_m) else { continue };
            let Some(found) = carried(&sensor, first, &moved, [&strays[0], &strays[1]]) else { continue };
            n_carried += 1;
            for (side, at) in [(found.first_px, u), (found.second_px, w), (found.disparity_px, u - w)] {
                assert!(side.inflate(1e-9).contains(at), "round {round}: {at} not in {side}");
                if side.width() > 1e-3 {
                    nearest = nearest.max((at - side.mid()).abs() / side.radius());
                }
            }
        }
        // Most places are carried, and to bounds that the truth comes close to.
        assert!(n_carried > rounds(50_000) / 2 && nearest > 0.9, "{n_carried}, {nearest}");
    }

    #[test]
    fn any_one_of_several_columns_may_be_wrong() {
        let all = [[0.0, 1.0], [0.5, 1.5], [0.8, 2.0]].map(|side| columns(side, side, [20.0, 21.0]));
        // Without the first [0.8, 1.5] is left, without the second [0.8, 1], without the third [0.5, 1].
        assert_eq!(despite_one(&all), Some(columns([0.5, 1.5], [0.5, 1.5], [20.0, 21.0])));
        // One that contradicts two others is the wrong one, also by the disparity alone.
        let far = columns([0.0, 2.0], [0.0, 2.0], [30.0, 31.0]);
        assert_eq!(despite_one(&[all[0], far, all[1]]), Some(columns([0.5, 1.0], [0.5, 1.0], [20.0, 21.0])));
        // A single one may be wrong, and of two that contradict each other either.
        assert_eq!(despite_one(&all[..1]), None);
        assert_eq!(despite_one(&[all[0], far]), Some(columns([0.0, 2.0], [0.0, 2.0], [20.0, 31.0])));
        // Two pairs that contradict each other: more than one is wrong.
        assert_eq!(despite_one(&[all[0], all[1], far, far]), None);
    }

    #[test]
    fn only_uses_that_follow_each_other_closely_enough_tell_a_place() {
        let mut draw = Draw::new(20_261_130);
        let sensor = sensor(&mut draw, 2);
        let place = columns([10.0, 10.1], [-10.1, -10.0], [20.0, 20.2]);
        let one = |number| Use { landmark: LandmarkId(3), number, columns: place };
        let reading_at = |stamp_s: f64, uses: Vec<Use>| {
            let (codes, stray) = (Arc::new(RightCodes::default()), Stray::default());
            let shows = Shows { stamp_s, arrived_s: stamp_s, seen: Vec::new(), uses, stray, codes };
            Earlier::latest(stamp_s, Arc::new(shows))
        };
        let reading = |uses: Vec<Use>| reading_at(1.0, uses);
        let agreed =
            |uses: &[Use], earlier: &[Earlier]| agreed_columns(&sensor, (2.0, &Stray::default()), uses, earlier);
        // The third use before may be wrong as well as the latest.
        assert!(agreed(&[one(8)], &[reading(vec![one(6)])])[0].is_some());
        assert!(agreed(&[one(8)], &[reading(vec![one(5)])])[0].is_none());
        // Uses of another code tell nothing.
        let other = Use { landmark: LandmarkId(4), ..one(7) };
        assert!(agreed(&[one(8)], &[reading(vec![other])])[0].is_none());
        // Two uses in one reading are of one place, which stands at the last.
        let both = agreed(&[one(7), one(8)], &[reading(vec![one(6)])]);
        assert!(both[0].is_none() && both[1].is_some());
        // A reading that came twice tells no more than once.
        assert!(agreed(&[one(8)], &[reading_at(2.0, vec![one(7)])])[0].is_none());
        let far = |number| Use { columns: columns([30.0, 30.1], [10.0, 10.1], [20.0, 20.2]), ..one(number) };
        let twice = agreed(&[far(8)], &[reading(vec![one(6)]), reading(vec![one(7)])])[0].unwrap();
        assert!(twice.first_px.contains(30.0), "{twice:?}");
    }
}
