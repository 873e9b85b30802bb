//! Canny edges of the deblurred image, joined by morphological closing to one band per tile joint (the binarisation of paper 1, section 3.1).

use image::{GrayImage, Luma};
use imageproc::distance_transform::Norm;
use imageproc::edges::canny;
use imageproc::morphology::close;

/// Least gradient of an edge in the image, in units of a 3×3 Sobel operator; it corresponds to a step of about 25 grey levels.
const GRADIENT_MIN: f32 = 60.0;
/// Factor by which the gradient of an edge must exceed that of the noise: at 5, noise alone makes no edge in an image of 300 000 pixels.
const GRADIENT_PER_NOISE: f32 = 5.0;
/// Lower threshold of Canny's hysteresis as a share of the upper one; Canny recommends a ratio of 2:1 to 3:1.
const HYSTERESIS: f32 = 0.4;
/// Noise of the gradient per grey level of pixel noise: smoothing by 1.4 px leaves `1/(√(8π)·1.4²)` per pixel, and the
/// Sobel operator multiplies by 8.
const SOBEL_NOISE: f32 = 0.81;

/// Binary image with white bands where tile joints are, black elsewhere, and nothing within `border_px` of the image's edge.
///
/// A joint has an edge on either side. Edges no farther apart than a joint and its smoothing are closed to one band, so that the band's
/// skeleton is the joint's centre line, rather than two lines beside it.
pub(super) fn bands(image: &GrayImage, joint_width_px: f64, border_px: usize) -> GrayImage {
    let high = GRADIENT_MIN.max(GRADIENT_PER_NOISE * SOBEL_NOISE * noise_grey(image));
    let mut edges = canny(image, HYSTERESIS * high, high);
    let (width, height, border) = (edges.width(), edges.height(), border_px as u32);
    for (u, v, pixel) in edges.enumerate_pixels_mut() {
        if u < border || v < border || u + border >= width || v + border >= height {
            *pixel = Luma([0]);
        }
    }
    // Smoothing moves the two edges of a narrow joint outwards by up to 2 px together. Morphological closing by half of the gap between them, rounded
    // up, joins the two edges to one band.
    let reach = (0.5 * (joint_width_px + 2.0)).ceil().clamp(1.0, 20.0) as u8;
    close(&edges, Norm::LInf, reach)
}

/// Standard deviation of a pixel's noise, from the median of second differences along rows, which a linear change of brightness does not affect.
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
    // The second difference of white noise has √6 times its standard deviation; the median of its magnitude is 0.6745 standard deviations.
    median.unwrap_or(0) as f32 / (6.0_f32.sqrt() * 0.6745)
}
