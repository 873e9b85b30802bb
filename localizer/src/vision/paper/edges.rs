//! Canny edges of the restored picture, closed to bands (paper 1, section 3.1: binarisation).

use image::{GrayImage, Luma};
use imageproc::distance_transform::Norm;
use imageproc::edges::canny;
use imageproc::morphology::close;

/// Least gradient of an edge, in the units of a 3×3 Sobel operator: a step of about 25 grey levels.
const GRADIENT_MIN: f32 = 60.0;
/// Edges must exceed the gradient of the noise by this factor: at 5, a picture of 300 000 pixels has no edge from noise alone.
const GRADIENT_PER_NOISE: f32 = 5.0;
/// Share of the upper threshold that continues an edge, Canny's own recommendation of 2:1 to 3:1.
const HYSTERESIS: f32 = 0.4;
/// Gradient noise per grey level of pixel noise: smoothing by 1.4 px leaves `1/(√(8π)·1.4²)` a pixel, Sobel multiplies by 8.
const SOBEL_NOISE: f32 = 0.81;

/// White bands where joints are, black elsewhere; nothing within `border_px` of the picture's edge.
///
/// A joint has an edge on either side. Edges no farther apart than a joint and its smoothing are closed to one band, so that its
/// skeleton is the joint's centre line, not two lines beside it.
pub(super) fn bands(image: &GrayImage, joint_width_px: f64, border_px: usize) -> GrayImage {
    let high = GRADIENT_MIN.max(GRADIENT_PER_NOISE * SOBEL_NOISE * noise_grey(image));
    let mut edges = canny(image, HYSTERESIS * high, high);
    let (width, height, border) = (edges.width(), edges.height(), border_px as u32);
    for (u, v, pixel) in edges.enumerate_pixels_mut() {
        if u < border || v < border || u + border >= width || v + border >= height {
            *pixel = Luma([0]);
        }
    }
    // Smoothing moves the two edges of a narrow strip outwards by up to 2 px together; half of the gap, rounded up, closes it.
    let reach = (0.5 * (joint_width_px + 2.0)).ceil().clamp(1.0, 20.0) as u8;
    close(&edges, Norm::LInf, reach)
}

/// Standard deviation of a pixel's noise: median of second differences along rows, which straight shading cannot excite.
fn noise_grey(image: &GrayImage) -> f32 {
    let mut counts = [0usize; 1024];
    let mut total = 0;
    for row in image.as_raw().chunks_exact(image.width().max(1) as usize).step_by(4) {
        for near in row.windows(3) {
            counts[(2 * i32::from(near[1]) - i32::from(near[0]) - i32::from(near[2])).unsigned_abs() as usize] += 1;
            total += 1;
        }
    }
    let mut below = 0;
    let median = counts.iter().position(|count| {
        below += count;
        2 * below >= total
    });
    // The second difference of white noise has √6 times its deviation; the median of its size is 0.6745 deviations.
    median.unwrap_or(0) as f32 / (6.0_f32.sqrt() * 0.6745)
}
