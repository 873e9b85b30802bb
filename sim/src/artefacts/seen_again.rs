//! What a drive tells of the landmarks of its map: which were seen again, and which are gone, as far as that is known.

use std::collections::BTreeSet;

use localizer::reading::LandmarkId;
use serde::Serialize;
use serde_json::Value;

use crate::{run::RunRecord, scene::Scene};

use super::map_changes::{Change, Changed, changes};

/// Width of a landmark's box, along any axis, from which on nothing is told of it: what is known so vaguely is seldom a point of a surface, and is
/// then not seen again from other places.
const VAGUE_M: f64 = 1.0;
/// Least number of landmarks of a change that is told in words: a few are easily hidden.
const FEWEST_TOLD: usize = 2;
/// Least number of landmarks that were looked for with which few that were seen again tell that the map may be of another place.
const MANY: u64 = 20;
/// Greatest number of changes that are told in words.
const MOST_TOLD: usize = 6;

/// What a drive tells of the landmarks of its map that should have been in view.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapSeen {
    /// Number of landmarks that were looked for.
    pub looked_for: usize,
    /// Number of them that were seen again.
    pub seen_again: usize,
    /// Those that are no longer where the map has them, as far as the drive tells. None of whose place the map knows little is among them.
    pub gone: Vec<Gone>,
    /// The same, neighbours taken together.
    pub changes: Vec<Change>,
}

/// A landmark that is no longer where the map has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gone {
    /// Its number on the map.
    pub number: u32,
    /// World x, y and z of the middle of its box on the map.
    pub at_m: [f64; 3],
    /// World x, y and z of the place where it was found instead; `None` if none is known.
    pub now_m: Option<[f64; 3]>,
    /// Number of pictures in which it was found where the map has it.
    pub found: usize,
    /// Number of pictures in which it was found at that other place.
    pub elsewhere: usize,
    /// Number of pictures that contradict the place of the thing that it is on, although it is seen near it.
    pub displaced: usize,
    /// Number of pictures in which it was missed near the place from which it was first seen.
    pub missed: usize,
    /// Number of pictures in which it was missed from wherever.
    pub absent: usize,
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
        let gone = sought.iter().filter(|one| one.is_gone()).filter_map(|one| {
            Some(Gone {
                number: one.landmark.0,
                at_m: at_m(one.landmark)?,
                now_m: one.now_m,
                found: one.n_found,
                elsewhere: one.n_elsewhere,
                displaced: one.n_displaced,
                missed: one.n_missed,
                absent: one.n_absent,
            })
        });
        let gone: Vec<Gone> = gone.collect();
        let beside: BTreeSet<u32> = sought.iter().filter(|one| one.is_displaced()).map(|one| one.landmark.0).collect();
        let changed = |one: &Gone| Changed {
            number: one.number,
            at_m: one.at_m,
            now_m: one.now_m,
            is_beside: beside.contains(&one.number),
        };
        (!sought.is_empty()).then(|| MapSeen {
            looked_for: sought.len(),
            seen_again: sought.iter().filter(|one| one.n_found > 0 && !one.is_gone()).count(),
            changes: changes(&gone.iter().map(changed).collect::<Vec<Changed>>()),
            gone,
        })
    }
}

/// What a summary tells of the landmarks of its map, in a sentence; `None` where it tells nothing.
pub fn in_words(summary: &Value) -> Option<String> {
    let seen = summary.get("map_seen").filter(|seen| !seen.is_null())?;
    let number = |key: &str| seen[key].as_u64().unwrap_or(0);
    let changes: Vec<Change> = serde_json::from_value(seen["changes"].clone()).unwrap_or_default();
    let counts = format!(
        "Of {} landmarks of the map that should have been in view, {} were seen again",
        number("looked_for"),
        number("seen_again")
    );
    // By a map of another place, a few are found all the same: much looks alike.
    let is_elsewhere = number("looked_for") >= MANY && 2 * number("seen_again") < number("looked_for");
    let counts = if is_elsewhere { format!("{counts}, which are few (is it a map of this place?)") } else { counts };
    if changes.is_empty() {
        let width_m = ["x_m", "y_m"].map(|axis| summary["width"][axis]["mean"].as_f64().unwrap_or(f64::NAN));
        let width_m = width_m[0].max(width_m[1]);
        let known = if width_m.is_finite() {
            format!(" by more than {width_m:.2} m, as poses were known")
        } else {
            String::new()
        };
        return Some(format!("{counts}; none seems to have gone or moved{known}."));
    }
    let is_told = |change: &&Change| change.landmarks.len() >= FEWEST_TOLD;
    let told: Vec<&Change> = changes.iter().filter(is_told).take(MOST_TOLD).collect();
    let mut parts: Vec<String> = told.iter().map(|change| change.in_words()).collect();
    let others: usize = changes.iter().skip(told.len()).map(|change| change.landmarks.len()).sum();
    let (seem, s) = if others == 1 { ("seems", "") } else { ("seem", "s") };
    // Where nothing was told before, these are no others.
    let who = if told.is_empty() { format!("{others}") } else { format!("{others} other{s}") };
    parts.extend((others > 0).then(|| format!("{who} {seem} to have gone or moved, here and there")));
    Some(format!("{counts}; {}.", parts.join("; ")))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_has_gone_and_moved_is_told_by_its_places() {
        let change =
            |landmarks: &[u32], x_m: f64| json!({ "landmarks": landmarks, "from_m": [x_m, 2.04, 0.5], "n_moved": 0 });
        let moved = json!({ "landmarks": [4, 6], "from_m": [1.0, 0.0, 1.0], "to_m": [3.0, 0.0, 1.0], "moved_m": 2.0, "n_moved": 2 });
        let seen = |changes: Value| json!({ "map_seen": { "looked_for": 20, "seen_again": 15, "changes": changes } });
        let told = in_words(&seen(json!([change(&[1, 2, 3], 1.1), moved, change(&[9], 4.0)]))).unwrap();
        assert_eq!(
            told,
            "Of 20 landmarks of the map that should have been in view, 15 were seen again; 3 seem to have gone from around x 1.1 m, y 2.0 m, z 0.5 m; \
             2 seem to have moved from around x 1.0 m, y 0.0 m, z 1.0 m by 2.0 m to around x 3.0 m, y 0.0 m, z 1.0 m; 1 other seems to have gone or \
             moved, here and there."
        );
        // More than six are not told one by one.
        let many: Vec<Value> = (0..8).map(|at| change(&[2 * at, 2 * at + 1], f64::from(at))).collect();
        let told = in_words(&seen(json!(many))).unwrap();
        assert!(told.contains("x 5.0 m") && !told.contains("x 6.0 m") && told.contains("; 4 others seem to"), "{told}");
        let told = in_words(&seen(json!([change(&[9], 4.0)]))).unwrap();
        assert!(told.ends_with("15 were seen again; 1 seems to have gone or moved, here and there."), "{told}");
        assert!(in_words(&seen(json!([]))).unwrap().ends_with("15 were seen again; none seems to have gone or moved."));
        assert_eq!(in_words(&json!({})), None);
        let mut narrow = seen(json!([]));
        narrow["width"] = json!({ "x_m": { "mean": 0.114 }, "y_m": { "mean": 0.128 } });
        let told = in_words(&narrow).unwrap();
        assert!(told.ends_with("none seems to have gone or moved by more than 0.13 m, as poses were known."), "{told}");
        let few = json!({ "map_seen": { "looked_for": 136, "seen_again": 36, "changes": [] } });
        assert_eq!(
            in_words(&few).unwrap(),
            "Of 136 landmarks of the map that should have been in view, 36 were seen again, which are few (is it a map of this place?); none seems to \
             have gone or moved."
        );
    }
}
