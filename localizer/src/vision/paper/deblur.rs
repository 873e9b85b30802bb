//! Deconvolution of uniform motion blur by a Wiener filter (paper 1, section 3.1, first step).

use std::f32::consts::PI;

use image::GrayImage;
use realfft::num_complex::Complex32;
use realfft::{ComplexToReal, FftError, RealFftPlanner, RealToComplex};

/// Noise-to-signal ratio of the filter: it amplifies no frequency by more than `1/(2·√ratio)`, 2.5 times.
///
/// Smaller sharpens more and rings more: at 0.005 the ringing of one joint passes for two more.
const NOISE_TO_SIGNAL: f32 = 0.04;

/// Border over which the picture fades to its mean: the transform sees it as periodic, and a jump there would ring inwards.
pub(super) fn taper_px(blur_px: [f64; 2]) -> usize {
    // As far as the motion carries, and a few pixels so that the fading itself is no edge.
    blur_px[0].hypot(blur_px[1]).ceil() as usize + 8
}

/// Restores a picture that was moved by `blur_px = (du, dv)` over the exposure, at uniform speed about mid-exposure.
///
/// The point-spread function is a centred segment, so its transfer function is real, `H(f) = sinc(π·f·blur)`, and the
/// restored spectrum is `H/(H² + noise-to-signal)` times the picture's. The outer [`taper_px`] pixels are not usable.
pub(super) fn deblurred(image: &GrayImage, blur_px: [f64; 2]) -> Result<GrayImage, FftError> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let mut planner = RealFftPlanner::<f32>::new();
    let rows = Pair { forward: planner.plan_fft_forward(width), inverse: planner.plan_fft_inverse(width) };
    let columns = Pair { forward: planner.plan_fft_forward(height), inverse: planner.plan_fft_inverse(height) };
    let mut values = tapered(image, taper_px(blur_px));
    let half = width / 2 + 1;
    // One line per column of the half spectrum, so that the second transform runs along memory.
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
        // Real input makes these two real; rounding must not make them otherwise.
        line[0].im = 0.0;
        if width.is_multiple_of(2) {
            line[half - 1].im = 0.0;
        }
        rows.inverse.process(&mut line, values)?;
        restored.extend(values.iter().map(|value| (value * scale).round().clamp(0.0, 255.0) as u8));
    }
    Ok(GrayImage::from_raw(image.width(), image.height(), restored).unwrap_or_default())
}

/// Transforms of one length, there and back.
struct Pair {
    forward: std::sync::Arc<dyn RealToComplex<f32>>,
    inverse: std::sync::Arc<dyn ComplexToReal<f32>>,
}

/// Gain of the Wiener filter at a frequency that the motion crosses this many times; 1 at rest.
fn wiener(cycles: f32) -> f32 {
    let x = PI * cycles;
    let transfer = if x.abs() < 1e-3 { 1.0 } else { x.sin() / x };
    (1.0 + NOISE_TO_SIGNAL) * transfer / (transfer * transfer + NOISE_TO_SIGNAL)
}

/// Multiplies the spectrum of one complex column by a real gain, given as a function of the row frequency in cycles per pixel.
///
/// Only transforms of real input are at hand: with `A`, `B` those of the real and the imaginary part, the column's own is
/// `A[k] + i·B[k]` at `k` and `conj A[k] + i·conj B[k]` at `−k`.
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

/// The picture, faded to its mean over the border with a raised cosine.
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
