//! The pose graph of paper 2 (Yi, Lee and Cho 2018), Eq. (4), by the method of Levenberg and Marquardt: odometry between poses, and headings
//! from vanishing points.
//!
//! Eq. (4) as printed adds squared metres to squared radians without weights, does not wrap angles and leaves the first pose free. Here each
//! residual is divided by its standard deviation, angles are wrapped, and the first pose is fixed.

use nalgebra::{DMatrix, DVector};

use crate::Pose;

/// A step of odometry from one pose to the next, in the frame of the pose before the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Travel in the step, forward and left.
    pub travel_m: [f64; 2],
    /// Turn in the step, counter-clockwise.
    pub turn_rad: f64,
    /// Heading of the pose after the step as the camera measured it; `None` where the camera measured no heading.
    pub heading_rad: Option<f64>,
}

impl Step {
    /// The step of odometry from one pose to another, without a heading measured by the camera.
    pub(super) fn between(from: Pose, to: Pose) -> Self {
        let (sin, cos) = from.heading_rad.sin_cos();
        let (x_m, y_m) = (to.x_m - from.x_m, to.y_m - from.y_m);
        Step {
            travel_m: [cos * x_m + sin * y_m, cos * y_m - sin * x_m],
            turn_rad: to.heading_rad - from.heading_rad,
            heading_rad: None,
        }
    }

    /// The pose that this step leads to from the pose `from`.
    pub(super) fn after(&self, from: Pose) -> Pose {
        let ((sin, cos), [forward, left]) = (from.heading_rad.sin_cos(), self.travel_m);
        Pose {
            x_m: from.x_m + forward * cos - left * sin,
            y_m: from.y_m + forward * sin + left * cos,
            heading_rad: from.heading_rad + self.turn_rad,
        }
    }
}

/// Standard deviations of the pose graph's residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Standard deviation of a step's travel along each axis.
    pub travel_m: f64,
    /// Standard deviation of a step's turn.
    pub turn_rad: f64,
    /// Standard deviation of a heading measured by the camera.
    pub heading_rad: f64,
}

/// Optimised poses after each step, from a first pose that is known and stays fixed.
pub fn optimised(first: Pose, steps: &[Step], weights: &Weights) -> Vec<Pose> {
    let mut poses = dead_reckoned(first, steps);
    let (mut damping, mut cost) = (1e-4, residuals(first, &poses, steps, weights).norm_squared());
    for _ in 0..30 {
        let (error, slope) = (residuals(first, &poses, steps, weights), jacobian(first, &poses, steps, weights));
        let gradient = slope.tr_mul(&error);
        let mut matrix = slope.tr_mul(&slope);
        for at in 0..matrix.nrows() {
            matrix[(at, at)] *= 1.0 + damping;
        }
        let Some(change) = matrix.cholesky().map(|factor| factor.solve(&gradient)) else { break };
        let tried = moved(&poses, &change);
        let new_cost = residuals(first, &tried, steps, weights).norm_squared();
        if new_cost < cost {
            let settled = cost - new_cost < 1e-12 * cost.max(1e-12);
            (poses, cost, damping) = (tried, new_cost, damping * 0.1);
            if settled {
                break;
            }
        } else {
            damping *= 10.0;
        }
    }
    poses
}

fn dead_reckoned(first: Pose, steps: &[Step]) -> Vec<Pose> {
    let mut at = first;
    let next = |step: &Step| {
        at = step.after(at);
        at
    };
    steps.iter().map(next).collect()
}

fn moved(poses: &[Pose], change: &DVector<f64>) -> Vec<Pose> {
    let of = |(idx, pose): (usize, &Pose)| Pose {
        x_m: pose.x_m - change[3 * idx],
        y_m: pose.y_m - change[3 * idx + 1],
        heading_rad: pose.heading_rad - change[3 * idx + 2],
    };
    poses.iter().enumerate().map(of).collect()
}

/// Residuals of the pose graph, four for each step: travel forward, travel left, turn, and heading measured (0 where there is none).
fn residuals(first: Pose, poses: &[Pose], steps: &[Step], weights: &Weights) -> DVector<f64> {
    let mut all = DVector::zeros(4 * steps.len());
    let mut before = first;
    for (idx, (step, pose)) in steps.iter().zip(poses).enumerate() {
        let (sin, cos) = before.heading_rad.sin_cos();
        let (dx, dy) = (pose.x_m - before.x_m, pose.y_m - before.y_m);
        all[4 * idx] = (dx * cos + dy * sin - step.travel_m[0]) / weights.travel_m;
        all[4 * idx + 1] = (dy * cos - dx * sin - step.travel_m[1]) / weights.travel_m;
        all[4 * idx + 2] = wrapped(pose.heading_rad - before.heading_rad - step.turn_rad) / weights.turn_rad;
        all[4 * idx + 3] = step.heading_rad.map_or(0.0, |seen| wrapped(pose.heading_rad - seen) / weights.heading_rad);
        before = *pose;
    }
    all
}

fn jacobian(first: Pose, poses: &[Pose], steps: &[Step], weights: &Weights) -> DMatrix<f64> {
    let mut slope = DMatrix::zeros(4 * steps.len(), 3 * steps.len());
    let mut before = first;
    for (idx, (step, pose)) in steps.iter().zip(poses).enumerate() {
        let ((sin, cos), row, column) = (before.heading_rad.sin_cos(), 4 * idx, 3 * idx);
        let (dx, dy) = (pose.x_m - before.x_m, pose.y_m - before.y_m);
        let travel = [[cos, sin], [-sin, cos]];
        for axis in 0..2 {
            for along in 0..2 {
                slope[(row + axis, column + along)] = travel[axis][along] / weights.travel_m;
                if idx > 0 {
                    slope[(row + axis, column - 3 + along)] = -travel[axis][along] / weights.travel_m;
                }
            }
        }
        slope[(row + 2, column + 2)] = 1.0 / weights.turn_rad;
        if idx > 0 {
            slope[(row, column - 1)] = (dy * cos - dx * sin) / weights.travel_m;
            slope[(row + 1, column - 1)] = -(dx * cos + dy * sin) / weights.travel_m;
            slope[(row + 2, column - 1)] = -1.0 / weights.turn_rad;
        }
        if step.heading_rad.is_some() {
            slope[(row + 3, column + 2)] = 1.0 / weights.heading_rad;
        }
        before = *pose;
    }
    slope
}

/// Wraps a turn to within half a turn of 0.
fn wrapped(turn_rad: f64) -> f64 {
    turn_rad - (turn_rad / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
