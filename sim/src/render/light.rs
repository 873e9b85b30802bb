//! Illuminance over the room's floor: uneven, with a declared mean and a declared ratio.

use nalgebra::{Vector2, vector};

use crate::scene::{Light, Room};

/// `E(p) = mean · factor_at_origin · exp(gradient · p)` over the floor, `p` in the world frame.
///
/// The exponential makes the ratio between two places depend on their distance alone, so that
/// brightest over darkest is the declared ratio and no place is dark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorLight {
    /// Gradient of ln E, per metre, world frame.
    pub gradient_per_m: Vector2<f64>,
    /// E at the world origin over the mean over the floor.
    pub factor_at_origin: f64,
}

impl FloorLight {
    /// Light whose mean over the room's floor is 1 and whose brightest over darkest place is the scene's ratio.
    pub fn new(light: &Light, room: &Room) -> FloorLight {
        let (sin, cos) = light.unevenness_direction_deg.to_radians().sin_cos();
        // Projected on the direction of the gradient, the room is this long.
        let length_m = room.width_m * cos.abs() + room.depth_m * sin.abs();
        let gradient_per_m = vector![cos, sin] * (light.unevenness_ratio.ln() / length_m);
        let mean =
            mean_of_exponential(gradient_per_m.x * room.width_m) * mean_of_exponential(gradient_per_m.y * room.depth_m);
        FloorLight { gradient_per_m, factor_at_origin: 1.0 / mean }
    }

    /// E over its mean at a place in the world frame.
    pub fn factor_at(&self, place_m: Vector2<f64>) -> f64 {
        self.factor_at_origin * self.gradient_per_m.dot(&place_m).exp()
    }
}

/// ∫₀¹ exp(a·s) ds = (eᵃ − 1)/a.
fn mean_of_exponential(a: f64) -> f64 {
    if a == 0.0 { 1.0 } else { a.exp_m1() / a }
}
