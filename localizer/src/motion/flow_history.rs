//! From the counts of a flow sensor to an enclosure of the motion between two stamps.

use std::collections::VecDeque;

use crate::robot::{FlowModel, Reach, WheelModel};

use super::{FlowIntegral, GyroHistory, Motion, gyro::greatest_change_rad_per_s2};

/// Recent readings of a flow sensor.
#[derive(Clone, Debug)]
pub struct FlowHistory {
    model: FlowModel,
    readings: VecDeque<FlowReading>,
    keep_s: f64,
}

/// Reading of a flow sensor: the totals that it has counted up to one stamp.
#[derive(Clone, Copy, Debug)]
struct FlowReading {
    time_s: f64,
    counts: [i64; 2],
    blind_periods: u64,
}

/// Time difference below which two stamps are the same instant: periods are decimal numbers, stamps binary ones.
const SAME_S: f64 = 1e-9;

impl FlowHistory {
    /// A history that forgets flow sensor readings older than `keep_s`.
    pub fn new(model: FlowModel, keep_s: f64) -> Self {
        FlowHistory { model, readings: VecDeque::new(), keep_s }
    }

    /// Adds a flow sensor reading at its place in time, as totals need not arrive in order; a duplicate is dropped.
    pub fn push(&mut self, time_s: f64, counts: [i64; 2], blind_periods: u64) {
        let place = self.readings.partition_point(|reading| reading.time_s < time_s - SAME_S);
        if self.readings.get(place).is_some_and(|reading| reading.time_s <= time_s + SAME_S) {
            return;
        }
        self.readings.insert(place, FlowReading { time_s, counts, blind_periods });
        let latest_s = self.readings.back().map_or(time_s, |latest| latest.time_s);
        while self.readings.front().is_some_and(|first| first.time_s < latest_s - self.keep_s) {
            self.readings.pop_front();
        }
    }

    /// Motion from `from_s` to a later `to_s` by the flow sensor, with the turn by the gyroscope. It is `None` without a gyroscope, where the
    /// readings do not cover the span of time, and where the flow sensor saw nothing for a period.
    ///
    /// Between two readings the travel is interpolated. The sensor's place accelerates by at most A := a + v·ω + (α + ω²)·arm, with the limits a
    /// and v of acceleration and speed and ω and α of the turn rate and its change. So in a time T the place departs from the chord by at most
    /// A·T²/8, and goes back and forth by at most A·T²/4.
    pub fn motion(
        &self,
        [from_s, to_s]: [f64; 2],
        gyro: Option<&GyroHistory>,
        wheels: &WheelModel,
        reach: &Reach,
    ) -> Option<Motion> {
        if to_s < from_s {
            return None;
        }
        let first = self.readings.partition_point(|reading| reading.time_s <= from_s + SAME_S).checked_sub(1)?;
        let last = self.readings.partition_point(|reading| reading.time_s < to_s - SAME_S);
        let (begin, end) = (self.readings.get(first)?, self.readings.get(last)?);
        if begin.blind_periods != end.blind_periods {
            return None;
        }
        let change_rad_per_s2 = greatest_change_rad_per_s2(wheels, reach);
        let arm_m = self.model.position_m[0].magnitude() + self.model.position_m[1].magnitude();
        let turn_rate = reach.turn_rate_rad_per_s;
        let acceleration_m_per_s2 = reach.acceleration_m_per_s2
            + reach.speed_m_per_s * turn_rate
            + (change_rad_per_s2 + turn_rate * turn_rate) * arm_m;

        let mut turns = gyro.map(|gyro| gyro.turns_from(from_s, change_rad_per_s2));
        let mut integral = FlowIntegral::new();
        let (mut before_s, mut before) = (from_s, [0.0; 2]);
        let mut bent_m = 0.0;
        for idx in first..last {
            let (left, right) = (&self.readings[idx], &self.readings[idx + 1]);
            let span_s = right.time_s - left.time_s;
            let at = |time_s: f64| {
                let share = (time_s - left.time_s) / span_s;
                [0, 1].map(|axis| {
                    (left.counts[axis] - begin.counts[axis]) as f64
                        + share * (right.counts[axis] - left.counts[axis]) as f64
                })
            };
            if idx == first {
                before = if from_s > left.time_s + SAME_S { at(from_s) } else { [0.0; 2] };
            }
            let until_s = right.time_s.min(to_s);
            let now = if until_s < right.time_s - SAME_S { at(until_s) } else { at(right.time_s) };
            let is_cut = from_s > left.time_s + SAME_S || until_s < right.time_s - SAME_S;
            let cut_m = if is_cut { acceleration_m_per_s2 * span_s * span_s / 8.0 } else { 0.0 };
            bent_m += cut_m;
            let excess_m = cut_m + self.back_and_forth_m(span_s, acceleration_m_per_s2);
            let step_s = until_s - before_s;
            // Between two readings the robot may turn further than their difference shows, and back: by up to a quarter of `change_rad_per_s2`,
            // which bounds the change of the turn rate, times the time squared.
            let turning_rad = gyro?.turn(before_s, until_s, change_rad_per_s2)?.magnitude()
                + 0.25 * change_rad_per_s2 * step_s * step_s;
            let step = [now[0] - before[0], now[1] - before[1]];
            integral.advance(step, turns.as_mut()?.to(until_s)?, turning_rad, excess_m, &self.model);
            (before_s, before) = (until_s, now);
        }
        Some(integral.motion(bent_m, &self.model))
    }

    /// Greatest length by which the path of the flow sensor between two consecutive readings exceeds the distance between its positions at them.
    /// Where readings between the two are missing, the sensor may go back and forth in each of the missing periods, and from one period to the next
    /// as far as the acceleration allows.
    fn back_and_forth_m(&self, span_s: f64, acceleration_m_per_s2: f64) -> f64 {
        let n_periods = (span_s / self.model.period_s - 1e-6).ceil().max(1.0);
        let between_m = if n_periods > 1.0 { 0.25 * acceleration_m_per_s2 * span_s * span_s } else { 0.0 };
        n_periods * self.model.back_and_forth_m + between_m
    }
}
