//! Wheels to motion: an enclosure of where the robot has gone between two stamps.
//!
//! The true arc of a differential drive, per-wheel bounds with a floor, side slip, and reach. Ticks telescope: over any span
//! the quantisation counts once, because a wheel's count is a difference of two latched totals.

mod flow;
mod flow_history;
mod gyro;
mod gyro_errors;
mod integral;
mod odometry;
mod polygon;
mod slip_excess;

use std::{borrow::Cow, collections::VecDeque};

use interval::{Interval, IntervalBox};

use crate::{
    PoseBox, PoseUnion,
    robot::{FlowModel, GyroModel, Reach, WheelModel},
};

pub use flow::{Agreement, FlowIntegral, agree};
pub use flow_history::FlowHistory;
pub use gyro::{GyroHistory, TurnsFrom, greatest_change_rad_per_s2, sudden_change_rad_per_s2};
pub use gyro_errors::GyroErrors;
pub use integral::WheelIntegral;
pub use odometry::PointOdometry;
pub use slip_excess::SlipExcess;

/// Wheels tell the way so far ahead of their latest reading: later, a way that grows with the square of time is wider than one that grows
/// with the greatest speed.
pub const AHEAD_S: f64 = 0.25;

/// Motion of the robot relative to its first pose, in that pose's robot frame: forward, left (metres), turn (radians).
pub type Motion = IntervalBox<3>;

/// Body motion at a stamp as the wheels tell it: where the blur in an image comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed.
    pub forward_m_per_s: f64,
    /// Turn rate, counter-clockwise.
    pub turn_rad_per_s: f64,
}

/// Encoder counts at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelSample {
    /// When the counters were latched.
    pub time_s: f64,
    /// Cumulative ticks, left and right; fractional when interpolated between two readings.
    pub ticks: [f64; 2],
    /// Bound of the interpolation's error, in ticks; 0 at a reading.
    pub ticks_error: f64,
}

/// Recent encoder readings, and those of the gyroscope and of the flow sensor if there are such.
#[derive(Clone, Debug)]
pub struct WheelHistory {
    samples: VecDeque<WheelSample>,
    gyro: Option<GyroHistory>,
    flow: Option<FlowHistory>,
    keep_s: f64,
    /// Spans in which the wheels slip by more than declared, as somebody knows who saw them.
    excesses: Vec<SlipExcess>,
}

impl WheelHistory {
    /// A history that forgets what is older than `keep_s`.
    pub fn new(keep_s: f64) -> Self {
        WheelHistory { samples: VecDeque::new(), gyro: None, flow: None, keep_s, excesses: Vec::new() }
    }

    /// The same with a gyroscope, whose turn is intersected with that of the wheels.
    pub fn with_gyro(self, model: GyroModel) -> Self {
        WheelHistory { gyro: Some(GyroHistory::new(model, self.keep_s)), ..self }
    }

    /// The same with a flow sensor, which sees its own way beside the wheels and needs a gyroscope to know the turn.
    pub fn with_flow(self, model: FlowModel) -> Self {
        WheelHistory { flow: Some(FlowHistory::new(model, self.keep_s)), ..self }
    }

    /// Takes over where the wheels slip by more than declared.
    pub fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.excesses = excesses;
    }

    /// The wheels' model as it holds over a span.
    pub fn model_over<'a>(&self, span_s: [f64; 2], wheels: &'a WheelModel) -> Cow<'a, WheelModel> {
        SlipExcess::over(&self.excesses, span_s, wheels)
    }

    /// Adds a reading of the flow sensor.
    pub fn push_flow(&mut self, time_s: f64, counts: [i64; 2], blind_periods: u64) {
        if let Some(flow) = &mut self.flow {
            flow.push(time_s, counts, blind_periods);
        }
    }

    /// Motion as flow sensor and gyroscope tell it, whatever the wheels do; `None` without them, and where the flow sensor saw nothing.
    pub fn flow_motion(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Motion> {
        self.flow.as_ref()?.motion([from_s, to_s], self.gyro.as_ref(), wheels, reach)
    }

    /// Adds a reading of the gyroscope.
    pub fn push_rate(&mut self, time_s: f64, rate_rad_per_s: f64) {
        if let Some(gyro) = &mut self.gyro {
            gyro.push(time_s, rate_rad_per_s);
        }
    }

    /// Takes over a bias and a scale of the gyroscope that are known better than declared.
    pub fn learn_gyro(&mut self, bias_rad_per_s: Interval, scale: Interval) {
        if let Some(gyro) = &mut self.gyro {
            gyro.learn(bias_rad_per_s, scale);
        }
    }

    /// Stamp of the last wheel reading that is not after a time.
    pub fn reading_before(&self, time_s: f64) -> Option<f64> {
        let after = self.samples.partition_point(|sample| sample.time_s <= time_s);
        Some(self.samples.get(after.checked_sub(1)?)?.time_s)
    }

    /// Turn as the gyroscope tells it, with wheels that keep their acceleration; `None` without one.
    pub fn gyro_turn(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Interval> {
        self.gyro.as_ref()?.turn(from_s, to_s, greatest_change_rad_per_s2(wheels, reach))
    }

    fn turns_from(&self, from_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<TurnsFrom<'_>> {
        Some(self.gyro.as_ref()?.turns_from(from_s, greatest_change_rad_per_s2(wheels, reach)))
    }

    /// Motion by reach alone, whatever the wheels say; the gyroscope does not slip. Where it reads more than reach allows, one of the two is
    /// wrong, and both are kept: what is left when everything else is doubted is never nothing. To an earlier stamp reach tells as much as to a later one.
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

    /// Carries an integral on to a sample, with the gyroscope's turn up to it.
    pub fn advance(&self, integral: &mut WheelIntegral, sample: &WheelSample, wheels: &WheelModel, reach: &Reach) {
        let turn = self.gyro_turn(integral.start_s(), sample.time_s, wheels, reach);
        integral.advance(sample, turn, &self.model_over([integral.start_s(), sample.time_s], wheels), reach);
    }

    /// Adds a reading; a reading no later than the last one is a duplicate and is dropped. Returns whether it was new.
    pub fn push(&mut self, time_s: f64, ticks: [i64; 2]) -> bool {
        if self.latest().is_some_and(|latest| time_s <= latest.time_s) {
            return false;
        }
        self.samples.push_back(WheelSample { time_s, ticks: ticks.map(|count| count as f64), ticks_error: 0.0 });
        // One sample older than the span stays, so that every stamp inside it lies between two samples.
        while self.samples.len() > 2 && self.samples[1].time_s < time_s - self.keep_s {
            self.samples.pop_front();
        }
        true
    }

    /// The newest reading.
    pub fn latest(&self) -> Option<&WheelSample> {
        self.samples.back()
    }

    /// Counts at `time_s`, linear between the readings around it; `None` outside of the history.
    ///
    /// A wheel that accelerates by at most a departs from the chord of an interval T by at most a·T²/8.
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

    /// Counts at a time up to [`AHEAD_S`] after the latest reading, as far as the wheels can have changed their rate since; `None` later,
    /// and before there are two readings.
    ///
    /// Over the last T before the latest reading the mean rate is known to a tick and to what the wheel may slip in T, and no rate in it
    /// departs from that of its end by more than a·T, so that the mean departs by at most a·T/2. A time h later the count is off by
    /// h·((1 + slip)/T + a·T/2) + a·h²/2, with T chosen where that is least.
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

    /// The wheels' integral from `from_s` on, through every reading since; `None` if `from_s` lies outside of the history.
    pub fn integrate_from(&self, from_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<WheelIntegral> {
        let mut integral = WheelIntegral::new(self.at(from_s, wheels, reach)?);
        let next = self.samples.partition_point(|sample| sample.time_s <= from_s);
        let mut turns = self.turns_from(from_s, wheels, reach);
        for sample in self.samples.iter().skip(next) {
            let turn = turns.as_mut().and_then(|turns| turns.to(sample.time_s));
            integral.advance(sample, turn, &self.model_over([from_s, sample.time_s], wheels), reach);
        }
        Some(integral)
    }

    /// Motion from `from_s` to `to_s`; `None` if `from_s` lies outside of the history, or `to_s` more than [`AHEAD_S`] after it, and to an
    /// earlier stamp: a way back is not a stand.
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
            let turn = turns.as_mut().and_then(|turns| turns.to(sample.time_s));
            integral.advance(sample, turn, &self.model_over([from_s, sample.time_s], wheels), reach);
        }
        Some(integral.motion(&self.model_over([from_s, to_s], wheels)))
    }

    /// Nominal body motion at `time_s`, from the readings up to 20 ms around it; zero where there are none.
    pub fn twist(&self, time_s: f64, wheels: &WheelModel) -> Twist {
        // Two readings on each side: one alone resolves a speed no better than a tick per period.
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
    /// Rolled distance of one tick of the left (0) or right (1) wheel.
    pub fn metres_per_tick(&self, wheel: usize) -> Interval {
        self.radius_m[wheel] * (Interval::PI * 2.0 / self.ticks_per_turn)
    }
}

/// Motion of anything that keeps to its reach for `span_s`: it may go anywhere within speed times time.
pub fn reach_motion(span_s: f64, reach: &Reach) -> Motion {
    let distance = Interval::centred(0.0, reach.speed_m_per_s * span_s);
    IntervalBox::from([distance, distance, Interval::centred(0.0, reach.turn_rate_rad_per_s * span_s)])
}

/// `pose ⊕ motion`: the poses reached from `pose` by `motion`, which is given in the frame of `pose`.
///
/// x′ = x + f·cos θ − l·sin θ, y′ = y + f·sin θ + l·cos θ, θ′ = θ + turn.
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

/// Every branch of `union`, moved.
pub fn moved_union(union: &PoseUnion, motion: &Motion) -> PoseUnion {
    PoseUnion { branches: union.branches.iter().map(|branch| moved(branch, motion)).collect() }
}
