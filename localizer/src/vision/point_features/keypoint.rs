//! Detector of corners: FAST-9 (Rosten and Drummond, *Machine learning for high-speed corner detection*, ECCV 2006) on the smoothed image, spread
//! over the image by a grid, with sub-pixel positions.
//!
//! The detector of the crate `imageproc` takes three times as long and whole grey levels only, which the smoothing would have to be rounded to.

use crate::vision::forward::Picture;

/// Side of the cells of the grid by which keypoints are spread over the image, in pixels.
const CELL_PX: usize = 20;
/// Greatest number of keypoints in one cell.
const PER_CELL: usize = 4;
/// Least distance along u or along v between two keypoints, in pixels: the corner detector answers to one corner at several neighbouring pixels.
const APART_PX: usize = 4;
/// Least contrast of a corner in the smoothed image, in grey levels. The smoothing leaves 0.28 of the noise, so that noise of a standard deviation of
/// 3 grey levels makes hardly any corner.
const CONTRAST: f32 = 5.0;
/// Distance from the image's border within which there are no keypoints, in pixels: the corner measure needs a neighbourhood.
const BORDER_PX: usize = 6;

/// A corner in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keypoint {
    /// Position `[u, v]`, to a fraction of a pixel. It says where something is to be looked at; how accurately the same corner is found again in
    /// another image is not claimed.
    pub position_px: [f64; 2],
    /// Greatest contrast, in grey levels of the smoothed image, at which the point is still a FAST corner.
    pub contrast: f64,
}

/// A pixel that is a FAST corner, and the greatest contrast at which it still is.
#[derive(Clone, Copy)]
struct Corner {
    u: usize,
    v: usize,
    contrast: f32,
}

/// Corners of an image, at most `most`. Each cell of the grid gives its strongest corner before any gives its second, so that they spread over the
/// image; within a rank the strongest come first.
pub(super) fn keypoints(smoothed: &Picture, most: usize) -> Vec<Keypoint> {
    let stronger_first = |a: &Corner, b: &Corner| b.contrast.total_cmp(&a.contrast).then((a.v, a.u).cmp(&(b.v, b.u)));
    let mut corners = corners(smoothed);
    corners.sort_by(stronger_first);
    let n_columns = smoothed.width.div_ceil(CELL_PX);
    let mut cells: Vec<Vec<Corner>> = vec![Vec::new(); n_columns * smoothed.height.div_ceil(CELL_PX)];
    for corner in corners {
        let [column, row] = [corner.u / CELL_PX, corner.v / CELL_PX];
        let is_beside = |other: &Corner| corner.u.abs_diff(other.u) < APART_PX && corner.v.abs_diff(other.v) < APART_PX;
        let near = |at: usize| at.saturating_sub(1)..=at + 1;
        let is_taken = near(row).flat_map(|row| near(column).map(move |column| [column, row])).any(|[column, row]| {
            column < n_columns && cells.get(row * n_columns + column).is_some_and(|cell| cell.iter().any(is_beside))
        });
        let own = &mut cells[row * n_columns + column];
        if !is_taken && own.len() < PER_CELL {
            own.push(corner);
        }
    }
    let mut chosen: Vec<Corner> = Vec::new();
    for rank in 0..PER_CELL {
        let mut of_rank: Vec<Corner> = cells.iter().filter_map(|cell| cell.get(rank).copied()).collect();
        of_rank.sort_by(stronger_first);
        chosen.extend(of_rank);
    }
    chosen.truncate(most);
    let keypoint = |corner: &Corner| Keypoint {
        position_px: refined(smoothed, corner.u, corner.v),
        contrast: f64::from(corner.contrast),
    };
    chosen.iter().map(keypoint).collect()
}

/// The circle of 16 pixels around a pixel, in order, each `[u, v]`.
const CIRCLE: [[isize; 2]; 16] = [
    [0, -3],
    [1, -3],
    [2, -2],
    [3, -1],
    [3, 0],
    [3, 1],
    [2, 2],
    [1, 3],
    [0, 3],
    [-1, 3],
    [-2, 2],
    [-3, 1],
    [-3, 0],
    [-3, -1],
    [-2, -2],
    [-1, -3],
];
/// Number of neighbouring pixels of the circle that must all be brighter, or all be darker, than the middle.
const ARC: usize = 9;

/// FAST corners that are the strongest among their eight neighbours; of equal ones, the last.
fn corners(picture: &Picture) -> Vec<Corner> {
    let (width, height) = (picture.width, picture.height);
    if width <= 2 * BORDER_PX || height <= 2 * BORDER_PX {
        return Vec::new();
    }
    let inner = BORDER_PX..width - BORDER_PX;
    let steps = CIRCLE.map(|[du, dv]| dv * width as isize + du);
    let mut contrasts = vec![0.0f32; width * height];
    let mut is_candidate = vec![false; inner.len()];
    let mut found = Vec::new();
    for v in BORDER_PX..height - BORDER_PX {
        mark_candidates(picture, v, inner.start, &mut is_candidate);
        for u in inner.clone().filter(|u| is_candidate[u - inner.start]) {
            let at = v * width + u;
            let middle = picture.values[at];
            let off = steps.map(|step| picture.values[at.wrapping_add_signed(step)] - middle);
            let contrast = contrast(&off);
            if contrast > CONTRAST {
                contrasts[at] = contrast;
                found.push(Corner { u, v, contrast });
            }
        }
    }
    found.retain(|corner| {
        let at = corner.v * width + corner.u;
        let before = [at - width - 1, at - width, at - width + 1, at - 1];
        let after = [at + 1, at + width - 1, at + width, at + width + 1];
        before.iter().all(|&other| contrasts[other] <= corner.contrast)
            && after.iter().all(|&other| contrasts[other] < corner.contrast)
    });
    found
}

/// Marks the pixels of a row that may be corners: of nine neighbouring pixels of the circle, at least two are among those straight above, right,
/// below and left.
fn mark_candidates(picture: &Picture, v: usize, first: usize, is_candidate: &mut [bool]) {
    let n_pixels = is_candidate.len();
    let row = |dv: isize, du: isize| {
        &picture.values[(v.wrapping_add_signed(dv) * picture.width + first).wrapping_add_signed(du)..][..n_pixels]
    };
    let (middle, above, right, below, left) = (row(0, 0), row(-3, 0), row(0, 3), row(3, 0), row(0, -3));
    for (idx, is_candidate) in is_candidate.iter_mut().enumerate() {
        let [low, high] = [middle[idx] - CONTRAST, middle[idx] + CONTRAST];
        let around = [above[idx], right[idx], below[idx], left[idx]];
        let count = |of: [bool; 4]| of.map(u8::from).iter().sum::<u8>();
        let n_bright = count(around.map(|level| level > high));
        let n_dark = count(around.map(|level| level < low));
        *is_candidate = (n_bright >= 2) | (n_dark >= 2);
    }
}

/// Greatest contrast at which nine neighbours of a circle are all brighter or all darker than the middle, from their differences from it; less than 0
/// where there is none.
fn contrast(off: &[f32; 16]) -> f32 {
    // The choices are made such that each is one vector instruction.
    let least_of_arcs = of_arcs(off, |a, b| if a < b { a } else { b });
    let greatest_of_arcs = of_arcs(off, |a, b| if a > b { a } else { b });
    let bright = least_of_arcs.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let dark = greatest_of_arcs.iter().copied().fold(f32::INFINITY, f32::min);
    bright.max(-dark)
}

/// For each number of a circle of 16, what is chosen of it and the eight after it, from the choice between two.
fn of_arcs(circle: &[f32; 16], choice: impl Fn(f32, f32) -> f32) -> [f32; 16] {
    const { assert!(ARC == 9) };
    // One turn and a half, so that an arc over the end of the circle counts.
    let one: [f32; 24] = std::array::from_fn(|at| circle[at % 16]);
    let two: [f32; 22] = std::array::from_fn(|at| choice(one[at], one[at + 1]));
    let four: [f32; 20] = std::array::from_fn(|at| choice(two[at], two[at + 2]));
    let eight: [f32; 16] = std::array::from_fn(|at| choice(four[at], four[at + 4]));
    std::array::from_fn(|at| choice(eight[at], one[at + 8]))
}

/// Steps of one pixel by which the greatest corner measure is followed.
const CLIMB: usize = 2;
/// Half of the side of the square, less half a pixel, over which a corner measure sums.
const HALF_PX: usize = 2;

/// Position, near a pixel, of the greatest corner measure: the smaller eigenvalue of the sum of the gradients' outer products over 5 × 5 pixels
/// (Shi and Tomasi 1994), with parabolas through its values at the pixel and its neighbours.
fn refined(picture: &Picture, u: usize, v: usize) -> [f64; 2] {
    const REACH: usize = CLIMB + 1 + HALF_PX;
    const SIDE: usize = 2 * REACH + 1;
    // Products g_u², g_u·g_v and g_v² at the pixels around the point, and a number more, because four are added at once.
    let mut products = [[[0.0f32; 4]; SIDE]; SIDE];
    for (row, products) in products.iter_mut().enumerate() {
        let (first_u, v) = (u - REACH - 1, v + row - REACH);
        let pixels = |v: usize| &picture.values[v * picture.width + first_u..][..SIDE + 2];
        let (above, beside, below) = (pixels(v - 1), pixels(v), pixels(v + 1));
        for (column, product) in products.iter_mut().enumerate() {
            let (along_u, along_v) = (beside[column + 2] - beside[column], below[column + 1] - above[column + 1]);
            *product = [along_u * along_u, along_u * along_v, along_v * along_v, 0.0];
        }
    }
    // The measure at a pixel counted from the first one at which the square fits.
    let mut known = [[None; 2 * CLIMB + 3]; 2 * CLIMB + 3];
    let mut measure = |[u, v]: [usize; 2]| {
        *known[v][u].get_or_insert_with(|| {
            let mut sums = [0.0f32; 4];
            for row in &products[v..=v + 2 * HALF_PX] {
                for product in &row[u..=u + 2 * HALF_PX] {
                    (0..4).for_each(|part| sums[part] += product[part]);
                }
            }
            let [uu, uv, vv, _] = sums.map(f64::from);
            0.5 * (uu + vv) - (0.25 * (uu - vv).powi(2) + uv * uv).sqrt()
        })
    };
    let first = CLIMB + 1;
    let mut at = [first, first];
    for _ in 0..CLIMB {
        let around = [[0, 1], [1, 0], [1, 2], [2, 1]].map(|[du, dv]| [at[0] + du - 1, at[1] + dv - 1]);
        // Of equal ones, the last.
        let (mut best, mut greatest) = (at, f64::NEG_INFINITY);
        for one in around {
            let measure = measure(one);
            if measure.total_cmp(&greatest).is_ge() {
                (best, greatest) = (one, measure);
            }
        }
        if greatest <= measure(at) {
            break;
        }
        at = best;
    }
    let middle = measure(at);
    let vertex = |below: f64, above: f64| {
        let bend = below - 2.0 * middle + above;
        if bend < 0.0 { (0.5 * (below - above) / bend).clamp(-0.5, 0.5) } else { 0.0 }
    };
    let along_u = vertex(measure([at[0] - 1, at[1]]), measure([at[0] + 1, at[1]]));
    let along_v = vertex(measure([at[0], at[1] - 1]), measure([at[0], at[1] + 1]));
    [(u + at[0] - first) as f64 + along_u, (v + at[1] - first) as f64 + along_v]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    #[test]
    fn the_contrast_of_a_corner_is_the_greatest_at_which_nine_neighbours_of_the_circle_pass() {
        let mut random = Random::new(41);
        for round in 0..2000 {
            let mut off: [f32; 16] = std::array::from_fn(|_| random.between(-20.0, 20.0) as f32);
            // Corners of either kind whose arc begins anywhere.
            if round % 2 == 0 {
                let sign = if round % 4 == 0 { 1.0 } else { -1.0 };
                (0..9 + round % 3).for_each(|step| off[(round + step) % 16] = sign * random.between(6.0, 30.0) as f32);
            }
            let passes = |level: f32| {
                (0..16).any(|first| {
                    let mut arc = (0..9).map(|step| off[(first + step) % 16]);
                    arc.clone().all(|off| off >= level) || arc.all(|off| off <= -level)
                })
            };
            let contrast = contrast(&off);
            let levels = off.iter().map(|off| off.abs()).filter(|&level| passes(level));
            let greatest = levels.fold(0.0, f32::max);
            assert_eq!(contrast.max(0.0), greatest, "{off:?}");
        }
    }
}
