//! What one step of the robot does to its pose by the motion sensors, and how uncertain that is.

use localizer::RobotModel;
use nalgebra::{DVector, Matrix3, Vector3};

use crate::{
    scene::FilterNoise,
    subject::cues::{SIGMAS_OF_BOUND, Step, turned},
};

use super::layout::Layout;

/// What a step of the robot does to its pose: travel and turn in its own frame, their derivatives by the constants in the state, and their noise.
pub(crate) struct Moved {
    pub(crate) travel_m: [f64; 2],
    pub(crate) turn_rad: f64,
    pub(crate) by: Vec<(usize, [f64; 3])>,
    pub(crate) noise: Matrix3<f64>,
}

impl Moved {
    /// What the step does where `mean` is the mean of the filter's state.
    pub(crate) fn of(
        step: &Step,
        mean: &DVector<f64>,
        layout: &Layout,
        robot: &RobotModel,
        tuning: &FilterNoise,
    ) -> Moved {
        let wheels = &robot.wheels;
        let [left, right, track] = layout.wheels;
        let [left_slip, right_slip, side_slip] = layout.slip;
        let share = |wheel: usize| mean[[left, right][wheel]] + mean[[left_slip, right_slip][wheel]];
        let rolled_m = [0, 1].map(|wheel| step.rolled_m[wheel] * (1.0 + share(wheel)));
        let track_m = wheels.track_m.mid() * (1.0 + mean[track]);
        let (path_m, window_s) = (step.rolled_m.map(f64::abs), wheels.slip_window_s);
        // The slip that grows with the way lasts, and is in the state. The floor of its bound is one for each window; those of different windows are
        // taken as independent, so that each step has its share of a window's variance.
        let windows = step.span_s / window_s;
        let floor_m2 = |path_m: f64, floor_m: f64| {
            if path_m > 0.0 { (tuning.motion * SIGMAS_OF_BOUND * floor_m).powi(2) * windows } else { 0.0 }
        };
        let wheel_m2: f64 = path_m.iter().map(|path_m| floor_m2(*path_m, wheels.slip_floor_m)).sum();
        let mut by: Vec<(usize, [f64; 3])> = Vec::new();
        let (turn_rad, turn_rad2) = match (step.turned, layout.gyro, robot.gyro) {
            (Some((rates_rad, n_rates)), Some([bias, scale]), Some(gyro)) => {
                let covered_s = n_rates * gyro.period_s;
                // Where rates were lost, those that arrived stand for the whole step.
                let whole = step.span_s / covered_s;
                let turn_rad = whole * (rates_rad - mean[bias] * covered_s) / (gyro.scale.mid() * (1.0 + mean[scale]));
                by.push((bias, [0.0, 0.0, -step.span_s / gyro.scale.mid()]));
                by.push((scale, [0.0, 0.0, -turn_rad]));
                let rate_rad = tuning.motion * SIGMAS_OF_BOUND * gyro.noise_rad_per_s * gyro.period_s;
                (turn_rad, (whole * rate_rad).powi(2) * n_rates)
            }
            _ => {
                let turn_rad = (rolled_m[1] - rolled_m[0]) / track_m;
                by.extend([left, left_slip].map(|place| (place, [0.0, 0.0, -step.rolled_m[0] / track_m])));
                by.extend([right, right_slip].map(|place| (place, [0.0, 0.0, step.rolled_m[1] / track_m])));
                by.push((track, [0.0, 0.0, -turn_rad]));
                (turn_rad, wheel_m2 / track_m.powi(2))
            }
        };
        let (travel_m, travel_m2) = match (step.flowed_m, layout.flow, robot.flow) {
            (Some(flowed_m), Some([scale, change, yaw]), Some(flow)) => {
                let longer = 1.0 + mean[scale] + mean[change];
                let along = turned(flowed_m, flow.yaw_rad.mid() + mean[yaw]).map(|m| m * longer);
                by.extend([scale, change].map(|place| (place, [along[0], along[1], 0.0])));
                by.push((yaw, [-along[1], along[0], 0.0]));
                let [arm_ahead_m, arm_left_m] = flow.position_m.map(|side| side.mid());
                // Counts are rounded once however often they are read, so that a window has the error of one count, and each step its share of that.
                let factor = tuning.motion * SIGMAS_OF_BOUND;
                let count_m = factor * 0.5 * flow.quantisation_counts * flow.metres_per_count.mid();
                // The robot went back and forth within the step only if it got less far than that.
                let path_m = along[0].hypot(along[1]);
                let turns_back = (0.0..flow.back_and_forth_m).contains(&path_m) && path_m > 0.0;
                let back_m = if turns_back { factor * flow.back_and_forth_m } else { 0.0 };
                let astray_m2 = count_m.powi(2) * windows + back_m.powi(2);
                let travel_m = [along[0] + turn_rad * arm_left_m, along[1] - turn_rad * arm_ahead_m];
                (travel_m, [astray_m2; 2])
            }
            _ => {
                by.extend([left, left_slip].map(|place| (place, [0.5 * step.rolled_m[0], 0.0, 0.0])));
                by.extend([right, right_slip].map(|place| (place, [0.5 * step.rolled_m[1], 0.0, 0.0])));
                let mean_path_m = 0.5 * (path_m[0] + path_m[1]);
                by.push((side_slip, [0.0, mean_path_m, 0.0]));
                let travel_m = [0.5 * (rolled_m[0] + rolled_m[1]), mean_path_m * mean[side_slip]];
                (travel_m, [0.25 * wheel_m2, floor_m2(mean_path_m, wheels.side_slip_floor_m)])
            }
        };
        let noise = Matrix3::from_diagonal(&Vector3::new(travel_m2[0], travel_m2[1], turn_rad2));
        Moved { travel_m, turn_rad, by, noise }
    }
}
