//! Contractor for membership of a fixed box.

use super::{Contractor, Outcome, settle};
use crate::IntervalBox;

/// The constraint that x is in a fixed box.
///
/// **Constraint.** x ∈ box.
///
/// **Sound** and **optimal**, because an intersection is exact.
///
/// **Source.** The definition. What a measurement says of the measured quantity has this form, at the root of a forward-backward contractor
/// ([`Inverse`](super::Inverse)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within<const N: usize>(pub IntervalBox<N>);

impl<const N: usize> Contractor<N> for Within<N> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let left = domain.intersect(&self.0);
        settle(domain, left, "the value is not in its box")
    }
}
