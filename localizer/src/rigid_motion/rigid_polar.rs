//! Rigid motion between two views of the same landmarks, in polar coordinates.

use interval::contractor::{Contractor, Outcome, Polar, settle};
use interval::{Interval, IntervalBox};

use super::rigid_planar::{CAUSE, direction};
use super::{Landmark, RigidPlanar};

/// Contractor of the planar pose from boxes of the same landmarks in two frames, compared by length and direction.
///
/// **Constraint.** That of [`RigidPlanar`]: a − t is b, rotated by θ. So a − t = |b| (cos, sin)(θ + ∠b).
///
/// **Sound.** The headings are first cut by the directions between landmarks, which no translation changes. Then each landmark contracts t and θ
/// by the polar equation and by the rotation itself, repeatedly. Both are consequences of the constraint.
///
/// **Not optimal.** The landmarks have only t and θ in common, while [`RigidPlanar`] compares each landmark's two boxes along four directions.
///
/// **Source.** B. Desrochers, L. Jaulin, "A minimal contractor for the polar equation: application to robot localization", Engineering
/// Applications of Artificial Intelligence 55 (2016), for the problem of Table IV of M. Mustafa et al., CSCS 2015.
#[derive(Clone, Debug)]
pub struct RigidPolar {
    motion: RigidPlanar,
    landmarks: Vec<Landmark>,
}

/// Another pass over the landmarks follows as long as some width of the pose shrinks by more than this fraction.
const SIGNIFICANT: f64 = 0.01;
/// Greatest number of passes of the contractor over all landmarks. Where convergence is slow, each further pass gains less.
const MOST_PASSES: usize = 50;

impl RigidPolar {
    /// A contractor for landmarks given as pairs of boxes (x, y): the first box is in the frame in which the pose is expressed, the second in the
    /// frame that moves (for a robot's pose: the world frame and the robot frame).
    pub fn new(landmarks: &[Landmark]) -> RigidPolar {
        RigidPolar { motion: RigidPlanar::new(landmarks), landmarks: landmarks.to_vec() }
    }

    fn fixpoint(&self, mut left: IntervalBox<3>) -> IntervalBox<3> {
        for _ in 0..MOST_PASSES {
            let before = left;
            for (a, b) in &self.landmarks {
                left = one_landmark(&left, a, b);
                if left.is_empty() {
                    return left;
                }
            }
            if (0..3).all(|axis| left.width(axis) >= (1.0 - SIGNIFICANT) * before.width(axis)) {
                break;
            }
        }
        left
    }
}

/// Contracts a pose by one landmark that is at `a` in the frame in which the pose is expressed and at `b` in the frame that moves.
fn one_landmark(pose: &IntervalBox<3>, a: &[Interval; 2], b: &[Interval; 2]) -> IntervalBox<3> {
    let (cosine, sine) = (pose[2].cos(), pose[2].sin());
    // The vector from the pose's position to the landmark is v = a − t = R(θ) b.
    let vector = [
        (a[0] - pose[0]).intersect(cosine * b[0] - sine * b[1]),
        (a[1] - pose[1]).intersect(sine * b[0] + cosine * b[1]),
    ];
    // In the frame that moves, the vector from the pose's position to the landmark is b = R(θ)ᵀ v.
    let back = [cosine * vector[0] + sine * vector[1], cosine * vector[1] - sine * vector[0]];
    if !(back[0].overlaps(b[0]) && back[1].overlaps(b[1])) {
        return IntervalBox::EMPTY;
    }
    let angle = direction(b[0], b[1]);
    let turned = angle.map_or(Interval::ENTIRE, |angle| pose[2] + angle);
    let mut polar = IntervalBox::new([vector[0], vector[1], b[0].hypot(b[1]), turned]);
    Polar.contract(&mut polar);
    if polar.is_empty() {
        return IntervalBox::EMPTY;
    }
    let heading = angle.map_or(pose[2], |angle| pose[2].intersect(polar[3] - angle));
    let left = IntervalBox::new([pose[0].intersect(a[0] - polar[0]), pose[1].intersect(a[1] - polar[1]), heading]);
    if left.is_empty() { IntervalBox::EMPTY } else { left }
}

impl Contractor<3> for RigidPolar {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let left = self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        settle(domain, left, CAUSE)
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let parts = self.motion.turns(domain[2]).into_iter();
        let contracted = parts.map(|heading| self.fixpoint(IntervalBox::new([domain[0], domain[1], heading])));
        contracted.filter(|part| !part.is_empty()).collect()
    }
}
