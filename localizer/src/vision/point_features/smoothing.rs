//! Smoothed copies of an image, and values between their pixels.

use image::GrayImage;

use crate::vision::forward::Picture;

/// Variance of the smoothing of the full image, in px². It makes the error of bilinear interpolation small and the noise of the corner detector's
/// input a quarter of the image's.
pub(super) const FINE_VARIANCE_PX2: f64 = 1.0;
/// Variance, in px² of the full image, of all that blurs the coarse image: the fine smoothing, the binning (¼), the kernel 1 2 1 at half resolution
/// (2), and bilinear interpolation there (⅔ on average).
pub(super) const COARSE_VARIANCE_PX2: f64 = FINE_VARIANCE_PX2 + 0.25 + 2.0 + 0.67;

/// Weights of a Gaussian of the given variance at −radius … radius, with the sum 1. The radius is three standard deviations and at most `most`.
pub(super) fn gaussian(variance_px2: f64, most: usize) -> Vec<f32> {
    let radius = ((3.0 * variance_px2.sqrt()).ceil() as usize).clamp(1, most);
    let weight = |at: usize| (-0.5 * (at as f64 - radius as f64).powi(2) / variance_px2).exp();
    let sum: f64 = (0..=2 * radius).map(weight).sum();
    (0..=2 * radius).map(|at| (weight(at) / sum) as f32).collect()
}

/// An image smoothed by a kernel along its rows and its columns. Beyond the border the value of the nearest pixel counts.
fn convolved(picture: &Picture, kernel: &[f32]) -> Picture {
    let (width, height, radius) = (picture.width, picture.height, kernel.len() / 2);
    if picture.values.is_empty() {
        return picture.clone();
    }
    // One row at a time is filtered along the columns and then along itself, so that all of it stays in the cache. Sums over whole rows are what the
    // compiler turns into vector instructions.
    let mut values = vec![0.0; width * height];
    let mut padded = vec![0.0; width + 2 * radius];
    for (v, out) in values.chunks_exact_mut(width).enumerate() {
        padded.fill(0.0);
        for (tap, weight) in kernel.iter().enumerate() {
            let row = (v + tap).saturating_sub(radius).min(height - 1);
            let row = &picture.values[row * width..(row + 1) * width];
            for (sum, value) in padded[radius..radius + width].iter_mut().zip(row) {
                *sum += weight * value;
            }
        }
        let [first, last] = [padded[radius], padded[radius + width - 1]];
        padded[..radius].fill(first);
        padded[radius + width..].fill(last);
        for (tap, weight) in kernel.iter().enumerate() {
            for (sum, value) in out.iter_mut().zip(&padded[tap..]) {
                *sum += weight * value;
            }
        }
    }
    Picture { width, height, values }
}

/// The image smoothed by a Gaussian of [`FINE_VARIANCE_PX2`], height × width as before.
pub(super) fn fine(image: &GrayImage) -> Picture {
    convolved(&Picture::from(image), &gaussian(FINE_VARIANCE_PX2, 3))
}

/// The image at half resolution, smoothed again. Its pixel (u, v) lies at (2u + ½, 2v + ½) of the full image.
pub(super) fn coarse(fine: &Picture) -> Picture {
    convolved(&fine.binned(), &[0.25, 0.5, 0.25])
}

/// Whether all points within a distance of a place are far enough from the border of an image for [`sample`].
pub(super) fn is_inside(picture: &Picture, at_px: [f64; 2], reach_px: f64) -> bool {
    // Not true of undefined numbers.
    let is_within = |at: f64, size: usize| at - reach_px >= 0.0 && at + reach_px < size as f64 - 2.0;
    is_within(at_px[0], picture.width) && is_within(at_px[1], picture.height)
}

/// Value of an image at a position between its pixels, interpolated bilinearly, for positions that are inside by [`is_inside`].
#[inline]
pub(super) fn sample(picture: &Picture, u_px: f32, v_px: f32) -> f32 {
    let (u, v) = (u_px as usize, v_px as usize);
    let (du, dv) = (u_px - u as f32, v_px - v as f32);
    let at = v * picture.width + u;
    let (top, below) = (&picture.values[at..at + 2], &picture.values[at + picture.width..at + picture.width + 2]);
    let top_value = top[0] + du * (top[1] - top[0]);
    let below_value = below[0] + du * (below[1] - below[0]);
    top_value + dv * (below_value - top_value)
}
