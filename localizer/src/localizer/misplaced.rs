//! Which markers may be misplaced after a contradiction: the smallest sets of markers without whose images nothing contradicts anything.

use crate::markers::MarkerId;

use super::{
    Localizer,
    hypothesis::{Hypothesis, Witness, named},
    ring::{Explanation, Slot},
};

/// Greatest number of markers that are taken to be misplaced together.
const MOST_MISPLACED: usize = 2;
/// Number of markers of which that is asked: those that were seen latest. All pairs of eight are 28, each of which means to contract the poses of up to
/// three seconds anew.
const MOST_ASKED: usize = 8;

impl Localizer {
    /// The smallest sets of markers without whose images nothing since the last doubt contradicts anything, each with the pose unions of all slots under
    /// the hypothesis that these markers are misplaced. The slots hold what was believed.
    pub(super) fn markers_that_explain(&mut self, ended_s: f64, contradicting_s: Option<f64>) -> Vec<Explanation> {
        let mut seen: Vec<MarkerId> = Vec::new();
        for slot in (0..self.ring.len()).rev().map(|at| &self.ring[at]) {
            for marker in slot.constraint.as_ref().map(named).unwrap_or_default() {
                if let Witness::Marker(marker) = marker
                    && !seen.contains(&marker)
                    && seen.len() < MOST_ASKED
                {
                    seen.push(marker);
                }
            }
        }
        let mut sets: Vec<Vec<MarkerId>> = vec![Vec::new()];
        for _ in 0..MOST_MISPLACED {
            let larger = |set: &Vec<MarkerId>| {
                let later = seen.iter().position(|marker| set.last() == Some(marker)).map_or(0, |last| last + 1);
                let larger = |&marker: &MarkerId| set.iter().copied().chain([marker]).collect();
                seen[later..].iter().map(larger).collect::<Vec<Vec<MarkerId>>>()
            };
            sets = sets.iter().flat_map(larger).collect();
            let explained: Vec<Explanation> =
                sets.iter().filter_map(|set| self.explained_without(set, ended_s, contradicting_s)).collect();
            if !explained.is_empty() {
                return explained;
            }
        }
        Vec::new()
    }

    /// The hypothesis that the given markers are misplaced, with the pose unions of all slots under it; `None` if something contradicts it.
    fn explained_without(
        &mut self,
        markers: &[MarkerId],
        from_s: f64,
        contradicting_s: Option<f64>,
    ) -> Option<Explanation> {
        // What was believed before the first image of one of these markers, and before the contradiction, stays as it is.
        let shows_one = |slot: &Slot| {
            let seen = slot.constraint.as_ref().map(named).unwrap_or_default();
            markers.iter().any(|marker| seen.contains(&Witness::Marker(*marker)))
        };
        let first = (0..self.ring.len()).map(|at| &self.ring[at]).find(|slot| shows_one(slot));
        let first_s = first.zip(contradicting_s).map_or(from_s, |(slot, at_s)| slot.stamp_s.min(at_s));
        self.explained_by(Hypothesis::of_markers(markers.to_vec()), from_s.max(first_s))
    }
}
