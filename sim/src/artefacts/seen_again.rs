//! What a drive tells of the landmarks of its map: which were seen again, and which are gone, as far as that is known.

use localizer::reading::LandmarkId;
use serde::Serialize;
use serde_json::Value;

use crate::{run::RunRecord, scene::Scene};

/// Landmarks that are nearer to each other than this on the floor plan are told as one place.
const NEAR_M: f64 = 0.6;
/// Width of a landmark's box, along any axis, from which on its place is not told.
const VAGUE_M: f64 = 1.0;
/// Greatest number of places that are told in words.
const MOST_PLACES: usize = 6;

/// What a drive tells of the landmarks of its map that should have been in view.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapSeen {
    /// Number of landmarks that were looked for.
    pub looked_for: usize,
    /// Number of them that were seen again.
    pub seen_again: usize,
    /// Those that are no longer where the map has them, as far as the drive tells.
    pub gone: Vec<Gone>,
}

/// A landmark that is no longer where the map has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gone {
    /// Its number on the map.
    pub number: u32,
    /// World x, y and z of the middle of its box on the map; `None` where the map knows its place only vaguely.
    pub at_m: Option<[f64; 3]>,
    /// Number of pictures in which it was found where the map has it.
    pub found: usize,
    /// Number of pictures in which it was found elsewhere.
    pub elsewhere: usize,
    /// Number of pictures in which it was missed.
    pub missed: usize,
}

impl MapSeen {
    /// What a run tells; `None` where no landmark of a map was looked for.
    pub(super) fn of(scene: &Scene, record: &RunRecord) -> Option<MapSeen> {
        let sought = &record.seen_again;
        let known = scene.localizer.mapped_landmarks().known;
        let at_m = |landmark: LandmarkId| {
            let (_, point) = *known.as_ref()?.landmarks.iter().find(|(number, _)| *number == landmark)?;
            let place_m = point.place_m().filter(|sides| sides.iter().all(|side| side.width() <= VAGUE_M))?;
            Some(place_m.map(|side| side.mid()))
        };
        let gone = sought.iter().filter(|one| one.is_gone()).map(|one| Gone {
            number: one.landmark.0,
            at_m: at_m(one.landmark),
            found: one.n_found,
            elsewhere: one.n_elsewhere,
            missed: one.n_missed,
        });
        (!sought.is_empty()).then(|| MapSeen {
            looked_for: sought.len(),
            seen_again: sought.iter().filter(|one| one.n_found > 0 && !one.is_gone()).count(),
            gone: gone.collect(),
        })
    }
}

/// What a summary tells of the landmarks of its map, in a sentence; `None` where it tells nothing.
pub fn in_words(summary: &Value) -> Option<String> {
    let seen = summary.get("map_seen").filter(|seen| !seen.is_null())?;
    let number = |key: &str| seen[key].as_u64().unwrap_or(0);
    let gone = seen["gone"].as_array().map_or(&[][..], Vec::as_slice);
    let counts = format!(
        "Of {} landmarks of the map that should have been in view, {} were seen again",
        number("looked_for"),
        number("seen_again")
    );
    if gone.is_empty() {
        return Some(format!("{counts}; none seems to have gone."));
    }
    let coordinate = |one: &Value, axis: usize| one["at_m"][axis].as_f64();
    let at: Vec<[f64; 2]> = gone.iter().filter_map(|one| Some([coordinate(one, 0)?, coordinate(one, 1)?])).collect();
    let places = places(&at);
    let around = |([x_m, y_m], n): &([f64; 2], usize)| format!("{n} around x {x_m:.1} m, y {y_m:.1} m");
    let mut told: Vec<String> = places.iter().take(MOST_PLACES).map(around).collect();
    let others: usize = places.iter().skip(MOST_PLACES).map(|(_, n)| n).sum();
    let vague = gone.len() - at.len();
    let rest = [(others, "at other places"), (vague, "where the map is vague")];
    told.extend(rest.iter().filter(|(n, _)| *n > 0).map(|(n, place)| format!("{n} {place}")));
    let seem = if gone.len() == 1 { "seems" } else { "seem" };
    Some(format!("{counts}; {} {seem} to have gone: {}.", gone.len(), told.join(", ")))
}

/// The middles of groups of points that are near to each other, with the number of points of each, the largest group first.
fn places(points: &[[f64; 2]]) -> Vec<([f64; 2], usize)> {
    let mut groups: Vec<Vec<[f64; 2]>> = Vec::new();
    for &point in points {
        let is_near = |group: &Vec<[f64; 2]>| {
            group.iter().any(|other| (other[0] - point[0]).hypot(other[1] - point[1]) <= NEAR_M)
        };
        let (near, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(is_near);
        groups = apart;
        groups.push(near.into_iter().flatten().chain([point]).collect());
    }
    let middle = |group: &Vec<[f64; 2]>| {
        [0, 1].map(|axis| group.iter().map(|point| point[axis]).sum::<f64>() / group.len() as f64)
    };
    let mut places: Vec<([f64; 2], usize)> = groups.iter().map(|group| (middle(group), group.len())).collect();
    places.sort_by(|a, b| b.1.cmp(&a.1).then(a.0[0].total_cmp(&b.0[0])));
    places
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn landmarks_near_each_other_are_one_place() {
        let places = places(&[[0.0, 0.0], [3.0, 1.0], [1.0, 0.0], [0.5, 0.0], [3.0, 1.5]]);
        assert_eq!(places, [([0.5, 0.0], 3), ([3.0, 1.25], 2)]);
    }

    #[test]
    fn what_has_gone_is_told_by_its_places() {
        let gone = |x: f64| json!({ "number": 1, "at_m": [x, 2.04, 0.5], "found": 0, "elsewhere": 0, "missed": 12 });
        let seen = |gone: Value| json!({ "map_seen": { "looked_for": 20, "seen_again": 15, "gone": gone } });
        let told = in_words(&seen(json!([gone(1.0), gone(1.2), gone(4.0)]))).unwrap();
        assert_eq!(
            told,
            "Of 20 landmarks of the map that should have been in view, 15 were seen again; 3 seem to have gone: 2 around x 1.1 m, y 2.0 m, \
             1 around x 4.0 m, y 2.0 m."
        );
        let vague = json!({ "number": 4, "at_m": null, "found": 0, "elsewhere": 0, "missed": 9 });
        assert!(
            in_words(&seen(json!([vague]))).unwrap().ends_with("; 1 seems to have gone: 1 where the map is vague.")
        );
        assert!(in_words(&seen(json!([]))).unwrap().ends_with("15 were seen again; none seems to have gone."));
        assert_eq!(in_words(&json!({})), None);
    }
}
