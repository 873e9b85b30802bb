//! Elementary functions of intervals: powers, roots, exponential, logarithm, absolute value, minimum, maximum.
//!
//! The crate `pxfm` states a largest error of half a unit in the last place for the functions used here. That error is measured, not proven, so
//! each bound is moved outward by two steps to the neighbouring double: one for the rounding, one in case the stated error is exceeded.

use super::Interval;
use super::rounding::{down, down_twice, up, up_twice};

impl Interval {
    /// Absolute value of the members. The result is exact.
    #[inline]
    pub fn abs(self) -> Interval {
        Interval::from_bounds(self.mignitude(), self.magnitude())
    }

    /// Interval of the smaller of two members: { min(x, y) }. The result is exact.
    #[inline]
    pub fn min(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        Interval::from_bounds(self.lo.min(other.lo), self.hi.min(other.hi))
    }

    /// Interval of the greater of two members: { max(x, y) }. The result is exact.
    #[inline]
    pub fn max(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        Interval::from_bounds(self.lo.max(other.lo), self.hi.max(other.hi))
    }

    /// Square of the members, never negative: narrower than `self * self` when zero is inside the interval.
    #[inline]
    pub fn sqr(self) -> Interval {
        let (least, greatest) = (self.mignitude(), self.magnitude());
        let lo = if least == 0.0 { 0.0 } else { at_least_zero(down(least * least)) };
        let hi = if greatest == 0.0 { 0.0 } else { up(greatest * greatest) };
        Interval::from_bounds(lo, hi)
    }

    /// Square root of the members that have one; empty when all members are negative.
    #[inline]
    pub fn sqrt(self) -> Interval {
        if self.is_empty() || self.hi < 0.0 {
            return Interval::EMPTY;
        }
        let lo = if self.lo > 0.0 { down(self.lo.sqrt()) } else { 0.0 };
        let hi = if self.hi > 0.0 { up(self.hi.sqrt()) } else { 0.0 };
        Interval::from_bounds(lo, hi)
    }

    /// Length √(x² + y²) of the vectors (x, y), with x in `self` and y in `other`.
    #[inline]
    pub fn hypot(self, other: Interval) -> Interval {
        if self.is_empty() || other.is_empty() {
            return Interval::EMPTY;
        }
        let least = hypot_nearest(self.mignitude(), other.mignitude());
        let greatest = hypot_nearest(self.magnitude(), other.magnitude());
        let lo = if least == 0.0 { 0.0 } else { at_least_zero(down_twice(least)) };
        let hi = if greatest == 0.0 { 0.0 } else { up_twice(greatest) };
        Interval::from_bounds(lo, hi)
    }

    /// Integer power xⁿ of the members x; x⁰ is 1 for every x. A member 0 is left out when n is negative.
    pub fn pown(self, n: i32) -> Interval {
        if self.is_empty() {
            return Interval::EMPTY;
        }
        match n {
            0 => Interval::ONE,
            1 => self,
            2 => self.sqr(),
            -1 => self.recip(),
            _ if n > 0 && n % 2 == 0 => power_of_non_negative(self.abs(), n),
            _ if n > 0 => Interval::from_bounds(power_bounds(self.lo, n).lo, power_bounds(self.hi, n).hi),
            _ => negative_power(self, n),
        }
    }

    /// Exponential eˣ of the members.
    #[inline]
    pub fn exp(self) -> Interval {
        if self.is_empty() {
            return Interval::EMPTY;
        }
        let lo = if self.lo == 0.0 { 1.0 } else { at_least_zero(down_twice(pxfm::f_exp(self.lo))) };
        let hi = if self.hi == 0.0 { 1.0 } else { up_twice(pxfm::f_exp(self.hi)) };
        Interval::from_bounds(lo, hi)
    }

    /// Natural logarithm of the positive members; empty when the interval has none.
    #[inline]
    pub fn log(self) -> Interval {
        if self.is_empty() || self.hi <= 0.0 {
            return Interval::EMPTY;
        }
        // 1 is the only double whose logarithm is exactly a double, so only its logarithm is not widened.
        let lo = if self.lo <= 0.0 {
            f64::NEG_INFINITY
        } else if self.lo == 1.0 {
            0.0
        } else {
            down_twice(pxfm::f_log(self.lo))
        };
        let hi = if self.hi == 1.0 { 0.0 } else { up_twice(pxfm::f_log(self.hi)) };
        Interval::from_bounds(lo, hi)
    }
}

#[inline(always)]
fn at_least_zero(bound: f64) -> f64 {
    if bound < 0.0 { 0.0 } else { bound }
}

/// Hypotenuse of two non-negative numbers, rounded to nearest. It is exact when one of them is zero, and infinite when one of them is.
#[inline]
fn hypot_nearest(a: f64, b: f64) -> f64 {
    if a.is_infinite() || b.is_infinite() { f64::INFINITY } else { pxfm::f_hypot(a, b) }
}

/// Bounds of the power xⁿ of one number x that is not NaN, for n ≥ 2 or n ≤ −2. Rounding does not change the power's sign.
fn power_bounds(x: f64, n: i32) -> Interval {
    if x == 0.0 || x.is_infinite() {
        let limit = if (x == 0.0) == (n > 0) { 0.0 } else { f64::INFINITY };
        let signed = if x.is_sign_negative() && n % 2 != 0 { -limit } else { limit };
        return Interval::from_bounds(signed, signed);
    }
    let nearest = pxfm::f_pow(x, f64::from(n));
    let (lo, hi) = (down_twice(nearest), up_twice(nearest));
    if x > 0.0 || n % 2 == 0 {
        Interval::from_bounds(at_least_zero(lo), hi)
    } else {
        Interval::from_bounds(lo, hi.min(0.0))
    }
}

/// Power xⁿ of an interval within [0, ∞], for a positive n that is even or odd.
#[inline]
fn power_of_non_negative(x: Interval, n: i32) -> Interval {
    Interval::from_bounds(power_bounds(x.lo, n).lo, power_bounds(x.hi, n).hi)
}

/// Power xⁿ for n < −1. It decreases on positive numbers, and is an even or odd function of x, which gives its values on negative numbers.
fn negative_power(x: Interval, n: i32) -> Interval {
    let positive = |side: Interval| {
        if side.is_empty() || side.hi <= 0.0 {
            return Interval::EMPTY;
        }
        let lo = power_bounds(side.hi, n).lo;
        let hi = if side.lo <= 0.0 { f64::INFINITY } else { power_bounds(side.lo, n).hi };
        Interval::from_bounds(lo, hi)
    };
    let half_line = Interval::from_bounds(0.0, f64::INFINITY);
    let right = positive(x.intersect(half_line));
    let left = positive((-x).intersect(half_line));
    right.hull(if n % 2 == 0 { left } else { -left })
}

/// A lower bound of the n-th root of a number c ≥ 0, for n ≥ 2.
pub(super) fn root_down(c: f64, n: i32) -> f64 {
    proven_root(c, n, 0.0, |root, c| power_bounds(root, n).hi <= c, |root, step| root - step)
}

/// An upper bound of the n-th root of a number c ≥ 0, for n ≥ 2.
pub(super) fn root_up(c: f64, n: i32) -> f64 {
    proven_root(c, n, f64::INFINITY, |root, c| power_bounds(root, n).lo >= c, |root, step| root + step)
}

/// Moves an approximate n-th root outward until its power proves that it is a bound. The bound `trivial`, which always holds, is the answer
/// where that fails.
fn proven_root(
    c: f64,
    n: i32,
    trivial: f64,
    is_bound: impl Fn(f64, f64) -> bool,
    moved: impl Fn(f64, f64) -> f64,
) -> f64 {
    if c == 0.0 || c == 1.0 || c.is_infinite() {
        return c;
    }
    // The scaled number c / 2^(n·shift) is near 1, where powers neither overflow nor lose bits; its root differs from that of c by the exact
    // factor 2^shift.
    let shift = (c.log2() / f64::from(n)).round() as i32;
    let half_power = 2f64.powi(-(n * shift / 2));
    let scaled = c * half_power * 2f64.powi(-(n * shift - n * shift / 2));
    if !scaled.is_normal() {
        return trivial;
    }
    let root = root_nearby(scaled, n);
    // Candidates for the bound are tried from the approximate root outward. The first ones are neighbouring numbers. Then the steps grow, so that a
    // poor approximation costs steps, never soundness.
    let candidates = (0..40).scan((root, root * f64::EPSILON), |(candidate, step), idx| {
        let current = *candidate;
        *candidate = moved(current, if idx < 4 { 0.5 * *step } else { *step });
        if idx >= 4 {
            *step *= 2.0;
        }
        Some(current)
    });
    let mut proven = candidates.filter(|candidate| is_bound(*candidate, scaled));
    proven.next().map_or(trivial, |bound| bound * 2f64.powi(shift))
}

/// Approximate n-th root of c, to about one unit in the last place. Bounds of the root are proven by taking the power, not by this function.
fn root_nearby(c: f64, n: i32) -> f64 {
    let root = pxfm::f_pow(c, 1.0 / f64::from(n));
    // The exponent 1/n is rounded, which costs up to |ln c| units in the last place: one step of Newton's method on the logarithm repairs that.
    let excess = c / pxfm::f_pow(root, f64::from(n)) - 1.0;
    if excess.is_finite() { root + root * excess / f64::from(n) } else { root }
}
