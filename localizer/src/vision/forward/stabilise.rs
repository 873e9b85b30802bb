//! Makes an image's noise equal everywhere by the generalised Anscombe transform, whose gain and offset are estimated from the image itself.
//!
//! Photon noise makes the variance of a pixel grow with its value, σ² = a·x + b. Then 2/a·√(a·x + b) has the variance 1
//! (Anscombe 1948; Starck, Murtagh and Bijaoui 1998).

use super::Picture;

/// Number of brightness classes, each with the same number of pixels, for which the noise is estimated separately.
const CLASSES: usize = 12;

/// The image, transformed so that its noise has standard deviation 1.
pub fn stabilised(picture: &Picture) -> Picture {
    let [slope, offset] = noise_law(picture);
    picture.map(|value| 2.0 / slope * (slope * value + offset).max(0.0).sqrt())
}

/// Coefficients a and b of the noise variance σ² = a·x + b, from the median noise of classes of brightness; edges are few and hardly change a median.
fn noise_law(picture: &Picture) -> [f32; 2] {
    let width = picture.width;
    // The second difference x₋₁ − 2x + x₊₁ of independent noise has 6 times the variance of the noise and is not affected by slopes. It is
    // taken two pixels apart, because neighbouring pixels that a lens map has interpolated share their noise.
    let mut samples: Vec<(f32, f32)> = picture
        .values
        .chunks(width.max(1))
        .step_by(4)
        .flat_map(|row| row.windows(5).step_by(4))
        .map(|of| (0.2 * of.iter().sum::<f32>(), (of[0] - 2.0 * of[2] + of[4]).abs()))
        .collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let in_class = samples.len().div_ceil(CLASSES).max(1);
    let mut classes: Vec<[f32; 2]> = samples
        .chunks_mut(in_class)
        .map(|class| {
            let middle = class.len() / 2;
            let level = class[middle].0;
            let (_, median, _) = class.select_nth_unstable_by(middle, |a, b| a.1.total_cmp(&b.1));
            // The median of |N(0, 1)| is 0.6745. Grey levels are whole numbers, so that a median may be rounded by half a level.
            let deviation = median.1 / 0.6745;
            [level, (deviation * deviation / 6.0).max(1.0 / 12.0)]
        })
        .collect();
    // The brightest of the brightness classes is left out of the noise estimate, because it may be saturated.
    classes.pop();
    straight_line(&classes)
}

/// Fits the noise variance of brightness classes as a straight line over their brightness, by least squares. Each variance is weighted as known with
/// the same relative accuracy; the slope is at least 0.001.
fn straight_line(points: &[[f32; 2]]) -> [f32; 2] {
    let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0_f32, 0.0, 0.0, 0.0, 0.0);
    for &[x, y] in points {
        let weight = 1.0 / (y * y);
        w += weight;
        wx += weight * x;
        wy += weight * y;
        wxx += weight * x * x;
        wxy += weight * x * y;
    }
    let determinant = w * wxx - wx * wx;
    let slope = if determinant > 1e-9 * w * wxx { (w * wxy - wx * wy) / determinant } else { 0.0 };
    let slope = slope.max(1e-3);
    [slope, if w > 0.0 { (wy - slope * wx) / w } else { 1.0 }]
}
