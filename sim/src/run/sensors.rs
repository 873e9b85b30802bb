//! From the true state to readings: each sensor has its own clock, errors and delay.

mod camera_sensor;
mod fitted_camera;
mod lamp_states;
pub mod still;

use localizer::{Reading, reading::Camera};

use crate::{
    devices::{FittedSensor, Observation, Sensor, delivery::Delivery, encoders::WheelSensor, scanner::Fan},
    place::{Bystander, building::UprightBody},
    render::{RenderError, RenderedWorld, Renderer, View},
    scene::{Scanner, Scene},
    truth::Truth,
    world::Drawn,
};

pub use camera_sensor::CameraSensor;
pub use fitted_camera::FittedCamera;
pub use lamp_states::{LampState, LampStates};

/// Turn rate above which a camera that has a shorter exposure for turns uses it: at this rate an exposure of 100 ms blurs by 4 pixels.
const TURNING_RAD_PER_S: f64 = 0.1;

/// All sensors of the robot.
pub struct Sensors {
    /// The sensors other than wheels and cameras. Readings of those that belong to the robot's base are sent before those of the wheels.
    fitted: Vec<FittedSensor>,
    wheels: WheelSensor,
    cameras: Vec<CameraSensor>,
    delivery: Delivery,
    /// Whether the latest reading of the gyroscope shows a turn that blurs images.
    turns: bool,
    scanner: Option<Scanner>,
    /// The latest scan that has arrived and that the driver has not asked for yet.
    scan: Option<Fan>,
    /// Readings that have been taken but not yet delivered.
    on_the_way: Vec<Observation>,
}

/// The simulated world that the cameras see, as prepared for drawing, and the renderer that draws it.
pub struct Stage<'a> {
    renderer: &'a mut Renderer,
    world: RenderedWorld,
    lamp_states: LampStates,
}

impl<'a> Stage<'a> {
    /// Prepares the world that the scene's cameras see: the floor alone where a floor camera is the only camera.
    ///
    /// # Errors
    /// If the graphics driver reports an error.
    pub fn new(scene: &Scene, drawn: &Drawn, renderer: &'a mut Renderer) -> Result<Self, RenderError> {
        let world = if scene.robot.cameras() == [Camera::Floor] {
            renderer.upload(scene, drawn)?
        } else {
            renderer.upload_room(scene, drawn)?
        };
        let lamp_states = LampStates::new(scene, &world);
        Ok(Stage { renderer, world, lamp_states })
    }
}

impl Sensors {
    /// The sensors of a drive. Cameras are included only if there is a stage, which is the prepared world that they take pictures of with its
    /// renderer.
    pub fn new(scene: &Scene, seed: u64, drawn: &Drawn, stage: Option<&Stage<'_>>) -> Self {
        let camera = |name| CameraSensor::new(name, scene, seed, drawn, stage?.lamp_states.clone());
        Sensors {
            fitted: drawn.devices.sensors(scene, seed),
            wheels: WheelSensor::new(scene, seed),
            cameras: Camera::ALL.into_iter().filter_map(camera).collect(),
            delivery: Delivery::new(&scene.robot.delivery, drawn.base.clock_s, scene.robot.errors, seed),
            turns: false,
            scanner: scene.robot.scanner.clone(),
            scan: None,
            on_the_way: Vec::new(),
        }
    }

    /// Observes the world at one physics step. Returns the readings that arrive at the localizer by then, in order of arrival.
    pub fn observe(
        &mut self,
        truth: &Truth,
        people: &[Bystander],
        stage: Option<&mut Stage<'_>>,
    ) -> Result<Vec<Observation>, RenderError> {
        let (mut sent, mut measured) = (Vec::new(), Vec::new());
        for sensor in &mut self.fitted {
            let to = if sensor.is_on_base { &mut sent } else { &mut measured };
            to.extend(sensor.observe(truth, people));
        }
        // The gyroscope's readings are sent before those of the wheels, so that the localizer knows the turn up to an instant when it is given
        // the distance rolled up to that instant.
        for observation in &sent {
            if let Reading::Gyro { rate_rad_per_s, .. } = &observation.reading {
                self.turns = rate_rad_per_s.abs() > TURNING_RAD_PER_S;
            }
        }
        sent.extend(self.wheels.observe(truth, people));
        self.on_the_way.extend(sent.into_iter().flat_map(|observation| self.delivery.send(observation)));
        if let Some(stage) = stage {
            self.on_the_way.extend(take_pictures(&mut self.cameras, truth, self.turns, people, stage)?);
        }
        self.on_the_way.extend(measured);
        let (mut arrived, waiting): (Vec<_>, Vec<_>) = std::mem::take(&mut self.on_the_way)
            .into_iter()
            .partition(|observation| observation.reading.arrived_s() <= truth.time_s);
        self.on_the_way = waiting;
        arrived.sort_by(|a, b| a.reading.arrived_s().total_cmp(&b.reading.arrived_s()));
        if let Some(scanner) = &self.scanner {
            self.scan = arrived.iter().rev().find_map(|one| Fan::of(&one.reading, scanner)).or(self.scan.take());
        }
        Ok(arrived)
    }

    /// The latest scan of the range scanner, if one has arrived since the last call. Besides the estimate, it is all that the driver may know.
    pub fn look_out(&mut self) -> Option<Fan> {
        self.scan.take()
    }
}

/// Takes the pictures whose exposure ends at this step, all in one submission to the renderer unless the lamps were switched between two exposures.
fn take_pictures(
    cameras: &mut [CameraSensor],
    truth: &Truth,
    turns: bool,
    people: &[Bystander],
    stage: &mut Stage<'_>,
) -> Result<Vec<Observation>, RenderError> {
    let mut due: Vec<_> =
        cameras.iter_mut().filter_map(|camera| Some((camera.expose(truth, turns)?, camera))).collect();
    if due.is_empty() {
        return Ok(Vec::new());
    }
    let bodies: Vec<UprightBody> = people.iter().map(|person| UprightBody::from(*person)).collect();
    let mut taken = Vec::with_capacity(due.len());
    for together in due.chunk_by_mut(|(one, _), (next, _)| one.lamps == next.lamps) {
        if let Some((exposed, _)) = together.first() {
            stage.world.switch_lamps(&exposed.lamps.shares);
        }
        stage.world.place_bodies(&bodies);
        let views: Vec<View> = together.iter().map(|(exposed, _)| exposed.view.clone()).collect();
        let images = stage.renderer.draw(&stage.world, &views)?;
        let delivered =
            together.iter_mut().zip(images).map(|((exposed, camera), image)| camera.deliver(exposed, image));
        taken.extend(delivered);
    }
    Ok(taken)
}
