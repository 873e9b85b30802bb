//! What was truly behind the readings of gyroscope, flow sensor and range camera, for the check of their bounds.

use localizer::Reading;

use crate::sensors::{Observation, flow::FlowTruth};

/// True values that the declared bounds of gyroscope and flow sensor are about.
#[derive(Clone, Debug, Default)]
pub struct MotionSensors {
    /// Each reading of the gyroscope.
    pub gyro: Vec<GyroSight>,
    /// Each reading of the range camera: when it was taken and when it arrived, and the greatest noise in one of its columns.
    pub range_noise_px: Vec<([f64; 2], f64)>,
    /// Each reading of the flow sensor.
    pub flow: Vec<FlowSight>,
    /// Rests of the encoders, from half a second after their last count on.
    pub rests: Vec<Rest>,
    /// The encoders' latest count, since when, and the heading half a second later.
    counted: Option<Counted>,
    /// Stamp and bias of the gyroscope's latest reading.
    latest_bias: Option<(f64, f64)>,
}

/// What was wrong with one reading of the gyroscope.
#[derive(Clone, Copy, Debug)]
pub struct GyroSight {
    /// When it was taken.
    pub time_s: f64,
    /// Size of its noise.
    pub noise_rad_per_s: f64,
    /// Size of its bias.
    pub bias_rad_per_s: f64,
    /// What errors up to it have added up to beyond their rate, over any span that ends with it.
    pub angle_rad: f64,
    /// Change of the bias over time since the reading before; 0 in the first.
    pub wander_rad_per_s2: f64,
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
                let bias_rad_per_s = observation.gyro_bias_rad_per_s;
                let before = self.latest_bias.replace((measured_s, bias_rad_per_s));
                let wander_rad_per_s2 = before
                    .filter(|(before_s, _)| measured_s > *before_s)
                    .map_or(0.0, |(before_s, before)| (bias_rad_per_s - before).abs() / (measured_s - before_s));
                self.gyro.push(GyroSight {
                    time_s: observation.truth.time_s + offset_s,
                    noise_rad_per_s: observation.gyro_noise_rad_per_s.abs(),
                    bias_rad_per_s: bias_rad_per_s.abs(),
                    angle_rad: observation.gyro_angle_rad,
                    wander_rad_per_s2,
                });
            }
            Reading::Flow { blind_periods, .. } => {
                self.flow.push(FlowSight { measured_s, truth: observation.flow, blind_periods });
            }
            Reading::Wheels { ticks, .. } => self.note_rest(measured_s, ticks, observation.truth.pose.heading_rad),
            Reading::Range { .. } => {
                let span_s =
                    [observation.truth.time_s, observation.reading.arrived_s()].map(|time_s| time_s + offset_s);
                self.range_noise_px.push((span_s, observation.range_noise_px));
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
