//! The gyroscope: turn of the body since the last reading, read through scale, bias and noise.

use localizer::{Reading, bounds};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::Bystander,
    randomness::{self, draw_within},
    scene::{Distribution, Gyro, Scene},
    truth::Truth,
};

use super::{DrawnGyro, bias::WanderingBias};

/// Times 5 ms apart have lost some digits of their difference.
const ROUNDING: f64 = 1.0 - 1e-6;

/// A gyroscope that averages over each period.
pub struct GyroSensor {
    gyro: Gyro,
    calibration: DrawnGyro,
    errors: Distribution,
    /// To which side the noise of a drift pushes: 1 or −1.
    side: f64,
    noise: ChaCha8Rng,
    noise_deviation_rad_per_s: f64,
    bias: WanderingBias,
    angle: BoundedAngle,
    /// Whether its bias has to hold from one fix to the next: where it is learnt, and `gyro.angle` does not tell how far it gets.
    watches_wander: bool,
    n_readings: u64,
    before: Option<Truth>,
    /// Time and bias of the reading before.
    bias_before: Option<(f64, f64)>,
}

impl GyroSensor {
    /// The gyroscope, calibrated as drawn.
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
    /// Answers with a reading at the end of each period.
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
    /// The declared bounds beside what was true of one reading's errors.
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

    /// Noise that with the bias's departure from its first value adds up, over any span, to what is declared; drawn again otherwise.
    fn draw_bounded_rad_per_s(&mut self, departed_rad_per_s: f64) -> f64 {
        /// What none of as many draws keeps to is read without noise: the bias alone departs by no more than the bound grows.
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

    /// Noise without what of it is beyond the bounds that it is cut to, reading by reading the least that has to be taken off. As the bias alone
    /// departs by no more than the band grows, noise of 0 keeps to it: what is cut is nearer to 0, and keeps to both bounds if it is cut to both.
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

    /// Whether noise keeps to its bounds by being drawn again. At corners it does so anyway: they are about what bounds allow.
    fn redraws(&self) -> bool {
        self.gyro.noise_redrawn || self.errors == Distribution::Corner
    }

    /// Noise of a drift: as far to its side as its bound and that of the sum let it.
    fn push_rad_per_s(&mut self, departed_rad_per_s: f64) -> f64 {
        let bound_rad_per_s = self.gyro.noise_deg_per_s.to_radians();
        let wanted_rad_per_s = departed_rad_per_s + self.side * bound_rad_per_s;
        let noise_rad_per_s = self.angle.nearest_allowed(wanted_rad_per_s) - departed_rad_per_s;
        let noise_rad_per_s = noise_rad_per_s.clamp(-bound_rad_per_s, bound_rad_per_s);
        self.angle.take(departed_rad_per_s + noise_rad_per_s);
        noise_rad_per_s
    }

    /// Normal, drawn again when beyond the bound; or at its bound.
    fn draw_noise_rad_per_s(&mut self) -> f64 {
        let bound_rad_per_s = self.gyro.noise_deg_per_s.to_radians();
        if self.errors == Distribution::Corner {
            return draw_within(bound_rad_per_s, self.errors, &mut self.noise);
        }
        let Some(_) = self.gyro.angle_random_walk_deg_per_sqrt_h else {
            // The same order of operations as ever, so that runs keep their bytes.
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

/// What errors of readings have added up to, kept within floor + rate·|t − s| between any two times s and t.
///
/// With W the sum, W(t) − W(s) ≤ a + r·(t − s) for all s before t is W(t) − r·t ≤ a + min (W(s) − r·s), and likewise below.
struct BoundedAngle {
    floor_rad: f64,
    rad_per_s: f64,
    period_s: f64,
    time_s: f64,
    sum_rad: f64,
    least_rad: f64,
    greatest_rad: f64,
    /// What of the sum since any time is not rate·|t − s|.
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

    /// Time, sum and what of it is beyond rate·|t − s| after one more reading.
    fn after(&self, error_rad_per_s: f64) -> [f64; 3] {
        let (time_s, sum_rad) = (self.time_s + self.period_s, self.sum_rad + error_rad_per_s * self.period_s);
        let (low, high) = (sum_rad - self.rad_per_s * time_s, sum_rad + self.rad_per_s * time_s);
        [time_s, sum_rad, (low - self.least_rad).max(self.greatest_rad - high)]
    }

    /// Whether the sum keeps to its bound with one more reading's error.
    fn allows(&self, error_rad_per_s: f64) -> bool {
        self.after(error_rad_per_s)[2] <= self.floor_rad
    }

    /// Of the errors with which the sum keeps to its bound, the one nearest to `error_rad_per_s`.
    fn nearest_allowed(&self, error_rad_per_s: f64) -> f64 {
        // `after` solved for the error of which nothing is left beyond the floor.
        let left_rad = self.floor_rad + self.rad_per_s * (self.time_s + self.period_s);
        let most_rad_per_s = (left_rad + self.least_rad - self.sum_rad) / self.period_s;
        let least_rad_per_s = (self.greatest_rad - left_rad - self.sum_rad) / self.period_s;
        error_rad_per_s.min(most_rad_per_s).max(least_rad_per_s)
    }

    /// Adds one reading's error.
    fn take(&mut self, error_rad_per_s: f64) {
        let [time_s, sum_rad, beyond_rad] = self.after(error_rad_per_s);
        self.beyond_rad = beyond_rad.max(0.0);
        (self.time_s, self.sum_rad) = (time_s, sum_rad);
        self.least_rad = self.least_rad.min(sum_rad - self.rad_per_s * time_s);
        self.greatest_rad = self.greatest_rad.max(sum_rad + self.rad_per_s * time_s);
    }
}
