//! Membership of a box.

use super::{Contractor, Outcome, settle};
use crate::IntervalBox;

/// x ∈ box.
///
/// **Constraint.** x is in a fixed box.
///
/// **Sound** and **optimal**: an intersection is exact.
///
/// **Source.** The definition; it is what a
/// measurement says of the quantity measured, at the root of a forward-backward contractor ([`Inverse`](super::Inverse)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Within<const N: usize>(pub IntervalBox<N>);

impl<const N: usize> Contractor<N> for Within<N> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let left = domain.intersect(&self.0);
        settle(domain, left, "the value is not in its box")
    }
}
