//! Sine, cosine, tangent and their inverses, of intervals.
//!
//! Extrema and poles inside an interval are found by the quadrants of its two ends. Far from a quadrant boundary a multiplication by 2/π decides
//! on the quadrant; near one, or for large arguments, the signs of sine and cosine decide. These signs are right for every double, because the
//! argument reduction inside `pxfm` keeps enough digits of π. No multiple of π is ever rounded.

use super::Interval;
use super::rounding::{down_twice, up_twice};

/// Number of quadrants in a whole circle.
const QUADRANTS: u32 = 4;

/// π/2 rounded up.
const HALF_PI_UP: f64 = std::f64::consts::FRAC_PI_2.next_up();

/// π rounded up.
const PI_UP: f64 = std::f64::consts::PI.next_up();

impl Interval {
    /// Sine of the members.
    #[inline]
    pub fn sin(self) -> Interval {
        self.wave(pxfm::f_sin, 0)
    }

    /// Cosine of the members.
    #[inline]
    pub fn cos(self) -> Interval {
        // The cosine is the sine one quadrant later.
        self.wave(pxfm::f_cos, 1)
    }

    /// Sine (`shift` 0) or cosine (`shift` 1) of the members. With the argument shifted by that many quadrants both are the sine, which is highest
    /// at the end of quadrant 0 and lowest at the end of quadrant 2.
    #[inline]
    fn wave(self, function: impl Fn(f64) -> f64, shift: u32) -> Interval {
        const FULL: Interval = Interval::from_bounds(-1.0, 1.0);
        if self.is_empty() {
            return Interval::EMPTY;
        }
        let Some((first, crossed)) = self.quadrants() else {
            return FULL;
        };
        let first = (first + shift) % QUADRANTS;
        if crossed >= QUADRANTS {
            return FULL;
        }
        let (at_lo, at_hi) = (function(self.lo), function(self.hi));
        let (least, greatest) = if at_lo < at_hi { (at_lo, at_hi) } else { (at_hi, at_lo) };
        let lo = if crosses(first, crossed, 2) { -1.0 } else { widened_down(least).max(-1.0) };
        let hi = if crosses(first, crossed, 0) { 1.0 } else { widened_up(greatest).min(1.0) };
        Interval::from_bounds(lo, hi)
    }

    /// Tangent of the members; the whole line when a pole is inside the interval.
    #[inline]
    pub fn tan(self) -> Interval {
        if self.is_empty() {
            return Interval::EMPTY;
        }
        match self.quadrants() {
            Some((first, crossed)) if !crosses(first, crossed, 0) && !crosses(first, crossed, 2) => {
                Interval::from_bounds(widened_down(pxfm::f_tan(self.lo)), widened_up(pxfm::f_tan(self.hi)))
            }
            _ => Interval::ENTIRE,
        }
    }

    /// Inverse sine, in [−π/2, π/2], of the members that are in [−1, 1].
    #[inline]
    pub fn asin(self) -> Interval {
        let domain = self.intersect(Interval::from_bounds(-1.0, 1.0));
        if domain.is_empty() {
            return Interval::EMPTY;
        }
        let lo = widened_down(pxfm::f_asin(domain.lo)).max(-HALF_PI_UP);
        let hi = widened_up(pxfm::f_asin(domain.hi)).min(HALF_PI_UP);
        Interval::from_bounds(lo, hi)
    }

    /// Inverse cosine, in [0, π], of the members that are in [−1, 1].
    #[inline]
    pub fn acos(self) -> Interval {
        let domain = self.intersect(Interval::from_bounds(-1.0, 1.0));
        if domain.is_empty() {
            return Interval::EMPTY;
        }
        let lo = widened_down(pxfm::f_acos(domain.hi)).max(0.0);
        let hi = widened_up(pxfm::f_acos(domain.lo)).min(PI_UP);
        Interval::from_bounds(lo, hi)
    }

    /// Inverse tangent of the members, in (−π/2, π/2).
    #[inline]
    pub fn atan(self) -> Interval {
        if self.is_empty() {
            return Interval::EMPTY;
        }
        let lo = widened_down(pxfm::f_atan(self.lo)).max(-HALF_PI_UP);
        let hi = widened_up(pxfm::f_atan(self.hi)).min(HALF_PI_UP);
        Interval::from_bounds(lo, hi)
    }

    /// Angle in (−π, π] of the vectors (x, y) in a box, as in `f64::atan2`: `self` is y. The vector (0, 0) has no angle.
    ///
    /// A box that touches the cut (y = 0 and x < 0) from below gives all of [−π, π].
    pub fn atan2(self, x: Interval) -> Interval {
        let y = self;
        if y.is_empty() || x.is_empty() || (y == Interval::ZERO && x == Interval::ZERO) {
            return Interval::EMPTY;
        }
        if y.lo >= 0.0 {
            return upper_half_plane_angle(y, x);
        }
        if y.hi >= 0.0 && x.lo < 0.0 {
            return Interval::from_bounds(-PI_UP, PI_UP);
        }
        if y.hi <= 0.0 {
            return -upper_half_plane_angle(-y, x);
        }
        Interval::from_bounds(angle_down(y.lo, x.lo), angle_up(y.hi, x.lo))
    }

    /// Quadrant (0 to 3) of the interval's lower end, and the number of quadrant boundaries between its ends, at most 4. `None` when the
    /// interval is unbounded or wider than a circle.
    #[inline]
    fn quadrants(self) -> Option<(u32, u32)> {
        // The double nearest to 2π is below 2π, so that an interval no wider than that double crosses at most four quadrant boundaries.
        let width = self.hi - self.lo;
        if width > std::f64::consts::TAU {
            return None;
        }
        let (first, is_first_sure) = quadrant_count(self.lo);
        let (last, is_last_sure) = quadrant_count(self.hi);
        if is_first_sure & is_last_sure {
            return Some((first % QUADRANTS, last.wrapping_sub(first)));
        }
        let (first, last) = (quadrant_by_signs(self.lo), quadrant_by_signs(self.hi));
        let crossed = (last + QUADRANTS - first) % QUADRANTS;
        // When both ends are in the same quadrant, either no quadrant boundary is crossed (width < π/2) or all four are (width > 3π/2).
        Some((first, if crossed == 0 && width > 3.0 { QUADRANTS } else { crossed }))
    }
}

/// Whether an interval that starts in quadrant `first` and crosses `crossed` quadrant boundaries crosses the end of `quadrant`.
#[inline(always)]
fn crosses(first: u32, crossed: u32, quadrant: u32) -> bool {
    (quadrant + QUADRANTS - first) % QUADRANTS < crossed
}

/// The number ⌊x / (π/2)⌋ of x's quadrant modulo 2³², and whether a product in doubles was enough to be sure of it.
#[inline(always)]
fn quadrant_count(x: f64) -> (u32, bool) {
    // With |x| < 2²⁰ and a relative error below 2⁻⁵¹ the quotient x / (π/2) is off by at most 2⁻³¹; the guard distance from a whole number is
    // 2⁻³⁰.
    const GUARD: f64 = 1.0 / (1u64 << 30) as f64;
    // Adding 1.5 · 2⁵² rounds the quotient to a whole number, which then stands in the low bits of the sum.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let quotient = x * std::f64::consts::FRAC_2_PI;
    let shifted = quotient + WHOLE;
    let nearest = shifted - WHOLE;
    let floor = (shifted.to_bits() as u32).wrapping_sub(u32::from(nearest > quotient));
    (floor, (x.abs() < 1048576.0) & ((quotient - nearest).abs() > GUARD))
}

#[cold]
fn quadrant_by_signs(x: f64) -> u32 {
    match (pxfm::f_sin(x) >= 0.0, pxfm::f_cos(x) > 0.0) {
        (true, true) => 0,
        (true, false) => 1,
        (false, false) => 2,
        (false, true) => 3,
    }
}

/// Lower bound of a trigonometric function's value that was computed as `nearest`. A computed zero is exact, because each function gives zero
/// only at a double where its true value is zero.
#[inline(always)]
fn widened_down(nearest: f64) -> f64 {
    if nearest == 0.0 { 0.0 } else { down_twice(nearest) }
}

#[inline(always)]
fn widened_up(nearest: f64) -> f64 {
    if nearest == 0.0 { 0.0 } else { up_twice(nearest) }
}

/// Angles of the vectors in a box with y ≥ 0 that is not the origin alone.
fn upper_half_plane_angle(y: Interval, x: Interval) -> Interval {
    if y.hi == 0.0 && x.hi <= 0.0 {
        return Interval::PI;
    }
    // The box lies in y ≥ 0 (x to the right, y up). The least angle is that of a corner on its right side: the lower corner where that side has x >
    // 0, else the upper one. The greatest angle is that of a corner on its left side: the upper corner where that side has x ≥ 0, else the lower
    // one.
    let lo = if x.hi > 0.0 { angle_down(y.lo, x.hi) } else { angle_down(y.hi, x.hi) };
    let hi = if x.lo >= 0.0 { angle_up(y.hi, x.lo) } else { angle_up(y.lo, x.lo) };
    Interval::from_bounds(lo.max(0.0), hi)
}

#[inline]
fn angle_down(y: f64, x: f64) -> f64 {
    let nearest = pxfm::f_atan2(y + 0.0, x + 0.0);
    // An angle computed as zero may be a tiny one that underflowed. So only an angle that is exactly zero (y = 0 and x ≥ 0) is returned as zero;
    // any other result is moved outward.
    if y == 0.0 && x >= 0.0 { 0.0 } else { down_twice(nearest).max(-PI_UP) }
}

#[inline]
fn angle_up(y: f64, x: f64) -> f64 {
    let nearest = pxfm::f_atan2(y + 0.0, x + 0.0);
    if y == 0.0 && x >= 0.0 { 0.0 } else { up_twice(nearest).min(PI_UP) }
}
