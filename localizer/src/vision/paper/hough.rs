//! Standard Hough transform of a skeleton image (paper 1, equations (11) to (13)).

use std::f64::consts::{FRAC_PI_2, PI};

use super::Binary;

/// A line `u·cos ϑ + v·sin ϑ = r` (11) found by the Hough transform, in pixels from the first pixel, with its number of votes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    /// Signed distance of the first pixel from the line, in `[−r_max, r_max]` (12).
    pub(super) r_px: f64,
    /// Angle from the u axis to the line's perpendicular, in `[−π/2, π/2)`.
    pub(super) angle_rad: f64,
    pub(super) votes: u32,
}

/// Number of angles N_ϑ of the Hough transform, in steps of a quarter of a degree. Half of a step is 0.7 px at the end of a line across the image.
const ANGLES: usize = 720;
/// Width of a cell of the Hough accumulator in the distance r: one pixel, as wide as the skeleton.
const CELL_PX: f64 = 1.0;

/// Cells of the Hough accumulator that have at least `votes_min` votes and no neighbour with more, sorted by decreasing votes.
pub(super) fn peaks(skeleton: &Binary, votes_min: u32) -> Vec<Peak> {
    // By equation (12) of paper 1, the signed distances of lines in the Hough transform lie between r_min = −r_max and r_max = √(µ² + ν²), for an
    // image of µ × ν pixels.
    let r_max_px = (skeleton.width as f64).hypot(skeleton.height as f64);
    let cells = (2.0 * r_max_px / CELL_PX).ceil() as usize + 1;
    let white: Vec<(f64, f64)> = (0..skeleton.pixels.len())
        .filter(|&index| skeleton.pixels[index])
        .map(|index| ((index % skeleton.width) as f64, (index / skeleton.width) as f64))
        .collect();
    // By equations (13a) and (13b) of paper 1, row i of the accumulator is an angle and column j a distance.
    let mut accumulator = vec![0u32; ANGLES * cells];
    for (i, row) in accumulator.chunks_exact_mut(cells).enumerate() {
        let (sin, cos) = angle_rad(i).sin_cos();
        for &(u, v) in &white {
            let j = ((u * cos + v * sin + r_max_px) / CELL_PX + 0.5) as usize;
            row[j] += 1;
        }
    }
    let mut peaks = Vec::new();
    for i in 0..ANGLES {
        for j in 1..cells - 1 {
            let votes = accumulator[i * cells + j];
            if votes >= votes_min && is_highest(&accumulator, cells, i, j) {
                peaks.push(Peak { r_px: j as f64 * CELL_PX - r_max_px, angle_rad: angle_rad(i), votes });
            }
        }
    }
    peaks.sort_by_key(|peak| std::cmp::Reverse(peak.votes));
    peaks
}

fn angle_rad(i: usize) -> f64 {
    i as f64 * PI / ANGLES as f64 - FRAC_PI_2
}

/// Whether no neighbouring cell of the Hough accumulator has more votes. Beyond the first and the last angle, a line's distance r changes its sign.
fn is_highest(accumulator: &[u32], cells: usize, i: usize, j: usize) -> bool {
    let votes = accumulator[i * cells + j];
    let row = |step: usize| {
        // Neighbouring row of the accumulator: for step 0, 1 or 2 the row before, the same row or the next one. Rows are angles over half a
        // turn, and a line whose angle wraps around has its distance r mirrored.
        let angle = i + step;
        if angle == 0 {
            (ANGLES - 1, true)
        } else if angle == ANGLES + 1 {
            (0, true)
        } else {
            (angle - 1, false)
        }
    };
    (0..3).all(|step| {
        let (angle, mirrored) = row(step);
        (j - 1..=j + 1).all(|near| accumulator[angle * cells + if mirrored { cells - 1 - near } else { near }] <= votes)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawn_line_is_the_highest_peak() {
        // The test image shows the line u·cos 30° + v·sin 30° = 120 with one pixel per row.
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let mut picture = Binary { width: 200, height: 150, pixels: vec![false; 30_000] };
        for v in 1..149 {
            let u = ((120.0 - v as f64 * sin) / cos).round();
            picture.pixels[v * 200 + u as usize] = true;
        }
        let best = peaks(&picture, 50)[0];
        assert!((best.r_px - 120.0).abs() <= CELL_PX);
        assert!((best.angle_rad - 30.0_f64.to_radians()).abs() <= 2.0 * PI / ANGLES as f64);
    }
}
