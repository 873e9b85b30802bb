//! From a car's steering angle to its turn: an enclosure that does not depend on the difference of its rear wheels.
//!
//! With the wheelbase L, the steering angle δ of a wheel in the middle of the front axle, and the travel T of the middle of the rear axle, a car
//! whose tyres do not slip sideways turns by dφ = tan δ/L·dT (Rajamani, *Vehicle Dynamics and Control*, section 2.2). How far the true turn departs
//! from that is bounded by `wheels.steering_slip`.
//!
//! **Between readings.** The angle is known where the encoder is read, and changes at a bounded rate ρ. Where it is in [a, b] at the begin and in
//! [c, d] at the end of a time τ, it is at most min(b + ρt, d + ρ(τ − t)) in between. The mean of that is (b + d)/2 and a bulge of (ρ²τ² − (b −
//! d)²)/(4ρτ), or less than (b + d)/2 where |b − d| ≥ ρτ; its greatest value is at most (b + d + ρτ)/2. Below it is likewise.
//!
//! **A step.** From one sample of the wheels to the next let δ̄ be any angle, τ̄ = tan δ̄, |mean δ − δ̄| ≤ H and |δ − δ̄| ≤ D. The speed departs
//! from its mean by at most aT/2 in a step of the duration T, with the bound a on the acceleration, so that
//!
//! |∫ tan δ dT − τ̄·ΔT| ≤ sec²δ̄·(|ΔT|·H + D·aT²/2) + max |tan·sec²|·D²·∫ |dT|,   ∫ |dT| ≤ |ΔT| + aT²/4.
//!
//! **A span.** The travel is what the ticks say, with an error e of which only the total is bounded at every instant: |e| ≤ ē. By summation by
//! parts |Σ τ̄ Δe| ≤ ē·(|τ̄ of the last step| + Σ |changes of τ̄|). The quantisation of the ticks is such an error too.

use std::collections::VecDeque;

use interval::Interval;

use crate::robot::{Reach, SteeringModel, WheelModel};

use super::WheelSample;

/// Name of the steering encoder as a device, in a [`Reading::Other`](crate::Reading::Other) with one number: the ticks that it reads.
pub const DEVICE: &str = "steering_encoder";

/// Recent readings of the steering encoder.
#[derive(Clone, Debug)]
pub struct SteeringHistory {
    model: SteeringModel,
    /// Stamp of each reading, and the steering angles that it allows.
    readings: VecDeque<(f64, Interval)>,
    keep_s: f64,
}

/// Time difference below which two stamps are the same instant: periods are decimal numbers, stamps binary ones.
const SAME_S: f64 = 1e-9;
/// Steering angle from which on nothing is said of the turn: its tangent grows beyond all bounds soon after.
const MOST_RAD: f64 = 1.4;
/// Greatest error of a mean angle by the roundings of the times that it is a mean over, which are about 1e-16 of them.
const ROUNDING_RAD: f64 = 1e-12;
/// Factor by which a sum of positive error bounds is increased, to make up for the few roundings of the sum.
const ABOVE: f64 = 1.0 + 1e-9;

impl SteeringHistory {
    /// A history that forgets readings of the steering encoder older than `keep_s`.
    pub fn new(model: SteeringModel, keep_s: f64) -> Self {
        SteeringHistory { model, readings: VecDeque::new(), keep_s }
    }

    /// Adds a reading at its place in time. Returns whether there was none of its stamp yet.
    pub fn push(&mut self, time_s: f64, ticks: f64) -> bool {
        let place = self.readings.partition_point(|(stamp_s, _)| *stamp_s < time_s - SAME_S);
        if self.readings.get(place).is_some_and(|(stamp_s, _)| *stamp_s < time_s + SAME_S) {
            return false;
        }
        self.readings.insert(place, (time_s, self.model.angle_rad(ticks)));
        let latest_s = self.readings.back().map_or(time_s, |(latest_s, _)| *latest_s);
        // One reading older than the kept span stays, so that every stamp inside the span lies between two readings.
        while self.readings.len() > 2 && self.readings[1].0 < latest_s - self.keep_s {
            self.readings.pop_front();
        }
        true
    }

    /// The steering between two stamps; `None` where no reading tells it.
    pub fn between(&self, from_s: f64, to_s: f64) -> Option<Steered> {
        let rate_rad_per_s = self.model.rate_rad_per_s * ABOVE;
        let first = self.readings.partition_point(|(stamp_s, _)| *stamp_s <= from_s);
        let stamps_s = self.readings.iter().skip(first).map(|(stamp_s, _)| *stamp_s);
        let (mut before_s, mut before_rad) = (from_s, self.at(from_s)?);
        let (mut sum, mut range_rad) = (Interval::ZERO, Interval::EMPTY);
        for stamp_s in stamps_s.take_while(|stamp_s| *stamp_s < to_s).chain([to_s]) {
            let now_rad = self.at(stamp_s)?;
            let lasts_s = stamp_s - before_s;
            let [mean_rad, within_rad] = between_ends(before_rad, now_rad, rate_rad_per_s * lasts_s);
            sum += mean_rad * lasts_s;
            range_rad = range_rad.hull(within_rad);
            (before_s, before_rad) = (stamp_s, now_rad);
        }
        let is_told = range_rad.magnitude() < MOST_RAD && to_s > from_s;
        is_told.then(|| {
            let mean_rad = (sum / Interval::point(to_s - from_s)).inflate(ROUNDING_RAD);
            Steered { mean_rad, range_rad, model: self.model }
        })
    }

    /// The steering angle at an instant by the readings before and after it; `None` where there is none, or where they contradict each other.
    fn at(&self, time_s: f64) -> Option<Interval> {
        let after = self.readings.partition_point(|(stamp_s, _)| *stamp_s < time_s);
        let told = |idx: usize| {
            let (stamp_s, angle_rad) = self.readings.get(idx)?;
            Some(angle_rad.inflate(self.model.rate_rad_per_s * (time_s - stamp_s).abs() * ABOVE))
        };
        let both = match (after.checked_sub(1).and_then(told), told(after)) {
            (Some(before_rad), Some(after_rad)) => before_rad.intersect(after_rad),
            (before_rad, after_rad) => before_rad.or(after_rad)?,
        };
        (!both.is_empty()).then_some(both)
    }
}

/// Enclosures of the mean and of all values of an angle that is within one interval at the begin of a time and within another at its end, and changes
/// by at most `most_rad` in that time.
fn between_ends(begin_rad: Interval, end_rad: Interval, most_rad: f64) -> [Interval; 2] {
    let bulge_rad = |off_rad: f64| {
        let is_reached = off_rad.abs() < most_rad;
        if is_reached { (most_rad * most_rad - off_rad * off_rad) / (4.0 * most_rad) * ABOVE } else { 0.0 }
    };
    let (low, high) = (begin_rad.lo() - end_rad.lo(), begin_rad.hi() - end_rad.hi());
    let middle = (begin_rad + end_rad) * 0.5;
    let mean = middle + Interval::new(-bulge_rad(low), bulge_rad(high));
    [mean, middle.inflate(0.5 * most_rad)]
}

/// The steering of a car between two stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steered {
    /// Enclosure of the mean steering angle over the time.
    pub mean_rad: Interval,
    /// Enclosure of all steering angles in that time.
    pub range_rad: Interval,
    /// Model of the steering.
    pub model: SteeringModel,
}

/// Sums of a car's turn by its steering and the travel of its rear axle since a stamp.
#[derive(Clone, Debug)]
pub(super) struct SteeringIntegral {
    /// Whether the steering is known in every step since the start.
    is_known: bool,
    /// For each wheel, the sum Σ Δn·tan δ̄ of ticks times the tangent of the steering angle, in ticks.
    tan_ticks: [Interval; 2],
    /// The tangents of the first and of the latest step; `None` before the first one.
    tangents: Option<[f64; 2]>,
    /// The sum of the tangents' changes from step to step, without regard to sign.
    variation: f64,
    /// The same sum, each change times the greatest error of the ticks where it is, in ticks.
    varied_ticks: f64,
    /// Greatest error of the ticks at the start and at the latest sample, about the middle of what the quantisation allows.
    errors_ticks: [f64; 2],
    remainder_m: f64,
    /// Greatest turn since the start, to either side without regard to sign, times the wheelbase.
    turning_m: f64,
}

impl SteeringIntegral {
    /// The sums at their start, before any step.
    pub(super) fn new(start: &WheelSample) -> Self {
        SteeringIntegral {
            is_known: true,
            tan_ticks: [Interval::ZERO; 2],
            tangents: None,
            variation: 0.0,
            varied_ticks: 0.0,
            errors_ticks: [0.5 + start.ticks_error; 2],
            remainder_m: 0.0,
            turning_m: 0.0,
        }
    }

    /// Adds a step that ends at a sample, in which the wheels counted `delta` ticks and rolled and slipped by at most `travel_m`. From a step without
    /// known steering on, the sums say nothing.
    pub(super) fn advance(
        &mut self,
        steered: Option<&Steered>,
        sample: &WheelSample,
        delta: [f64; 2],
        travel_m: f64,
        step_s: f64,
        reach: &Reach,
    ) {
        let Some(steered) = steered else {
            self.is_known = false;
            return;
        };
        let middle_rad = steered.mean_rad.mid();
        let tangent = middle_rad.tan();
        let exact = Interval::point(middle_rad).tan();
        let secant2 = 1.0 + exact.magnitude() * exact.magnitude();
        let steepest = steered.range_rad.tan().magnitude();
        let bend = steepest * (1.0 + steepest * steepest);
        let mean_off = (steered.mean_rad - middle_rad).magnitude();
        let off = (steered.range_rad - middle_rad).magnitude();
        let acceleration = reach.acceleration_m_per_s2;
        let path_m = travel_m + 0.25 * acceleration * step_s * step_s;
        self.remainder_m += secant2 * (travel_m * mean_off + 0.5 * off * acceleration * step_s * step_s)
            + (bend * off * off + (exact - tangent).magnitude()) * path_m;
        self.turning_m += steepest * path_m;

        for (sum, ticks) in self.tan_ticks.iter_mut().zip(delta) {
            *sum += Interval::point(tangent) * ticks;
        }
        let [first, before] = self.tangents.unwrap_or([tangent; 2]);
        self.variation += (tangent - before).abs();
        self.varied_ticks += (tangent - before).abs() * self.errors_ticks[1];
        self.tangents = Some([first, tangent]);
        self.errors_ticks[1] = 0.5 + sample.ticks_error;
    }

    /// The turn since the start; `None` where the steering was not known all the time. `slip_m` bounds the slip of the rear axle's middle along the
    /// way, `rolled_m` is the greatest distance that it rolled, and `windows` the number of slip windows that the time begins.
    pub(super) fn turn(
        &self,
        model: &SteeringModel,
        wheels: &WheelModel,
        slip_m: f64,
        rolled_m: f64,
        windows: f64,
    ) -> Option<Interval> {
        let [first, last] = self.tangents.filter(|_| self.is_known)?.map(f64::abs);
        let per_tick_m = [0, 1].map(|wheel| wheels.metres_per_tick(wheel));
        let sum_m = (per_tick_m[0] * self.tan_ticks[0] + per_tick_m[1] * self.tan_ticks[1]) * 0.5;
        let [at_start, at_end] = self.errors_ticks;
        let read_m = 0.5 * (per_tick_m[0].hi() + per_tick_m[1].hi());
        let quantised_m = read_m * (self.varied_ticks + last * at_end + first * at_start);
        let error_m = quantised_m + slip_m * (last + self.variation) + self.remainder_m;
        let turning_rad = self.turning_m / model.wheelbase_m.lo();
        let aside_rad =
            model.slip_share * turning_rad + model.slip_rad_per_m * rolled_m + windows * model.slip_floor_rad;
        Some((sum_m.inflate(error_m * ABOVE) / model.wheelbase_m).inflate(aside_rad * ABOVE))
    }
}
