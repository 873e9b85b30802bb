//! Light that arrives by way of floor, walls and ceiling: radiosity of rooms of three surfaces, each with one mean.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

use super::{Illuminance, source::polygon_irradiance};
use crate::building::{Enclosure, Opening};

/// What the rest of a room throws back on its floor, its walls and its ceiling, before dimming.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bounce {
    /// Onto what faces up, what stands upright, and what faces down.
    onto: [Illuminance; 3],
}

/// What bounces in a room starts from.
#[derive(Clone, Copy, Debug)]
pub struct RoomLight {
    /// Mean direct illuminance of floor, walls and ceiling.
    pub direct: [Illuminance; 3],
    /// Their mean albedo, visible and infrared.
    pub albedo: [[f64; 2]; 3],
}

/// Surfaces of a room: floor, walls, ceiling.
const SURFACES: usize = 3;
const WALLS: usize = 1;
/// What is left of walls that are all holes, so that light has somewhere to end.
const LEAST_WALL: f64 = 0.05;

impl Bounce {
    /// What bounces in each room.
    ///
    /// Exitances B solve B = ρ·(E + F·B), all bounces included. View factors F are those of empty rectangular rooms, which
    /// furniture changes little on the average. Of walls a share is open to other rooms: what arrives there leaves into those.
    pub fn in_rooms(rooms: &[Enclosure], light: &[RoomLight], openings: &[Opening]) -> Vec<Bounce> {
        let size = SURFACES * rooms.len();
        let mut factors = DMatrix::zeros(size, size);
        for (index, room) in rooms.iter().enumerate() {
            factors
                .fixed_view_mut::<SURFACES, SURFACES>(SURFACES * index, SURFACES * index)
                .copy_from(&view_factors(room));
        }
        // Share of a room's walls that is open to another room.
        let mut open = DMatrix::zeros(size, size);
        for Opening { rooms: [one, other], area_m2, .. } in openings {
            for (here, there) in [(*one, *other), (*other, *one)] {
                open[(SURFACES * here + WALLS, SURFACES * there + WALLS)] = area_m2 / walls_m2(&rooms[here]);
            }
        }
        for mut row in open.row_iter_mut() {
            let most = 1.0 - LEAST_WALL;
            let sum: f64 = row.sum();
            row *= if sum > most { most / sum } else { 1.0 };
        }
        let solid = DVector::from_fn(size, |surface, _| 1.0 - open.row(surface).sum());
        let arriving = |value: fn(&Illuminance) -> f64, band: usize| -> DVector<f64> {
            let of_surface = |surface: usize| (&light[surface / SURFACES], surface % SURFACES);
            let reflectance = DMatrix::from_diagonal(&DVector::from_fn(size, |surface, _| {
                let (light, side) = of_surface(surface);
                solid[surface] * light.albedo[side][band]
            }));
            let first = DVector::from_fn(size, |surface, _| {
                let (light, side) = of_surface(surface);
                value(&light.direct[side])
            });
            let system = DMatrix::identity(size, size) - (&reflectance + &open) * &factors;
            // Albedos are at most 1 and some light always leaves by the walls' own view of themselves, or B is infinite.
            let exitance = system.lu().solve(&(reflectance * first)).unwrap_or_else(|| DVector::zeros(size));
            &factors * exitance
        };
        let lux = arriving(|light| light.lux, 0);
        let visible = arriving(|light| light.by_band[0], 0);
        let infrared = arriving(|light| light.by_band[1], 1);
        let onto = |surface: usize| Illuminance { lux: lux[surface], by_band: [visible[surface], infrared[surface]] };
        (0..rooms.len()).map(|room| Bounce { onto: [0, 1, 2].map(|side| onto(SURFACES * room + side)) }).collect()
    }

    /// What arrives at a place of a room: the mean onto such surfaces there, and through holes, by the share of what is seen that they take,
    /// that of the rooms behind them. So it passes evenly from room to room.
    pub fn at(
        bounces: &[Bounce],
        openings: &[Opening],
        room: usize,
        (at, normal): (Point3<f64>, Vector3<f64>),
    ) -> Illuminance {
        let Some(own) = bounces.get(room).map(|bounce| bounce.onto(normal)) else { return Illuminance::default() };
        let mut sum = own;
        for opening in openings {
            let behind = match opening.rooms {
                [one, other] if one == room => other,
                [one, other] if other == room => one,
                _ => continue,
            };
            let seen = |hole: &[Point3<f64>; 4]| polygon_irradiance(&hole.map(|corner| corner - at), normal).abs() / PI;
            let share = opening.holes.iter().map(seen).sum::<f64>().min(1.0);
            sum = sum.plus(share, bounces[behind].onto(normal)).plus(-share, own);
        }
        sum
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
    let to_walls = 1.0 - opposite;
    let from_walls = to_walls * floor_m2 / walls_m2(room);
    Matrix3::new(0.0, to_walls, opposite, from_walls, 1.0 - 2.0 * from_walls, from_walls, opposite, to_walls, 0.0)
}

fn walls_m2(room: &Enclosure) -> f64 {
    2.0 * (room.width_m + room.depth_m) * room.height_m
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
