//! Turn rates to an enclosure of the turn between two stamps.
//!
//! A reading r averages ω = (r − bias − noise)/scale over the period before its stamp. Bias and scale are the same in all readings and
//! so act on sums. Noise is bounded for each reading, so its bound adds up, and may be bounded over any span besides.

use std::collections::VecDeque;

use crate::{
    Interval,
    robot::{GyroModel, Reach, WheelModel},
};

/// Recent turn rates.
#[derive(Clone, Debug)]
pub struct GyroHistory {
    model: GyroModel,
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
        GyroHistory { model, readings: VecDeque::new(), keep_s }
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

    /// Turn from `from_s` to `to_s` while turn rates change by at most `change_rad_per_s2`; `None` where no reading is near.
    ///
    /// Inside the period T of a reading the heading departs from the chord by at most change·T²/8. Time that no reading covers is
    /// turned at the rate of the reading beside it, give or take what that can have changed by since.
    pub fn turn(&self, from_s: f64, to_s: f64, change_rad_per_s2: f64) -> Option<Interval> {
        self.turn_by(&self.model, [from_s, to_s], change_rad_per_s2)
    }

    /// The same with another bias, as of a span long past.
    pub fn turn_with_bias(
        &self,
        bias_rad_per_s: Interval,
        span_s: [f64; 2],
        change_rad_per_s2: f64,
    ) -> Option<Interval> {
        self.turn_by(&GyroModel { bias_rad_per_s, ..self.model }, span_s, change_rad_per_s2)
    }

    fn turn_by(&self, model: &GyroModel, [from_s, to_s]: [f64; 2], change_rad_per_s2: f64) -> Option<Interval> {
        let period_s = model.period_s;
        let bend_rad = change_rad_per_s2 * period_s * period_s / 8.0;
        let mut covered = Covered::default();
        let mut beside = Interval::ZERO;
        let mut done_s = from_s;
        let first = self.readings.partition_point(|(end_s, _)| *end_s <= from_s + SAME_S);
        let mut latest = first.checked_sub(1).and_then(|idx| self.readings.get(idx)).copied();
        for &(end_s, rate) in self.readings.iter().skip(first) {
            let begin_s = end_s - period_s;
            latest = Some((end_s, rate));
            if begin_s >= to_s - SAME_S {
                break;
            }
            beside += beside_period(model, (end_s, rate), [done_s, begin_s], change_rad_per_s2);
            covered.n_runs += usize::from(covered.n_runs == 0 || begin_s - done_s > SAME_S);
            let span_s = end_s.min(to_s) - begin_s.max(done_s);
            covered.add(rate, span_s);
            if span_s < period_s - SAME_S {
                covered.bent_rad += bend_rad;
            }
            done_s = end_s.min(to_s);
        }
        beside += beside_period(model, latest?, [done_s, to_s], change_rad_per_s2);
        Some(covered.turn(model) + beside)
    }

    /// Mean bias over a span in which the robot has turned by `turn`, while turn rates change by at most `change_rad_per_s2`; `None`
    /// where no reading is near.
    ///
    /// ∫ r dt = scale·turn + bias·Δt ± noise·Δt.
    pub fn bias(&self, from_s: f64, to_s: f64, turn: Interval, change_rad_per_s2: f64) -> Option<Interval> {
        let as_read = GyroModel { bias_rad_per_s: Interval::ZERO, scale: Interval::point(1.0), ..self.model };
        let read = self.turn_by(&as_read, [from_s, to_s], change_rad_per_s2 * self.model.scale.magnitude())?;
        (to_s > from_s).then(|| (read - self.model.scale * turn) / (to_s - from_s))
    }

    /// Takes over a bias that is known better than declared.
    pub fn learn_bias(&mut self, bias_rad_per_s: Interval) {
        self.model.bias_rad_per_s = bias_rad_per_s;
    }
}

/// Turn in a span beside the period of a reading: somewhere in the period the rate was the mean that was read, and from there it
/// changed for as long as from the farther end of the period to the farther end of the span.
fn beside_period(
    model: &GyroModel,
    (end_s, rate): (f64, f64),
    [from_s, to_s]: [f64; 2],
    change_rad_per_s2: f64,
) -> Interval {
    if to_s - from_s <= SAME_S {
        return Interval::ZERO;
    }
    let away_s = end_s.max(to_s) - from_s.min(end_s - model.period_s);
    true_rate(rate, model).inflate(change_rad_per_s2 * away_s) * (to_s - from_s)
}

/// Sums over the time that readings cover.
#[derive(Clone, Copy, Debug, Default)]
struct Covered {
    turned_rad: f64,
    lasted_s: f64,
    /// Spans without a gap between readings.
    n_runs: usize,
    /// Bound of what chords leave out.
    bent_rad: f64,
    /// Σ |r|·T, for the rounding of the sums.
    size_rad: f64,
}

impl Covered {
    fn add(&mut self, rate: f64, span_s: f64) {
        self.turned_rad += rate * span_s;
        self.lasted_s += span_s;
        self.size_rad += rate.abs() * span_s;
    }

    /// (Σ r·T − bias·ΣT ± noise·ΣT)/scale ± what chords leave out.
    fn turn(&self, model: &GyroModel) -> Interval {
        // Stamps themselves are rounded, by far less than `SAME_S` for each reading.
        let rounding_rad = 1e-12 * (self.size_rad + self.lasted_s);
        let turned = Interval::point(self.turned_rad) - model.bias_rad_per_s * self.lasted_s;
        (turned.inflate(self.noise_rad(model) + rounding_rad) / model.scale).inflate(self.bent_rad)
    }

    /// Bound of what noise adds up to: reading by reading, or span by span, with a reading at either end that lies in it only in part.
    fn noise_rad(&self, model: &GyroModel) -> f64 {
        let by_reading_rad = model.noise_rad_per_s * self.lasted_s;
        let by_span_rad = self.n_runs as f64 * model.angle_floor_rad
            + model.angle_rad_per_s * self.lasted_s
            + 2.0 * model.noise_rad_per_s * model.period_s;
        by_reading_rad.min(by_span_rad)
    }
}

fn true_rate(rate: f64, model: &GyroModel) -> Interval {
    (Interval::point(rate) - model.bias_rad_per_s).inflate(model.noise_rad_per_s) / model.scale
}

/// Greatest change of the turn rate while each wheel accelerates by at most its bound: (a + a)/W.
pub fn greatest_change_rad_per_s2(wheels: &WheelModel, reach: &Reach) -> f64 {
    2.0 * reach.acceleration_m_per_s2 / wheels.track_m.lo()
}
