//! Dual numbers of intervals: a value and its derivatives, which make first-order models with a rigorous remainder.
//!
//! Over a box Φ around φ₀ a function f is in f(φ₀) + Σₖ ∂ₖf(Φ)·(φₖ − φ₀ₖ) (mean value form; R. Moore, *Interval Analysis*, 1966).

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::Interval;

/// A value and its derivatives by `K` parameters, all as intervals.
#[derive(Clone, Copy, Debug)]
pub struct Dual<const K: usize> {
    /// Enclosure of the number's value.
    pub value: Interval,
    /// Enclosure of the number's derivative by each parameter, over all values that the parameters may have.
    pub slopes: [Interval; K],
}

impl<const K: usize> Dual<K> {
    /// A dual number that depends on no parameter, so that its derivatives are 0.
    pub fn constant(value: Interval) -> Self {
        Dual { value, slopes: [Interval::ZERO; K] }
    }

    /// The parameter number `index` as a dual number; its interval is `value`.
    pub fn parameter(index: usize, value: Interval) -> Self {
        let mut parameter = Dual::constant(value);
        parameter.slopes[index] = Interval::ONE;
        parameter
    }

    /// Narrows the value by the mean value form: `middle` is the number's value at the middle of the parameters' box, and `deviations` are the
    /// parameters' distances from that middle.
    pub fn around(self, middle: Interval, deviations: &[Interval; K]) -> Self {
        let terms = self.slopes.iter().zip(deviations).map(|(&slope, &deviation)| slope * deviation);
        Dual { value: terms.fold(middle, |sum, term| sum + term).intersect(self.value), ..self }
    }

    /// The value of a function of this number, given with its derivative over all values that the number may have.
    pub fn through(self, value: Interval, derivative: Interval) -> Self {
        let slope = |slope: Interval| if slope == Interval::ZERO { Interval::ZERO } else { slope * derivative };
        Dual { value, slopes: self.slopes.map(slope) }
    }

    /// The number with a value and, for each parameter, the sum of what two numbers' derivatives become by the functions given.
    fn combine(
        value: Interval,
        (a, of_a): (&Self, impl Fn(Interval) -> Interval),
        (b, of_b): (&Self, impl Fn(Interval) -> Interval),
    ) -> Self {
        let slopes = std::array::from_fn(|k| {
            // Many derivatives are zero, because most parameters enter a computation late; products with a zero derivative are left out.
            match (a.slopes[k] == Interval::ZERO, b.slopes[k] == Interval::ZERO) {
                (true, true) => Interval::ZERO,
                (false, true) => of_a(a.slopes[k]),
                (true, false) => of_b(b.slopes[k]),
                (false, false) => of_a(a.slopes[k]) + of_b(b.slopes[k]),
            }
        });
        Dual { value, slopes }
    }
}

/// A derivative times 1 or −1, rounded like any other product.
fn signed(slope: Interval, sign: f64) -> Interval {
    slope * sign
}

impl<const K: usize> Neg for Dual<K> {
    type Output = Self;
    fn neg(self) -> Self {
        Dual { value: -self.value, slopes: self.slopes.map(|slope| -slope) }
    }
}

impl<const K: usize> Add for Dual<K> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Dual::combine(
            self.value + other.value,
            (&self, |slope| signed(slope, 1.0)),
            (&other, |slope| signed(slope, 1.0)),
        )
    }
}

impl<const K: usize> Sub for Dual<K> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Dual::combine(
            self.value - other.value,
            (&self, |slope| signed(slope, 1.0)),
            (&other, |slope| signed(slope, -1.0)),
        )
    }
}

impl<const K: usize> Mul for Dual<K> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Dual::combine(
            self.value * other.value,
            (&self, |slope| slope * other.value),
            (&other, |slope| slope * self.value),
        )
    }
}

impl<const K: usize> Div for Dual<K> {
    type Output = Self;
    /// Quotient, with the derivatives (a/b)′ = a′/b − b′·(a/b)/b.
    fn div(self, other: Self) -> Self {
        let (value, inverse) = (self.value / other.value, other.value.recip());
        let of_divisor = -(value * inverse);
        Dual::combine(value, (&self, |slope| slope * inverse), (&other, |slope| slope * of_divisor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_of_what_moves_alike_is_known_by_its_slopes() {
        // Expected by hand: (x + 1) − x is 1 whatever x is. Interval arithmetic alone gives 1 ± 2; the derivative of the dual number, which is 0,
        // gives 1.
        let x = Dual::<1>::parameter(0, Interval::new(-1.0, 1.0));
        let apart = (x + Dual::constant(Interval::ONE)) - x;
        assert!(apart.value.width() > 3.9);
        let known = apart.around(Interval::ONE, &[Interval::new(-1.0, 1.0)]);
        assert!(known.value.contains(1.0) && known.value.width() < 1e-14, "{:?}", known.value);
    }

    #[test]
    fn a_function_of_a_number_has_derivatives_by_the_chain_rule() {
        // Expected by hand for f = (x·y)² at x = 3, y = 2: f = 36, ∂f/∂x = 2·6·2 = 24, ∂f/∂y = 2·6·3 = 36, and none by a third parameter.
        let (x, y) = (Dual::<3>::parameter(0, Interval::point(3.0)), Dual::<3>::parameter(1, Interval::point(2.0)));
        let product = x * y;
        let f = product.through(product.value.sqr(), product.value * 2.0);
        for (interval, expected) in [(f.value, 36.0), (f.slopes[0], 24.0), (f.slopes[1], 36.0), (f.slopes[2], 0.0)] {
            assert!(interval.contains(expected) && interval.width() < 1e-12, "{interval:?} {expected}");
        }
    }

    #[test]
    fn derivatives_of_a_quotient_contain_those_worked_out_by_hand() {
        // Expected by hand for f = (x·y − x)/y at x = 3, y = 2: f = 1.5, ∂f/∂x = (y − 1)/y = 0.5, ∂f/∂y = x/y² = 0.75.
        let (x, y) = (Dual::<2>::parameter(0, Interval::point(3.0)), Dual::<2>::parameter(1, Interval::point(2.0)));
        let f = (x * y - x) / y;
        for (interval, expected) in [(f.value, 1.5), (f.slopes[0], 0.5), (f.slopes[1], 0.75)] {
            assert!(interval.contains(expected) && interval.width() < 1e-14, "{interval:?} {expected}");
        }
    }
}
