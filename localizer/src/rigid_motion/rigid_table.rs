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
/// **Not optimal.** The variables tx, ty and θ occur in every landmark's equations, and no two landmarks are compared. Backward, an equation bounds
/// ax − tx by what the other term, sin θ (ay − ty), leaves over, divided by cos θ. So it needs a start: where cos θ and sin θ may both be 0 the
/// division bounds nothing, and where t is known worse than the landmarks are far, the other term covers every bx. From an unknown heading and such a
/// position nothing is contracted, and bisection has to come first; [`RigidPlanar`](super::RigidPlanar) compares landmarks with each other and
/// needs no start. With a heading known to ±0.1 rad, widths are 1.6 to 2.1 times those of `RigidPlanar`.
///
/// Measured on four landmarks at 1.5 to 8 m, with a stereo camera's error of depth of 0.3 px (0.3 m at 8 m); the median of 300 widths of x or y,
/// whichever is wider:
///
/// | position and heading known to | here | by `RigidPlanar` |
/// |---|---|---|
/// | ±9 m, ±3.1 rad | 18.0 m | 0.27 m |
/// | ±9 m, ±0.5 rad | 8.3 m | 0.27 m |
/// | ±9 m, ±0.1 rad | 1.15 m | 0.59 m |
/// | ±1 m, ±3.1 rad | 1.94 m | 0.27 m |
/// | ±1 m, ±0.1 rad | 0.88 m | 0.55 m |
/// | ±1 m, ±0.03 rad | 0.45 m | 0.24 m |
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigid_motion::RigidPlanar;
    use crate::vision::synthetic::Random;

    const N_PROBLEMS: usize = 300;

    /// An interval of a given radius that holds a value somewhere within.
    fn around(value: f64, radius: f64, random: &mut Random) -> Interval {
        Interval::centred(value + random.between(-0.9, 0.9) * radius, radius)
    }

    /// Four landmarks of a room of 18 m, known to 2 cm, as a stereo camera sees them, and the true pose. An error of disparity of 0.3 px gives the
    /// depth z the error 0.3·z²/(f·b), with a focal length f of 500 px and a base b of 0.12 m; across, the error is 0.005·z.
    fn sighted(random: &mut Random) -> (Vec<Landmark>, [f64; 3]) {
        let [x, y] = [random.between(-6.0, 6.0), random.between(-6.0, 6.0)];
        let heading = random.between(-3.1, 3.1);
        let (sin, cos) = heading.sin_cos();
        let mut landmark = || {
            let depth = random.between(1.5, 8.0);
            let aside = depth * random.between(-0.5, 0.5);
            let place = [x + cos * depth - sin * aside, y + sin * depth + cos * aside];
            let depth_error = 0.3 * depth * depth / (500.0 * 0.12);
            (
                place.map(|at| around(at, 0.02, random)),
                [around(depth, depth_error, random), around(aside, 0.005 * depth, random)],
            )
        };
        ([landmark(), landmark(), landmark(), landmark()].to_vec(), [x, y, heading])
    }

    /// The wider one of the widths of x and y that a contractor leaves of a prior of the given radii: the median over many problems, first of this
    /// contractor, then of `RigidPlanar`; and the number of problems in which this contractor narrows any unknown by more than a hundredth.
    fn widths_m(position_m: f64, heading_rad: f64) -> ([f64; 2], usize) {
        let mut random = Random::new(3);
        let (mut n_narrowed, mut widths) = (0, [Vec::new(), Vec::new()]);
        for _ in 0..N_PROBLEMS {
            let (landmarks, pose) = sighted(&mut random);
            let radii = [position_m, position_m, heading_rad];
            let prior = IntervalBox::new([0, 1, 2].map(|axis| around(pose[axis], radii[axis], &mut random)));
            let (mut by_table, mut by_planar) = (prior, prior);
            RigidTable::new(&landmarks).contract(&mut by_table);
            RigidPlanar::new(&landmarks).contract(&mut by_planar);
            assert!((0..3).all(|axis| by_table[axis].contains(pose[axis])), "{pose:?} in {by_table:?}");
            n_narrowed += usize::from((0..3).any(|axis| by_table.width(axis) < 0.99 * prior.width(axis)));
            for (widths, left) in widths.iter_mut().zip([by_table, by_planar]) {
                widths.push(left.width(0).max(left.width(1)));
            }
        }
        let median = widths.map(|mut widths| {
            widths.sort_by(f64::total_cmp);
            widths[N_PROBLEMS / 2]
        });
        println!("±{position_m} m, ±{heading_rad} rad: {median:.3?} m, {n_narrowed} of {N_PROBLEMS} narrowed");
        (median, n_narrowed)
    }

    #[test]
    fn an_unknown_heading_and_a_position_worse_than_the_landmarks_are_far_stay_as_they_are() {
        let ([by_table, by_planar], n_narrowed) = widths_m(9.0, 3.1);
        // Landmarks up to 8 m away say little about a position that is known to ±9 m, so that hardly any problem has a start.
        assert!(by_table > 17.99 && n_narrowed < N_PROBLEMS / 20, "{by_table} m, {n_narrowed} narrowed");
        assert!(by_planar < 0.5, "{by_planar} m");
        // Either a position within the landmarks' distance or a rough heading is a start, though a poor one.
        assert!(widths_m(1.0, 3.1).1 > N_PROBLEMS * 9 / 10);
        assert!(widths_m(9.0, 0.5).1 > N_PROBLEMS * 9 / 10);
    }

    #[test]
    fn from_a_known_heading_the_widths_are_about_twice_those_of_the_planar_contractor() {
        for (position_m, heading_rad) in [(9.0, 0.1), (9.0, 0.03), (3.0, 0.1), (3.0, 0.03), (1.0, 0.1), (1.0, 0.03)] {
            let ([by_table, by_planar], n_narrowed) = widths_m(position_m, heading_rad);
            let ratio = by_table / by_planar;
            assert!((1.4..2.4).contains(&ratio) && n_narrowed > N_PROBLEMS * 9 / 10, "{ratio} at ±{position_m} m");
        }
    }
}
