//! Rangefinders that detect obstacles in the robot's path. Their readings go to the driver of errands, never to the localizer.

use nalgebra::Point3;

use crate::{
    place::{Bystander, sight::Obstacles},
    scene::{Proximity, Scene},
    truth::{
        Truth,
        randomness::{Repeated, stream},
    },
};

/// One reading of the proximity sensor, a fan of beams.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    /// Time at which the reading was taken; it arrives without delay.
    pub measured_s: f64,
    /// The beams of the fan, from right to left.
    pub beams: Vec<Beam>,
}

/// What one beam of the proximity sensor met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Direction of the beam from robot forward, counter-clockwise.
    pub bearing_rad: f64,
    /// Distance of the nearest surface from the robot's origin; `None` when there is none within the range.
    pub distance_m: Option<f64>,
}

/// The proximity sensor on a robot: rangefinders whose beams form a fan.
pub struct ProximitySensor {
    keys: Proximity,
    obstacles: Obstacles,
    noise: Repeated,
    n_readings: u64,
}

impl ProximitySensor {
    /// The proximity sensor that a scene states, if it states one.
    pub(crate) fn new(scene: &Scene, seed: u64) -> Option<Self> {
        Some(ProximitySensor {
            keys: scene.robot.proximity.clone()?,
            obstacles: Obstacles::new(scene),
            noise: Repeated::new(scene.robot.errors, stream(seed, "proximity.noise")),
            n_readings: 0,
        })
    }

    /// Returns a reading when one is due.
    pub(crate) fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Fan> {
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < self.n_readings as f64 * self.keys.period_s {
            return None;
        }
        self.n_readings += 1;
        let eye = Point3::new(truth.pose.x_m, truth.pose.y_m, self.keys.height_m);
        let step_rad = self.keys.field_deg.to_radians() / (self.keys.beams - 1) as f64;
        let beams = (0..self.keys.beams).map(|index| {
            let bearing_rad = index as f64 * step_rad - 0.5 * self.keys.field_deg.to_radians();
            let direction_rad = truth.pose.heading_rad + bearing_rad;
            let nearest_m = self.obstacles.nearest_m(eye, direction_rad, self.keys.range_m, people);
            let error_m = self.noise.one_way(self.keys.tolerance_m);
            Beam { bearing_rad, distance_m: nearest_m.map(|nearest_m| nearest_m + error_m) }
        });
        Some(Fan { measured_s: truth.time_s, beams: beams.collect() })
    }
}
