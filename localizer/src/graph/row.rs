//! A row of the graph's linear program.

use interval::Interval;

use crate::bounds::Assumption;

use super::{Domain, Variable};

/// A linear row: the sum of coefficients times deviations from reference values is within an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Quantities, each with the coefficient of its deviation from the reference value.
    pub terms: Vec<(Variable, f64)>,
    /// The interval that the sum is within.
    pub sides: Interval,
    /// What of the half width of the sides comes from which declared bound. The rest is what the row loses by linearisation, and what has no name,
    /// such as quantisation. Parts only explain the row; no bound of a quantity depends on them.
    pub parts: Vec<(Assumption, f64)>,
    /// Names of the devices whose readings the row comes from.
    pub devices: Vec<&'static str>,
}

impl Row {
    /// The row that follows from coefficients that are known as intervals only: Σ aⱼ δⱼ ∈ `sides` for some aⱼ in their intervals.
    ///
    /// The middle of each interval becomes the coefficient, and the rest times the possible deviations is added to the sides.
    pub(crate) fn new(domain: &Domain, terms: &[(Variable, Interval)], sides: Interval) -> Row {
        let mut row = Row { terms: Vec::with_capacity(terms.len()), sides, parts: Vec::new(), devices: Vec::new() };
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

    /// The same row with a further part of its sides that a declared bound makes.
    pub(crate) fn with_part(mut self, bound: Assumption, half: f64) -> Row {
        match self.parts.iter_mut().find(|(other, _)| *other == bound) {
            Some((_, sum)) => *sum += half,
            None if half > 0.0 => self.parts.push((bound, half)),
            None => {}
        }
        self
    }

    /// The same row with further parts, each `times` as large as given.
    pub(super) fn with_parts(self, times: f64, parts: &[(Assumption, f64)]) -> Row {
        parts.iter().fold(self, |row, &(bound, half)| row.with_part(bound, times * half))
    }

    /// The same row, of which a share of the part that one declared bound makes is made by another one.
    pub(crate) fn with_share_of(mut self, bound: Assumption, by: Assumption, share: f64) -> Row {
        let Some((_, half)) = self.parts.iter_mut().find(|(other, _)| *other == bound) else { return self };
        let moved = *half * share;
        *half -= moved;
        self.with_part(by, moved)
    }

    /// The same row, which comes from readings of the device with the given name, too.
    pub(crate) fn by_device(mut self, device: &'static str) -> Row {
        if !self.devices.contains(&device) {
            self.devices.push(device);
        }
        self
    }

    /// The same row for the values of the quantities in place of their deviations: it holds whatever the reference values.
    pub(super) fn in_values(&self, domain: &Domain) -> Row {
        Row { sides: self.sides + self.at_reference(domain), ..self.clone() }
    }

    /// A row in values as a row in the deviations from the domain's reference values.
    pub(super) fn about(&self, domain: &Domain) -> Row {
        Row { sides: self.sides - self.at_reference(domain), ..self.clone() }
    }

    fn at_reference(&self, domain: &Domain) -> Interval {
        let parts = self.terms.iter().map(|&(variable, a)| Interval::point(domain.reference(variable)) * a);
        parts.fold(Interval::ZERO, |sum, part| sum + part)
    }

    /// Coefficient of a quantity.
    pub(super) fn coefficient(&self, variable: Variable) -> f64 {
        self.terms.iter().find(|(other, _)| *other == variable).map_or(0.0, |&(_, coefficient)| coefficient)
    }

    /// The sum of multiples of rows in values. What is left of quantities that are dropped is enclosed over their intervals, and so are the rounding
    /// errors of the coefficients. Parts add up; the bound of a dropped quantity makes a part, too.
    pub(super) fn sum(rows: &[(f64, &Row)], dropped: impl Fn(Variable) -> bool, domain: &Domain) -> Row {
        let mut coefficients: Vec<(Variable, Interval)> = Vec::new();
        let mut sides = Interval::ZERO;
        for &(times, row) in rows {
            sides += row.sides * times;
            for &(variable, a) in &row.terms {
                let part = Interval::point(a) * times;
                match coefficients.iter_mut().find(|(other, _)| *other == variable) {
                    Some((_, sum)) => *sum += part,
                    None => coefficients.push((variable, part)),
                }
            }
        }
        let labels = Row { terms: Vec::new(), sides, parts: Vec::new(), devices: Vec::new() };
        let mut sum = rows.iter().fold(labels, |sum, &(times, row)| {
            row.devices.iter().fold(sum.with_parts(times.abs(), &row.parts), |sum, &device| sum.by_device(device))
        });
        for (variable, coefficient) in coefficients {
            let kept = if dropped(variable) { 0.0 } else { coefficient.mid() };
            if let Some(bound) = variable.bound().filter(|_| dropped(variable)) {
                sum = sum.with_part(bound, coefficient.magnitude() * domain.value(variable).radius());
            }
            sum.sides -= (coefficient - Interval::point(kept)) * domain.value(variable);
            if kept != 0.0 {
                sum.terms.push((variable, kept));
            }
        }
        sum
    }

    /// Half of the width of the sides that declared bounds make; for tests.
    #[cfg(test)]
    pub(crate) fn named_half(&self) -> f64 {
        self.parts.iter().map(|(_, half)| half).sum()
    }

    /// Interval of the row's left side less its sides' middle at the given deviations; for tests.
    #[cfg(test)]
    pub(crate) fn value_at(&self, deviation: impl Fn(Variable) -> f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Constant;

    #[test]
    fn an_uncertain_coefficient_widens_the_sides() {
        let (track, yaw) = (Variable::Constant(Constant::Track), Variable::Constant(Constant::RangeYaw));
        let mut domain = Domain::default();
        domain.put(track, Interval::new(9.5, 10.5));
        domain.put(yaw, Interval::point(3.0));
        // Some a in [1, 3] times a deviation of at most 1/2 is 0: twice the deviation is then at most 1/2 away from 0. The yaw has no deviation.
        let row = Row::new(&domain, &[(track, Interval::new(1.0, 3.0)), (yaw, Interval::point(7.0))], Interval::ZERO);
        assert_eq!(row.terms, [(track, 2.0)]);
        assert!(row.sides.contains(-0.5) && row.sides.contains(0.5) && row.sides.width() < 1.0 + 1e-9, "{}", row.sides);
        // Coefficients of one quantity add up.
        let twice =
            Row::new(&domain, &[(track, Interval::point(1.0)), (track, Interval::new(1.0, 2.0))], Interval::ZERO);
        assert_eq!(twice.terms, [(track, 2.5)]);
        assert!(twice.sides.contains(0.25) && twice.sides.width() < 0.5 + 1e-9, "{}", twice.sides);
    }

    #[test]
    fn a_quantity_that_a_sum_drops_is_enclosed_over_its_interval() {
        // a + 2b = 5 and c − b = 1, with b in [1, 2]: the sum a + b + c is 6, so that a + c is in [4, 5].
        let [a, b, c] = [0, 1, 2].map(|frame| Variable::Pose(frame, 0));
        let mut domain = Domain::default();
        domain.put(b, Interval::new(1.0, 2.0));
        [a, c].into_iter().for_each(|kept| domain.put(kept, Interval::new(-10.0, 10.0)));
        let row = |terms: &[(Variable, f64)], side: f64| Row {
            terms: terms.to_vec(),
            sides: Interval::point(side),
            parts: Vec::new(),
            devices: Vec::new(),
        };
        let (first, second) = (row(&[(a, 1.0), (b, 2.0)], 5.0), row(&[(c, 1.0), (b, -1.0)], 1.0));
        let sum = Row::sum(&[(1.0, &first), (1.0, &second)], |variable| variable == b, &domain);
        assert_eq!(sum.terms, [(a, 1.0), (c, 1.0)]);
        assert!(sum.sides.contains(4.0) && sum.sides.contains(5.0) && sum.sides.width() < 1.0 + 1e-9, "{}", sum.sides);
    }

    #[test]
    fn the_rests_of_sine_and_cosine_are_enclosed_closely() {
        for most in [1e-3, 0.02, 0.5_f64] {
            let (sine, cosine) = (sine_rest(Interval::centred(0.0, most)), cosine_rest(Interval::centred(0.0, most)));
            for share in [-1.0, -0.3, 0.0, 0.7, 1.0] {
                let delta: f64 = share * most;
                assert!(sine.contains(delta.sin() - delta) && cosine.contains(1.0 - delta.cos()), "{delta}");
            }
            assert!(sine.magnitude() < 1.02 * (most - most.sin()) + 1e-15, "{sine}");
            assert!(cosine.magnitude() < 1.03 * (1.0 - most.cos()) + 1e-15, "{cosine}");
        }
    }
}
