//! Reverse operations: given the result and what is known of the operand, what can the operand be?
//!
//! Each answers with the hull of { x ∈ known : f(x) ∈ result } (the reverse-mode operations of IEEE 1788-2015). They are what the backward pass of a
//! forward-backward contractor consists of.

use super::Interval;
use super::elementary::{root_down, root_up};
use super::rounding::{down_sum, up_sum};

/// Above this the bounds of a solution are no narrower than π, so periodic reverses answer with what was known.
const LARGEST_PERIODIC: f64 = 1e12;

const NON_NEGATIVE: Interval = Interval::from_bounds(0.0, f64::INFINITY);

impl Interval {
    /// Operands in `known` whose square is in `self`.
    #[inline]
    pub fn sqr_rev(self, known: Interval) -> Interval {
        even_reverse(self.sqrt(), known)
    }

    /// Operands in `known` whose absolute value is in `self`.
    #[inline]
    pub fn abs_rev(self, known: Interval) -> Interval {
        even_reverse(self.intersect(NON_NEGATIVE), known)
    }

    /// Operands in `known` whose power n is in `self`.
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
            // xⁿ = c is (1/x)⁻ⁿ = c.
            (false, true) => even_reverse(root.recip(), known),
            (false, false) => Interval::ONE.mul_rev(root, known),
        }
    }

    /// Real n-th roots, n ≥ 1; the non-negative ones when n is even.
    fn real_root(self, n: i32) -> Interval {
        let range = if n % 2 == 0 { self.intersect(NON_NEGATIVE) } else { self };
        if range.is_empty() || n == 1 {
            return range;
        }
        let lo = if range.lo < 0.0 { -root_up(-range.lo, n) } else { root_down(range.lo, n) };
        let hi = if range.hi < 0.0 { -root_down(-range.hi, n) } else { root_up(range.hi, n) };
        Interval::from_bounds(lo, hi)
    }

    /// Angles in `known` whose sine is in `self`.
    pub fn sin_rev(self, known: Interval) -> Interval {
        let principal = self.asin();
        // Branch k is centred on kπ; the sine rises on even ones and falls on odd ones.
        periodic_reverse(principal, known, 0.5, |k| pi_times(k) + if k % 2 == 0 { principal } else { -principal })
    }

    /// Angles in `known` whose cosine is in `self`.
    pub fn cos_rev(self, known: Interval) -> Interval {
        let principal = self.acos();
        // Branch k is [kπ, (k + 1)π]; the cosine falls on even ones and rises on odd ones.
        periodic_reverse(principal, known, 0.0, |k| {
            if k % 2 == 0 { pi_times(k) + principal } else { pi_times(k + 1) - principal }
        })
    }

    /// Angles in `known` whose tangent is in `self`.
    pub fn tan_rev(self, known: Interval) -> Interval {
        let principal = self.atan();
        periodic_reverse(principal, known, 0.5, |k| pi_times(k) + principal)
    }

    /// Factors x in `known` with x · `factor` in `self`, for some member of `factor`.
    #[inline]
    pub fn mul_rev(self, factor: Interval, known: Interval) -> Interval {
        let (first, second) = self.div2(factor);
        first.intersect(known).hull(second.intersect(known))
    }

    /// The tightest c with `other + c ⊇ self` (IEEE 1788: `cancelMinus`): undoes an addition without widening.
    ///
    /// The whole line when `self` is narrower than `other` or one is unbounded.
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

    /// The tightest c with `c − other ⊇ self` (IEEE 1788: `cancelPlus`).
    #[inline]
    pub fn cancel_plus(self, other: Interval) -> Interval {
        self.cancel_minus(-other)
    }
}

/// kπ; exact multiples of the bounds of π where there are such.
#[inline]
fn pi_times(k: i64) -> Interval {
    let factor = k as f64;
    match k {
        1 | 2 | 4 => Interval::from_bounds(factor * Interval::PI.lo, factor * Interval::PI.hi),
        -4 | -2 | -1 => -pi_times(-k),
        _ => factor * Interval::PI,
    }
}

/// Operands of an even function that has the value y ≥ 0 exactly at ±y.
#[inline]
fn even_reverse(magnitude: Interval, known: Interval) -> Interval {
    magnitude.intersect(known).hull((-magnitude).intersect(known))
}

/// Hull of the branches that meet `known`. Branch k lies in [(k − offset)π, (k + 1 − offset)π] and moves up with k.
fn periodic_reverse(principal: Interval, known: Interval, offset: f64, branch: impl Fn(i64) -> Interval) -> Interval {
    if principal.is_empty() || known.is_empty() {
        return Interval::EMPTY;
    }
    let index = |x: f64| (x / std::f64::consts::PI + offset).floor() as i64;
    // One index of slack covers the rounding of the quotient, a second one the gap between two branches.
    let lo = if known.lo < -LARGEST_PERIODIC {
        Some(known.lo)
    } else {
        let first = index(known.lo.min(LARGEST_PERIODIC));
        (first - 1..=first + 2).map(|k| branch(k).intersect(known)).find(|part| !part.is_empty()).map(Interval::lo)
    };
    let hi = if known.hi > LARGEST_PERIODIC {
        Some(known.hi)
    } else {
        let last = index(known.hi.max(-LARGEST_PERIODIC));
        (last - 2..=last + 1).rev().map(|k| branch(k).intersect(known)).find(|part| !part.is_empty()).map(Interval::hi)
    };
    match (lo, hi) {
        (Some(lo), Some(hi)) => Interval::new(lo, hi),
        _ => Interval::EMPTY,
    }
}

/// Whether a is narrower than b, decided on the exact widths.
#[inline]
fn is_narrower(a: Interval, b: Interval) -> bool {
    let (a_width, a_error) = exact_difference(a.hi, a.lo);
    let (b_width, b_error) = exact_difference(b.hi, b.lo);
    a_width < b_width || (a_width == b_width && a_error < b_error)
}

/// x − y as an unevaluated sum, rounded part first (Knuth's two-sum); halved when it would overflow.
fn exact_difference(x: f64, y: f64) -> (f64, f64) {
    let difference = x - y;
    if difference.is_infinite() {
        // Larger than any width that does not overflow, and still ordered among those that do.
        let (half, error) = exact_difference(0.5 * x, 0.5 * y);
        return (f64::INFINITY, half + error);
    }
    let y_part = difference - x;
    let x_part = difference - y_part;
    (difference, (x - x_part) - (y + y_part))
}
