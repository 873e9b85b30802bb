//! The landmark codes that a range camera gives to the landmarks that it sees: now and then that of another landmark, as often as declared or more
//! often.

use std::collections::{BTreeMap, VecDeque};

use localizer::{
    bounds::{self, Assumption},
    reading::{LandmarkId, Sighting},
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::scene::RangeCamera;

/// Makes the range camera take a landmark for another one now and then, within the bounds that the scene declares.
pub(super) struct Confusion {
    camera: RangeCamera,
    n_landmarks: usize,
    rng: ChaCha8Rng,
    /// For each landmark code, whether its last uses named a wrong landmark; the newest use is at the back.
    uses: BTreeMap<u32, VecDeque<bool>>,
}

impl Confusion {
    pub(super) fn new(camera: &RangeCamera, n_landmarks: usize, rng: ChaCha8Rng) -> Self {
        Confusion { camera: camera.clone(), n_landmarks, rng, uses: BTreeMap::new() }
    }

    /// Gives each landmark that the range camera sees a code, mostly the landmark's own.
    pub(super) fn name(&mut self, seen: &[(u32, [f64; 2])]) -> Vec<Sighting> {
        let mut n_wrong = 0;
        let mut sightings = Vec::with_capacity(seen.len());
        for &(code, [left_px, right_px]) in seen {
            let wanted = self.camera.wrong_share > 0.0 && self.rng.random::<f64>() < self.camera.wrong_share;
            let other = if wanted && n_wrong < self.camera.wrong_items_max { self.other_than(code) } else { None };
            n_wrong += usize::from(other.is_some());
            let given = other.unwrap_or(code);
            self.note(given, other.is_some());
            sightings.push(Sighting { landmark: LandmarkId(given), left_px, right_px });
        }
        sightings
    }

    /// A code of another landmark that may be given to a wrong landmark again; `None` if there is none.
    fn other_than(&mut self, code: u32) -> Option<u32> {
        let was_wrong = |other: &u32| self.uses.get(other).is_some_and(|uses| uses.iter().any(|is_wrong| *is_wrong));
        let allowed: Vec<u32> =
            (0..self.n_landmarks as u32).filter(|other| *other != code && !was_wrong(other)).collect();
        (!allowed.is_empty()).then(|| allowed[self.rng.random_range(0..allowed.len())])
    }

    fn note(&mut self, code: u32, is_wrong: bool) {
        let uses = self.uses.entry(code).or_default();
        uses.push_back(is_wrong);
        while uses.len() > self.camera.wrong_spacing {
            uses.pop_front();
        }
    }
}

/// Declared bounds to which wrong landmark codes are cut in a counterfactual run, one that is simulated again with bounds kept to find what was to
/// blame. In a run as a seed draws it they are cut to none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CodeCuts {
    /// Whether the number of wrong codes in each reading is cut to the bound `range_landmarks.q_items`.
    pub items: bool,
    /// Whether codes are cut to the bound `range_landmarks.wrong_spacing`, the least number of right uses of a code between two wrong ones. As this
    /// bound applies from reading to reading, all wrong codes are left out, so that no two of them are too close together.
    pub spacing: bool,
}

impl CodeCuts {
    /// Takes landmark codes that are wrong beyond the bounds out of a range reading.
    pub(super) fn cut(self, sightings: &mut Vec<Sighting>, codes: &mut Vec<(LandmarkId, bool)>, q_items: usize) {
        let most = match (self.spacing, self.items) {
            (true, _) => 0,
            (false, true) => q_items,
            (false, false) => return,
        };
        let mut n_wrong = 0;
        let stays: Vec<bool> = codes
            .iter()
            .map(|(_, is_own)| {
                n_wrong += usize::from(!is_own);
                *is_own || n_wrong <= most
            })
            .collect();
        let mut keep = stays.iter();
        sightings.retain(|_| keep.next().copied().unwrap_or(true));
        let mut keep = stays.iter();
        codes.retain(|_| keep.next().copied().unwrap_or(true));
    }
}

/// Compares the landmark codes of each reading with the declared bounds on wrong codes. Readings come in the order in which they were taken.
pub(super) struct CodeBounds {
    q_items: usize,
    wrong_spacing: usize,
    /// Number of right uses of each landmark code since its last wrong use.
    right_since: BTreeMap<LandmarkId, usize>,
}

impl CodeBounds {
    pub(super) fn new(camera: &RangeCamera) -> Self {
        CodeBounds { q_items: camera.q_items, wrong_spacing: camera.wrong_spacing, right_since: BTreeMap::new() }
    }

    /// Checks of one more reading, each with its bound, the declared and the true value: the number of wrong codes, and by how many the right uses of
    /// a code between two wrong ones fall short of the declared number, which is compared with 0.
    pub(super) fn after(&mut self, codes: &[(LandmarkId, bool)]) -> Vec<(Assumption, f64, f64)> {
        let n_wrong = codes.iter().filter(|(_, is_own)| !is_own).count();
        let mut all = vec![(bounds::RANGE_LANDMARKS_Q_ITEMS, self.q_items as f64, n_wrong as f64)];
        let mut missing = 0;
        for (code, is_own) in codes {
            if *is_own {
                self.right_since.entry(*code).and_modify(|count| *count += 1);
            // Where the scene declares that no code is wrong, it declares nothing about how far apart wrong ones are.
            } else if let Some(count) = self.right_since.insert(*code, 0).filter(|_| self.q_items > 0) {
                missing = missing.max(self.wrong_spacing.saturating_sub(count));
            }
        }
        all.push((bounds::RANGE_LANDMARKS_WRONG_SPACING, 0.0, missing as f64));
        all
    }
}
