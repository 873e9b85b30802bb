//! Wrong codes of the range camera: how many a reading may have, and how far apart those of one landmark are.

use std::collections::{BTreeMap, BTreeSet};

use interval::Interval;
use localizer::{bounds, reading::LandmarkId, robot::RangeCameraModel};

use super::super::kind::Broken;

/// Share of half a cell beyond which a column is nearly at the end of its cell: somewhat less than what the search leaves free there.
const NEARLY: f64 = 0.99;

/// Counts the wrong codes of readings that come in the order of measurement.
pub(super) struct Codes<'a> {
    model: &'a RangeCameraModel,
    time_s: f64,
    /// Number of the present reading's codes that may still be wrong.
    n_left: usize,
    /// Number of right uses of each code since its last wrong one.
    right_since: BTreeMap<LandmarkId, usize>,
}

impl<'a> Codes<'a> {
    pub(super) fn new(model: &'a RangeCameraModel) -> Self {
        Codes { model, time_s: 0.0, n_left: 0, right_since: BTreeMap::new() }
    }

    /// Begins the next reading.
    pub(super) fn begin(&mut self, time_s: f64) {
        (self.time_s, self.n_left) = (time_s, self.model.q_items);
    }

    /// Takes in the next code of the reading with whether it is right; errors if it is wrong and must not be.
    pub(super) fn take(&mut self, code: LandmarkId, is_right: Result<(), Broken>) -> Result<(), Broken> {
        let Err(broken) = is_right else {
            self.right_since.entry(code).and_modify(|count| *count += 1);
            return Ok(());
        };
        if self.model.q_items == 0 {
            return Err(broken);
        }
        let too_many = Broken { bound: bounds::RANGE_LANDMARKS_Q_ITEMS, ..broken };
        self.n_left = self.n_left.checked_sub(1).ok_or(too_many)?;
        let spacing = self.model.wrong_spacing;
        match self.right_since.insert(code, 0).filter(|count| *count < spacing) {
            None => Ok(()),
            Some(count) => Err(Broken {
                bound: bounds::RANGE_LANDMARKS_WRONG_SPACING,
                time_s: self.time_s,
                value: Interval::point(count as f64),
                allowed: Interval::new(spacing as f64, f64::INFINITY),
            }),
        }
    }
}

/// The codes, each given by its reading and its place there, that use most of their cells, as many as may be wrong; without those that are not nearly at
/// an end of their cell. Each code of a reading comes with the share of half a cell that it uses.
pub(super) fn most_used(
    readings: &[Vec<(LandmarkId, f64)>],
    q_items: usize,
    wrong_spacing: usize,
) -> BTreeSet<(usize, usize)> {
    // For each use of a code its number among the uses of this code, in the order of measurement.
    let mut n_uses: BTreeMap<LandmarkId, usize> = BTreeMap::new();
    let mut uses = Vec::new();
    for (reading, codes) in readings.iter().enumerate() {
        for (place, &(code, used)) in codes.iter().enumerate() {
            let number = n_uses.entry(code).or_default();
            uses.push((used, reading, place, code, *number));
            *number += 1;
        }
    }
    uses.retain(|(used, ..)| *used > NEARLY);
    uses.sort_by(|one, other| other.0.total_cmp(&one.0));
    let mut chosen = BTreeSet::new();
    let mut n_of_reading = vec![0; readings.len()];
    let mut numbers: BTreeMap<LandmarkId, Vec<usize>> = BTreeMap::new();
    for (_, reading, place, code, number) in uses {
        let others = numbers.entry(code).or_default();
        let is_apart = others.iter().all(|other| other.abs_diff(number) > wrong_spacing);
        if n_of_reading[reading] < q_items && is_apart {
            n_of_reading[reading] += 1;
            others.push(number);
            chosen.insert((reading, place));
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: of the first reading the two farthest out; code 1 not again before two other uses of it.
    #[test]
    fn the_codes_farthest_out_are_taken_for_wrong_as_many_and_as_far_apart_as_declared() {
        let read = |all: &[(u32, f64)]| all.iter().map(|&(code, used)| (LandmarkId(code), used)).collect::<Vec<_>>();
        let readings = [
            read(&[(1, 3.0), (2, 1.1), (3, 1.2), (4, 0.4)]),
            read(&[(1, 2.0), (4, 0.995)]),
            read(&[(1, 2.5), (2, 0.5)]),
            read(&[(1, 1.5), (3, 0.9)]),
        ];
        assert_eq!(most_used(&readings, 2, 2).into_iter().collect::<Vec<_>>(), [(0, 0), (0, 2), (1, 1), (3, 0)]);
    }
}
