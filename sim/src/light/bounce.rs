//! Light that arrives by way of floor, walls and ceiling: radiosity of a room of three surfaces, each with one mean.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::Illuminance;
use crate::building::Enclosure;

/// What the rest of a room throws back on its floor, its walls and its ceiling, before dimming.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bounce {
    /// Onto what faces up, what stands upright, and what faces down.
    onto: [Illuminance; 3],
}

impl Bounce {
    /// From the mean direct illuminance and the mean albedo, visible and infrared, of floor, walls and ceiling.
    ///
    /// Exitances B solve B = ρ·(E + F·B), all bounces included. View factors are those of an empty rectangular room, which
    /// furniture changes little on the average.
    pub fn new(room: &Enclosure, direct: [Illuminance; 3], albedo: [[f64; 2]; 3]) -> Bounce {
        let factors = view_factors(room);
        let arriving = |value: fn(&Illuminance) -> f64, band: usize| -> Vector3<f64> {
            let reflectance = Matrix3::from_diagonal(&Vector3::from(albedo.map(|bands| bands[band])));
            let first = Vector3::from(direct.map(|light| value(&light)));
            let system = Matrix3::identity() - reflectance * factors;
            // Albedos are at most 1 and some light always leaves by the walls' own view of themselves, or B is infinite.
            let exitance = system.lu().solve(&(reflectance * first)).unwrap_or_default();
            factors * exitance
        };
        let lux = arriving(|light| light.lux, 0);
        let visible = arriving(|light| light.by_band[0], 0);
        let infrared = arriving(|light| light.by_band[1], 1);
        Bounce { onto: [0, 1, 2].map(|side| Illuminance { lux: lux[side], by_band: [visible[side], infrared[side]] }) }
    }

    /// What arrives on a surface that faces along `normal`.
    pub fn onto(&self, normal: Vector3<f64>) -> Illuminance {
        let upright = 1.0 - normal.z * normal.z;
        let flat = if normal.z > 0.0 { self.onto[0] } else { self.onto[2] };
        self.onto[1].times(upright).plus(1.0 - upright, flat)
    }
}

/// Row i: shares of what leaves floor, walls, ceiling that arrive at i as mean illuminance, that is F from i to the others.
fn view_factors(room: &Enclosure) -> Matrix3<f64> {
    let opposite = opposite_rectangles_view_factor(room.width_m / room.height_m, room.depth_m / room.height_m);
    let floor_m2 = room.width_m * room.depth_m;
    let walls_m2 = 2.0 * (room.width_m + room.depth_m) * room.height_m;
    let to_walls = 1.0 - opposite;
    let from_walls = to_walls * floor_m2 / walls_m2;
    Matrix3::new(0.0, to_walls, opposite, from_walls, 1.0 - 2.0 * from_walls, from_walls, opposite, to_walls, 0.0)
}

/// View factor between two equal rectangles straight above each other, by their sides over their distance.
///
/// Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11.
pub fn opposite_rectangles_view_factor(x: f64, y: f64) -> f64 {
    let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
    let logarithm = 0.5 * (x2 * y2 / (1.0 + x * x + y * y)).ln();
    let sides = x * y2.sqrt() * (x / y2.sqrt()).atan() + y * x2.sqrt() * (y / x2.sqrt()).atan();
    2.0 / (PI * x * y) * (logarithm + sides - x * x.atan() - y * y.atan())
}
