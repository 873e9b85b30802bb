//! Synthetic images of tiled floors, made without the matched filters with which the localizer finds joints: the ground truth of the tests in this
//! folder.

use std::sync::OnceLock;

use image::GrayImage;

use super::FloorView;

/// Small deterministic random number generator (splitmix64, Steele et al. 2014); its statistics suffice for these tests.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Approximately normal random number: the sum of four uniform numbers, scaled to unit variance, which is quick to compute.
    pub(crate) fn normal(&mut self) -> f64 {
        let bits = self.next();
        let sum: i64 = (0..4).map(|part| (bits >> (16 * part) & 0xFFFF) as i64).sum();
        (sum - 131_070) as f64 / 37_837.0
    }
}

/// Pattern that is printed on the tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pattern {
    Plain,
    Speckle,
    Marble,
    /// Parallel stripes printed on the tiles, with their pitch in pixels and their contrast.
    Stripes {
        pitch_px: f64,
        contrast: f64,
    },
}

/// A strip on the floor that is no tile joint: a wire or a tape, at a given offset and angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    /// Sine and cosine of the angle of the normal of a wire or tape on the floor.
    pub(super) sin_cos: [f64; 2],
    pub(super) offset_px: f64,
    pub(super) width_px: f64,
    pub(super) albedo: f64,
    /// Amplitude of a sine-shaped bend of the wire or tape over the image.
    pub(super) bend_px: f64,
}

/// Everything that a synthetic image of a floor is made from. Coordinates are pixels from the image's centre, u right, v down.
#[derive(Clone, Debug)]
pub(super) struct Floor {
    pub(super) size_px: [usize; 2],
    pub(super) edge_px: [f64; 2],
    pub(super) joint_width_px: f64,
    /// Angle of the normal of the tile joints of family 0.
    pub(super) angle_rad: f64,
    /// Offset of one tile joint of each family from the image's centre.
    pub(super) phase_px: [f64; 2],
    pub(super) tile_albedo: f64,
    pub(super) joint_albedo: f64,
    /// Greatest departure of a tile's albedo from that of all tiles, relative to it.
    pub(super) tile_spread: f64,
    /// Relative amplitude of the brightness texture of the floor's surface.
    pub(super) texture: f64,
    pub(super) pattern: Pattern,
    /// Greatest share of a tile joint's contrast that is worn off in places, 0 to 1.
    pub(super) wear: f64,
    pub(super) strips: Vec<Strip>,
    /// A shadow through the image, with a soft edge: its relative darkness and the angle of the edge's normal.
    pub(super) shadow: Option<(f64, f64)>,
    /// Change of light over the image, along u and along v: logarithm of the change over half of the image's width.
    pub(super) gradient: [f64; 2],
    /// Photoelectrons of a pixel at mid grey (grey level 128).
    pub(super) electrons: f64,
    /// Grey level of a plain tile in mean light.
    pub(super) exposure_grey: f64,
    /// Motion of the image over the exposure at the image's centre, and rotation of the robot over the exposure.
    pub(super) blur_px: [f64; 2],
    pub(super) turn_rad: f64,
}

/// Pseudo-random number in `[−1, 1]` that belongs to a point of an integer lattice and a seed: always the same for the same point; read from a table
/// for speed.
fn lattice(u: i64, v: i64, seed: u64) -> f64 {
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let mut random = Random::new(77);
        (0..1 << 14).map(|_| random.between(-1.0, 1.0)).collect()
    });
    let mixed = (u as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (v as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ seed.wrapping_mul(0x1656_67B1_9E37_79F9);
    table[(mixed >> 50) as usize]
}

/// Smooth random field (value noise) with structures of size `grain_px`, in `[−1, 1]`.
fn value_noise(u: f64, v: f64, grain_px: f64, seed: u64) -> f64 {
    let (u, v) = (u / grain_px, v / grain_px);
    let (u0, v0) = (u.floor(), v.floor());
    let (fu, fv) = (u - u0, v - v0);
    let (fu, fv) = (fu * fu * (3.0 - 2.0 * fu), fv * fv * (3.0 - 2.0 * fv));
    let at = |du: i64, dv: i64| lattice(u0 as i64 + du, v0 as i64 + dv, seed);
    (at(0, 0) * (1.0 - fu) + at(1, 0) * fu) * (1.0 - fv) + (at(0, 1) * (1.0 - fu) + at(1, 1) * fu) * fv
}

/// Share of a pixel that a strip (tile joint, wire or tape) covers, for a square pixel aligned with the strip.
fn coverage(distance_px: f64, width_px: f64) -> f64 {
    (0.5 * width_px - distance_px.abs() + 0.5).clamp(0.0, 1.0)
}

impl Floor {
    /// Sine and cosine of the angle of the normal of tile joint family 0, computed once per image.
    fn axes(&self) -> [f64; 2] {
        [self.angle_rad.sin(), self.angle_rad.cos()]
    }

    /// For a point of the floor and one family of parallel tile joints: the distance along the family's normal from the nearest joint's centre, that
    /// joint's number, and the coordinate along the joint.
    fn nearest_joint(&self, [sin, cos]: [f64; 2], family: usize, u: f64, v: f64) -> (f64, i64, f64) {
        let grid = [u * cos + v * sin, v * cos - u * sin];
        let coordinate = grid[family] - self.phase_px[family];
        let number = (coordinate / self.edge_px[family]).round();
        (coordinate - number * self.edge_px[family], number as i64, grid[1 - family])
    }

    /// Albedo of the floor at a point.
    fn albedo(&self, axes: [f64; 2], u: f64, v: f64) -> f64 {
        let joints = [0, 1].map(|family| self.nearest_joint(axes, family, u, v));
        let tile = [0, 1].map(|family| joints[family].1 + i64::from(joints[family].0 > 0.0));
        let mut albedo = self.tile_albedo * (1.0 + self.tile_spread * lattice(tile[0], tile[1], 11));
        // Printed patterns are fixed to the tile, so that they turn with the grid.
        let [sin, cos] = axes;
        let (x, y) = (u * cos + v * sin, v * cos - u * sin);
        let seed = (tile[0] * 977 + tile[1] * 131) as u64;
        match self.pattern {
            Pattern::Plain => {}
            Pattern::Speckle => albedo *= 1.0 - 0.5 * f64::from(u8::from(value_noise(x, y, 5.0, seed) > 0.72)),
            Pattern::Marble => {
                let warp = 40.0 * value_noise(x, y, 90.0, seed);
                let vein = ((x * 0.8 + y * 0.6 + warp) / 70.0 * std::f64::consts::TAU).sin().abs();
                albedo *= 1.0 - 0.35 * (1.0 - vein).powi(6);
            }
            Pattern::Stripes { pitch_px, contrast } => {
                let phase = (x / pitch_px + 0.37 * tile[1] as f64).rem_euclid(1.0);
                albedo *= 1.0 - contrast * f64::from(u8::from(phase * pitch_px < 5.0));
            }
        }
        for (family, &(distance, number, along)) in joints.iter().enumerate() {
            let mut cover = coverage(distance, self.joint_width_px);
            if cover > 0.0 {
                if self.wear > 0.0 {
                    cover *= 1.0
                        - self.wear
                            * (0.5
                                + 0.5 * value_noise(along, 300.0 * number as f64 + 7000.0 * family as f64, 130.0, 9));
                }
                albedo += (self.joint_albedo - albedo) * cover;
            }
        }
        for strip in &self.strips {
            let [sin, cos] = strip.sin_cos;
            let along = v * cos - u * sin;
            let distance = u * cos + v * sin - strip.offset_px - strip.bend_px * (along / 180.0).sin();
            albedo += (strip.albedo - albedo) * coverage(distance, strip.width_px);
        }
        albedo
    }

    fn light(&self, u: f64, v: f64) -> f64 {
        let half = 0.5 * self.size_px[0] as f64;
        let mut light = (self.gradient[0] * u / half + self.gradient[1] * v / half).exp();
        if let Some((darkness, normal_rad)) = self.shadow {
            let distance = u * normal_rad.cos() + v * normal_rad.sin() - 40.0;
            light *= 1.0 - darkness / (1.0 + (-distance / 4.0).exp());
        }
        light
    }

    /// The image that the camera takes: area-sampled, averaged over the motion, with shot noise and read noise, in 8 bits.
    pub(super) fn picture(&self, random: &mut Random) -> GrayImage {
        let [width, height] = self.size_px;
        let centre = [0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0)];
        let motion = self.blur_px[0].hypot(self.blur_px[1]) + self.turn_rad.abs() * centre[0].hypot(centre[1]);
        // Joints, wires and tapes are area-sampled at each instant, so that instants one pixel of motion apart blend into each other.
        let samples = if motion < 0.1 { 1 } else { (2.0 + motion).min(24.0) as usize };
        let axes = self.axes();
        let grey_per_albedo = self.exposure_grey / self.tile_albedo;
        let electrons_per_grey = self.electrons / 128.0;
        GrayImage::from_fn(width as u32, height as u32, |column, row| {
            let (u, v) = (f64::from(column) - centre[0], f64::from(row) - centre[1]);
            let mut sum = 0.0;
            for sample in 0..samples {
                // While the image moves during the exposure, the floor point that a fixed pixel sees moves the opposite way.
                let time = (sample as f64 + 0.5) / samples as f64 - 0.5;
                let (sin, cos) = (-self.turn_rad * time).sin_cos();
                let (a, b) = (u - self.blur_px[0] * time, v - self.blur_px[1] * time);
                let (a, b) = (a * cos - b * sin, a * sin + b * cos);
                sum += self.albedo(axes, a, b);
            }
            // The floor's texture is not blurred by motion, so that the image has more of it than a real one.
            let texture = 1.0 + self.texture * (value_noise(u, v, 3.0, 5) + value_noise(u, v, 11.0, 6));
            let grey = sum / samples as f64 * texture * grey_per_albedo * self.light(u, v);
            let electrons = grey * electrons_per_grey;
            let noisy = electrons + random.normal() * (electrons + 4.0).sqrt();
            image::Luma([(noisy / electrons_per_grey).round().clamp(0.0, 255.0) as u8])
        })
    }

    /// What the localizer is given about the synthetic image of the floor: declared values, here equal to the true ones.
    pub(super) fn view(&self) -> FloorView {
        FloorView {
            pixels_per_m: self.edge_px[0] / 0.30,
            edge_px: self.edge_px,
            joint_width_px: self.joint_width_px,
            q_items: 0,
        }
    }

    fn centred(&self, point_px: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| point_px[axis] - 0.5 * (self.size_px[axis] as f64 - 1.0))
    }

    /// Number of the tile joint of a family that is nearest to a point of the image.
    pub(super) fn joint_number(&self, family: usize, point_px: [f64; 2]) -> i64 {
        let [u, v] = self.centred(point_px);
        self.nearest_joint(self.axes(), family, u, v).1
    }

    /// Distance of a point of the image from one tile joint, along the normal of the joint's family.
    pub(super) fn distance_to_joint_px(&self, family: usize, number: i64, point_px: [f64; 2]) -> f64 {
        let [u, v] = self.centred(point_px);
        let (sin, cos) = (self.angle_rad + family as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
        u * cos + v * sin - self.phase_px[family] - number as f64 * self.edge_px[family]
    }

    /// Length of the longest visible tile joint of a family, counting only what lies at least 15 px inside of the image.
    pub(super) fn longest_chord_px(&self, family: usize) -> f64 {
        let (sin, cos) = (self.angle_rad + family as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
        let half = self.size_px.map(|size| 0.5 * size as f64 - 15.0);
        let chord = |number: i64| {
            let offset = self.phase_px[family] + number as f64 * self.edge_px[family];
            let inside = (-400..=400).filter(|along| {
                let along = f64::from(*along);
                (offset * cos - along * sin).abs() < half[0] && (offset * sin + along * cos).abs() < half[1]
            });
            inside.count() as f64
        };
        (-5..=5).map(chord).fold(0.0, f64::max)
    }
}
