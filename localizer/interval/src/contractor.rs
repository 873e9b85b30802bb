//! Constraints that make boxes smaller without losing a solution. One verb, `contract`.
//!
//! A contractor stands for a constraint on some variables. Given a box of what these may be, it takes away points that violate the
//! constraint, as many as it can tell, and no other ones. What is left of the box still holds every solution that was in it.
//!
//! | constraint | contractor |
//! |---|---|
//! | a formula of the variables is in an interval | [`ForwardBackward`]; several formulas, and what another contractor leaves of them, [`Inverse`] |
//! | the variables are in a fixed box | [`Within`] |
//! | a point is at a known distance from a place | [`Distance`] |
//! | Cartesian and polar coordinates are of one vector | [`Polar`] |
//! | a coordinate is on one of equally spaced lines | [`Periodic`] |
//! | a point in space is seen at a place of a picture | [`Pinhole`] |
//! | all constraints hold but at most q | [`QRelaxed`] |
//! | both, either, the same again, the same on other axes | [`then`](Contractor::then), [`union`](Contractor::union), [`fixpoint`](Contractor::fixpoint), [`on_axes`](Contractor::on_axes) |
//!
//! A contractor of your own implements [`Contractor`], and ends with [`settle`].
//!
//! ```
//! use interval::contractor::{Contractor, ForwardBackward};
//! use interval::{Interval, IntervalBox};
//!
//! // An equation becomes a contractor: x² + y² ∈ [1, 4] …
//! let ring = ForwardBackward::new(|[x, y]| x.sqr() + y.sqr(), Interval::new(1.0, 4.0));
//! // … and contractors combine: also x = y, again and again until nothing moves.
//! let diagonal = ForwardBackward::new(|[x, y]| x - y, Interval::ZERO);
//! let both = ring.then(diagonal).fixpoint(1e-6);
//! let mut domain = IntervalBox::new([Interval::new(0.0, 9.0), Interval::new(-9.0, 9.0)]);
//! both.contract(&mut domain);
//! // y was known to ±9; the ring and x ≥ 0 leave 0 to 2.
//! assert!(domain[1].is_subset_of(Interval::new(-1e-9, 2.0 + 1e-9)));
//! ```

mod combinators;
mod distance;
mod expression;
mod forward_backward;
mod periodic;
mod pinhole;
mod polar;
mod q_relaxed;
mod within;

pub use combinators::{Fixpoint, OnAxes, Then, Union};
pub use distance::Distance;
pub use expression::Expression;
pub use forward_backward::{ForwardBackward, Inverse};
pub use periodic::Periodic;
pub use pinhole::Pinhole;
pub use polar::Polar;
pub use q_relaxed::{QRelaxed, q_intersection};
pub use within::Within;

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

    /// Both constraints: this one first, then `next` on what is left.
    fn then<Next: Contractor<N>>(self, next: Next) -> Then<Self, Next>
    where
        Self: Sized,
    {
        Then { first: self, next }
    }

    /// Either constraint: the hull of what each leaves.
    fn union<Other: Contractor<N>>(self, other: Other) -> Union<Self, Other>
    where
        Self: Sized,
    {
        Union { either: self, or: other }
    }

    /// The same constraint, applied until no width shrinks by more than the share `ratio` of it.
    fn fixpoint(self, ratio: f64) -> Fixpoint<Self>
    where
        Self: Sized,
    {
        Fixpoint { contractor: self, ratio }
    }

    /// The same constraint on `M` variables, of which `axes` are this contractor's, in its order.
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

/// Replaces `domain` by what a contraction left of it, and says whether that is anything; `cause` names why it may be nothing.
pub fn settle<const N: usize>(domain: &mut IntervalBox<N>, left: IntervalBox<N>, cause: &'static str) -> Outcome {
    if left.is_empty() {
        *domain = IntervalBox::EMPTY;
        Outcome::Empty(cause)
    } else {
        *domain = left;
        Outcome::Feasible
    }
}
