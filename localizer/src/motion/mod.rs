//! From wheel readings to motion: an enclosure of where the robot has gone between two stamps.
//!
//! The enclosure uses the true arc of a differential drive, slip bounds with a constant part (floor) for each wheel, a bound on side slip, and
//! the robot's speed and acceleration limits (reach). A gyroscope, and a car's steering encoder, bound the turn besides. Over any span of time the
//! quantisation of the wheel encoders counts once, because a wheel's count is a difference of two latched totals.

mod about;
mod flow;
mod flow_history;
mod flow_way;
mod gyro;
mod gyro_errors;
mod integral;
mod odometry;
mod polygon;
mod slip_excess;
pub mod steering;
mod way;

use std::{borrow::Cow, collections::VecDeque};

use interval::{Interval, IntervalBox};

use crate::{
    PoseBox, PoseUnion,
    robot::{FlowModel, GyroModel, Reach, SteeringModel, WheelModel},
};

pub use flow::{Agreement, FlowIntegral, agree};
pub use flow_history::FlowHistory;
pub use flow_way::FlowWay;
pub use gyro::{GyroHistory, GyroTurn, SumSince, TurnsFrom, greatest_change_rad_per_s2, sudden_change_rad_per_s2};
pub use gyro_errors::GyroErrors;
pub use integral::{KnownTurns, WheelIntegral};
pub use odometry::PointOdometry;
pub use slip_excess::SlipExcess;
pub use steering::SteeringHistory;
pub use way::Way;

/// Longest time after the latest wheel reading for which motion is extrapolated from the readings. Beyond it the extrapolation's error, which
/// grows with the square of time, exceeds the distance at greatest speed, which grows in proportion to time.
pub const AHEAD_S: f64 = 0.25;

/// Motion of the robot in a span of time, as a box in the robot frame at the start of the span: forward and left in metres, turn in radians.
pub type Motion = IntervalBox<3>;

/// Nominal velocity of the robot at a stamp, by its wheels. It causes the motion blur in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed of the robot.
    pub forward_m_per_s: f64,
    /// Turn rate of the robot, counter-clockwise.
    pub turn_rad_per_s: f64,
}

/// Counts of both wheel encoders at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelSample {
    /// Time at which the encoder counters were latched.
    pub time_s: f64,
    /// Cumulative encoder ticks of the left and the right wheel; fractional when interpolated between two readings.
    pub ticks: [f64; 2],
    /// Bound on the interpolation error of the encoder ticks, in ticks; 0 at a reading.
    pub ticks_error: f64,
}

/// Recent readings of the wheel encoders, and of the gyroscope, the flow sensor and the steering encoder if the robot has them.
#[derive(Clone, Debug)]
pub struct WheelHistory {
    samples: VecDeque<WheelSample>,
    gyro: Option<GyroHistory>,
    flow: Option<FlowHistory>,
    steering: Option<SteeringHistory>,
    keep_s: f64,
    /// Spans of time in which the wheels slip by more than declared. The simulator, which knows the slip, gives them when it repeats a run with
    /// wider bounds.
    excesses: Vec<SlipExcess>,
}

impl WheelHistory {
    /// A history that forgets wheel readings older than `keep_s`.
    pub fn new(keep_s: f64) -> Self {
        WheelHistory { samples: VecDeque::new(), gyro: None, flow: None, steering: None, keep_s, excesses: Vec::new() }
    }

    /// The same history with a gyroscope, whose turn is intersected with that of the wheels.
    pub fn with_gyro(self, model: GyroModel) -> Self {
        WheelHistory { gyro: Some(GyroHistory::new(model, self.keep_s)), ..self }
    }

    /// The same history with a flow sensor, which measures the travel independently of the wheels and needs a gyroscope for the turn.
    pub fn with_flow(self, model: FlowModel) -> Self {
        WheelHistory { flow: Some(FlowHistory::new(model, self.keep_s)), ..self }
    }

    /// The same history with a steering encoder, whose turn is intersected with that of the wheels.
    pub fn with_steering(self, model: SteeringModel) -> Self {
        WheelHistory { steering: Some(SteeringHistory::new(model, self.keep_s)), ..self }
    }

    /// Sets the spans of time in which the wheels are known to slip by more than declared.
    pub fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.excesses = excesses;
    }

    /// The wheels' model with the slip bounds that hold over a span of time.
    pub fn model_over<'a>(&self, span_s: [f64; 2], wheels: &'a WheelModel) -> Cow<'a, WheelModel> {
        SlipExcess::over(&self.excesses, span_s, wheels)
    }

    /// Adds a reading of the flow sensor. Returns whether there was none of its stamp yet; `None` for a robot without the sensor.
    pub fn push_flow(&mut self, time_s: f64, counts: [i64; 2], blind_periods: u64) -> Option<bool> {
        Some(self.flow.as_mut()?.push(time_s, counts, blind_periods))
    }

    /// Motion by the flow sensor and the gyroscope, whatever the wheels do. It is `None` when the robot lacks one of these sensors, where their
    /// readings do not cover the time, and where the flow sensor saw nothing for a period.
    pub fn flow_motion(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Motion> {
        self.flow.as_ref()?.motion([from_s, to_s], self.gyro.as_ref(), wheels, reach)
    }

    /// The way of the flow sensor's place from `from_s` to `to_s`; `heading_rad` encloses the heading at `from_s`. `None` where
    /// [`flow_motion`](Self::flow_motion) is.
    pub fn flow_way(
        &self,
        from_s: f64,
        to_s: f64,
        heading_rad: Interval,
        wheels: &WheelModel,
        reach: &Reach,
    ) -> Option<FlowWay> {
        self.flow.as_ref()?.way([from_s, to_s], heading_rad, self.gyro.as_ref()?, wheels, reach)
    }

    /// Adds a reading of the steering encoder. Returns whether there was none of its stamp yet; `None` for a robot without one.
    pub fn push_steering(&mut self, time_s: f64, ticks: f64) -> Option<bool> {
        Some(self.steering.as_mut()?.push(time_s, ticks))
    }

    /// Adds a reading of the gyroscope. Returns whether it fits among those that have come before; `None` for a robot without a gyroscope.
    pub fn push_rate(&mut self, time_s: f64, rate_rad_per_s: f64) -> Option<bool> {
        Some(self.gyro.as_mut()?.push(time_s, rate_rad_per_s))
    }

    /// Replaces the gyroscope's bias and scale by intervals that are known better than the declared ones.
    pub fn learn_gyro(&mut self, bias_rad_per_s: Interval, scale: Interval) {
        if let Some(gyro) = &mut self.gyro {
            gyro.learn(bias_rad_per_s, scale);
        }
    }

    /// Stamp of the last wheel reading that is not later than a given time.
    pub fn reading_before(&self, time_s: f64) -> Option<f64> {
        let after = self.samples.partition_point(|sample| sample.time_s <= time_s);
        Some(self.samples.get(after.checked_sub(1)?)?.time_s)
    }

    /// Turn by the gyroscope between two stamps, for wheels that keep to their acceleration bound; `None` when there is no gyroscope, or no reading
    /// of it yet.
    pub fn gyro_turn(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Interval> {
        self.gyro.as_ref()?.turn(from_s, to_s, greatest_change_rad_per_s2(wheels, reach))
    }

    fn turns_from(&self, from_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<TurnsFrom<'_>> {
        Some(self.gyro.as_ref()?.turns_from(from_s, greatest_change_rad_per_s2(wheels, reach)))
    }

    /// Motion bounded by the robot's speed limits (reach) and by the gyroscope alone, whatever the wheels report; a gyroscope does not slip. Where
    /// the gyroscope reads more turn than the limits allow, one of the two is wrong, and the hull of both is kept. So the motion is never empty,
    /// and the localizer can rely on it when it distrusts everything else. From a stamp to an earlier one only the limits are used, which hold in
    /// that direction too.
    pub fn reach_motion(&self, from_s: f64, to_s: f64, reach: &Reach) -> Motion {
        let mut motion = reach_motion((to_s - from_s).abs(), reach);
        if to_s < from_s {
            return motion;
        }
        let turn = self
            .gyro
            .as_ref()
            .and_then(|gyro| gyro.turn(from_s, to_s, sudden_change_rad_per_s2(reach, gyro.period_s())));
        if let Some(turn) = turn {
            let both = motion[2].intersect(turn);
            motion[2] = if both.is_empty() { motion[2].hull(turn) } else { both };
        }
        motion
    }

    /// Carries an integral of the wheels' motion on to a sample, with the gyroscope's turn up to that sample.
    pub fn advance(&self, integral: &mut WheelIntegral, sample: &WheelSample, wheels: &WheelModel, reach: &Reach) {
        let turn_rad = self.gyro_turn(integral.start_s(), sample.time_s, wheels, reach);
        self.carry_on(integral, sample, turn_rad, wheels, reach);
    }

    /// Carries an integral on to a sample up to which the robot has turned by `turn_rad` since the integral's start, as far as the gyroscope tells.
    /// The turn in the step is known by the gyroscope, too, or of a robot without one by the robot's greatest turn rate.
    fn carry_on(
        &self,
        integral: &mut WheelIntegral,
        sample: &WheelSample,
        turn_rad: Option<Interval>,
        wheels: &WheelModel,
        reach: &Reach,
    ) {
        let step_s = [integral.latest_s(), sample.time_s];
        let in_step_rad = match &self.gyro {
            Some(gyro) => gyro.turn(step_s[0], step_s[1], greatest_change_rad_per_s2(wheels, reach)),
            None => Some(Interval::centred(0.0, reach.turn_rate_rad_per_s * (step_s[1] - step_s[0]).max(0.0))),
        };
        let steered = self.steering.as_ref().and_then(|steering| steering.between(step_s[0], step_s[1]));
        let known = KnownTurns { since_start_rad: turn_rad, in_step_rad, steered };
        integral.advance(sample, known, &self.model_over([integral.start_s(), sample.time_s], wheels), reach);
    }

    /// Adds a wheel reading and returns whether it was new. A reading no later than the last one is a duplicate and is dropped.
    pub fn push(&mut self, time_s: f64, ticks: [i64; 2]) -> bool {
        if self.latest().is_some_and(|latest| time_s <= latest.time_s) {
            return false;
        }
        self.samples.push_back(WheelSample { time_s, ticks: ticks.map(|count| count as f64), ticks_error: 0.0 });
        // One wheel reading older than the kept span stays, so that every stamp inside the span lies between two readings.
        while self.samples.len() > 2 && self.samples[1].time_s < time_s - self.keep_s {
            self.samples.pop_front();
        }
        true
    }

    /// Stamp of the earliest wheel reading in memory.
    pub fn earliest_s(&self) -> Option<f64> {
        Some(self.samples.front()?.time_s)
    }

    /// The latest wheel reading.
    pub fn latest(&self) -> Option<&WheelSample> {
        self.samples.back()
    }

    /// Encoder counts at `time_s`, linear between the readings around that time; `None` outside of the history.
    ///
    /// The travel of a wheel that accelerates by at most a departs from the chord of a time interval T by at most a·T²/8.
    pub fn at(&self, time_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<WheelSample> {
        let after = self.samples.partition_point(|sample| sample.time_s < time_s);
        let right = self.samples.get(after)?;
        if right.time_s == time_s {
            return Some(*right);
        }
        let left = self.samples.get(after.checked_sub(1)?)?;
        let span_s = right.time_s - left.time_s;
        let share = (time_s - left.time_s) / span_s;
        let ticks = [0, 1].map(|wheel| left.ticks[wheel] + share * (right.ticks[wheel] - left.ticks[wheel]));
        let bend_m = reach.acceleration_m_per_s2 * span_s * span_s / 8.0;
        let least_m_per_tick = wheels.metres_per_tick(0).lo().min(wheels.metres_per_tick(1).lo());
        Some(WheelSample { time_s, ticks, ticks_error: bend_m / least_m_per_tick })
    }

    /// Encoder counts extrapolated to a time up to [`AHEAD_S`] after the latest reading, with a bound on how far the wheels can have changed
    /// their rate since then; `None` for later times, and before there are two readings.
    ///
    /// Over the last T before the latest reading the mean rate is known to within one tick and the wheel's slip in T. No rate within T departs
    /// from the rate at its end by more than a·T, so that the mean departs from it by at most a·T/2. At a time h after the reading the count is
    /// then off by h·((1 + slip)/T + a·T/2) + a·h²/2, with T chosen where that is least.
    fn ahead(&self, time_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<WheelSample> {
        let latest = self.latest()?;
        let ahead_s = time_s - latest.time_s;
        if !(0.0..=AHEAD_S).contains(&ahead_s) {
            return None;
        }
        let least_m_per_tick = wheels.metres_per_tick(0).lo().min(wheels.metres_per_tick(1).lo());
        let change = reach.acceleration_m_per_s2 / least_m_per_tick;
        let wheels = self.model_over([self.samples.front()?.time_s, time_s], wheels);
        let rate_error = |before: &WheelSample| {
            let span_s = latest.time_s - before.time_s;
            let counted = [0, 1].map(|wheel| (latest.ticks[wheel] - before.ticks[wheel]).abs() + 1.0);
            let slip = wheels.slip_ratio * counted[0].max(counted[1]) + wheels.slip_floor_m / least_m_per_tick;
            (1.0 + slip) / span_s + 0.5 * change * span_s
        };
        let earlier = self.samples.iter().filter(|sample| sample.time_s < latest.time_s);
        let before = earlier.min_by(|a, b| rate_error(a).total_cmp(&rate_error(b)))?;
        let rate = [0, 1].map(|wheel| (latest.ticks[wheel] - before.ticks[wheel]) / (latest.time_s - before.time_s));
        let ticks = [0, 1].map(|wheel| latest.ticks[wheel] + rate[wheel] * ahead_s);
        let ticks_error = ahead_s * rate_error(before) + 0.5 * change * ahead_s * ahead_s;
        Some(WheelSample { time_s, ticks, ticks_error: ticks_error * (1.0 + 1e-9) })
    }

    /// The integral of the wheels' motion from `from_s` on, through every later reading; `None` if `from_s` lies outside of the history.
    pub fn integrate_from(&self, from_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<WheelIntegral> {
        let mut integral = WheelIntegral::new(self.at(from_s, wheels, reach)?);
        let next = self.samples.partition_point(|sample| sample.time_s <= from_s);
        let mut turns = self.turns_from(from_s, wheels, reach);
        for sample in self.samples.iter().skip(next) {
            let turn_rad = turns.as_mut().and_then(|turns| turns.to(sample.time_s));
            self.carry_on(&mut integral, sample, turn_rad, wheels, reach);
        }
        Some(integral)
    }

    /// Motion from `from_s` to `to_s` by the wheels, and by the gyroscope if there is one. It is `None` if `from_s` lies outside of the history,
    /// or if `to_s` is more than [`AHEAD_S`] after its end or earlier than `from_s`: a motion backward in time must not be taken for no motion.
    pub fn motion(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Motion> {
        if to_s < from_s {
            return None;
        }
        let mut integral = WheelIntegral::new(self.at(from_s, wheels, reach)?);
        let next = self.samples.partition_point(|sample| sample.time_s <= from_s);
        let mut turns = self.turns_from(from_s, wheels, reach);
        let end = self.at(to_s, wheels, reach).or_else(|| self.ahead(to_s, wheels, reach))?;
        let between = self.samples.iter().skip(next).take_while(|sample| sample.time_s < to_s);
        for sample in between.chain([&end]) {
            let turn_rad = turns.as_mut().and_then(|turns| turns.to(sample.time_s));
            self.carry_on(&mut integral, sample, turn_rad, wheels, reach);
        }
        Some(integral.motion(&self.model_over([from_s, to_s], wheels)))
    }

    /// Nominal velocity of the robot at `time_s`, from the wheel counts between a reading about two readings earlier and one about two readings
    /// later; zero where there are no readings.
    pub fn twist(&self, time_s: f64, wheels: &WheelModel) -> Twist {
        // Two wheel readings on each side are used, because one alone resolves a speed no better than one tick per period.
        let middle = self.samples.partition_point(|sample| sample.time_s < time_s);
        let first = middle.saturating_sub(2);
        let last = (middle + 2).min(self.samples.len().saturating_sub(1));
        let (Some(left), Some(right)) = (self.samples.get(first), self.samples.get(last)) else {
            return Twist::default();
        };
        let span_s = right.time_s - left.time_s;
        if span_s <= 0.0 {
            return Twist::default();
        }
        let speed =
            [0, 1].map(|wheel| wheels.metres_per_tick(wheel).mid() * (right.ticks[wheel] - left.ticks[wheel]) / span_s);
        Twist {
            forward_m_per_s: 0.5 * (speed[0] + speed[1]),
            turn_rad_per_s: (speed[1] - speed[0]) / wheels.track_m.mid(),
        }
    }
}

impl WheelModel {
    /// Distance that the left (0) or right (1) wheel rolls in one encoder tick.
    pub fn metres_per_tick(&self, wheel: usize) -> Interval {
        self.radius_m[wheel] * (Interval::PI * 2.0 / self.ticks_per_turn)
    }
}

/// Motion in the time `span_s` of anything that keeps to the speed limits `reach`: it may go anywhere within speed times time.
pub fn reach_motion(span_s: f64, reach: &Reach) -> Motion {
    let distance = Interval::centred(0.0, reach.speed_m_per_s * span_s);
    IntervalBox::from([distance, distance, Interval::centred(0.0, reach.turn_rate_rad_per_s * span_s)])
}

/// The poses `pose ⊕ motion` that are reached from `pose` by `motion`, which is given in the frame of `pose`.
///
/// x′ = x + f·cos θ − l·sin θ, y′ = y + f·sin θ + l·cos θ, θ′ = θ + turn, with the motion f forward and l to the left.
pub fn moved(pose: &PoseBox, motion: &Motion) -> PoseBox {
    if pose.is_empty() {
        return PoseBox::EMPTY;
    }
    let (cos, sin) = (pose[2].cos(), pose[2].sin());
    IntervalBox::from([
        pose[0] + motion[0] * cos - motion[1] * sin,
        pose[1] + motion[0] * sin + motion[1] * cos,
        pose[2] + motion[2],
    ])
}

/// Moves every box of a union of pose boxes by `motion`.
pub fn moved_union(union: &PoseUnion, motion: &Motion) -> PoseUnion {
    PoseUnion { branches: union.branches.iter().map(|branch| moved(branch, motion)).collect() }
}
