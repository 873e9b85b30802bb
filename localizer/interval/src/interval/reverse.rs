//! Reverse operations: given the interval of an operation's result and an interval known to hold the operand, what can the operand be?
//!
//! Each reverse operation returns the hull of { x ∈ known : f(x) ∈ result } (the reverse-mode operations of IEEE 1788-2015). The backward pass
//! of a forward-backward contractor consists of these operations.

use super::Interval;
use super::elementary::{root_down, root_up};
use super::rounding::{down_sum, up_sum};

/// Greatest distance from 0, in radians, at which the reverse operations of sine, cosine and tangent narrow a bound of an angle: a bound farther
/// from 0 stays as known. Enclosures of multiples of π are some 10⁻⁴ wide there, and grow with the distance.
const LARGEST_PERIODIC: f64 = 1e12;

const NON_NEGATIVE: Interval = Interval::from_bounds(0.0, f64::INFINITY);

impl Interval {
    /// Reverse of the square: interval around the operands in `known` whose square is in `self`.
    #[inline]
    pub fn sqr_rev(self, known: Interval) -> Interval {
        even_reverse(self.sqrt(), known)
    }

    /// Reverse of the absolute value: interval around the operands in `known` whose absolute value is in `self`.
    #[inline]
    pub fn abs_rev(self, known: Interval) -> Interval {
        even_reverse(self.intersect(NON_NEGATIVE), known)
    }

    /// Reverse of the integer power: interval around the operands in `known` whose power n is in `self`.
    pub fn pown_rev(self, known: Interval, n: i32) -> Interval {
        let root = match n {
            0 => {
                return if self.contains(1.0) { known } else { Interval::EMPTY };
            }
            i32::MIN => return known,
            _ => self.real_root(n.abs()),
        };
        match (n > 0, n % 2 == 0) {
            (true, true) => even_reverse(root, known),
            (true, false) => root.intersect(known),
            // xⁿ = c is the same equation as (1/x)⁻ⁿ = c, where −n is positive.
            (false, true) => even_reverse(root.recip(), known),
            (false, false) => Interval::ONE.mul_rev(root, known),
        }
    }

    /// Real n-th roots of the members for n ≥ 1; only the non-negative roots when n is even.
    fn real_root(self, n: i32) -> Interval {
        let range = if n % 2 == 0 { self.intersect(NON_NEGATIVE) } else { self };
        if range.is_empty() || n == 1 {
            return range;
        }
        let lo = if range.lo < 0.0 { -root_up(-range.lo, n) } else { root_down(range.lo, n) };
        let hi = if range.hi < 0.0 { -root_down(-range.hi, n) } else { root_up(range.hi, n) };
        Interval::from_bounds(lo, hi)
    }

    /// Reverse of the sine: interval around the angles in `known` whose sine is in `self`.
    pub fn sin_rev(self, known: Interval) -> Interval {
        let principal = self.asin();
        // Branch k of the inverse sine is centred on kπ; the sine rises on even branches and falls on odd ones.
        periodic_reverse(principal, known, 0.5, |k| pi_times(k) + if k % 2 == 0 { principal } else { -principal })
    }

    /// Reverse of the cosine: interval around the angles in `known` whose cosine is in `self`.
    pub fn cos_rev(self, known: Interval) -> Interval {
        let principal = self.acos();
        // Branch k of the inverse cosine is [kπ, (k + 1)π]; the cosine falls on even branches and rises on odd ones.
        periodic_reverse(principal, known, 0.0, |k| {
            if k % 2 == 0 { pi_times(k) + principal } else { pi_times(k + 1) - principal }
        })
    }

    /// Reverse of the tangent: interval around the angles in `known` whose tangent is in `self`.
    pub fn tan_rev(self, known: Interval) -> Interval {
        let principal = self.atan();
        periodic_reverse(principal, known, 0.5, |k| pi_times(k) + principal)
    }

    /// Reverse of the product: interval around the factors x in `known` for which x · y is in `self` for some member y of `factor`.
    #[inline]
    pub fn mul_rev(self, factor: Interval, known: Interval) -> Interval {
        let (first, second) = self.div2(factor);
        first.intersect(known).hull(second.intersect(known))
    }

    /// The tightest interval c with `other + c ⊇ self` (IEEE 1788: `cancelMinus`). It undoes an addition without widening.
    ///
    /// The result is the whole line when `self` is narrower than `other`, or when one of the two is unbounded.
    #[inline]
    pub fn cancel_minus(self, other: Interval) -> Interval {
        if self.is_empty() && (other.is_empty() || other.is_bounded()) {
            return Interval::EMPTY;
        }
        if !self.is_bounded() || !other.is_bounded() || is_narrower(self, other) {
            return Interval::ENTIRE;
        }
        Interval::from_bounds(down_sum(self.lo - other.lo), up_sum(self.hi - other.hi))
    }

    /// The tightest interval c with `c − other ⊇ self` (IEEE 1788: `cancelPlus`). It undoes a subtraction without widening.
    #[inline]
    pub fn cancel_plus(self, other: Interval) -> Interval {
        self.cancel_minus(-other)
    }
}

/// Enclosure of kπ. Where k times the bounds of π is exact (k = ±1, ±2, ±4), the enclosure is not rounded outward.
#[inline]
fn pi_times(k: i64) -> Interval {
    let factor = k as f64;
    match k {
        1 | 2 | 4 => Interval::from_bounds(factor * Interval::PI.lo, factor * Interval::PI.hi),
        -4 | -2 | -1 => -pi_times(-k),
        _ => factor * Interval::PI,
    }
}

/// Reverse of an even function: interval around the operands in `known` whose absolute value is in `magnitude`.
#[inline]
fn even_reverse(magnitude: Interval, known: Interval) -> Interval {
    magnitude.intersect(known).hull((-magnitude).intersect(known))
}

/// Narrows `known` to the values that a periodic function's inverse can have. The inverse has one branch for each integer k, an interval within [(k
/// − offset)π, (k + 1 − offset)π], given by `branch`. The result is the hull of what these branches have in common with `known`.
fn periodic_reverse(principal: Interval, known: Interval, offset: f64, branch: impl Fn(i64) -> Interval) -> Interval {
    if principal.is_empty() || known.is_empty() {
        return Interval::EMPTY;
    }
    let index = |x: f64| (x / std::f64::consts::PI + offset).floor() as i64;
    // For each end of `known` the branches around the computed index are tried, from one further outside to two further inside: one on either side
    // because the quotient is rounded, and one more inside because the end may lie in the gap between two branches.
    let lo = if known.lo.abs() > LARGEST_PERIODIC {
        Some(known.lo)
    } else {
        let first = index(known.lo);
        (first - 1..=first + 2).map(|k| branch(k).intersect(known)).find(|part| !part.is_empty()).map(Interval::lo)
    };
    let hi = if known.hi.abs() > LARGEST_PERIODIC {
        Some(known.hi)
    } else {
        let last = index(known.hi);
        (last - 2..=last + 1).rev().map(|k| branch(k).intersect(known)).find(|part| !part.is_empty()).map(Interval::hi)
    };
    match (lo, hi) {
        (Some(lo), Some(hi)) => Interval::new(lo, hi),
        _ => Interval::EMPTY,
    }
}

/// Whether interval a is narrower than interval b, decided on the exact widths.
#[inline]
fn is_narrower(a: Interval, b: Interval) -> bool {
    let (a_width, a_error) = exact_difference(a.hi, a.lo);
    let (b_width, b_error) = exact_difference(b.hi, b.lo);
    a_width < b_width || (a_width == b_width && a_error < b_error)
}

/// The difference x − y as an unevaluated sum of two numbers, the rounded difference first (Knuth's two-sum). If it overflows, the first number
/// is infinite and the second is half of the difference.
fn exact_difference(x: f64, y: f64) -> (f64, f64) {
    let difference = x - y;
    if difference.is_infinite() {
        // Where a difference overflows, the returned pair still compares rightly: its first number is infinite, hence larger than that of any
        // difference that does not overflow, and its second number orders those that do.
        let (half, error) = exact_difference(0.5 * x, 0.5 * y);
        return (f64::INFINITY, half + error);
    }
    let y_part = difference - x;
    let x_part = difference - y_part;
    (difference, (x - x_part) - (y + y_part))
}
