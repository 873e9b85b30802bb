//! A flat rectangle with its material.

use nalgebra::{Point3, Vector3};

/// A rectangle that is seen from the side to which `along × up` points.
#[derive(Clone, Debug)]
pub struct Panel {
    /// One corner, world.
    pub corner: Point3<f64>,
    /// To the next corner.
    pub along: Vector3<f64>,
    /// From the first corner to the last, at a right angle to `along`.
    pub up: Vector3<f64>,
    /// What it is made of.
    pub material: Material,
    /// What it is part of.
    pub part: Part,
    /// The room whose light bounces onto it.
    pub room: usize,
}

/// What a panel is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A floor.
    Floor,
    /// A wall.
    Wall,
    /// A ceiling.
    Ceiling,
    /// Furniture, doors, pictures, lamps.
    Thing,
}

/// What a surface does with light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// What is on it.
    pub texture: Texture,
    /// Mean albedo, visible and infrared.
    pub albedo: [f64; 2],
    /// Share of the light that is reflected like a mirror's, at right incidence.
    pub mirrored: f64,
    /// Standard deviation of the mirrored direction, about each axis.
    pub roughness_rad: f64,
    /// Another number, another cut of the same texture.
    pub seed: u32,
}

/// What is on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Texture {
    /// One albedo.
    Plain,
    /// Slightly uneven paint.
    Plaster,
    /// The scene's tiles.
    Tiles,
    /// Cloudy concrete.
    Concrete,
    /// Boards along world x.
    Wood,
    /// Loop pile.
    Carpet,
    /// A painting with its frame.
    Picture,
    /// Water: mirrors what is there.
    Wet,
    /// Black and white squares within a white margin as wide as one; the seed says how many.
    Chessboard,
}

impl Texture {
    /// How many there are.
    pub const COUNT: usize = 9;
}

impl Material {
    /// A matt material of one albedo.
    pub fn matt(albedo: f64) -> Material {
        Material {
            texture: Texture::Plain,
            albedo: [albedo, in_infrared(albedo)],
            mirrored: 0.0,
            roughness_rad: 0.1,
            seed: 0,
        }
    }

    /// The same with another texture.
    pub fn with(self, texture: Texture) -> Material {
        Material { texture, ..self }
    }

    /// The same under a varnish that mirrors a share of the light, blurred by its roughness.
    pub fn glossy(self, mirrored: f64, roughness_rad: f64) -> Material {
        Material { mirrored, roughness_rad, ..self }
    }
}

/// Albedo at 850 nm of something with this visible albedo: most dyes are transparent there, so that what is dark to the eye is not.
fn in_infrared(albedo: f64) -> f64 {
    0.25 + 0.65 * albedo
}

impl Panel {
    /// Unit vector towards the side from which it is seen.
    pub fn normal(&self) -> Vector3<f64> {
        self.along.cross(&self.up).normalize()
    }

    /// Extents along both sides.
    pub fn size_m(&self) -> [f64; 2] {
        [self.along.norm(), self.up.norm()]
    }

    /// Area.
    pub fn area_m2(&self) -> f64 {
        self.along.norm() * self.up.norm()
    }

    /// A place on it, `s` and `t` from 0 to 1.
    pub fn place(&self, s: f64, t: f64) -> Point3<f64> {
        self.corner + self.along * s + self.up * t
    }

    /// Its corners in order.
    pub fn corners(&self) -> [Point3<f64>; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[s, t]| self.place(s, t))
    }

    /// How far along a ray, in its own lengths, it is met from the side from which it is seen; `None` if it is not.
    pub fn seen_along(&self, from: Point3<f64>, ray: Vector3<f64>) -> Option<f64> {
        let normal = self.along.cross(&self.up);
        let (height, fall) = (normal.dot(&(from - self.corner)), -normal.dot(&ray));
        if height <= 0.0 || fall <= 0.0 {
            return None;
        }
        let hit = from + ray * (height / fall) - self.corner;
        self.spans(hit).then_some(height / fall)
    }

    /// Whether the straight way between two places goes through it, from either side.
    pub fn meets(&self, from: Point3<f64>, to: Point3<f64>) -> bool {
        let normal = self.along.cross(&self.up);
        let (before, behind) = (normal.dot(&(from - self.corner)), normal.dot(&(to - self.corner)));
        // What lies in its plane does not go through it.
        let slack = 1e-4 * normal.norm();
        if before.abs() < slack || behind.abs() < slack || (before > 0.0) == (behind > 0.0) {
            return false;
        }
        let hit = from + (to - from) * (before / (before - behind)) - self.corner;
        self.spans(hit)
    }

    /// Whether a place of its plane, from its first corner, is on it.
    fn spans(&self, from_corner: Vector3<f64>) -> bool {
        [self.along, self.up].iter().all(|side| (0.0..=side.norm_squared()).contains(&from_corner.dot(side)))
    }
}
