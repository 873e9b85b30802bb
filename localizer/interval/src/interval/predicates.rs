//! Comparisons of intervals as sets and as ordered ranges (the boolean functions and extended comparisons of IEEE 1788-2015).

use super::Interval;

/// How two intervals lie on the real line relative to each other: Allen's relations, extended to empty intervals (the overlap states of IEEE
/// 1788-2015).
///
/// The names take the point of view of the first interval: `a.overlap(b) == Before` when a ends before b starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are those of the standard and say it all")]
pub enum Overlap {
    BothEmpty,
    FirstEmpty,
    SecondEmpty,
    Before,
    Meets,
    Overlaps,
    Starts,
    ContainedBy,
    Finishes,
    Equals,
    FinishedBy,
    Contains,
    StartedBy,
    OverlappedBy,
    MetBy,
    After,
}

impl Interval {
    /// Whether the interval is the whole real line.
    #[inline]
    pub fn is_entire(self) -> bool {
        self == Interval::ENTIRE
    }

    /// Whether the interval has exactly one member.
    #[inline]
    pub fn is_singleton(self) -> bool {
        self.lo == self.hi
    }

    /// Whether the interval is bounded and not empty: what IEEE 1788 calls a common interval.
    #[inline]
    pub fn is_bounded(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Whether this interval is in the interior of `other`: every member has a neighbourhood inside `other`. An infinite bound counts as inside
    /// the same infinite bound.
    #[inline]
    pub fn is_interior_of(self, other: Interval) -> bool {
        self.is_empty()
            || (is_below(other.lo, self.lo, f64::NEG_INFINITY) && is_below(self.hi, other.hi, f64::INFINITY))
    }

    /// Whether the two intervals have no member in common.
    #[inline]
    pub fn is_disjoint_from(self, other: Interval) -> bool {
        !self.overlaps(other)
    }

    /// Whether each bound of this interval is at most that of `other`: every member has a member of `other` at or above it, and every member of
    /// `other` has a member of this interval at or below it.
    #[inline]
    pub fn is_less(self, other: Interval) -> bool {
        (self.is_empty() && other.is_empty()) || (self.lo <= other.lo && self.hi <= other.hi)
    }

    /// Whether each bound of this interval is less than that of `other`, as [`is_less`](Self::is_less) but strictly; equal infinite bounds count
    /// as less.
    #[inline]
    pub fn is_strictly_less(self, other: Interval) -> bool {
        (self.is_empty() && other.is_empty())
            || (is_below(self.lo, other.lo, f64::NEG_INFINITY) && is_below(self.hi, other.hi, f64::INFINITY))
    }

    /// Whether no member of this interval is above a member of `other`.
    #[inline]
    pub fn precedes(self, other: Interval) -> bool {
        self.is_empty() || other.is_empty() || self.hi <= other.lo
    }

    /// Whether every member of this interval is below every member of `other`.
    #[inline]
    pub fn strictly_precedes(self, other: Interval) -> bool {
        self.is_empty() || other.is_empty() || self.hi < other.lo
    }

    /// How this interval and `other` lie on the real line relative to each other.
    pub fn overlap(self, other: Interval) -> Overlap {
        use std::cmp::Ordering::{Equal, Greater, Less};
        match (self.is_empty(), other.is_empty()) {
            (true, true) => return Overlap::BothEmpty,
            (true, false) => return Overlap::FirstEmpty,
            (false, true) => return Overlap::SecondEmpty,
            (false, false) => {}
        }
        if self.hi < other.lo {
            return Overlap::Before;
        }
        if other.hi < self.lo {
            return Overlap::After;
        }
        match (order(self.lo, other.lo), order(self.hi, other.hi)) {
            (Equal, Equal) => Overlap::Equals,
            (Less, Less) if self.hi == other.lo => Overlap::Meets,
            (Less, Less) => Overlap::Overlaps,
            (Greater, Greater) if self.lo == other.hi => Overlap::MetBy,
            (Greater, Greater) => Overlap::OverlappedBy,
            (Equal, Less) => Overlap::Starts,
            (Equal, Greater) => Overlap::StartedBy,
            (Greater, Equal) => Overlap::Finishes,
            (Less, Equal) => Overlap::FinishedBy,
            (Greater, Less) => Overlap::ContainedBy,
            (Less, Greater) => Overlap::Contains,
        }
    }
}

#[inline]
fn is_below(low: f64, high: f64, infinity: f64) -> bool {
    low < high || (low == infinity && high == infinity)
}

/// Orders two bounds of intervals. They are never NaN here, and −0 equals 0.
#[inline]
fn order(a: f64, b: f64) -> std::cmp::Ordering {
    if a < b {
        std::cmp::Ordering::Less
    } else if a > b {
        std::cmp::Ordering::Greater
    } else {
        std::cmp::Ordering::Equal
    }
}
