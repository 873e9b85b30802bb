//! Truth to readings: each sensor with its own clock, errors and delay.

mod camera_sensor;
pub mod delivery;
pub mod encoder;
mod fitted_camera;
pub mod flow;
pub mod gyro;
pub mod gyro_bias;
pub mod proximity;
pub mod range_camera;
pub(crate) mod sight;
pub mod still;

use localizer::{
    Reading,
    reading::{Camera, LandmarkId},
};

use crate::{
    building::UprightBody,
    drawn::Drawn,
    render::{RenderError, RenderedWorld, Renderer, View},
    scene::Scene,
    truth::Truth,
    world::Bystander,
};

pub use camera_sensor::CameraSensor;
use delivery::Delivery;
use encoder::Encoder;
pub use fitted_camera::FittedCamera;
use flow::{FlowSensor, FlowTruth};
use gyro::GyroSensor;
use proximity::{Fan, ProximitySensor};
pub use range_camera::RangeCameraSensor;

/// A camera that is told to exposes for a shorter time when the gyroscope tells of a faster turn: 100 ms of it then blur by 4 pixels.
const TURNING_RAD_PER_S: f64 = 0.1;

/// All sensors of the robot.
pub struct Sensors {
    encoder: Encoder,
    encoder_period_s: f64,
    n_encoder_readings: u64,
    cameras: Vec<CameraSensor>,
    gyro: Option<GyroSensor>,
    flow: Option<FlowSensor>,
    delivery: Delivery,
    /// Whether the gyroscope's latest reading tells of a turn that blurs.
    turns: bool,
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
    /// Bias in a reading of the gyroscope; 0 in others.
    pub gyro_bias_rad_per_s: f64,
    /// By how much the noise of the gyroscope's readings up to this one has added up over any span, beyond its rate times the span; 0 in
    /// others.
    pub gyro_angle_rad: f64,
    /// What was wrong with a reading of the flow sensor; nothing in others.
    pub flow: FlowTruth,
    /// Greatest noise in the columns of a reading of the range camera; 0 in others.
    pub range_noise_px: f64,
    /// Codes given in a reading of the range camera, in its order, and whether each is its landmark's own; none in others.
    pub codes: Vec<(LandmarkId, bool)>,
}

impl Observation {
    /// A reading without anything else behind it than the truth.
    pub fn new(reading: Reading, truth: Truth) -> Self {
        Observation {
            reading,
            truth,
            gyro_noise_rad_per_s: 0.0,
            gyro_bias_rad_per_s: 0.0,
            gyro_angle_rad: 0.0,
            flow: FlowTruth::default(),
            range_noise_px: 0.0,
            codes: Vec::new(),
        }
    }
}

/// The world as cameras look at it, on the device that draws it.
pub struct Stage<'a> {
    renderer: &'a mut Renderer,
    world: RenderedWorld,
}

impl<'a> Stage<'a> {
    /// Prepares what the scene's cameras look at: the floor alone for a floor camera alone.
    ///
    /// # Errors
    /// If the driver reported an error.
    pub fn new(scene: &Scene, drawn: &Drawn, renderer: &'a mut Renderer) -> Result<Self, RenderError> {
        let world = if scene.robot.cameras() == [Camera::Floor] {
            renderer.upload(scene, drawn)?
        } else {
            renderer.upload_room(scene, drawn)?
        };
        Ok(Stage { renderer, world })
    }

    /// Mean illuminance at the floor before any switch.
    fn illuminance_at_floor_lux(&self, scene: &Scene) -> f64 {
        self.world.illuminance_at_floor_lux().unwrap_or(scene.light.illuminance_at_floor_lux)
    }
}

impl Sensors {
    /// Sensors of a drive; those that take pictures need a stage to look at.
    pub fn new(scene: &Scene, seed: u64, drawn: &Drawn, stage: Option<&Stage<'_>>) -> Self {
        let at_first_lux = stage.map(|stage| stage.illuminance_at_floor_lux(scene));
        let camera = |name| CameraSensor::new(name, scene, seed, drawn, at_first_lux?);
        Sensors {
            encoder: Encoder::new(&scene.robot.encoders, scene.robot.errors, seed),
            encoder_period_s: scene.robot.encoders.period_s,
            n_encoder_readings: 0,
            cameras: Camera::ALL.into_iter().filter_map(camera).collect(),
            gyro: GyroSensor::new(scene, seed, drawn),
            flow: FlowSensor::new(scene, seed, drawn),
            delivery: Delivery::new(&scene.robot.delivery, drawn.base_clock_s, scene.robot.errors, seed),
            turns: false,
            range_camera: RangeCameraSensor::new(scene, seed, drawn),
            proximity: ProximitySensor::new(scene, seed),
            on_the_way: Vec::new(),
        }
    }

    /// Looks at the world at one physics step; answers with what arrives at the localizer by then, in order of arrival.
    pub fn observe(
        &mut self,
        truth: &Truth,
        people: &[Bystander],
        stage: Option<&mut Stage<'_>>,
    ) -> Result<Vec<Observation>, RenderError> {
        // Before the wheels, so that a turn up to the same instant is known when they tell how far they rolled.
        let turn = self.gyro.as_mut().and_then(|gyro| gyro.observe(truth));
        if let Some(Reading::Gyro { rate_rad_per_s, .. }) = turn.as_ref().map(|observation| &observation.reading) {
            self.turns = rate_rad_per_s.abs() > TURNING_RAD_PER_S;
        }
        let mut sent = Vec::from_iter(turn);
        sent.extend(self.flow.as_mut().and_then(|flow| flow.observe(truth)));
        // Half a physics step of slack, so that a period in decimal seconds falls on its step.
        if truth.time_s + 0.0005 >= self.n_encoder_readings as f64 * self.encoder_period_s {
            self.n_encoder_readings += 1;
            let ticks = self.encoder.latch(truth);
            let reading = Reading::Wheels { measured_s: truth.time_s, arrived_s: truth.time_s, ticks };
            sent.push(Observation::new(reading, *truth));
        }
        self.on_the_way.extend(sent.into_iter().flat_map(|observation| self.delivery.send(observation)));
        if let Some(stage) = stage {
            self.on_the_way.extend(take_pictures(&mut self.cameras, truth, self.turns, people, stage)?);
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

/// The pictures whose exposure ends at this step, all in one submit.
fn take_pictures(
    cameras: &mut [CameraSensor],
    truth: &Truth,
    turns: bool,
    people: &[Bystander],
    stage: &mut Stage<'_>,
) -> Result<Vec<Observation>, RenderError> {
    let due: Vec<_> = cameras.iter_mut().filter_map(|camera| Some((camera.expose(truth, turns)?, camera))).collect();
    if due.is_empty() {
        return Ok(Vec::new());
    }
    let bodies: Vec<UprightBody> = people.iter().map(|person| UprightBody::from(*person)).collect();
    stage.world.place_bodies(&bodies);
    let views: Vec<View> = due.iter().map(|(exposed, _)| exposed.view.clone()).collect();
    let images = stage.renderer.draw(&stage.world, &views)?;
    Ok(due.into_iter().zip(images).map(|((exposed, camera), image)| camera.deliver(&exposed, image)).collect())
}
