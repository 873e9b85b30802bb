//! The surfaces of a building cut into reflectors, of each of which the reflected light is one number.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use super::{
    occlusion::{Between, Occluders},
    source::polygon_irradiance,
};
use crate::place::building::{Building, Panel, Part};

/// Wanted side of a reflector.
const SIDE_M: f64 = 0.45;
/// Greatest number of reflectors that a building is cut into; more would take seconds. In a large building they are larger.
const MAX_REFLECTORS: usize = 1600;
/// Factor by which reflectors grow until there are few enough of them.
const GROWTH: f64 = 1.1;
/// Side of the greatest reflectors, which a building gets whatever their number.
const GREATEST_SIDE_M: f64 = 20.0;
/// Faces of the building that are narrower do not reflect light onto others, nor do they cover the faces behind them.
const NARROWEST_M: f64 = 0.05;
/// Number of points along each side of a reflector at which is looked whether it is covered, and what light falls on it.
const SAMPLES: usize = 4;
/// Distance in front of a face within which another face that looks the same way covers it, such as a picture its wall.
const COVER_M: [f64; 2] = [1e-4, 0.05];
/// Distance from its surface of a point from which is looked, so that the surface itself is not in the way.
pub(super) const BEFORE_M: f64 = 0.002;
/// Height over a reflector's plane below which a point counts as in it.
const FLAT_M: f64 = 1e-6;
/// Four of the sixteen points of a reflector, one in each row and each column.
const SPREAD: [usize; 4] = [1, 7, 8, 14];
/// Distances in multiples of a reflector's half diagonal beyond which its light arrives as if it all came from four of its points, and from its
/// middle.
const FAR: [f64; 2] = [4.0, 10.0];

/// A rectangle of a flat face of the building that reflects light.
#[derive(Clone, Debug)]
pub(super) struct Reflector {
    /// Index of the face among the building's panels.
    pub(super) panel: usize,
    /// Unit normal, towards the side that light falls on.
    pub(super) normal: Vector3<f64>,
    /// Albedo in the visible and in the infrared band.
    pub(super) albedo: [f64; 2],
    /// Points of the reflector that nothing covers, as shares of the sides of its face.
    pub(super) shares: Vec<[f64; 2]>,
    /// The same points in the world, a little in front of the reflector.
    pub(super) places: Vec<Point3<f64>>,
    /// The middle of these points, or if some of the reflector is covered, that which is nearest to it.
    pub(super) eye: Point3<f64>,
    pub(super) corners: [Point3<f64>; 4],
    middle: Point3<f64>,
    /// Area that nothing covers, and its share of the whole reflector.
    pub(super) open_m2: f64,
    open: f64,
    /// Squares of the distances beyond which the light comes as if from four points, and as if from the middle.
    far_m2: [f64; 2],
    /// Half of the sides of the rectangle around each of the points, and vectors from the middle to four points (Gauss's rule).
    half: [Vector3<f64>; 2],
    gauss: [Vector3<f64>; 4],
    reach_m: f64,
}

/// Cuts the faces of a building into reflectors.
pub(super) fn reflectors(building: &Building, occluders: &Occluders) -> Vec<Reflector> {
    let cover = Cover { building, occluders };
    let wide: Vec<usize> = (0..building.panels.len()).filter(|index| is_wide(&building.panels[*index])).collect();
    let counts = |side_m: f64| -> Vec<[usize; 2]> {
        let count = |index: &usize| {
            building.panels[*index].size_m().map(|length_m| (length_m / side_m).ceil().max(1.0) as usize)
        };
        wide.iter().map(count).collect()
    };
    let mut side_m = SIDE_M;
    while counts(side_m).iter().map(|[columns, rows]| columns * rows).sum::<usize>() > MAX_REFLECTORS
        && side_m < GREATEST_SIDE_M
    {
        side_m *= GROWTH;
    }
    let of_face = |(index, count): (&usize, [usize; 2])| {
        let cells = (0..count[1]).flat_map(move |j| (0..count[0]).map(move |i| [i, j]));
        cells.filter_map(|cell| cover.reflector(*index, cell, count)).collect::<Vec<_>>()
    };
    wide.iter().zip(counts(side_m)).flat_map(of_face).collect()
}

fn is_wide(panel: &Panel) -> bool {
    panel.size_m().iter().all(|side_m| *side_m >= NARROWEST_M)
}

/// What covers parts of a building's faces: furniture that stands on or before them, and coverings, pictures and door leaves on them.
struct Cover<'a> {
    building: &'a Building,
    occluders: &'a Occluders,
}

impl Cover<'_> {
    /// The reflector in one cell of a face that is cut into `count` cells along both sides; `None` if the whole of it is covered.
    fn reflector(&self, index: usize, cell: [usize; 2], count: [usize; 2]) -> Option<Reflector> {
        let panel = &self.building.panels[index];
        let share = |axis: usize, within: f64| (cell[axis] as f64 + within) / count[axis] as f64;
        let sample = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
        let samples = (0..SAMPLES).flat_map(|j| (0..SAMPLES).map(move |i| [share(0, sample(i)), share(1, sample(j))]));
        let shares: Vec<[f64; 2]> =
            samples.filter(|at| panel.has(*at) && self.is_open(index, panel.place(at[0], at[1]))).collect();
        let normal = panel.normal();
        let places: Vec<Point3<f64>> = shares.iter().map(|[s, t]| panel.place(*s, *t) + normal * BEFORE_M).collect();
        let sum = places.iter().fold(Vector3::zeros(), |sum, place| sum + place.coords);
        let middle = Point3::from(sum / places.len().max(1) as f64);
        let from_middle = |place: &&Point3<f64>| (*place - middle).norm_squared();
        let nearest = *places.iter().min_by(|one, other| from_middle(one).total_cmp(&from_middle(other)))?;
        let eye = if places.len() == SAMPLES * SAMPLES { middle } else { nearest };
        let size_m = panel.size_m();
        let sides_m = [0, 1].map(|axis| size_m[axis] / count[axis] as f64);
        let half = [panel.along / (2 * SAMPLES * count[0]) as f64, panel.up / (2 * SAMPLES * count[1]) as f64];
        let open = shares.len() as f64 / (SAMPLES * SAMPLES) as f64;
        let reach_m = 0.5 * sides_m[0].hypot(sides_m[1]);
        Some(Reflector {
            panel: index,
            normal,
            albedo: panel.material.albedo,
            eye,
            corners: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(|[s, t]| panel.place(share(0, s), share(1, t))),
            middle,
            open_m2: open * sides_m[0] * sides_m[1],
            open,
            far_m2: FAR.map(|far| (far * reach_m).powi(2)),
            half,
            gauss: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[s, t]| (half[0] * s + half[1] * t) * (SAMPLES as f64 / 3.0_f64.sqrt())),
            reach_m,
            shares,
            places,
        })
    }

    /// Whether nothing covers a point of a face.
    fn is_open(&self, index: usize, at: Point3<f64>) -> bool {
        let panel = &self.building.panels[index];
        let normal = panel.normal();
        let before = at + normal * BEFORE_M;
        let room = &self.building.rooms[panel.room];
        let looks_out = panel.part == Part::Thing && !room.contains(before) && room.contains(at - normal * BEFORE_M);
        // The ceilings of rooms that may overlap are drawn in layers, a little above each other.
        let is_above = panel.part != Part::Ceiling && before.z > room.corner.z + room.height_m;
        if looks_out || is_above || self.occluders.contain(before) {
            return false;
        }
        let covers = |(other, one): (usize, &Panel)| {
            let out = one.normal();
            let above_m = normal.dot(&(one.corner - at));
            other != index
                && (COVER_M[0]..COVER_M[1]).contains(&above_m)
                && out.dot(&normal) > 0.999
                && is_wide(one)
                && one.seen_along(at + normal * (2.0 * COVER_M[1]), -normal * (4.0 * COVER_M[1])).is_some()
        };
        !self.building.panels.iter().enumerate().any(covers)
    }
}

impl Reflector {
    /// Shares of the light falling at a point on surfaces with the given normals which this reflector gives if its exitance is 1 (view factors), as
    /// far as it is seen from there; `None` if nothing of it is. What is in `between` may hide it.
    ///
    /// Near reflectors count by Lambert's closed form, far ones by cos θ·cos θ'·A/(π·d²). What hides a reflector is asked for some of its points,
    /// which `salt` chooses.
    #[inline]
    pub(super) fn factors<const N: usize>(
        &self,
        at: Point3<f64>,
        normals: &[Vector3<f64>; N],
        between: &Between,
        salt: usize,
    ) -> Option<[f64; N]> {
        let leaving = self.normal.dot(&(at - self.corners[0]));
        if leaving <= FLAT_M {
            return None;
        }
        let way = self.middle - at;
        let square = way.norm_squared();
        let is_far = square > self.far_m2[0];
        let from_middle = leaving * self.open_m2 / PI;
        let (mut factors, mut sum) = ([0.0; N], 0.0);
        for (factor, normal) in factors.iter_mut().zip(normals) {
            let arriving = normal.dot(&way);
            if is_far && arriving > self.reach_m {
                *factor = from_middle
                    * if square > self.far_m2[1] || self.open < 1.0 {
                        arriving / (square * square)
                    } else {
                        let from =
                            |place: &Vector3<f64>| normal.dot(&(way + place)) / (way + place).norm_squared().powi(2);
                        0.25 * self.gauss.iter().map(from).sum::<f64>()
                    };
            } else if arriving > -self.reach_m {
                *factor = self.closed_form(at, *normal) / PI;
            }
            sum += *factor;
        }
        if sum <= 0.0 {
            return None;
        }
        if !between.is_empty() {
            let share = self.seen_share(at, normals, between, salt, is_far);
            factors.iter_mut().for_each(|factor| *factor *= share);
        }
        Some(factors)
    }

    /// Irradiance at a point of a surface from what of the reflector nothing covers, if its radiance is 1.
    fn closed_form(&self, at: Point3<f64>, normal: Vector3<f64>) -> f64 {
        if self.open == 1.0 {
            return polygon_irradiance(&self.corners.map(|corner| corner - at), normal);
        }
        let around = |place: &Point3<f64>| {
            let way = place - self.normal * BEFORE_M - at;
            let [u, v] = self.half;
            polygon_irradiance(&[way - u - v, way + u - v, way + u + v, way - u + v], normal)
        };
        self.places.iter().map(around).sum()
    }

    /// Share of the reflector that a point sees, as far as it lies before one of the surfaces with the given normals.
    fn seen_share(
        &self,
        at: Point3<f64>,
        normals: &[Vector3<f64>],
        between: &Between,
        salt: usize,
        is_far: bool,
    ) -> f64 {
        let count = self.places.len();
        if is_far {
            return if between.block(at, self.places[salt % count]) { 0.0 } else { 1.0 };
        }
        let (mut seen, mut asked) = (0.0, 0.0);
        for index in SPREAD {
            let place = self.places[(index * count / (SAMPLES * SAMPLES) + salt) % count];
            if normals.iter().any(|normal| normal.dot(&(place - at)) > 0.0) {
                asked += 1.0;
                seen += if between.block(at, place) { 0.0 } else { 1.0 };
            }
        }
        if asked > 0.0 { seen / asked } else { 1.0 }
    }

    /// Whether two reflectors are so near each other that light between them depends on where on them it leaves and arrives.
    pub(super) fn is_near(&self, other: &Reflector) -> bool {
        (other.middle - self.middle).norm_squared() <= self.far_m2[0].max(other.far_m2[0])
    }

    /// Four points of the reflector that nothing covers, spread over it.
    pub(super) fn spread(&self) -> [Point3<f64>; 4] {
        SPREAD.map(|index| self.places[index * self.places.len() / (SAMPLES * SAMPLES)])
    }
}
