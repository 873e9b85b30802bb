//! A flat rectangle of a building, with its material.

use std::sync::Arc;

use nalgebra::{Point3, Vector2, Vector3, vector};

use super::Polygon;

/// A flat rectangle of a building, or what of it an outline leaves. It is visible only from the side to which `along × up` points.
#[derive(Clone, Debug)]
pub struct Panel {
    /// First corner of the panel, a flat rectangle of the building, world frame.
    pub corner: Point3<f64>,
    /// Side of the panel (a flat rectangle of the building), as a vector from its first corner to its second.
    pub along: Vector3<f64>,
    /// Side of the panel (a flat rectangle of the building), as a vector from its first corner to its last, at a right angle to `along`.
    pub up: Vector3<f64>,
    /// Material of the panel.
    pub material: Material,
    /// Part of the building that the panel (a flat rectangle) belongs to.
    pub part: Part,
    /// Index of the room whose reflected light falls onto the panel, a flat rectangle of the building.
    pub room: usize,
    /// Outline of the floor or ceiling of a room that is no rectangle, within the panel (a flat rectangle around it). Its coordinates are distances
    /// from the panel's first corner along `along` and along `up`.
    pub(crate) outline: Option<Arc<Polygon>>,
}

/// The part of the building that a panel (a flat rectangle of it) belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The floor of a room.
    Floor,
    /// A wall of a room.
    Wall,
    /// The ceiling of a room.
    Ceiling,
    /// A thing in the building, such as furniture, a door, a picture or a lamp.
    Thing,
}

/// Optical properties of a surface: how it reflects light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Pattern on the surface.
    pub texture: Texture,
    /// Mean albedo of the surface, in the visible and in the infrared band.
    pub albedo: [f64; 2],
    /// Share of the light that the surface reflects like a mirror, at normal incidence.
    pub mirrored: f64,
    /// Standard deviation of the direction of mirrored rays about each axis, by which a reflection is blurred.
    pub roughness_rad: f64,
    /// Number that selects a variant of the texture: with another number the surface shows another part of the same pattern.
    pub seed: u32,
}

/// The pattern on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Texture {
    /// No pattern: the surface has one albedo everywhere.
    Plain,
    /// Plaster with slightly uneven paint.
    Plaster,
    /// The pattern of the floor tiles that the scene states.
    Tiles,
    /// Concrete with a cloudy pattern.
    Concrete,
    /// Wooden boards along world x.
    Wood,
    /// Carpet with a loop pile.
    Carpet,
    /// A painting with its frame.
    Picture,
    /// Water, which mirrors its surroundings.
    Wet,
    /// A chessboard pattern: black and white squares within a white margin as wide as one square. The `seed` of the material encodes how many
    /// columns and rows it has.
    Chessboard,
    /// Bricks of uneven brightness with windows, doors and stains.
    Facade,
    /// Asphalt with stones, spots, patches and cracks.
    Asphalt,
    /// Shelves with books.
    Books,
}

impl Texture {
    /// Number of textures.
    pub const COUNT: usize = 12;
}

impl Material {
    /// A matt, plain material of the given visible albedo.
    pub fn matt(albedo: f64) -> Material {
        Material {
            texture: Texture::Plain,
            albedo: [albedo, in_infrared(albedo)],
            mirrored: 0.0,
            roughness_rad: 0.1,
            seed: 0,
        }
    }

    /// This material with the given texture instead of its own.
    pub fn with(self, texture: Texture) -> Material {
        Material { texture, ..self }
    }

    /// This material under a varnish, which reflects the share `mirrored` of the light like a mirror that is blurred by the roughness.
    pub fn glossy(self, mirrored: f64, roughness_rad: f64) -> Material {
        Material { mirrored, roughness_rad, ..self }
    }
}

/// Albedo at 850 nm of a material with the given visible albedo. Most dyes are transparent at 850 nm, so that what is dark to the eye is
/// not dark there.
fn in_infrared(albedo: f64) -> f64 {
    0.25 + 0.65 * albedo
}

impl Panel {
    /// Unit normal of the panel (a flat rectangle of the building), towards the side from which it is visible.
    pub fn normal(&self) -> Vector3<f64> {
        self.along.cross(&self.up).normalize()
    }

    /// Lengths of the two sides of the panel, a flat rectangle.
    pub fn size_m(&self) -> [f64; 2] {
        [self.along.norm(), self.up.norm()]
    }

    /// Area of the panel, a flat rectangle, whether or not it has an outline within.
    pub fn area_m2(&self) -> f64 {
        self.along.norm() * self.up.norm()
    }

    /// A point on the panel (a flat rectangle), at the shares `s` and `t` of its sides, each from 0 to 1.
    pub fn place(&self, s: f64, t: f64) -> Point3<f64> {
        self.corner + self.along * s + self.up * t
    }

    /// The panel's corners in order.
    pub fn corners(&self) -> [Point3<f64>; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[s, t]| self.place(s, t))
    }

    /// Distance at which a ray meets the visible side of the panel (a flat rectangle), in multiples of the ray's length; `None` if the ray misses
    /// it.
    pub fn seen_along(&self, from: Point3<f64>, ray: Vector3<f64>) -> Option<f64> {
        let normal = self.along.cross(&self.up);
        let (height, fall) = (normal.dot(&(from - self.corner)), -normal.dot(&ray));
        if height <= 0.0 || fall <= 0.0 {
            return None;
        }
        let hit = from + ray * (height / fall) - self.corner;
        self.spans(hit).then_some(height / fall)
    }

    /// Whether the straight line between two points passes through the panel (a flat rectangle), from either side.
    pub fn meets(&self, from: Point3<f64>, to: Point3<f64>) -> bool {
        let normal = self.along.cross(&self.up);
        let (before, behind) = (normal.dot(&(from - self.corner)), normal.dot(&(to - self.corner)));
        // A line that ends in the plane of the panel (a flat rectangle) does not pass through it.
        let slack = 1e-4 * normal.norm();
        if before.abs() < slack || behind.abs() < slack || (before > 0.0) == (behind > 0.0) {
            return false;
        }
        let hit = from + (to - from) * (before / (before - behind)) - self.corner;
        self.spans(hit)
    }

    /// Whether a point in the plane of the panel (a flat rectangle) lies on the panel. The point is given as a vector from the panel's first
    /// corner.
    fn spans(&self, from_corner: Vector3<f64>) -> bool {
        let is_within =
            [self.along, self.up].iter().all(|side| (0.0..=side.norm_squared()).contains(&from_corner.dot(side)));
        is_within
            && self.outline.as_ref().is_none_or(|outline| {
                outline.contains(
                    vector![from_corner.dot(&self.along), from_corner.dot(&self.up)].component_div(&self.lengths()),
                )
            })
    }

    /// Whether a point of the panel (a flat rectangle), at shares of its sides, is within its outline, if it has one.
    pub(crate) fn has(&self, [s, t]: [f64; 2]) -> bool {
        self.outline.as_ref().is_none_or(|outline| outline.contains(vector![s, t].component_mul(&self.lengths())))
    }

    /// The point within the panel's outline, by about `inset_m` or more, that is nearest to a point of the panel, a flat rectangle. Both are given by
    /// the shares of the panel's sides; without an outline they are the same.
    pub(crate) fn nearest_within(&self, [s, t]: [f64; 2], inset_m: f64) -> [f64; 2] {
        self.outline.as_ref().map_or([s, t], |outline| {
            let lengths_m = self.lengths();
            let nearest = outline.nearest_within(vector![s, t].component_mul(&lengths_m), inset_m);
            nearest.component_div(&lengths_m).into()
        })
    }

    fn lengths(&self) -> Vector2<f64> {
        Vector2::from(self.size_m())
    }
}
