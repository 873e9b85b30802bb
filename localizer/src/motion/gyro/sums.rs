//! Sums of gyroscope readings over a span of time, with the bounds on their errors.

use interval::Interval;

use crate::robot::GyroModel;

use super::{GyroHistory, SAME_S, SumSince};

/// Sums of gyroscope readings from a fixed stamp on, carried forward through the readings. Only readings whose periods have ended are included for
/// good.
#[derive(Clone, Debug)]
pub(super) struct Walk<'a> {
    pub(super) history: &'a GyroHistory,
    pub(super) change_rad_per_s2: f64,
    pub(super) from_s: f64,
    pub(super) done_s: f64,
    /// Index of the first gyroscope reading that has not been added to the sums.
    pub(super) next: usize,
    pub(super) sums: Sums,
}

impl<'a> Walk<'a> {
    pub(super) fn new(history: &'a GyroHistory, from_s: f64, change_rad_per_s2: f64) -> Walk<'a> {
        Walk::after(history, &SumSince::new(from_s), change_rad_per_s2)
    }

    /// The walk goes on after the readings that have been added to a sum.
    pub(super) fn after(history: &'a GyroHistory, since: &SumSince, change_rad_per_s2: f64) -> Walk<'a> {
        let SumSince { from_s, done_s, sums } = *since;
        let next = history.readings.partition_point(|(end_s, _)| *end_s <= done_s + SAME_S);
        Walk { history, change_rad_per_s2, from_s, done_s, next, sums }
    }

    /// Sums of the gyroscope's readings up to a stamp that is not earlier than that of the previous call. They are `None` before the first reading
    /// has arrived, and for a stamp before the one at which the sums begin: a motion backward in time must not be taken for no motion.
    pub(super) fn sums_to(&mut self, to_s: f64) -> Option<Sums> {
        if to_s < self.from_s - SAME_S {
            return None;
        }
        let period_s = self.history.model.period_s;
        while self.reading().is_some_and(|(end_s, _)| end_s <= to_s && end_s - period_s < to_s - SAME_S) {
            self.add_next(to_s);
        }
        // A gyroscope reading whose period ends after this stamp counts only in part here, but may count as a whole at the next stamp. So it is
        // added to a copy of the sums.
        let mut last = self.clone();
        while last.reading().is_some_and(|(end_s, _)| end_s - period_s < to_s - SAME_S) {
            last.add_next(to_s);
        }
        let beside = last.reading().or_else(|| last.before())?;
        last.sums.missed_at_end_rad = last.missed_rad(to_s - last.done_s);
        last.add_beside(beside, [last.done_s, to_s]);
        Some(last.sums)
    }

    /// The first gyroscope reading that has not been added to the sums.
    fn reading(&self) -> Option<(f64, f64)> {
        self.history.readings.get(self.next).copied()
    }

    /// The gyroscope reading before the first one that has not been added to the sums.
    fn before(&self) -> Option<(f64, f64)> {
        self.history.readings.get(self.next.checked_sub(1)?).copied()
    }

    /// Adds the next gyroscope reading to the sums. Its period begins before `to_s`, and only its part up to `to_s` is added.
    fn add_next(&mut self, to_s: f64) {
        let Some((end_s, rate)) = self.reading() else { return };
        let period_s = self.history.model.period_s;
        let begin_s = end_s - period_s;
        self.sums.missed_rad += self.missed_rad(begin_s - self.done_s);
        self.add_beside((end_s, rate), [self.done_s, begin_s]);
        self.sums.n_runs += usize::from(self.sums.n_runs == 0 || begin_s - self.done_s > SAME_S);
        let span_s = end_s.min(to_s) - begin_s.max(self.done_s);
        self.sums.add(rate, span_s);
        if span_s < period_s - SAME_S {
            self.sums.bend_rad += self.change_rad_per_s2 * period_s * period_s / 8.0;
        }
        self.done_s = end_s.min(to_s);
        self.next += 1;
    }

    /// Greatest change of the bounded part u of the accumulated angle error over a span of time that no reading covers: the readings of that time, which
    /// were lost, had errors, too.
    fn missed_rad(&self, span_s: f64) -> f64 {
        let model = &self.history.model;
        if span_s <= SAME_S {
            return 0.0;
        }
        let by_reading = model.noise_rad_per_s + model.bias_rad_per_s.width() + model.angle_rad_per_s;
        model.angle_floor_rad.min(by_reading * (span_s + 2.0 * model.period_s))
    }

    /// Adds a span of time beside a gyroscope reading's period to the sums, at the rate of that reading. Somewhere in the period the turn rate
    /// was the mean that was read, and from there it has changed for at most the time from the farther end of the period to the farther end of
    /// the span.
    fn add_beside(&mut self, (end_s, rate): (f64, f64), [from_s, to_s]: [f64; 2]) {
        let span_s = to_s - from_s;
        if span_s > SAME_S {
            let away_s = end_s.max(to_s) - from_s.min(end_s - self.history.model.period_s);
            self.sums.add(rate, span_s);
            self.sums.beside_s += span_s;
            self.sums.bend_rad += self.change_rad_per_s2 * away_s * span_s;
        }
    }
}

/// Sums of the gyroscope readings in a span of time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) read_rad: f64,
    pub(super) lasts_s: f64,
    /// Time of the span that no gyroscope reading covers.
    pub(super) beside_s: f64,
    /// Number of stretches of the span that gyroscope readings cover without a gap.
    pub(super) n_runs: usize,
    /// Bound on how much the part u of the accumulated angle error changes in gaps between readings, and before the first one of the span.
    pub(super) missed_rad: f64,
    /// The same from the last reading to the end of the span.
    pub(super) missed_at_end_rad: f64,
    /// Bound on the error of the turn that arises where only a part of a reading's period is used, and in time that no reading covers.
    pub(super) bend_rad: f64,
    /// Sum Σ |r|·T over the gyroscope readings r and the times T for which they count; the bound on the rounding errors of the sums is in
    /// proportion to it.
    pub(super) size_rad: f64,
}

impl Sums {
    fn add(&mut self, rate: f64, span_s: f64) {
        self.read_rad += rate * span_s;
        self.lasts_s += span_s;
        self.size_rad += rate.abs() * span_s;
    }

    fn within(&self, noise_rad: f64) -> Interval {
        // Besides the noise, rounding errors count: those of the sums, and those of the stamps of gyroscope readings, which are far less than
        // `SAME_S` each.
        Interval::point(self.read_rad).inflate(noise_rad + 1e-12 * (self.size_rad + self.lasts_s))
    }

    /// Enclosure of scale·turn + ∫ bias dt over a span of time, when the noise of every gyroscope reading is bounded on its own.
    pub(super) fn by_reading(&self, model: &GyroModel) -> Interval {
        self.within(model.noise_rad_per_s * self.lasts_s)
    }

    /// Enclosure of scale·turn + bias·Δt, where bias is that of the whole run. Of the accumulated angle error, the part that grows with time is
    /// included. The part u that is bounded at every instant is not: what is enclosed is the sum with u(end) − u(start) added.
    pub(super) fn summed(&self, model: &GyroModel) -> Interval {
        if !model.bounds_angle() {
            return Interval::ENTIRE;
        }
        self.within(self.grown_rad(model) + self.missed_at_end_rad + model.one_rad())
    }

    /// Bound on the part of the accumulated angle error that grows with time, and on what gaps between readings add to it. What a gap at the end of the
    /// span adds is not included, since it concerns u at the end alone.
    pub(super) fn grown_rad(&self, model: &GyroModel) -> f64 {
        let beside_rad = (model.noise_rad_per_s + model.bias_rad_per_s.width()) * self.beside_s;
        self.missed_rad + model.angle_rad_per_s * self.lasts_s + beside_rad
    }

    /// Bound on the noise and the bias's departure, reading by reading, in time that no reading covers and for a reading at either end that lies only
    /// partly in the span.
    fn by_one_rad(&self, model: &GyroModel) -> f64 {
        (model.noise_rad_per_s + model.bias_rad_per_s.width()) * self.beside_s + model.one_rad()
    }

    /// Enclosure of scale·turn + bias·Δt with the gyroscope's bias of the whole run. In each stretch of the span that readings cover without a gap,
    /// noise and the bias's departure from that of the whole run are bounded together. They are bounded reading by reading in time that no reading
    /// covers, and for a reading at either end that lies only partly in the span.
    pub(super) fn by_span(&self, model: &GyroModel) -> Interval {
        if !model.bounds_angle() {
            return Interval::ENTIRE;
        }
        let by_span_rad = self.n_runs as f64 * model.angle_floor_rad + model.angle_rad_per_s * self.lasts_s;
        self.within(by_span_rad + self.by_one_rad(model))
    }
}

impl GyroModel {
    /// Bound on noise and on the bias's departure for one reading at either end of a span that lies only partly in the span.
    pub(super) fn one_rad(&self) -> f64 {
        (self.noise_rad_per_s + self.bias_rad_per_s.width()) * 2.0 * self.period_s
    }
}
