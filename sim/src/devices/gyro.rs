//! The gyroscope, which measures the turn rate about the vertical.

mod bias;
mod sensor;

use interval::Interval;
use localizer::{
    bounds::{self, Assumption},
    robot::GyroModel,
};

use crate::{
    scene::{Distribution, Gyro, Scene},
    truth::randomness::{draw_within, stream},
};

use super::{Device, Sensor, ToldKey, Widens, relative, unsampled};

pub use bias::WanderingBias;
pub use sensor::GyroSensor;

/// True bias and scale of the gyroscope.
#[derive(Clone, Copy, Debug)]
pub struct DrawnGyro {
    /// True bias of the gyroscope at time 0; it is constant over a run unless the scene lets it wander.
    pub bias_rad_per_s: f64,
    /// True scale of the gyroscope, constant over a run.
    pub scale: f64,
    /// Bounds to which the gyroscope's noise is cut in a counterfactual run, one that is simulated again with bounds kept to find what was to blame.
    pub cuts: GyroCuts,
}

/// Bounds to which the gyroscope's noise is cut in a counterfactual run, one that is simulated again with bounds kept to find what was to blame. In a
/// run as a seed draws it the noise is cut to none of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GyroCuts {
    /// Whether the noise of each reading is cut to the bound `gyro.noise`.
    pub noise: bool,
    /// Whether the noise is cut so that the sum of the readings' errors keeps to the bound `gyro.angle`.
    pub angle: bool,
}

impl Device for Gyro {
    type Drawn = DrawnGyro;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnGyro {
        let mut rng = stream(seed, "gyro.calibration");
        DrawnGyro {
            bias_rad_per_s: draw_within(self.bias_tolerance_deg_per_s.to_radians(), errors, &mut rng),
            scale: 1.0 + draw_within(self.scale_tolerance, errors, &mut rng),
            cuts: GyroCuts::default(),
        }
    }

    fn sensor(&self, drawn: &DrawnGyro, scene: &Scene, seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(GyroSensor::new(self, drawn, scene, seed)))
    }

    fn is_on_base(&self) -> bool {
        true
    }

    fn is_relied_on(&self, _scene: &Scene) -> bool {
        true
    }

    fn constants(&self, drawn: &DrawnGyro, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        vec![
            (bounds::GYRO_BIAS, self.bias_tolerance_deg_per_s.to_radians(), drawn.bias_rad_per_s.abs()),
            (bounds::GYRO_SCALE, self.scale_tolerance, (drawn.scale - 1.0).abs()),
        ]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        let mut keys = vec![
            ToldKey::is_in_deg(&[bounds::GYRO_BIAS], &mut self.bias_tolerance_deg_per_s),
            ToldKey::is(&[bounds::GYRO_SCALE], &mut self.scale_tolerance),
            ToldKey::is_in_deg(&[bounds::GYRO_NOISE], &mut self.noise_deg_per_s),
            ToldKey::is_in_deg(&[bounds::GYRO_WANDER], &mut self.bias_wander_deg_per_s2),
            ToldKey::is_part(&[bounds::GYRO_ANGLE], &mut self.angle_deg_per_s, Widens::Not),
        ];
        keys.extend(
            self.angle_floor_deg.as_mut().map(|floor_deg| ToldKey::is_in_deg(&[bounds::GYRO_ANGLE], floor_deg)),
        );
        keys
    }

    /// Noise is drawn reading by reading, so that the sensor itself cuts off the noise that exceeds its bounds.
    const CLIPPED: &'static [Assumption] = &[bounds::GYRO_NOISE, bounds::GYRO_ANGLE];

    fn clip(&self, drawn: &mut DrawnGyro, bound: &str) {
        drawn.cuts.noise |= bound == bounds::GYRO_NOISE;
        drawn.cuts.angle |= bound == bounds::GYRO_ANGLE;
    }

    fn contradictions(&self) -> Vec<(String, String)> {
        let mut found = Vec::from_iter(unsampled(self.period_s).map(|expected| ("period_s".to_owned(), expected)));
        if let Some(walk_deg) = self.angle_random_walk_deg_per_sqrt_h
            && self.noise_deg_per_s < 3.0 * self.deviation_deg_per_s(walk_deg)
        {
            let least = 3.0 * self.deviation_deg_per_s(walk_deg);
            let expected =
                format!("cuts the angle random walk off, expected at least {least:.4}: three standard deviations");
            found.push(("noise_deg_per_s".to_owned(), expected));
        }
        if self.bias_wander_deg_per_s2 == 0.0
            && self.bias_instability_deg_per_h + self.rate_random_walk_deg_per_h_per_sqrt_h > 0.0
        {
            let expected = "the bias would be held fast, expected more than 0 to let it wander".to_owned();
            found.push(("bias_wander_deg_per_s2".to_owned(), expected));
        }
        if self.angle_deg_per_s > 0.0 && self.angle_floor_deg.is_none() {
            found.push((
                "angle_deg_per_s".to_owned(),
                "bounds nothing alone, expected `angle_floor_deg` beside it".to_owned(),
            ));
        }
        found
    }
}

impl Gyro {
    /// The model of the gyroscope that the localizer is given.
    pub(crate) fn model(&self) -> GyroModel {
        GyroModel {
            bias_rad_per_s: Interval::centred(0.0, self.bias_tolerance_deg_per_s.to_radians()),
            scale: relative(1.0, self.scale_tolerance),
            noise_rad_per_s: self.noise_deg_per_s.to_radians(),
            angle_floor_rad: self.angle_floor_deg.map_or(f64::INFINITY, f64::to_radians),
            angle_rad_per_s: self.angle_deg_per_s.to_radians(),
            bias_wander_rad_per_s2: self.bias_wander_deg_per_s2.to_radians(),
            period_s: self.period_s,
        }
    }
}
