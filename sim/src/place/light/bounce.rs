//! Light that floor, walls and ceiling of rooms reflect, computed by radiosity: each room has these three surfaces, and each surface one mean
//! brightness.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

use super::{Illuminance, source::polygon_irradiance};
use crate::place::building::{Enclosure, Opening};

/// Light that the surfaces of a room reflect onto its floor, its walls and its ceiling, before the factor on all light that yields the
/// illuminance which the scene states.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bounce {
    /// Reflected illuminance on surfaces that face up, on upright ones, and on those that face down.
    onto: [Illuminance; 3],
}

/// Direct light and albedos of a room, from which its reflected light is computed.
#[derive(Clone, Copy, Debug)]
pub struct RoomLight {
    /// Mean direct illuminance of a room's floor, walls and ceiling.
    pub direct: [Illuminance; 3],
    /// Mean albedo of a room's floor, walls and ceiling, each in the visible and in the infrared band.
    pub albedo: [[f64; 2]; 3],
}

/// Number of surfaces of a room in this model: floor, walls, ceiling.
const SURFACES: usize = 3;
const WALLS: usize = 1;
/// Least share of a room's walls that counts as solid even if all of them are openings, so that light is absorbed somewhere.
const LEAST_WALL: f64 = 0.05;

impl Bounce {
    /// Computes the reflected light of each room.
    ///
    /// Exitances B solve B = ρ·(E + F·B), so that all orders of reflection are included. View factors F are those of empty rectangular rooms,
    /// which furniture changes little on the average. A share of the walls is open to other rooms; the light that arrives there passes into
    /// those.
    pub fn in_rooms(rooms: &[Enclosure], light: &[RoomLight], openings: &[Opening]) -> Vec<Bounce> {
        let size = SURFACES * rooms.len();
        let mut factors = DMatrix::zeros(size, size);
        for (index, room) in rooms.iter().enumerate() {
            factors
                .fixed_view_mut::<SURFACES, SURFACES>(SURFACES * index, SURFACES * index)
                .copy_from(&view_factors(room));
        }
        // Share of the area of a room's walls that is open to another room.
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
            // The linear system for the exitances B can be solved, because albedos are at most 1 and some light is always absorbed by the walls;
            // otherwise B would be infinite.
            let exitance = system.lu().solve(&(reflectance * first)).unwrap_or_else(|| DVector::zeros(size));
            &factors * exitance
        };
        let lux = arriving(|light| light.lux, 0);
        let visible = arriving(|light| light.by_band[0], 0);
        let infrared = arriving(|light| light.by_band[1], 1);
        let onto = |surface: usize| Illuminance { lux: lux[surface], by_band: [visible[surface], infrared[surface]] };
        (0..rooms.len()).map(|room| Bounce { onto: [0, 1, 2].map(|side| onto(SURFACES * room + side)) }).collect()
    }

    /// Light reflected onto a surface at a point of a room: the room's mean for surfaces with that normal. For the share of the surface's view
    /// that openings to other rooms take up, it is the mean of the room behind instead, so that light changes smoothly from room to room.
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

    /// Reflected light on a surface of the room that faces along `normal`.
    pub fn onto(&self, normal: Vector3<f64>) -> Illuminance {
        let upright = 1.0 - normal.z * normal.z;
        let flat = if normal.z > 0.0 { self.onto[0] } else { self.onto[2] };
        self.onto[1].times(upright).plus(1.0 - upright, flat)
    }
}

/// View factors between floor, walls and ceiling of an empty room. Row i holds the factors from surface i to each surface, so that the row
/// times the exitances gives the mean illuminance at i.
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

/// View factor between two equal rectangles straight above each other; `x` and `y` are their sides over their distance.
///
/// Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11.
pub fn opposite_rectangles_view_factor(x: f64, y: f64) -> f64 {
    let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
    let logarithm = 0.5 * (x2 * y2 / (1.0 + x * x + y * y)).ln();
    let sides = x * y2.sqrt() * (x / y2.sqrt()).atan() + y * x2.sqrt() * (y / x2.sqrt()).atan();
    2.0 / (PI * x * y) * (logarithm + sides - x * x.atan() - y * y.atan())
}
