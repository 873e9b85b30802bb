//! Set-membership fit of a line to points: encloses all lines that are within the error bounds of most of the points, without omitting any.

mod level;

use interval::Interval;

use self::level::{Leaf, Level};

/// Set of the lines `{ p : n(φ)·(p − centroid) = offset }`, with `n(φ) = (cos φ, sin φ)`, that are within the bounds of enough points.
///
/// Angles are real numbers near [`direction_rad`](Self::direction_rad), not wrapped; the same line at `φ + π` with the
/// opposite offset is not listed a second time.
#[derive(Clone, Debug, PartialEq)]
pub struct LineSet {
    /// Point from which the offsets of the fitted lines are counted, near the middle of the points.
    pub centroid_px: [f64; 2],
    /// Best estimate of the angle of the fitted line's normal, in `(-π/2, π/2]`; the best estimate of the offset is 0.
    pub direction_rad: f64,
    /// Hull of the normal's angle over all lines that fit the points: `[least, greatest]`.
    pub normal_angle_rad: [f64; 2],
    /// Hull of the offset over all lines that fit the points: `[least, greatest]`.
    pub offset_px: [f64; 2],
    /// Slices (ranges of angle and offset) that together enclose all lines that fit the points, by ascending angle.
    slices: Vec<Slice>,
}

/// A range of normal angles with a range of offsets: every line that fits the points and whose normal angle lies in
/// `angle_rad` has its offset in `offset_px`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slice {
    angle_rad: [f64; 2],
    offset_px: [f64; 2],
}

impl LineSet {
    /// Hull of the offset over the lines that fit the points and whose normal angle lies in `[normal_angle_lo, normal_angle_hi]`; `None` if no line
    /// with such an angle fits.
    pub fn offset_at(&self, normal_angle_lo: f64, normal_angle_hi: f64) -> Option<[f64; 2]> {
        let touches = |slice: &&Slice| slice.angle_rad[0] <= normal_angle_hi && slice.angle_rad[1] >= normal_angle_lo;
        self.slices.iter().filter(touches).map(|slice| slice.offset_px).reduce(hull)
    }
}

/// Point of an image with the direction in which it is uncertain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePoint {
    /// Where the best estimate of the line passes, `[u, v]`.
    pub at_px: [f64; 2],
    /// Unit normal of the best estimate.
    pub normal: [f64; 2],
    /// Distances from `at_px` along the normal at which lines that fit the points pass.
    pub across_px: Interval,
}

impl LineSet {
    /// Where the lines that fit the points cross the normal of the best estimate that is `along_px` from the centroid.
    ///
    /// A line of normal angle φ and offset o passes at o/cos(φ₀ − φ) + along·tan(φ₀ − φ), with φ₀ the angle of the best estimate.
    pub fn crossing(&self, along_px: f64) -> LinePoint {
        let (sin, cos) = self.direction_rad.sin_cos();
        let across = |slice: &Slice| {
            let angle = Interval::point(self.direction_rad) - Interval::new(slice.angle_rad[0], slice.angle_rad[1]);
            let offset = Interval::new(slice.offset_px[0], slice.offset_px[1]);
            offset / angle.cos() + angle.tan() * along_px
        };
        let across_px = self.slices.iter().map(across).fold(Interval::EMPTY, Interval::hull);
        let at_px = [self.centroid_px[0] - along_px * sin, self.centroid_px[1] + along_px * cos];
        LinePoint { at_px, normal: [cos, sin], across_px: across_px.inflate(ROUNDING) }
    }

    /// Distance of a point of the image from the centroid along the best estimate.
    pub fn along_px(&self, [u, v]: [f64; 2]) -> f64 {
        let (sin, cos) = self.direction_rad.sin_cos();
        (v - self.centroid_px[1]) * cos - (u - self.centroid_px[0]) * sin
    }
}

/// Tangent of the greatest angle between a line that fits the points and the best estimate. If the points span too short a line to bound the angle
/// better, the fit gives no result; small angles also keep the local coordinates accurate.
const SLOPE_MAX: f64 = 0.2;
/// A range of slopes is bisected as long as its width would widen the lines' offsets by more than this.
const SLACK_PX: f64 = 0.06;
/// Absolute margin for rounding errors: coordinates below [`FARTHEST_PX`] have a spacing of 10⁻¹¹, and each passes through few operations.
const ROUNDING: f64 = 1e-9;
/// Coordinates and bounds must be less than this in magnitude: the margin for rounding errors would not cover those of greater ones.
const FARTHEST_PX: f64 = 1e5;

/// Encloses all lines that are within their bound of at least `n − ⌊share_wrong·n⌋` of the `n` points `[u, v, bound]`.
///
/// In local coordinates, x along and y across a first estimate, such a line `y = m·x + b` satisfies `|y_i − m·x_i − b| ≤ e_i·√(1 + m²)` for at
/// least K points; these lines form the K-level of the arrangement of bounding lines. Over a small range of slopes each point allows one interval
/// of `b`, so that a sweep encloses the intercepts that K points allow; ranges of slopes are bisected, and dropped where no line is left.
///
/// `None` if no line is near enough to that many points, if the points are too few or too close together to bound the direction, or if a coordinate
/// or bound is 10⁵ px or more.
pub fn enclose(points: &[[f64; 3]], share_wrong: f64) -> Option<LineSet> {
    let count = points.len();
    // The number of points that may be wrong, a share of all, is rounded down. The product is increased slightly before that, so that rounding errors
    // can only allow one more wrong point, never one less.
    let wrong = (share_wrong * count as f64 + ROUNDING).floor() as usize;
    let needed = count.checked_sub(wrong)?;
    if count < 2 || needed < 2 || !points.iter().flatten().all(|value| value.abs() < FARTHEST_PX) {
        return None;
    }
    let (centroid_px, direction_rad) = estimate(points, needed)?;
    let (sin, cos) = direction_rad.sin_cos();
    let mut local: Vec<[f64; 3]> = points
        .iter()
        .map(|&[u, v, bound_px]| {
            let (u, v) = (u - centroid_px[0], v - centroid_px[1]);
            [v * cos - u * sin, u * cos + v * sin, bound_px]
        })
        .collect();
    let slope_max = greatest_slope(&local, needed)?;
    let widening = (1.0 + slope_max * slope_max).sqrt();
    for point in &mut local {
        point[2] = point[2] * widening + ROUNDING;
    }
    let leaves = Level::new(&local, needed).leaves([-slope_max, slope_max], SLACK_PX);
    // A greater slope of the line is a smaller angle of its normal, hence the reversed order.
    let slices: Vec<Slice> = leaves.iter().rev().map(|leaf| slice(leaf, direction_rad)).collect();
    let offset_px = slices.iter().map(|slice| slice.offset_px).reduce(hull)?;
    let normal_angle_rad = slices.iter().map(|slice| slice.angle_rad).reduce(hull)?;
    Some(LineSet { centroid_px, direction_rad, normal_angle_rad, offset_px, slices })
}

fn hull(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Converts slopes `[m₀, m₁]` and intercepts `[b₀, b₁]` from local coordinates to normal angles and offsets:
/// `φ = φ₀ − atan m`, `offset = b·cos(atan m)`.
fn slice(leaf: &Leaf, direction_rad: f64) -> Slice {
    let ([slope_from, slope_to], [low_px, high_px]) = (leaf.slope, leaf.intercept_px);
    let angle_rad =
        [direction_rad - slope_to.atan() - ROUNDING * 1e-3, direction_rad - slope_from.atan() + ROUNDING * 1e-3];
    let steepest = slope_from.abs().max(slope_to.abs());
    let shrink = 1.0 / (1.0 + steepest * steepest).sqrt();
    let offset_px = [low_px.min(low_px * shrink) - ROUNDING, high_px.max(high_px * shrink) + ROUNDING];
    Slice { angle_rad, offset_px }
}

/// Estimates a line near most of the points: its centroid and the angle of its normal. The best of the lines through some pairs of points comes
/// first, then least squares through the points nearest to it.
fn estimate(points: &[[f64; 3]], needed: usize) -> Option<([f64; 2], f64)> {
    let count = points.len();
    let mut best: Option<(usize, [f64; 2], f64)> = None;
    // If the list of points runs along the line, two points half of the list apart are far from each other. Of ten such pairs, at least one almost
    // certainly consists of two correct points.
    let stride = (count / 20).max(1);
    for first in (0..count - count / 2).step_by(stride) {
        let (a, b) = (points[first], points[first + count / 2]);
        let normal_rad = (a[0] - b[0]).atan2(b[1] - a[1]);
        let (sin, cos) = normal_rad.sin_cos();
        let near = |point: &&[f64; 3]| ((point[0] - a[0]) * cos + (point[1] - a[1]) * sin).abs() <= point[2];
        let votes = points.iter().filter(near).count();
        if best.is_none_or(|best| votes > best.0) {
            best = Some((votes, [a[0], a[1]], normal_rad));
        }
    }
    let (_, mut centre, mut normal_rad) = best?;
    let mut ranked: Vec<(f64, [f64; 3])> = Vec::with_capacity(count);
    for _ in 0..3 {
        let (sin, cos) = normal_rad.sin_cos();
        ranked.clear();
        ranked.extend(
            points.iter().map(|&point| (((point[0] - centre[0]) * cos + (point[1] - centre[1]) * sin).abs(), point)),
        );
        ranked.select_nth_unstable_by(needed - 1, |a, b| a.0.total_cmp(&b.0));
        (centre, normal_rad) = principal(&ranked[..needed]);
    }
    let half_turn = std::f64::consts::PI;
    let folded_rad = normal_rad - half_turn * (normal_rad / half_turn).round();
    Some((centre, folded_rad))
}

/// Mean of the points, and angle of the direction in which they spread least.
fn principal(ranked: &[(f64, [f64; 3])]) -> ([f64; 2], f64) {
    let weight = 1.0 / ranked.len() as f64;
    let mean = [0, 1].map(|axis| ranked.iter().map(|(_, point)| point[axis]).sum::<f64>() * weight);
    let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
    for (_, point) in ranked {
        let (u, v) = (point[0] - mean[0], point[1] - mean[1]);
        uu += u * u;
        uv += u * v;
        vv += v * v;
    }
    // Half of atan2(2·uv, uu − vv) is the direction of greatest spread; the normal is a quarter turn away from it.
    (mean, 0.5 * (2.0 * uv).atan2(uu - vv) + std::f64::consts::FRAC_PI_2)
}

/// An upper bound for the magnitude of the slope, in local coordinates, of every line that fits the points: that is within the bound of at least K of
/// n.
///
/// Of the K points nearest to the estimate, any such line is near at least `2K − n`. Two of these points are at least as far apart along the line as
/// the shortest stretch that contains that many points, and `|Δx·sin δ| ≤ |Δy| + e_i + e_j`, where δ is the line's angle and e_i a point's bound.
fn greatest_slope(local: &[[f64; 3]], needed: usize) -> Option<f64> {
    let shared = (2 * needed).checked_sub(local.len()).filter(|&shared| shared >= 2)?;
    let mut core = local.to_vec();
    core.select_nth_unstable_by(needed - 1, |a, b| a[1].abs().total_cmp(&b[1].abs()));
    core.truncate(needed);
    core.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let stretch_px = core.windows(shared).map(|window| window[shared - 1][0] - window[0][0]).fold(f64::MAX, f64::min);
    let spread_px = core.iter().map(|point| point[1]).fold(f64::MIN, f64::max)
        - core.iter().map(|point| point[1]).fold(f64::MAX, f64::min);
    let bound_px = core.iter().map(|point| point[2]).fold(0.0, f64::max);
    let sine = (spread_px + 2.0 * bound_px + ROUNDING) / stretch_px;
    let slope = sine / (1.0 - sine * sine).sqrt();
    (sine < 1.0 && slope < SLOPE_MAX).then_some(slope * (1.0 + ROUNDING))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    /// Random points about a line with a given normal angle through `place`: `wrong` of them up to 9 px from the line, the others within their bounds
    /// of it.
    fn scattered(
        random: &mut Random,
        count: usize,
        wrong: usize,
        bounds_px: [f64; 2],
        normal_rad: f64,
        place: [f64; 2],
    ) -> Vec<[f64; 3]> {
        let (sin, cos) = normal_rad.sin_cos();
        let mut points: Vec<[f64; 3]> = (0..count)
            .map(|index| {
                let bound_px = random.between(bounds_px[0], bounds_px[1]);
                let along = 500.0 * (index as f64 / count as f64 - 0.5);
                let across =
                    if index < wrong { random.between(-9.0, 9.0) } else { random.between(-bound_px, bound_px) };
                [place[0] + across * cos - along * sin, place[1] + across * sin + along * cos, bound_px]
            })
            .collect();
        // The list of points is shuffled, so that wrong points are anywhere in it.
        for index in 0..count {
            points.swap(index, (random.unit() * count as f64) as usize);
        }
        points
    }

    fn enclosed(points: &[[f64; 3]], share_wrong: f64) -> LineSet {
        enclose(points, share_wrong).unwrap_or_else(|| panic!("a line near the points is in the set"))
    }

    /// Whether a line is within the bounds of enough points, counted directly point by point.
    fn is_member(points: &[[f64; 3]], wrong: usize, centroid_px: [f64; 2], normal_rad: f64, offset_px: f64) -> bool {
        let (sin, cos) = normal_rad.sin_cos();
        let near = |point: &&[f64; 3]| {
            ((point[0] - centroid_px[0]) * cos + (point[1] - centroid_px[1]) * sin - offset_px).abs() <= point[2]
        };
        points.iter().filter(near).count() + wrong >= points.len()
    }

    /// For the lines of one angle that fit the points, the ends of the intervals of their offsets, by trying all: as the offset changes, a line
    /// begins or ceases to fit only where its distance from a point equals the point's bound.
    fn members_at(points: &[[f64; 3]], wrong: usize, centroid_px: [f64; 2], normal_rad: f64) -> Vec<f64> {
        let (sin, cos) = normal_rad.sin_cos();
        let ends = points.iter().flat_map(|point| {
            let middle = (point[0] - centroid_px[0]) * cos + (point[1] - centroid_px[1]) * sin;
            [middle - point[2] + 1e-9, middle + point[2] - 1e-9]
        });
        ends.filter(|&offset_px| is_member(points, wrong, centroid_px, normal_rad, offset_px)).collect()
    }

    #[test]
    fn every_line_near_enough_points_is_in_the_set() {
        let mut random = Random::new(11);
        let mut members = 0;
        for _ in 0..300 {
            let count = 10 + (random.unit() * 70.0) as usize;
            let wrong = (0.3 * count as f64) as usize;
            let normal_rad = random.between(-3.0, 3.0);
            let place = [random.between(0.0, 640.0), random.between(0.0, 480.0)];
            let points = scattered(&mut random, count, wrong, [0.2, 0.9], normal_rad, place);
            let set = enclosed(&points, 0.3);
            for _ in 0..2000 {
                let tried_rad = set.direction_rad + random.normal() * 0.003;
                let offset_px = random.normal() * 0.6;
                if !is_member(&points, wrong, set.centroid_px, tried_rad, offset_px) {
                    continue;
                }
                members += 1;
                assert!(set.normal_angle_rad[0] <= tried_rad && tried_rad <= set.normal_angle_rad[1]);
                assert!(set.offset_px[0] <= offset_px && offset_px <= set.offset_px[1]);
                let [low, high] = set.offset_at(tried_rad, tried_rad).unwrap_or([f64::NAN; 2]);
                assert!(low <= offset_px && offset_px <= high);
                // Where the line crosses a normal of the best estimate, by the equation of the line.
                let along_px = random.between(-300.0, 300.0);
                let crossing = set.crossing(along_px);
                let [nu, nv] = crossing.normal;
                let (sin, cos) = tried_rad.sin_cos();
                let across_px = (offset_px + along_px * (cos * nv - sin * nu)) / (cos * nu + sin * nv);
                assert!(crossing.across_px.contains(across_px), "{across_px} {}", crossing.across_px);
                let [u, v] = [0, 1].map(|axis| crossing.at_px[axis] - set.centroid_px[axis]);
                assert!((u * nu + v * nv).abs() < 1e-9 && (set.along_px(crossing.at_px) - along_px).abs() < 1e-9);
            }
        }
        assert!(members > 5_000, "only {members} members tried");
    }

    #[test]
    fn the_set_is_hardly_wider_than_its_members() {
        let mut random = Random::new(12);
        for _ in 0..50 {
            let normal_rad = random.between(-1.5, 1.5);
            let points = scattered(&mut random, 60, 15, [0.2, 0.9], normal_rad, [320.0, 240.0]);
            let set = enclosed(&points, 0.3);
            let (mut angles, mut offsets) = ([f64::MAX, f64::MIN], [f64::MAX, f64::MIN]);
            for step in 0..=4000 {
                let share = f64::from(step) / 4000.0;
                let tried_rad = set.normal_angle_rad[0] + share * (set.normal_angle_rad[1] - set.normal_angle_rad[0]);
                for offset_px in members_at(&points, 18, set.centroid_px, tried_rad) {
                    angles = hull(angles, [tried_rad, tried_rad]);
                    offsets = hull(offsets, [offset_px, offset_px]);
                }
            }
            // The two ends of the range of angles may each be too wide by the slack of 0.06 px over the 250 px from the middle to an end of the line:
            // 0.5 mrad together.
            assert!(set.normal_angle_rad[1] - set.normal_angle_rad[0] < angles[1] - angles[0] + 6e-4);
            assert!(set.offset_px[1] - set.offset_px[0] < offsets[1] - offsets[0] + 0.12);
        }
    }

    #[test]
    fn offsets_of_a_range_of_angles_hold_those_of_its_parts() {
        let mut random = Random::new(13);
        let points = scattered(&mut random, 40, 6, [0.2, 0.9], 0.4, [100.0, 50.0]);
        let set = enclosed(&points, 0.3);
        let [low, high] = set.normal_angle_rad;
        let middle = 0.5 * (low + high);
        let (all, part) = (set.offset_at(low, high), set.offset_at(middle, middle));
        assert_eq!(all, Some(set.offset_px));
        assert!(all.zip(part).is_some_and(|(all, part)| hull(all, part) == all));
        assert_eq!(set.offset_at(high + 1e-3, high + 1.0), None);
    }

    #[test]
    fn points_that_no_line_fits_give_no_set() {
        let mut random = Random::new(14);
        let points: Vec<[f64; 3]> =
            (0..30).map(|_| [random.between(0.0, 600.0), random.between(0.0, 400.0), 0.5]).collect();
        assert_eq!(enclose(&points, 0.3), None);
        // A cluster of points does not bound the line's direction.
        let cluster: Vec<[f64; 3]> = (0..30).map(|_| [random.unit(), random.unit(), 0.5]).collect();
        assert_eq!(enclose(&cluster, 0.3), None);
        assert_eq!(enclose(&[], 0.3), None);
        assert_eq!(enclose(&[[1.0, 2.0, 0.5]], 0.3), None);
        assert_eq!(enclose(&[[f64::NAN, 2.0, 0.5], [3.0, 4.0, 0.5], [9.0, 9.0, 0.5]], 0.0), None);
        // A line passes through these points, but one of them is farther away than rounding errors are allowed for.
        assert_eq!(enclose(&[[0.0, 2.0, 0.5], [300.0, 2.0, 0.5], [2e5, 2.0, 0.5]], 0.0), None);
        assert!(enclose(&[[0.0, 2.0, 0.5], [300.0, 2.0, 0.5], [2e4, 2.0, 0.5]], 0.0).is_some());
    }

    #[test]
    fn two_points_enclose_the_lines_between_their_bounds() {
        // By hand: both ends, at u = ±100, are within ±1 px, so that angles are within about ±0.01 rad and offsets within ±1 px.
        let set = enclosed(&[[-100.0, 5.0, 1.0], [100.0, 5.0, 1.0]], 0.0);
        let half_angle = 0.5 * (set.normal_angle_rad[1] - set.normal_angle_rad[0]);
        assert!((half_angle - 0.01).abs() < 2e-4, "half angle {half_angle}");
        assert!((set.offset_px[1] - 1.0).abs() < 0.03 && (set.offset_px[0] + 1.0).abs() < 0.03);
    }
}
