//! A camera as it is truly mounted: its pose while the robot moves, and the description of the picture that it takes.

use localizer::reading::Camera;
use nalgebra::Isometry3;
use rand::Rng;

use crate::{
    devices::camera::{DrawnCamera, world_from_camera},
    optics::{Exposure, Lens},
    render::{NoiseKey, Shows, View},
    scene::{Scene, SensorModel},
    truth::{Truth, randomness},
    world::Drawn,
};

/// One of the robot's cameras, with its own true mount, lens and noise.
#[derive(Clone, Debug)]
pub struct FittedCamera {
    /// Name of the camera.
    pub name: Camera,
    /// Image sensor that turns light into grey levels.
    pub sensor: SensorModel,
    mount: DrawnCamera,
    lens: Lens,
    noise_seed: u64,
}

impl FittedCamera {
    /// The scene's camera of this name with mount and lens as drawn at random; `None` if the robot has no such camera.
    pub fn new(name: Camera, scene: &Scene, drawn: &Drawn, seed: u64) -> Option<FittedCamera> {
        let (camera, mount) = (scene.robot.camera(name)?, drawn.devices.camera(name)?);
        let (sensor, lens) = (camera.sensor_model(), Lens::of(camera, &mount));
        Some(FittedCamera { name, sensor, mount, lens, noise_seed: noise_seed(seed, name) })
    }

    /// True pose of the camera in the world when the robot's true state is `truth`.
    pub fn world_from_camera(&self, truth: &Truth) -> Isometry3<f64> {
        world_from_camera(truth, &self.mount)
    }

    /// Time from the start of the first row's exposure to the start of the last row's.
    pub fn readout_s(&self) -> f64 {
        self.lens.readout_s()
    }

    /// Description of the camera's picture number `image`, taken while the robot goes through the states `truths` at equal steps of time.
    pub fn view(&self, truths: &[Truth], exposure: Exposure, illuminance_at_floor_lux: f64, image: u32) -> View {
        View {
            shows: if self.name == Camera::Floor { Shows::Floor } else { Shows::Room },
            lens: self.lens.clone(),
            sensor: self.sensor,
            world_from_camera: truths.iter().map(|truth| self.world_from_camera(truth)).collect(),
            exposure_s: exposure.exposure_s,
            gain_levels_per_electron: exposure.gain_levels_per_electron,
            illuminance_at_floor_lux,
            noise: NoiseKey { seed: self.noise_seed, image },
        }
    }
}

/// Seed of a camera's noise: the run's own seed for the floor camera, and a seed of its own for each other camera.
fn noise_seed(seed: u64, name: Camera) -> u64 {
    match name {
        Camera::Floor => seed,
        _ => randomness::stream(seed, &format!("{}_camera.noise", name.as_str())).next_u64(),
    }
}
