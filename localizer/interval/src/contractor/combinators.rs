//! Contractors made of other contractors: conjunction, disjunction, repetition, and a change of variables.
//!
//! Source: G. Chabert, L. Jaulin, "Contractor programming", Artificial Intelligence 173 (2009). Each combination is sound (loses no solution) when
//! its parts are. None of them is optimal (leaves the smallest box possible) even if its parts are, because a box cannot express how its sides
//! depend on each other.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// Conjunction of two contractors: x ∈ A and x ∈ B. Sound, because a solution of both constraints survives each contraction in turn.
#[derive(Clone, Debug)]
pub struct Then<First, Next> {
    pub(super) first: First,
    pub(super) next: Next,
}

impl<const N: usize, First: Contractor<N>, Next: Contractor<N>> Contractor<N> for Then<First, Next> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        match self.first.contract(domain) {
            Outcome::Feasible => self.next.contract(domain),
            empty => empty,
        }
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        self.first.branches(domain).iter().flat_map(|branch| self.next.branches(branch)).collect()
    }
}

/// Disjunction of two contractors: x ∈ A or x ∈ B. Sound, because a solution of either constraint survives in that constraint's part of the
/// hull.
#[derive(Clone, Debug)]
pub struct Union<Either, Or> {
    pub(super) either: Either,
    pub(super) or: Or,
}

impl<const N: usize, Either: Contractor<N>, Or: Contractor<N>> Contractor<N> for Union<Either, Or> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let (mut one, mut other) = (*domain, *domain);
        let outcome = self.either.contract(&mut one);
        self.or.contract(&mut other);
        let cause = match outcome {
            Outcome::Empty(cause) => cause,
            Outcome::Feasible => "",
        };
        settle(domain, one.hull(&other), cause)
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        let mut branches = self.either.branches(domain);
        branches.extend(self.or.branches(domain));
        branches
    }
}

/// A contractor that is applied repeatedly. Sound, because every application is. It ends, because it continues only while some width of the box
/// shrinks by more than the fraction `ratio`, and stops after [`Fixpoint::MOST_PASSES`] at the latest.
#[derive(Clone, Debug)]
pub struct Fixpoint<Inner> {
    pub(super) contractor: Inner,
    pub(super) ratio: f64,
}

impl Fixpoint<()> {
    /// Greatest number of times that [`Fixpoint`] applies its contractor. Where convergence is slow, each further pass gains less; bisection is
    /// then the better tool.
    pub const MOST_PASSES: usize = 1000;
}

impl<const N: usize, Inner: Contractor<N>> Contractor<N> for Fixpoint<Inner> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        for _ in 0..Fixpoint::MOST_PASSES {
            let before = *domain;
            let outcome = self.contractor.contract(domain);
            if outcome != Outcome::Feasible {
                return outcome;
            }
            if !shrank(&before, domain, self.ratio) {
                break;
            }
        }
        Outcome::Feasible
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        let mut contracted = *domain;
        if self.contract(&mut contracted) != Outcome::Feasible {
            return Vec::new();
        }
        self.contractor.branches(&contracted)
    }
}

/// Whether some side of the box `after` is narrower than that of `before` by more than the fraction `ratio` of its width.
fn shrank<const N: usize>(before: &IntervalBox<N>, after: &IntervalBox<N>, ratio: f64) -> bool {
    before.iter().zip(after).any(|(&old, &new)| narrowed(old, new, ratio))
}

/// Whether the interval `new` is narrower than `old` by more than the fraction `ratio` of its width.
pub(super) fn narrowed(old: Interval, new: Interval, ratio: f64) -> bool {
    let (old_width, new_width) = (old.width(), new.width());
    // Any narrowing of an unbounded interval counts, because its width may stay infinite: ∞ · (1 − ratio) is still ∞.
    new_width < (1.0 - ratio) * old_width || (old_width.is_infinite() && old != new)
}

/// A constraint on `M` of a box's `N` variables, given by a contractor for these `M` variables. Sound, and as tight as that contractor, because the
/// other variables stay untouched.
#[derive(Clone, Debug)]
pub struct OnAxes<Inner, const M: usize> {
    pub(super) contractor: Inner,
    pub(super) axes: [usize; M],
}

impl<Inner, const M: usize> OnAxes<Inner, M> {
    fn select<const N: usize>(&self, domain: &IntervalBox<N>) -> IntervalBox<M> {
        IntervalBox::new(self.axes.map(|axis| domain[axis]))
    }

    fn replace<const N: usize>(&self, domain: &IntervalBox<N>, selected: &IntervalBox<M>) -> IntervalBox<N> {
        let mut replaced = *domain;
        for (axis, component) in self.axes.iter().zip(selected) {
            replaced[*axis] = replaced[*axis].intersect(*component);
        }
        replaced
    }
}

impl<const N: usize, const M: usize, Inner: Contractor<M>> Contractor<N> for OnAxes<Inner, M> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        let mut selected = self.select(domain);
        match self.contractor.contract(&mut selected) {
            Outcome::Feasible => {
                let left = self.replace(domain, &selected);
                settle(domain, left, "no solution on the chosen axes")
            }
            Outcome::Empty(cause) => settle(domain, IntervalBox::EMPTY, cause),
        }
    }

    fn branches(&self, domain: &IntervalBox<N>) -> Vec<IntervalBox<N>> {
        let branches = self.contractor.branches(&self.select(domain));
        branches.iter().map(|branch| self.replace(domain, branch)).filter(|branch| !branch.is_empty()).collect()
    }
}
