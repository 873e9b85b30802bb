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

/// Step of the flow sensor from one reading to the next, or the part of it that lies in a span of time.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlowStep {
    /// Times at which the step begins and ends.
    pub(super) from_s: f64,
    pub(super) until_s: f64,
    /// Counts at the step's begin and at its end, since the reading before the span.
    pub(super) from: [f64; 2],
    pub(super) to: [f64; 2],
    /// Stamps of the two readings.
    pub(super) readings_s: [f64; 2],
    /// At its begin and at its end, the greatest distance of the sensor's place from the place interpolated between two readings; 0 at a reading.
    pub(super) cut_m: [f64; 2],
    /// Greatest length by which the path of the step is longer than the distance between its ends, on either axis.
    pub(super) excess_m: f64,
}

impl FlowStep {
    /// Number of parts into which the step is divided, so that none is much longer than a period of the gyroscope.
    pub(super) fn n_nodes(&self, period_s: f64) -> usize {
        ((self.until_s - self.from_s) / period_s).round().clamp(1.0, 8.0) as usize
    }

    /// Stamps at which the parts of the step end.
    pub(super) fn nodes_s(&self, period_s: f64) -> Vec<f64> {
        let n_parts = self.n_nodes(period_s);
        let part_s = (self.until_s - self.from_s) / n_parts as f64;
        (1..n_parts).map(|part| self.from_s + part as f64 * part_s).chain([self.until_s]).collect()
    }

    /// Stamps of the readings from which the counts at the step's begin (0) or end (1) come: twice the same one, unless the counts are interpolated.
    pub(super) fn beside_s(&self, side: usize) -> [f64; 2] {
        if self.cut_m[side] > 0.0 { self.readings_s } else { [self.readings_s[side]; 2] }
    }
}

/// Time difference below which two stamps are the same instant: periods are decimal numbers, stamps binary ones.
const SAME_S: f64 = 1e-9;

impl FlowHistory {
    /// A history that forgets flow sensor readings older than `keep_s`.
    pub fn new(model: FlowModel, keep_s: f64) -> Self {
        FlowHistory { model, readings: VecDeque::new(), keep_s }
    }

    /// Adds a flow sensor reading at its place in time, as totals need not arrive in order; a duplicate is dropped.
    pub fn push(&mut self, time_s: f64, counts: [i64; 2], blind_periods: u64) -> bool {
        let place = self.readings.partition_point(|reading| reading.time_s < time_s - SAME_S);
        if self.readings.get(place).is_some_and(|reading| reading.time_s <= time_s + SAME_S) {
            return false;
        }
        self.readings.insert(place, FlowReading { time_s, counts, blind_periods });
        let latest_s = self.readings.back().map_or(time_s, |latest| latest.time_s);
        while self.readings.front().is_some_and(|first| first.time_s < latest_s - self.keep_s) {
            self.readings.pop_front();
        }
        true
    }

    /// The model of the flow sensor.
    pub(super) fn model(&self) -> &FlowModel {
        &self.model
    }

    /// Motion from `from_s` to a later `to_s` by the flow sensor, with the turn by the gyroscope. It is `None` without a gyroscope, where the
    /// readings do not cover the span of time, and where the flow sensor saw nothing for a period.
    pub fn motion(
        &self,
        [from_s, to_s]: [f64; 2],
        gyro: Option<&GyroHistory>,
        wheels: &WheelModel,
        reach: &Reach,
    ) -> Option<Motion> {
        let change_rad_per_s2 = greatest_change_rad_per_s2(wheels, reach);
        let steps = self.steps([from_s, to_s], self.acceleration_m_per_s2(change_rad_per_s2, reach))?;
        let mut turns = gyro.map(|gyro| gyro.turns_from(from_s, change_rad_per_s2));
        let mut integral = FlowIntegral::new();
        let (mut before_s, mut bent_m) = (from_s, 0.0);
        for step in steps {
            let step_s = step.until_s - before_s;
            // Between two readings the robot may turn further than their difference shows, and back: by up to a quarter of `change_rad_per_s2`,
            // which bounds the change of the turn rate, times the time squared.
            let turning_rad = gyro?.turn(before_s, step.until_s, change_rad_per_s2)?.magnitude()
                + 0.25 * change_rad_per_s2 * step_s * step_s;
            let counts = [0, 1].map(|axis| step.to[axis] - step.from[axis]);
            integral.advance(counts, turns.as_mut()?.to(step.until_s)?, turning_rad, step.excess_m, &self.model);
            bent_m += step.cut_m[0].max(step.cut_m[1]);
            before_s = step.until_s;
        }
        Some(integral.motion(bent_m, &self.model))
    }

    /// Greatest acceleration of the sensor's place: A := a + v·ω + (α + ω²)·arm, with the limits a and v of acceleration and speed and ω and α of
    /// the turn rate and its change.
    pub(super) fn acceleration_m_per_s2(&self, change_rad_per_s2: f64, reach: &Reach) -> f64 {
        let arm_m = self.model.position_m[0].magnitude() + self.model.position_m[1].magnitude();
        let turn_rate = reach.turn_rate_rad_per_s;
        reach.acceleration_m_per_s2
            + reach.speed_m_per_s * turn_rate
            + (change_rad_per_s2 + turn_rate * turn_rate) * arm_m
    }

    /// The steps between the readings in a span of time, the first and the last one cut at the ends of the span. `None` where the readings do not
    /// cover the span, and where the flow sensor saw nothing for a period.
    ///
    /// Between two readings the travel is interpolated: in a time T the place departs from the chord by at most A·T²/8, and goes back and forth by
    /// at most A·T²/4.
    pub(super) fn steps(&self, [from_s, to_s]: [f64; 2], acceleration_m_per_s2: f64) -> Option<Vec<FlowStep>> {
        if to_s < from_s {
            return None;
        }
        let first = self.readings.partition_point(|reading| reading.time_s <= from_s + SAME_S).checked_sub(1)?;
        let last = self.readings.partition_point(|reading| reading.time_s < to_s - SAME_S);
        let (begin, end) = (self.readings.get(first)?, self.readings.get(last)?);
        if begin.blind_periods != end.blind_periods {
            return None;
        }
        let mut steps = Vec::with_capacity(last.saturating_sub(first));
        for (left, right) in self.readings.range(first..last).zip(self.readings.range(first + 1..=last)) {
            let span_s = right.time_s - left.time_s;
            let counts_at = |time_s: f64| {
                let share = (time_s - left.time_s) / span_s;
                [0, 1].map(|axis| {
                    (left.counts[axis] - begin.counts[axis]) as f64
                        + share * (right.counts[axis] - left.counts[axis]) as f64
                })
            };
            let counts_of =
                |reading: &FlowReading| [0, 1].map(|axis| (reading.counts[axis] - begin.counts[axis]) as f64);
            let is_cut = [from_s > left.time_s + SAME_S, to_s < right.time_s - SAME_S];
            let bent_m = acceleration_m_per_s2 * span_s * span_s / 8.0;
            let cut_m = is_cut.map(|is_cut| if is_cut { bent_m } else { 0.0 });
            steps.push(FlowStep {
                from_s: if is_cut[0] { from_s } else { left.time_s },
                until_s: if is_cut[1] { to_s } else { right.time_s },
                from: if is_cut[0] { counts_at(from_s) } else { counts_of(left) },
                to: if is_cut[1] { counts_at(to_s) } else { counts_of(right) },
                readings_s: [left.time_s, right.time_s],
                cut_m,
                excess_m: cut_m[0].max(cut_m[1]) + self.back_and_forth_m(span_s, acceleration_m_per_s2),
            });
        }
        Some(steps)
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
