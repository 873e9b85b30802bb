//! Solvers for the robot's pose from landmarks, by name: which of the pose's three unknowns (x, y, heading) are contracted, and by which contractor.

use interval::contractor::{Contractor, Outcome, QRelaxed};
use interval::{IntervalBox, paving};

use crate::{
    PoseBox,
    rigid_motion::{Landmark, LinearPose, RelaxedPose, RigidPlanar, RigidPolar, RigidTable, Translated},
};

/// Components of the pose that the landmarks contract.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Freedom {
    /// World x alone, with y and heading as known before: the paper's Table II.
    Line,
    /// World x and y, with the heading as known before: the paper's Table III.
    Translation,
    /// World x, world y and heading: the paper's Table IV.
    #[default]
    Full,
}

/// Method by which the equations of a full planar motion are solved. All methods are sound; they differ in computing time and width of the
/// box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Solver {
    /// Linear elimination over all landmarks at once, [`RigidPlanar`] and [`LinearPose`]; [`RelaxedPose`] when some landmarks may be wrong.
    #[default]
    OneShot,
    /// Directions between landmarks, then each landmark in polar coordinates, [`RigidPolar`].
    Polar,
    /// The paper's forward-backward contractor with all branches, [`RigidTable`].
    TableIv,
    /// The paper's bisection over x, y and heading around [`RigidPlanar`]; the result is the hull of the leaves.
    Sivia {
        /// Greatest width of a leaf of the bisection, in metres and in radians.
        resolution: f64,
    },
}

/// Contractor on x, y and heading that assumes that all but `q` landmarks are carried from the robot frame into the world by the pose.
///
/// It is sound: each solver is, and a remaining box is dropped only when more than q landmarks, seen from every pose of it, miss their
/// places. When exactly q > 0 landmarks miss their places, those are the wrong ones, and the box is contracted by all others at once. That
/// is a theorem about boxes, not about landmarks: a wrong landmark may well stay hidden.
pub struct PoseFromLandmarks {
    landmarks: Vec<Landmark>,
    q: usize,
    freedom: Freedom,
    solver: Solver,
    contractor: Box<dyn Contractor<3> + Send + Sync>,
}

/// Number of slices of heading of the one-shot solver: the width that linearising costs falls with the square of this number.
const N_SLICES: usize = 4;
/// Share by which a width must shrink for another pass of a fixpoint iteration to be worth its time.
const SIGNIFICANT: f64 = 0.05;
/// Greatest number of contractions in one bisection, which take some milliseconds.
const MOST_BOXES: usize = 2000;

const CAUSE: &str = "the landmarks in view do not fit those known";

impl PoseFromLandmarks {
    /// Makes the contractor. Each landmark is a box in the world and a box in the robot frame, and at most `q` of the landmarks are wrong.
    pub fn new(landmarks: Vec<Landmark>, q: usize, freedom: Freedom, solver: Solver) -> Self {
        let contractor = contractor(&landmarks, q, freedom, solver);
        PoseFromLandmarks { landmarks, q, freedom, solver, contractor }
    }

    /// Whether a landmark, seen from some pose of the box, can be at its place.
    fn fits(pose: &PoseBox, (place, seen): &Landmark) -> bool {
        let (cosine, sine) = (pose[2].cos(), pose[2].sin());
        (pose[0] + (cosine * seen[0] - sine * seen[1])).overlaps(place[0])
            && (pose[1] + (sine * seen[0] + cosine * seen[1])).overlaps(place[1])
    }

    /// Boxes that remain of a pose box when the landmarks that surely miss their places are counted.
    fn counted(&self, pose: PoseBox) -> Vec<PoseBox> {
        let right: Vec<Landmark> = self.landmarks.iter().filter(|one| Self::fits(&pose, one)).copied().collect();
        let n_wrong = self.landmarks.len() - right.len();
        if n_wrong > self.q {
            return Vec::new();
        }
        if self.q == 0 || n_wrong < self.q {
            return vec![pose];
        }
        PoseFromLandmarks::new(right, 0, self.freedom, self.solver).branches(&pose)
    }
}

impl Contractor<3> for PoseFromLandmarks {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        *domain = paving::hull(&self.branches(domain));
        if domain.is_empty() { Outcome::Empty(CAUSE) } else { Outcome::Feasible }
    }

    fn branches(&self, domain: &PoseBox) -> Vec<PoseBox> {
        if domain.is_empty() {
            return Vec::new();
        }
        if self.landmarks.len() <= self.q {
            return vec![*domain];
        }
        self.contractor.branches(domain).into_iter().flat_map(|branch| self.counted(branch)).collect()
    }
}

fn contractor(
    landmarks: &[Landmark],
    q: usize,
    freedom: Freedom,
    solver: Solver,
) -> Box<dyn Contractor<3> + Send + Sync> {
    match (freedom, solver) {
        (Freedom::Line, _) => Box::new(Translated::<1> { landmarks: landmarks.to_vec(), q }),
        (Freedom::Translation, _) => Box::new(Translated::<2> { landmarks: landmarks.to_vec(), q }),
        (Freedom::Full, Solver::OneShot) if q == 0 => Box::new(OneShot { motion: RigidPlanar::new(landmarks) }),
        (Freedom::Full, Solver::OneShot) => Box::new(RelaxedPose { landmarks: landmarks.to_vec(), q }),
        (Freedom::Full, Solver::Polar) => relaxed(landmarks, q, RigidPolar::new),
        (Freedom::Full, Solver::TableIv) => relaxed(landmarks, q, RigidTable::new),
        (Freedom::Full, Solver::Sivia { resolution }) => {
            Box::new(Bisection { contractor: relaxed(landmarks, q, RigidPlanar::new), resolution })
        }
    }
}

/// Contractor by linear elimination over all landmarks, applied separately to each whole turn of the heading.
struct OneShot {
    motion: RigidPlanar,
}

impl Contractor<3> for OneShot {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        *domain = paving::hull(&self.branches(domain));
        if domain.is_empty() { Outcome::Empty(CAUSE) } else { Outcome::Feasible }
    }

    fn branches(&self, domain: &PoseBox) -> Vec<PoseBox> {
        let pose = LinearPose { motion: self.motion.clone(), n_slices: N_SLICES };
        let both = (&self.motion).then(pose).fixpoint(SIGNIFICANT);
        let mut turns: Vec<PoseBox> = self
            .motion
            .turns(domain[2])
            .into_iter()
            .map(|heading| IntervalBox::new([domain[0], domain[1], heading]))
            .collect();
        for turn in &mut turns {
            both.contract(turn);
        }
        turns.retain(|turn| !turn.is_empty());
        turns
    }
}

/// Contractor of the pose by all landmarks at once. When q landmarks may be wrong, contractor by each landmark alone and by disjoint pairs
/// of landmarks, of which at most q are spoilt.
fn relaxed<Exact>(
    landmarks: &[Landmark],
    q: usize,
    exact: impl Fn(&[Landmark]) -> Exact,
) -> Box<dyn Contractor<3> + Send + Sync>
where
    Exact: Contractor<3> + Send + Sync + 'static,
{
    if q == 0 {
        return Box::new(exact(landmarks));
    }
    let boxed = |some: &[Landmark]| -> Box<dyn Contractor<3> + Send + Sync> { Box::new(exact(some)) };
    let each = QRelaxed { contractors: landmarks.chunks(1).map(boxed).collect(), q };
    let pairs = QRelaxed { contractors: landmarks.chunks_exact(2).map(boxed).collect(), q };
    Box::new(each.then(pairs).fixpoint(SIGNIFICANT))
}

/// Contractor by set inversion with bisection (SIVIA) around another contractor, with bounded work.
struct Bisection {
    contractor: Box<dyn Contractor<3> + Send + Sync>,
    resolution: f64,
}

impl Contractor<3> for Bisection {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        let leaves = paving::cover_at_most(&self.contractor, *domain, &[0, 1, 2], self.resolution, MOST_BOXES);
        *domain = paving::hull(&leaves);
        if domain.is_empty() { Outcome::Empty(CAUSE) } else { Outcome::Feasible }
    }
}
