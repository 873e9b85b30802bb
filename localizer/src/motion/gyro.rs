//! From the turn rates of a gyroscope to an enclosure of the turn between two stamps.
//!
//! A reading r averages ω = (r − bias − noise)/scale over the period before its stamp. The scale is the same in all readings, and so is the bias
//! but for a slow change; their bounds therefore apply to the sum of readings. Noise is bounded for each reading, so that its bounds add up.
//! Besides, noise may be bounded over any span of time, together with the departure of the bias from the bias of the whole run.

use std::collections::VecDeque;

use interval::Interval;

use crate::{
    bounds,
    bounds::Assumption,
    robot::{GyroModel, Reach, WheelModel},
};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod lost;
mod sums;

use sums::{Sums, Walk};

/// Recent turn rates read from a gyroscope.
#[derive(Clone, Debug)]
pub struct GyroHistory {
    model: GyroModel,
    /// Gyroscope bias of the whole run, from which the mean bias of any span of time departs by no more than the declared bound `gyro.angle` on the
    /// accumulated angle error allows.
    run_bias_rad_per_s: Interval,
    /// Stamp and turn rate of each gyroscope reading.
    readings: VecDeque<(f64, f64)>,
    keep_s: f64,
}

/// Time difference below which two stamps are the same instant: periods are decimal numbers, stamps binary ones.
const SAME_S: f64 = 1e-9;

/// Fraction of a period by which the periods that two gyroscope readings average over may overlap without one of them counting as a duplicate:
/// stamps are rounded.
const PERIOD_S_SLACK: f64 = 1e-3;

impl GyroHistory {
    /// A history that forgets gyroscope readings older than `keep_s`.
    pub fn new(model: GyroModel, keep_s: f64) -> Self {
        GyroHistory { model, run_bias_rad_per_s: model.bias_rad_per_s, readings: VecDeque::new(), keep_s }
    }

    /// Span of time that a gyroscope reading averages over.
    pub(super) fn period_s(&self) -> f64 {
        self.model.period_s
    }

    /// The declared bound on the gyroscope's errors beside bias and scale.
    pub(super) fn noise_bound(&self) -> Assumption {
        if self.model.bounds_angle() { bounds::GYRO_ANGLE } else { bounds::GYRO_NOISE }
    }

    /// Adds a gyroscope reading at the place of its period in time. A late reading is dropped if its period overlaps that of another reading, as
    /// a duplicate's does, or if it is older than all readings in memory.
    pub fn push(&mut self, time_s: f64, rate_rad_per_s: f64) -> bool {
        let place = self.readings.partition_point(|(end_s, _)| *end_s < time_s);
        let begin_s = time_s - self.model.period_s;
        let before = place.checked_sub(1).and_then(|idx| self.readings.get(idx));
        let after = self.readings.get(place);
        let overlaps = before.is_some_and(|(end_s, _)| begin_s < end_s - PERIOD_S_SLACK * self.model.period_s)
            || after
                .is_some_and(|(end_s, _)| end_s - self.model.period_s < time_s - PERIOD_S_SLACK * self.model.period_s);
        let is_late = self.readings.back().is_some_and(|(latest_s, _)| time_s <= latest_s + SAME_S);
        if is_late && (overlaps || before.is_none()) {
            return false;
        }
        self.readings.insert(place, (time_s, rate_rad_per_s));
        let latest_s = self.readings.back().map_or(time_s, |(latest_s, _)| *latest_s);
        while self.readings.front().is_some_and(|(first_s, _)| *first_s < latest_s - self.keep_s) {
            self.readings.pop_front();
        }
        true
    }

    /// Turn by the gyroscope from `from_s` to `to_s`, while turn rates change by at most `change_rad_per_s2`; `None` before the first reading has
    /// arrived, and if `to_s` is earlier than `from_s`.
    ///
    /// Inside the period T of a reading the heading departs from the chord by at most change·T²/8. In time that no reading covers, the robot is
    /// taken to turn at the rate of the reading beside it, plus or minus what the rate can have changed by in the time between.
    pub fn turn(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        self.turns_from(from_s, change_rad_per_s2).to(to_s)
    }

    /// Sum of the gyroscope's readings over a span of time, ∫ r dt = scale·turn + bias·Δt, while turn rates change by at most `change_rad_per_s2`;
    /// `None` before the first reading has arrived. The enclosure includes the noise, but neither bias nor scale. Where the bound `gyro.angle` on
    /// the accumulated angle error is declared, the bias in this formula is the mean one of the whole run.
    pub fn sum(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        self.sum_since(&mut SumSince::new(from_s), to_s, change_rad_per_s2)
    }

    /// The same as [`sum`](Self::sum) from the stamp at which `since` begins. The readings that are added are remembered in `since`, so that they are
    /// not walked through again for a later stamp; a reading that arrives later than its successor is then left out, as one that is lost.
    pub fn sum_since(&self, since: &mut SumSince, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        let mut walk = if to_s < since.done_s {
            Walk::new(self, since.from_s, change_rad_per_s2)
        } else {
            Walk::after(self, since, change_rad_per_s2)
        };
        let sums = walk.sums_to(to_s)?;
        if walk.done_s > since.done_s {
            (since.done_s, since.sums) = (walk.done_s, walk.sums);
        }
        let model = &self.model;
        let read = if model.bounds_angle() { sums.by_span(model) } else { sums.by_reading(model) };
        Some(read.inflate(sums.bend_rad * model.scale.magnitude()))
    }

    fn sums(&self, [from_s, to_s]: [f64; 2], change_rad_per_s2: f64) -> Option<Sums> {
        Walk::new(self, from_s, change_rad_per_s2).sums_to(to_s)
    }

    /// What the gyroscope tells of the turn from `from_s` to `to_s`, without its bias and scale; `None` before the first reading has arrived.
    pub(super) fn turn_read(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<GyroTurn> {
        let sums = self.sums([from_s, to_s], change_rad_per_s2)?;
        let bend_rad = sums.bend_rad * self.model.scale.magnitude();
        let summed = sums.summed(&self.model).inflate(bend_rad);
        Some(GyroTurn { by_reading_rad: sums.by_reading(&self.model).inflate(bend_rad), summed_rad: summed, bend_rad })
    }

    /// Nominal turns from each stamp to the next by the gyroscope, with bounds on their errors; `None` before the first reading has arrived.
    pub(super) fn turn_steps(&self, stamps_s: &[f64], change_rad_per_s2: f64) -> Option<Vec<TurnStep>> {
        let model = &self.model;
        let (bias, scale) = (model.bias_rad_per_s, model.scale);
        let (bias_off, run_bias_off) =
            ((bias - bias.mid()).magnitude(), (self.run_bias_rad_per_s - bias.mid()).magnitude());
        let inverse_off = (Interval::point(1.0) / scale - 1.0 / scale.mid()).magnitude();
        let mut walk = Walk::new(self, *stamps_s.first()?, change_rad_per_s2);
        let (mut before, mut by_scale_rad, mut steps) = (Sums::default(), 0.0, Vec::new());
        for &stamp_s in &stamps_s[1..] {
            let sums = walk.sums_to(stamp_s)?;
            let lasts_s = sums.lasts_s - before.lasts_s;
            let turned = sums.read_rad - before.read_rad - bias.mid() * lasts_s;
            by_scale_rad += turned.abs() * inverse_off;
            let by_span = sums.by_span(model).width() * 0.5 + run_bias_off * sums.lasts_s;
            steps.push(TurnStep {
                turn_rad: turned / scale.mid(),
                error_rad: (model.noise_rad_per_s + bias_off) * lasts_s.abs() / scale.lo() + turned.abs() * inverse_off,
                bend_rad: sums.bend_rad,
                span_error_rad: by_span / scale.lo() + by_scale_rad,
            });
            before = sums;
        }
        Some(steps)
    }

    /// Nominal turns from the first stamp to each later one by the gyroscope, with bounds on their errors other than those that the middles of the
    /// bias and the scale make in proportion to time and turn; `None` before the first reading has arrived.
    pub(super) fn profile(&self, stamps_s: &[f64], change_rad_per_s2: f64) -> Option<Vec<ProfileStep>> {
        let model = &self.model;
        let bias_rad_per_s = if model.bounds_angle() { self.run_bias_rad_per_s } else { model.bias_rad_per_s };
        let inverse_off = (Interval::point(1.0) / model.scale - 1.0 / model.scale.mid()).magnitude();
        let mut walk = Walk::new(self, *stamps_s.first()?, change_rad_per_s2);
        let (mut before, mut steps) = (Sums::default(), Vec::with_capacity(stamps_s.len()));
        // What the bias changes within the whole span, beside its mean.
        let whole_s = stamps_s.last()? - stamps_s.first()?;
        let wandered = (model.bias_wander_rad_per_s2 * whole_s).min(model.bias_rad_per_s.width());
        for &stamp_s in &stamps_s[1..] {
            let sums = walk.sums_to(stamp_s)?;
            let [floor, grows, at_once] = if model.bounds_angle() {
                let at_once = sums.missed_at_end_rad + model.one_rad();
                [0.5 * model.angle_floor_rad, sums.grown_rad(model), at_once]
            } else {
                [0.0, (model.noise_rad_per_s + wandered) * sums.lasts_s, 0.0]
            };
            let (read, lasts_s) = (sums.read_rad - before.read_rad, sums.lasts_s - before.lasts_s);
            let turned_rad = (read - bias_rad_per_s.mid() * lasts_s).abs();
            let off_rad_per_s = model.noise_rad_per_s + (model.bias_rad_per_s - bias_rad_per_s.mid()).magnitude();
            steps.push(ProfileStep {
                lasts_s: sums.lasts_s,
                turn_rad: (sums.read_rad - bias_rad_per_s.mid() * sums.lasts_s) / model.scale.mid(),
                floor_rad: floor / model.scale.lo(),
                grows_rad: grows / model.scale.lo(),
                at_once_rad: at_once / model.scale.lo(),
                bend_rad: sums.bend_rad,
                step_error_rad: off_rad_per_s * lasts_s / model.scale.lo() + turned_rad * inverse_off,
            });
            before = sums;
        }
        Some(steps)
    }

    /// The middle of what is known of the scale, by which nominal turns are divided.
    pub(super) fn middle_scale(&self) -> f64 {
        self.model.scale.mid()
    }

    /// Turns by the gyroscope from `from_s` to one later stamp after the other, each as [`turn`](Self::turn) gives it, in one pass over the
    /// readings.
    pub fn turns_from(&self, from_s: f64, change_rad_per_s2: f64) -> TurnsFrom<'_> {
        TurnsFrom { walk: Walk::new(self, from_s, change_rad_per_s2) }
    }

    /// Replaces the gyroscope's bias and scale by intervals that are known better than the declared ones.
    pub fn learn(&mut self, bias_rad_per_s: Interval, scale: Interval) {
        self.run_bias_rad_per_s = bias_rad_per_s;
        if !self.model.bounds_angle() {
            self.model.bias_rad_per_s = bias_rad_per_s;
        }
        self.model.scale = scale;
    }
}

/// Sum of a gyroscope's readings from a fixed stamp on; see [`GyroHistory::sum_since`].
#[derive(Clone, Copy, Debug)]
pub struct SumSince {
    from_s: f64,
    /// End of the last reading that was added as a whole.
    done_s: f64,
    sums: Sums,
}

impl SumSince {
    /// The sum from a stamp on, to which no reading has been added yet.
    pub fn new(from_s: f64) -> SumSince {
        SumSince { from_s, done_s: from_s, sums: Sums::default() }
    }
}

/// What the gyroscope tells of the turn between two stamps: enclosures of scale·turn + bias·span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroTurn {
    /// With the mean bias of this span, when the noise of each reading is bounded on its own.
    pub by_reading_rad: Interval,
    /// The readings' sum: scale·turn + bias·span + u(end) − u(start) is within this interval, where bias is that of the whole run. The angle error
    /// accumulated since the run's start is u(t) + v(t): |u| is at most half of the constant part of the bound `gyro.angle`, and v changes by at most
    /// the bound's other part per second. The change of v is within this interval.
    pub summed_rad: Interval,
    /// The part of the half widths of both that comes from the change of the turn rate, where readings count only in part or are missing.
    pub bend_rad: f64,
}

/// Nominal turn by the gyroscope from one stamp of a span to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurnStep {
    pub(super) turn_rad: f64,
    /// Greatest error of the turn by noise, bias and scale. The errors of steps add up.
    pub(super) error_rad: f64,
    /// Greatest error of the turn from the first stamp of the span to this one where readings count only in part or are missing.
    pub(super) bend_rad: f64,
    /// Greatest error of the turn from the first stamp of the span to this one, without `bend_rad`, by the declared bound `gyro.angle`. Infinite
    /// where that bound is not declared.
    pub(super) span_error_rad: f64,
}

/// Nominal turn by the gyroscope since the first stamp of a span, with the parts of its error that the noise makes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ProfileStep {
    /// Time since the first stamp.
    pub(super) lasts_s: f64,
    pub(super) turn_rad: f64,
    /// Greatest error that is bounded at every instant, whatever the span: half of the constant part of `gyro.angle`, or 0 where that is not
    /// declared.
    pub(super) floor_rad: f64,
    /// Greatest error that adds up over the time.
    pub(super) grows_rad: f64,
    /// Greatest error by readings that count only in part, over any span, and by those that are missing up to this stamp.
    pub(super) at_once_rad: f64,
    /// Greatest error where readings count only in part or are missing, by the turn rate's change.
    pub(super) bend_rad: f64,
    /// Greatest error of the turn since the stamp before by noise, bias and scale.
    pub(super) step_error_rad: f64,
}

/// Turns by the gyroscope that begin at the same stamp; see [`GyroHistory::turns_from`].
#[derive(Clone, Debug)]
pub struct TurnsFrom<'a> {
    walk: Walk<'a>,
}

impl TurnsFrom<'_> {
    /// The turn by the gyroscope up to a stamp, which must not be earlier than the stamp of the previous call.
    pub fn to(&mut self, to_s: f64) -> Option<Interval> {
        let sums = self.walk.sums_to(to_s)?;
        let model = &self.walk.history.model;
        let by_reading = sums.by_reading(model) - model.bias_rad_per_s * sums.lasts_s;
        let by_span = sums.by_span(model) - self.walk.history.run_bias_rad_per_s * sums.lasts_s;
        Some((by_reading.intersect(by_span) / model.scale).inflate(sums.bend_rad))
    }
}

/// Greatest change of the robot's turn rate while each wheel accelerates by at most its bound: (a + a)/W, with the acceleration a and the track
/// width W.
pub fn greatest_change_rad_per_s2(wheels: &WheelModel, reach: &Reach) -> f64 {
    2.0 * reach.acceleration_m_per_s2 / wheels.track_m.lo()
}

/// Greatest change of the turn rate of a robot that is pushed: it may change its rate Ω to the opposite at once. In a part s of a period T the
/// turn then departs from the mean by up to 2·Ω·s·(1 − s/T), at most Ω·T/2, which is that of a rate that changes by 4·Ω in each period.
pub fn sudden_change_rad_per_s2(reach: &Reach, period_s: f64) -> f64 {
    4.0 * reach.turn_rate_rad_per_s / period_s
}
