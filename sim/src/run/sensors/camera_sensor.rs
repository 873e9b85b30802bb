//! A camera over time: when it exposes, how it moves meanwhile, how it stamps images and when it delivers them.

use std::{collections::VecDeque, sync::Arc};

use image::GrayImage;
use localizer::{
    Reading,
    bounds::{self, Assumption},
    reading::Camera,
};

use crate::{
    devices::{BoundCheck, Device, Observation},
    optics::{AutoExposure, Exposure},
    render::View,
    scene::{CameraTiming, Scene},
    truth::{
        Truth,
        randomness::{self, Repeated},
    },
    world::Drawn,
};

use super::{
    fitted_camera::FittedCamera,
    lamp_states::{LampState, LampStates},
};

/// A camera that takes an image every period.
pub struct CameraSensor {
    camera: FittedCamera,
    timing: CameraTiming,
    auto_exposure: AutoExposure,
    /// Longest exposure of the camera while the robot turns.
    turning_exposure_s: Option<f64>,
    /// Whether the robot turned at the earliest time at which the next exposure may begin, so that this exposure is limited to
    /// `turning_exposure_s`.
    turns: bool,
    lamp_states: LampStates,
    clock: Repeated,
    /// The declared bound on the errors of the camera's stamps, to be checked; `None` where the localizer does not rely on it.
    stamp_bound: Option<Assumption>,
    n_images: u32,
    /// True states of the robot at all physics steps that the exposure in progress may need.
    recent: VecDeque<Truth>,
}

/// An exposure that has just ended and whose image has not been drawn.
pub(super) struct Exposed {
    /// The picture (view) that is to be drawn.
    pub(super) view: View,
    /// State of the lamps in the middle of the exposure.
    pub(super) lamps: LampState,
    middle: Truth,
    ended_s: f64,
}

impl CameraSensor {
    /// The scene's camera of this name, under lamps that are switched as stated; `None` if the robot has no such camera.
    pub(super) fn new(name: Camera, scene: &Scene, seed: u64, drawn: &Drawn, lamp_states: LampStates) -> Option<Self> {
        let (keys, camera) = (scene.robot.camera(name)?, FittedCamera::new(name, scene, drawn, seed)?);
        Some(CameraSensor {
            timing: keys.timing(),
            auto_exposure: AutoExposure::new(&camera.sensor),
            turning_exposure_s: keys.turning_exposure_s(),
            turns: false,
            lamp_states,
            clock: Repeated::new(
                scene.robot.errors,
                randomness::stream(seed, &format!("{}_camera.clock", name.as_str())),
            ),
            stamp_bound: stamp_bound(name, scene),
            n_images: 0,
            recent: VecDeque::new(),
            camera,
        })
    }

    /// Observes one physics step, at which the gyroscope measures a turn or not. Returns an exposure when one has just ended.
    pub(super) fn expose(&mut self, truth: &Truth, turns: bool) -> Option<Exposed> {
        self.recent.push_back(*truth);
        // The first exposure may begin at the start of the run.
        let middle_s = self.timing.longest_s + f64::from(self.n_images) * self.timing.period_s;
        if truth.time_s <= middle_s - 0.5 * self.timing.longest_s {
            self.turns = turns;
        }
        let exposure = match self.turning_exposure_s.filter(|_| self.turns) {
            Some(longest_s) => self.auto_exposure.exposure_within(longest_s),
            None => self.auto_exposure.exposure(),
        };
        let lasts_s = exposure.exposure_s + self.camera.readout_s();
        let (from_s, to_s) = (middle_s - 0.5 * lasts_s, middle_s + 0.5 * lasts_s);
        while self.recent.len() > 2 && self.recent[1].time_s <= from_s {
            self.recent.pop_front();
        }
        if truth.time_s < to_s {
            return None;
        }
        let truths: Vec<Truth> = instants(from_s, to_s).map(|time_s| self.truth_at(time_s)).collect();
        let lamps = self.lamp_states.at(middle_s).clone();
        let view = self.camera.view(&truths, exposure, lamps.illuminance_at_floor_lux, self.n_images);
        Some(Exposed { view, lamps, middle: self.truth_at(middle_s), ended_s: to_s })
    }

    /// Stamps and sends the image of an exposure.
    pub(super) fn deliver(&mut self, exposed: &Exposed, image: GrayImage) -> Observation {
        let (exposure_s, gain_levels_per_electron) = (exposed.view.exposure_s, exposed.view.gain_levels_per_electron);
        self.auto_exposure.meter_exposed(&image, Exposure { exposure_s, gain_levels_per_electron });
        self.n_images += 1;
        let (timing, middle_s) = (&self.timing, exposed.middle.time_s);
        let measured_s = middle_s + self.clock.one_way(timing.stamp_tolerance_s);
        let late_s = timing.latency_s + self.clock.in_turn(timing.latency_tolerance_s);
        // An image cannot be delivered before its exposure has ended.
        let arrived_s = (middle_s + late_s).max(exposed.ended_s);
        let (camera, image) = (self.camera.name, Arc::new(image));
        let reading = Reading::Camera { measured_s, arrived_s, camera, exposure_s, image };
        let check = |bound| BoundCheck {
            bound,
            span_s: [middle_s, arrived_s],
            declared: timing.stamp_tolerance_s,
            true_value: (measured_s - middle_s).abs(),
        };
        let checks = self.stamp_bound.map(check).into_iter().collect();
        Observation { checks, ..Observation::new(reading, exposed.middle) }
    }

    /// True state of the robot at a time between two physics steps, interpolated linearly.
    fn truth_at(&self, time_s: f64) -> Truth {
        let after = self.recent.partition_point(|truth| truth.time_s < time_s).clamp(1, self.recent.len().max(2) - 1);
        match (self.recent.get(after - 1), self.recent.get(after)) {
            (Some(before), Some(after)) => before.interpolated(after, time_s),
            _ => self.recent.back().copied().unwrap_or_default(),
        }
    }
}

/// The declared bound on the errors of a camera's stamps, to be checked; `None` where the scene's localizer does not rely on it.
fn stamp_bound(name: Camera, scene: &Scene) -> Option<Assumption> {
    let robot = &scene.robot;
    let (bound, is_relied_on) = match name {
        Camera::Floor => (bounds::FLOOR_CAMERA_STAMP, robot.floor_camera.as_ref()?.is_relied_on(scene)),
        Camera::Forward => (bounds::FORWARD_CAMERA_STAMP, robot.forward_camera.as_ref()?.is_relied_on(scene)),
        Camera::Ceiling => (bounds::CEILING_CAMERA_STAMP, robot.ceiling_camera.as_ref()?.is_relied_on(scene)),
    };
    is_relied_on.then_some(bound)
}

/// Instants at equal steps through an exposure; the renderer decides by how many instants (sub-frames) of its own it draws the exposure.
fn instants(from_s: f64, to_s: f64) -> impl Iterator<Item = f64> {
    // The path of a wheeled robot during one exposure bends so little that five poses describe it.
    const N_POSES: usize = 5;
    (0..N_POSES).map(move |index| from_s + (to_s - from_s) * index as f64 / (N_POSES - 1) as f64)
}
