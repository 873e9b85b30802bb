//! One verb, `contract`: shrink a box without losing a solution.

use crate::IntervalBox;

/// What a contraction found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The box is not empty; it may have shrunk.
    Feasible,
    /// No point of the box satisfies the constraint; the text names the cause.
    Empty(&'static str),
}

/// A constraint on `N` variables that can shrink boxes.
///
/// Laws: the result is a subset of the domain, and every point of the domain that satisfies the constraint is in it.
pub trait Contractor<const N: usize> {
    /// Shrinks `domain`; sets it to the empty box when no solution is left.
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome;

    /// Shrinks `domain` to boxes that may be disjoint; their union keeps every solution. None is empty.
    ///
    /// A constraint with several solutions far apart (periodic joints, quadrants) overrides this, so that nothing between is kept.
    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        let mut contracted = *domain;
        match self.contract(&mut contracted) {
            Outcome::Feasible => vec![contracted],
            Outcome::Empty(_) => Vec::new(),
        }
    }
}
