//! Outward rounding of results that were rounded to nearest, without touching the rounding mode.
//!
//! Source: S. M. Rump, P. Zimmermann, S. Boldo, G. Melquiond, "Computing predecessor and successor in rounding to nearest", BIT 49 (2009),
//! algorithm 1: with φ = u (1 + 2u), u = 2⁻⁵³, the numbers `c − φ|c|` and `c + φ|c|` rounded to nearest are the neighbours of c as long as φ|c|
//! does not underflow. It underflows for tiny numbers only, whose bits are stepped instead.

/// The factor φ = u (1 + 2u) with u = 2⁻⁵³; φ|c| added to a number c gives its upper neighbour.
const PHI: f64 = 0.5 * f64::EPSILON * (1.0 + f64::EPSILON);

/// Smallest magnitude of a number that counts as regular, 2⁻⁹⁶⁰: from here up φ|c| is a normal number. That needs only |c| ≥ 2⁻⁹⁶⁹; the rest is
/// margin.
const REGULAR: f64 = f64::from_bits((1023 - 960) << 52);

/// Magnitude below which sums are exact: below 2⁻¹⁰²¹ every multiple of 2⁻¹⁰⁷⁴ is a double, hence every sum of doubles is exact.
const EXACT_SUM: f64 = 2.0 * f64::MIN_POSITIVE;

/// Whether the fast way to a number's neighbouring doubles (adding or subtracting φ times its absolute value) is valid: false for tiny numbers,
/// infinities and NaN.
#[inline(always)]
pub(super) fn is_regular(nearest: f64) -> bool {
    (nearest.abs() >= REGULAR) & (nearest.abs() < f64::INFINITY)
}

/// Whether the fast way to the neighbouring doubles (adding or subtracting φ times the absolute value) is valid for both ends of an interval; one
/// subtraction detects infinities and NaN in either end.
#[inline(always)]
pub(super) fn are_regular(lo: f64, hi: f64) -> bool {
    let (below, above) = (lo.abs(), hi.abs());
    let least = if below < above { below } else { above };
    (least >= REGULAR) & (hi - lo < f64::INFINITY)
}

/// The double next below a number that is neither tiny nor infinite nor NaN.
#[inline(always)]
pub(super) fn down_regular(nearest: f64) -> f64 {
    nearest - PHI * nearest.abs()
}

/// The double next above a number that is neither tiny nor infinite nor NaN.
#[inline(always)]
pub(super) fn up_regular(nearest: f64) -> f64 {
    nearest + PHI * nearest.abs()
}

/// A lower bound of the real result that was rounded to `nearest`.
#[inline(always)]
pub(super) fn down(nearest: f64) -> f64 {
    if is_regular(nearest) { down_regular(nearest) } else { nearest.next_down() }
}

/// An upper bound of the real result that was rounded to `nearest`.
#[inline(always)]
pub(super) fn up(nearest: f64) -> f64 {
    if is_regular(nearest) { up_regular(nearest) } else { nearest.next_up() }
}

/// A lower bound of a real sum or difference that was rounded to `nearest`; tiny sums are exact.
#[inline(always)]
pub(super) fn down_sum(nearest: f64) -> f64 {
    if is_regular(nearest) { down_regular(nearest) } else { down_small_sum(nearest) }
}

/// An upper bound of a real sum or difference that was rounded to `nearest`; tiny sums are exact.
#[inline(always)]
pub(super) fn up_sum(nearest: f64) -> f64 {
    if is_regular(nearest) { up_regular(nearest) } else { -down_small_sum(-nearest) }
}

#[cold]
fn down_small_sum(nearest: f64) -> f64 {
    if nearest.abs() < EXACT_SUM { nearest } else { nearest.next_down() }
}

/// Moves `nearest` two doubles down: a lower bound of the real result when `nearest` is off by less than one and a half units in the last place.
#[inline(always)]
pub(super) fn down_twice(nearest: f64) -> f64 {
    down(down(nearest))
}

/// Moves `nearest` two doubles up: an upper bound of the real result when `nearest` is off by less than one and a half units in the last place.
#[inline(always)]
pub(super) fn up_twice(nearest: f64) -> f64 {
    up(up(nearest))
}
