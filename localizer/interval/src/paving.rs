//! Pavings: sets covered by boxes that are surely inside, boxes that are surely outside, and small boxes that may cut the boundary.
//!
//! A paving is made by set inversion (SIVIA): a separator decides what it can of a box, the rest is cut in two, and so on until the boxes are as
//! small as wanted. [`Paving`] does that for sets with an interior, [`cover`] for the solutions of a contractor, which may be a thin set.
//!
//! Source: L. Jaulin, É. Walter, "Set inversion via interval analysis for nonlinear bounded-error estimation", Automatica 29 (1993); with
//! contractors and separators, L. Jaulin, B. Desrochers (2014).
//!
//! ![Green boxes fill a disc with a hole and a wavy lower edge, small orange ones line its boundary, grey ones surround
//! it](../../../../localizer/interval/examples/paving.png)
//!
//! *The picture that `cargo run -p wherein-interval --example paving` draws, of boxes inside, undecided and outside.*

use std::collections::VecDeque;

use crate::contractor::Contractor;
use crate::separator::Separator;
use crate::{Interval, IntervalBox};

/// Lists of boxes that say which parts of a domain are in a set. The three lists together cover the domain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paving<const N: usize> {
    /// Boxes of which every point is in the set.
    pub inner: Vec<IntervalBox<N>>,
    /// Undecided boxes, which may cut the set's boundary. None of their bisected sides is wider than the resolution.
    pub boundary: Vec<IntervalBox<N>>,
    /// Boxes of which no point is in the set.
    pub outer: Vec<IntervalBox<N>>,
}

impl<const N: usize> Paving<N> {
    /// Smallest box around all points of the domain that may be in the set.
    pub fn hull(&self) -> IntervalBox<N> {
        hull(self.inner.iter().chain(&self.boundary))
    }

    /// Paves a set: the separator decides what it can of each box, and the rest is bisected along the widest of `axes`, until all of these axes
    /// are at most `resolution` wide.
    ///
    /// Variables that are not in `axes` are contracted but never bisected, so the boxes become small along the listed axes only.
    pub fn new(set: &impl Separator<N>, domain: IntervalBox<N>, axes: &[usize], resolution: f64) -> Self {
        let mut paving = Paving::default();
        let mut pending = vec![domain];
        while let Some(candidate) = pending.pop() {
            let (inside, outside) = set.separate(&candidate);
            // Points that the complement's contractor removed are in the set; points that the set's contractor removed are not.
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

/// Covers the solutions of a contractor's constraint with boxes that are at most `resolution` wide along `axes`.
///
/// Every solution in `domain` is in one of the boxes. The boxes are contracted, so that they are often much smaller than the resolution.
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

/// Covers the solutions of a contractor as [`cover`] does, but gives up after `most_boxes` contractions: boxes that still wait to be bisected are
/// then returned as they are, however wide.
///
/// The oldest boxes are bisected first, so that the widest boxes are never left over while smaller ones are cut.
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

/// Smallest box around all of the given boxes; empty when there is none.
pub fn hull<'a, const N: usize>(boxes: impl IntoIterator<Item = &'a IntervalBox<N>>) -> IntervalBox<N> {
    boxes.into_iter().fold(IntervalBox::EMPTY, |hull, one| hull.hull(one))
}

/// The one of `axes` along which the box is widest; `None` if the box is no wider than the resolution there.
fn axis_to_bisect<const N: usize>(candidate: &IntervalBox<N>, axes: &[usize], resolution: f64) -> Option<usize> {
    let widest = axes.iter().copied().max_by(|a, b| candidate.width(*a).total_cmp(&candidate.width(*b)))?;
    let component = candidate[widest];
    // An interval between two neighbouring doubles cannot be halved.
    let is_divisible = component.lo() < component.mid() && component.mid() < component.hi();
    (component.width() > resolution && is_divisible).then_some(widest)
}

fn halves<const N: usize>(candidate: &IntervalBox<N>, axis: usize) -> [IntervalBox<N>; 2] {
    let (left, right) = candidate.bisect(axis);
    [right, left]
}

/// Adds to `slabs` boxes that cover `whole` without `part`: at most one slab on each side of `part` along each axis.
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
