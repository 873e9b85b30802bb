//! Vote of the ridge points on straight lines: points of two orthogonal families of tile joints agree on one angle modulo 90° and, in each family, on
//! a few distances from the image's centre.

use std::f32::consts::{FRAC_PI_2, PI};

use super::ridge::RidgePoint;

/// A straight structure that is to be examined more closely: the line `{ p : n·p = offset }`, where `n` is the unit vector at the normal
/// angle and `p` is relative to the image's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) normal_rad: f64,
    pub(super) offset_px: f64,
    /// Family of the line, 0 or 1: its normal is near the angle found for the tile grid, or a right angle further.
    pub(super) family: u8,
    pub(super) dark: bool,
    /// Sum of the weights of the ridge points that lie on the candidate line.
    pub(super) support: f32,
}

/// Number of bins of the histogram of ridge directions, folded to 90°: steps of half a degree.
const ANGLE_BINS: usize = 180;
/// Greatest error of the direction at a single ridge point: a point whose normal differs by more than this from the normal of a family of lines does
/// not vote for that family.
const ORIENTATION_RAD: f32 = 0.2;
/// Greatest number of candidate lines examined per family of parallel lines. At most two tile joints of a family are in view; the rest leaves room
/// for lines that turn out to be none.
const CANDIDATES_PER_FAMILY: usize = 6;

/// Finds straight structures along and across the angle that most ridge points (points of thin dark or light lines in the image) agree on; none if
/// the image shows nothing straight.
pub(super) fn candidates(points: &[RidgePoint], cell_px: f32, size_px: [f32; 2]) -> Vec<Candidate> {
    let angle_rad = peak_angle(points);
    let families = [0.0, FRAC_PI_2].map(|turn| family_points(points, angle_rad + turn));
    let angle_rad = sharpened(&families, angle_rad, cell_px, size_px);
    let mut candidates = Vec::new();
    for (family, points) in families.iter().enumerate() {
        let normal_rad = angle_rad + family as f32 * FRAC_PI_2;
        let mut found: Vec<Candidate> = Vec::new();
        for (dark, histogram) in offsets(points, normal_rad, cell_px, size_px).iter().enumerate() {
            found.extend(peaks(histogram, points, normal_rad, dark == 1, cell_px, size_px));
        }
        found.sort_by(|a, b| b.support.total_cmp(&a.support));
        let mut distinct: Vec<Candidate> = Vec::new();
        for candidate in found {
            // A strong ridge in the image has weak ridges of the opposite polarity (light or dark) beside it, and one ridge may have been found
            // twice. A candidate beside a stronger one is therefore dropped.
            let beside = |known: &Candidate| {
                (known.offset_px - candidate.offset_px).abs()
                    < f64::from(if known.dark == candidate.dark { cell_px } else { 4.0 * cell_px })
            };
            if distinct.len() < CANDIDATES_PER_FAMILY && !distinct.iter().any(beside) {
                distinct.push(Candidate { family: family as u8, ..candidate });
            }
        }
        candidates.extend(distinct);
    }
    candidates
}

/// Removes the ridge points (points of thin dark or light lines) near a candidate line, so that they do not vote for further lines.
pub(super) fn remove(points: &mut Vec<RidgePoint>, candidate: &Candidate, reach_px: f32) {
    let (sin, cos) = (candidate.normal_rad as f32).sin_cos();
    let offset_px = candidate.offset_px as f32;
    points.retain(|point| (point.position_px[0] * cos + point.position_px[1] * sin - offset_px).abs() > reach_px);
}

/// Peak of the histogram of the ridge points' normal angles modulo 90°.
fn peak_angle(points: &[RidgePoint]) -> f32 {
    let mut histogram = [0f32; ANGLE_BINS];
    for point in points {
        let turn = point.normal_rad.rem_euclid(FRAC_PI_2) / FRAC_PI_2;
        histogram[((turn * ANGLE_BINS as f32) as usize).min(ANGLE_BINS - 1)] += point.weight;
    }
    // The histogram of angles is smoothed with a triangle of ±3°, about the error of direction of the ridge points that matter.
    const REACH: i32 = 6;
    let smooth = |bin: usize| -> f32 {
        (-REACH..=REACH)
            .map(|k| (REACH + 1 - k.abs()) as f32 * histogram[(bin as i32 + k).rem_euclid(ANGLE_BINS as i32) as usize])
            .sum()
    };
    let sums: Vec<f32> = (0..ANGLE_BINS).map(smooth).collect();
    let peak = (0..ANGLE_BINS).max_by(|&a, &b| sums[a].total_cmp(&sums[b])).unwrap_or(0);
    (peak as f32 + 0.5) * FRAC_PI_2 / ANGLE_BINS as f32
}

/// Histogram of one family of parallel lines and one polarity (light or dark): the summed weights of the ridge points by their offset, which is their
/// distance from the image's centre along the family's normal.
struct OffsetHistogram {
    weights: Vec<f32>,
    bin_px: f32,
    reach_px: f32,
}

impl OffsetHistogram {
    fn new(size_px: [f32; 2], bin_px: f32) -> Self {
        let reach_px = 0.5 * size_px[0].hypot(size_px[1]) + 2.0 * bin_px;
        OffsetHistogram { weights: vec![0.0; (2.0 * reach_px / bin_px) as usize + 1], bin_px, reach_px }
    }

    fn add(&mut self, offset_px: f32, weight: f32) {
        let bin = ((offset_px + self.reach_px) / self.bin_px) as usize;
        if let Some(sum) = self.weights.get_mut(bin) {
            *sum += weight;
        }
    }

    /// Summed weight of the ridge points in bins `bin` and `bin + 1` of the offset histogram: the support for a line between these bins' middles.
    fn pair(&self, bin: usize) -> f32 {
        self.weights[bin] + self.weights[bin + 1]
    }

    fn energy(&self) -> f32 {
        (0..self.weights.len() - 1).map(|bin| self.pair(bin) * self.pair(bin)).sum()
    }

    /// Offset at the boundary between bins `bin` and `bin + 1`, which is the middle of the two.
    fn offset_px(&self, bin: usize) -> f32 {
        (bin + 1) as f32 * self.bin_px - self.reach_px
    }
}

/// Angle between a point's normal and a given angle, both known modulo half a turn; it lies in `[0, π/2]`.
fn between(normal_rad: f32, angle_rad: f32) -> f32 {
    let difference = (normal_rad - angle_rad).rem_euclid(PI);
    difference.min(PI - difference)
}

/// Ridge points whose normal is near the given angle: those that may lie on a line of that family of parallel lines.
fn family_points(points: &[RidgePoint], normal_rad: f32) -> Vec<RidgePoint> {
    points.iter().filter(|point| between(point.normal_rad, normal_rad) < ORIENTATION_RAD).copied().collect()
}

/// Histograms of the offsets of one family's ridge points (distances from the image's centre along the family's normal), by polarity: `[light,
/// dark]`.
fn offsets(family: &[RidgePoint], normal_rad: f32, cell_px: f32, size_px: [f32; 2]) -> [OffsetHistogram; 2] {
    let (sin, cos) = normal_rad.sin_cos();
    let mut histograms = [(); 2].map(|()| OffsetHistogram::new(size_px, 0.75 * cell_px));
    for point in family {
        histograms[usize::from(point.dark)].add(cos * point.position_px[0] + sin * point.position_px[1], point.weight);
    }
    histograms
}

/// Angle near `angle_rad` at which the ridge points of both families of parallel lines fall into the fewest and fullest bins of offset.
fn sharpened(families: &[Vec<RidgePoint>; 2], angle_rad: f32, cell_px: f32, size_px: [f32; 2]) -> f32 {
    let energy = |angle_rad: f32| -> f32 {
        let of_family =
            |family: usize| offsets(&families[family], angle_rad + family as f32 * FRAC_PI_2, cell_px, size_px);
        [0, 1].into_iter().flat_map(of_family).map(|histogram| histogram.energy()).sum()
    };
    // When the angle is wrong by up to half a degree, the points of a line across the whole image still fall into one bin of offsets. Angles tried at
    // steps of 0.4° therefore cannot miss the peak.
    let tried: Vec<(f32, f32)> =
        (-8..=8).map(|step| angle_rad + 0.007 * step as f32).map(|angle_rad| (angle_rad, energy(angle_rad))).collect();
    tried.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(angle_rad, |best| best.0)
}

/// Least support of a line, per cell of the binned image along the line's visible part: this share of the cells must have voted for the line if every
/// vote has the least weight, 1.
const LEAST_COVER: f32 = 0.3;
/// Least length of a line's visible part, in image cells: a shorter line cuts a corner of the image and does not determine a direction.
const LEAST_CELLS: f32 = 12.0;

/// Local maxima of the offset histogram that enough ridge points support for the length of the line in the image, each refined by a straight fit to
/// its ridge points.
fn peaks(
    histogram: &OffsetHistogram,
    points: &[RidgePoint],
    normal_rad: f32,
    dark: bool,
    cell_px: f32,
    size_px: [f32; 2],
) -> Vec<Candidate> {
    let last = histogram.weights.len() - 1;
    let mut found = Vec::new();
    for bin in 3..last - 3 {
        let support = histogram.pair(bin);
        let highest = (bin - 3..bin).all(|near| histogram.pair(near) < support)
            && (bin + 1..=bin + 3).all(|near| histogram.pair(near) <= support);
        if support < LEAST_COVER * LEAST_CELLS || !highest {
            continue;
        }
        let offset_px = histogram.offset_px(bin);
        let cells = chord_px(normal_rad, offset_px, size_px) / cell_px;
        if cells < LEAST_CELLS || support < LEAST_COVER * cells {
            continue;
        }
        if let Some((normal_rad, offset_px)) = fit(points, normal_rad, offset_px, dark, cell_px) {
            found.push(Candidate {
                normal_rad: f64::from(normal_rad),
                offset_px: f64::from(offset_px),
                family: 0,
                dark,
                support,
            });
        }
    }
    found
}

/// Length of the part of a line that lies in the image.
fn chord_px(normal_rad: f32, offset_px: f32, size_px: [f32; 2]) -> f32 {
    let (sin, cos) = normal_rad.sin_cos();
    let (mut from, mut to) = (-f32::MAX, f32::MAX);
    for (foot, along, half) in [(offset_px * cos, -sin, 0.5 * size_px[0]), (offset_px * sin, cos, 0.5 * size_px[1])] {
        if along.abs() < 1e-6 {
            if foot.abs() > half {
                return 0.0;
            }
            continue;
        }
        let (a, b) = ((-half - foot) / along, (half - foot) / along);
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (to - from).max(0.0)
}

/// Weighted straight fit to the ridge points near a line, made twice, the second time to nearer points only; returns `(normal angle, offset)`.
fn fit(points: &[RidgePoint], mut normal_rad: f32, mut offset_px: f32, dark: bool, cell_px: f32) -> Option<(f32, f32)> {
    for reach_px in [1.5 * cell_px, cell_px] {
        let (sin, cos) = normal_rad.sin_cos();
        let (mut w, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for point in points.iter().filter(|point| point.dark == dark) {
            let [u, v] = point.position_px;
            let (along, across) = (cos * v - sin * u, cos * u + sin * v - offset_px);
            if across.abs() < reach_px {
                w += point.weight;
                x += point.weight * along;
                y += point.weight * across;
                xx += point.weight * along * along;
                xy += point.weight * along * across;
            }
        }
        let spread = xx * w - x * x;
        if w <= 0.0 || spread <= w * w * cell_px * cell_px {
            return None;
        }
        let slope = (xy * w - x * y) / spread;
        let intercept = (y - slope * x) / w;
        // Since across = slope·along + intercept in the fit, the line's normal turns by −atan(slope).
        normal_rad -= slope.atan();
        offset_px = (offset_px + intercept) * slope.atan().cos();
    }
    Some((normal_rad, offset_px))
}
