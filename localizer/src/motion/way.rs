//! The way between two stamps, with the relations that a box of the motion loses.
//!
//! **Mid heading.** Let φ(t) be the heading, T(t) the true travel of the axle's middle since the first stamp a, L(t) its side slip, b the last stamp,
//! and β = (φ(a) + φ(b))/2 the mid heading. With ψ = φ − β the robot's displacement is, along β and to the left of it,
//!
//! along = ∫ cos ψ dT − ∫ sin ψ dL,   lateral = ∫ sin ψ dT + ∫ cos ψ dL.
//!
//! Seen from the mid heading, the errors of turn and displacement hardly depend on each other, and along differs from T(b) by a shortening of second
//! order in ψ: shortening = T(b) − along = ∫ (1 − cos ψ) dT + ∫ sin ψ dL. So travel and turn, which the wheels and the gyroscope measure, determine
//! the displacement nearly linearly.
//!
//! **Errors of the profile.** By the readings ψ is ψ₀; let η be the error of the turn rate in it. Then ψ − ψ₀ = ½(∫ₐᵗ η − ∫ₜᵇ η), so that with
//! C(t) = ∫ₐᵗ cos ψ₀ dT an exchange of the integrals gives
//!
//! ∫ (sin ψ − sin ψ₀) dT = ∫ η(s)·½(C(b) − 2C(s)) ds ± ½E²·∫ |dT|,   |ψ − ψ₀| ≤ E,
//!
//! and likewise for ∫ (1 − cos ψ) dT with S(t) = ∫ₐᵗ sin ψ₀ dT. An error e of the travel, |e| ≤ ē at every instant, contributes by summation by
//! parts |∫ sin ψ de| ≤ ē·(|sin ψ(b)| + ∫ |cos ψ dψ|).

use interval::Interval;

use crate::{
    bounds,
    bounds::Assumption,
    robot::{Reach, WheelModel},
};

use super::{
    GyroTurn, WheelHistory, WheelSample,
    gyro::TurnStep,
    integral::{KnownTurns, WheelIntegral, midpoint_remainder},
};

/// How the robot moved between two stamps, as far as its wheels and its gyroscope tell. The displacement is given by its components along and across
/// the mid heading, which is the mean of the headings at the two stamps.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Length of time between the two stamps.
    pub span_s: f64,
    /// Ticks of the left and of the right wheel. The true travel of a wheel's contact point is that many times the metres per tick, with an error of
    /// at most `travel_error_m`.
    pub ticks: [f64; 2],
    /// Greatest error of the travel of the left and of the right wheel by slip and by quantisation, in metres.
    pub travel_error_m: [f64; 2],
    /// The part of each wheel's `travel_error_m` that comes from slip.
    pub slip_m: [f64; 2],
    /// What of the half width of `shortening_m` comes from which declared bound; the rest is of second order.
    pub shortening_parts_m: Vec<(Assumption, f64)>,
    /// What of the half width of `lateral_m` comes from which declared bound; the rest is of second order.
    pub lateral_parts_m: Vec<(Assumption, f64)>,
    /// Component of the displacement along the mid heading.
    pub along_m: Interval,
    /// Travel of the axle's middle, less the component of the displacement along the mid heading.
    pub shortening_m: Interval,
    /// Component of the displacement across the mid heading, to the left.
    pub lateral_m: Interval,
    /// What the gyroscope tells of the turn; `None` without a gyroscope, and before its first reading.
    pub gyro: Option<GyroTurn>,
}

impl WheelHistory {
    /// The way from `from_s` to `to_s`; `None` where the wheel readings in memory do not cover it.
    pub fn way(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Way> {
        if to_s <= from_s {
            return None;
        }
        let samples = self.samples_between(from_s, to_s, wheels, reach)?;
        let wheels = &*self.model_over([from_s, to_s], wheels);
        let mut integral = WheelIntegral::new(samples[0]);
        samples[1..].iter().for_each(|sample| integral.advance(sample, KnownTurns::default(), wheels, reach));
        let profile = match &self.gyro {
            Some(gyro) => {
                let stamps: Vec<f64> = samples.iter().map(|sample| sample.time_s).collect();
                Profile::by_gyro(
                    gyro.turn_steps(&stamps, super::greatest_change_rad_per_s2(wheels, reach))?,
                    gyro.noise_bound(),
                )
            }
            None => Profile::by_wheels(&samples, &integral, wheels),
        };
        let sides = Sides::along(&samples, &profile, &integral, wheels, reach);
        let ticks = [0, 1].map(|wheel| samples[samples.len() - 1].ticks[wheel] - samples[0].ticks[wheel]);
        Some(Way {
            span_s: to_s - from_s,
            ticks,
            travel_error_m: [0, 1].map(|wheel| integral.travel_error(wheel, wheels)),
            slip_m: [0, 1].map(|wheel| integral.slip_error(wheel, wheels)),
            shortening_parts_m: sides.shortening_parts_m,
            lateral_parts_m: sides.lateral_parts_m,
            along_m: integral.travel_of_middle(wheels) - sides.shortening_m,
            shortening_m: sides.shortening_m,
            lateral_m: sides.lateral_m,
            gyro: self
                .gyro
                .as_ref()
                .and_then(|gyro| gyro.turn_read(from_s, to_s, super::greatest_change_rad_per_s2(wheels, reach))),
        })
    }

    /// The wheels' counts at both ends of a span and at every reading between.
    fn samples_between(&self, from_s: f64, to_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<Vec<WheelSample>> {
        let mut samples = vec![self.at(from_s, wheels, reach)?];
        let next = self.samples.partition_point(|sample| sample.time_s <= from_s);
        samples.extend(self.samples.iter().skip(next).take_while(|sample| sample.time_s < to_s));
        samples.push(self.at(to_s, wheels, reach).or_else(|| self.ahead(to_s, wheels, reach))?);
        Some(samples)
    }
}

/// The heading relative to the first stamp at each sample of a way, by the readings, with what it can be off by.
struct Profile {
    /// Heading at each sample, relative to that at the first one.
    heading_rad: Vec<f64>,
    /// For each step, the greatest error of its turn by causes whose errors in different steps add up.
    step_error_rad: Vec<f64>,
    /// Greatest error of the turn between any two samples by other causes.
    error_rad: f64,
    /// Greatest error of the turn between any two samples by all causes, where that is known to be less than the sum of the other two.
    most_error_rad: f64,
    /// The declared bound that makes most of the errors.
    bound: Assumption,
}

impl Profile {
    fn by_gyro(steps: Vec<TurnStep>, bound: Assumption) -> Profile {
        let mut heading_rad = vec![0.0];
        let mut at_rad = 0.0;
        for step in &steps {
            at_rad += step.turn_rad;
            heading_rad.push(at_rad);
        }
        Profile {
            heading_rad,
            step_error_rad: steps.iter().map(|step| step.error_rad).collect(),
            error_rad: steps.iter().map(|step| step.bend_rad).fold(0.0, f64::max) * 2.0,
            most_error_rad: steps.last().map_or(0.0, |last| last.span_error_rad),
            bound,
        }
    }

    fn by_wheels(samples: &[WheelSample], integral: &WheelIntegral, wheels: &WheelModel) -> Profile {
        let per_tick_m = [0, 1].map(|wheel| wheels.metres_per_tick(wheel).mid());
        let turn = |sample: &WheelSample| {
            let travel_m = [0, 1].map(|wheel| (sample.ticks[wheel] - samples[0].ticks[wheel]) * per_tick_m[wheel]);
            (travel_m[1] - travel_m[0]) / wheels.track_m.mid()
        };
        let error_rad = integral.greatest_turn_error(wheels);
        Profile {
            heading_rad: samples.iter().map(turn).collect(),
            step_error_rad: vec![0.0; samples.len() - 1],
            error_rad,
            most_error_rad: error_rad,
            bound: bounds::WHEELS_SLIP,
        }
    }
}

/// The parts of a way's displacement that depend on the profile of its heading.
struct Sides {
    shortening_m: Interval,
    lateral_m: Interval,
    /// The parts of their half widths that declared bounds make.
    shortening_parts_m: Vec<(Assumption, f64)>,
    lateral_parts_m: Vec<(Assumption, f64)>,
}

impl Sides {
    fn along(
        samples: &[WheelSample],
        profile: &Profile,
        integral: &WheelIntegral,
        wheels: &WheelModel,
        reach: &Reach,
    ) -> Sides {
        let last = samples.len() - 1;
        let end_rad = 0.5 * profile.heading_rad[last];
        let per_tick_m = [0, 1].map(|wheel| wheels.metres_per_tick(wheel).mid());
        // C, S and the path at each sample, and the remainders of the steps.
        let (mut cos_m, mut sin_m, mut path_m) = (vec![0.0], vec![0.0], 0.0);
        // A step of length D that turns by 2h: within it, C and S depart from their chords by at most D·h/4, as their slopes change by at most 2h;
        // and ∫ |cos ψ₀| |dT| is at most D·h/2 more than the change of C, where ψ₀ passes a right angle, and likewise for S.
        let mut bulged_m = Vec::with_capacity(last);
        let (mut short_m, mut remainder_m, mut turning_rad) = (0.0, 0.0, 0.0);
        for step in 0..last {
            let delta = [0, 1].map(|wheel| samples[step + 1].ticks[wheel] - samples[step].ticks[wheel]);
            let travel_m = 0.5 * (delta[0] * per_tick_m[0] + delta[1] * per_tick_m[1]);
            let (from_rad, to_rad) = (profile.heading_rad[step] - end_rad, profile.heading_rad[step + 1] - end_rad);
            let (middle_rad, half_rad) = (0.5 * (from_rad + to_rad), 0.5 * (to_rad - from_rad));
            let chord_m = travel_m * (1.0 - half_rad * half_rad / 6.0);
            cos_m.push(cos_m[step] + chord_m * middle_rad.cos());
            sin_m.push(sin_m[step] + chord_m * middle_rad.sin());
            bulged_m.push(0.5 * travel_m.abs() * half_rad.abs());
            short_m += travel_m - chord_m * middle_rad.cos();
            path_m += travel_m.abs();
            turning_rad += 2.0 * half_rad.abs() + profile.step_error_rad[step] + 2.0 * profile.error_rad;
            let counts = 1.0 + samples[step].ticks_error + samples[step + 1].ticks_error;
            let step_s = samples[step + 1].time_s - samples[step].time_s;
            // A turn rate that changes its sign within a step turns the robot forth and back by at most α·T²/4 more than the step's turn.
            turning_rad += 0.25 * super::greatest_change_rad_per_s2(wheels, reach) * step_s * step_s;
            remainder_m += midpoint_remainder(
                delta,
                counts,
                integral.step_turn(delta, counts, step_s, wheels).magnitude(),
                step_s,
                wheels,
                reach,
            ) + travel_m.abs() * half_rad.powi(4) / 120.0;
        }
        // First order: what the error of each step's turn rate does; or, where the whole error of a turn is known to be less, what that does.
        let weighted = |parts: &[f64]| -> f64 {
            let total = parts[last];
            let most = |step: usize| (total - 2.0 * parts[step]).abs().max((total - 2.0 * parts[step + 1]).abs());
            (0..last).map(|step| 0.5 * profile.step_error_rad[step] * (most(step) + bulged_m[step])).sum()
        };
        let steps_rad: f64 = profile.step_error_rad.iter().sum();
        let off_rad = (0.5 * steps_rad + profile.error_rad).min(profile.most_error_rad);
        let first_order_m = |parts: &[f64]| {
            let length_m: f64 =
                parts.windows(2).zip(&bulged_m).map(|(pair, bulged_m)| (pair[1] - pair[0]).abs() + bulged_m).sum();
            (weighted(parts) + profile.error_rad * length_m).min(profile.most_error_rad * length_m)
        };
        let second_order_m = 0.5 * off_rad * off_rad * path_m;

        let (travel_error_m, side_m) = integral.errors_of_middle(wheels);
        let psi_rad = (end_rad.abs() + off_rad).min(std::f64::consts::PI);
        // The wheels bound the turning, too, where the noise of a gyroscope is large or not bounded.
        let turning_rad = turning_rad.min(integral.turning_rad());
        let sine = psi_rad.min(std::f64::consts::FRAC_PI_2).sin();
        let across_m = travel_error_m * (sine + turning_rad) + side_m * (1.0 + turning_rad);
        let along_m = travel_error_m * (1.0 - psi_rad.cos() + turning_rad) + side_m * (sine + turning_rad);
        let about = |middle_m: f64, most_m: f64| {
            Interval::point(middle_m).inflate(most_m * ABOVE + ROUNDING * (path_m + most_m))
        };
        let slip_m = 0.5 * (0..2).map(|wheel| integral.slip_error(wheel, wheels)).sum::<f64>();
        let parts = |by_heading_m: f64, slip_share: f64, side_share: f64| {
            vec![
                (bounds::WHEELS_SIDE_SLIP, side_m * side_share),
                (bounds::WHEELS_SLIP, slip_m * slip_share),
                (profile.bound, by_heading_m),
                (bounds::REACH_ACCELERATION, remainder_m),
            ]
        };
        let (by_sine_m, by_cosine_m) = (first_order_m(&sin_m), first_order_m(&cos_m));
        Sides {
            shortening_m: about(short_m, by_sine_m + second_order_m + remainder_m + along_m),
            lateral_m: about(sin_m[last], by_cosine_m + second_order_m + remainder_m + across_m),
            shortening_parts_m: parts(by_sine_m, 1.0 - psi_rad.cos() + turning_rad, sine + turning_rad),
            lateral_parts_m: parts(by_cosine_m, sine + turning_rad, 1.0 + turning_rad),
        }
    }
}

/// Factor by which a sum of positive error bounds is increased, to make up for the few roundings of the sum.
const ABOVE: f64 = 1.0 + 1e-9;
/// Share of the path by which sums over all steps may be off by rounding: far more than a thousand roundings make.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod remainders;
