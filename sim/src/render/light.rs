//! Illuminance over the room's floor: uneven, with a declared mean and a declared ratio of brightest to darkest point.

use nalgebra::{Vector2, vector};

use crate::scene::{Light, Room};

/// Illuminance over the floor, `E(p) = mean · factor_at_origin · exp(gradient · p)`, with `p` in the world frame.
///
/// With the exponential, the ratio between two places depends on their difference in position alone. The ratio of the brightest to the
/// darkest place is then the declared one, and no place is dark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorLight {
    /// Gradient of ln E, per metre, world frame.
    pub gradient_per_m: Vector2<f64>,
    /// Illuminance at the world origin over the mean over the floor.
    pub factor_at_origin: f64,
}

impl FloorLight {
    /// Light whose mean over the room's floor is 1, and whose ratio of brightest to darkest place is that which the scene states.
    pub fn new(light: &Light, room: &Room) -> FloorLight {
        let (sin, cos) = light.unevenness_direction_deg.to_radians().sin_cos();
        // Length of the room when it is projected on the direction of the gradient.
        let length_m = room.width_m * cos.abs() + room.depth_m * sin.abs();
        let gradient_per_m = vector![cos, sin] * (light.unevenness_ratio.ln() / length_m);
        let mean =
            mean_of_exponential(gradient_per_m.x * room.width_m) * mean_of_exponential(gradient_per_m.y * room.depth_m);
        FloorLight { gradient_per_m, factor_at_origin: 1.0 / mean }
    }

    /// Illuminance over its mean, at a point of the floor in the world frame.
    pub fn factor_at(&self, place_m: Vector2<f64>) -> f64 {
        self.factor_at_origin * self.gradient_per_m.dot(&place_m).exp()
    }
}

/// The mean of an exponential, ∫₀¹ exp(a·s) ds = (eᵃ − 1)/a.
fn mean_of_exponential(a: f64) -> f64 {
    if a == 0.0 { 1.0 } else { a.exp_m1() / a }
}
