//! Synthetic images of a plane with a known texture, seen by a camera with a known pose: the ground truth of the tests in this folder. Textures and
//! projection are formulas, and each pixel is the mean of 4 × 4 points, so that the true position of everything is known exactly.

use image::GrayImage;

use crate::vision::synthetic::Random;

/// Number of points along each side of a pixel at which a texture is taken.
const OVERSAMPLING: usize = 4;

/// What is on the plane. Coordinates are pixels of a camera that sees the plane straight and at scale 1, counted from the plane's middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A poster of overlapping rectangles in three sizes and turns.
    Poster,
    /// Noise whose amplitude is inversely proportional to its frequency, like in pictures of nature.
    Natural,
    /// A wallpaper that repeats exactly.
    Wallpaper,
    /// Shelves with books.
    Shelves,
    /// Thin strokes in all directions, like writing.
    Strokes,
}

pub(super) const KINDS: [Kind; 5] = [Kind::Poster, Kind::Natural, Kind::Wallpaper, Kind::Shelves, Kind::Strokes];

/// A texture of a kind, drawn by a seed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texture {
    pub(super) kind: Kind,
    pub(super) seed: u64,
}

/// Pseudo-random number in [0, 1) that belongs to a cell of a lattice and a seed (the finaliser of splitmix64).
fn hashed(column: i64, row: i64, seed: u64) -> f64 {
    let mut z = (column as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (row as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ seed.wrapping_mul(0x1656_67B1_9E37_79F9);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Smooth random field with structures of size `grain`, in [0, 1].
fn field(x: f64, y: f64, grain: f64, seed: u64) -> f64 {
    let (x, y) = (x / grain, y / grain);
    let (column, row) = (x.floor(), y.floor());
    let fade = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (u, v) = (fade(x - column), fade(y - row));
    let at = |du: i64, dv: i64| hashed(column as i64 + du, row as i64 + dv, seed);
    (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v) + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v
}

/// A random rectangle in each cell of a lattice that is turned by an angle: its shade, where there is one.
fn rectangle(x: f64, y: f64, pitch: f64, turn_rad: f64, seed: u64) -> Option<f64> {
    let (sin, cos) = turn_rad.sin_cos();
    let (x, y) = ((x * cos + y * sin) / pitch, (y * cos - x * sin) / pitch);
    let (column, row) = (x.floor() as i64, y.floor() as i64);
    let draw = |which: u64| hashed(column, row, seed + which);
    let (x, y) = (x - x.floor(), y - y.floor());
    let is_in = |at: f64, low: f64, high: f64| at > 0.4 * low && at < 1.0 - 0.4 * high;
    let is_inside = is_in(x, draw(1), draw(2)) && is_in(y, draw(3), draw(4)) && draw(5) < 0.75;
    is_inside.then(|| draw(6))
}

impl Texture {
    /// Share of the light that a point of the plane reflects, in [0, 1].
    fn albedo(self, x: f64, y: f64) -> f64 {
        let seed = self.seed.wrapping_mul(1000);
        match self.kind {
            Kind::Poster => {
                let shade = rectangle(x, y, 13.0, -0.6, seed + 300)
                    .filter(|_| field(x, y, 60.0, seed + 7) > 0.5)
                    .or_else(|| rectangle(x, y, 29.0, 0.35, seed + 200))
                    .or_else(|| rectangle(x, y, 53.0, 0.05, seed + 100));
                0.08 + 0.84 * shade.unwrap_or(0.5)
            }
            Kind::Natural => {
                let octaves = [64.0, 32.0, 16.0, 8.0, 4.0];
                let sum: f64 = octaves
                    .iter()
                    .enumerate()
                    .map(|(idx, grain)| (field(x, y, *grain, seed + idx as u64) - 0.5) * 0.5f64.powi(idx as i32).sqrt())
                    .sum();
                (0.5 + 0.55 * sum).clamp(0.02, 0.98)
            }
            Kind::Wallpaper => {
                let pitch = [34.0, 26.0];
                let (u, v) = (x.rem_euclid(pitch[0]), y.rem_euclid(pitch[1]));
                let motif = field(u, v, 7.0, seed + 1);
                let inside = u > 3.0 && u < 30.0 && v > 3.0 && v < 22.0;
                if inside && motif > 0.5 { 0.75 } else { 0.3 }
            }
            Kind::Shelves => {
                let height = 70.0;
                let shelf = (y / height).floor();
                let above = y - shelf * height;
                if above < 6.0 {
                    return 0.7;
                }
                let number = (x / 11.0).floor();
                let edge = |number: f64| 11.0 * number + 6.0 * hashed(number as i64, shelf as i64, seed + 1);
                let book = if x < edge(number) { number - 1.0 } else { number };
                let draw = |which: u64| hashed(book as i64, shelf as i64, seed + which);
                let top = 12.0 + 26.0 * draw(2);
                let label = top + 6.0 + 20.0 * draw(3);
                match above {
                    above if above < top => 0.05,
                    above if above > label && above < label + 8.0 => 0.15 + 0.75 * draw(4),
                    _ => 0.12 + 0.8 * draw(5),
                }
            }
            Kind::Strokes => {
                let pitch = 15.0;
                let (column, row) = ((x / pitch).floor() as i64, (y / pitch).floor() as i64);
                let is_near = (-1..=1).flat_map(|du| (-1..=1).map(move |dv| [column + du, row + dv])).any(|[c, r]| {
                    let draw = |which: u64| hashed(c, r, seed + which);
                    let (cx, cy) = (pitch * (c as f64 + draw(1)), pitch * (r as f64 + draw(2)));
                    let (sin, cos) = (3.2 * draw(3)).sin_cos();
                    let (along, across) = ((x - cx) * cos + (y - cy) * sin, (y - cy) * cos - (x - cx) * sin);
                    along.abs() < 3.0 + 6.0 * draw(4) && across.abs() < 0.9 + draw(5)
                });
                if is_near { 0.1 } else { 0.8 }
            }
        }
    }
}

/// A camera that sees the plane, with the true properties of its image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    pub(super) size_px: [usize; 2],
    pub(super) focal_px: f64,
    /// Size of the plane's middle in the image.
    pub(super) scale: f64,
    pub(super) turn_rad: f64,
    /// Angle between the plane's normal and the optical axis, and direction in the image towards which the plane comes nearer.
    pub(super) slant_rad: f64,
    pub(super) towards_rad: f64,
    /// Where the plane's middle is in the image, from the image's middle.
    pub(super) shift_px: [f64; 2],
    /// Standard deviation of the blur by the lens.
    pub(super) blur_px: f64,
    /// Motion of the image over the exposure.
    pub(super) motion_px: [f64; 2],
    /// Grey level of a white plane in the middle of the image, and grey level of black.
    pub(super) white_grey: f64,
    pub(super) black_grey: f64,
    /// Whether the image darkens outwards with the fourth power of the cosine.
    pub(super) darkens: bool,
    pub(super) dark_noise_grey: f64,
    pub(super) electrons_per_grey: f64,
}

impl Eye {
    /// A camera straight before the plane, with a sharp image.
    pub(super) fn straight(size_px: [usize; 2]) -> Eye {
        Eye {
            size_px,
            focal_px: 500.0,
            scale: 1.0,
            turn_rad: 0.0,
            slant_rad: 0.0,
            towards_rad: 0.0,
            shift_px: [0.0; 2],
            blur_px: 0.6,
            motion_px: [0.0; 2],
            white_grey: 230.0,
            black_grey: 4.0,
            darkens: true,
            dark_noise_grey: 1.0,
            electrons_per_grey: 20.0,
        }
    }

    fn middle_px(&self) -> [f64; 2] {
        self.size_px.map(|size| 0.5 * (size as f64 - 1.0))
    }

    /// Image `[u, v]` of a point of the plane.
    pub(super) fn project(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x, y] = turned([x, y], -self.towards_rad);
        let (sin, cos) = self.slant_rad.sin_cos();
        let depth = 1.0 - x * sin / self.focal_px;
        let seen = turned([self.scale * x * cos / depth, self.scale * y / depth], self.towards_rad);
        let seen = turned(seen, self.turn_rad);
        [0, 1].map(|axis| seen[axis] + self.middle_px()[axis] + self.shift_px[axis])
    }

    /// Point of the plane that the image shows at a position.
    pub(super) fn on_plane(&self, at_px: [f64; 2]) -> [f64; 2] {
        let from_middle = [0, 1].map(|axis| at_px[axis] - self.middle_px()[axis] - self.shift_px[axis]);
        let [p, q] = turned(turned(from_middle, -self.turn_rad), -self.towards_rad);
        let (sin, cos) = self.slant_rad.sin_cos();
        let x = p / (self.scale * cos + p * sin / self.focal_px);
        let depth = 1.0 - x * sin / self.focal_px;
        turned([x, q * depth / self.scale], self.towards_rad)
    }

    /// The image that the camera takes.
    pub(super) fn picture(&self, texture: Texture, random: &mut Random) -> GrayImage {
        let [width, height] = self.size_px.map(|size| size * OVERSAMPLING);
        let place = |at: usize| (at as f64 + 0.5) / OVERSAMPLING as f64 - 0.5;
        let points = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
        let mut sharp: Vec<f32> = points
            .map(|[u, v]| {
                let [x, y] = self.on_plane([place(u), place(v)]);
                texture.albedo(x, y) as f32
            })
            .collect();
        let sigma = self.blur_px * OVERSAMPLING as f64;
        if sigma > 0.1 {
            let reach = (4.0 * sigma).ceil() as i64;
            let taps: Vec<([i64; 2], f32)> =
                (-reach..=reach).map(|at| ([at, 0], (-0.5 * (at as f64 / sigma).powi(2)).exp() as f32)).collect();
            sharp = blurred(&sharp, [width, height], &taps);
            let taps: Vec<_> = taps.into_iter().map(|([at, _], weight)| ([0, at], weight)).collect();
            sharp = blurred(&sharp, [width, height], &taps);
        }
        let motion = self.motion_px.map(|part| part * OVERSAMPLING as f64);
        let length = motion[0].hypot(motion[1]);
        if length > 0.5 {
            let n_instants = (2.0 * length).ceil() as usize | 1;
            let instant = |idx: usize| {
                let time = (idx as f64 + 0.5) / n_instants as f64 - 0.5;
                (motion.map(|part| (part * time).round() as i64), 1.0)
            };
            sharp = blurred(&sharp, [width, height], &(0..n_instants).map(instant).collect::<Vec<_>>());
        }
        let middle = self.middle_px();
        GrayImage::from_fn(self.size_px[0] as u32, self.size_px[1] as u32, |u, v| {
            let (u, v) = (u as usize, v as usize);
            let rows = v * OVERSAMPLING..(v + 1) * OVERSAMPLING;
            let sum: f32 =
                rows.map(|row| sharp[row * width + u * OVERSAMPLING..][..OVERSAMPLING].iter().sum::<f32>()).sum();
            let albedo = f64::from(sum) / (OVERSAMPLING * OVERSAMPLING) as f64;
            let tan2 = ((u as f64 - middle[0]).powi(2) + (v as f64 - middle[1]).powi(2)) / self.focal_px.powi(2);
            let light = if self.darkens { (1.0 + tan2).powi(-2) } else { 1.0 };
            let grey = (self.white_grey - self.black_grey) * albedo * light + self.black_grey;
            let variance = self.dark_noise_grey.powi(2) + grey / self.electrons_per_grey;
            image::Luma([(grey + normal(random) * variance.sqrt()).round().clamp(0.0, 255.0) as u8])
        })
    }
}

/// Normally distributed random number (Box and Muller).
fn normal(random: &mut Random) -> f64 {
    let (radius, angle) = ((-2.0 * (1.0 - random.unit()).ln()).sqrt(), std::f64::consts::TAU * random.unit());
    radius * angle.cos()
}

fn turned([x, y]: [f64; 2], by_rad: f64) -> [f64; 2] {
    let (sin, cos) = by_rad.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

/// Weighted mean of an array, shifted by each of the offsets. At the border the nearest value counts.
fn blurred(values: &[f32], [width, height]: [usize; 2], taps: &[([i64; 2], f32)]) -> Vec<f32> {
    let sum: f32 = taps.iter().map(|(_, weight)| weight).sum();
    let mut blurred = vec![0.0f32; values.len()];
    for ([du, dv], weight) in taps {
        for v in 0..height {
            let from = (v as i64 + dv).clamp(0, height as i64 - 1) as usize;
            let (row, out) = (&values[from * width..][..width], &mut blurred[v * width..][..width]);
            let inner = (-du).max(0) as usize..(width as i64 - du.max(&0)).max(0) as usize;
            for u in (0..inner.start).chain(inner.end..width) {
                out[u] += weight / sum * row[(u as i64 + du).clamp(0, width as i64 - 1) as usize];
            }
            let shifted = &row[(inner.start as i64 + du) as usize..];
            for (out, value) in out[inner].iter_mut().zip(shifted) {
                *out += weight / sum * value;
            }
        }
    }
    blurred
}
