//! The robot's way as its motion sensors measure it, for a filter that samples it: a pose by dead reckoning, and how uncertain it has become.

use std::{array, collections::VecDeque};

use localizer::RobotModel;

use crate::{
    scene::FilterNoise,
    subject::cues::{LASTS_M, Mounted, SIGMAS_OF_BOUND, Step, turned},
};

/// Dead reckoning over the last moments.
pub(crate) struct Odometry {
    robot: RobotModel,
    tuning: FilterNoise,
    way: VecDeque<Reckoned>,
}

/// Pose by dead reckoning at a stamp, and the variances of the way so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reckoned {
    pub(crate) stamp_s: f64,
    pose: [f64; 3],
    /// Time over which the turn was that of the gyroscope, by its nominal bias.
    biased_s: f64,
    /// Sums over all steps of the variances of the travel ahead, of that to the side, and of the turn, by errors that are new in each step.
    variances: [f64; 3],
    /// Sums over all steps of what each lasting error of one standard deviation does to the same three.
    lasting: [[f64; 3]; N_LASTING],
    /// Way so far, without signs.
    path_m: f64,
}

/// The way between two stamps in the frame of the robot at the first, and the standard deviations of travel ahead, to the side, and turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) moved: [f64; 3],
    pub(crate) sigma: [f64; 3],
    lasting: [[f64; 3]; N_LASTING],
    path_m: f64,
    /// Time over which the turn was that of the gyroscope; negative for a way back.
    biased_s: f64,
}

/// Number of errors that grow with the way and last: those of the left and of the right wheel, of the direction of travel (slip to the side, or the yaw
/// of the flow sensor), of the flow sensor's scale, of the gyroscope's scale, and of the track, which matters where there is no gyroscope.
///
/// All but the last are forgotten as the robot goes, although radii, scales and yaw are constant: as constants of each sample they are learnt too well
/// from a few joints, and where nothing tells the position the robot then goes astray by them.
pub(crate) const N_LASTING: usize = 6;
const WHEEL: [usize; 2] = [0, 1];
const DIRECTION: usize = 2;
const FLOW_SCALE: usize = 3;
const GYRO_SCALE: usize = 4;
const TRACK: usize = 5;

/// The errors of the sensors of one sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Errors {
    /// Errors of the mounts of the devices of [`Mounted::ALL`]: forward and left in metres, and the yaw. They are the same all the time.
    pub(crate) mounts: [[f64; 3]; Mounted::ALL.len()],
    /// Bias of the gyroscope less the nominal one.
    pub(crate) bias_rad_per_s: f64,
    /// Errors that last, each in its standard deviations.
    pub(crate) lasting: [f64; N_LASTING],
    /// Error ahead, to the side and of turn that is new on this way, in standard deviations.
    pub(crate) new: [f64; 3],
}

/// Time for which the way is kept, longer than any image takes to arrive.
const KEPT_S: f64 = 1.5;

impl Odometry {
    pub(crate) fn new(robot: &RobotModel, tuning: FilterNoise) -> Odometry {
        Odometry { robot: robot.clone(), tuning, way: VecDeque::from([Reckoned::default()]) }
    }

    pub(crate) fn latest(&self) -> Reckoned {
        self.way.back().copied().unwrap_or_default()
    }

    /// Adds a step of the robot: the turn by the gyroscope, the travel by the flow sensor, and either by the wheels where there is no such reading.
    pub(crate) fn add(&mut self, step: &Step) {
        let Reckoned { pose, mut biased_s, mut variances, mut lasting, path_m, .. } = self.latest();
        let (robot, wheels) = (&self.robot, &self.robot.wheels);
        let track_m = wheels.track_m.mid();
        let factor = self.tuning.motion * SIGMAS_OF_BOUND;
        // The floor of a bound on slip is one for each window. Those of different windows are taken as independent, so that each step has its share of a
        // window's variance.
        let windows = step.span_s / wheels.slip_window_s;
        let floor_m2 = |path_m: f64, floor_m: f64| {
            if path_m > 0.0 { (factor * floor_m).powi(2) * windows } else { 0.0 }
        };
        let share = |of: interval::Interval| 0.5 * of.width() / of.mid();
        let wheels_m2 = step.rolled_m.iter().map(|rolled_m| floor_m2(rolled_m.abs(), wheels.slip_floor_m)).sum::<f64>();
        let slipped_m =
            [0, 1].map(|wheel| factor * wheels.slip_ratio.hypot(share(wheels.radius_m[wheel])) * step.rolled_m[wheel]);
        let mut last = |error: usize, by: [f64; 3]| (0..3).for_each(|axis| lasting[error][axis] += by[axis]);
        let (turn_rad, turn_rad2) = match (step.turned, robot.gyro) {
            (Some((rates_rad, n_rates)), Some(gyro)) => {
                let rate_rad_per_s = rates_rad / (n_rates * gyro.period_s) - gyro.bias_rad_per_s.mid();
                let turn_rad = rate_rad_per_s * step.span_s / gyro.scale.mid();
                biased_s += step.span_s;
                last(GYRO_SCALE, [0.0, 0.0, factor * share(gyro.scale) * turn_rad]);
                (turn_rad, (factor * gyro.noise_rad_per_s * step.span_s / n_rates.sqrt()).powi(2))
            }
            _ => {
                let turn_rad = (step.rolled_m[1] - step.rolled_m[0]) / track_m;
                last(WHEEL[0], [0.0, 0.0, -slipped_m[0] / track_m]);
                last(WHEEL[1], [0.0, 0.0, slipped_m[1] / track_m]);
                last(TRACK, [0.0, 0.0, -factor * share(wheels.track_m) * turn_rad]);
                (turn_rad, wheels_m2 / track_m.powi(2))
            }
        };
        let rolled_m = 0.5 * (step.rolled_m[0].abs() + step.rolled_m[1].abs());
        let (travel_m, travel_m2) = match (step.flowed_m, robot.flow) {
            (Some(flowed_m), Some(flow)) => {
                let along = turned(flowed_m, flow.yaw_rad.mid());
                let [arm_ahead_m, arm_left_m] = flow.position_m.map(|side| side.mid());
                let scale = factor * flow.scale_change.hypot(share(flow.metres_per_count));
                let yaw_rad = factor * 0.5 * flow.yaw_rad.width();
                last(FLOW_SCALE, [scale * along[0], scale * along[1], 0.0]);
                last(DIRECTION, [-yaw_rad * along[1], yaw_rad * along[0], 0.0]);
                let count_m = factor * 0.5 * flow.quantisation_counts * flow.metres_per_count.mid();
                // Counts are rounded once however often they are read, so that a window has the error of one count.
                // The robot went back and forth within the step only if it got less far than that.
                let turns_back = (0.0..flow.back_and_forth_m).contains(&along[0].hypot(along[1])) && along != [0.0; 2];
                let back_m = if turns_back { factor * flow.back_and_forth_m } else { 0.0 };
                let off_m2 = count_m.powi(2) * windows + back_m.powi(2);
                ([along[0] + turn_rad * arm_left_m, along[1] - turn_rad * arm_ahead_m], [off_m2; 2])
            }
            _ => {
                WHEEL.into_iter().for_each(|wheel| last(wheel, [0.5 * slipped_m[wheel], 0.0, 0.0]));
                last(DIRECTION, [0.0, factor * wheels.side_slip_ratio * rolled_m, 0.0]);
                let ahead_m = 0.5 * (step.rolled_m[0] + step.rolled_m[1]);
                ([ahead_m, 0.0], [0.25 * wheels_m2, floor_m2(rolled_m, wheels.side_slip_floor_m)])
            }
        };
        for (sum, variance) in variances.iter_mut().zip([travel_m2[0], travel_m2[1], turn_rad2]) {
            *sum += variance;
        }
        let [dx, dy] = turned(travel_m, pose[2] + 0.5 * turn_rad);
        let pose = [pose[0] + dx, pose[1] + dy, pose[2] + turn_rad];
        let path_m = path_m + rolled_m;
        self.way.push_back(Reckoned { stamp_s: step.stamp_s, pose, biased_s, variances, lasting, path_m });
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
            lasting: array::from_fn(|error| between(one.lasting[error], two.lasting[error])),
            path_m: one.path_m + share * (two.path_m - one.path_m),
        }
    }
}

impl Way {
    /// The way from one stamp to another, which may be earlier.
    pub(crate) fn between(from: &Reckoned, to: &Reckoned) -> Way {
        let [dx, dy] = turned([to.pose[0] - from.pose[0], to.pose[1] - from.pose[1]], -from.pose[2]);
        let sigma = [0, 1, 2].map(|axis| (to.variances[axis] - from.variances[axis]).max(0.0).sqrt());
        let of = |error: usize| [0, 1, 2].map(|axis| to.lasting[error][axis] - from.lasting[error][axis]);
        Way {
            moved: [dx, dy, to.pose[2] - from.pose[2]],
            sigma,
            lasting: array::from_fn(of),
            path_m: (to.path_m - from.path_m).abs(),
            biased_s: to.biased_s - from.biased_s,
        }
    }

    /// Share of a lasting error that is left after the way: one that is forgotten is a first-order Gauss–Markov process.
    pub(crate) fn kept(&self, error: usize) -> f64 {
        if error == TRACK { 1.0 } else { (-self.path_m / LASTS_M).exp() }
    }

    /// The way without the errors that are new on it.
    pub(crate) fn exactly(self) -> Way {
        Way { sigma: [0.0; 3], ..self }
    }

    /// The pose that a robot reaches from a pose by the way with these errors. The error of the turn comes evenly along the way.
    pub(crate) fn from(&self, [x_m, y_m, heading_rad]: [f64; 3], errors: &Errors) -> [f64; 3] {
        let off = |axis: usize| {
            let lasting = self.lasting.iter().zip(&errors.lasting).map(|(by, error)| by[axis] * error).sum::<f64>();
            self.sigma[axis] * errors.new[axis] + lasting
        };
        let off_rad = off(2) - errors.bias_rad_per_s * self.biased_s;
        let travel = [self.moved[0] + off(0), self.moved[1] + off(1)];
        let [dx, dy] = turned(travel, heading_rad + 0.5 * off_rad);
        [x_m + dx, y_m + dy, heading_rad + self.moved[2] + off_rad]
    }
}
