//! Closed intervals of real numbers with outward rounding: the result of every operation contains every possible result.
//!
//! An interval is the set { x ∈ ℝ : lo ≤ x ≤ hi }. Infinite bounds are allowed and are not members, as in IEEE 1788-2015 (set-based flavour).
//! The empty interval is a value: arithmetic with it gives the empty interval, and it equals itself.
//!
//! Bounds are computed in round-to-nearest and then moved one step outward (`rounding`), so that no rounding mode is ever switched. Results of
//! basic operations exceed the tightest result by at most one unit in the last place on each side, those of elementary functions by at most two.

mod arithmetic;
mod elementary;
mod predicates;
mod reverse;
mod rounding;
mod text;
mod trigonometry;

pub use predicates::Overlap;
pub use text::ParseIntervalError;

/// A closed interval of real numbers, possibly unbounded or empty.
#[derive(Clone, Copy)]
pub struct Interval {
    // Both bounds are NaN when the interval is empty, so that arithmetic keeps emptiness without a branch. Otherwise lo ≤ hi, lo < ∞ and hi >
    // −∞.
    lo: f64,
    hi: f64,
}

impl Interval {
    /// The empty interval, which contains no number.
    pub const EMPTY: Interval = Interval { lo: f64::NAN, hi: f64::NAN };
    /// The interval of all real numbers.
    pub const ENTIRE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    /// The interval that contains exactly 0.
    pub const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };
    /// The interval that contains exactly 1.
    pub const ONE: Interval = Interval { lo: 1.0, hi: 1.0 };
    /// Tightest enclosure of π. The double nearest to π is its lower bound, because that double is below π.
    pub const PI: Interval = Interval { lo: std::f64::consts::PI, hi: std::f64::consts::PI.next_up() };

    /// The interval of all numbers from `lo` to `hi`. It is empty when `lo > hi`, when a bound is NaN, or when both bounds are the same
    /// infinity.
    #[inline]
    pub const fn new(lo: f64, hi: f64) -> Interval {
        if lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY { Interval { lo, hi } } else { Interval::EMPTY }
    }

    /// The interval that contains exactly `value`; empty when `value` is not finite.
    #[inline]
    pub const fn point(value: f64) -> Interval {
        Interval::new(value, value)
    }

    /// The interval of all numbers within `radius` of `mid`, rounded outward; empty when the radius is negative or NaN.
    #[inline]
    pub fn centred(mid: f64, radius: f64) -> Interval {
        Interval::point(mid).inflate(radius)
    }

    // Makes an interval of unchecked bounds, for callers that have just proven that the bounds are valid.
    #[inline(always)]
    const fn from_bounds(lo: f64, hi: f64) -> Interval {
        Interval { lo, hi }
    }

    /// Greatest lower bound of the interval; NaN when the interval is empty.
    #[inline]
    pub const fn lo(self) -> f64 {
        self.lo
    }

    /// Least upper bound of the interval; NaN when the interval is empty.
    #[inline]
    pub const fn hi(self) -> f64 {
        self.hi
    }

    /// A finite member close to the interval's middle: 0 for the whole line, ±`f64::MAX` for a half line. NaN when the interval is empty.
    #[inline]
    pub fn mid(self) -> f64 {
        let sum = self.lo + self.hi;
        if sum.is_finite() {
            return 0.5 * sum;
        }
        match (self.lo.is_finite(), self.hi.is_finite()) {
            (true, true) => 0.5 * self.lo + 0.5 * self.hi,
            (true, false) => f64::MAX,
            (false, true) => f64::MIN,
            (false, false) => {
                if self.is_empty() {
                    f64::NAN
                } else {
                    0.0
                }
            }
        }
    }

    /// An upper bound of the distance from [`mid`](Self::mid) to either end of the interval, so that `centred(mid, radius)` contains the
    /// interval. NaN when the interval is empty.
    #[inline]
    pub fn radius(self) -> f64 {
        let mid = self.mid();
        let below = rounding::up_sum(mid - self.lo);
        let above = rounding::up_sum(self.hi - mid);
        if below > above { below } else { above }
    }

    /// Width `hi − lo` of the interval, rounded up; NaN when the interval is empty.
    #[inline]
    pub fn width(self) -> f64 {
        rounding::up_sum(self.hi - self.lo)
    }

    /// Largest absolute value of a member of the interval; NaN when the interval is empty.
    #[inline]
    pub fn magnitude(self) -> f64 {
        let (below, above) = (self.lo.abs(), self.hi.abs());
        if below > above { below } else { above }
    }

    /// Smallest absolute value of a member of the interval; NaN when the interval is empty.
    #[inline]
    pub fn mignitude(self) -> f64 {
        if self.lo > 0.0 {
            self.lo
        } else if self.hi < 0.0 {
            -self.hi
        } else if self.is_empty() {
            f64::NAN
        } else {
            0.0
        }
    }

    /// Whether the interval has no member.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.lo.is_nan()
    }

    /// Whether a number is a member of the interval; infinities never are.
    #[inline]
    pub const fn contains(self, value: f64) -> bool {
        self.lo <= value && value <= self.hi && value.is_finite()
    }

    /// Whether 0 is a member of the interval.
    #[inline]
    pub const fn contains_zero(self) -> bool {
        self.lo <= 0.0 && 0.0 <= self.hi
    }

    /// Whether every member of this interval is a member of `other`; true when this interval is empty.
    #[inline]
    pub const fn is_subset_of(self, other: Interval) -> bool {
        self.is_empty() || (other.lo <= self.lo && self.hi <= other.hi)
    }

    /// Whether the two intervals have a member in common.
    #[inline]
    pub const fn overlaps(self, other: Interval) -> bool {
        self.lo <= other.hi && other.lo <= self.hi
    }

    /// Interval of the members that two intervals have in common. The result is exact.
    #[inline]
    pub fn intersect(self, other: Interval) -> Interval {
        if !self.overlaps(other) {
            return Interval::EMPTY;
        }
        let lo = if self.lo > other.lo { self.lo } else { other.lo };
        let hi = if self.hi < other.hi { self.hi } else { other.hi };
        Interval::from_bounds(lo, hi)
    }

    /// Smallest interval that contains both intervals. The result is exact.
    #[inline]
    pub fn hull(self, other: Interval) -> Interval {
        // f64::min and f64::max return the other operand when one is NaN, so that the hull with an empty interval is the other interval.
        Interval::from_bounds(self.lo.min(other.lo), self.hi.max(other.hi))
    }

    /// The interval of all numbers within `radius` of a member of this one, rounded outward; empty when the radius is negative or NaN.
    #[inline]
    pub fn inflate(self, radius: f64) -> Interval {
        if radius >= 0.0 { self + Interval::from_bounds(-radius, radius) } else { Interval::EMPTY }
    }
}

impl PartialEq for Interval {
    #[inline]
    fn eq(&self, other: &Interval) -> bool {
        (self.is_empty() && other.is_empty()) || (self.lo == other.lo && self.hi == other.hi)
    }
}

impl From<f64> for Interval {
    #[inline]
    fn from(value: f64) -> Interval {
        Interval::point(value)
    }
}
