//! Removes uniform motion blur by deconvolution with a Wiener filter (paper 1, section 3.1, first step).

use std::f32::consts::PI;

use image::GrayImage;
use realfft::num_complex::Complex32;
use realfft::{ComplexToReal, FftError, RealFftPlanner, RealToComplex};

/// Noise-to-signal ratio of the Wiener filter: no frequency is amplified by more than `(1 + ratio)/(2·√ratio)`, 2.6 times.
///
/// A smaller ratio sharpens more and causes more ringing: at 0.005 the ringing of one tile joint looks like two more joints.
const NOISE_TO_SIGNAL: f32 = 0.04;

/// Width of the border over which the image fades to its mean: the Fourier transform treats the image as periodic, and
/// a jump at the border would cause ringing inwards.
pub(super) fn taper_px(blur_px: [f64; 2]) -> usize {
    // The border is as wide as the motion, plus a few pixels so that the fading itself does not form an edge.
    blur_px[0].hypot(blur_px[1]).ceil() as usize + 8
}

/// Restores an image that moved by `blur_px = (du, dv)` over the exposure, at uniform speed and symmetrically about mid-exposure.
///
/// The point-spread function is a centred segment, so its transfer function is real, `H(f) = sinc(π·f·blur)`, and the restored spectrum is
/// `(1 + ratio)·H/(H² + ratio)` times the image's, where the ratio is that of noise to signal. The outer [`taper_px`] pixels are not usable.
pub(super) fn deblurred(image: &GrayImage, blur_px: [f64; 2]) -> Result<GrayImage, FftError> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let mut planner = RealFftPlanner::<f32>::new();
    let rows = Pair { forward: planner.plan_fft_forward(width), inverse: planner.plan_fft_inverse(width) };
    let columns = Pair { forward: planner.plan_fft_forward(height), inverse: planner.plan_fft_inverse(height) };
    let mut values = tapered(image, taper_px(blur_px));
    let half = width / 2 + 1;
    // The half spectrum is stored column by column, so that the second transform runs along contiguous memory.
    let mut spectrum = vec![Complex32::default(); half * height];
    let mut line = vec![Complex32::default(); half];
    for (row, values) in values.chunks_exact_mut(width).enumerate() {
        rows.forward.process(values, &mut line)?;
        for (column, &value) in line.iter().enumerate() {
            spectrum[column * height + row] = value;
        }
    }
    let blur = blur_px.map(|component| component as f32);
    for (column, line) in spectrum.chunks_exact_mut(height).enumerate() {
        let cycles_u = blur[0] * column as f32 / width as f32;
        filter_column(line, &columns, |row_cycles| wiener(cycles_u + blur[1] * row_cycles))?;
    }
    let scale = 1.0 / (width * height) as f32;
    let mut restored = Vec::with_capacity(width * height);
    for (row, values) in values.chunks_exact_mut(width).enumerate() {
        for (column, value) in line.iter_mut().enumerate() {
            *value = spectrum[column * height + row];
        }
        // For real input the first Fourier coefficient, and for an even width the last one, is real; rounding must not give them an imaginary part.
        line[0].im = 0.0;
        if width.is_multiple_of(2) {
            line[half - 1].im = 0.0;
        }
        rows.inverse.process(&mut line, values)?;
        restored.extend(values.iter().map(|value| (value * scale).round().clamp(0.0, 255.0) as u8));
    }
    Ok(GrayImage::from_raw(image.width(), image.height(), restored).unwrap_or_default())
}

/// Forward and inverse Fourier transforms for one length.
struct Pair {
    forward: std::sync::Arc<dyn RealToComplex<f32>>,
    inverse: std::sync::Arc<dyn ComplexToReal<f32>>,
}

/// Gain of the Wiener filter at a frequency that goes through this many cycles over the motion; 1 without motion.
fn wiener(cycles: f32) -> f32 {
    let x = PI * cycles;
    let transfer = if x.abs() < 1e-3 { 1.0 } else { x.sin() / x };
    (1.0 + NOISE_TO_SIGNAL) * transfer / (transfer * transfer + NOISE_TO_SIGNAL)
}

/// Multiplies the spectrum of one complex column by a real gain, which is given as a function of the row frequency in cycles per pixel.
///
/// Only transforms of real input are available. If `A` and `B` are the transforms of the real and the imaginary part, the transform of the
/// column is `A[k] + i·B[k]` at `k` and `conj A[k] + i·conj B[k]` at `−k`.
fn filter_column(column: &mut [Complex32], pair: &Pair, gain: impl Fn(f32) -> f32) -> Result<(), FftError> {
    let height = column.len();
    let half = height / 2 + 1;
    let mut parts =
        [column.iter().map(|value| value.re).collect::<Vec<f32>>(), column.iter().map(|value| value.im).collect()];
    let [mut a, mut b] = [vec![Complex32::default(); half], vec![Complex32::default(); half]];
    pair.forward.process(&mut parts[0], &mut a)?;
    pair.forward.process(&mut parts[1], &mut b)?;
    let i = Complex32::i();
    for row in 0..half {
        let cycles = row as f32 / height as f32;
        let at_plus = (a[row] + i * b[row]) * gain(cycles);
        let at_minus = (a[row].conj() + i * b[row].conj()) * gain(-cycles);
        a[row] = 0.5 * (at_plus + at_minus.conj());
        b[row] = -0.5 * i * (at_plus - at_minus.conj());
    }
    for part in [&mut a, &mut b] {
        part[0].im = 0.0;
        if height.is_multiple_of(2) {
            part[half - 1].im = 0.0;
        }
    }
    pair.inverse.process(&mut a, &mut parts[0])?;
    pair.inverse.process(&mut b, &mut parts[1])?;
    for ((value, &re), &im) in column.iter_mut().zip(&parts[0]).zip(&parts[1]) {
        *value = Complex32::new(re, im);
    }
    Ok(())
}

/// Pixel values of the image, faded to its mean over the border with a raised cosine.
fn tapered(image: &GrayImage, border_px: usize) -> Vec<f32> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let mean = image.as_raw().iter().map(|&grey| f64::from(grey)).sum::<f64>() as f32 / (width * height).max(1) as f32;
    let weight = |position: usize, length: usize| {
        let inside = (position.min(length - 1 - position) as f32 + 0.5) / border_px as f32;
        0.5 - 0.5 * (PI * inside.min(1.0)).cos()
    };
    let across: Vec<f32> = (0..width).map(|column| weight(column, width)).collect();
    let rows = image.as_raw().chunks_exact(width.max(1)).enumerate();
    rows.flat_map(|(row, greys)| {
        let down = weight(row, height);
        greys.iter().zip(&across).map(move |(&grey, across)| mean + (f32::from(grey) - mean) * across * down)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Image of a dark strip 6 px wide at u = 100, which moves by some pixels along u during the exposure: the exact overlap of two boxes.
    fn strip(motion_px: f64) -> GrayImage {
        GrayImage::from_fn(200, 90, |u, _| {
            let from = (f64::from(u) - 0.5 * motion_px).max(97.0);
            let to = (f64::from(u) + 0.5 * motion_px).min(103.0);
            let share = if motion_px > 0.0 {
                (to - from).max(0.0) / motion_px
            } else {
                f64::from(u8::from((97..=103).contains(&u)))
            };
            image::Luma([(150.0 - 100.0 * share).round() as u8])
        })
    }

    #[test]
    fn a_moved_strip_gets_its_edges_back_in_place() {
        let moved = strip(9.0);
        let restored = deblurred(&moved, [9.0, 0.0]).unwrap_or_default();
        let row: Vec<f64> = restored.as_raw()[45 * 200..46 * 200].iter().map(|&grey| f64::from(grey)).collect();
        let before: Vec<f64> = moved.as_raw()[45 * 200..46 * 200].iter().map(|&grey| f64::from(grey)).collect();
        let steepest = |row: &[f64]| (60..140).map(|u| (row[u + 1] - row[u]).abs()).fold(0.0, f64::max);
        assert!(steepest(&row) > 1.8 * steepest(&before), "{} against {}", steepest(&row), steepest(&before));
        // The dark strip's centroid stays in place, because symmetric blur shifts it to neither side.
        let centre: f64 = (85..=115).map(|u| (150.0 - row[u]) * u as f64).sum::<f64>()
            / (85..=115).map(|u| 150.0 - row[u]).sum::<f64>();
        assert!((centre - 100.0).abs() < 0.2, "centre {centre}");
        // The ringing that deblurring leaves beside the dark strip stays below a third of the strip's depth.
        assert!((30..90).chain(110..170).all(|u| (row[u] - 150.0).abs() < 34.0));
    }
}
