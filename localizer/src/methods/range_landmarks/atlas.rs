//! Atlas of the landmarks learnt: boxes in the world that only ever shrink.

use std::collections::BTreeMap;

use interval::contractor::{Outcome, q_intersection};
use interval::{Interval, IntervalBox};

use crate::reading::LandmarkId;

/// Places of all landmarks, as learnt from readings.
#[derive(Clone, Debug)]
pub(super) struct Atlas {
    entries: BTreeMap<LandmarkId, Entry>,
    /// Number of consecutive sightings with one landmark's code of which at most one is wrong; `None` when none is ever wrong.
    window: Option<usize>,
}

#[derive(Clone, Debug, Default)]
struct Entry {
    /// Box of the landmark's world x and y; `None` before enough has been seen.
    place: Option<[Interval; 2]>,
    /// Places at which the sightings with the landmark's code put it, since the last full window; no sighting in between is left out.
    waiting: Vec<[Interval; 2]>,
}

impl Atlas {
    /// Makes an atlas in which no landmark is known. With `q_items` wrong matches in a reading, at least `wrong_spacing` right sightings
    /// with a landmark's code lie between two wrong ones.
    pub(super) fn new(q_items: usize, wrong_spacing: usize) -> Self {
        Atlas { entries: BTreeMap::new(), window: (q_items > 0).then_some(wrong_spacing + 1) }
    }

    /// Box of a landmark's place, if it is known.
    pub(super) fn place(&self, landmark: LandmarkId) -> Option<[Interval; 2]> {
        self.entries.get(&landmark)?.place
    }

    /// All landmarks whose place is known, in the order of their codes.
    pub(super) fn places(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        self.entries.iter().filter_map(|(landmark, entry)| Some((*landmark, entry.place?))).collect()
    }

    /// Learns from the places at which landmarks were seen in one reading.
    ///
    /// Of a whole window of sightings with a landmark's code at most one is wrong, so the landmark is at a place that all but one of them
    /// allow. A sighting that says nothing counts all the same: its place is then unbounded. Where no place is left for a landmark, nothing
    /// of the reading is learnt.
    pub(super) fn learn(&mut self, seen_at: &[(LandmarkId, [Interval; 2])]) -> Outcome {
        let mut learnt: BTreeMap<LandmarkId, Entry> = BTreeMap::new();
        for (landmark, place) in seen_at {
            let known = || self.entries.get(landmark).cloned().unwrap_or_default();
            let outcome = learnt.entry(*landmark).or_insert_with(known).learn(*place, self.window);
            if outcome != Outcome::Feasible {
                return outcome;
            }
        }
        self.entries.extend(learnt);
        Outcome::Feasible
    }

    /// Drops the sightings that wait for a full window: a reading was not learnt from, so that they are no longer consecutive.
    pub(super) fn interrupt(&mut self) {
        self.entries.values_mut().for_each(|entry| entry.waiting.clear());
    }

    /// Narrows the box of a known landmark to its intersection with `place`.
    pub(super) fn narrow(&mut self, landmark: LandmarkId, place: [Interval; 2]) -> Outcome {
        self.entries.get_mut(&landmark).map_or(Outcome::Feasible, |entry| entry.narrow(place))
    }
}

/// Cause reported when a landmark's places contradict each other: an assumption failed, perhaps long ago.
const CAUSE: &str = "a landmark is not where it was learnt to be";

impl Entry {
    fn learn(&mut self, seen_at: [Interval; 2], window: Option<usize>) -> Outcome {
        let Some(window) = window else { return self.narrow(seen_at) };
        self.waiting.push(seen_at);
        if self.waiting.len() < window {
            return Outcome::Feasible;
        }
        let uses: Vec<IntervalBox<2>> = self.waiting.drain(..).map(IntervalBox::new).collect();
        self.narrow(q_intersection(&uses, 1).components())
    }

    fn narrow(&mut self, seen_at: [Interval; 2]) -> Outcome {
        let narrower = match self.place {
            Some(place) => [place[0].intersect(seen_at[0]), place[1].intersect(seen_at[1])],
            None => seen_at,
        };
        if narrower.iter().any(|axis| axis.is_empty()) {
            return Outcome::Empty(CAUSE);
        }
        if narrower.iter().all(|axis| axis.is_bounded()) {
            self.place = Some(narrower);
        }
        Outcome::Feasible
    }
}
