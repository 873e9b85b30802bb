//! Detection of chessboard corners: where black and white squares meet in an image of the board.
//!
//! ```text
//! saddles of the smoothed picture ──> the strongest, as many as the board has ──> sub-pixel ──> grid
//! ```

use image::{GrayImage, ImageBuffer, Luma};
use imageproc::filter::gaussian_blur_f32;
use nalgebra::{Matrix2, Vector2, Vector3};

use super::{Corner, homography};

/// Standard deviation, in pixels, of the smoothing of the image before saddle points are searched in it: larger than the grain of sensor noise,
/// smaller than a square.
const SMOOTHING_PX: f32 = 1.5;
/// Half width, in pixels, of the neighbourhood in which a saddle point has to be the strongest one.
const APART_PX: usize = 5;
/// Half width, in pixels, of the window in which the position of a corner is refined, and the standard deviation of the weights in it: the other
/// corners of the nearest squares stay outside.
const REACH_PX: i64 = 6;
const WEIGHT_PX: f64 = 2.5;
const MOST_STEPS: usize = 30;
/// Greatest distance, in squares, of a corner from the grid place predicted by the board's four outermost corners; lenses bend the board by less.
const OFF_GRID: f64 = 0.4;

/// A chessboard of `columns × rows` squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Number of squares along the board's x axis.
    pub columns: usize,
    /// Number of squares along the board's y axis.
    pub rows: usize,
    /// Side length of a square.
    pub square_m: f64,
}

type Picture = ImageBuffer<Luma<f32>, Vec<f32>>;

/// All `(columns − 1)(rows − 1)` inner corners of a board; `None` unless the whole board is in the image with squares at least some 14 px wide.
///
/// Which of the outermost corners comes first is arbitrary, which changes the board's pose and not the camera.
pub fn find(image: &GrayImage, board: &Board) -> Option<Vec<Corner>> {
    let picture = Picture::from_fn(image.width(), image.height(), |u, v| Luma([f32::from(image.get_pixel(u, v)[0])]));
    let count = board.columns.checked_sub(1)? * board.rows.checked_sub(1)?;
    let mut saddles = saddles(&gaussian_blur_f32(&picture, SMOOTHING_PX));
    saddles.sort_by(|a, b| b.0.total_cmp(&a.0));
    let strongest = saddles.get(..count)?;
    let places: Vec<[f64; 2]> = strongest.iter().map(|(_, at)| sub_pixel(&picture, *at)).collect::<Option<_>>()?;
    on_grid(&places, board)
}

/// Local maxima of the saddle strength I_uv² − I_uu·I_vv, with their strengths.
fn saddles(smooth: &Picture) -> Vec<(f32, [f64; 2])> {
    let (width, height) = (smooth.width() as usize, smooth.height() as usize);
    let grey = |u: usize, v: usize| smooth.as_raw()[v * width + u];
    let mut strengths = vec![0.0_f32; width * height];
    for (u, v) in (1..height.saturating_sub(1)).flat_map(|v| (1..width.saturating_sub(1)).map(move |u| (u, v))) {
        let middle = 2.0 * grey(u, v);
        let uu = grey(u + 1, v) + grey(u - 1, v) - middle;
        let vv = grey(u, v + 1) + grey(u, v - 1) - middle;
        let uv = 0.25 * (grey(u + 1, v + 1) + grey(u - 1, v - 1) - grey(u + 1, v - 1) - grey(u - 1, v + 1));
        strengths[v * width + u] = uv * uv - uu * vv;
    }
    let mut found = Vec::new();
    let margin = APART_PX.max(REACH_PX as usize + 1);
    for (u, v) in (margin..height.saturating_sub(margin))
        .flat_map(|v| (margin..width.saturating_sub(margin)).map(move |u| (u, v)))
    {
        let here = strengths[v * width + u];
        let mut around =
            (v - APART_PX..=v + APART_PX).flat_map(|v| (u - APART_PX..=u + APART_PX).map(move |u| v * width + u));
        // Of neighbouring saddle points with equal strength the last one in the order of pixels is kept.
        if here > 0.0
            && around.all(|other| strengths[other] < here || (strengths[other] == here && other <= v * width + u))
        {
            found.push((here, [u as f64, v as f64]));
        }
    }
    found
}

/// Sub-pixel position q of a corner: the point for which all gradients around it are perpendicular to the lines from q to their pixels p, Σ
/// w·g·gᵀ·(p − q) = 0 (W. Förstner, E. Gülch, ISPRS Intercommission Workshop, 1987). The window of weights w is moved to q until q no longer
/// changes.
fn sub_pixel(picture: &Picture, start: [f64; 2]) -> Option<[f64; 2]> {
    let grey = |u: i64, v: i64| f64::from(picture.get_pixel(u as u32, v as u32)[0]);
    let (width, height) = (i64::from(picture.width()), i64::from(picture.height()));
    let mut at = Vector2::from(start);
    for _ in 0..MOST_STEPS {
        let (mut tensor, mut right) = (Matrix2::zeros(), Vector2::zeros());
        let [u0, v0] = [at.x, at.y].map(|coordinate| coordinate.round() as i64);
        let margin = REACH_PX + 1;
        if u0 < margin || v0 < margin || u0 >= width - margin || v0 >= height - margin {
            return None;
        }
        for (u, v) in (v0 - REACH_PX..=v0 + REACH_PX).flat_map(|v| (u0 - REACH_PX..=u0 + REACH_PX).map(move |u| (u, v)))
        {
            let gradient = 0.5 * Vector2::new(grey(u + 1, v) - grey(u - 1, v), grey(u, v + 1) - grey(u, v - 1));
            let way = Vector2::new(u as f64, v as f64) - at;
            let weight = (-0.5 * way.norm_squared() / (WEIGHT_PX * WEIGHT_PX)).exp();
            let outer = weight * gradient * gradient.transpose();
            tensor += outer;
            right += outer * way;
        }
        let step = tensor.try_inverse()? * right;
        at += step;
        if step.norm() < 1e-4 {
            return ((at - Vector2::from(start)).norm() < APART_PX as f64).then_some(at.into());
        }
    }
    None
}

/// Assigns corners to the board's grid by the homography of the four outermost ones.
fn on_grid(places: &[[f64; 2]], board: &Board) -> Option<Vec<Corner>> {
    // A board that is a single square wide has no inner corner.
    let last = [board.columns.checked_sub(2)?, board.rows.checked_sub(2)?].map(|last| last as f64);
    let outermost = widest_quadrilateral(&hull(places))?;
    let corners = [[0.0, 0.0], [last[0], 0.0], last, [0.0, last[1]]];
    // The first of the four outermost corners is at the start of a long side of the board or of a short one, so both are tried.
    (0..2).find_map(|first| {
        let pairs: Vec<Corner> = (0..4).map(|k| (corners[k], outermost[(first + k) % 4])).collect();
        let grid_from_pixels = homography(&pairs)?;
        let mut taken = vec![false; places.len()];
        let named = |pixel: &[f64; 2]| {
            let at = grid_from_pixels * Vector3::new(pixel[0], pixel[1], 1.0);
            let at = [at.x / at.z, at.y / at.z];
            let node = at.map(f64::round);
            let near = (0..2).all(|k| (at[k] - node[k]).abs() < OFF_GRID && (0.0..=last[k]).contains(&node[k]));
            let index = near.then_some(node[1] as usize * (board.columns - 1) + node[0] as usize)?;
            if std::mem::replace(taken.get_mut(index)?, true) {
                return None;
            }
            Some((*pixel, [0, 1].map(|k| board.square_m * (node[k] - 0.5 * last[k]))))
        };
        places.iter().map(named).collect()
    })
}

/// Convex hull in cyclic order (A. Andrew's monotone chains).
fn hull(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = places.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |ordered: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for place in ordered {
            while chain.len() >= 2 && twice_area(chain[chain.len() - 2], chain[chain.len() - 1], place) <= 0.0 {
                chain.pop();
            }
            chain.push(place);
        }
        chain.pop();
        chain
    };
    let mut around = half(&mut sorted.iter().copied());
    around.extend(half(&mut sorted.iter().rev().copied()));
    around
}

/// The four corners of a convex polygon, in the polygon's order, whose quadrilateral has the greatest area.
fn widest_quadrilateral(hull: &[[f64; 2]]) -> Option<[[f64; 2]; 4]> {
    let mut widest: Option<(f64, [[f64; 2]; 4])> = None;
    for (i, k) in (0..hull.len()).flat_map(|i| (i + 2..hull.len()).map(move |k| (i, k))) {
        // Given the diagonal from corner i to corner k, the corner farthest from it on either side gives the quadrilateral of greatest area.
        let farthest = |range: &mut dyn Iterator<Item = usize>| {
            let area = |j: usize| twice_area(hull[i], hull[k], hull[j]).abs();
            range.map(|j| (area(j), j)).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let one = farthest(&mut (i + 1..k));
        let other = farthest(&mut (k + 1..hull.len()).chain(0..i));
        let (Some((one_area, j)), Some((other_area, l))) = (one, other) else { continue };
        if widest.is_none_or(|(area, _)| one_area + other_area > area) {
            widest = Some((one_area + other_area, [hull[i], hull[j], hull[k], hull[l]]));
        }
    }
    widest.map(|(_, corners)| corners)
}

/// Twice the signed area of a triangle: positive if its corners turn from u towards v.
fn twice_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
