//! What has changed in a room, in places that a person knows: landmarks that are no longer where the map has them, taken together where they are near
//! each other.

use serde::{Deserialize, Serialize};

/// Landmarks that are nearer to each other than this have changed together.
const NEAR_M: f64 = 0.6;
/// Greatest change of the distance between two landmarks that have moved together: new places are told to some decimetres.
const STRETCH_M: f64 = 0.4;

/// Least number of landmarks that have moved together for that to be told: a single one may look like something else.
const FEWEST_MOVED: usize = 2;

/// A landmark that is no longer where the map has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Changed {
    /// Its number on the map.
    pub(crate) number: u32,
    /// World x, y and z of the middle of its box on the map.
    pub(crate) at_m: [f64; 3],
    /// Where it was found instead.
    pub(crate) now_m: Option<[f64; 3]>,
    /// Whether it is still seen, so near to its old place that no other is known.
    pub(crate) is_beside: bool,
}

/// Neighbouring landmarks that are no longer where the map has them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Change {
    /// Their numbers on the map.
    pub landmarks: Vec<u32>,
    /// World x, y and z of the middle of their places on the map; if some were found elsewhere, of the places of these.
    pub from_m: [f64; 3],
    /// The middle of the places where some of them were found instead; left out where none was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_m: Option<[f64; 3]>,
    /// Distance between both places.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moved_m: Option<f64>,
    /// Number of those that were found there.
    pub n_moved: usize,
    /// Whether they are still seen, a little beside their places on the map.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub beside: bool,
}

/// The changes that some landmarks tell of, those of the most landmarks first. Landmarks have moved together if they are neighbours in both places. One
/// that has moved alone counts as not found again. Those that were not found again belong to what has moved from beside them, or else to each other.
pub(crate) fn changes(changed: &[Changed]) -> Vec<Change> {
    let (moved, mut missing): (Vec<Changed>, Vec<Changed>) = changed.iter().partition(|one| one.now_m.is_some());
    let together = |one: &Changed, other: &Changed| {
        let before_m = distance_m(one.at_m, other.at_m);
        let now_m = one.now_m.zip(other.now_m).map(|(one, other)| distance_m(one, other));
        before_m <= NEAR_M && now_m.is_some_and(|now_m| (now_m - before_m).abs() <= STRETCH_M)
    };
    let near = |one: &Changed, other: &Changed| distance_m(one.at_m, other.at_m) <= NEAR_M;
    let (mut groups, lone): (Vec<Vec<Changed>>, Vec<Vec<Changed>>) =
        grouped(&moved, together).into_iter().partition(|group| group.len() >= FEWEST_MOVED);
    missing.extend(lone.into_iter().flatten().map(|one| Changed { now_m: None, ..one }));
    let mut apart = Vec::new();
    for one in missing {
        match groups.iter_mut().find(|group| group.iter().any(|other| other.now_m.is_some() && near(&one, other))) {
            Some(group) => group.push(one),
            None => apart.push(one),
        }
    }
    groups.extend(grouped(&apart, |one, other| one.is_beside == other.is_beside && near(one, other)));
    let mut changes: Vec<Change> = groups.iter().map(|group| Change::of(group)).collect();
    changes.sort_by(|a, b| b.landmarks.len().cmp(&a.landmarks.len()).then(a.landmarks.cmp(&b.landmarks)));
    changes
}

impl Change {
    fn of(group: &[Changed]) -> Change {
        let moved: Vec<([f64; 3], [f64; 3])> = group.iter().filter_map(|one| Some((one.at_m, one.now_m?))).collect();
        let (before_m, now_m): (Vec<[f64; 3]>, Vec<[f64; 3]>) = moved.into_iter().unzip();
        let all_m: Vec<[f64; 3]> = group.iter().map(|one| one.at_m).collect();
        let from_m = middle(if now_m.is_empty() { &all_m } else { &before_m });
        let to_m = (!now_m.is_empty()).then(|| middle(&now_m));
        let mut landmarks: Vec<u32> = group.iter().map(|one| one.number).collect();
        landmarks.sort_unstable();
        let moved_m = to_m.map(|to_m| distance_m(from_m, to_m));
        let beside = now_m.is_empty() && group.iter().all(|one| one.is_beside);
        Change { landmarks, from_m, to_m, moved_m, n_moved: now_m.len(), beside }
    }

    /// The change in words, with its number of landmarks.
    pub(crate) fn in_words(&self) -> String {
        let n = self.landmarks.len();
        let seem = if n == 1 { "seems" } else { "seem" };
        let from = around(self.from_m);
        match (self.to_m, self.moved_m) {
            (Some(to_m), Some(moved_m)) => {
                let told =
                    if self.n_moved == n { String::new() } else { format!(", where {} were found", self.n_moved) };
                format!(
                    "{n} {seem} to have moved from around {from} by {moved_m:.1} m to around {}{told}",
                    around(to_m)
                )
            }
            _ if self.beside => format!("{n} {seem} to have moved a little, around {from}"),
            _ => format!("{n} {seem} to have gone from around {from}"),
        }
    }
}

/// A place in words. Zero has no sign.
fn around(place_m: [f64; 3]) -> String {
    let [x_m, y_m, z_m] = place_m.map(|at_m| (10.0 * at_m).round() / 10.0 + 0.0);
    format!("x {x_m:.1} m, y {y_m:.1} m, z {z_m:.1} m")
}

/// Groups of those that belong together, by chains of others.
fn grouped(all: &[Changed], together: impl Fn(&Changed, &Changed) -> bool) -> Vec<Vec<Changed>> {
    let mut groups: Vec<Vec<Changed>> = Vec::new();
    for &one in all {
        let (mut of_it, others): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group: &Vec<Changed>| group.iter().any(|other| together(&one, other)));
        of_it.push(vec![one]);
        groups = others;
        groups.push(of_it.concat());
    }
    groups
}

fn middle(places_m: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|axis| places_m.iter().map(|place| place[axis]).sum::<f64>() / places_m.len() as f64)
}

fn distance_m(one: [f64; 3], other: [f64; 3]) -> f64 {
    [0, 1, 2].map(|axis| one[axis] - other[axis]).into_iter().fold(0.0, f64::hypot)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(number: u32, at_m: [f64; 3], now_m: Option<[f64; 3]>) -> Changed {
        Changed { number, at_m, now_m, is_beside: false }
    }

    #[test]
    fn two_pictures_that_were_exchanged_are_two_changes_each_to_where_the_other_was() {
        // Two pictures side by side on a wall along x, each by 1.2 m to the place of the other; of the first, one landmark is not found.
        let found = [
            changed(1, [1.0, 4.2, 1.0], Some([2.2, 4.2, 1.1])),
            changed(2, [1.4, 4.2, 1.2], Some([2.6, 4.2, 1.3])),
            changed(3, [1.2, 4.2, 1.4], None),
            changed(4, [2.2, 4.2, 1.0], Some([1.0, 4.2, 1.0])),
            changed(5, [2.6, 4.2, 1.0], Some([1.4, 4.2, 1.0])),
            changed(6, [1.8, 4.2, 1.0], Some([0.6, 4.2, 1.0])),
        ];
        let told = changes(&found);
        let numbers: Vec<&[u32]> = told.iter().map(|change| &change.landmarks[..]).collect();
        assert_eq!(numbers, [&[1, 2, 3][..], &[4, 5, 6]]);
        assert_eq!(
            told[0].in_words(),
            "3 seem to have moved from around x 1.2 m, y 4.2 m, z 1.1 m by 1.2 m to around x 2.4 m, y 4.2 m, z 1.2 m, where 2 were found"
        );
        assert_eq!(
            told[1].in_words(),
            "3 seem to have moved from around x 2.2 m, y 4.2 m, z 1.0 m by 1.2 m to around x 1.0 m, y 4.2 m, z 1.0 m"
        );
        assert_eq!((told[0].n_moved, told[1].n_moved), (2, 3));
    }

    #[test]
    fn landmarks_near_each_other_that_were_not_found_again_are_one_change() {
        let gone = |number: u32, x_m: f64| changed(number, [x_m, -0.02, 0.5], None);
        let told = changes(&[gone(1, 0.0), gone(2, 3.0), gone(3, 1.0), gone(4, 0.5), gone(5, 3.4)]);
        let words: Vec<String> = told.iter().map(Change::in_words).collect();
        assert_eq!(
            words,
            [
                "3 seem to have gone from around x 0.5 m, y 0.0 m, z 0.5 m",
                "2 seem to have gone from around x 3.2 m, y 0.0 m, z 0.5 m"
            ]
        );
        assert_eq!(told[0].landmarks, [1, 3, 4]);
        assert!(changes(&[]).is_empty());
    }

    #[test]
    fn what_is_seen_beside_its_place_is_told_apart_from_what_has_gone() {
        let beside = |number: u32, x_m: f64| Changed { is_beside: true, ..changed(number, [x_m, 0.0, 1.0], None) };
        let told = changes(&[beside(1, 2.0), beside(2, 2.4), changed(3, [2.2, 0.0, 1.0], None)]);
        assert_eq!(told[0].in_words(), "2 seem to have moved a little, around x 2.2 m, y 0.0 m, z 1.0 m");
        assert_eq!(told[1].in_words(), "1 seems to have gone from around x 2.2 m, y 0.0 m, z 1.0 m");
        // Beside others that were found elsewhere, it has moved with them.
        let far = |number: u32, x_m: f64| changed(number, [x_m, 0.0, 1.0], Some([x_m, 3.0, 1.0]));
        let told = changes(&[far(1, 2.0), far(2, 2.2), beside(3, 2.4)]);
        assert_eq!((told.len(), told[0].landmarks.len(), told[0].beside), (1, 3, false));
    }

    #[test]
    fn neighbours_that_were_found_far_from_each_other_have_gone_and_not_moved_together() {
        let told = changes(&[
            changed(1, [1.0, 0.0, 1.0], Some([3.0, 0.0, 1.0])),
            changed(2, [1.3, 0.0, 1.0], Some([1.3, 3.0, 1.0])),
        ]);
        assert_eq!(told.len(), 1);
        assert_eq!((&told[0].landmarks[..], told[0].to_m, told[0].n_moved), (&[1, 2][..], None, 0));
    }
}
