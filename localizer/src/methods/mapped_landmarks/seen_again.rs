//! Whether the landmarks of the map are still where the map has them, as far as a drive tells.
//!
//! A landmark that is found where it should be counts; so does one that is not found although it should be wholly in view. A single miss tells little:
//! somebody may stand before it, and the light may be poor. What has moved is missed each time, and is looked for elsewhere (`whereabouts`).

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
};

use crate::{map::SeenAgain, reading::LandmarkId};

/// Least number of landmarks found in a picture for the missing of others to count: where hardly anything is found, it is dark, or the camera is covered.
const FEWEST_FOUND: usize = 5;

/// What a drive tells of each landmark of the map that it has looked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Sought {
    counts: BTreeMap<LandmarkId, SeenAgain>,
    /// The directions from which each was missed.
    absent_from: BTreeMap<LandmarkId, Spread>,
}

/// Directions, by the least and the greatest difference from the first one.
#[derive(Clone, Debug)]
struct Spread {
    first_rad: f64,
    off_rad: [f64; 2],
}

impl Spread {
    fn at(first_rad: f64) -> Spread {
        Spread { first_rad, off_rad: [0.0; 2] }
    }

    /// Takes one more, and returns the angle over which all are spread.
    fn with(&mut self, direction_rad: f64) -> f64 {
        let off_rad = (direction_rad - self.first_rad + PI).rem_euclid(TAU) - PI;
        self.off_rad = [self.off_rad[0].min(off_rad), self.off_rad[1].max(off_rad)];
        self.off_rad[1] - self.off_rad[0]
    }
}

impl Sought {
    /// Counts the landmarks of one picture: those that were found where possible poses show them, those missed near where they were first seen from,
    /// and those missed from wherever, each with the direction from it to the robot as an angle from world x.
    pub(super) fn count(&mut self, found: &[LandmarkId], missed: &[LandmarkId], absent: &[(LandmarkId, f64)]) {
        found.iter().for_each(|&landmark| self.of(landmark).n_found += 1);
        if found.len() >= FEWEST_FOUND {
            missed.iter().for_each(|&landmark| self.of(landmark).n_missed += 1);
            for &(landmark, from_rad) in absent {
                let spread = self.absent_from.entry(landmark).or_insert_with(|| Spread::at(from_rad));
                let over_rad = spread.with(from_rad);
                let one = self.of(landmark);
                (one.n_absent, one.absent_over_rad) = (one.n_absent + 1, over_rad);
            }
        }
    }

    /// Counts landmarks of a picture that are on things which cannot be where the map has them.
    pub(super) fn count_displaced(&mut self, displaced: impl Iterator<Item = LandmarkId>) {
        displaced.for_each(|landmark| self.of(landmark).n_displaced += 1);
    }

    /// What is known so far of a landmark, apart from where it is now.
    pub(super) fn so_far(&self, landmark: LandmarkId) -> Option<SeenAgain> {
        self.counts.get(&landmark).copied()
    }

    /// All that were looked for, in the order of their numbers, with the places where some are now and the numbers of pictures that show them there.
    /// Those are left out that were only missed from where a wall may have hidden them.
    pub(super) fn all(&self, moved: &BTreeMap<LandmarkId, ([f64; 3], usize)>) -> Vec<SeenAgain> {
        let with_place = |one: &SeenAgain| {
            let moved = moved.get(&one.landmark);
            SeenAgain { now_m: moved.map(|(now_m, _)| *now_m), n_elsewhere: moved.map_or(0, |(_, n)| *n), ..*one }
        };
        let is_known = |one: &SeenAgain| one.n_found + one.n_displaced + one.n_elsewhere + one.n_missed > 0;
        self.counts.values().map(with_place).filter(is_known).collect()
    }

    fn of(&mut self, landmark: LandmarkId) -> &mut SeenAgain {
        self.counts.entry(landmark).or_insert(SeenAgain::of(landmark))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_landmark_is_gone_if_it_is_missed_each_time_or_found_elsewhere() {
        let mut sought = Sought::default();
        let numbers = |numbers: &[u32]| numbers.iter().copied().map(LandmarkId).collect::<Vec<_>>();
        // The robot drives around all of them but 11, which it always sees from one direction.
        let from = |picture: usize, numbers: &[u32]| -> Vec<(LandmarkId, f64)> {
            let angle_rad = |number| if number == 11 { 3.0 } else { 3.0 + 0.05 * picture as f64 };
            numbers.iter().map(|&number| (LandmarkId(number), angle_rad(number))).collect()
        };
        for picture in 0..12 {
            // Landmark 7 is hidden now and then, 8 is never seen, 9 hardly ever, and 10 is missed only from where a wall may hide it.
            let hidden = if picture % 3 == 0 { vec![7] } else { vec![] };
            let shown = if picture % 3 == 0 { vec![] } else { vec![7] };
            let at_times = if picture == 5 { vec![9] } else { vec![] };
            sought.count(
                &numbers(&[&[0, 1, 2, 3, 4, 5][..], &shown, &at_times].concat()),
                &numbers(&[&hidden[..], &[8, 11]].concat()),
                &from(picture, &[&hidden[..], &[8, 9, 10, 11]].concat()),
            );
        }
        let gone = |moved: &[(u32, usize)]| -> Vec<u32> {
            let moved = moved.iter().map(|&(landmark, n)| (LandmarkId(landmark), ([1.0, 2.0, 3.0], n))).collect();
            sought.all(&moved).iter().filter(|one| one.is_gone()).map(|one| one.landmark.0).collect()
        };
        assert_eq!(gone(&[]), [8]);
        // Found elsewhere more often than in their places are 9 and 10; 7 is not.
        assert_eq!(gone(&[(7, 8), (9, 2), (10, 3)]), [8, 9, 10]);
        assert_eq!(gone(&[(9, 1)]), [8]);
        let all = sought.all(&BTreeMap::new());
        let seven = all[6];
        assert!(all.iter().any(|one| one.landmark.0 == 11 && one.n_missed == 12 && !one.is_gone()));
        let over_rad = sought.so_far(LandmarkId(8)).map_or(0.0, |one| one.absent_over_rad);
        assert!((over_rad - 0.55).abs() < 1e-9, "{over_rad}");
        assert_eq!((seven.n_found, seven.n_elsewhere, seven.n_missed, seven.n_absent), (8, 0, 4, 4));
        assert!(all.iter().all(|one| one.landmark.0 != 10), "{all:?}");
        assert_eq!(sought.so_far(LandmarkId(10)).map(|one| one.n_absent), Some(12));
    }

    #[test]
    fn a_landmark_has_moved_a_little_once_enough_pictures_contradict_its_thing() {
        let mut sought = Sought::default();
        let [moved, other] = [LandmarkId(1), LandmarkId(2)];
        (0..3).for_each(|_| sought.count_displaced([moved, other].into_iter()));
        assert!(sought.all(&BTreeMap::new()).iter().all(|one| !one.is_displaced() && !one.is_gone()));
        sought.count_displaced([moved].into_iter());
        let told: Vec<bool> =
            sought.all(&BTreeMap::new()).iter().map(|one| one.is_displaced() && one.is_gone()).collect();
        assert_eq!(told, [true, false]);
    }

    #[test]
    fn what_is_missed_in_the_dark_does_not_count() {
        let mut sought = Sought::default();
        let [one, two] = [LandmarkId(1), LandmarkId(2)];
        (0..20).for_each(|_| sought.count(&[one], &[two], &[(two, 0.0)]));
        assert_eq!(sought.all(&BTreeMap::new()).len(), 1);
        assert!(!sought.all(&BTreeMap::new())[0].is_gone());
        assert!(sought.so_far(two).is_none());
    }
}
