//! Arithmetic of intervals: the four operations, a division with two result intervals, and the operations between an interval and an `f64`,
//! which stands for exactly that number.

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use super::Interval;
use super::rounding::{are_regular, down, down_regular, down_sum, up, up_regular, up_sum};

impl Neg for Interval {
    type Output = Interval;
    #[inline]
    fn neg(self) -> Interval {
        Interval::from_bounds(-self.hi, -self.lo)
    }
}

impl Add for Interval {
    type Output = Interval;
    #[inline]
    fn add(self, other: Interval) -> Interval {
        let (lo, hi) = (self.lo + other.lo, self.hi + other.hi);
        if are_regular(lo, hi) {
            Interval::from_bounds(down_regular(lo), up_regular(hi))
        } else {
            Interval::from_bounds(down_sum(lo), up_sum(hi))
        }
    }
}

impl Sub for Interval {
    type Output = Interval;
    #[inline]
    fn sub(self, other: Interval) -> Interval {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Interval;
    #[inline]
    fn mul(self, other: Interval) -> Interval {
        let ll = self.lo * other.lo;
        let lh = self.lo * other.hi;
        let hl = self.hi * other.lo;
        let hh = self.hi * other.hi;
        let (lo, hi) = (least(least(ll, lh), least(hl, hh)), greatest(greatest(ll, lh), greatest(hl, hh)));
        // 0 × ∞ gives NaN, and the comparisons in `least` and `greatest` may drop a NaN. Then either an end of the result is 0, the product of the
        // zero with the other factor's finite bound, or the result is infinite. Neither of these is a regular number, so the product is then
        // computed case by case.
        if are_regular(lo, hi) {
            Interval::from_bounds(down_regular(lo), up_regular(hi))
        } else {
            multiply_by_cases(self, other)
        }
    }
}

#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Product of two intervals case by case, for factors that are empty, zero, infinite or tiny.
#[cold]
fn multiply_by_cases(a: Interval, b: Interval) -> Interval {
    if a.is_empty() || b.is_empty() {
        return Interval::EMPTY;
    }
    if a == Interval::ZERO || b == Interval::ZERO {
        return Interval::ZERO;
    }
    [(a.lo, b.lo), (a.lo, b.hi), (a.hi, b.lo), (a.hi, b.hi)]
        .into_iter()
        .fold(Interval::EMPTY, |hull, (x, y)| hull.hull(enclose_product(x, y)))
}

/// Encloses the real product of two bounds, where a bound 0 times an infinite one is 0, because no member of an interval is infinite.
#[inline]
fn enclose_product(x: f64, y: f64) -> Interval {
    if x == 0.0 || y == 0.0 {
        return Interval::ZERO;
    }
    enclose_signed(x * y, (x > 0.0) == (y > 0.0))
}

/// Encloses the real number that was rounded to `nearest`. The number's sign is known, so that an underflow does not cross zero.
#[inline]
fn enclose_signed(nearest: f64, is_positive: bool) -> Interval {
    let (lo, hi) = (down(nearest), up(nearest));
    if is_positive { Interval::from_bounds(lo.max(0.0), hi) } else { Interval::from_bounds(lo, hi.min(0.0)) }
}

impl Div for Interval {
    type Output = Interval;
    /// Quotient { x / y : y ≠ 0 } as one interval; see [`div2`](Interval::div2) for the two pieces that it may consist of.
    #[inline]
    fn div(self, other: Interval) -> Interval {
        // A negative divisor is turned positive, together with the dividend. Then each bound of the quotient comes from one bound of the dividend
        // and that bound of the divisor which moves the quotient outward.
        let (numerator, divisor) = if other.hi < 0.0 { (-self, -other) } else { (self, other) };
        if divisor.lo > 0.0 {
            let lo = numerator.lo / if numerator.lo < 0.0 { divisor.lo } else { divisor.hi };
            let hi = numerator.hi / if numerator.hi < 0.0 { divisor.hi } else { divisor.lo };
            if are_regular(lo, hi) {
                return Interval::from_bounds(down_regular(lo), up_regular(hi));
            }
        }
        divide_by_cases(numerator, divisor)
    }
}

/// Quotient of two intervals case by case, for operands that are empty, zero, infinite or tiny.
#[cold]
fn divide_by_cases(numerator: Interval, divisor: Interval) -> Interval {
    let (by_negative, by_positive) = divide_by_signs(numerator, divisor);
    by_negative.hull(by_positive)
}

impl Interval {
    /// Quotient { x / y : y ≠ 0 } as at most two intervals, the lower one first; the second is empty when one interval is the answer.
    ///
    /// IEEE 1788 calls the operation `mulRevToPair(den, self)`: all q with q · y = x for some member x of `self` and some member y of `den`. So
    /// the quotient is the whole line when both contain 0 (unlike `/`, which never divides by 0), and two half lines when only the divisor
    /// contains 0, in its interior.
    #[inline]
    pub fn div2(self, den: Interval) -> (Interval, Interval) {
        if self.is_empty() || den.is_empty() {
            return (Interval::EMPTY, Interval::EMPTY);
        }
        if self.contains_zero() && den.contains_zero() {
            return (Interval::ENTIRE, Interval::EMPTY);
        }
        let (by_negative, by_positive) = divide_by_signs(self, den);
        match (by_negative.is_empty(), by_positive.is_empty()) {
            (false, false) if by_negative.lo > by_positive.lo => (by_positive, by_negative),
            (true, _) => (by_positive, Interval::EMPTY),
            (false, _) => (by_negative, by_positive),
        }
    }

    /// Reciprocal `1 / self` of the interval.
    #[inline]
    pub fn recip(self) -> Interval {
        Interval::ONE / self
    }
}

/// The non-negative numbers. The 0 stands for the limit of divisors above 0.
const POSITIVE: Interval = Interval::from_bounds(0.0, f64::INFINITY);

/// Quotients by the negative members and by the positive members of the divisor, as two intervals.
#[inline]
fn divide_by_signs(numerator: Interval, divisor: Interval) -> (Interval, Interval) {
    let by_negative = divide_by_positive(-numerator, (-divisor).intersect(POSITIVE));
    let by_positive = divide_by_positive(numerator, divisor.intersect(POSITIVE));
    (by_negative, by_positive)
}

/// Quotient { x / y : y > 0 } for a `divisor` within [0, ∞].
#[inline]
fn divide_by_positive(numerator: Interval, divisor: Interval) -> Interval {
    if numerator.is_empty() || divisor.is_empty() || divisor.hi == 0.0 {
        return Interval::EMPTY;
    }
    let low_divisor = if numerator.lo < 0.0 { divisor.lo } else { divisor.hi };
    let high_divisor = if numerator.hi < 0.0 { divisor.hi } else { divisor.lo };
    let lo = enclose_quotient(numerator.lo, low_divisor).lo;
    let hi = enclose_quotient(numerator.hi, high_divisor).hi;
    Interval::from_bounds(lo, hi)
}

/// Bounds of the quotient x / y of two numbers with y ∈ [0, ∞]. They are ±∞ when y is 0, which is the limit from above.
#[inline]
fn enclose_quotient(x: f64, y: f64) -> Interval {
    if x == 0.0 {
        return Interval::ZERO;
    }
    if y == 0.0 || x.is_infinite() {
        return Interval::from_bounds(x.signum() * f64::INFINITY, x.signum() * f64::INFINITY);
    }
    enclose_signed(x / y, x > 0.0)
}

impl Mul<f64> for Interval {
    type Output = Interval;
    #[inline]
    fn mul(self, factor: f64) -> Interval {
        let (a, b) = (self.lo * factor, self.hi * factor);
        let (lo, hi) = if factor < 0.0 { (b, a) } else { (a, b) };
        if are_regular(lo, hi) {
            Interval::from_bounds(down_regular(lo), up_regular(hi))
        } else {
            multiply_by_cases(self, Interval::point(factor))
        }
    }
}

impl Mul<Interval> for f64 {
    type Output = Interval;
    #[inline]
    fn mul(self, other: Interval) -> Interval {
        other * self
    }
}

/// Defines the operations between an interval and a number, which stands for the interval that holds only that number.
macro_rules! with_number {
    ($($operation:ident $method:ident),*) => {$(
        impl $operation<f64> for Interval {
            type Output = Interval;
            #[inline]
            fn $method(self, other: f64) -> Interval {
                self.$method(Interval::point(other))
            }
        }
        impl $operation<Interval> for f64 {
            type Output = Interval;
            #[inline]
            fn $method(self, other: Interval) -> Interval {
                Interval::point(self).$method(other)
            }
        }
    )*};
}
with_number!(Add add, Sub sub, Div div);

/// Defines the assigning operations: `a += b` is `a = a + b`, where the operand `b` is an interval or a number.
macro_rules! assigning {
    ($($assign:ident $assign_method:ident $operation:ident $method:ident),*) => {$(
        impl<Operand> $assign<Operand> for Interval
        where
            Interval: $operation<Operand, Output = Interval>,
        {
            #[inline]
            fn $assign_method(&mut self, other: Operand) {
                *self = (*self).$method(other);
            }
        }
    )*};
}
assigning!(AddAssign add_assign Add add, SubAssign sub_assign Sub sub, MulAssign mul_assign Mul mul, DivAssign div_assign Div div);
