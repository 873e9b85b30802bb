//! Rolling guidance filter (Zhang, Shen, Xu and Jia, ECCV 2014): takes away what is smaller than its scale and keeps edges.
//!
//! Round 1 is a Gaussian blur; each further round filters the *input*, guided by what the last round gave (their Eq. 4). Rows
//! and columns are filtered one after the other, which is exact for the Gaussian and close to it for the guided rounds.

use super::Picture;

/// Steps of the table of range weights for each standard deviation.
const STEPS: f32 = 32.0;
/// Beyond as many standard deviations a weight is zero.
const REACH: f32 = 4.0;

/// The filter with a spatial standard deviation in pixels, a range standard deviation in the picture's values, and rounds.
pub fn rolling_guidance(input: &Picture, spatial_px: f32, range: f32, rounds: usize) -> Picture {
    let taps: Vec<f32> = (0..=(2.0 * spatial_px).ceil() as usize)
        .map(|distance| (-0.5 * (distance as f32 / spatial_px).powi(2)).exp())
        .collect();
    let table: Vec<f32> =
        (0..=(REACH * STEPS) as usize).map(|step| (-0.5 * (step as f32 / STEPS).powi(2)).exp()).collect();
    // A constant guide makes every range weight 1.
    let mut guide = Picture::filled(input.width, input.height, 0.0);
    for _ in 0..rounds {
        let rows = along_rows(input, &guide, &taps, &table, STEPS / range);
        let columns = along_rows(&transposed(&rows), &transposed(&guide), &taps, &table, STEPS / range);
        guide = transposed(&columns);
    }
    guide
}

fn along_rows(input: &Picture, guide: &Picture, taps: &[f32], table: &[f32], steps_per_value: f32) -> Picture {
    let (width, reach) = (input.width, taps.len() - 1);
    let mut values = vec![0.0; input.values.len()];
    for ((source, guide), target) in
        input.values.chunks(width).zip(guide.values.chunks(width)).zip(values.chunks_mut(width))
    {
        for (u, value) in target.iter_mut().enumerate() {
            let (first, last) = (u.saturating_sub(reach), (u + reach).min(width - 1));
            let (mut sum, mut weights) = (0.0_f32, 0.0_f32);
            for other in first..=last {
                let step = ((guide[other] - guide[u]).abs() * steps_per_value) as usize;
                let weight = taps[other.abs_diff(u)] * table[step.min(table.len() - 1)];
                sum += weight * source[other];
                weights += weight;
            }
            *value = sum / weights;
        }
    }
    Picture { values, ..*input }
}

fn transposed(picture: &Picture) -> Picture {
    let (width, height) = (picture.height, picture.width);
    let mut values = vec![0.0; picture.values.len()];
    for (v, row) in picture.values.chunks(picture.width).enumerate() {
        for (u, &value) in row.iter().enumerate() {
            values[u * width + v] = value;
        }
    }
    Picture { width, height, values }
}
