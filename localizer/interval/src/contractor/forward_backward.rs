//! Contractors made from formulas: the formula is enclosed step by step forward, then each step is contracted backward.

use super::expression::{Expression, Program};
use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// The constraint that the value of a formula f of `N` variables is in an interval.
///
/// **Constraint.** f(x) ∈ range, or for [`Inverse`] f(x) ∈ the box that another contractor leaves.
///
/// **Sound.** Forward, every step encloses its values at all points of the box. Backward, every step removes only operands for which no value of
/// the result is left.
///
/// **Optimal** when each variable occurs once and all steps are continuous. Otherwise the occurrences of a variable are treated as if they were
/// different variables, and a fixpoint or bisection helps.
///
/// **Source.** F. Benhamou, F. Goualard, L. Granvilliers, J.-F. Puget, "Revising hull and box consistency", ICLP 1999 (HC4-revise).
#[derive(Clone, Debug)]
pub struct ForwardBackward<const N: usize> {
    program: Program<N, 1>,
    range: IntervalBox<1>,
}

impl<const N: usize> ForwardBackward<N> {
    /// A contractor for the points at which the formula's value is in `range`; `Interval::ZERO` states an equation.
    pub fn new(formula: impl for<'a> FnOnce([Expression<'a>; N]) -> Expression<'a>, range: Interval) -> Self {
        ForwardBackward { program: Program::record(|x| [formula(x)]), range: IntervalBox::new([range]) }
    }

    /// A contractor for this contractor's formula, with another interval of allowed values.
    pub fn with_range(&self, range: Interval) -> Self {
        ForwardBackward { program: self.program.clone(), range: IntervalBox::new([range]) }
    }

    /// The interval in which the formula's value must be.
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

/// Inverse image of a set under several formulas: the points x whose values f(x) satisfy a constraint on `M` variables.
#[derive(Clone, Debug)]
pub struct Inverse<const N: usize, const M: usize, On> {
    program: Program<N, M>,
    on: On,
}

impl<const N: usize, const M: usize, On: Contractor<M>> Inverse<N, M, On> {
    /// A contractor for the points whose image under the formulas satisfies the constraint `on`.
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
