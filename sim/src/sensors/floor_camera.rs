//! The floor camera in time: when it exposes, what moves meanwhile, how it stamps and when it delivers.

use std::collections::VecDeque;

use localizer::{Reading, reading::Camera};
use rand_chacha::ChaCha8Rng;

use crate::{
    drawn::{Drawn, DrawnFloorCamera, draw_within},
    randomness,
    render::{NoiseKey, RenderError, RenderedWorld, Renderer, View},
    scene::{Distribution, Event, FloorCamera, Scene, SensorModel},
    truth::Truth,
};

use super::{
    Observation,
    camera::{AutoExposure, Intrinsics, floor_camera_intrinsics, world_from_floor_camera},
};

/// A floor camera that takes an image every period.
pub struct FloorCameraSensor {
    camera: FloorCamera,
    mount: DrawnFloorCamera,
    intrinsics: Intrinsics,
    sensor: SensorModel,
    auto_exposure: AutoExposure,
    world: RenderedWorld,
    lights: Vec<Switch>,
    errors: Distribution,
    clock: ChaCha8Rng,
    seed: u64,
    n_images: u32,
    /// Truth at every physics step that the exposure in progress may need.
    recent: VecDeque<Truth>,
}

/// From this time on the lamps give this illuminance.
#[derive(Clone, Copy, Debug)]
struct Switch {
    at_s: f64,
    illuminance_at_floor_lux: f64,
}

impl FloorCameraSensor {
    /// The scene's floor camera, or `None` if the robot has none.
    pub fn new(scene: &Scene, seed: u64, drawn: &Drawn, renderer: &mut Renderer) -> Result<Option<Self>, RenderError> {
        let (Some(camera), Some(mount)) = (scene.robot.floor_camera.clone(), drawn.floor_camera) else {
            return Ok(None);
        };
        let sensor = camera.sensor_model();
        let world = renderer.upload(scene, drawn)?;
        let at_first_lux = world.illuminance_at_floor_lux().unwrap_or(scene.light.illuminance_at_floor_lux);
        Ok(Some(FloorCameraSensor {
            intrinsics: floor_camera_intrinsics(&camera, &mount),
            auto_exposure: AutoExposure::new(&sensor),
            sensor,
            world,
            lights: switches(scene, at_first_lux),
            errors: scene.robot.errors,
            clock: randomness::stream(seed, "floor_camera.clock"),
            seed,
            n_images: 0,
            recent: VecDeque::new(),
            camera,
            mount,
        }))
    }

    /// Looks at one physics step; answers with an image when its exposure has just ended.
    pub fn observe(&mut self, truth: &Truth, renderer: &mut Renderer) -> Result<Option<Observation>, RenderError> {
        self.recent.push_back(*truth);
        // The first exposure may begin as soon as the run does.
        let middle_s = self.sensor.longest_exposure_s + f64::from(self.n_images) * self.camera.period_s;
        let exposure = self.auto_exposure.exposure();
        let (from_s, to_s) = (middle_s - 0.5 * exposure.exposure_s, middle_s + 0.5 * exposure.exposure_s);
        while self.recent.len() > 2 && self.recent[1].time_s <= from_s {
            self.recent.pop_front();
        }
        if truth.time_s < to_s {
            return Ok(None);
        }
        let view = View {
            intrinsics: self.intrinsics,
            sensor: self.sensor,
            world_from_camera: poses_during(from_s, to_s)
                .map(|time_s| world_from_floor_camera(&self.truth_at(time_s), &self.mount))
                .collect(),
            exposure_s: exposure.exposure_s,
            gain_levels_per_electron: exposure.gain_levels_per_electron,
            illuminance_at_floor_lux: self.illuminance_lux(middle_s),
            noise: NoiseKey { seed: self.seed, image: self.n_images },
            lens: None,
        };
        let middle = self.truth_at(middle_s);
        let Some(image) = renderer.draw(&self.world, &[view])?.pop() else { return Ok(None) };
        self.auto_exposure.meter(&image);
        self.n_images += 1;
        let measured_s = middle_s + draw_within(self.camera.stamp_tolerance_s, self.errors, &mut self.clock);
        let late_s = self.camera.latency_s + draw_within(self.camera.latency_tolerance_s, self.errors, &mut self.clock);
        // A delivery cannot come before the exposure has ended.
        let arrived_s = (middle_s + late_s).max(to_s);
        let reading =
            Reading::Camera { measured_s, arrived_s, camera: Camera::Floor, exposure_s: exposure.exposure_s, image };
        Ok(Some(Observation::new(reading, middle)))
    }

    /// Truth between physics steps, on the chord of the step.
    fn truth_at(&self, time_s: f64) -> Truth {
        let after = self.recent.partition_point(|truth| truth.time_s < time_s).clamp(1, self.recent.len().max(2) - 1);
        match (self.recent.get(after - 1), self.recent.get(after)) {
            (Some(before), Some(after)) => before.interpolated(after, time_s),
            _ => self.recent.back().copied().unwrap_or_default(),
        }
    }

    fn illuminance_lux(&self, time_s: f64) -> f64 {
        self.lights
            .iter()
            .rev()
            .find(|switch| switch.at_s <= time_s)
            .map_or(0.0, |switch| switch.illuminance_at_floor_lux)
    }
}

/// Instants at equal steps through an exposure; the renderer chooses how many sub-frames to make of them.
fn poses_during(from_s: f64, to_s: f64) -> impl Iterator<Item = f64> {
    // The path of a wheeled robot over one exposure bends so little that five poses tell it.
    const N_POSES: usize = 5;
    (0..N_POSES).map(move |index| from_s + (to_s - from_s) * index as f64 / (N_POSES - 1) as f64)
}

/// The lamps over time: as the scene states them, then as its events switch them.
fn switches(scene: &Scene, at_first_lux: f64) -> Vec<Switch> {
    let mut switches = vec![Switch { at_s: f64::NEG_INFINITY, illuminance_at_floor_lux: at_first_lux }];
    switches.extend(scene.events.iter().filter_map(|event| match event {
        Event::Light { at_s, illuminance_at_floor_lux } => {
            Some(Switch { at_s: *at_s, illuminance_at_floor_lux: *illuminance_at_floor_lux })
        }
        _ => None,
    }));
    switches.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    switches
}
