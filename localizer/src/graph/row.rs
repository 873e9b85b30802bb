//! A row of the graph's linear program.

use interval::Interval;

use super::{Domain, Variable};

/// A linear row: the sum of coefficients times deviations from reference values is within an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Quantities, each with the coefficient of its deviation from the reference value.
    pub terms: Vec<(Variable, f64)>,
    /// The interval that the sum is within.
    pub sides: Interval,
}

impl Row {
    /// The row that follows from coefficients that are known as intervals only: Σ aⱼ δⱼ ∈ `sides` for some aⱼ in their intervals.
    ///
    /// The middle of each interval becomes the coefficient, and the rest times the possible deviations is added to the sides.
    pub(super) fn new(domain: &Domain, terms: &[(Variable, Interval)], sides: Interval) -> Row {
        let mut row = Row { terms: Vec::with_capacity(terms.len()), sides };
        for &(variable, coefficient) in terms {
            let deviation = domain.deviation(variable);
            if deviation == Interval::ZERO {
                continue;
            }
            let middle = coefficient.mid();
            row.sides -= (coefficient - Interval::point(middle)) * deviation;
            match row.terms.iter_mut().find(|(other, _)| *other == variable) {
                // Two coefficients of one quantity are added up; the rounding error of the sum goes to the sides, too.
                Some((_, sum)) => {
                    let both = Interval::point(*sum) + Interval::point(middle);
                    *sum += middle;
                    row.sides -= (both - Interval::point(*sum)) * deviation;
                }
                None => row.terms.push((variable, middle)),
            }
        }
        row
    }

    /// Interval of the row's left side less its sides' middle at the given deviations; for tests.
    #[cfg(test)]
    pub(super) fn value_at(&self, deviation: impl Fn(Variable) -> f64) -> f64 {
        self.terms.iter().map(|&(variable, coefficient)| coefficient * deviation(variable)).sum()
    }
}

/// Enclosure of sin δ − δ for all δ in an interval: at most Δ³/6 in size, with Δ the greatest |δ|.
pub(super) fn sine_rest(delta: Interval) -> Interval {
    let most = Interval::point(delta.magnitude());
    Interval::ZERO.hull(most * most * most / 6.0).hull(-(most * most * most / 6.0))
}

/// Enclosure of 1 − cos δ for all δ in an interval: between 0 and Δ²/2, with Δ the greatest |δ|.
pub(super) fn cosine_rest(delta: Interval) -> Interval {
    let most = Interval::point(delta.magnitude());
    Interval::ZERO.hull(most * most / 2.0)
}

/// Unit vectors (cos φ, sin φ) and, to its left, (−sin φ, cos φ).
pub(super) fn axes(direction: Interval) -> [[Interval; 2]; 2] {
    let (cosine, sine) = (direction.cos(), direction.sin());
    [[cosine, sine], [-sine, cosine]]
}

pub(super) fn dot(a: [Interval; 2], b: [Interval; 2]) -> Interval {
    a[0] * b[0] + a[1] * b[1]
}
