//! Truth to readings: each sensor with its own clock, errors and delay.

pub mod camera;
pub mod encoder;
mod floor_camera;
pub mod lens;
pub mod gyro;
pub mod proximity;
pub mod range_camera;
mod sight;

use localizer::{Reading, reading::LandmarkId};

use crate::{
    drawn::Drawn,
    render::{RenderError, Renderer},
    scene::Scene,
    truth::Truth,
    world::Bystander,
};

use encoder::Encoder;
pub use floor_camera::FloorCameraSensor;
use gyro::GyroSensor;
use proximity::{Fan, ProximitySensor};
pub use range_camera::RangeCameraSensor;

/// All sensors of the robot.
pub struct Sensors {
    encoder: Encoder,
    encoder_period_s: f64,
    n_encoder_readings: u64,
    floor_camera: Option<FloorCameraSensor>,
    gyro: Option<GyroSensor>,
    range_camera: Option<RangeCameraSensor>,
    proximity: Option<ProximitySensor>,
    /// Taken but not yet delivered.
    on_the_way: Vec<Observation>,
}

/// A reading, with the truth behind it for those who may know.
#[derive(Clone, Debug)]
pub struct Observation {
    /// What the localizer gets.
    pub reading: Reading,
    /// Truth at the true time of the measurement.
    pub truth: Truth,
    /// Noise in a reading of the gyroscope; 0 in others.
    pub gyro_noise_rad_per_s: f64,
    /// Codes given in a reading of the range camera, in its order, and whether each is its landmark's own; none in others.
    pub codes: Vec<(LandmarkId, bool)>,
}

impl Observation {
    /// A reading without anything else behind it than the truth.
    pub fn new(reading: Reading, truth: Truth) -> Self {
        Observation { reading, truth, gyro_noise_rad_per_s: 0.0, codes: Vec::new() }
    }
}

impl Sensors {
    /// Sensors of a run; a robot with a camera needs a renderer.
    pub fn new(scene: &Scene, seed: u64, drawn: &Drawn, renderer: Option<&mut Renderer>) -> Result<Self, RenderError> {
        let floor_camera = match renderer {
            Some(renderer) => FloorCameraSensor::new(scene, seed, drawn, renderer)?,
            None => None,
        };
        Ok(Sensors {
            encoder: Encoder::new(&scene.robot.encoders, seed),
            encoder_period_s: scene.robot.encoders.period_s,
            n_encoder_readings: 0,
            floor_camera,
            gyro: GyroSensor::new(scene, seed, drawn),
            range_camera: RangeCameraSensor::new(scene, seed, drawn),
            proximity: ProximitySensor::new(scene, seed),
            on_the_way: Vec::new(),
        })
    }

    /// Looks at the world at one physics step; answers with what arrives at the localizer by then, in order of arrival.
    pub fn observe(
        &mut self,
        truth: &Truth,
        people: &[Bystander],
        renderer: Option<&mut Renderer>,
    ) -> Result<Vec<Observation>, RenderError> {
        // Before the wheels, so that a turn up to the same instant is known when they tell how far they rolled.
        self.on_the_way.extend(self.gyro.as_mut().and_then(|gyro| gyro.observe(truth)));
        // Half a physics step of slack, so that a period in decimal seconds falls on its step.
        if truth.time_s + 0.0005 >= self.n_encoder_readings as f64 * self.encoder_period_s {
            self.n_encoder_readings += 1;
            let ticks = self.encoder.latch(truth);
            let reading = Reading::Wheels { measured_s: truth.time_s, arrived_s: truth.time_s, ticks };
            self.on_the_way.push(Observation::new(reading, *truth));
        }
        if let (Some(camera), Some(renderer)) = (&mut self.floor_camera, renderer) {
            self.on_the_way.extend(camera.observe(truth, renderer)?);
        }
        self.on_the_way.extend(self.range_camera.as_mut().and_then(|camera| camera.observe(truth, people)));
        let (mut arrived, waiting): (Vec<_>, Vec<_>) = std::mem::take(&mut self.on_the_way)
            .into_iter()
            .partition(|observation| observation.reading.arrived_s() <= truth.time_s);
        self.on_the_way = waiting;
        arrived.sort_by(|a, b| a.reading.arrived_s().total_cmp(&b.reading.arrived_s()));
        Ok(arrived)
    }

    /// What the driver may know besides the estimate: a reading of the proximity sensor when one is due.
    pub fn look_out(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Fan> {
        self.proximity.as_mut().and_then(|proximity| proximity.observe(truth, people))
    }
}
