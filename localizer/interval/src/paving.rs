//! Sets covered by boxes: those that are surely inside, those that are surely outside, and small ones that may cut the boundary.
//!
//! A paving comes about by set inversion (SIVIA): a separator decides what it can of a box, the rest is cut in two, and so on until boxes are as
//! small as wanted. [`Paving`] does so for sets with an inside, [`cover`] for the solutions of a contractor, which may be thin.
//!
//! Source: L. Jaulin, É. Walter, "Set inversion via interval analysis for nonlinear bounded-error estimation", Automatica 29
//! (1993); with contractors and separators, L. Jaulin, B. Desrochers (2014).
//!
//! ![Green boxes fill a disc with a hole and a wavy lower edge, small orange ones line its boundary, grey ones surround it](../../../../localizer/interval/examples/paving.png)
//!
//! *What `cargo run -p wherein-interval --example paving` draws: inside, undecided, outside.*

use std::collections::VecDeque;

use crate::contractor::Contractor;
use crate::separator::Separator;
use crate::{Interval, IntervalBox};

/// What is known of a set in a domain. The three lists together cover the domain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paving<const N: usize> {
    /// Every point is in the set.
    pub inner: Vec<IntervalBox<N>>,
    /// Undecided: no bisected side is wider than the resolution.
    pub boundary: Vec<IntervalBox<N>>,
    /// No point is in the set.
    pub outer: Vec<IntervalBox<N>>,
}

impl<const N: usize> Paving<N> {
    /// Smallest box around all that may be in the set.
    pub fn hull(&self) -> IntervalBox<N> {
        hull(self.inner.iter().chain(&self.boundary))
    }

    /// Paves a set: decides what the separator can, bisects the rest along the widest of `axes` until all of these are at most
    /// `resolution` wide.
    ///
    /// Variables that are not in `axes` are only contracted: the paving is of those that are.
    pub fn new(set: &impl Separator<N>, domain: IntervalBox<N>, axes: &[usize], resolution: f64) -> Self {
        let mut paving = Paving::default();
        let mut pending = vec![domain];
        while let Some(candidate) = pending.pop() {
            let (inside, outside) = set.separate(&candidate);
            // What the complement's contractor removed is in the set; what the set's contractor removed is not.
            difference(&candidate, &outside, &mut paving.inner);
            difference(&candidate, &inside, &mut paving.outer);
            let undecided = inside.intersect(&outside);
            if undecided.is_empty() {
                continue;
            }
            match axis_to_bisect(&undecided, axes, resolution) {
                Some(axis) => pending.extend(halves(&undecided, axis)),
                None => paving.boundary.push(undecided),
            }
        }
        paving
    }
}

/// Covers the solutions of a contractor with boxes that are at most `resolution` wide along `axes`.
///
/// Every solution in `domain` is in one of the boxes. Boxes are contracted, so that they are often much smaller.
pub fn cover<const N: usize>(
    constraint: &impl Contractor<N>,
    domain: IntervalBox<N>,
    axes: &[usize],
    resolution: f64,
) -> Vec<IntervalBox<N>> {
    let mut leaves = Vec::new();
    let mut pending = vec![domain];
    while let Some(mut candidate) = pending.pop() {
        constraint.contract(&mut candidate);
        if candidate.is_empty() {
            continue;
        }
        match axis_to_bisect(&candidate, axes, resolution) {
            Some(axis) => pending.extend(halves(&candidate, axis)),
            None => leaves.push(candidate),
        }
    }
    leaves
}

/// As [`cover`], but gives up after `most_boxes` contractions: what is pending then counts as leaves, however wide.
///
/// The oldest boxes are bisected first, so that the widest are never left over while smaller ones are cut.
pub fn cover_at_most<const N: usize>(
    constraint: &impl Contractor<N>,
    domain: IntervalBox<N>,
    axes: &[usize],
    resolution: f64,
    most_boxes: usize,
) -> Vec<IntervalBox<N>> {
    let mut leaves = Vec::new();
    let mut pending = VecDeque::from([domain]);
    for _ in 0..most_boxes {
        let Some(mut candidate) = pending.pop_front() else { break };
        constraint.contract(&mut candidate);
        if candidate.is_empty() {
            continue;
        }
        match axis_to_bisect(&candidate, axes, resolution) {
            Some(axis) => pending.extend(halves(&candidate, axis)),
            None => leaves.push(candidate),
        }
    }
    leaves.extend(pending);
    leaves
}

/// Smallest box around boxes; empty when there is none.
pub fn hull<'a, const N: usize>(boxes: impl IntoIterator<Item = &'a IntervalBox<N>>) -> IntervalBox<N> {
    boxes.into_iter().fold(IntervalBox::EMPTY, |hull, one| hull.hull(one))
}

/// The widest of `axes` if it is wider than the resolution.
fn axis_to_bisect<const N: usize>(candidate: &IntervalBox<N>, axes: &[usize], resolution: f64) -> Option<usize> {
    let widest = axes.iter().copied().max_by(|a, b| candidate.width(*a).total_cmp(&candidate.width(*b)))?;
    let component = candidate[widest];
    // An interval of two neighbouring doubles cannot be halved.
    let is_divisible = component.lo() < component.mid() && component.mid() < component.hi();
    (component.width() > resolution && is_divisible).then_some(widest)
}

fn halves<const N: usize>(candidate: &IntervalBox<N>, axis: usize) -> [IntervalBox<N>; 2] {
    let (left, right) = candidate.bisect(axis);
    [right, left]
}

/// Adds boxes that cover `whole` without `part`: one slab at most on each side of each axis.
fn difference<const N: usize>(whole: &IntervalBox<N>, part: &IntervalBox<N>, slabs: &mut Vec<IntervalBox<N>>) {
    if part.is_empty() {
        slabs.push(*whole);
        return;
    }
    let mut rest = *whole;
    for axis in 0..N {
        let (outer, kept) = (rest[axis], part[axis]);
        if outer.lo() < kept.lo() {
            let mut slab = rest;
            slab[axis] = Interval::new(outer.lo(), kept.lo());
            slabs.push(slab);
        }
        if kept.hi() < outer.hi() {
            let mut slab = rest;
            slab[axis] = Interval::new(kept.hi(), outer.hi());
            slabs.push(slab);
        }
        rest[axis] = kept;
    }
}
