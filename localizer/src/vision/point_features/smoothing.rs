//! Smoothed copies of an image, and values between their pixels.

use image::GrayImage;

use crate::vision::forward::Picture;

/// Variance of the smoothing of the full image, in px². It makes the error of bilinear interpolation small and the noise of the corner detector's
/// input a quarter of the image's.
pub(super) const FINE_VARIANCE_PX2: f64 = 1.0;
/// Radius of the kernel of that smoothing: three standard deviations.
const FINE_RADIUS_PX: usize = 3;
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

/// An image smoothed by a kernel of `N` weights along its rows and its columns. Beyond the border the value of the nearest pixel counts.
fn convolved<const N: usize>(picture: &Picture, kernel: [f32; N]) -> Picture {
    let (width, height) = (picture.width, picture.height);
    let radius = N / 2;
    let mut values = vec![0.0; width * height];
    if values.is_empty() {
        return Picture { width, height, values };
    }
    // One row at a time is filtered along the columns and then along itself, so that all of it stays in the cache. Sums over all weights for one
    // pixel after the other are what the compiler turns into vector instructions.
    let mut padded = vec![0.0; width + 2 * radius];
    for (v, out) in values.chunks_exact_mut(width).enumerate() {
        let row = |tap: usize| (v + tap).saturating_sub(radius).min(height - 1);
        let rows: [&[f32]; N] = std::array::from_fn(|tap| &picture.values[row(tap) * width..][..width]);
        for (u, sum) in padded[radius..radius + width].iter_mut().enumerate() {
            *sum = (0..N).fold(0.0, |sum, tap| sum + kernel[tap] * rows[tap][u]);
        }
        let [first, last] = [padded[radius], padded[radius + width - 1]];
        padded[..radius].fill(first);
        padded[radius + width..].fill(last);
        let shifted: [&[f32]; N] = std::array::from_fn(|tap| &padded[tap..][..width]);
        for (u, sum) in out.iter_mut().enumerate() {
            *sum = (0..N).fold(0.0, |sum, tap| sum + kernel[tap] * shifted[tap][u]);
        }
    }
    Picture { width, height, values }
}

/// The image smoothed by a Gaussian of [`FINE_VARIANCE_PX2`], height × width as before.
pub(super) fn fine(image: &GrayImage) -> Picture {
    let kernel = gaussian(FINE_VARIANCE_PX2, FINE_RADIUS_PX);
    convolved::<{ 2 * FINE_RADIUS_PX + 1 }>(&Picture::from(image), std::array::from_fn(|tap| kernel[tap]))
}

/// The image at half resolution, smoothed again. Its pixel (u, v) lies at (2u + ½, 2v + ½) of the full image.
pub(super) fn coarse(fine: &Picture) -> Picture {
    convolved(&fine.binned(), [0.25, 0.5, 0.25])
}

/// Greatest width and height of an image in which values are interpolated, in pixels. Positions of single precision have no fraction beyond it.
const WIDEST_PX: usize = 1 << 22;

/// Whether all points within a distance of a place are far enough from the border of an image for values between its pixels.
pub(super) fn is_inside(picture: &Picture, at_px: [f64; 2], reach_px: f64) -> bool {
    // Not true of undefined numbers.
    let is_within =
        |at: f64, size: usize| at - reach_px >= 0.0 && at + reach_px < size as f64 - 2.0 && size <= WIDEST_PX;
    is_within(at_px[0], picture.width) && is_within(at_px[1], picture.height)
}

/// Positions between the pixels of an image that are inside by [`is_inside`]: for each the pixel before it, and what is left along u and along v.
pub(super) struct Between<const N: usize> {
    pixels: [[u32; N]; 2],
    shares: [[f32; N]; 2],
}

impl<const N: usize> Between<N> {
    /// The positions with these coordinates along u and along v. All are computed side by side, by the vector instructions that the compiler makes of it.
    #[inline(always)]
    pub(super) fn new(positions_px: &[[f32; N]; 2]) -> Between<N> {
        let mut between = Between { pixels: [[0; N]; 2], shares: [[0.0; N]; 2] };
        for (axis, positions_px) in positions_px.iter().enumerate() {
            for (idx, &at_px) in positions_px.iter().enumerate() {
                let whole_px = whole(at_px);
                between.pixels[axis][idx] = index(whole_px);
                between.shares[axis][idx] = at_px - whole_px;
            }
        }
        between
    }

    /// Value of the image at one of the positions, interpolated bilinearly.
    #[inline(always)]
    pub(super) fn value(&self, picture: &Picture, idx: usize) -> f32 {
        let ([u, v], [du, dv]) =
            (self.pixels.map(|pixels| pixels[idx] as usize), self.shares.map(|shares| shares[idx]));
        let pixels = &picture.values[v * picture.width + u..][..picture.width + 2];
        let (top, below) = ([pixels[0], pixels[1]], [pixels[picture.width], pixels[picture.width + 1]]);
        let top_value = top[0] + du * (top[1] - top[0]);
        let below_value = below[0] + du * (below[1] - below[0]);
        top_value + dv * (below_value - top_value)
    }
}

/// From this number on, and up to twice it, numbers of single precision are whole, and their last bits are those of a whole number.
const ALL_WHOLE: f32 = (1u32 << (f32::MANTISSA_DIGITS - 1)) as f32;

/// The greatest whole number that is not above a number from 0 to [`WIDEST_PX`]. The standard functions for this, which hold for any number, are none of
/// the vector instructions that every processor has.
#[inline]
fn whole(number: f32) -> f32 {
    let nearest = (number + ALL_WHOLE) - ALL_WHOLE;
    if nearest > number { nearest - 1.0 } else { nearest }
}

/// A whole number from 0 to [`WIDEST_PX`] as an index.
#[inline]
fn index(whole: f32) -> u32 {
    (whole + ALL_WHOLE).to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    fn noise(width: usize, height: usize, random: &mut Random) -> Picture {
        Picture { width, height, values: (0..width * height).map(|_| random.between(0.0, 255.0) as f32).collect() }
    }

    #[test]
    fn an_image_is_smoothed_along_both_axes_with_its_border_continued() {
        let mut random = Random::new(21);
        let kernel = [0.1, 0.2, 0.4, 0.25, 0.05];
        // Images smaller than the kernel, too.
        for [width, height] in [[1, 1], [2, 3], [7, 5], [21, 18]] {
            let picture = noise(width, height, &mut random);
            let smoothed = convolved(&picture, kernel);
            assert_eq!([smoothed.width, smoothed.height], [width, height]);
            for (at, value) in smoothed.values.iter().enumerate() {
                let near = |at: usize, tap: usize, size: usize| (at + tap).saturating_sub(2).min(size - 1);
                let weight = |tap: usize| f64::from(kernel[tap]);
                let level =
                    |i: usize, j: usize| f64::from(picture.at(near(at % width, i, width), near(at / width, j, height)));
                let parts = (0..25).map(|tap| weight(tap % 5) * weight(tap / 5) * level(tap % 5, tap / 5));
                assert!((f64::from(*value) - parts.sum::<f64>()).abs() < 1e-3, "{width} × {height}, {at}");
            }
        }
        assert_eq!(convolved(&noise(0, 0, &mut random), kernel).values, []);
    }

    #[test]
    fn values_between_pixels_are_bilinear_up_to_the_last_pixel_that_is_inside() {
        let mut random = Random::new(22);
        let picture = noise(31, 23, &mut random);
        let places: Vec<[f32; 2]> =
            (0..400).map(|_| [random.between(0.0, 28.9) as f32, random.between(0.0, 20.9) as f32]).collect();
        let places = [[0.0, 0.0], [5.0, 7.0], [28.0, 20.0], [f32::from_bits(5.0f32.to_bits() - 1), 3.0]]
            .into_iter()
            .chain(places);
        for [u, v] in places {
            assert!(is_inside(&picture, [f64::from(u), f64::from(v)], 0.0));
            let value = Between::new(&[[u], [v]]).value(&picture, 0);
            let parts = [0, 1, 2, 3].map(|corner| {
                let (at_u, at_v) = (u.floor() as usize + corner % 2, v.floor() as usize + corner / 2);
                let share = |at: f32, corner: usize| f64::from(1.0 - (at - corner as f32).abs());
                share(u, at_u) * share(v, at_v) * f64::from(picture.at(at_u, at_v))
            });
            assert!((f64::from(value) - parts.iter().sum::<f64>()).abs() < 1e-3, "{u} {v}: {value}");
        }
        assert!(!is_inside(&picture, [29.0, 5.0], 0.0) && !is_inside(&picture, [5.0, 5.0], 5.1));
    }

    #[test]
    fn a_number_is_at_the_whole_number_below_it() {
        let below = |number: f32| f32::from_bits(number.to_bits() - 1);
        for number in [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.5, 639.999, 4_194_303.5] {
            assert_eq!(whole(number), number.floor(), "{number}");
            assert_eq!(index(whole(number)), number.floor() as u32);
        }
        for at in 1..3000u32 {
            assert_eq!([at as f32, below(at as f32)].map(|number| index(whole(number))), [at, at - 1]);
        }
    }
}
