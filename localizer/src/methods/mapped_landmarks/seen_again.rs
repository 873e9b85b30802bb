//! Whether the landmarks of the map are still where the map has them, as far as a drive tells.
//!
//! A landmark that is found where it should be, and one that is found where no possible pose shows it, both count; so does one that is not found although
//! it should be wholly in view. A single miss tells little: somebody may stand before it, and the light may be poor. What has moved is missed each time.

use std::collections::BTreeMap;

use crate::{map::SeenAgain, reading::LandmarkId};

/// Least number of landmarks found in a picture for the missing of others to count: where hardly anything is found, it is dark, or the camera is covered.
const FEWEST_FOUND: usize = 5;

/// What a drive tells of each landmark of the map that it has looked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Sought {
    counts: BTreeMap<LandmarkId, SeenAgain>,
}

impl Sought {
    /// Counts the landmarks of one picture: those that were found where possible poses show them, those found elsewhere, and those missed.
    pub(super) fn count(&mut self, found: &[LandmarkId], elsewhere: &[LandmarkId], missed: &[LandmarkId]) {
        found.iter().for_each(|&landmark| self.of(landmark).n_found += 1);
        elsewhere.iter().for_each(|&landmark| self.of(landmark).n_elsewhere += 1);
        if found.len() >= FEWEST_FOUND {
            missed.iter().for_each(|&landmark| self.of(landmark).n_missed += 1);
        }
    }

    /// All that were looked for, in the order of their numbers.
    pub(super) fn all(&self) -> Vec<SeenAgain> {
        self.counts.values().copied().collect()
    }

    fn of(&mut self, landmark: LandmarkId) -> &mut SeenAgain {
        self.counts.entry(landmark).or_insert(SeenAgain { landmark, n_found: 0, n_elsewhere: 0, n_missed: 0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_landmark_is_gone_if_it_is_missed_each_time_or_found_elsewhere() {
        let mut sought = Sought::default();
        let seen: Vec<LandmarkId> = (0..6).map(LandmarkId).collect();
        for picture in 0..12 {
            // Landmark 7 is hidden now and then, 8 never seen, and 9 found elsewhere.
            let (found, missed) = if picture % 3 == 0 { (&seen[..], vec![7, 8]) } else { (&seen[..], vec![8]) };
            let hidden = [LandmarkId(7)];
            let found: Vec<LandmarkId> =
                found.iter().chain(hidden.iter().filter(|_| picture % 3 != 0)).copied().collect();
            let missed: Vec<LandmarkId> = missed.into_iter().map(LandmarkId).collect();
            sought.count(&found, &[LandmarkId(9)], &missed);
        }
        let gone: Vec<u32> = sought.all().iter().filter(|one| one.is_gone()).map(|one| one.landmark.0).collect();
        assert_eq!(gone, [8, 9]);
        let seven = sought.all()[6];
        assert_eq!((seven.n_found, seven.n_elsewhere, seven.n_missed), (8, 0, 4));
    }

    #[test]
    fn what_is_missed_in_the_dark_does_not_count() {
        let mut sought = Sought::default();
        (0..20).for_each(|_| sought.count(&[LandmarkId(1)], &[], &[LandmarkId(2)]));
        assert_eq!(sought.all().len(), 1);
        assert!(!sought.all()[0].is_gone());
    }
}
