//! What one step of the robot does to its pose by the motion sensors, and how uncertain that is.

use localizer::{RobotModel, robot::WheelModel};
use nalgebra::{Matrix3, Vector3};

use crate::subject::cues::{SIGMAS_OF_BOUND, Step, turned};

use super::{Tuning, belief::Belief, layout::Layout};

/// What a step of the robot does to its pose: travel and turn in its own frame, their derivatives by the constants in the state, and their noise.
pub(crate) struct Moved {
    pub(crate) travel_m: [f64; 2],
    pub(crate) turn_rad: f64,
    pub(crate) by: Vec<(usize, [f64; 3])>,
    pub(crate) noise: Matrix3<f64>,
}

impl Moved {
    pub(crate) fn of(step: &Step, belief: &Belief, layout: &Layout, robot: &RobotModel, tuning: &Tuning) -> Moved {
        let wheels = &robot.wheels;
        let [left, right, track] = layout.wheels;
        let rolled_m = [0, 1].map(|wheel| step.rolled_m[wheel] * (1.0 + belief.mean[[left, right][wheel]]));
        let track_m = wheels.track_m.mid() * (1.0 + belief.mean[track]);
        let (path_m, window_s) = (step.rolled_m.map(f64::abs), wheels.slip_window_s);
        // Slip is bounded over windows. Errors of different windows are taken as independent, so that each step has its share of a window's variance.
        let windows = step.span_s / window_s;
        let slip_m2 = |path_m: f64, of: &dyn Fn(f64) -> f64| {
            if path_m > 0.0 { (tuning.motion * SIGMAS_OF_BOUND * of(path_m / windows)).powi(2) * windows } else { 0.0 }
        };
        let wheel_m2: f64 = (0..2).map(|wheel| slip_m2(path_m[wheel], &|path_m| slip_m(wheels, path_m))).sum();
        let mut by: Vec<(usize, [f64; 3])> = Vec::new();
        let (turn_rad, turn_rad2) = match (step.turned, layout.gyro, robot.gyro) {
            (Some((rates_rad, n_rates)), Some([bias, scale]), Some(gyro)) => {
                let covered_s = n_rates * gyro.period_s;
                // Where rates were lost, those that arrived stand for the whole step.
                let whole = step.span_s / covered_s;
                let turn_rad = whole * (rates_rad - belief.mean[bias] * covered_s)
                    / (gyro.scale.mid() * (1.0 + belief.mean[scale]));
                by.push((bias, [0.0, 0.0, -step.span_s / gyro.scale.mid()]));
                by.push((scale, [0.0, 0.0, -turn_rad]));
                let rate_rad = tuning.motion * SIGMAS_OF_BOUND * gyro.noise_rad_per_s * gyro.period_s;
                (turn_rad, (whole * rate_rad).powi(2) * n_rates)
            }
            _ => {
                let turn_rad = (rolled_m[1] - rolled_m[0]) / track_m;
                by.push((left, [0.0, 0.0, -step.rolled_m[0] / track_m]));
                by.push((right, [0.0, 0.0, step.rolled_m[1] / track_m]));
                by.push((track, [0.0, 0.0, -turn_rad]));
                (turn_rad, wheel_m2 / track_m.powi(2))
            }
        };
        let (travel_m, travel_m2) = match (step.flowed_m, layout.flow, robot.flow) {
            (Some(flowed_m), Some([scale, yaw]), Some(flow)) => {
                let along =
                    turned(flowed_m, flow.yaw_rad.mid() + belief.mean[yaw]).map(|m| m * (1.0 + belief.mean[scale]));
                by.push((scale, [along[0], along[1], 0.0]));
                by.push((yaw, [-along[1], along[0], 0.0]));
                let [arm_ahead_m, arm_left_m] = flow.position_m.map(|side| side.mid());
                let path_m = along[0].hypot(along[1]);
                let count_m = SIGMAS_OF_BOUND * 0.5 * flow.quantisation_counts * flow.metres_per_count.mid();
                let changed_m2 = slip_m2(path_m, &|path_m| flow.scale_change * path_m);
                let astray_m2 = count_m.powi(2)
                    + if path_m > 0.0 { (SIGMAS_OF_BOUND * flow.back_and_forth_m).powi(2) } else { 0.0 };
                let travel_m = [along[0] + turn_rad * arm_left_m, along[1] - turn_rad * arm_ahead_m];
                (travel_m, [changed_m2 + astray_m2; 2])
            }
            _ => {
                by.push((left, [0.5 * step.rolled_m[0], 0.0, 0.0]));
                by.push((right, [0.5 * step.rolled_m[1], 0.0, 0.0]));
                let ahead_m = 0.5 * (rolled_m[0] + rolled_m[1]);
                let side = |path_m: f64| wheels.side_slip_ratio * path_m + wheels.side_slip_floor_m;
                ([ahead_m, 0.0], [0.25 * wheel_m2, slip_m2(0.5 * (path_m[0] + path_m[1]), &side)])
            }
        };
        let noise = Matrix3::from_diagonal(&Vector3::new(travel_m2[0], travel_m2[1], turn_rad2));
        Moved { travel_m, turn_rad, by, noise }
    }
}

/// Declared bound on the slip of a wheel that rolls `path_m` within a window.
pub(crate) fn slip_m(wheels: &WheelModel, path_m: f64) -> f64 {
    wheels.slip_ratio * path_m + wheels.slip_floor_m
}
