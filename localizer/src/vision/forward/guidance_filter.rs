//! Rolling guidance filter (Zhang, Shen, Xu and Jia, ECCV 2014): it removes structures smaller than its scale and keeps edges.
//!
//! The first round is a Gaussian blur; each further round filters the *input*, guided by the result of the previous round (Eq. 4 there).
//! Rows and columns are filtered one after the other, which is exact for the Gaussian and close to exact for the guided rounds.

use super::Picture;

/// Rolling guidance filter of an image: `spatial_px` is the spatial standard deviation in pixels, `range` the standard deviation in the
/// image's values, and `rounds` the number of rounds.
pub fn rolling_guidance(input: &Picture, spatial_px: f32, range: f32, rounds: usize) -> Picture {
    filtered(input, spatial_px, range, rounds, |off| (-0.5 * off * off).exp())
}

/// Rolling guidance filter whose weight for a difference d of values, in units of `range`, is (1 − d²/16)⁸ instead of exp(−d²/2). The two differ by
/// at most 0.04, and any processor computes several of the former at a time.
pub fn rolling_guidance_at_speed(input: &Picture, spatial_px: f32, range: f32, rounds: usize) -> Picture {
    filtered(input, spatial_px, range, rounds, |off| {
        let base = (1.0 - off * off * (1.0 / 16.0)).max(0.0);
        let square = base * base;
        let fourth = square * square;
        fourth * fourth
    })
}

fn filtered(
    input: &Picture,
    spatial_px: f32,
    range: f32,
    rounds: usize,
    range_weight: impl Fn(f32) -> f32 + Copy,
) -> Picture {
    let taps: Vec<f32> = (0..=(2.0 * spatial_px).ceil() as usize)
        .map(|distance| (-0.5 * (distance as f32 / spatial_px).powi(2)).exp())
        .collect();
    // With a constant guide image every weight by difference of values is 1, so that the first round is a Gaussian blur.
    let mut guide = Picture::filled(input.width, input.height, 0.0);
    for _ in 0..rounds {
        let rows = along_rows(input, &guide, &taps, |off| range_weight(off / range));
        guide = along_columns(&rows, &guide, &taps, |off| range_weight(off / range));
    }
    guide
}

fn along_rows(input: &Picture, guide: &Picture, taps: &[f32], weighed: impl Fn(f32) -> f32) -> Picture {
    let width = input.width;
    let (mut values, mut total, mut weights) =
        (Vec::with_capacity(input.values.len()), vec![0.0; width], vec![0.0; width]);
    for (source, guide) in input.values.chunks(width.max(1)).zip(guide.values.chunks(width.max(1))) {
        let mut sum: Vec<f32> = source.iter().map(|value| value * taps[0]).collect();
        total.fill(taps[0]);
        for (distance, tap) in taps.iter().enumerate().skip(1).take_while(|(distance, _)| *distance < width) {
            let pairs = width - distance;
            for ((weight, near), far) in weights.iter_mut().zip(guide).zip(&guide[distance..]) {
                *weight = tap * weighed(near - far);
            }
            add(&mut sum[..pairs], &mut total[..pairs], &weights, &source[distance..]);
            add(&mut sum[distance..], &mut total[distance..], &weights, &source[..pairs]);
        }
        values.extend(sum.iter().zip(&total).map(|(sum, total)| sum / total));
    }
    Picture { values, ..*input }
}

fn along_columns(input: &Picture, guide: &Picture, taps: &[f32], weighed: impl Fn(f32) -> f32) -> Picture {
    let (width, height) = (input.width, input.height);
    let row = |of: &Picture, v: usize| v * of.width..(v + 1) * of.width;
    let mut sum: Vec<f32> = input.values.iter().map(|value| value * taps[0]).collect();
    let (mut total, mut weights) = (vec![taps[0]; sum.len()], vec![0.0; width]);
    for (distance, tap) in taps.iter().enumerate().skip(1).take_while(|(distance, _)| *distance < height) {
        for v in 0..height - distance {
            let (near, far) = (row(input, v), row(input, v + distance));
            for ((weight, a), b) in weights.iter_mut().zip(&guide.values[near.clone()]).zip(&guide.values[far.clone()])
            {
                *weight = tap * weighed(a - b);
            }
            add(&mut sum[near.clone()], &mut total[near.clone()], &weights, &input.values[far.clone()]);
            add(&mut sum[far.clone()], &mut total[far], &weights, &input.values[near]);
        }
    }
    Picture { values: sum.iter().zip(&total).map(|(sum, total)| sum / total).collect(), ..*input }
}

/// Adds each value of `source` times its weight to `sum`, and the weight itself to `total`, as a weighted mean needs it.
fn add(sum: &mut [f32], total: &mut [f32], weights: &[f32], source: &[f32]) {
    for (((sum, total), weight), source) in sum.iter_mut().zip(total).zip(weights).zip(source) {
        *sum += weight * source;
        *total += weight;
    }
}
