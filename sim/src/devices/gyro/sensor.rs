//! The gyroscope as a sensor: the mean turn rate of the body since the last reading, with scale, bias and noise.

use localizer::{Reading, bounds};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::Bystander,
    scene::{Distribution, Gyro, Scene},
    truth::{
        Truth,
        randomness::{self, draw_within},
    },
};

use super::{DrawnGyro, bias::WanderingBias};

/// Factor for rounding, by which true values are reduced before they are compared with a bound: the difference of two times that are 5 ms apart has
/// lost some digits.
const ROUNDING: f64 = 1.0 - 1e-6;

/// A gyroscope that averages the turn rate over each period.
pub struct GyroSensor {
    gyro: Gyro,
    calibration: DrawnGyro,
    errors: Distribution,
    /// Side to which the noise pushes with the error distribution `drift`: 1 or −1.
    side: f64,
    noise: ChaCha8Rng,
    noise_deviation_rad_per_s: f64,
    bias: WanderingBias,
    angle: BoundedAngle,
    /// Whether the bound `gyro.wander` on the rate at which the bias changes is checked: where the localizer learns the bias, and no bound
    /// `gyro.angle` limits the angle to which the readings' errors add up.
    watches_wander: bool,
    n_readings: u64,
    before: Option<Truth>,
    /// Time and bias of the previous reading.
    bias_before: Option<(f64, f64)>,
}

impl GyroSensor {
    /// The gyroscope with its true calibration, as drawn at random.
    pub fn new(gyro: &Gyro, calibration: &DrawnGyro, scene: &Scene, seed: u64) -> Self {
        let of_random_walk = |walk_deg: f64| gyro.deviation_deg_per_s(walk_deg).to_radians();
        let errors = scene.robot.errors;
        let third_rad_per_s = gyro.noise_deg_per_s.to_radians() / 3.0;
        GyroSensor {
            noise_deviation_rad_per_s: gyro.angle_random_walk_deg_per_sqrt_h.map_or(third_rad_per_s, of_random_walk),
            angle: BoundedAngle::new(gyro),
            bias: WanderingBias::new(gyro, calibration.bias_rad_per_s, errors, randomness::stream(seed, "gyro.wander")),
            side: draw_within(1.0, Distribution::Drift, &mut randomness::stream(seed, "gyro.drift")),
            errors,
            watches_wander: scene.localizer.learns_gyro && gyro.angle_floor_deg.is_none(),
            gyro: gyro.clone(),
            calibration: *calibration,
            noise: randomness::stream(seed, "gyro.noise"),
            n_readings: 0,
            before: None,
            bias_before: None,
        }
    }
}

impl Sensor for GyroSensor {
    /// Returns a reading at the end of each period.
    fn observe(&mut self, truth: &Truth, _people: &[Bystander]) -> Option<Observation> {
        if truth.time_s + 0.0005 < self.n_readings as f64 * self.gyro.period_s {
            return None;
        }
        self.n_readings += 1;
        let before = self.before.replace(*truth)?;
        let turned_rad = truth.pose.heading_rad - before.pose.heading_rad;
        let true_rad_per_s = turned_rad / (truth.time_s - before.time_s);
        let bias_rad_per_s = self.bias.at(0.5 * (before.time_s + truth.time_s));
        let noise_rad_per_s = self.draw_bounded_rad_per_s(bias_rad_per_s - self.calibration.bias_rad_per_s);
        let rate_rad_per_s = self.calibration.scale * true_rad_per_s + bias_rad_per_s + noise_rad_per_s;
        let reading = Reading::Gyro { measured_s: truth.time_s, arrived_s: truth.time_s, rate_rad_per_s };
        let checks = self.checks(truth.time_s, bias_rad_per_s, noise_rad_per_s);
        Some(Observation { checks, ..Observation::new(reading, *truth) })
    }
}

impl GyroSensor {
    /// The declared bounds on the errors of one gyroscope reading, each with the true value of the error.
    fn checks(&mut self, time_s: f64, bias_rad_per_s: f64, noise_rad_per_s: f64) -> Vec<BoundCheck> {
        let gyro = &self.gyro;
        let span_s = [time_s - gyro.period_s, time_s];
        let check = |bound, declared, true_value| BoundCheck { bound, span_s, declared, true_value };
        let floor_rad = gyro.angle_floor_deg.map_or(f64::INFINITY, f64::to_radians);
        let mut checks = vec![
            check(bounds::GYRO_BIAS, gyro.bias_tolerance_deg_per_s.to_radians(), bias_rad_per_s.abs()),
            check(bounds::GYRO_NOISE, gyro.noise_deg_per_s.to_radians(), noise_rad_per_s.abs()),
            check(bounds::GYRO_ANGLE, floor_rad, self.angle.beyond_rad * ROUNDING),
        ];
        if self.watches_wander {
            let before = self.bias_before.replace((time_s, bias_rad_per_s));
            let wander_rad_per_s2 = before.map_or(0.0, |(before_s, before_rad_per_s)| {
                (bias_rad_per_s - before_rad_per_s).abs() / (time_s - before_s)
            });
            let declared = gyro.bias_wander_deg_per_s2.to_radians();
            checks.push(check(bounds::GYRO_WANDER, declared, wander_rad_per_s2 * ROUNDING));
        }
        checks
    }

    /// Noise of one reading. Where the scene says that noise beyond its bounds is drawn again, draws are repeated until the sum of noise and of the
    /// bias's departure from its value at time 0 keeps, over any time span, to the bound `gyro.angle`.
    fn draw_bounded_rad_per_s(&mut self, departed_rad_per_s: f64) -> f64 {
        /// Greatest number of draws of noise for one reading. If none of them keeps to the bound on the sum of errors, the reading has no
        /// noise: the bias alone departs by no more than the bound grows.
        const MOST_DRAWS: usize = 1000;
        if self.errors == Distribution::Drift {
            return self.push_rad_per_s(departed_rad_per_s);
        }
        for _ in 0..if self.redraws() { MOST_DRAWS } else { 0 } {
            let noise_rad_per_s = self.draw_noise_rad_per_s();
            if self.angle.allows(departed_rad_per_s + noise_rad_per_s) {
                self.angle.take(departed_rad_per_s + noise_rad_per_s);
                return noise_rad_per_s;
            }
        }
        let drawn_rad_per_s = if self.redraws() { 0.0 } else { self.draw_noise_rad_per_s() };
        let noise_rad_per_s = self.cut_rad_per_s(drawn_rad_per_s, departed_rad_per_s);
        self.angle.take(departed_rad_per_s + noise_rad_per_s);
        noise_rad_per_s
    }

    /// The noise without the part that exceeds the bounds to which it is cut; from each reading as little as possible is cut off. Since the
    /// bias alone departs by no more than the bound `gyro.angle` grows, noise of 0 keeps to that bound: cutting moves noise towards 0, so
    /// that it keeps to both bounds if it is cut to both.
    fn cut_rad_per_s(&self, noise_rad_per_s: f64, departed_rad_per_s: f64) -> f64 {
        let (cuts, bound_rad_per_s) = (self.calibration.cuts, self.gyro.noise_deg_per_s.to_radians());
        let noise_rad_per_s =
            if cuts.noise { noise_rad_per_s.clamp(-bound_rad_per_s, bound_rad_per_s) } else { noise_rad_per_s };
        let error_rad_per_s = departed_rad_per_s + noise_rad_per_s;
        if cuts.angle && !self.angle.allows(error_rad_per_s) {
            self.angle.nearest_allowed(error_rad_per_s) - departed_rad_per_s
        } else {
            noise_rad_per_s
        }
    }

    /// Whether noise beyond its bounds is drawn again. With the error distribution `corner` it always is, because that distribution goes to
    /// the limits of what the bounds allow.
    fn redraws(&self) -> bool {
        self.gyro.noise_redrawn || self.errors == Distribution::Corner
    }

    /// Noise with the error distribution `drift`: as far to one side as its own bound and the bound on the sum of errors allow.
    fn push_rad_per_s(&mut self, departed_rad_per_s: f64) -> f64 {
        let bound_rad_per_s = self.gyro.noise_deg_per_s.to_radians();
        let wanted_rad_per_s = departed_rad_per_s + self.side * bound_rad_per_s;
        let noise_rad_per_s = self.angle.nearest_allowed(wanted_rad_per_s) - departed_rad_per_s;
        let noise_rad_per_s = noise_rad_per_s.clamp(-bound_rad_per_s, bound_rad_per_s);
        self.angle.take(departed_rad_per_s + noise_rad_per_s);
        noise_rad_per_s
    }

    /// One draw of noise: at its bound with the error distribution `corner`, otherwise normal and, unless noise may exceed its bound, drawn
    /// again until it is within the bound.
    fn draw_noise_rad_per_s(&mut self) -> f64 {
        let bound_rad_per_s = self.gyro.noise_deg_per_s.to_radians();
        if self.errors == Distribution::Corner {
            return draw_within(bound_rad_per_s, self.errors, &mut self.noise);
        }
        let Some(_) = self.gyro.angle_random_walk_deg_per_sqrt_h else {
            // A different order of these operations would change the last bits of the noise, and with them a run's results.
            let third = self.draw_deviations(3.0);
            return bound_rad_per_s * third / 3.0;
        };
        if self.noise_deviation_rad_per_s == 0.0 {
            return 0.0;
        }
        let most =
            if self.gyro.noise_redrawn { bound_rad_per_s / self.noise_deviation_rad_per_s } else { f64::INFINITY };
        self.noise_deviation_rad_per_s * self.draw_deviations(most)
    }

    fn draw_deviations(&mut self, most: f64) -> f64 {
        loop {
            let deviations: f64 = StandardNormal.sample(&mut self.noise);
            if deviations.abs() <= most {
                return deviations;
            }
        }
    }
}

/// The angle to which the errors of the gyroscope's readings add up. Between any two times s and t its change is kept within floor + rate·|t − s|,
/// where floor and rate are the two parts of the declared bound.
///
/// Let W be the sum of the errors, a the floor and r the rate. That W(t) − W(s) ≤ a + r·(t − s) for all s before t is W(t) − r·t ≤ a + min (W(s) −
/// r·s), and likewise below.
struct BoundedAngle {
    floor_rad: f64,
    rad_per_s: f64,
    period_s: f64,
    time_s: f64,
    sum_rad: f64,
    least_rad: f64,
    greatest_rad: f64,
    /// The greatest amount by which the change of the sum of errors since any earlier time s exceeds rate·|t − s|. The bound's constant part, the
    /// floor, limits this amount.
    beyond_rad: f64,
}

impl BoundedAngle {
    fn new(gyro: &Gyro) -> Self {
        BoundedAngle {
            floor_rad: gyro.angle_floor_deg.map_or(f64::INFINITY, f64::to_radians),
            rad_per_s: gyro.angle_deg_per_s.to_radians(),
            period_s: gyro.period_s,
            time_s: 0.0,
            sum_rad: 0.0,
            least_rad: 0.0,
            greatest_rad: 0.0,
            beyond_rad: 0.0,
        }
    }

    /// Values after one more reading with this error: the time, the sum of the errors, and the greatest amount by which the sum's change since any
    /// earlier time s exceeds rate·|t − s|.
    fn after(&self, error_rad_per_s: f64) -> [f64; 3] {
        let (time_s, sum_rad) = (self.time_s + self.period_s, self.sum_rad + error_rad_per_s * self.period_s);
        let (low, high) = (sum_rad - self.rad_per_s * time_s, sum_rad + self.rad_per_s * time_s);
        [time_s, sum_rad, (low - self.least_rad).max(self.greatest_rad - high)]
    }

    /// Whether the sum of the gyroscope's errors keeps to its bound if the next reading has this error.
    fn allows(&self, error_rad_per_s: f64) -> bool {
        self.after(error_rad_per_s)[2] <= self.floor_rad
    }

    /// The error of the next reading nearest to `error_rad_per_s` with which the sum of the gyroscope's errors keeps to its bound.
    fn nearest_allowed(&self, error_rad_per_s: f64) -> f64 {
        // Solves the equation in the function `after` for the error of the next reading with which the change of the sum of errors is exactly at its
        // bound.
        let left_rad = self.floor_rad + self.rad_per_s * (self.time_s + self.period_s);
        let most_rad_per_s = (left_rad + self.least_rad - self.sum_rad) / self.period_s;
        let least_rad_per_s = (self.greatest_rad - left_rad - self.sum_rad) / self.period_s;
        error_rad_per_s.min(most_rad_per_s).max(least_rad_per_s)
    }

    /// Adds the error of one reading to the sum of the gyroscope's errors.
    fn take(&mut self, error_rad_per_s: f64) {
        let [time_s, sum_rad, beyond_rad] = self.after(error_rad_per_s);
        self.beyond_rad = beyond_rad.max(0.0);
        (self.time_s, self.sum_rad) = (time_s, sum_rad);
        self.least_rad = self.least_rad.min(sum_rad - self.rad_per_s * time_s);
        self.greatest_rad = self.greatest_rad.max(sum_rad + self.rad_per_s * time_s);
    }
}
