//! Which sightings are certainly of the landmark that their code names.
//!
//! A sighting that puts its landmark outside of the box in which the landmark surely is has a wrong code. At most `q_items` codes of a reading are
//! wrong, and at least `wrong_spacing` right uses of a code lie between two wrong ones. So a code that is certainly wrong makes others certainly right:
//! the uses of the same code just before and after it, and, once as many codes of a reading are wrong as may be, all other codes of that reading.
//!
//! What codes are right follows from the landmarks' boxes. Where those are taken back, it is taken back with them.

use std::{
    collections::{BTreeMap, VecDeque},
    sync::{
        Arc, Weak,
        atomic::{AtomicBool, Ordering},
    },
};

use crate::reading::LandmarkId;

/// Which sightings of one reading certainly have the right code, in the order of the sightings.
#[derive(Debug, Default)]
pub(super) struct RightCodes {
    right: Vec<AtomicBool>,
}

impl RightCodes {
    /// None known yet of a number of sightings, or all of them.
    pub(super) fn new(n_sightings: usize, all_are_right: bool) -> RightCodes {
        RightCodes { right: (0..n_sightings).map(|_| AtomicBool::new(all_are_right)).collect() }
    }

    /// Whether the code of the sighting with the given number is certainly right.
    pub(super) fn is_right(&self, sighting: usize) -> bool {
        self.right.get(sighting).is_some_and(|right| right.load(Ordering::Relaxed))
    }

    /// Sets whether the code of a sighting is certainly right. Returns whether that changed.
    fn set(&self, sighting: usize, is_right: bool) -> bool {
        self.right.get(sighting).is_some_and(|right| right.swap(is_right, Ordering::Relaxed) != is_right)
    }
}

/// The latest uses of each landmark's code, in the order of measurement.
#[derive(Debug)]
pub(super) struct CodeUses {
    q_items: usize,
    wrong_spacing: usize,
    uses: BTreeMap<LandmarkId, VecDeque<Use>>,
    /// The codes that were found to be right, in the order in which they were, as far as somebody still keeps their readings.
    found: Vec<Found>,
    n_found: usize,
}

/// A code that was found to be right.
#[derive(Debug)]
struct Found {
    /// Number of codes that were found before.
    number: usize,
    reading: Weak<RightCodes>,
    sighting: usize,
}

/// A sighting with a landmark's code.
#[derive(Debug)]
struct Use {
    reading: Arc<RightCodes>,
    sighting: usize,
    is_wrong: bool,
}

impl CodeUses {
    pub(super) fn new(q_items: usize, wrong_spacing: usize) -> CodeUses {
        CodeUses { q_items, wrong_spacing, uses: BTreeMap::new(), found: Vec::new(), n_found: 0 }
    }

    /// Takes in the codes of the next reading, each with whether it is certainly wrong, and notes which codes of this reading and of earlier ones are
    /// certainly right.
    pub(super) fn take_in(&mut self, codes: &[(LandmarkId, bool)], reading: &Arc<RightCodes>) {
        if self.q_items == 0 {
            return;
        }
        let n_wrong = codes.iter().filter(|(_, is_wrong)| *is_wrong).count();
        let mut right: Vec<(Arc<RightCodes>, usize)> = Vec::new();
        for (sighting, &(landmark, is_wrong)) in codes.iter().enumerate() {
            if n_wrong == self.q_items && !is_wrong {
                right.push((reading.clone(), sighting));
            }
            let uses = self.uses.entry(landmark).or_default();
            if is_wrong {
                right.extend(uses.iter().filter(|one| !one.is_wrong).map(|one| (one.reading.clone(), one.sighting)));
            } else if uses.iter().any(|one| one.is_wrong) {
                right.push((reading.clone(), sighting));
            }
            uses.push_back(Use { reading: reading.clone(), sighting, is_wrong });
            while uses.len() > self.wrong_spacing {
                uses.pop_front();
            }
        }
        self.found.retain(|one| one.reading.strong_count() > 0);
        for (reading, sighting) in right {
            if reading.set(sighting, true) {
                self.found.push(Found { number: self.n_found, reading: Arc::downgrade(&reading), sighting });
                self.n_found += 1;
            }
        }
    }

    /// Number of codes that have been found to be right.
    pub(super) fn n_found(&self) -> usize {
        self.n_found
    }

    /// Forgets which codes were found to be right after so many had been.
    pub(super) fn go_back(&mut self, n_found: usize) {
        let kept = self.found.partition_point(|one| one.number < n_found);
        for Found { reading, sighting, .. } in self.found.drain(kept..) {
            if let Some(reading) = reading.upgrade() {
                reading.set(sighting, false);
            }
        }
    }

    /// Forgets all uses, because a reading is missing from the sequence.
    pub(super) fn interrupt(&mut self) {
        self.uses.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(uses: &mut CodeUses, codes: &[(u32, bool)]) -> Arc<RightCodes> {
        let reading = Arc::new(RightCodes::new(codes.len(), false));
        let codes: Vec<(LandmarkId, bool)> = codes.iter().map(|&(code, wrong)| (LandmarkId(code), wrong)).collect();
        uses.take_in(&codes, &reading);
        reading
    }

    fn n_right(reading: &RightCodes) -> usize {
        (0..reading.right.len()).filter(|&sighting| reading.is_right(sighting)).count()
    }

    #[test]
    fn uses_of_a_code_around_a_wrong_one_are_right() {
        let mut uses = CodeUses::new(2, 3);
        let before: Vec<_> = (0..4).map(|_| read(&mut uses, &[(7, false), (8, false)])).collect();
        let wrong = read(&mut uses, &[(8, false), (7, true)]);
        let after: Vec<_> = (0..4).map(|_| read(&mut uses, &[(7, false)])).collect();
        // Three uses on either side, of code 7 alone; the fourth may be wrong again.
        assert_eq!(before.iter().map(|one| one.is_right(0)).collect::<Vec<_>>(), [false, true, true, true]);
        assert!(before.iter().all(|one| !one.is_right(1)) && n_right(&wrong) == 0);
        assert_eq!(after.iter().map(|one| one.is_right(0)).collect::<Vec<_>>(), [true, true, true, false]);
    }

    #[test]
    fn all_others_of_a_reading_are_right_once_as_many_are_wrong_as_may_be() {
        let mut uses = CodeUses::new(2, 3);
        let one_wrong = read(&mut uses, &[(1, true), (2, false), (3, false)]);
        let two_wrong = read(&mut uses, &[(4, true), (5, true), (6, false)]);
        assert_eq!((n_right(&one_wrong), n_right(&two_wrong)), (0, 1));
        assert!(two_wrong.is_right(2));
    }

    #[test]
    fn what_followed_from_boxes_that_are_taken_back_is_forgotten() {
        let mut uses = CodeUses::new(1, 3);
        let before = read(&mut uses, &[(7, false)]);
        read(&mut uses, &[(7, true)]);
        let n_found = uses.n_found();
        let late = read(&mut uses, &[(9, false), (7, false)]);
        let wrong = read(&mut uses, &[(9, true), (8, false)]);
        // A reading that nobody keeps is no more in the way than one that is kept.
        drop(read(&mut uses, &[(9, false)]));
        assert_eq!([n_right(&before), n_right(&late), n_right(&wrong)], [1, 2, 1]);
        uses.go_back(n_found);
        assert_eq!([n_right(&before), n_right(&late), n_right(&wrong)], [1, 0, 0]);
        uses.go_back(0);
        assert_eq!(n_right(&before), 0);
    }

    #[test]
    fn nothing_is_right_across_a_reading_that_is_missing() {
        let mut uses = CodeUses::new(1, 2);
        let before = read(&mut uses, &[(1, false)]);
        uses.interrupt();
        read(&mut uses, &[(1, true), (2, false)]);
        assert_eq!(n_right(&before), 0);
        // Where wrong uses may follow each other, one tells nothing of its neighbours.
        let mut uses = CodeUses::new(2, 0);
        let before = read(&mut uses, &[(1, false)]);
        read(&mut uses, &[(1, true), (2, false)]);
        assert_eq!(n_right(&before), 0);
    }
}
