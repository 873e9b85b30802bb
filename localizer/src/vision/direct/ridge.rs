//! Ridge points: places where a binned, logarithmic image is darkest or lightest across a thin structure.

use std::f32::consts::FRAC_PI_2;

use image::GrayImage;

/// An image of floating-point values, row-major, `height × width`.
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f32>,
}

impl Plane {
    /// The row of the image above a given row, the row itself and the row below.
    fn three_rows(&self, row: usize) -> [&[f32]; 3] {
        [row - 1, row, row + 1].map(|row| &self.values[row * self.width..(row + 1) * self.width])
    }
}

/// A point on the centre line of a thin dark or light structure, to a fraction of a cell of the binned image.
#[derive(Clone, Copy, Debug)]
pub(super) struct RidgePoint {
    /// Position of the ridge point relative to the centre of the image, in pixels of full resolution.
    pub(super) position_px: [f32; 2],
    /// Angle of the normal of a thin structure in the image, known modulo half a turn.
    pub(super) normal_rad: f32,
    /// Second derivative of brightness across the thin structure at this point, as a multiple of the least one at which a point is detected: at least
    /// 1, and limited to `WEIGHT_CAP`.
    pub(super) weight: f32,
    /// Whether the thin structure in the image is darker than its surroundings.
    pub(super) dark: bool,
}

/// Usable range of the mean grey level of a cell of pixels: below it, eight bits leave no contrast to measure; above it, the sensor clips.
const USABLE_GREY: [f32; 2] = [5.0, 250.0];

/// Averages blocks of `bin × bin` pixels and takes the logarithm. Uneven light becomes an additive, slowly varying term, so that a tile joint
/// has the same contrast in bright and in dark areas. `None` when at least half of the image is black or clipped.
pub(super) fn binned_log(image: &GrayImage, bin: usize) -> Option<Plane> {
    let (width, height) = (image.width() as usize / bin, image.height() as usize / bin);
    if width < 8 || height < 8 {
        return None;
    }
    let (stride, pixels) = (image.width() as usize, image.as_raw());
    let mut values = Vec::with_capacity(width * height);
    let mut sums = vec![0u16; width * bin];
    let (per_cell, mut unusable) = (1.0 / (bin * bin) as f32, 0);
    for row in 0..height {
        sums.fill(0);
        for line in pixels[row * bin * stride..].chunks(stride).take(bin) {
            for (sum, &pixel) in sums.iter_mut().zip(line) {
                *sum += u16::from(pixel);
            }
        }
        for cell in sums.chunks_exact(bin) {
            let grey = cell.iter().map(|&sum| u32::from(sum)).sum::<u32>() as f32 * per_cell;
            unusable += usize::from(!(USABLE_GREY[0]..USABLE_GREY[1]).contains(&grey));
            // One grey level is added, so that the logarithm of a black pixel cell stays finite.
            values.push((grey + 1.0).ln());
        }
    }
    (2 * unusable < width * height).then_some(Plane { width, height, values })
}

/// The image after binomial smoothing `[1 4 6 4 1]/16` along rows and along columns; the two outermost cells at each
/// border are not smoothed across that border.
fn smoothed(plane: &Plane) -> Plane {
    let (width, height) = (plane.width, plane.height);
    let mut across = plane.values.clone();
    for (out, row) in across.chunks_mut(width).zip(plane.values.chunks(width)) {
        for (cell, near) in out[2..width - 2].iter_mut().zip(row.windows(5)) {
            *cell = (near[0] + near[4] + 4.0 * (near[1] + near[3]) + 6.0 * near[2]) / 16.0;
        }
    }
    let mut values = across.clone();
    for row in 2..height - 2 {
        let near = |offset: usize| &across[(row + offset - 2) * width..(row + offset - 1) * width];
        let (a, b, c, d, e) = (near(0), near(1), near(2), near(3), near(4));
        for (column, cell) in values[row * width..(row + 1) * width].iter_mut().enumerate() {
            *cell = (a[column] + e[column] + 4.0 * (b[column] + d[column]) + 6.0 * c[column]) / 16.0;
        }
    }
    Plane { width, height, values }
}

/// Width of the binned image's border, in cells, where smoothing and second differences are not available.
const BORDER_CELLS: usize = 3;

/// Ridge points of the image: cells where the curvature in one direction dominates and whose extremum lies inside the cell.
///
/// Points weaker than `strong_share` of the image's strong ridges are left out.
pub(super) fn ridge_points(plane: &Plane, bin: usize, image_size_px: [f32; 2], strong_share: f32) -> Vec<RidgePoint> {
    let smooth = smoothed(plane);
    let width = smooth.width;
    let mut curvature = vec![0f32; smooth.values.len()];
    let rows = BORDER_CELLS..smooth.height - BORDER_CELLS;
    for row in rows.clone() {
        let near = smooth.three_rows(row);
        let out = &mut curvature[row * width..(row + 1) * width];
        for (column, across) in out.iter_mut().enumerate().take(width - BORDER_CELLS).skip(BORDER_CELLS) {
            let (uu, vv, uv) = hessian(near, column);
            let (half_sum, half_difference) = (0.5 * (uu + vv), 0.5 * (uu - vv));
            let root = (half_difference * half_difference + uv * uv).sqrt();
            *across = half_sum + root.copysign(half_sum);
        }
    }
    let threshold = threshold(&curvature, width, strong_share);
    let mut points = Vec::with_capacity(1024);
    for row in rows {
        let near = smooth.three_rows(row);
        for column in BORDER_CELLS..width - BORDER_CELLS {
            let across = curvature[row * width + column];
            if across.abs() < threshold {
                continue;
            }
            let Some((step, normal_rad)) = extremum(near, column, across) else { continue };
            let cell = [column as f32 + step[0], row as f32 + step[1]];
            points.push(RidgePoint {
                position_px: [0, 1].map(|axis| (cell[axis] + 0.5) * bin as f32 - 0.5 * image_size_px[axis]),
                normal_rad,
                weight: (across.abs() / threshold).min(WEIGHT_CAP),
                dark: across > 0.0,
            });
        }
    }
    points
}

/// Offset from the middle of a cell of the image to the darkest or lightest place across a ridge, and the angle of the ridge's normal. `None` if that
/// place lies in another cell or the structure is not line-shaped. `across` is the eigenvalue of the second derivatives with the greatest magnitude.
fn extremum(near: [&[f32]; 3], column: usize, across: f32) -> Option<([f32; 2], f32)> {
    let (uu, vv, uv) = hessian(near, column);
    // A blob or a crossing in the image is curved in both directions, so that its direction has no meaning.
    if (uu + vv - across).abs() > 0.5 * across.abs() {
        return None;
    }
    // Half of the angle atan2(2·uv, uu − vv) is the direction of the greatest second derivative: the normal of a dark
    // ridge, the direction along a light one.
    let normal_rad = 0.5 * (2.0 * uv).atan2(uu - vv) + if across > 0.0 { 0.0 } else { FRAC_PI_2 };
    let (sin, cos) = normal_rad.sin_cos();
    let [above, here, below] = near;
    let slope = 0.5 * ((here[column + 1] - here[column - 1]) * cos + (below[column] - above[column]) * sin);
    let step = [-slope / across * cos, -slope / across * sin];
    // Neighbouring cells overlap by a tenth of a cell on each side, so that no extremum is lost between them.
    (step[0].abs() <= 0.6 && step[1].abs() <= 0.6).then_some((step, normal_rad))
}

/// Greatest weight of a ridge point in the vote on lines, where the weakest point has weight 1: the reflection of a lamp must not outvote a tile
/// joint.
const WEIGHT_CAP: f32 = 4.0;

/// Second differences uu, vv, uv of the image at one column of three neighbouring rows.
#[inline(always)]
fn hessian([above, here, below]: [&[f32]; 3], column: usize) -> (f32, f32, f32) {
    let uu = here[column + 1] - 2.0 * here[column] + here[column - 1];
    let vv = below[column] - 2.0 * here[column] + above[column];
    let uv = 0.25 * (below[column + 1] - below[column - 1] - above[column + 1] + above[column - 1]);
    (uu, vv, uv)
}

/// Least curvature of a ridge: three times the median curvature of the image (noise and texture), but at least a share of its strong ridges'
/// curvature (otherwise their side lobes would count), and at least 1 % of contrast (otherwise the steps of eight bits in a dark image would form
/// ridges).
fn threshold(curvature: &[f32], width: usize, strong_share: f32) -> f32 {
    // Every seventh cell is enough for the quantiles of the image's curvature; seven divides no usual width, so that all columns are sampled in turn.
    let mut sample: Vec<f32> = curvature[BORDER_CELLS * width..].iter().step_by(7).map(|value| value.abs()).collect();
    let count = sample.len();
    let (_, &mut median, _) = sample.select_nth_unstable_by(count / 2, f32::total_cmp);
    // One tile joint across an image fills about one per cent of its cells.
    let (_, &mut strong, _) = sample.select_nth_unstable_by(count * 98 / 100, f32::total_cmp);
    (3.0 * median).max(strong_share * strong).max(0.01)
}
