//! Our method: relations kept as linear rows with rigorous remainders, and bounds by linear programs whose duals are certified.

use interval::Interval;
use interval::contractor::{Outcome, UnknownVariable};
use interval::linear_program::{LinearProgram, ProgramError, Solver, Terms, certified_maximum, certified_minimum};

use crate::boxes::{Boxes, contract_all, contract_window};
use crate::drive::{Drive, N_CONVERGING};
use crate::rows::{Surroundings, pose_index, ray_index};

/// Rounds of linear programs; the boxes that one leaves make the remainders of the next smaller. A third round makes no width smaller by 0.2 %.
const N_ROUNDS: usize = 2;
/// Of this many poses, counted from the last, one is bounded by linear programs; contractors carry that to the poses between. With every fifth pose
/// instead, widths are 0.3 % smaller and the time is doubled.
const POSE_STRIDE: usize = 20;
/// Rows narrower than this are widened by as much on both sides, which is sound: an equation leaves a solver that goes through the interior no room.
/// Over a whole drive it lets a pose move aside by a micrometre.
const LEAST_WIDTH: f64 = 1e-8;

/// Why a drive has no result.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the texts say it")]
pub(crate) enum Failure {
    #[error(transparent)]
    Program(#[from] ProgramError),
    #[error(transparent)]
    Variable(#[from] UnknownVariable),
    #[error("find any motion that agrees with the data")]
    Contradiction,
}

/// What our method knows after a drive.
pub(crate) struct Related {
    /// Places of the converging landmarks.
    pub(crate) places_m: [[Interval; 3]; N_CONVERGING],
    /// Boxes of all poses and rays.
    pub(crate) boxes: Boxes,
}

/// Bounds of all landmarks from all readings of a drive.
///
/// The paper's contraction of the whole drive comes first, so that the boxes, and with them the remainders of the rows, are small.
pub(crate) fn relate(drive: &Drive) -> Result<Related, Failure> {
    let n_poses = drive.n_poses();
    let mut boxes = contract_window(drive, drive.steps.len())?;
    for _ in 0..N_ROUNDS {
        boxes = contracted(drive, &boxes)?;
        let mut bounds = Bounds::new(drive, &boxes)?;
        for pose in (1..n_poses).rev().step_by(POSE_STRIDE) {
            for (axis, known) in boxes.poses[pose].iter_mut().enumerate() {
                *known = known.intersect(bounds.of(pose_index(pose, axis)));
            }
        }
        for (landmark, ray) in boxes.rays.iter_mut().enumerate() {
            for (part, known) in ray.iter_mut().enumerate() {
                *known = known.intersect(bounds.of(ray_index(n_poses, landmark, part)));
            }
        }
    }
    boxes = contracted(drive, &boxes)?;
    let mut bounds = Bounds::new(drive, &boxes)?;
    let mut places_m = [[Interval::EMPTY; 3]; N_CONVERGING];
    for (landmark, place_m) in places_m.iter_mut().enumerate() {
        let rho = ray_index(n_poses, landmark, 2);
        let inverse_depth = bounds.of(rho).intersect(boxes.rays[landmark][2]);
        place_m[0] = Interval::ONE / inverse_depth;
        for part in 0..2 {
            let slope = ray_index(n_poses, landmark, part);
            place_m[part + 1] = bounds.quotient(slope, rho, boxes.rays[landmark][part], inverse_depth);
        }
    }
    Ok(Related { places_m, boxes })
}

fn contracted(drive: &Drive, boxes: &Boxes) -> Result<Boxes, Failure> {
    match contract_all(drive, boxes)? {
        (boxes, Outcome::Feasible) => Ok(boxes),
        _ => Err(Failure::Contradiction),
    }
}

/// A row's sides, widened where they leave a solver no room.
pub(crate) fn with_room(sides: Interval) -> Interval {
    if sides.width() < LEAST_WIDTH { sides.inflate(LEAST_WIDTH) } else { sides }
}

/// The linear program of a drive with its solver.
struct Bounds {
    surroundings: Surroundings,
    program: LinearProgram,
    solver: Solver,
}

impl Bounds {
    fn new(drive: &Drive, boxes: &Boxes) -> Result<Bounds, ProgramError> {
        let surroundings = Surroundings::of_boxes(boxes);
        let mut program = LinearProgram::new(surroundings.deviations.clone())?;
        for row in surroundings.rows(drive) {
            program.add_row(&row.terms, with_room(row.sides))?;
        }
        let solver = Solver::new(&program);
        Ok(Bounds { surroundings, program, solver })
    }

    /// Certified bounds of a quantity.
    fn of(&mut self, index: usize) -> Interval {
        let cost = [(index, 1.0)];
        Interval::point(self.surroundings.reference[index]) + Interval::new(self.least(&cost), self.greatest(&cost))
    }

    fn least(&mut self, cost: &Terms) -> f64 {
        let duals = self.solver.minimise(cost);
        certified_minimum(&self.program, cost, &duals)
    }

    fn greatest(&mut self, cost: &Terms) -> f64 {
        let negated: Vec<_> = cost.iter().map(|&(index, coefficient)| (index, -coefficient)).collect();
        let duals = self.solver.minimise(&negated);
        certified_maximum(&self.program, cost, &duals)
    }

    /// Bounds of the quotient s/ρ of two quantities whose intervals are known, ρ > 0.
    ///
    /// For any number t, s/ρ = t + (s − tρ)/ρ, and s − tρ is linear. The nearer t is to a bound of the quotient, the nearer is the bound of s − tρ to
    /// 0, and the less matters the interval of ρ. Source: W. Dinkelbach, "On nonlinear fractional programming", Management Science 13 (1967).
    fn quotient(&mut self, slope: usize, rho: usize, slope_known: Interval, rho_known: Interval) -> Interval {
        let mut quotient = slope_known / rho_known;
        // The step from a bound to the next converges quadratically; two steps leave 10⁻⁶ of the width.
        for _ in 0..2 {
            for is_least in [true, false] {
                let at = if is_least { quotient.lo() } else { quotient.hi() };
                let [slope_0, rho_0] = [slope, rho].map(|index| Interval::point(self.surroundings.reference[index]));
                let cost = [(slope, 1.0), (rho, -at)];
                let bound = if is_least { self.least(&cost) } else { self.greatest(&cost) };
                let beyond = (slope_0 - rho_0 * at + bound) / rho_known + at;
                let side = if is_least {
                    Interval::new(beyond.lo(), f64::INFINITY)
                } else {
                    Interval::new(f64::NEG_INFINITY, beyond.hi())
                };
                quotient = quotient.intersect(side);
            }
        }
        quotient
    }
}
