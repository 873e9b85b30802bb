//! Contractor for the constraint that a point is in a fixed box.

use super::{Contractor, Outcome, settle};
use crate::IntervalBox;

/// The constraint that x is in a fixed box.
///
/// **Constraint.** x ∈ box.
///
/// **Sound** and **optimal**, because an intersection is exact.
///
/// **Source.** The definition. A measurement is a constraint of this form: the measured quantity is in the box. [`Inverse`](super::Inverse) turns
/// it into a constraint on the variables that the quantity is computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within<const N: usize>(pub IntervalBox<N>);

impl<const N: usize> Contractor<N> for Within<N> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let left = domain.intersect(&self.0);
        settle(domain, left, "the value is not in its box")
    }
}
