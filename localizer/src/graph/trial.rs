//! What the tests of the graph share: draws at the corners of bounds, and a range camera, and drives whose every error is known.

use std::collections::BTreeMap;

use interval::Interval;
use nalgebra::{Rotation3, Vector3};

use crate::{
    motion::WheelHistory,
    robot::{BodyModel, FlowModel, GyroModel, RangeCameraModel, Reach, RobotModel, WheelModel},
};

use super::{Constant, Domain, Variable};

/// Number of rounds of a test at the corners of bounds: the environment variable `WHEREIN_ROWS` asks for so many times the usual number.
pub(crate) fn rounds(usual: usize) -> usize {
    usual * std::env::var("WHEREIN_ROWS").ok().and_then(|times| times.parse().ok()).unwrap_or(1)
}

/// Number of domains in which the rows of one drive are made, each with other widths and references of the poses: one, or where more rounds are asked
/// for, a hundred. To integrate a drive takes a hundred times as long as to make its rows.
pub(super) fn domains() -> usize {
    if rounds(1) > 1 { 100 } else { 1 }
}

/// Number of domains in which the same ways are used: a way by the flow sensor depends on what was known of the heading when it was computed.
pub(super) const DOMAINS_OF_A_WAY: usize = 10;

/// A generator of numbers that prefers the ends of intervals.
pub(crate) struct Draw(u64);

impl Draw {
    pub(crate) fn new(seed: u64) -> Draw {
        Draw(seed | 1)
    }

    /// A number from 0 to 1, by the generator xorshift64.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// A size between two, evenly on a logarithmic scale.
    pub(crate) fn size(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }

    /// The given number, or, one time in two, 0.
    pub(crate) fn or_zero(&mut self, value: f64) -> f64 {
        if self.unit() < 0.5 { 0.0 } else { value }
    }

    /// A number in an interval, three times in four at one of its ends.
    pub(crate) fn within(&mut self, values: Interval) -> f64 {
        match self.unit() {
            share if share < 0.375 => values.lo(),
            share if share < 0.75 => values.hi(),
            _ => self.between(values.lo(), values.hi()),
        }
    }
}

/// A tilt with its Cayley vector, of the greatest angle three times in four.
pub(crate) fn tilt(draw: &mut Draw, most_rad: f64) -> (Rotation3<f64>, [f64; 2]) {
    let course = draw.between(-std::f64::consts::PI, std::f64::consts::PI);
    let angle = draw.within(Interval::new(0.0, most_rad)).max(1e-12);
    let axis = Vector3::new(course.cos(), course.sin(), 0.0);
    let length = (0.5 * angle).tan();
    (Rotation3::new(axis * angle), [length * axis.x, length * axis.y])
}

/// The range camera of the tests, whose bounds are those that each test puts into its domain.
pub(crate) fn camera() -> RangeCameraModel {
    RangeCameraModel {
        focal_px: Interval::centred(400.0, 0.4),
        baseline_m: Interval::centred(0.12, 0.0003),
        centre_px: 319.5,
        step_px: [0.125; 2],
        position_m: [Interval::ZERO; 2],
        height_m: 0.3,
        yaw_rad: Interval::ZERO,
        tilt_rad: 0.0,
        height_span_m: 0.3,
        stamp_error_s: 0.0,
        latency_s: Interval::ZERO,
        period_s: 0.1,
        q_items: 0,
        wrong_spacing: 0,
    }
}

/// Slip ratio of the wheels and of the side slip in the tests.
pub(super) const SLIP: f64 = 0.02;
/// Greatest acceleration of a wheel in the tests.
const ACCELERATION_M_PER_S2: f64 = 1.5;
/// Greatest noise of one gyroscope reading in the tests.
const NOISE_RAD_PER_S: f64 = 0.004;
/// Bound `gyro.angle` in the tests: its constant part, and its part for each second.
const ANGLE_RAD: [f64; 2] = [0.0004, 0.0001];

pub(crate) fn wheels() -> WheelModel {
    WheelModel {
        radius_m: [Interval::centred(0.05, 0.0001); 2],
        track_m: Interval::centred(0.33, 0.001),
        ticks_per_turn: 1024.0,
        slip_ratio: SLIP,
        slip_floor_m: 0.0002,
        side_slip_ratio: SLIP,
        side_slip_floor_m: 0.0002,
        slip_window_s: 0.2,
    }
}

pub(crate) fn reach() -> Reach {
    Reach { speed_m_per_s: 2.0, turn_rate_rad_per_s: 4.0, acceleration_m_per_s2: ACCELERATION_M_PER_S2 * (1.0 + SLIP) }
}

pub(crate) fn gyro(has_angle: bool) -> GyroModel {
    GyroModel {
        bias_rad_per_s: Interval::centred(0.001, 0.002),
        scale: Interval::centred(1.0, 0.003),
        noise_rad_per_s: NOISE_RAD_PER_S,
        angle_floor_rad: if has_angle { ANGLE_RAD[0] } else { f64::INFINITY },
        angle_rad_per_s: if has_angle { ANGLE_RAD[1] } else { f64::INFINITY },
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.01,
    }
}

/// A robot with wheels, gyroscope and flow sensor.
pub(crate) fn robot() -> RobotModel {
    RobotModel {
        wheels: wheels(),
        reach: reach(),
        body: BodyModel { tilt_rad: 0.0, heave_m: 0.0, clearance_m: 0.1 },
        floor_camera: None,
        forward_camera: None,
        gyro: Some(gyro(true)),
        flow: Some(flow()),
        ceiling_camera: None,
        range_camera: None,
        steering: None,
    }
}

/// Bounds of the flow sensor in the tests.
pub(super) fn flow() -> FlowModel {
    FlowModel {
        position_m: [Interval::centred(-0.06, 0.002), Interval::centred(0.03, 0.002)],
        metres_per_count: Interval::centred(1e-4, 5e-7),
        scale_change: SCALE_CHANGE,
        yaw_rad: Interval::centred(0.01, 0.01),
        quantisation_counts: 1.0,
        back_and_forth_m: 0.0,
        period_s: 0.01,
    }
}

/// Share by which the flow sensor's scale varies in the tests.
const SCALE_CHANGE: f64 = 0.004;

/// What the sensors of a drive read at one stamp: ticks, turn rate, and counts of the flow sensor.
pub(super) struct Read {
    pub(super) time_s: f64,
    ticks: [i64; 2],
    rate_rad_per_s: f64,
    counts: [i64; 2],
}

/// A drive with all true values, at the corners of the bounds above.
pub(crate) struct Drive {
    has_angle: bool,
    /// What is read every 10 ms.
    pub(super) readings: Vec<Read>,
    /// The stamps of the key frames, the true poses there, and the bounded part of the accumulated angle error.
    pub(crate) stamps_s: Vec<f64>,
    pub(crate) poses: Vec<[f64; 3]>,
    angle_rad: Vec<f64>,
    /// Length of the whole path of the axle's middle.
    pub(super) path_m: f64,
    /// True values of the robot's constants.
    pub(super) constants: BTreeMap<Constant, f64>,
}

impl Drive {
    /// Draws a drive of 1 to 4 s with three key frames.
    pub(super) fn short(draw: &mut Draw, has_angle: bool) -> Drive {
        let lasts_s = draw.between(1.0, 4.0);
        Drive::new(draw, has_angle, lasts_s, 3)
    }

    /// Draws a drive, integrated in steps of 0.1 ms by the midpoint rule, with key frames at equal distances: on a reading or between two.
    pub(crate) fn new(draw: &mut Draw, has_angle: bool, lasts_s: f64, n_frames: usize) -> Drive {
        let mut constants = BTreeMap::new();
        let mut put = |constant, values: Interval| constants.insert(constant, draw.within(values));
        for side in 0..2 {
            put(Constant::MetresPerTick(side), wheels().metres_per_tick(side));
            put(Constant::FlowPosition(side), flow().position_m[side]);
        }
        put(Constant::Track, wheels().track_m);
        put(Constant::GyroScale, gyro(has_angle).scale);
        put(Constant::GyroBias, gyro(has_angle).bias_rad_per_s);
        put(Constant::FlowMetresPerCount, flow().metres_per_count);
        put(Constant::FlowYaw, flow().yaw_rad);
        let n_steps = (lasts_s * 100.0) as u32;
        let between = |draw: &mut Draw| if draw.unit() < 0.5 { 0 } else { (draw.unit() * 100.0) as u32 };
        let apart = (n_steps - 2) / (n_frames as u32 - 1);
        let stamps: Vec<u32> = (0..n_frames as u32).map(|frame| 100 * apart * frame + between(draw)).collect();
        let mut moving = Moving::new(draw, constants.clone(), has_angle);
        let (mut poses, mut angle_rad) = (Vec::new(), Vec::new());
        let mut readings = vec![moving.read(0.0)];
        for fine in 0..=100 * n_steps {
            if stamps.binary_search(&fine).is_ok() {
                poses.push(moving.pose);
                angle_rad.push(moving.summed_rad);
            }
            if fine % 100 == 0 {
                moving.push(draw);
            }
            moving.advance(draw);
            if fine % 100 == 99 {
                readings.push(moving.read(f64::from(fine + 1) * FINE_S));
            }
        }
        let stamps_s = stamps.iter().map(|&stamp| f64::from(stamp) * FINE_S).collect();
        Drive { has_angle, readings, stamps_s, poses, angle_rad, path_m: moving.path_m, constants }
    }

    /// The readings as the localizer keeps them.
    pub(crate) fn history(&self, has_gyro: bool) -> WheelHistory {
        let mut history = WheelHistory::new(1000.0).with_flow(flow());
        if has_gyro {
            history = history.with_gyro(gyro(self.has_angle));
        }
        for read in &self.readings {
            history.push(read.time_s, read.ticks);
            history.push_flow(read.time_s, read.counts, 0);
            if has_gyro && read.time_s > 0.0 {
                history.push_rate(read.time_s, read.rate_rad_per_s);
            }
        }
        history
    }

    /// A domain with the key frames' poses in boxes of random sizes, and with the constants; and the true values of all of them.
    pub(super) fn domain(&self, draw: &mut Draw) -> (Domain, BTreeMap<Variable, f64>) {
        let (mut domain, mut truth) = (Domain::default(), BTreeMap::new());
        let mut put = |variable, value: Interval, at: f64| {
            assert!(value.contains(at), "{variable:?}: {at} is not in {value}");
            domain.put(variable, value);
            truth.insert(variable, at);
        };
        for frame in 0..self.poses.len() {
            for (axis, &at) in self.poses[frame].iter().enumerate() {
                let half = draw.size(1e-4, 0.2);
                let off = draw.within(Interval::centred(0.0, half));
                put(Variable::Pose(frame, axis), Interval::centred(at + off, half * (1.0 + 1e-9)), at);
            }
            if self.has_angle {
                let values = Interval::centred(0.0, 0.5 * ANGLE_RAD[0]);
                put(Variable::GyroAngle(frame), values, self.angle_rad[frame]);
            }
        }
        let bounds = RobotBounds::new(self.has_angle);
        for (&constant, &at) in &self.constants {
            // One time in two the constant is known better by now than when the readings were summed up.
            let (declared, share) = (bounds.of(constant), draw.unit());
            let known = if draw.unit() < 0.5 {
                declared
            } else {
                declared.intersect(Interval::centred(at, share * declared.width()))
            };
            put(Variable::Constant(constant), known, at);
        }
        (domain, truth)
    }
}

/// The bounds of the constants in the tests.
struct RobotBounds {
    gyro: GyroModel,
}

impl RobotBounds {
    fn new(has_angle: bool) -> RobotBounds {
        RobotBounds { gyro: gyro(has_angle) }
    }

    fn of(&self, constant: Constant) -> Interval {
        match constant {
            Constant::MetresPerTick(wheel) => wheels().metres_per_tick(wheel),
            Constant::Track => wheels().track_m,
            Constant::GyroScale => self.gyro.scale,
            Constant::GyroBias => self.gyro.bias_rad_per_s,
            Constant::FlowMetresPerCount => flow().metres_per_count,
            Constant::FlowYaw => flow().yaw_rad,
            Constant::FlowPosition(side) => flow().position_m[side],
            _ => Interval::EMPTY,
        }
    }
}

/// Step of the integration.
const FINE_S: f64 = 1e-4;

/// The robot of a drive on its way.
struct Moving {
    constants: BTreeMap<Constant, f64>,
    has_angle: bool,
    slip: [f64; 2],
    side: f64,
    /// Part of the accumulated angle error that grows with time, per second.
    drift_rad_per_s: f64,
    speed: [f64; 2],
    acceleration: [f64; 2],
    noise: f64,
    pose: [f64; 3],
    rolled_m: [f64; 2],
    /// Turn since the last reading, and the bounded part of the accumulated angle error.
    turned_rad: f64,
    summed_rad: f64,
    counted: [f64; 2],
    path_m: f64,
    /// In which direction the flow sensor's scale errs: 1 or −1 along world x or y, or at random.
    errs: (usize, f64),
}

impl Moving {
    fn new(draw: &mut Draw, constants: BTreeMap<Constant, f64>, has_angle: bool) -> Moving {
        Moving {
            constants,
            has_angle,
            slip: [0, 1].map(|_| draw.within(Interval::centred(0.0, SLIP))),
            side: draw.within(Interval::centred(0.0, SLIP)),
            drift_rad_per_s: draw.within(Interval::centred(0.0, ANGLE_RAD[1])),
            speed: [draw.between(-0.3, 0.5), draw.between(-0.3, 0.5)],
            acceleration: [0.0; 2],
            noise: draw.within(Interval::centred(0.0, NOISE_RAD_PER_S)),
            pose: [draw.between(-3.0, 3.0), draw.between(-3.0, 3.0), draw.between(-4.0, 4.0)],
            rolled_m: [0.0; 2],
            turned_rad: 0.0,
            summed_rad: 0.0,
            counted: [draw.unit(), draw.unit()],
            path_m: 0.0,
            errs: ((draw.unit() * 3.0) as usize, if draw.unit() < 0.5 { -1.0 } else { 1.0 }),
        }
    }

    /// Another acceleration, and another noise, now and then; else the same, so that errors add up.
    fn push(&mut self, draw: &mut Draw) {
        if draw.unit() < 0.1 {
            self.acceleration = [0, 1].map(|_| draw.within(Interval::centred(0.0, ACCELERATION_M_PER_S2)));
        }
        if draw.unit() < 0.1 {
            self.noise = draw.within(Interval::centred(0.0, NOISE_RAD_PER_S));
        }
        for wheel in 0..2 {
            if (self.speed[wheel] + 0.01 * self.acceleration[wheel]).abs() > 0.6 {
                self.acceleration[wheel] = 0.0;
            }
        }
    }

    fn advance(&mut self, draw: &mut Draw) {
        let of = |constant| self.constants[&constant];
        let middle = [0, 1].map(|wheel| self.speed[wheel] + 0.5 * FINE_S * self.acceleration[wheel]);
        let travel = [0, 1].map(|wheel| middle[wheel] * FINE_S * (1.0 + self.slip[wheel]));
        let aside_m = self.side * 0.5 * FINE_S * (middle[0] + middle[1]);
        let (ahead_m, turn) = (0.5 * (travel[0] + travel[1]), (travel[1] - travel[0]) / of(Constant::Track));
        let (sin, cos) = (self.pose[2] + 0.5 * turn).sin_cos();
        self.pose[0] += ahead_m * cos - aside_m * sin;
        self.pose[1] += ahead_m * sin + aside_m * cos;
        self.pose[2] += turn;
        self.path_m += ahead_m.hypot(aside_m);
        self.turned_rad += turn;

        // The sensor's place moves with the axle's middle and by the turn times its lever arm.
        let arm_m = [0, 1].map(|side| of(Constant::FlowPosition(side)));
        let moved_m = [ahead_m - turn * arm_m[1], aside_m + turn * arm_m[0]];
        let in_world = [cos * moved_m[0] - sin * moved_m[1], sin * moved_m[0] + cos * moved_m[1]];
        let share = match self.errs {
            (axis @ (0 | 1), sign) => sign * in_world[axis].signum(),
            _ => draw.between(-1.0, 1.0),
        };
        let per_m = (1.0 + SCALE_CHANGE * share) / of(Constant::FlowMetresPerCount);
        let (sin, cos) = of(Constant::FlowYaw).sin_cos();
        self.counted[0] += (cos * moved_m[0] + sin * moved_m[1]) * per_m;
        self.counted[1] += (cos * moved_m[1] - sin * moved_m[0]) * per_m;
        (0..2).for_each(|wheel| {
            self.rolled_m[wheel] += middle[wheel] * FINE_S;
            self.speed[wheel] += FINE_S * self.acceleration[wheel];
        });
        // The angle error of the present noise, which is drawn back to its bound where it is bounded.
        if self.has_angle {
            let half = 0.5 * ANGLE_RAD[0];
            let next = (self.summed_rad + self.noise * FINE_S).clamp(-half, half);
            self.turned_rad += (next - self.summed_rad + self.drift_rad_per_s * FINE_S) / of(Constant::GyroScale);
            self.summed_rad = next;
        }
    }

    fn read(&mut self, time_s: f64) -> Read {
        let of = |constant| self.constants[&constant];
        let noise = if self.has_angle { 0.0 } else { self.noise };
        let rate = of(Constant::GyroScale) * self.turned_rad / 0.01 + of(Constant::GyroBias) + noise;
        self.turned_rad = 0.0;
        Read {
            time_s,
            ticks: [0, 1].map(|wheel| (self.rolled_m[wheel] / of(Constant::MetresPerTick(wheel))).floor() as i64),
            rate_rad_per_s: rate,
            counts: self.counted.map(|counts| counts.floor() as i64),
        }
    }
}
