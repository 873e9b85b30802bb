//! What was truly behind the readings of gyroscope, flow sensor and range camera, for the check of their bounds.

use localizer::Reading;

use crate::sensors::{Observation, flow::FlowTruth};

/// True values that the declared bounds of gyroscope and flow sensor are about.
#[derive(Clone, Debug, Default)]
pub struct MotionSensors {
    /// Greatest noise in a reading of the gyroscope.
    pub greatest_gyro_noise_rad_per_s: f64,
    /// Greatest bias in one.
    pub greatest_gyro_bias_rad_per_s: f64,
    /// What the noise added up to beyond its rate, at most.
    pub greatest_gyro_angle_rad: f64,
    /// Greatest change of the bias over time, between two readings in a row.
    pub greatest_gyro_wander_rad_per_s2: f64,
    /// Greatest noise in a column of the range camera.
    pub greatest_range_noise_px: f64,
    /// Each reading of the flow sensor.
    pub flow: Vec<FlowSight>,
    /// Rests of the encoders, from half a second after their last count on.
    pub rests: Vec<Rest>,
    /// The encoders' latest count, since when, and the heading half a second later.
    counted: Option<Counted>,
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

/// A span in which the encoders counted nothing.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    /// Its begin and end.
    pub span_s: [f64; 2],
    /// Greatest turn of the body since its begin.
    pub turned_rad: f64,
}

#[derive(Clone, Copy, Debug)]
struct Counted {
    ticks: [i64; 2],
    since_s: f64,
    settled_heading_rad: Option<f64>,
}

/// After their last count, wheels may roll on for so long.
const SETTLED_S: f64 = 0.5;

impl MotionSensors {
    /// Notes what is behind a reading; those of other sensors have nothing to tell. Times run on by `offset_s` from station to station.
    pub(super) fn note(&mut self, observation: &Observation, offset_s: f64) {
        let measured_s = observation.reading.measured_s() + offset_s;
        match observation.reading {
            Reading::Gyro { .. } => {
                let (noise, bias) = (observation.gyro_noise_rad_per_s.abs(), observation.gyro_bias_rad_per_s);
                self.greatest_gyro_noise_rad_per_s = self.greatest_gyro_noise_rad_per_s.max(noise);
                self.greatest_gyro_bias_rad_per_s = self.greatest_gyro_bias_rad_per_s.max(bias.abs());
                self.greatest_gyro_angle_rad = self.greatest_gyro_angle_rad.max(observation.gyro_angle_rad);
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
            Reading::Wheels { ticks, .. } => self.note_rest(measured_s, ticks, observation.truth.pose.heading_rad),
            Reading::Range { .. } => {
                self.greatest_range_noise_px = self.greatest_range_noise_px.max(observation.range_noise_px);
            }
            Reading::Camera { .. } => {}
        }
    }

    fn note_rest(&mut self, measured_s: f64, ticks: [i64; 2], heading_rad: f64) {
        let anew = Counted { ticks, since_s: measured_s, settled_heading_rad: None };
        let counted = self.counted.take().filter(|counted| counted.ticks == ticks).unwrap_or(anew);
        self.counted = Some(counted);
        let begin_s = counted.since_s + SETTLED_S;
        if measured_s < begin_s {
            return;
        }
        let Some(settled_rad) = counted.settled_heading_rad else {
            self.counted = Some(Counted { settled_heading_rad: Some(heading_rad), ..counted });
            self.rests.push(Rest { span_s: [begin_s, measured_s], turned_rad: 0.0 });
            return;
        };
        if let Some(rest) = self.rests.last_mut() {
            rest.span_s[1] = measured_s;
            rest.turned_rad = rest.turned_rad.max((heading_rad - settled_rad).abs());
        }
    }

    /// Another drive begins: sensors remember nothing of the one before.
    pub(super) fn restart(&mut self) {
        self.counted = None;
        self.latest_bias = None;
    }
}
