//! The exact hull from inside: motions that agree with every reading and put a landmark as far out as a search gets them.
//!
//! The search needs no proof: each motion that it finds is checked on all readings by [`Drive::admits`], which shares no code with the methods. The
//! places of such motions are places that no sound method may exclude, so that the exact hull is between their hull and that of any sound method.

use interval::Interval;
use interval::linear_program::{LinearProgram, ProgramError, Solver};

use crate::boxes::Boxes;
use crate::drive::{Drive, Motion, N_CONVERGING};
use crate::related::with_room;
use crate::rows::{Row, Surroundings, pose_index, quantities, ray_index};

/// Linear programs in a row, each linearised about the motion that the one before has found. The search converges quadratically; a fourth program
/// changes nothing.
const N_PROGRAMS: usize = 3;
/// Shares of the readings' half widths by which the search stays inside their bounds, so that what the linearisation neglects does not lead outside.
/// Each is tried and the motion that is farthest out counts, because with the smallest share the solver does not always converge.
const MARGINS: [f64; 3] = [1e-3, 1e-4, 1e-5];
/// Share that a witness must keep: a thousand times more than what rounding needs.
const LEAST_MARGIN: f64 = 1e-9;

/// For each converging landmark the smallest box around the places that witnesses have. The truth is one of them.
pub(crate) fn hull_from_inside(drive: &Drive, boxes: &Boxes) -> Result<[[Interval; 3]; N_CONVERGING], ProgramError> {
    let mut hulls = [[Interval::EMPTY; 3]; N_CONVERGING];
    for landmark in 0..N_CONVERGING {
        for axis in 0..3 {
            for (sign, margin) in [-1.0, 1.0].iter().flat_map(|&sign| MARGINS.map(|margin| (sign, margin))) {
                let witness = push(drive, boxes, [landmark, axis], sign, margin)?;
                // What one search finds counts for all landmarks.
                for (other, hull) in hulls.iter_mut().enumerate() {
                    let place_m = witness.place_m(other);
                    (0..3).for_each(|axis| hull[axis] = hull[axis].hull(Interval::point(place_m[axis])));
                }
            }
        }
    }
    Ok(hulls)
}

/// A motion that agrees with the data and has a landmark's coordinate as great as possible, or as small for a negative sign.
fn push(
    drive: &Drive,
    boxes: &Boxes,
    [landmark, axis]: [usize; 2],
    sign: f64,
    margin: f64,
) -> Result<Motion, ProgramError> {
    let n_poses = drive.n_poses();
    let [a, b, rho] = [0, 1, 2].map(|part| ray_index(n_poses, landmark, part));
    let mut reached = drive.truth.clone();
    for _ in 0..N_PROGRAMS {
        let reference = quantities(&reached.poses(), &reached.landmarks);
        let linear = Surroundings { deviations: vec![Interval::ZERO; reference.len()], reference: reference.clone() };
        let known = boxes.poses.iter().chain(&boxes.rays).flatten();
        let free = known.zip(&reference).map(|(&known, &at)| known - Interval::point(at));
        let mut program = LinearProgram::new(free.collect())?;
        for row in linear.rows(drive) {
            program.add_row(&row.terms, inside(&row, margin))?;
        }
        // The coordinate is 1/ρ, a/ρ or b/ρ; this is its gradient, times ρ² and negated.
        let (slope, at) = [(None, 1.0), (Some(a), reference[a]), (Some(b), reference[b])][axis];
        let mut cost = vec![(rho, sign * at)];
        cost.extend(slope.map(|slope| (slope, -sign * reference[rho])));
        let mut solver = Solver::new(&program);
        let mut search = solver.begin(&cost);
        while !solver.advance(&mut search, 10) {}
        let values: Vec<f64> = reference.iter().zip(solver.point(&search)).map(|(at, by)| at + by).collect();
        if !values.iter().all(|value| value.is_finite()) {
            break;
        }
        reached = motion_of(&values, n_poses);
    }
    Ok(nearest_admitted(drive, &reached))
}

/// The sides of a row, moved inwards. Rows of pixels have one open side and are in pixels times a depth near 1; those of odometry are bounded.
fn inside(row: &Row, margin: f64) -> Interval {
    let sides = with_room(row.sides);
    if sides != row.sides {
        return sides;
    }
    if sides.is_bounded() {
        return Interval::centred(sides.mid(), (1.0 - margin) * sides.radius());
    }
    Interval::new(sides.lo() + margin, sides.hi() - margin)
}

/// The motion with the given poses and rays, of which each step's distance is that along the mean heading.
fn motion_of(values: &[f64], n_poses: usize) -> Motion {
    let pose = |at: usize| [0, 1, 2].map(|axis| values[pose_index(at, axis)]);
    let steps = (1..n_poses).map(|at| {
        let ([x, y, heading], [next_x, next_y, next_heading]) = (pose(at - 1), pose(at));
        let (sin, cos) = (0.5 * (heading + next_heading)).sin_cos();
        [(next_x - x) * cos + (next_y - y) * sin, next_heading - heading]
    });
    let ray = |landmark| [0, 1, 2].map(|part| values[ray_index(n_poses, landmark, part)]);
    Motion { steps: steps.collect(), landmarks: std::array::from_fn(ray) }
}

/// The motion nearest to the one wanted, on the way from the truth to it, that the data admit.
fn nearest_admitted(drive: &Drive, wanted: &Motion) -> Motion {
    let mix = |from: f64, to: f64, share: f64| from + share * (to - from);
    let between = |share: f64| {
        let steps = drive.truth.steps.iter().zip(&wanted.steps);
        let rays = |at: usize| [0, 1, 2].map(|i| mix(drive.truth.landmarks[at][i], wanted.landmarks[at][i], share));
        Motion {
            steps: steps.map(|(from, to)| [0, 1].map(|i| mix(from[i], to[i], share))).collect(),
            landmarks: std::array::from_fn(rays),
        }
    };
    if drive.admits(wanted, LEAST_MARGIN) {
        return wanted.clone();
    }
    let (mut admitted, mut refused) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (admitted + refused);
        *(if drive.admits(&between(middle), LEAST_MARGIN) { &mut admitted } else { &mut refused }) = middle;
    }
    between(admitted)
}
