//! The steering encoder, which reads the steering angle of a car.

use interval::Interval;
use localizer::{
    Reading,
    bounds::{self, Assumption},
    motion::steering::DEVICE,
    robot::SteeringModel,
};

use crate::{
    place::Bystander,
    scene::{Base, Distribution, Scene, SteeringEncoder},
    truth::{
        Truth,
        randomness::{draw_within, stream},
    },
};

use super::{Device, Observation, Sensor, ToldKey, Widens, relative, unsampled};

/// True zero and scale of the steering encoder.
#[derive(Clone, Copy, Debug)]
pub struct DrawnSteeringEncoder {
    /// Angle that the encoder truly reads when the car is steered straight ahead.
    pub zero_rad: f64,
    /// True scale factor of the encoder.
    pub scale: f64,
}

impl Device for SteeringEncoder {
    type Drawn = DrawnSteeringEncoder;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnSteeringEncoder {
        let mut rng = stream(seed, "steering_encoder.calibration");
        DrawnSteeringEncoder {
            zero_rad: (draw_within(self.zero_tolerance_deg, errors, &mut rng) + self.zero_shift_deg).to_radians(),
            scale: 1.0 + draw_within(self.scale_tolerance, errors, &mut rng),
        }
    }

    fn sensor(&self, drawn: &DrawnSteeringEncoder, _scene: &Scene, _seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(SteeringSensor { encoder: self.clone(), drawn: *drawn, n_readings: 0 }))
    }

    fn is_on_base(&self) -> bool {
        true
    }

    fn is_relied_on(&self, _scene: &Scene) -> bool {
        true
    }

    fn constants(&self, drawn: &DrawnSteeringEncoder, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        vec![
            (bounds::STEERING_ENCODER_ZERO, self.zero_tolerance_deg.to_radians(), drawn.zero_rad.abs()),
            (bounds::STEERING_ENCODER_SCALE, self.scale_tolerance, (drawn.scale - 1.0).abs()),
        ]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        let per_true = f64::to_degrees(1.0);
        let slip = |value, widens| ToldKey { bounds: &[bounds::WHEELS_STEERING_SLIP], value, per_true, widens };
        vec![
            ToldKey::is_in_deg(&[bounds::STEERING_ENCODER_ZERO], &mut self.zero_tolerance_deg),
            ToldKey::is(&[bounds::STEERING_ENCODER_SCALE], &mut self.scale_tolerance),
            ToldKey::is_in_deg(&[bounds::WHEELS_STEERING_RATE], &mut self.rate_deg_per_s),
            slip(&mut self.slip_share, Widens::Not),
            slip(&mut self.slip_deg_per_m, Widens::Not),
            slip(&mut self.slip_floor_deg, Widens::By),
        ]
    }

    const CLIPPED: &'static [Assumption] = &[bounds::STEERING_ENCODER_ZERO];

    fn clip(&self, drawn: &mut DrawnSteeringEncoder, bound: &str) {
        if bound == bounds::STEERING_ENCODER_ZERO {
            let most_rad = self.zero_tolerance_deg.to_radians();
            drawn.zero_rad = drawn.zero_rad.clamp(-most_rad, most_rad);
        }
    }

    fn contradictions(&self) -> Vec<(String, String)> {
        Vec::from_iter(unsampled(self.period_s).map(|expected| ("period_s".to_owned(), expected)))
    }
}

impl SteeringEncoder {
    /// The model of the steering that the localizer is given.
    pub(crate) fn model(&self, base: &Base) -> SteeringModel {
        SteeringModel {
            wheelbase_m: relative(base.ackermann.wheelbase_m, base.ackermann.wheelbase_tolerance),
            rad_per_tick: self.rad_per_tick(),
            zero_rad: Interval::centred(0.0, self.zero_tolerance_deg.to_radians()),
            scale: relative(1.0, self.scale_tolerance),
            rate_rad_per_s: self.rate_deg_per_s.to_radians(),
            slip_share: self.slip_share,
            slip_rad_per_m: self.slip_deg_per_m.to_radians(),
            slip_floor_rad: self.slip_floor_deg.to_radians(),
        }
    }

    fn rad_per_tick(&self) -> f64 {
        std::f64::consts::TAU / f64::from(self.ticks_per_turn)
    }
}

/// An encoder of the steering angle that is read every period.
struct SteeringSensor {
    encoder: SteeringEncoder,
    drawn: DrawnSteeringEncoder,
    n_readings: u64,
}

impl Sensor for SteeringSensor {
    /// Returns the ticks that are nearest to the steering angle when a reading is due.
    fn observe(&mut self, truth: &Truth, _people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < self.n_readings as f64 * self.encoder.period_s {
            return None;
        }
        self.n_readings += 1;
        let read_rad = self.drawn.scale * truth.steering_rad + self.drawn.zero_rad;
        let numbers = vec![(read_rad / self.encoder.rad_per_tick()).round()];
        let (measured_s, device) = (truth.time_s, DEVICE.to_owned());
        Some(Observation::new(Reading::Other { measured_s, arrived_s: measured_s, device, numbers }, *truth))
    }
}
