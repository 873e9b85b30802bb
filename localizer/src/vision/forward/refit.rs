//! Measures where a straight edge runs in the unfiltered image, and how accurately that is known.
//!
//! The edge is moved and turned until the gradient across it, summed along it, is greatest: for a step in homogeneous
//! noise this is the position of maximum likelihood.

use std::ops::Range;

use super::{EdgeLine, Picture, Segment};

/// Half of the width of the derivative filter's window across an edge of the image.
const BAND_PX: f64 = 5.0;
/// Greatest distance by which the refinement moves an edge at either of its ends.
const MOVED_PX: f64 = 3.0;
/// Step between the offsets that are tried for an edge's ends; the remaining fraction comes from a parabola.
const STEP_PX: f64 = 0.5;
/// Number of slices into which an edge is divided along its length.
const SLICES: usize = 16;
/// Standard deviation of the Gaussian whose derivative is the filter laid across an edge in the image.
const ACROSS_PX: f64 = 1.2;
/// Distance of a real edge from the straight line that represents it even without noise, caused by pixels, the lens map and rounded corners of walls.
/// Of 254 edges with noise below 0.04 px in rendered rooms, 98 % were within 0.11 px.
const SYSTEMATIC_PX: f64 = 0.1;
/// Number of standard deviations of noise in the bound of an edge's ends.
const DEVIATIONS: f64 = 2.5;
/// Straightness test: greatest distance of any quarter of an edge from the straight line through the whole edge, before the allowance for noise is
/// added.
const STRAIGHT_PX: f64 = 0.15;
/// Straightness test of an edge's quarters: allowance for noise, in standard deviations of noise. The painted outline of a hill on a wall exceeds
/// distance and allowance together and is thus rejected.
const BENT_DEVIATIONS: f64 = 3.0;
/// Number of parts of an edge (quarters) that are tested for straightness.
const PARTS: usize = 4;
/// An edge whose error bound is greater than this is discarded, because it says too little.
const WIDEST_PX: f64 = 2.0;

/// Measures the position of a segment again in an image whose noise has standard deviation 1. `None` if no edge stands out near the segment, the edge
/// leaves the searched band, or it is not straight.
pub fn refit(picture: &Picture, segment: &Segment) -> Option<EdgeLine> {
    let profiles = responses(picture, segment);
    let (at_ends, response) = steepest(&profiles)?;
    // For a step of brightness of height A, the edge filter's response is A times the Gaussian's peak value.
    let step = response.abs() * ACROSS_PX * (2.0 * std::f64::consts::PI).sqrt();
    // Cramér–Rao bound: one pixel of the length of an edge that is blurred by a Gaussian of standard deviation s determines the edge's
    // position with variance 2√π·s/A². At an end of a straight line the variance is four times that of its middle.
    let variance = 4.0 * 2.0 * std::f64::consts::PI.sqrt() * ACROSS_PX / (step * step * segment.length_px());
    let bound_px = SYSTEMATIC_PX + DEVIATIONS * variance.sqrt();
    // The middle of a quarter of an edge is known as accurately as an end of the whole edge, so that the same variance serves for the straightness
    // test.
    if bound_px > WIDEST_PX || bend_px(&profiles, at_ends) > STRAIGHT_PX + BENT_DEVIATIONS * variance.sqrt() {
        return None;
    }
    let along = segment.along();
    let moved = [0, 1].map(|end| {
        let [u, v] = segment.ends_px[end];
        [u - at_ends[end] * along[1], v + at_ends[end] * along[0]]
    });
    Some(EdgeLine { ends_px: moved, bound_px })
}

/// Of edges that run beside each other keeps only the longest: the two sides of a door frame count as one line, because they are right or wrong
/// together.
pub fn drop_repeats(lines: &mut Vec<EdgeLine>) {
    /// Distance between two edges below which they count as sides of the same door frame or skirting board.
    const BESIDE_PX: f64 = 10.0;
    lines.sort_by(|a, b| length(b).total_cmp(&length(a)));
    let mut kept: Vec<EdgeLine> = Vec::new();
    for line in lines.drain(..) {
        if !kept.iter().any(|other| line.ends_px.iter().all(|end| distance(*end, other) < BESIDE_PX)) {
            kept.push(line);
        }
    }
    *lines = kept;
}

/// Number of offsets across the edge that are tried, at each of which the response of the gradient filter is computed.
fn offsets() -> usize {
    (2.0 * MOVED_PX / STEP_PX) as usize + 1
}

/// For each slice along the edge, the gradient across the edge at each tried offset from −`MOVED_PX` to `MOVED_PX`, averaged over the slice.
fn responses(picture: &Picture, segment: &Segment) -> Vec<Vec<f64>> {
    let (along, length) = (segment.along(), segment.length_px());
    let samples = ((length / SLICES as f64).round() as usize).max(1);
    let reach = BAND_PX + MOVED_PX;
    let fine = (2.0 * reach / STEP_PX) as usize + 1;
    let taps: Vec<f64> = (0..=(2.0 * BAND_PX / STEP_PX) as usize)
        .map(|tap| {
            let at = tap as f64 * STEP_PX - BAND_PX;
            let peak = 1.0 / (ACROSS_PX * (2.0 * std::f64::consts::PI).sqrt());
            at / ACROSS_PX.powi(2) * peak * (-0.5 * (at / ACROSS_PX).powi(2)).exp() * STEP_PX
        })
        .collect();
    (0..SLICES)
        .map(|slice| {
            let mut profile = vec![0.0; fine];
            for sample in 0..samples {
                let on = (slice as f64 + (sample as f64 + 0.5) / samples as f64) / SLICES as f64 * length;
                let [u, v] = segment.ends_px[0];
                let (u, v) = (u + on * along[0], v + on * along[1]);
                for (idx, value) in profile.iter_mut().enumerate() {
                    let off = idx as f64 * STEP_PX - reach;
                    *value += picture.between(u - off * along[1], v + off * along[0]) / samples as f64;
                }
            }
            let response = |at: usize| taps.iter().zip(&profile[at..]).map(|(tap, value)| tap * value).sum();
            (0..offsets()).map(response).collect()
        })
        .collect()
}

/// Offsets of the edge's two ends, across the edge, at which the mean gradient is steepest, and that gradient. `None` if the best offsets lie at the
/// limit of the tried range.
fn steepest(profiles: &[Vec<f64>]) -> Option<([f64; 2], f64)> {
    let last = offsets() - 1;
    let mean = |first: f64, end: f64| mean_along(profiles, 0..SLICES, first, end);
    // The edge sought has the polarity (dark to light or light to dark) that the image shows at the segment itself, in the middle of the searched
    // band.
    let sign = mean(last as f64 / 2.0, last as f64 / 2.0).signum();
    let mut best = (0, 0, f64::NEG_INFINITY);
    for first in 0..=last {
        for end in 0..=last {
            let value = sign * mean(first as f64, end as f64);
            if value > best.2 {
                best = (first, end, value);
            }
        }
    }
    let (first, end, value) = best;
    if first == 0 || end == 0 || first == last || end == last {
        return None;
    }
    let (x, y) = (first as f64, end as f64);
    // The sum and the difference of the offsets of the edge's two ends hardly depend on each other, so that each of them is refined alone.
    let common = vertex(|by| sign * mean(x + by, y + by));
    let turned = vertex(|by| sign * mean(x + by, y - by));
    let px = |steps: f64| steps * STEP_PX - MOVED_PX;
    Some(([px(x + common + turned), px(y + common - turned)], sign * value))
}

/// Greatest distance, over the quarters of an edge, between the place where the gradient of a quarter is steepest and the straight line with its ends
/// at the given offsets. Distances are limited to `STEP_PX`.
fn bend_px(profiles: &[Vec<f64>], at_ends_px: [f64; 2]) -> f64 {
    let [first, end] = at_ends_px.map(|at_px| (at_px + MOVED_PX) / STEP_PX);
    let sign = mean_along(profiles, 0..SLICES, first, end).signum();
    let parts = (0..PARTS).map(|part| part * SLICES / PARTS..(part + 1) * SLICES / PARTS);
    parts
        .map(|part| vertex(|by| sign * mean_along(profiles, part.clone(), first + by, end + by)).abs() * STEP_PX)
        .fold(0.0, f64::max)
}

/// Mean gradient of some slices of the edge along a straight line across the searched band: its offset is `first` at the edge's first end and `end`
/// at its last, counted in steps of `STEP_PX`.
fn mean_along(profiles: &[Vec<f64>], slices: Range<usize>, first: f64, end: f64) -> f64 {
    let last = offsets() - 1;
    let n_slices = slices.len() as f64;
    let responses = slices.map(|slice| {
        let share = (slice as f64 + 0.5) / SLICES as f64;
        let at = first + share * (end - first);
        let below = (at.max(0.0) as usize).min(last - 1);
        let profile = &profiles[slice];
        profile[below] + (at - below as f64) * (profile[below + 1] - profile[below])
    });
    responses.sum::<f64>() / n_slices
}

/// Position of the vertex of the parabola through the values of a function at −1, 0 and 1; limited to that range.
fn vertex(value: impl Fn(f64) -> f64) -> f64 {
    let [below, at, above] = [value(-1.0), value(0.0), value(1.0)];
    let bend = below - 2.0 * at + above;
    if bend >= 0.0 { 0.0 } else { (0.5 * (below - above) / bend).clamp(-1.0, 1.0) }
}

fn length(line: &EdgeLine) -> f64 {
    Segment { ends_px: line.ends_px }.length_px()
}

/// Distance of a point from the straight line through another edge, if that edge runs beside the point; infinite otherwise.
fn distance(point: [f64; 2], line: &EdgeLine) -> f64 {
    let segment = Segment { ends_px: line.ends_px };
    let ([u, v], along) = (line.ends_px[0], segment.along());
    let (du, dv) = (point[0] - u, point[1] - v);
    let on = du * along[0] + dv * along[1];
    if (-10.0..=segment.length_px() + 10.0).contains(&on) {
        (dv * along[0] - du * along[1]).abs()
    } else {
        f64::INFINITY
    }
}
