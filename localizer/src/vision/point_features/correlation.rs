//! The search for a patch at every place of a small region, by its correlation with the coarse image.

use crate::vision::forward::Picture;

use super::alignment::Warp;
use super::patch::{COARSE, GAIN, Template};
use super::search::Region;

/// Greatest number of places, two pixels of the image apart, at which a patch is compared.
const MOST_PLACES: usize = 1600;
/// Least zero-mean normalised cross-correlation of a peak. The coarse image and a warp that is off by a slant of 45° leave 0.7 of it.
const LEAST_ZNCC: f32 = 0.6;
/// Peaks that correlate less than this share of the best one are not returned.
const LEAST_SHARE: f32 = 0.85;
/// Greatest number of peaks.
const MOST_PEAKS: usize = 3;

/// Whether the patch may be compared at every place of a region.
pub(super) fn is_small(region: &Region) -> bool {
    let (_, [n_columns, n_rows]) = grid(region);
    n_columns.saturating_mul(n_rows) <= MOST_PLACES
}

/// The first place of a region, in pixels of the coarse image, and the numbers of places along u and along v. They are steps of one pixel of the coarse
/// image, of which pixel i is at 2i + ½; one more on each side, so that a peak on the border is one.
fn grid(region: &Region) -> ([i64; 2], [usize; 2]) {
    let [low, high] = region.hull_px;
    let first = low.map(|at| (0.5 * (at - 0.5)).floor() as i64 - 1);
    let last = high.map(|at| (0.5 * (at - 0.5)).ceil() as i64 + 1);
    (first, [0, 1].map(|axis| (last[axis] - first[axis] + 1) as usize))
}

/// Places in the region of a search at which the patch, warped as given but for its place, correlates most with the coarse image; the best first. The
/// region has to be [small](is_small).
pub(super) fn peaks(template: &Template<COARSE>, coarse: &Picture, region: &Region, warp: &Warp) -> Vec<[f64; 2]> {
    let (first, [n_columns, n_rows]) = grid(region);
    let zncc = Points::new(template, warp).zncc(coarse, first, [n_columns, n_rows]);
    let mut peaks: Vec<(f32, usize)> = Vec::new();
    for row in 1..n_rows - 1 {
        for column in 1..n_columns - 1 {
            let idx = row * n_columns + column;
            let mut around = [row - 1, row, row + 1].into_iter().flat_map(|row| {
                let first = row * n_columns + column - 1;
                first..first + 3
            });
            // Of neighbours that are exactly equal, the last one is the peak.
            let is_peak = around.all(|other| zncc[other] < zncc[idx] || zncc[other] == zncc[idx] && other <= idx);
            if zncc[idx] >= LEAST_ZNCC && is_peak {
                peaks.push((zncc[idx], idx));
            }
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let place = |idx: usize| {
        let at = [idx % n_columns, idx / n_columns];
        [0, 1].map(|axis| 2.0 * (first[axis] + at[axis] as i64) as f64 + 0.5)
    };
    let best = peaks.first().map_or(0.0, |peak| peak.0);
    peaks.retain(|peak| peak.0 >= LEAST_SHARE * best);
    peaks.into_iter().take(MOST_PEAKS).map(|(_, idx)| place(idx)).collect()
}

/// Number of neighbouring places that are compared side by side, by the vector instructions that the compiler makes of it.
const LANES: usize = 8;

/// Points of a warped patch as whole pixels of the coarse image, counted from the landmark.
struct Points {
    steps: Vec<[i64; 2]>,
    levels: Vec<f32>,
    /// Sum of the squared levels, whose mean is 0.
    squares: f32,
}

impl Points {
    fn new(template: &Template<COARSE>, warp: &Warp) -> Points {
        let m = 0.5 * warp.image_from_patch;
        // Every second point suffices to find the peak.
        let points = || template.points_px.iter().step_by(2).map(|point| point.map(f64::from));
        let steps = points()
            .map(|[x, y]| [(m.m11 * x + m.m12 * y).round() as i64, (m.m21 * x + m.m22 * y).round() as i64])
            .collect();
        let levels: Vec<f32> = template.columns[GAIN].iter().step_by(2).copied().collect();
        let mean = levels.iter().sum::<f32>() / levels.len() as f32;
        let levels: Vec<f32> = levels.iter().map(|level| level - mean).collect();
        let squares = levels.iter().map(|level| level * level).sum();
        Points { steps, levels, squares }
    }

    /// Correlations with the image around each pixel of a rectangle of `size` columns and rows, row by row; −1 where a point is outside.
    fn zncc(&self, coarse: &Picture, first: [i64; 2], size: [usize; 2]) -> Vec<f32> {
        let mut zncc = vec![-1.0; size[0] * size[1]];
        let [columns, rows] = [coarse.width, coarse.height].map(|extent| extent as i64);
        let [columns, rows] = [(0, columns), (1, rows)].map(|(axis, extent)| {
            let steps = || self.steps.iter().map(|step| step[axis]);
            let [least, greatest] = [steps().min().unwrap_or(0), steps().max().unwrap_or(0)];
            let end = (extent - greatest - first[axis]).clamp(0, size[axis] as i64);
            (-least - first[axis]).clamp(0, end)..end
        });
        for row in rows {
            // Index of the pixel under a point for the place in column 0; columns follow each other in image and result.
            let under = |[du, dv]: [i64; 2]| (first[1] + row + dv) * coarse.width as i64 + first[0] + du;
            let mut column = columns.start;
            while column < columns.end {
                let at = row as usize * size[0] + column as usize;
                // The last places of a row may be compared twice.
                if columns.end - columns.start >= LANES as i64 {
                    column = column.min(columns.end - LANES as i64);
                    let at = row as usize * size[0] + column as usize;
                    zncc[at..at + LANES]
                        .copy_from_slice(&self.side_by_side::<LANES>(coarse, |step| under(step) + column));
                    column += LANES as i64;
                } else {
                    [zncc[at]] = self.side_by_side::<1>(coarse, |step| under(step) + column);
                    column += 1;
                }
            }
        }
        zncc
    }

    /// Correlations at `N` neighbouring places of a row. `first` gives the index of the pixel under a point for the first of them.
    fn side_by_side<const N: usize>(&self, coarse: &Picture, first: impl Fn([i64; 2]) -> i64) -> [f32; N] {
        let (mut sums, mut squares, mut products) = ([0.0f32; N], [0.0f32; N], [0.0f32; N]);
        for (step, level) in self.steps.iter().zip(&self.levels) {
            let values = &coarse.values[first(*step) as usize..][..N];
            for lane in 0..N {
                let value = values[lane];
                sums[lane] += value;
                squares[lane] += value * value;
                products[lane] += value * level;
            }
        }
        std::array::from_fn(|lane| {
            let varied = squares[lane] - sums[lane] * sums[lane] / self.levels.len() as f32;
            products[lane] / (varied * self.squares).sqrt().max(1e-3)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    #[test]
    fn correlations_at_all_places_are_those_of_the_textbook_and_none_where_a_point_is_outside() {
        let mut random = Random::new(31);
        let values = (0..40 * 30).map(|_| random.between(0.0, 255.0) as f32).collect();
        let coarse = Picture { width: 40, height: 30, values };
        let mut levels: Vec<f32> = (0..20).map(|_| random.between(-50.0, 50.0) as f32).collect();
        let mean = levels.iter().sum::<f32>() / 20.0;
        levels.iter_mut().for_each(|level| *level -= mean);
        let steps = (0..20).map(|_| [random.between(-4.0, 5.0) as i64, random.between(-6.0, 3.0) as i64]).collect();
        let squares = levels.iter().map(|level| level * level).sum();
        let points = Points { steps, levels, squares };
        // Rectangles within the image, over each of its borders, narrower than what is compared side by side, and beside the image.
        for (first, size) in [
            ([6, 8], [25, 9]),
            ([-3, -5], [50, 40]),
            ([10, 10], [3, 3]),
            ([30, 20], [9, 20]),
            ([-20, 4], [8, 3]),
            ([41, 31], [3, 3]),
        ] {
            let zncc = points.zncc(&coarse, first, size);
            assert_eq!(zncc.len(), size[0] * size[1]);
            for (at, &zncc) in zncc.iter().enumerate() {
                let place = [first[0] + (at % size[0]) as i64, first[1] + (at / size[0]) as i64];
                let under: Option<Vec<f64>> = points
                    .steps
                    .iter()
                    .map(|step| {
                        let [u, v] = [0, 1].map(|axis| place[axis] + step[axis]);
                        let is_inside = (0..40).contains(&u) && (0..30).contains(&v);
                        is_inside.then(|| f64::from(coarse.at(u as usize, v as usize)))
                    })
                    .collect();
                let expected = under.map_or(-1.0, |under| {
                    let mean = under.iter().sum::<f64>() / under.len() as f64;
                    let of_both = |a: fn(f64, f64) -> f64| {
                        under.iter().zip(&points.levels).map(|(value, level)| a(value - mean, f64::from(*level))).sum()
                    };
                    let [product, one, other]: [f64; 3] =
                        [of_both(|a, b| a * b), of_both(|a, _| a * a), of_both(|_, b| b * b)];
                    product / (one * other).sqrt()
                });
                assert!((f64::from(zncc) - expected).abs() < 1e-4, "{place:?}: {zncc} {expected}");
            }
        }
    }
}
