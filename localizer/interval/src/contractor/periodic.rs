//! Contractor for a coordinate on one of equally spaced lines, such as the joints between tiles, or quarter turns.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// The constraint x = offset + k · period for any integer k.
///
/// **Constraint.** x ∈ offset + k · period for some integer k, with offset and period in intervals, and period > 0.
///
/// **Sound.** The indices k are enclosed by an outward-rounded division, so that no line x = offset + k · period that meets the domain is missed.
///
/// **Optimal.** The branches (one interval for each line in the domain) are exact up to rounding, and the contraction is their hull. It is found by
/// searching for the outermost branches from both ends, which loses nothing.
///
/// **Source.** Solving for k gives k ∈ (x − offset) / period, where each variable occurs once, so that the enclosure of k is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// Distance between neighbouring lines; positive.
    pub period: Interval,
    /// Interval of the position of the line with the index 0, from which the lines are counted.
    pub offset: Interval,
}

impl Periodic {
    /// Greatest number of branches (one interval for each line in the domain) that are returned. A longer list is of no use to a caller, so the
    /// domain is returned as one box instead.
    pub const MOST_BRANCHES: i64 = 4096;

    /// Indices k of the first and the last line x = offset + k · period that may meet the interval `x`; `None` when there are too many lines to
    /// count.
    pub fn indices(&self, x: Interval) -> Option<(i64, i64)> {
        let quotient = (x - self.offset) / self.period;
        let (first, last) = (quotient.lo().ceil(), quotient.hi().floor());
        let is_countable = self.period.lo() > 0.0 && first.abs() < 1e15 && last.abs() < 1e15;
        is_countable.then_some((first as i64, last as i64))
    }

    /// Interval of the position offset + k · period of the line with the index k = `index`.
    pub fn line(&self, index: i64) -> Interval {
        self.offset + self.period * index as f64
    }
}

impl Contractor<1> for Periodic {
    fn contract(&self, domain: &mut IntervalBox<1>) -> Outcome {
        let Some((first, last)) = self.indices(domain[0]) else {
            let unchanged = *domain;
            return settle(domain, unchanged, "the domain is empty");
        };
        let part = |index: i64| self.line(index).intersect(domain[0]);
        let lowest = (first..=last).take(3).map(part).find(|part| !part.is_empty());
        let highest = (first..=last).rev().take(3).map(part).find(|part| !part.is_empty());
        let left = match (lowest, highest) {
            (Some(lowest), Some(highest)) => lowest.hull(highest),
            // Because the quotient is rounded, the range of line indices contains at most one index too many at each end. So when there are at most
            // three indices and the search has found no line, no line meets the interval.
            _ if last - first < 3 => Interval::EMPTY,
            _ => domain[0],
        };
        settle(domain, IntervalBox::new([left]), "no line meets the interval")
    }

    fn branches(&self, domain: &IntervalBox<1>) -> Vec<IntervalBox<1>> {
        match self.indices(domain[0]) {
            Some((first, last)) if last - first < Self::MOST_BRANCHES => (first..=last)
                .map(|index| IntervalBox::new([self.line(index).intersect(domain[0])]))
                .filter(|branch| !branch.is_empty())
                .collect(),
            _ => vec![*domain],
        }
    }
}
