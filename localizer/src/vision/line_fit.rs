//! Set-membership fit: every line that is near enough to most of the points, enclosed without a gap.

/// The lines `{ p : n(φ)·(p − centroid) = offset }`, `n(φ) = (cos φ, sin φ)`, that are within bound of enough points.
///
/// Angles are on the real line around [`direction_rad`](Self::direction_rad); the same line at `φ + π` with the opposite
/// offset is not listed twice.
#[derive(Clone, Debug, PartialEq)]
pub struct LineSet {
    /// Point about which offsets are counted, near the middle of the points.
    pub centroid_px: [f64; 2],
    /// Best estimate of the normal's angle, in `(-π/2, π/2]`; the best estimate of the offset is 0.
    pub direction_rad: f64,
    /// Hull of the normal's angle over the set: `[least, greatest]`.
    pub normal_angle_rad: [f64; 2],
    /// Hull of the offset over the set: `[least, greatest]`.
    pub offset_px: [f64; 2],
    /// Outer description of the set, by ascending angle.
    slices: Vec<Slice>,
}

/// Every line of the set whose normal angle lies in `angle_rad` has its offset in `offset_px`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slice {
    angle_rad: [f64; 2],
    offset_px: [f64; 2],
}

impl LineSet {
    /// Hull of the offset over the lines of the set whose normal angle lies in `[normal_angle_lo, normal_angle_hi]`;
    /// `None` if there is none.
    pub fn offset_at(&self, normal_angle_lo: f64, normal_angle_hi: f64) -> Option<[f64; 2]> {
        let touches = |slice: &&Slice| slice.angle_rad[0] <= normal_angle_hi && slice.angle_rad[1] >= normal_angle_lo;
        self.slices.iter().filter(touches).map(|slice| slice.offset_px).reduce(hull)
    }
}

/// Tangent of the greatest angle between a line of the set and the best estimate. Points too short a line to bound it better
/// have no use, and the smallness keeps the local coordinates honest.
const SLOPE_MAX: f64 = 0.2;
/// Widening of a slice's offsets that is worth another bisection.
const SLACK_PX: f64 = 0.04;
/// Absolute margin for rounding: coordinates below 10⁵ px have a spacing of 10⁻¹¹, and each goes through few operations.
const ROUNDING: f64 = 1e-9;

/// Encloses all lines that are within their bound of at least `n − ⌊share_wrong·n⌋` of the `n` points `[u, v, bound]`.
///
/// In local coordinates, x along and y across a first estimate, a line `y = m·x + b` satisfies
/// `|y_i − m·x_i − b| ≤ e_i·√(1 + m²)` for at least K points. At a slope m that leaves `b` between the K-th smallest lower and the
/// K-th greatest upper end of these intervals (the K-level of the arrangement of bounding lines). Both change by at
/// most `max|x_i|` per unit of slope, so two slopes enclose all between them; slopes are bisected until that is tight.
///
/// `None` if no line is near enough to so many points, or if they are too few or too short to bound the direction.
pub fn enclose(points: &[[f64; 3]], share_wrong: f64) -> Option<LineSet> {
    let count = points.len();
    // A hair more than the product, so that rounding can only allow one more wrong point.
    let wrong = (share_wrong * count as f64 + ROUNDING).floor() as usize;
    let needed = count.checked_sub(wrong)?;
    if count < 2 || needed < 2 || points.iter().flatten().any(|value| !value.is_finite()) {
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
    let level = Level {
        points: &local,
        needed,
        reach_px: local.iter().map(|point| point[0].abs()).fold(0.0, f64::max) + ROUNDING,
    };
    let mut leaves = Vec::new();
    let mut work = Vec::with_capacity(count);
    let ends = [-slope_max, slope_max].map(|slope| level.at(slope, &mut work));
    level.bisect(ends[0], ends[1], &mut work, &mut leaves);
    let (first, last) = (*leaves.first()?, *leaves.last()?);
    let sharp = [level.sharpen(first, false, &mut work), level.sharpen(last, true, &mut work)];
    let end = leaves.len() - 1;
    leaves[0][0] = if end == 0 { leaves[0][0] } else { sharp[0] };
    leaves[end][1] = if end == 0 { leaves[end][1] } else { sharp[1] };
    // A greater slope is a smaller angle of the normal.
    let slices: Vec<Slice> = leaves.iter().rev().map(|leaf| slice(leaf, direction_rad)).collect();
    let offset_px = slices.iter().map(|slice| slice.offset_px).reduce(hull)?;
    let normal_angle_rad = slices.iter().map(|slice| slice.angle_rad).reduce(hull)?;
    Some(LineSet { centroid_px, direction_rad, normal_angle_rad, offset_px, slices })
}

fn hull(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// Slopes `[m₀, m₁]` and intercepts `[b₀, b₁]` in local coordinates as angles and offsets: `φ = φ₀ − atan m`, `offset = b·cos(atan m)`.
fn slice(&[slope_from, slope_to, low_px, high_px]: &[f64; 4], direction_rad: f64) -> Slice {
    let angle_rad =
        [direction_rad - slope_to.atan() - ROUNDING * 1e-3, direction_rad - slope_from.atan() + ROUNDING * 1e-3];
    let steepest = slope_from.abs().max(slope_to.abs());
    let shrink = 1.0 / (1.0 + steepest * steepest).sqrt();
    let offset_px = [low_px.min(low_px * shrink) - ROUNDING, high_px.max(high_px * shrink) + ROUNDING];
    Slice { angle_rad, offset_px }
}

/// Intercepts left at one slope: `lower ≤ b ≤ upper`.
#[derive(Clone, Copy)]
struct Node {
    slope: f64,
    lower_px: f64,
    upper_px: f64,
}

/// The K-level of the bounding lines of points in local coordinates `[x, y, bound]`.
struct Level<'a> {
    points: &'a [[f64; 3]],
    needed: usize,
    /// Greatest |x|: how fast an intercept moves with the slope.
    reach_px: f64,
}

impl Level<'_> {
    fn at(&self, slope: f64, work: &mut Vec<f64>) -> Node {
        work.clear();
        work.extend(self.points.iter().map(|[x, y, bound]| y - slope * x - bound));
        let lower_px = *work.select_nth_unstable_by(self.needed - 1, f64::total_cmp).1;
        work.clear();
        work.extend(self.points.iter().map(|[x, y, bound]| y - slope * x + bound));
        let upper_px = *work.select_nth_unstable_by(self.points.len() - self.needed, f64::total_cmp).1;
        Node { slope, lower_px, upper_px }
    }

    /// Intercepts of all lines with slopes between two nodes, `None` if there is none.
    fn between(&self, a: &Node, b: &Node) -> Option<[f64; 2]> {
        let travel_px = self.reach_px * (b.slope - a.slope) + ROUNDING;
        let low_px = 0.5 * (a.lower_px + b.lower_px - travel_px);
        let high_px = 0.5 * (a.upper_px + b.upper_px + travel_px);
        (low_px <= high_px).then_some([low_px, high_px])
    }

    /// Appends the leaves `[slope from, slope to, least intercept, greatest intercept]` between two nodes, by ascending slope.
    fn bisect(&self, a: Node, b: Node, work: &mut Vec<f64>, leaves: &mut Vec<[f64; 4]>) {
        let Some([low_px, high_px]) = self.between(&a, &b) else { return };
        if self.reach_px * (b.slope - a.slope) <= SLACK_PX {
            leaves.push([a.slope, b.slope, low_px, high_px]);
            return;
        }
        let middle = self.at(0.5 * (a.slope + b.slope), work);
        self.bisect(a, middle, work, leaves);
        self.bisect(middle, b, work, leaves);
    }

    /// Least (or greatest) slope of a leaf that cannot be ruled out, to an eighth of its width.
    fn sharpen(&self, leaf: [f64; 4], greatest: bool, work: &mut Vec<f64>) -> f64 {
        let (mut from, mut to) = (self.at(leaf[0], work), self.at(leaf[1], work));
        for _ in 0..3 {
            let middle = self.at(0.5 * (from.slope + to.slope), work);
            let outer = if greatest { self.between(&middle, &to) } else { self.between(&from, &middle) };
            // An empty outer half is cut off; else the search goes on inside of it.
            if greatest == outer.is_none() { to = middle } else { from = middle }
        }
        if greatest { to.slope } else { from.slope }
    }
}

/// Centroid and normal angle of a line near most points: the best of some pairs, then least squares through the nearest.
fn estimate(points: &[[f64; 3]], needed: usize) -> Option<([f64; 2], f64)> {
    let count = points.len();
    let mut best: Option<(usize, [f64; 2], f64)> = None;
    // Pairs half of the list apart are far apart in a list that runs along the line; ten of them meet two right points surely enough.
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

/// Mean, and angle of the direction of least spread.
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
    // Half of atan2(2·uv, uu − vv) is the direction of greatest spread; the normal is a quarter turn away.
    (mean, 0.5 * (2.0 * uv).atan2(uu - vv) + std::f64::consts::FRAC_PI_2)
}

/// A slope that no line of the set exceeds, in local coordinates.
///
/// Of the K points nearest to the estimate, any line of the set is near at least `2K − n`. Two of these are as far apart
/// along the line as the shortest stretch that holds so many, and `|Δx·sin δ| ≤ |Δy| + e_i + e_j`.
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
