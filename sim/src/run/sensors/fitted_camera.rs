//! A camera as it is truly mounted: its pose while the robot moves, and the description of the picture that it takes.

use localizer::reading::Camera;
use nalgebra::Isometry3;
use rand::Rng;

use crate::{
    devices::camera::{DrawnCamera, DrawnFloorCamera, world_from_camera, world_from_floor_camera},
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
    mount: Mount,
    lens: Lens,
    noise_seed: u64,
}

#[derive(Clone, Copy, Debug)]
enum Mount {
    Floor(DrawnFloorCamera),
    Other(DrawnCamera),
}

impl FittedCamera {
    /// The scene's camera of this name with mount and lens as drawn at random; `None` if the robot has no such camera.
    pub fn new(name: Camera, scene: &Scene, drawn: &Drawn, seed: u64) -> Option<FittedCamera> {
        let robot = &scene.robot;
        let (sensor, mount, lens) = match name {
            Camera::Floor => {
                let (camera, mount) = (robot.floor_camera.as_ref()?, drawn.devices.floor_camera?);
                (camera.sensor_model(), Mount::Floor(mount), Lens::floor(camera, &mount))
            }
            Camera::Forward => {
                let (camera, mount) = (robot.forward_camera.as_ref()?, drawn.devices.forward_camera?);
                (camera.sensor_model(), Mount::Other(mount), Lens::forward(camera, &mount))
            }
            Camera::Ceiling => {
                let (camera, mount) = (robot.ceiling_camera.as_ref()?, drawn.devices.ceiling_camera?);
                (camera.sensor_model(), Mount::Other(mount), Lens::ceiling(camera, &mount))
            }
        };
        Some(FittedCamera { name, sensor, mount, lens, noise_seed: noise_seed(seed, name) })
    }

    /// True pose of the camera in the world when the robot's true state is `truth`.
    pub fn world_from_camera(&self, truth: &Truth) -> Isometry3<f64> {
        match &self.mount {
            Mount::Floor(mount) => world_from_floor_camera(truth, mount),
            Mount::Other(mount) => world_from_camera(truth, mount),
        }
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
