//! A single lamp: its shape, its light, and the illuminance that it gives on a surface when nothing is in between.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3, vector};

use crate::{
    optics::Photons,
    place::building::Building,
    scene::{Lamp, LampKind, Scene, Spectrum},
};

/// A lamp of a scene, which does not move.
#[derive(Clone, Debug)]
pub struct Source {
    /// Shape of the lamp's luminous surface.
    pub shape: Shape,
    /// Luminous flux of the lamp.
    pub lumens: f64,
    /// Photons in the visible and in the infrared band for every lumen of the lamp.
    pub photons: Photons,
}

/// The luminous shape of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A matt rectangle that shines to the side to which `half_u × half_v` points.
    Rectangle {
        /// Middle of the rectangular lamp, world frame.
        centre: Point3<f64>,
        /// Vector from the middle of the rectangular lamp to the end of its first axis.
        half_u: Vector3<f64>,
        /// Vector from the middle of the rectangular lamp to the end of its second axis, at a right angle to the first.
        half_v: Vector3<f64>,
    },
    /// A point that shines equally in all directions.
    Point {
        /// Position of the point lamp, world frame.
        at: Point3<f64>,
        /// Radius of the disc as which the point lamp appears in an image.
        radius_m: f64,
    },
}

impl Shape {
    /// Luminous area of the lamp: of a rectangle its area, of a point the area of the disc as which it appears.
    pub fn area_m2(&self) -> f64 {
        match self {
            Shape::Rectangle { half_u, half_v, .. } => 4.0 * half_u.norm() * half_v.norm(),
            Shape::Point { radius_m, .. } => PI * radius_m * radius_m,
        }
    }

    /// A point of the lamp, at the coordinates `s` and `t` along its axes, each from −1 to 1.
    pub fn place(&self, s: f64, t: f64) -> Point3<f64> {
        match self {
            Shape::Rectangle { centre, half_u, half_v } => centre + half_u * s + half_v * t,
            Shape::Point { at, .. } => *at,
        }
    }

    /// A point of the lamp as it is seen from somewhere, at coordinates along its axes, each from −1 to 1. A bulb is seen as a disc, to whose edge
    /// points of the unit circle lead.
    pub(super) fn place_towards(&self, from: Point3<f64>, s: f64, t: f64) -> Point3<f64> {
        let Shape::Point { at, radius_m } = *self else { return self.place(s, t) };
        let way = (at - from).normalize();
        let across = if way.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() }.cross(&way).normalize();
        at + (across * s + way.cross(&across) * t) * radius_m
    }

    /// Distance from the lamp's middle to its farthest point, or for a bulb to the corners of the square around its disc.
    pub(super) fn reach_m(&self) -> f64 {
        match self {
            Shape::Rectangle { half_u, half_v, .. } => (half_u + half_v).norm(),
            Shape::Point { radius_m, .. } => 2.0_f64.sqrt() * radius_m,
        }
    }

    /// Direction in which a rectangular lamp shines; `None` for a point.
    pub fn normal(&self) -> Option<Vector3<f64>> {
        match self {
            Shape::Rectangle { half_u, half_v, .. } => Some(half_u.cross(half_v).normalize()),
            Shape::Point { .. } => None,
        }
    }
}

impl Source {
    /// Luminance of the lamp as an observer sees it: Φ/(π·A) for a matt rectangle, I/A for a bulb with I = Φ/4π.
    pub fn luminance(&self) -> f64 {
        let solid_angle = if let Shape::Rectangle { .. } = self.shape { PI } else { 4.0 * PI };
        self.lumens / (solid_angle * self.shape.area_m2())
    }

    /// Illuminance in lux that the lamp gives at a point of a surface, without shadows.
    ///
    /// For a rectangle it follows from the luminance by Lambert's formula, for a point it is I·cos θ/d².
    pub fn illuminance(&self, at: Point3<f64>, normal: Vector3<f64>) -> f64 {
        match self.shape {
            Shape::Rectangle { centre, half_u, half_v } => {
                if half_u.cross(&half_v).dot(&(at - centre)) <= 0.0 {
                    return 0.0;
                }
                let corners =
                    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[s, t]| self.shape.place(s, t) - at);
                self.luminance() * polygon_irradiance(&corners, normal)
            }
            Shape::Point { at: bulb, .. } => {
                let away = bulb - at;
                let distance_m = away.norm();
                let cosine = away.dot(&normal) / distance_m;
                self.lumens / (4.0 * PI) * cosine.max(0.0) / (distance_m * distance_m)
            }
        }
    }
}

/// Irradiance at a point of a surface from a convex polygon of unit radiance, its corners given as seen from that point: ½·|Σ θᵢ·Γᵢ·n|
/// (Lambert 1760). This is the area of the polygon's projection onto the unit sphere and from there onto the surface. Side i subtends the
/// angle θᵢ, and Γᵢ is the unit normal of the plane through the side and the point.
///
/// The part of the polygon below the surface is cut off.
pub fn polygon_irradiance(corners: &[Vector3<f64>], normal: Vector3<f64>) -> f64 {
    if corners.iter().all(|corner| normal.dot(corner) > 0.0) {
        return visible_irradiance(corners, normal);
    }
    visible_irradiance(&above_horizon(corners, normal), normal)
}

/// Irradiance from a convex polygon of unit radiance that lies above the surface as a whole.
fn visible_irradiance(corners: &[Vector3<f64>], normal: Vector3<f64>) -> f64 {
    let Some(mut from) = corners.last() else { return 0.0 };
    let mut sum = 0.0;
    for to in corners {
        let cross = from.cross(to);
        let length = cross.norm_squared().sqrt();
        // A side of the polygon that is in line with the point of the surface subtends no angle.
        if length > 0.0 {
            sum += length.atan2(from.dot(to)) * cross.dot(&normal) / length;
        }
        from = to;
    }
    0.5 * sum.abs()
}

/// The part of a convex polygon in the half space n·p > 0 (Sutherland and Hodgman).
fn above_horizon(corners: &[Vector3<f64>], normal: Vector3<f64>) -> Vec<Vector3<f64>> {
    let mut above = Vec::with_capacity(corners.len() + 1);
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (height, next) = (normal.dot(from), normal.dot(to));
        if height > 0.0 {
            above.push(*from);
        }
        if (height > 0.0) != (next > 0.0) {
            above.push(from + (to - from) * (height / (height - next)));
        }
    }
    above
}

/// The lamps of a scene; if it states none, a grid of matt ceiling panels.
pub(super) fn sources(scene: &Scene, building: &Building) -> Vec<Source> {
    if scene.lamps.is_empty() {
        return default_panels(scene);
    }
    scene.lamps.iter().map(|lamp| source(lamp, scene.building.ceiling_height_m, building)).collect()
}

/// The lamps of a scene that states none: a grid of ceiling panels of 0.6 m, about 2.5 m apart. Their light has the one wavelength for which the
/// illuminance in the scene's `[light]` is counted.
fn default_panels(scene: &Scene) -> Vec<Source> {
    let (width_m, depth_m) = (scene.room.width_m, scene.room.depth_m);
    // More than a dozen ceiling panels along a side of the room would take long to compute and look no different.
    let count = [width_m, depth_m].map(|side_m| (side_m / 2.5).round().clamp(1.0, 12.0) as usize);
    let height_m = scene.building.ceiling_height_m - 0.03;
    let place = |index: usize, count: usize, side_m: f64| (index as f64 + 0.5) / count as f64 * side_m;
    (0..count[0])
        .flat_map(|i| (0..count[1]).map(move |j| [i, j]))
        .map(|[i, j]| Source {
            shape: Shape::Rectangle {
                centre: Point3::new(place(i, count[0], width_m), place(j, count[1], depth_m), height_m),
                half_u: vector![0.3, 0.0, 0.0],
                half_v: vector![0.0, -0.3, 0.0],
            },
            lumens: 1000.0,
            photons: Photons::of(Spectrum::Monochrome),
        })
        .collect()
}

fn source(lamp: &Lamp, ceiling_m: f64, building: &Building) -> Source {
    let spectrum = lamp.spectrum.unwrap_or(match lamp.kind {
        LampKind::Window => Spectrum::Daylight,
        LampKind::Tube => Spectrum::Tube,
        LampKind::Panel | LampKind::Point => Spectrum::Led,
    });
    let mut source = Source { shape: shape(lamp, ceiling_m, building), lumens: 1.0, photons: Photons::of(spectrum) };
    source.lumens = match (lamp.lumens, lamp.illuminance_at_floor_lux) {
        (Some(lumens), _) => lumens,
        (None, Some(wanted_lux)) => {
            let given_lux = source.illuminance(measured_at(lamp, &source.shape), Vector3::z());
            if given_lux > 0.0 { wanted_lux / given_lux } else { 0.0 }
        }
        (None, None) => 1000.0,
    };
    source
}

fn shape(lamp: &Lamp, ceiling_m: f64, building: &Building) -> Shape {
    let (sin, cos) = lamp.heading_deg.to_radians().sin_cos();
    let (ahead, left) = (vector![cos, sin, 0.0], vector![-sin, cos, 0.0]);
    let under_ceiling_m = lamp.height_m.unwrap_or(ceiling_m - 0.03);
    let at = |height_m| Point3::new(lamp.x_m, lamp.y_m, height_m);
    let flat = |size_m: [f64; 2]| Shape::Rectangle {
        centre: at(under_ceiling_m),
        half_u: ahead * (size_m[0] / 2.0),
        // The sign is chosen so that the cross product of the lamp's first half axis with this second one points down, the direction in which the
        // lamp shines.
        half_v: -left * (size_m[1] / 2.0),
    };
    match lamp.kind {
        LampKind::Panel => flat(lamp.size_m.unwrap_or([0.6, 0.6])),
        LampKind::Tube => flat(lamp.size_m.unwrap_or([1.2, 0.08])),
        LampKind::Point => {
            let radius_m = lamp.size_m.map_or(0.05, |size_m| size_m[0] / 2.0);
            Shape::Point { at: at(lamp.height_m.unwrap_or(ceiling_m - 0.3)), radius_m }
        }
        LampKind::Window => {
            let [width_m, height_m] = lamp.size_m.unwrap_or([1.4, 1.2]);
            let on_wall = building.on_wall(at(lamp.height_m.unwrap_or(1.5)), ahead);
            Shape::Rectangle {
                // A window's luminous surface stands before the wall by a distance too small to be seen.
                centre: on_wall + ahead * 0.004,
                half_u: left * (width_m / 2.0),
                half_v: vector![0.0, 0.0, height_m / 2.0],
            }
        }
    }
}

/// The point on the floor at which a lamp's illuminance is stated: straight below the lamp, or 1 m before a window.
fn measured_at(lamp: &Lamp, shape: &Shape) -> Point3<f64> {
    let foot = shape.place(0.0, 0.0);
    let before = match (lamp.kind, shape.normal()) {
        (LampKind::Window, Some(normal)) => normal,
        _ => Vector3::zeros(),
    };
    Point3::new(foot.x + before.x, foot.y + before.y, 0.0)
}
