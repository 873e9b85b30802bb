//! Rigid motion by forward-backward propagation: Table IV of paper 3 (Mustafa et al., CSCS 2015), with every branch of the inverse functions.

use interval::contractor::{Contractor, Inverse, Outcome, Within, settle};
use interval::{Interval, IntervalBox};

use super::Landmark;
use super::rigid_planar::CAUSE;

/// Contractor of the planar pose from boxes of the same landmarks in two frames, which treats the landmarks one by one.
///
/// **Constraint.** That of [`RigidPlanar`](super::RigidPlanar), written as the paper's Eq. (16): bx = cos θ (ax − tx) + sin θ (ay − ty), by =
/// −sin θ (ax − tx) + cos θ (ay − ty) for each landmark.
///
/// **Sound.** Each step of the formulas is inverted by an enclosure of all its operands. As printed, rows 31 and 32 of Table IV invert sine and
/// cosine on one branch only and lose three quarters of all headings, and rows 19 to 26 divide by intervals that may contain 0. Here all periods
/// of the inverse that meet the known angle are kept, and a division never drops an operand.
///
/// **Not optimal.** The variables tx, ty and θ occur in every landmark's equations, and no two landmarks are compared. The widths are about
/// twice those of [`RigidPlanar`](super::RigidPlanar); bisection helps.
///
/// **Source.** M. Mustafa et al., "Rigid transformation using interval analysis for robot motion estimation", CSCS 2015, Table IV.
#[derive(Clone, Debug)]
pub struct RigidTable {
    /// For each landmark, a contractor on (tx, ty, θ, ax, ay), and the landmark's box in the frame in which the pose is expressed.
    rows: Vec<(Inverse<5, 2, Within<2>>, [Interval; 2])>,
}

/// Another pass over the landmarks follows as long as some width of the pose shrinks by more than this fraction; the paper says "while
/// contraction is significant".
const SIGNIFICANT: f64 = 0.01;
/// Greatest number of passes of the contractor over all landmarks. Where convergence is slow, each further pass gains less.
const MOST_PASSES: usize = 50;

impl RigidTable {
    /// A contractor for landmarks given as pairs of boxes (x, y): the first box is in the frame in which the pose is expressed, the second in the
    /// frame that moves (for a robot's pose: the world frame and the robot frame).
    pub fn new(landmarks: &[Landmark]) -> RigidTable {
        let row = |&(a, b): &Landmark| {
            let equations = Inverse::new(
                |[tx, ty, heading, ax, ay]| {
                    let (cosine, sine) = (heading.cos(), heading.sin());
                    let (across, along) = (ax - tx, ay - ty);
                    [cosine * across + sine * along, cosine * along - sine * across]
                },
                Within(IntervalBox::new(b)),
            );
            (equations, a)
        };
        RigidTable { rows: landmarks.iter().map(row).collect() }
    }
}

impl Contractor<3> for RigidTable {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let mut left = *domain;
        let mut places: Vec<_> = self.rows.iter().map(|(_, place)| *place).collect();
        for _ in 0..MOST_PASSES {
            let before = left;
            for ((equations, _), place) in self.rows.iter().zip(&mut places) {
                let mut all = IntervalBox::new([left[0], left[1], left[2], place[0], place[1]]);
                equations.contract(&mut all);
                if all.is_empty() {
                    return settle(domain, IntervalBox::EMPTY, CAUSE);
                }
                left = IntervalBox::new([all[0], all[1], all[2]]);
                *place = [all[3], all[4]];
            }
            if (0..3).all(|axis| left.width(axis) >= (1.0 - SIGNIFICANT) * before.width(axis)) {
                break;
            }
        }
        settle(domain, left, CAUSE)
    }
}
