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

/// Places in the region of a search at which the patch, warped as given but for its place, correlates most with the coarse image; the best first.
/// None are returned if the region is too large for that.
pub(super) fn peaks(template: &Template<COARSE>, coarse: &Picture, region: &Region, warp: &Warp) -> Vec<[f64; 2]> {
    let [low, high] = region.hull_px;
    // Steps of one pixel of the coarse image, of which pixel i is at 2i + ½; one more on each side, so that a peak on the border is one.
    let first = low.map(|at| (0.5 * (at - 0.5)).floor() as i64 - 1);
    let last = high.map(|at| (0.5 * (at - 0.5)).ceil() as i64 + 1);
    let n_columns = (last[0] - first[0] + 1) as usize;
    let n_rows = (last[1] - first[1] + 1) as usize;
    if n_columns.saturating_mul(n_rows) > MOST_PLACES {
        return Vec::new();
    }
    let points = Points::new(template, warp);
    let places = (0..n_rows).flat_map(|row| (0..n_columns).map(move |column| [column, row]));
    let zncc: Vec<f32> =
        places.map(|[column, row]| points.zncc(coarse, [first[0] + column as i64, first[1] + row as i64])).collect();
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

    /// Correlation with the image around a pixel; −1 where a point is outside.
    fn zncc(&self, coarse: &Picture, [column, row]: [i64; 2]) -> f32 {
        let (width, height) = (coarse.width as i64, coarse.height as i64);
        let (mut sum, mut squares, mut products) = (0.0, 0.0, 0.0);
        for ([du, dv], level) in self.steps.iter().zip(&self.levels) {
            let (u, v) = (column + du, row + dv);
            if u < 0 || v < 0 || u >= width || v >= height {
                return -1.0;
            }
            let value = coarse.values[(v * width + u) as usize];
            sum += value;
            squares += value * value;
            products += value * level;
        }
        let varied = squares - sum * sum / self.levels.len() as f32;
        products / (varied * self.squares).sqrt().max(1e-3)
    }
}
