//! The robot's way as its motion sensors measure it, for a filter that samples it: a pose by dead reckoning, and how uncertain it has become.

use std::collections::VecDeque;

use localizer::RobotModel;

use crate::subject::{
    Tuning,
    cues::{SIGMAS_OF_BOUND, Step, turned},
};

/// Dead reckoning over the last moments.
pub(crate) struct Odometry {
    robot: RobotModel,
    tuning: Tuning,
    way: VecDeque<Reckoned>,
}

/// Pose by dead reckoning at a stamp, and the variances of the way so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reckoned {
    pub(crate) stamp_s: f64,
    pose: [f64; 3],
    /// Time over which the turn was that of the gyroscope, by its nominal bias.
    biased_s: f64,
    /// Sums over all steps of the variances of the travel ahead, of that to the side, and of the turn.
    variances: [f64; 3],
}

/// The way between two stamps in the frame of the robot at the first, and the standard deviations of travel ahead, to the side, and turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) moved: [f64; 3],
    pub(crate) sigma: [f64; 3],
    /// Time over which the turn was that of the gyroscope; negative for a way back.
    biased_s: f64,
}

/// Time for which the way is kept, longer than any image takes to arrive.
const KEPT_S: f64 = 1.5;

impl Odometry {
    pub(crate) fn new(robot: &RobotModel, tuning: Tuning) -> Odometry {
        Odometry { robot: robot.clone(), tuning, way: VecDeque::from([Reckoned::default()]) }
    }

    pub(crate) fn latest(&self) -> Reckoned {
        self.way.back().copied().unwrap_or_default()
    }

    /// Adds a step of the robot: the turn by the gyroscope, the travel by the flow sensor, and either by the wheels where there is no such reading.
    pub(crate) fn add(&mut self, step: &Step) {
        let Reckoned { pose, mut biased_s, mut variances, .. } = self.latest();
        let (robot, wheels) = (&self.robot, &self.robot.wheels);
        let track_m = wheels.track_m.mid();
        let factor = self.tuning.motion * SIGMAS_OF_BOUND;
        // Slip is bounded over windows. Errors of different windows are taken as independent, so that each step has its share of a window's variance.
        let windows = step.span_s / wheels.slip_window_s;
        let of_window = |path_m: f64, bound_m: &dyn Fn(f64) -> f64| {
            if path_m > 0.0 { (factor * bound_m(path_m / windows)).powi(2) * windows } else { 0.0 }
        };
        let share = |of: interval::Interval| 0.5 * of.width() / of.mid();
        let wheel_m2 = |wheel: usize| {
            let ratio = wheels.slip_ratio + share(wheels.radius_m[wheel]);
            of_window(step.rolled_m[wheel].abs(), &|path_m| ratio * path_m + wheels.slip_floor_m)
        };
        let wheels_m2 = wheel_m2(0) + wheel_m2(1);
        let (turn_rad, turn_rad2) = match (step.turned, robot.gyro) {
            (Some((rates_rad, n_rates)), Some(gyro)) => {
                let rate_rad_per_s = rates_rad / (n_rates * gyro.period_s) - gyro.bias_rad_per_s.mid();
                let turn_rad = rate_rad_per_s * step.span_s / gyro.scale.mid();
                let white_rad = factor * gyro.noise_rad_per_s * step.span_s / n_rates.sqrt();
                biased_s += step.span_s;
                let scaled_rad2 = of_window(turn_rad.abs(), &|turned_rad| share(gyro.scale) * turned_rad);
                (turn_rad, white_rad.powi(2) + scaled_rad2)
            }
            _ => ((step.rolled_m[1] - step.rolled_m[0]) / track_m, wheels_m2 / track_m.powi(2)),
        };
        let (travel_m, travel_m2) = match (step.flowed_m, robot.flow) {
            (Some(flowed_m), Some(flow)) => {
                let along = turned(flowed_m, flow.yaw_rad.mid());
                let [arm_ahead_m, arm_left_m] = flow.position_m.map(|side| side.mid());
                let path_m = along[0].hypot(along[1]);
                let calibrated = share(flow.metres_per_count).hypot(0.5 * flow.yaw_rad.width());
                let count_m = factor * 0.5 * flow.quantisation_counts * flow.metres_per_count.mid();
                // Counts are rounded once however often they are read, so that a window has the error of one count.
                let off_m2 = of_window(path_m, &|path_m| flow.scale_change.hypot(calibrated) * path_m)
                    + count_m.powi(2) * windows;
                ([along[0] + turn_rad * arm_left_m, along[1] - turn_rad * arm_ahead_m], [off_m2; 2])
            }
            _ => {
                let ahead_m = 0.5 * (step.rolled_m[0] + step.rolled_m[1]);
                let side = |path_m: f64| wheels.side_slip_ratio * path_m + wheels.side_slip_floor_m;
                ([ahead_m, 0.0], [0.25 * wheels_m2, of_window(ahead_m.abs(), &side)])
            }
        };
        for (sum, variance) in variances.iter_mut().zip([travel_m2[0], travel_m2[1], turn_rad2]) {
            *sum += variance;
        }
        let [dx, dy] = turned(travel_m, pose[2] + 0.5 * turn_rad);
        let pose = [pose[0] + dx, pose[1] + dy, pose[2] + turn_rad];
        self.way.push_back(Reckoned { stamp_s: step.stamp_s, pose, biased_s, variances });
        while self.way.len() > 2 && self.way.front().is_some_and(|first| first.stamp_s < step.stamp_s - KEPT_S) {
            self.way.pop_front();
        }
    }

    /// Pose by dead reckoning at a stamp, between the two readings about it.
    pub(crate) fn at(&self, stamp_s: f64) -> Reckoned {
        let Some(after) = self.way.iter().position(|one| one.stamp_s >= stamp_s) else { return self.latest() };
        let (two, one) = (self.way[after], self.way[after.saturating_sub(1)]);
        let span_s = two.stamp_s - one.stamp_s;
        let share = if span_s > 0.0 { ((stamp_s - one.stamp_s) / span_s).clamp(0.0, 1.0) } else { 1.0 };
        let between = |one: [f64; 3], two: [f64; 3]| [0, 1, 2].map(|axis| one[axis] + share * (two[axis] - one[axis]));
        Reckoned {
            stamp_s,
            pose: between(one.pose, two.pose),
            biased_s: one.biased_s + share * (two.biased_s - one.biased_s),
            variances: between(one.variances, two.variances),
        }
    }
}

impl Way {
    /// The way from one stamp to another, which may be earlier.
    pub(crate) fn between(from: &Reckoned, to: &Reckoned) -> Way {
        let [dx, dy] = turned([to.pose[0] - from.pose[0], to.pose[1] - from.pose[1]], -from.pose[2]);
        let sigma = [0, 1, 2].map(|axis| (to.variances[axis] - from.variances[axis]).max(0.0).sqrt());
        Way { moved: [dx, dy, to.pose[2] - from.pose[2]], sigma, biased_s: to.biased_s - from.biased_s }
    }

    /// The way without the errors of the motion.
    pub(crate) fn exactly(self) -> Way {
        Way { sigma: [0.0; 3], ..self }
    }

    /// The pose that a robot reaches from a pose by the way, if its gyroscope's bias is off the nominal one by `bias_rad_per_s`, and with an error of
    /// so many standard deviations ahead, to the side, and of turn. The error of the turn comes evenly along the way.
    pub(crate) fn from(&self, [x_m, y_m, heading_rad]: [f64; 3], bias_rad_per_s: f64, off: [f64; 3]) -> [f64; 3] {
        let off_rad = self.sigma[2] * off[2] - bias_rad_per_s * self.biased_s;
        let travel = [self.moved[0] + self.sigma[0] * off[0], self.moved[1] + self.sigma[1] * off[1]];
        let [dx, dy] = turned(travel, heading_rad + 0.5 * off_rad);
        [x_m + dx, y_m + dy, heading_rad + self.moved[2] + off_rad]
    }
}
