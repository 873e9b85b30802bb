//! Separators: a set and its complement, each with a contractor, so that a box can be proven to be inside, outside or neither.
//!
//! A contractor alone can only prove that a box is outside of its set, by leaving the box empty. A separator has a second contractor for all
//! points that are not in the set, which proves in the same way that a box is inside. Sets combine by `and`, `or` and `complement`.
//!
//! Source: L. Jaulin, B. Desrochers, "Introduction to the algebra of separators with application to path planning", Engineering Applications of
//! Artificial Intelligence 33 (2014).

use crate::contractor::{Contractor, ForwardBackward};
use crate::{Interval, IntervalBox};

/// A set of points with which boxes can be compared.
///
/// Law: with (inside, outside) = `separate(domain)`, every point of the domain that is in the set is in `inside`, and every other point of the
/// domain is in `outside`. Both boxes are subsets of the domain and may share the set's boundary.
pub trait Separator<const N: usize> {
    /// Returns the part of `domain` that may be in the set, and the part that may be outside of the set.
    fn separate(&self, domain: &IntervalBox<N>) -> (IntervalBox<N>, IntervalBox<N>);

    /// Separator of the intersection of two sets.
    fn and<Other: Separator<N>>(self, other: Other) -> And<Self, Other>
    where
        Self: Sized,
    {
        And { one: self, other }
    }

    /// Separator of the union of two sets.
    fn or<Other: Separator<N>>(self, other: Other) -> Complement<And<Complement<Self>, Complement<Other>>>
    where
        Self: Sized,
    {
        // De Morgan's law: the union is the complement of the intersection of both complements.
        self.complement().and(other.complement()).complement()
    }

    /// Separator of the set's complement.
    fn complement(self) -> Complement<Self>
    where
        Self: Sized,
    {
        Complement { of: self }
    }
}

/// A separator made of two contractors: one for the points of a set and one for all other points.
#[derive(Clone, Debug)]
pub struct ContractorPair<Inside, Outside> {
    /// Contractor that removes points that are not in the set.
    pub keeps_inside: Inside,
    /// Contractor that removes points that are in the set.
    pub keeps_outside: Outside,
}

impl<const N: usize, Inside: Contractor<N>, Outside: Contractor<N>> Separator<N> for ContractorPair<Inside, Outside> {
    fn separate(&self, domain: &IntervalBox<N>) -> (IntervalBox<N>, IntervalBox<N>) {
        let (mut inside, mut outside) = (*domain, *domain);
        self.keeps_inside.contract(&mut inside);
        self.keeps_outside.contract(&mut outside);
        (inside, outside)
    }
}

/// The set { x : f(x) ∈ range } needs no more than its formula to be a separator: outside of the set, f(x) is below or above the range.
///
/// Both contractions remove points at which the formula has no value, so the formula has to be defined on the whole domain.
impl<const N: usize> Separator<N> for ForwardBackward<N> {
    fn separate(&self, domain: &IntervalBox<N>) -> (IntervalBox<N>, IntervalBox<N>) {
        let part = |range: Interval| {
            let mut part = *domain;
            self.with_range(range).contract(&mut part);
            part
        };
        let range = self.range();
        let below = part(Interval::new(f64::NEG_INFINITY, range.lo()));
        let above = part(Interval::new(range.hi(), f64::INFINITY));
        (part(range), below.hull(&above))
    }
}

/// Separator of the intersection of two sets.
#[derive(Clone, Debug)]
pub struct And<One, Other> {
    one: One,
    other: Other,
}

impl<const N: usize, One: Separator<N>, Other: Separator<N>> Separator<N> for And<One, Other> {
    fn separate(&self, domain: &IntervalBox<N>) -> (IntervalBox<N>, IntervalBox<N>) {
        let (inside_one, outside_one) = self.one.separate(domain);
        let (inside_other, outside_other) = self.other.separate(domain);
        (inside_one.intersect(&inside_other), outside_one.hull(&outside_other))
    }
}

/// Separator of the complement of a set.
#[derive(Clone, Debug)]
pub struct Complement<Of> {
    of: Of,
}

impl<const N: usize, Of: Separator<N>> Separator<N> for Complement<Of> {
    fn separate(&self, domain: &IntervalBox<N>) -> (IntervalBox<N>, IntervalBox<N>) {
        let (inside, outside) = self.of.separate(domain);
        (outside, inside)
    }
}
