//! Synthetic images of ceilings with markers, made without the localizer's projection: the ground truth of the tests in this folder.

use image::GrayImage;
use nalgebra::{Rotation3, Vector3};

use crate::markers::{GridPlace, MarkerId};
use crate::vision::synthetic::Random;

/// A true camera below a true ceiling. The frame `ceiling` has x and y as the world's, z up, and its origin on the floor.
#[derive(Clone, Debug)]
pub(crate) struct Eye {
    pub(crate) focal_px: [f64; 2],
    pub(crate) centre_px: [f64; 2],
    /// Coefficients k1, k2, p1, p2 of Brown's lens distortion.
    pub(crate) distortion: [f64; 4],
    pub(crate) place_m: Vector3<f64>,
    /// Rotation of the camera. Its columns are image right, image down and the optical axis in the ceiling frame.
    pub(crate) world_from_camera: Rotation3<f64>,
}

impl Eye {
    /// A camera with the calibration matrix K of paper 5 that looks straight up from the origin; image up points along `heading_rad`.
    pub(crate) fn upright(heading_rad: f64) -> Eye {
        let (sin, cos) = heading_rad.sin_cos();
        let forward = Vector3::new(cos, sin, 0.0);
        let left = Vector3::new(-sin, cos, 0.0);
        let axes = nalgebra::Matrix3::from_columns(&[left, -forward, Vector3::z()]);
        Eye {
            focal_px: [755.139, 753.926],
            centre_px: [320.252, 239.661],
            distortion: [0.0; 4],
            place_m: Vector3::zeros(),
            world_from_camera: Rotation3::from_matrix_unchecked(axes),
        }
    }

    /// Pixel at which a point is seen, inside or outside of the image; `None` for a point behind the camera.
    pub(crate) fn project(&self, point_m: Vector3<f64>) -> Option<[f64; 2]> {
        let seen = self.world_from_camera.inverse() * (point_m - self.place_m);
        if seen.z <= 1e-6 {
            return None;
        }
        let (x, y) = (seen.x / seen.z, seen.y / seen.z);
        let [k1, k2, p1, p2] = self.distortion;
        let square = x * x + y * y;
        let radial = 1.0 + k1 * square + k2 * square * square;
        let bent = [
            x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
            y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        Some([0, 1].map(|axis| self.focal_px[axis] * bent[axis] + self.centre_px[axis]))
    }
}

/// A marker as it is pasted on the ceiling.
#[derive(Clone, Debug)]
pub(crate) struct Pasted {
    pub(crate) id: MarkerId,
    pub(crate) centre_m: [f64; 2],
    pub(crate) rotation_rad: f64,
    pub(crate) height_m: f64,
    /// Whether the marker is mirrored, as if printed on the wrong side of the film.
    pub(crate) is_mirrored: bool,
    /// Dots that are missing from the marker, and dots that are scratched: a share of each one's width is removed at the right.
    pub(crate) missing: Vec<GridPlace>,
    pub(crate) scratched: Vec<(GridPlace, f64)>,
    /// Grey level of the marker's dots above the background; grey levels above white are clipped.
    pub(crate) level: f64,
}

impl Pasted {
    pub(crate) fn new(id: MarkerId, centre_m: [f64; 2], rotation_rad: f64, height_m: f64) -> Pasted {
        let (missing, scratched) = (Vec::new(), Vec::new());
        Pasted { id, centre_m, rotation_rad, height_m, is_mirrored: false, missing, scratched, level: 215.0 }
    }

    /// Point of the ceiling at which a point of the marker frame lies.
    fn at(&self, [mut x, y]: [f64; 2]) -> Vector3<f64> {
        if self.is_mirrored {
            x = -x;
        }
        let (sin, cos) = self.rotation_rad.sin_cos();
        Vector3::new(self.centre_m[0] + cos * x - sin * y, self.centre_m[1] + sin * x + cos * y, self.height_m)
    }

    fn dot(&self, place: GridPlace, offset: [f64; 2]) -> Vector3<f64> {
        self.at([0, 1].map(|axis| 0.04 * (f64::from(place[axis]) - 1.5) + offset[axis]))
    }

    /// Pixel at which the camera sees the centre of a dot.
    pub(crate) fn dot_px(&self, place: GridPlace, eye: &Eye) -> Option<[f64; 2]> {
        eye.project(self.dot(place, [0.0; 2]))
    }

    fn dots(&self) -> impl Iterator<Item = GridPlace> {
        self.id.dots().filter(|place| !self.missing.contains(place))
    }
}

/// Something bright on the ceiling that is no marker: a four-cornered patch (a fluorescent tube, a window) or a disc (a round lamp).
#[derive(Clone, Debug)]
pub(crate) enum Clutter {
    Patch { corners_px: [[f64; 2]; 4], grey: f64 },
    Disc { centre_px: [f64; 2], radius_px: f64, grey: f64 },
}

/// Everything that a synthetic image of a ceiling is made from.
#[derive(Clone, Debug)]
pub(crate) struct Ceiling {
    pub(crate) size_px: [usize; 2],
    pub(crate) markers: Vec<Pasted>,
    pub(crate) clutter: Vec<Clutter>,
    /// Grey level of the ceiling, and its relative change from the middle of the image to its edge, along u and v.
    pub(crate) background: f64,
    pub(crate) gradient: [f64; 2],
    /// Standard deviation of the lens's blur.
    pub(crate) sigma_px: f64,
    /// Motion of the image over the exposure.
    pub(crate) motion_px: [f64; 2],
    /// Photoelectrons of a pixel at mid grey (grey level 128).
    pub(crate) electrons: f64,
}

impl Ceiling {
    pub(crate) fn new(markers: Vec<Pasted>) -> Ceiling {
        Ceiling {
            size_px: [640, 480],
            markers,
            clutter: Vec::new(),
            background: 20.0,
            gradient: [0.0; 2],
            sigma_px: 0.6,
            motion_px: [0.0; 2],
            electrons: 5000.0,
        }
    }

    /// The image that the camera takes: area-sampled, blurred by lens and motion, with shot noise and read noise, in 8 bits.
    pub(crate) fn picture(&self, eye: &Eye, random: &mut Random) -> GrayImage {
        let [width, height] = self.size_px;
        let mut grey = vec![0.0f32; width * height];
        for (index, value) in grey.iter_mut().enumerate() {
            let (u, v) = ((index % width) as f64 / width as f64 - 0.5, (index / width) as f64 / height as f64 - 0.5);
            *value = (self.background * (1.0 + 2.0 * self.gradient[0] * u + 2.0 * self.gradient[1] * v)) as f32;
        }
        self.clutter.iter().for_each(|clutter| clutter.add(&mut grey, width));
        for marker in &self.markers {
            for place in marker.dots() {
                self.add_dot(marker, place, eye, &mut grey);
            }
        }
        let electrons_per_grey = self.electrons / 128.0;
        GrayImage::from_fn(width as u32, height as u32, |u, v| {
            let electrons = f64::from(grey[v as usize * width + u as usize]) * electrons_per_grey;
            let noisy = electrons + random.normal() * (electrons + 16.0).sqrt();
            image::Luma([(noisy / electrons_per_grey).round().clamp(0.0, 255.0) as u8])
        })
    }

    /// Adds the light of one marker dot to the image: a cloud of points of equal area, each blurred to a Gaussian. Only the finite number of points
    /// makes the result inexact.
    fn add_dot(&self, marker: &Pasted, place: GridPlace, eye: &Eye, grey: &mut [f32]) {
        let cut = marker
            .scratched
            .iter()
            .find(|(scratched, _)| *scratched == place)
            .map_or(1.0, |(_, share)| 1.0 - 2.0 * share);
        let Some(centre) = marker.dot_px(place, eye) else { return };
        let [width, height] = self.size_px;
        let inside = |value: f64, size: usize| value > -30.0 && value < size as f64 + 30.0;
        if !inside(centre[0], width) || !inside(centre[1], height) {
            return;
        }
        let blur = self.motion_px[0].hypot(self.motion_px[1]);
        let n_times = if blur < 0.1 { 1 } else { (2.0 * blur).ceil() as usize + 2 };
        // The cloud has rings of equal area with points at equal angles on each, which makes it fine and symmetric.
        let (n_rings, n_angles) = (10, 40);
        let mut samples = Vec::new();
        for ring in 0..n_rings {
            let radius = 0.01 * ((ring as f64 + 0.5) / n_rings as f64).sqrt();
            for step in 0..n_angles {
                let (sin, cos) =
                    (std::f64::consts::TAU * (step as f64 + 0.5 * (ring % 2) as f64) / n_angles as f64).sin_cos();
                if cos * radius <= cut * 0.01 {
                    samples.extend(eye.project(marker.dot(place, [radius * cos, radius * sin])));
                }
            }
        }
        // The dot's light is its grey level times its whole area in pixels, divided by the number of points of a whole dot.
        let area_px = dot_area_px(marker, place, eye);
        let weight = marker.level * area_px / (n_rings * n_angles * n_times) as f64;
        let reach = (3.5 * self.sigma_px + 1.0).ceil();
        let spread = 0.5 * self.motion_px[0].abs().max(self.motion_px[1].abs()) + 0.01 * eye.focal_px[0] / 1.0;
        let half = (reach + spread + 2.0) as i64;
        let (left, top) = (centre[0].round() as i64 - half, centre[1].round() as i64 - half);
        let side = (2 * half + 1) as usize;
        let mut patch = vec![0.0f64; side * side];
        for time in 0..n_times {
            let share = (time as f64 + 0.5) / n_times as f64 - 0.5;
            for sample in &samples {
                let at = [0, 1].map(|axis| sample[axis] + share * self.motion_px[axis]);
                splat(&mut patch, side, [at[0] - left as f64, at[1] - top as f64], weight, self.sigma_px);
            }
        }
        for (index, value) in patch.iter().enumerate() {
            let (u, v) = (left + (index % side) as i64, top + (index / side) as i64);
            if (0..width as i64).contains(&u) && (0..height as i64).contains(&v) {
                grey[v as usize * width + u as usize] += *value as f32;
            }
        }
    }
}

/// Area of a whole dot's image, from the images of the ends of two of its diameters.
fn dot_area_px(marker: &Pasted, place: GridPlace, eye: &Eye) -> f64 {
    let at = |offset: [f64; 2]| eye.project(marker.dot(place, offset)).unwrap_or([0.0; 2]);
    let (right, left, up, down) = (at([0.01, 0.0]), at([-0.01, 0.0]), at([0.0, 0.01]), at([0.0, -0.01]));
    let (a, b) = ([right[0] - left[0], right[1] - left[1]], [up[0] - down[0], up[1] - down[1]]);
    std::f64::consts::PI * 0.25 * (a[0] * b[1] - a[1] * b[0]).abs()
}

/// Adds a Gaussian of volume `weight`, integrated over each pixel.
fn splat(patch: &mut [f64], side: usize, at: [f64; 2], weight: f64, sigma: f64) {
    const MOST: usize = 24;
    let reach = (3.5 * sigma + 1.0).ceil() as i64;
    let shares = [0, 1].map(|axis| {
        let first = at[axis].round() as i64 - reach;
        let mut shares = [0.0; MOST];
        let mut below = smooth_step((first as f64 - 0.5 - at[axis]) / sigma);
        for (step, share) in shares.iter_mut().enumerate().take((2 * reach + 1) as usize) {
            let above = smooth_step((first as f64 + step as f64 + 0.5 - at[axis]) / sigma);
            *share = above - below;
            below = above;
        }
        (first, shares)
    });
    let span = (2 * reach + 1).min(MOST as i64);
    for dv in 0..span {
        for du in 0..span {
            let (u, v) = (shares[0].0 + du, shares[1].0 + dv);
            if (0..side as i64).contains(&u) && (0..side as i64).contains(&v) {
                patch[v as usize * side + u as usize] += weight * shares[0].1[du as usize] * shares[1].1[dv as usize];
            }
        }
    }
}

/// Distribution function of the standard normal distribution to within 2e-4: the logistic approximation with a cubic
/// term (E. Page, Applied Statistics 26, 1977).
fn smooth_step(x: f64) -> f64 {
    1.0 / (1.0 + (-(1.5976 * x + 0.07056 * x * x * x)).exp())
}

impl Clutter {
    fn add(&self, grey: &mut [f32], width: usize) {
        for (index, value) in grey.iter_mut().enumerate() {
            let at = [(index % width) as f64, (index / width) as f64];
            let (distance, level) = match self {
                Clutter::Disc { centre_px, radius_px, grey } => {
                    ((at[0] - centre_px[0]).hypot(at[1] - centre_px[1]) - radius_px, *grey)
                }
                Clutter::Patch { corners_px, grey } => (outside_px(corners_px, at), *grey),
            };
            // The edge of a bright tube, window or lamp is as soft as the lens makes it, with a halo of stray light around it.
            if distance < 30.0 {
                let halo = if distance > 0.0 { 0.04 * (-distance / 8.0).exp() } else { 0.0 };
                *value += (level * ((0.5 - distance / 1.5).clamp(0.0, 1.0) + halo)) as f32;
            }
        }
    }
}

/// Distance of a point from a convex polygon whose corners run clockwise in the image; negative inside of the polygon.
fn outside_px(corners: &[[f64; 2]; 4], at: [f64; 2]) -> f64 {
    (0..4)
        .map(|corner| {
            let (a, b) = (corners[corner], corners[(corner + 1) % 4]);
            let (du, dv) = (b[0] - a[0], b[1] - a[1]);
            (dv * (at[0] - a[0]) - du * (at[1] - a[1])) / du.hypot(dv)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}
