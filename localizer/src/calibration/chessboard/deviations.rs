//! How well views of a board determine a camera: the jackknife, which leaves out one view after the other.
//!
//! The residuals' covariance would say too little: corners of one view share the errors of its light, its blur and the board's flatness.

use super::{Bend, Corner, Intrinsics, calibrate};

/// Distance between the pixels at which the lens's bend is compared, as a share of the image's width and height.
const GRID: usize = 8;

/// Standard deviations of a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviations {
    /// Of the focal lengths along u and v.
    pub focal_px: [f64; 2],
    /// Of the principal point.
    pub centre_px: [f64; 2],
    /// Of the place at which the lens coefficients put a pixel: the greatest anywhere in the image.
    pub bend_px: f64,
}

impl Intrinsics {
    /// By how many pixels the lens moves the image of a point that a lens without distortion would show at `pixel`.
    pub fn bend_px(&self, pixel: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| (pixel[axis] - self.centre_px[axis]) / self.focal_px[axis]);
        let ([k1, k2, p1, p2], square) = (self.distortion, x * x + y * y);
        let radial = k1 * square + k2 * square * square;
        [
            self.focal_px[0] * (x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x)),
            self.focal_px[1] * (y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y),
        ]
    }
}

/// Standard deviations of what [`calibrate`] finds from these views of images of `size_px` (width, height). `None` unless each set of all views but
/// one determines a camera.
pub fn deviations(views: &[Vec<Corner>], bend: Bend, size_px: [u32; 2]) -> Option<Deviations> {
    let without: Vec<Intrinsics> = (0..views.len())
        .map(|left_out| {
            let others = views.iter().enumerate().filter(|(view, _)| *view != left_out);
            let others: Vec<Vec<Corner>> = others.map(|(_, corners)| corners.clone()).collect();
            Some(calibrate(&others, bend)?.intrinsics)
        })
        .collect::<Option<_>>()?;
    let deviation = |of: &dyn Fn(&Intrinsics) -> f64| {
        let values: Vec<f64> = without.iter().map(of).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        ((n - 1.0) / n * values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()).sqrt()
    };
    let places = (0..=GRID).flat_map(|row| (0..=GRID).map(move |column| [column, row]));
    let bend_px = places
        .map(|place| {
            let pixel = [0, 1].map(|axis| f64::from(size_px[axis]) * place[axis] as f64 / GRID as f64 - 0.5);
            let [u, v] = [0, 1].map(|axis| deviation(&|one: &Intrinsics| one.bend_px(pixel)[axis]));
            u.hypot(v)
        })
        .fold(0.0, f64::max);
    Some(Deviations {
        focal_px: [0, 1].map(|axis| deviation(&|one: &Intrinsics| one.focal_px[axis])),
        centre_px: [0, 1].map(|axis| deviation(&|one: &Intrinsics| one.centre_px[axis])),
        bend_px,
    })
}
