//! What was truly behind the readings of gyroscope and flow sensor, for the check of their bounds.

use localizer::Reading;

use crate::sensors::{Observation, flow::FlowTruth};

/// True values that the declared bounds of gyroscope and flow sensor are about.
#[derive(Clone, Debug, Default)]
pub struct MotionSensors {
    /// Greatest noise in a reading of the gyroscope.
    pub greatest_gyro_noise_rad_per_s: f64,
    /// Greatest bias in one.
    pub greatest_gyro_bias_rad_per_s: f64,
    /// Greatest change of the bias over time, between two readings in a row.
    pub greatest_gyro_wander_rad_per_s2: f64,
    /// Each reading of the flow sensor.
    pub flow: Vec<FlowSight>,
    /// Stamp and bias of the gyroscope's latest reading.
    latest_bias: Option<(f64, f64)>,
}

/// One reading of the flow sensor.
#[derive(Clone, Copy, Debug)]
pub struct FlowSight {
    /// End of its period.
    pub measured_s: f64,
    /// What was wrong with it.
    pub truth: FlowTruth,
    /// Periods so far in which it found nothing to follow.
    pub blind_periods: u64,
}

impl MotionSensors {
    /// Notes what is behind a reading; those of other sensors have nothing to tell. Times run on by `offset_s` from station to station.
    pub(super) fn note(&mut self, observation: &Observation, offset_s: f64) {
        let measured_s = observation.reading.measured_s() + offset_s;
        match observation.reading {
            Reading::Gyro { .. } => {
                let (noise, bias) = (observation.gyro_noise_rad_per_s.abs(), observation.gyro_bias_rad_per_s);
                self.greatest_gyro_noise_rad_per_s = self.greatest_gyro_noise_rad_per_s.max(noise);
                self.greatest_gyro_bias_rad_per_s = self.greatest_gyro_bias_rad_per_s.max(bias.abs());
                if let Some((before_s, before)) = self.latest_bias
                    && measured_s > before_s
                {
                    let wander = (bias - before).abs() / (measured_s - before_s);
                    self.greatest_gyro_wander_rad_per_s2 = self.greatest_gyro_wander_rad_per_s2.max(wander);
                }
                self.latest_bias = Some((measured_s, bias));
            }
            Reading::Flow { blind_periods, .. } => {
                self.flow.push(FlowSight { measured_s, truth: observation.flow, blind_periods });
            }
            Reading::Wheels { .. } | Reading::Camera { .. } | Reading::Range { .. } => {}
        }
    }

    /// Another drive begins: sensors remember nothing of the one before.
    pub(super) fn restart(&mut self) {
        self.latest_bias = None;
    }
}
