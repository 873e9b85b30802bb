//! A coordinate on one of equally spaced lines, such as the joints between tiles, or quarter turns.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// x = offset + k · period, k any integer.
///
/// **Constraint.** x ∈ offset + k · period for some integer k, with offset and period in intervals, period > 0.
///
/// **Sound.** The indices k are enclosed by an outward-rounded division, with every one of them tried.
///
/// **Optimal.** Branches are exact up to rounding; the contraction is their hull. Nothing is lost by walking from both ends.
///
/// **Source.** Solving for k: k ∈ (x − offset) / period, where each variable occurs once, so that the enclosure of k is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// Distance from line to line; positive.
    pub period: Interval,
    /// Where line 0 is.
    pub offset: Interval,
}

impl Periodic {
    /// A union of more branches than this is no help to anybody: it is answered as one box.
    pub const MOST_BRANCHES: i64 = 4096;

    /// The first and the last index of lines that may meet `x`; `None` when there are too many to count.
    pub fn indices(&self, x: Interval) -> Option<(i64, i64)> {
        let quotient = (x - self.offset) / self.period;
        let (first, last) = (quotient.lo().ceil(), quotient.hi().floor());
        let is_countable = self.period.lo() > 0.0 && first.abs() < 1e15 && last.abs() < 1e15;
        is_countable.then_some((first as i64, last as i64))
    }

    /// Where line `index` may be.
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
            // The quotient's rounding admits at most one index too many at each end.
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
