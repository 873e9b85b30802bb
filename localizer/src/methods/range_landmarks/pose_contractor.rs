//! All sightings of one reading as a contractor on the pose.

use crate::{
    Contractor, Interval, IntervalBox, Outcome, PoseBox,
    contractor::{ForwardBackward, Landmark, LinearPose, Polar, RigidPlanar, q_intersection},
    paving,
};

use super::{Freedom, Solver};

/// Slices of heading of the one-shot solver: with eight, each width is within a tenth of the limit on the paper's problem.
const N_SLICES: usize = 8;

/// Passes end when no width shrinks by more than this share.
const WORTHWHILE: f64 = 0.02;

/// Passes at most.
const MOST_PASSES: usize = 50;

/// Width of a slice of heading when matches may be wrong: 5 mrad blur a landmark at 3 m by 15 mm.
const SLICE_RAD: f64 = 0.005;
/// Slices at most: a wider prior gets wider slices.
const MOST_SLICES: f64 = 128.0;

/// A box is bisected into at most this many parts along each axis, whatever the resolution.
const MOST_PARTS: f64 = 48.0;

const CAUSE: &str = "the landmarks in view do not fit those known";

/// The pose against known landmarks, all but `q_items` of the matches being right.
pub(super) struct LandmarkPose {
    pairs: Vec<Landmark>,
    /// Pairs prepared for the solvers that look at all of them at once.
    rigid: RigidPlanar,
    freedom: Freedom,
    solver: Solver,
    q_items: usize,
}

impl LandmarkPose {
    pub(super) fn new(pairs: &[Landmark], freedom: Freedom, solver: Solver, q_items: usize) -> Self {
        let prepared = if freedom == Freedom::Full && q_items == 0 { pairs } else { &[] };
        LandmarkPose { pairs: pairs.to_vec(), rigid: RigidPlanar::new(prepared), freedom, solver, q_items }
    }
}

impl Contractor<3> for LandmarkPose {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        let left = self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        *domain = left;
        if left.is_empty() { Outcome::Empty(CAUSE) } else { Outcome::Feasible }
    }

    fn branches(&self, domain: &PoseBox) -> Vec<PoseBox> {
        if self.pairs.len() <= self.q_items || domain.is_empty() {
            return if domain.is_empty() { Vec::new() } else { vec![*domain] };
        }
        let left = match (self.freedom, self.q_items) {
            (Freedom::Line, _) => vec![self.translated(domain, &[0])],
            (Freedom::Translation, _) => vec![self.translated(domain, &[0, 1])],
            (Freedom::Full, 0) => solve(&self.rigid, &self.pairs, self.solver, domain),
            (Freedom::Full, _) => vec![self.relaxed(domain)],
        };
        left.into_iter().filter(|branch| !branch.is_empty()).collect()
    }
}

impl LandmarkPose {
    /// Tables II and III: t = a − R(θ)·b on the axes that move, the heading as it is known.
    fn translated(&self, domain: &PoseBox, axes: &[usize]) -> PoseBox {
        let boxes: Vec<IntervalBox<2>> =
            self.pairs.iter().map(|pair| IntervalBox::new(translation(pair, domain[2]))).collect();
        let allowed = q_intersection(&boxes, self.q_items);
        let mut left = *domain;
        for &axis in axes {
            left[axis] = left[axis].intersect(allowed[axis]);
        }
        if left.is_empty() { IntervalBox::EMPTY } else { left }
    }

    /// Slices of heading, in each of which all but q matches must allow a common place.
    ///
    /// Sound: the true heading is in a slice, and there the true place is in the boxes of all right matches.
    fn relaxed(&self, domain: &PoseBox) -> PoseBox {
        let (lo, width) = (domain[2].lo(), domain[2].width());
        let n_slices = (width / SLICE_RAD).ceil().clamp(1.0, MOST_SLICES);
        let mut hull = IntervalBox::EMPTY;
        for idx in 0..n_slices as usize {
            let end = |idx: usize| lo + width * idx as f64 / n_slices;
            let slice = Interval::new(end(idx), end(idx + 1)).inflate(1e-12).intersect(domain[2]);
            let part = IntervalBox::new([domain[0], domain[1], slice]);
            hull = hull.hull(&self.translated(&part, &[0, 1]));
        }
        hull
    }
}

/// a − R(θ)·b.
fn translation((a, [forward, left]): &Landmark, heading: Interval) -> [Interval; 2] {
    let (cos, sin) = (heading.cos(), heading.sin());
    [a[0] - (*forward * cos - *left * sin), a[1] - (*forward * sin + *left * cos)]
}

/// Boxes that contain every pose of `domain` that carries each b into its a.
pub(crate) fn solve(rigid: &RigidPlanar, pairs: &[Landmark], solver: Solver, domain: &PoseBox) -> Vec<PoseBox> {
    match solver {
        Solver::OneShot => LinearPose { motion: rigid.clone(), n_slices: N_SLICES }.branches(domain),
        Solver::Polar => rigid
            .turns(domain[2])
            .into_iter()
            .map(|heading| to_fixpoint(IntervalBox::new([domain[0], domain[1], heading]), |pose| polar(pairs, pose)))
            .collect(),
        Solver::TableIv => {
            let equations: Vec<ForwardBackward<3>> = pairs.iter().flat_map(table_iv).collect();
            vec![to_fixpoint(*domain, |mut pose| {
                equations.iter().for_each(|equation| {
                    equation.contract(&mut pose);
                });
                pose
            })]
        }
        Solver::Sivia { resolution } => {
            // A single landmark leaves a curve of poses: no use in bisecting it.
            if pairs.len() < 2 {
                return rigid.branches(domain);
            }
            let parts = rigid.branches(domain).into_iter();
            parts
                .map(|part| {
                    let resolution = resolution.max(part.max_width() / MOST_PARTS);
                    paving::hull(&paving::cover(rigid, part, &[0, 1, 2], resolution))
                })
                .collect()
        }
    }
}

/// One pass of the polar contractor over all landmarks: a − t has the length of b, and its direction is θ plus that of b.
fn polar(pairs: &[Landmark], mut pose: PoseBox) -> PoseBox {
    for (a, b) in pairs {
        if pose.is_empty() {
            return IntervalBox::EMPTY;
        }
        let (length, direction) = (b[0].hypot(b[1]), b[1].atan2(b[0]));
        let mut way = IntervalBox::new([a[0] - pose[0], a[1] - pose[1], length, pose[2] + direction]);
        Polar.contract(&mut way);
        pose = pose.intersect(&IntervalBox::new([a[0] - way[0], a[1] - way[1], way[3] - direction]));
    }
    pose
}

/// Eq. (16) as two equations in the pose; the forward-backward contractor knows all branches of the inverse sine and cosine.
fn table_iv((a, b): &Landmark) -> [ForwardBackward<3>; 2] {
    let (a, b) = (*a, *b);
    [
        ForwardBackward::new(|[x, y, heading]| heading.cos() * (a[0] - x) + heading.sin() * (a[1] - y), b[0]),
        ForwardBackward::new(|[x, y, heading]| heading.cos() * (a[1] - y) - heading.sin() * (a[0] - x), b[1]),
    ]
}

fn to_fixpoint(mut pose: PoseBox, pass: impl Fn(PoseBox) -> PoseBox) -> PoseBox {
    for _ in 0..MOST_PASSES {
        let next = pass(pose);
        if next.is_empty() {
            return IntervalBox::EMPTY;
        }
        let goes_on = (0..3).any(|axis| next.width(axis) < (1.0 - WORTHWHILE) * pose.width(axis));
        pose = next;
        if !goes_on {
            break;
        }
    }
    pose
}
