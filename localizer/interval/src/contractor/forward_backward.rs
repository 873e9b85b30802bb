//! An equation becomes a contractor: enclose the formula forward, then contract each step backward.

use super::expression::{Expression, Program};
use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// f(x) ∈ range, for one formula of `N` variables.
///
/// **Constraint.** f(x) ∈ range, or f(x) ∈ what another contractor leaves ([`Inverse`]).
///
/// **Sound.** Forward, every step encloses its values at all points of the box; backward, every step removes only operands for
/// which no value of the result is left.
///
/// **Optimal** when each variable occurs once and all steps are continuous; otherwise the occurrences are treated as if they
/// were different variables, and a fixpoint or bisection helps.
///
/// **Source.** F. Benhamou, F. Goualard, L. Granvilliers, J.-F. Puget, "Revising hull and box consistency", ICLP 1999 (HC4-revise).
#[derive(Clone, Debug)]
pub struct ForwardBackward<const N: usize> {
    program: Program<N, 1>,
    range: IntervalBox<1>,
}

impl<const N: usize> ForwardBackward<N> {
    /// The points at which the formula's value is in `range`; `Interval::ZERO` for an equation.
    pub fn new(formula: impl for<'a> FnOnce([Expression<'a>; N]) -> Expression<'a>, range: Interval) -> Self {
        ForwardBackward { program: Program::record(|x| [formula(x)]), range: IntervalBox::new([range]) }
    }

    /// The same formula with another range.
    pub fn with_range(&self, range: Interval) -> Self {
        ForwardBackward { program: self.program.clone(), range: IntervalBox::new([range]) }
    }

    /// The interval that the value must be in.
    pub fn range(&self) -> Interval {
        self.range[0]
    }

    /// Encloses the formula's values on a box.
    pub fn evaluate(&self, domain: &IntervalBox<N>) -> Interval {
        self.program.outputs(&self.program.forward(domain))[0]
    }
}

impl<const N: usize> Contractor<N> for ForwardBackward<N> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let values = self.program.forward(domain);
        let left = self.program.backward(values, &self.range);
        settle(domain, left, "the formula cannot take a value in its range")
    }
}

/// f(x) satisfies a constraint on `M` variables: the inverse image of a set under a vector of formulas.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize, const M: usize, On> {
    program: Program<N, M>,
    on: On,
}

impl<const N: usize, const M: usize, On: Contractor<M>> Inverse<N, M, On> {
    /// The points whose image satisfies `on`.
    pub fn new(formulas: impl for<'a> FnOnce([Expression<'a>; N]) -> [Expression<'a>; M], on: On) -> Self {
        Inverse { program: Program::record(formulas), on }
    }
}

impl<const N: usize, const M: usize, On: Contractor<M>> Contractor<N> for Inverse<N, M, On> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let values = self.program.forward(domain);
        let mut image = self.program.outputs(&values);
        match self.on.contract(&mut image) {
            Outcome::Feasible => {
                let left = self.program.backward(values, &image);
                settle(domain, left, "no point has an allowed image")
            }
            Outcome::Empty(cause) => settle(domain, IntervalBox::EMPTY, cause),
        }
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        let values = self.program.forward(domain);
        let images = self.on.branches(&self.program.outputs(&values));
        images
            .iter()
            .map(|image| self.program.backward(values.clone(), image))
            .filter(|branch| !branch.is_empty())
            .collect()
    }
}
