//! Turn rates to an enclosure of the turn between two stamps.
//!
//! A reading r averages ω = (r − bias − noise)/scale over the period before its stamp. Bias and scale are the same in all readings and
//! so act on sums. Noise is bounded for each reading, so its bound adds up, and may be bounded over any span besides, together with what
//! the bias departs from that of all the run.

use std::collections::VecDeque;

use interval::Interval;

use crate::robot::{GyroModel, Reach, WheelModel};

/// Recent turn rates.
#[derive(Clone, Debug)]
pub struct GyroHistory {
    model: GyroModel,
    /// The bias that any span's mean departs from by no more than `gyro.angle` allows.
    run_bias_rad_per_s: Interval,
    /// Stamp and rate.
    readings: VecDeque<(f64, f64)>,
    keep_s: f64,
}

/// Stamps closer than this are the same instant: periods are decimal, stamps binary.
const SAME_S: f64 = 1e-9;

/// Share of a period by which two may overlap and still be one after the other.
const PERIOD_S_SLACK: f64 = 1e-3;

impl GyroHistory {
    /// A history that forgets what is older than `keep_s`.
    pub fn new(model: GyroModel, keep_s: f64) -> Self {
        GyroHistory { model, run_bias_rad_per_s: model.bias_rad_per_s, readings: VecDeque::new(), keep_s }
    }

    /// Span that a reading averages over.
    pub(super) fn period_s(&self) -> f64 {
        self.model.period_s
    }

    /// Adds a reading where its period has its place among the others. A duplicate has none and is dropped, and so is a reading that comes
    /// after all that its memory holds has gone by.
    pub fn push(&mut self, time_s: f64, rate_rad_per_s: f64) {
        let place = self.readings.partition_point(|(end_s, _)| *end_s < time_s);
        let begin_s = time_s - self.model.period_s;
        let before = place.checked_sub(1).and_then(|idx| self.readings.get(idx));
        let after = self.readings.get(place);
        let overlaps = before.is_some_and(|(end_s, _)| begin_s < end_s - PERIOD_S_SLACK * self.model.period_s)
            || after
                .is_some_and(|(end_s, _)| end_s - self.model.period_s < time_s - PERIOD_S_SLACK * self.model.period_s);
        let is_late = self.readings.back().is_some_and(|(latest_s, _)| time_s <= latest_s + SAME_S);
        if is_late && (overlaps || before.is_none()) {
            return;
        }
        self.readings.insert(place, (time_s, rate_rad_per_s));
        let latest_s = self.readings.back().map_or(time_s, |(latest_s, _)| *latest_s);
        while self.readings.front().is_some_and(|(first_s, _)| *first_s < latest_s - self.keep_s) {
            self.readings.pop_front();
        }
    }

    /// Turn from `from_s` to `to_s` while turn rates change by at most `change_rad_per_s2`; `None` where no reading is near, and to an earlier
    /// stamp.
    ///
    /// Inside the period T of a reading the heading departs from the chord by at most change·T²/8. Time that no reading covers is
    /// turned at the rate of the reading beside it, give or take what that can have changed by since.
    pub fn turn(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        self.turns_from(from_s, change_rad_per_s2).to(to_s)
    }

    /// What readings add up to, ∫ r dt = scale·turn + bias·Δt, while turn rates change by at most `change_rad_per_s2`; `None` where no
    /// reading is near. Noise is in it; bias and scale are not. Where `gyro.angle` is declared, the bias is the one of all the run.
    pub fn sum(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        let sums = self.sums([from_s, to_s], change_rad_per_s2)?;
        let model = &self.model;
        let read = if model.bounds_angle() { sums.by_span(model) } else { sums.by_reading(model) };
        Some(read.inflate(sums.bend_rad * model.scale.magnitude()))
    }

    fn sums(&self, [from_s, to_s]: [f64; 2], change_rad_per_s2: f64) -> Option<Sums> {
        Walk::new(self, from_s, change_rad_per_s2).sums_to(to_s)
    }

    /// Turns from one stamp to one after the other, each as [`turn`](Self::turn) tells it, in one pass over the readings.
    pub fn turns_from(&self, from_s: f64, change_rad_per_s2: f64) -> TurnsFrom<'_> {
        TurnsFrom { walk: Walk::new(self, from_s, change_rad_per_s2) }
    }

    /// Takes over a bias and a scale that are known better than declared.
    pub fn learn(&mut self, bias_rad_per_s: Interval, scale: Interval) {
        self.run_bias_rad_per_s = bias_rad_per_s;
        if !self.model.bounds_angle() {
            self.model.bias_rad_per_s = bias_rad_per_s;
        }
        self.model.scale = scale;
    }
}

/// Turns that begin at the same stamp; see [`GyroHistory::turns_from`].
#[derive(Clone, Debug)]
pub struct TurnsFrom<'a> {
    walk: Walk<'a>,
}

impl TurnsFrom<'_> {
    /// The turn to a stamp that is not before the one asked for last.
    pub fn to(&mut self, to_s: f64) -> Option<Interval> {
        let sums = self.walk.sums_to(to_s)?;
        let model = &self.walk.history.model;
        let by_reading = sums.by_reading(model) - model.bias_rad_per_s * sums.lasts_s;
        let by_span = sums.by_span(model) - self.walk.history.run_bias_rad_per_s * sums.lasts_s;
        Some((by_reading.intersect(by_span) / model.scale).inflate(sums.bend_rad))
    }
}

/// A pass over readings: what those add up to whose periods have ended.
#[derive(Clone, Debug)]
struct Walk<'a> {
    history: &'a GyroHistory,
    change_rad_per_s2: f64,
    from_s: f64,
    done_s: f64,
    /// Index of the first reading that has not been added.
    next: usize,
    sums: Sums,
}

impl<'a> Walk<'a> {
    fn new(history: &'a GyroHistory, from_s: f64, change_rad_per_s2: f64) -> Walk<'a> {
        let next = history.readings.partition_point(|(end_s, _)| *end_s <= from_s + SAME_S);
        Walk { history, change_rad_per_s2, from_s, done_s: from_s, next, sums: Sums::default() }
    }

    /// What readings add up to until a stamp that is not before the one asked for last; `None` where no reading is near, and before the
    /// beginning: the way back is no stand.
    fn sums_to(&mut self, to_s: f64) -> Option<Sums> {
        if to_s < self.from_s - SAME_S {
            return None;
        }
        let period_s = self.history.model.period_s;
        while self.reading().is_some_and(|(end_s, _)| end_s <= to_s && end_s - period_s < to_s - SAME_S) {
            self.add_next(to_s);
        }
        // What lies only in part in the span that ends here may lie in the next one altogether.
        let mut last = self.clone();
        while last.reading().is_some_and(|(end_s, _)| end_s - period_s < to_s - SAME_S) {
            last.add_next(to_s);
        }
        let beside = last.reading().or_else(|| last.before())?;
        last.add_beside(beside, [last.done_s, to_s]);
        Some(last.sums)
    }

    /// The first reading that has not been added.
    fn reading(&self) -> Option<(f64, f64)> {
        self.history.readings.get(self.next).copied()
    }

    /// The reading before it.
    fn before(&self) -> Option<(f64, f64)> {
        self.history.readings.get(self.next.checked_sub(1)?).copied()
    }

    /// Adds the next reading, which begins before `to_s`, as far as there.
    fn add_next(&mut self, to_s: f64) {
        let Some((end_s, rate)) = self.reading() else { return };
        let period_s = self.history.model.period_s;
        let begin_s = end_s - period_s;
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

    /// Adds a span beside a reading's period: the rate was somewhere in it the mean that was read, and from there it changed for as long as
    /// from the farther end of the period to the farther end of the span.
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

/// What readings of a span add up to.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    read_rad: f64,
    lasts_s: f64,
    /// How much of the span no reading covers.
    beside_s: f64,
    /// Parts of the span without a gap between readings.
    n_runs: usize,
    /// Bound of the turn that the sum leaves out.
    bend_rad: f64,
    /// Σ |r|·T, for the rounding of the sums.
    size_rad: f64,
}

impl Sums {
    fn add(&mut self, rate: f64, span_s: f64) {
        self.read_rad += rate * span_s;
        self.lasts_s += span_s;
        self.size_rad += rate.abs() * span_s;
    }

    fn within(&self, noise_rad: f64) -> Interval {
        // Stamps themselves are rounded, by far less than `SAME_S` for each reading.
        Interval::point(self.read_rad).inflate(noise_rad + 1e-12 * (self.size_rad + self.lasts_s))
    }

    /// scale·turn + ∫ bias dt: every reading is within its noise.
    fn by_reading(&self, model: &GyroModel) -> Interval {
        self.within(model.noise_rad_per_s * self.lasts_s)
    }

    /// scale·turn + bias·Δt with the bias of all the run: noise and what the bias departs from that are bounded span by span, and for a
    /// reading at either end that lies in it only in part, and beside readings, one by one.
    fn by_span(&self, model: &GyroModel) -> Interval {
        if !model.bounds_angle() {
            return Interval::ENTIRE;
        }
        let one_rad_per_s = model.noise_rad_per_s + model.bias_rad_per_s.width();
        let by_one_rad = one_rad_per_s * (self.beside_s + 2.0 * model.period_s);
        self.within(self.n_runs as f64 * model.angle_floor_rad + model.angle_rad_per_s * self.lasts_s + by_one_rad)
    }
}

/// Greatest change of the turn rate while each wheel accelerates by at most its bound: (a + a)/W.
pub fn greatest_change_rad_per_s2(wheels: &WheelModel, reach: &Reach) -> f64 {
    2.0 * reach.acceleration_m_per_s2 / wheels.track_m.lo()
}

/// Greatest change of the turn rate of a robot that is pushed: it may change its rate Ω to its opposite at once. In a part s of a
/// period T the turn then departs from the mean by up to 2·Ω·s·(1 − s/T), at most Ω·T/2: that of a rate which changes by 4·Ω in
/// each period.
pub fn sudden_change_rad_per_s2(reach: &Reach, period_s: f64) -> f64 {
    4.0 * reach.turn_rate_rad_per_s / period_s
}
