//! Contractors: constraints that make boxes smaller without losing a solution. Their one operation is `contract`.
//!
//! A contractor stands for a constraint on some variables. Given a box of possible values of these variables, it removes points that violate the
//! constraint, as many as it can detect, and no other points. The box that is left still holds every solution that was in it.
//!
//! | constraint | contractor |
//! |---|---|
//! | the value of a formula is in an interval | [`ForwardBackward`]; for several formulas whose values satisfy another contractor, [`Inverse`] |
//! | the variables are in a fixed box | [`Within`] |
//! | a point is at a known distance from a place | [`Distance`] |
//! | Cartesian and polar coordinates describe the same vector | [`Polar`] |
//! | a coordinate is on one of equally spaced lines | [`Periodic`] |
//! | a point in space is seen at a pixel of a picture | [`Pinhole`] |
//! | all constraints hold but at most q | [`QRelaxed`] |
//! | all constraints of a network hold, on any number of variables that come and go | [`Network`] |
//! | both of two constraints hold, or at least one of them | [`then`](Contractor::then), [`union`](Contractor::union) |
//! | one constraint, applied repeatedly or to other axes | [`fixpoint`](Contractor::fixpoint), [`on_axes`](Contractor::on_axes) |
//!
//! A contractor of your own implements [`Contractor`], and its `contract` ends with a call of [`settle`].
//!
//! ```
//! use interval::contractor::{Contractor, ForwardBackward};
//! use interval::{Interval, IntervalBox};
//!
//! // An equation becomes a contractor: x² + y² ∈ [1, 4] …
//! let ring = ForwardBackward::new(|[x, y]| x.sqr() + y.sqr(), Interval::new(1.0, 4.0));
//! // … and contractors combine: x = y holds too, and both are applied until the box shrinks no more.
//! let diagonal = ForwardBackward::new(|[x, y]| x - y, Interval::ZERO);
//! let both = ring.then(diagonal).fixpoint(1e-6);
//! let mut domain = IntervalBox::new([Interval::new(0.0, 9.0), Interval::new(-9.0, 9.0)]);
//! both.contract(&mut domain);
//! // y was known to be in [−9, 9]; the ring, x = y and x ≥ 0 leave [0, 2].
//! assert!(domain[1].is_subset_of(Interval::new(-1e-9, 2.0 + 1e-9)));
//! ```

mod combinators;
mod distance;
mod expression;
mod forward_backward;
mod network;
mod periodic;
mod pinhole;
mod polar;
mod q_relaxed;
mod within;

pub use combinators::{Fixpoint, OnAxes, Then, Union};
pub use distance::Distance;
pub use expression::Expression;
pub use forward_backward::{ForwardBackward, Inverse};
pub use network::{ContractorId, Network, UnknownVariable, VariableId};
pub use periodic::Periodic;
pub use pinhole::Pinhole;
pub use polar::Polar;
pub use q_relaxed::{QRelaxed, q_intersection};
pub use within::Within;

use crate::IntervalBox;

/// Result of a contraction: whether the box still has points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The box is not empty after the contraction; it may have shrunk.
    Feasible,
    /// No point of the box satisfies the constraint. The text names the cause.
    Empty(&'static str),
}

/// A constraint on `N` variables that can shrink boxes of these variables.
///
/// Laws of every implementation: the contracted box is a subset of the domain given, and every point of the domain that satisfies the constraint
/// is in it.
pub trait Contractor<const N: usize> {
    /// Shrinks the box `domain` by the constraint; sets it to the empty box when no solution is left.
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome;

    /// Shrinks the box `domain` to several boxes, which may be disjoint. Their union keeps every solution, and none of them is empty.
    ///
    /// A constraint whose solutions lie far apart (periodic joints, quadrants of an angle) overrides this method, so that nothing between the
    /// solutions is kept.
    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        let mut contracted = *domain;
        match self.contract(&mut contracted) {
            Outcome::Feasible => vec![contracted],
            Outcome::Empty(_) => Vec::new(),
        }
    }

    /// A contractor for both of two constraints: it applies this one first, then `next` to the box that is left.
    fn then<Next: Contractor<N>>(self, next: Next) -> Then<Self, Next>
    where
        Self: Sized,
    {
        Then { first: self, next }
    }

    /// A contractor for at least one of two constraints: it leaves the hull of the boxes that each of them leaves.
    fn union<Other: Contractor<N>>(self, other: Other) -> Union<Self, Other>
    where
        Self: Sized,
    {
        Union { either: self, or: other }
    }

    /// A contractor that applies this one repeatedly, until no width of the box shrinks by more than the fraction `ratio` of itself.
    fn fixpoint(self, ratio: f64) -> Fixpoint<Self>
    where
        Self: Sized,
    {
        Fixpoint { contractor: self, ratio }
    }

    /// The same constraint on a box that has more variables: `axes[i]` is the index in that box of this contractor's variable i.
    fn on_axes(self, axes: [usize; N]) -> OnAxes<Self, N>
    where
        Self: Sized,
    {
        OnAxes { contractor: self, axes }
    }
}

impl<const N: usize, C: Contractor<N> + ?Sized> Contractor<N> for Box<C> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        (**self).contract(domain)
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        (**self).branches(domain)
    }
}

impl<const N: usize, C: Contractor<N> + ?Sized> Contractor<N> for &C {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        (**self).contract(domain)
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        (**self).branches(domain)
    }
}

/// Replaces `domain` by the box `left` that a contraction has left of it, and returns whether that box has points; `cause` names why it may be
/// empty.
pub fn settle<const N: usize>(domain: &mut IntervalBox<N>, left: IntervalBox<N>, cause: &'static str) -> Outcome {
    if left.is_empty() {
        *domain = IntervalBox::EMPTY;
        Outcome::Empty(cause)
    } else {
        *domain = left;
        Outcome::Feasible
    }
}
