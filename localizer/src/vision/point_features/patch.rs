//! The stored surroundings of a landmark, and what an alignment needs of them.

use std::sync::OnceLock;

use image::GrayImage;
use nalgebra::SMatrix;

use super::smoothing::gaussian;

/// Half of the side, less half a pixel, of the stored square of pixels: the radius of the aligned disc, one pixel for derivatives, and the greatest
/// radius of a smoothing kernel.
const REACH_PX: usize = 18;
const SIDE_PX: usize = 2 * REACH_PX + 1;
/// Variance, in px², of what a camera's pixels and lens are taken to blur by themselves: a square pixel has 1/12, a good lens about as much as a
/// Gaussian of 0.6 px. What they truly blur may differ; the alignment allows for that.
const OPTICS_VARIANCE_PX2: f64 = 0.44;
/// Least variance of the smoothing of a template, so that differences of neighbouring pixels are good derivatives.
const LEAST_VARIANCE_PX2: f64 = 0.3;
/// Length, in pixels, by which coordinates in the patch are divided in the columns of a template, so that all columns are of about the same size.
pub(super) const UNIT_PX: f64 = 10.0;
/// Grey levels of 0 and of at least this are taken for clipped.
const CLIPPED: u8 = 254;
/// Greatest share of clipped pixels in the disc that is aligned.
const MOST_CLIPPED: f64 = 0.03;

/// Grey levels around a point, as its image had them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Patch {
    /// Grey levels of the square around the pixel nearest to the point, row-major.
    levels: Vec<u8>,
}

impl Patch {
    /// Number of grey levels of a patch.
    pub(super) const N_LEVELS: usize = SIDE_PX * SIDE_PX;

    /// Grey levels, row-major.
    pub(super) fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// The patch with these grey levels, [`Patch::N_LEVELS`] of them.
    pub(super) fn of_levels(levels: &[u8]) -> Patch {
        Patch { levels: levels.to_vec() }
    }

    /// The surroundings of the pixel nearest to a point; `None` near the border or where too many pixels are clipped.
    pub(super) fn cut(image: &GrayImage, at_px: [f64; 2]) -> Option<Patch> {
        let size_px = [image.width() as usize, image.height() as usize];
        let [u, v] = at_px.map(|at| at.round() as usize);
        let is_inside = |at: usize, size: usize| at >= REACH_PX && at + REACH_PX < size;
        if !is_inside(u, size_px[0]) || !is_inside(v, size_px[1]) {
            return None;
        }
        let row = |v: usize| &image.as_raw()[v * size_px[0] + u - REACH_PX..][..SIDE_PX];
        let levels = (v - REACH_PX..=v + REACH_PX).flat_map(|v| row(v).iter().copied()).collect();
        let patch = Patch { levels };
        (patch.clipped_share() <= MOST_CLIPPED).then_some(patch)
    }

    /// Share of the disc's pixels that are clipped.
    fn clipped_share(&self) -> f64 {
        let disc = &Grid::fine().places;
        let clipped = disc.iter().filter(|place| {
            let level = self.levels[place.idx];
            level == 0 || level >= CLIPPED
        });
        clipped.count() as f64 / disc.len() as f64
    }

    /// Mean grey level of the patch.
    pub(super) fn mean(&self) -> f64 {
        self.levels.iter().map(|&level| f64::from(level)).sum::<f64>() / self.levels.len() as f64
    }

    /// The patch smoothed by a Gaussian of the given variance. Values within the kernel's radius of the border are meaningless.
    fn smoothed(&self, variance_px2: f64, most_px: usize) -> Vec<f32> {
        let kernel = gaussian(variance_px2, most_px);
        let radius = kernel.len() / 2;
        let mut along_v = vec![0.0f32; SIDE_PX * SIDE_PX];
        for row in radius..SIDE_PX - radius {
            let out = &mut along_v[row * SIDE_PX..(row + 1) * SIDE_PX];
            for (tap, weight) in kernel.iter().enumerate() {
                let row = row + tap - radius;
                for (sum, level) in out.iter_mut().zip(&self.levels[row * SIDE_PX..]) {
                    *sum += weight * f32::from(*level);
                }
            }
        }
        let mut smoothed = vec![0.0f32; SIDE_PX * SIDE_PX];
        for row in radius..SIDE_PX - radius {
            let range = row * SIDE_PX..(row + 1) * SIDE_PX;
            let out = &mut smoothed[range.start + radius..range.end - radius];
            for (tap, weight) in kernel.iter().enumerate() {
                for (sum, value) in out.iter_mut().zip(&along_v[range.start + tap..range.end]) {
                    *sum += weight * value;
                }
            }
        }
        smoothed
    }
}

/// Greatest distance of a point of a template from its landmark, with the landmark's offset from the middle pixel.
pub(super) const RADIUS_PX: f64 = 12.5;

/// Pixels of a patch at which it is compared with an image: a disc around its middle.
struct Grid {
    places: Vec<Place>,
    /// Greatest radius of the template's smoothing.
    smoothing_px: usize,
}

/// One pixel of a grid.
struct Place {
    /// Index of the pixel in the patch.
    idx: usize,
    /// Position relative to the middle pixel.
    from_middle_px: [f32; 2],
    weight: f32,
}

impl Grid {
    fn fine() -> &'static Grid {
        static GRID: OnceLock<Grid> = OnceLock::new();
        GRID.get_or_init(|| Grid::new(10.5, 1, 7))
    }

    fn coarse() -> &'static Grid {
        static GRID: OnceLock<Grid> = OnceLock::new();
        GRID.get_or_init(|| Grid::new(11.5, 2, 6))
    }

    fn new(radius_px: f64, step_px: usize, smoothing_px: usize) -> Grid {
        let reach = (radius_px / step_px as f64) as i32 * step_px as i32;
        let steps = move || (-reach..=reach).step_by(step_px);
        let idx = |at: i32| (REACH_PX as i32 + at) as usize;
        let place = |[x, y]: [i32; 2]| {
            // The weight is less towards the rim, so that what is just outside hardly matters.
            let share = f64::from(x).hypot(f64::from(y)) / (radius_px + 1.0);
            let from_middle_px = [x, y].map(|at| at as f32);
            Place { idx: idx(y) * SIDE_PX + idx(x), from_middle_px, weight: (1.0 - share.powi(4)) as f32 }
        };
        let is_in_disc = |[x, y]: &[i32; 2]| f64::from(*x).hypot(f64::from(*y)) <= radius_px;
        let places = steps().flat_map(|y| steps().map(move |x| [x, y])).filter(is_in_disc).map(place).collect();
        Grid { places, smoothing_px }
    }
}

/// A patch prepared for alignment: how its grey levels change with each of `P` parameters.
pub(super) struct Template<const P: usize> {
    /// Positions relative to the landmark at which an image is compared with the patch, in pixels of the patch.
    pub(super) points_px: Vec<[f32; 2]>,
    /// Weight of each point, less towards the rim of the disc.
    pub(super) weights: Vec<f32>,
    /// For each parameter, the change of grey level with it at each point.
    pub(super) columns: [Vec<f32>; P],
    /// JᵀWJ of the columns J and the weights W.
    pub(super) normal: SMatrix<f64, P, P>,
    /// Weighted standard deviation of the patch's grey levels.
    pub(super) contrast: f64,
    /// Variance of the smoothing of the patch.
    pub(super) variance_px2: f64,
}

/// Number of parameters of a coarse alignment: displacement (2), the four numbers of a linear map, gain, offset.
pub(super) const COARSE: usize = 8;
/// Number of parameters of a fine alignment: those of a coarse one, the gain's gradient (2), the difference of blur (3), and perspective (2).
pub(super) const FINE: usize = 15;
/// Index of the gain among the parameters.
pub(super) const GAIN: usize = 6;
/// Index of the offset among the parameters.
pub(super) const OFFSET: usize = 7;

impl<const P: usize> Template<P> {
    /// A template of which the blur is that of an image at the given scale.
    ///
    /// `offset_px` is the landmark's position relative to the patch's middle pixel, `image_variance_px2` what the processing of the image blurs.
    fn new(patch: &Patch, offset_px: [f64; 2], scale: f64, image_variance_px2: f64) -> Template<P> {
        let grid = if P == FINE { Grid::fine() } else { Grid::coarse() };
        // The image blurs by its optics and its processing, both in pixels of the image, of which one is 1/scale of the patch's.
        let total_px2 = (OPTICS_VARIANCE_PX2 + image_variance_px2) / (scale * scale);
        let variance_px2 = (total_px2 - OPTICS_VARIANCE_PX2).max(LEAST_VARIANCE_PX2);
        let smoothed = patch.smoothed(variance_px2, grid.smoothing_px);
        let places = &grid.places;
        let offset_px = offset_px.map(|part| part as f32);
        let from_landmark_px = |place: &Place| [0, 1].map(|axis| place.from_middle_px[axis] - offset_px[axis]);
        let weights: Vec<f32> = places.iter().map(|place| place.weight).collect();
        let levels: Vec<f32> = places.iter().map(|place| smoothed[place.idx]).collect();
        let sum = f64::from(weights.iter().sum::<f32>());
        let mean = (dot(&levels, &weights) / sum) as f32;
        let mut columns = [(); P].map(|()| vec![0.0; places.len()]);
        for (at, place) in places.iter().enumerate() {
            let row = changes(&smoothed, place.idx, from_landmark_px(place), mean);
            columns.iter_mut().zip(row).for_each(|(column, change)| column[at] = change);
        }
        let mut normal = SMatrix::zeros();
        let mut scaled = weights.clone();
        for row in 0..P {
            for (scaled, (change, weight)) in scaled.iter_mut().zip(columns[row].iter().zip(&weights)) {
                *scaled = change * weight;
            }
            let mut products = [0.0; P];
            dots(&scaled, &columns[..=row], &mut products[..=row]);
            for (column, product) in products.into_iter().enumerate().take(row + 1) {
                normal[(row, column)] = product;
                normal[(column, row)] = product;
            }
        }
        let contrast = (normal[(GAIN, GAIN)] / sum).sqrt();
        let points_px = places.iter().map(from_landmark_px).collect();
        Template { points_px, weights, columns, normal, contrast, variance_px2 }
    }
}

/// How the grey level of one point changes with each parameter. Coordinates from the landmark are in [`UNIT_PX`].
fn changes(smoothed: &[f32], idx: usize, from_landmark_px: [f32; 2], mean: f32) -> [f32; FINE] {
    let at = |du: isize, dv: isize| smoothed[idx.wrapping_add_signed(dv * SIDE_PX as isize + du)];
    let middle = at(0, 0);
    let (t_x, t_y) = (0.5 * (at(1, 0) - at(-1, 0)), 0.5 * (at(0, 1) - at(0, -1)));
    let t_xx = at(1, 0) - 2.0 * middle + at(-1, 0);
    let t_yy = at(0, 1) - 2.0 * middle + at(0, -1);
    let t_xy = 0.25 * (at(1, 1) - at(-1, 1) - at(1, -1) + at(-1, -1));
    let [x, y] = from_landmark_px.map(|at| at / UNIT_PX as f32);
    let outward = t_x * x + t_y * y;
    let t = middle - mean;
    #[rustfmt::skip]
    let changes = [
        t_x, t_y,
        t_x * x, t_x * y, t_y * x, t_y * y,
        t, 1.0,
        t * x, t * y,
        t_xx, t_xy, t_yy,
        outward * x, outward * y,
    ];
    changes
}

/// Number of parts of a sum of products that the compiler adds side by side.
pub(super) const LANES: usize = 8;

/// Sum of products.
pub(super) fn dot(one: &[f32], other: &[f32]) -> f64 {
    let [sum] = dots_of(one, [other]);
    sum
}

/// Sums of products of a list with each of several others, one for each. Up to four are computed side by side.
pub(super) fn dots(one: &[f32], others: &[Vec<f32>], sums: &mut [f64]) {
    for (sums, others) in sums.chunks_mut(4).zip(others.chunks(4)) {
        match others {
            [a, b, c, d] => sums.copy_from_slice(&dots_of(one, [a, b, c, d])),
            [a, b, c] => sums.copy_from_slice(&dots_of(one, [a, b, c])),
            _ => sums.iter_mut().zip(others).for_each(|(sum, other)| *sum = dot(one, other)),
        }
    }
}

fn dots_of<const N: usize>(one: &[f32], others: [&[f32]; N]) -> [f64; N] {
    let (ones, rest) = one.as_chunks::<LANES>();
    let others = others.map(|other| other.as_chunks::<LANES>());
    let mut sums = [[0.0f32; LANES]; N];
    for (at, a) in ones.iter().enumerate() {
        for (sums, (others, _)) in sums.iter_mut().zip(&others) {
            let b = &others[at];
            (0..LANES).for_each(|lane| sums[lane] += a[lane] * b[lane]);
        }
    }
    std::array::from_fn(|which| {
        let rest: f32 = rest.iter().zip(others[which].1).map(|(a, b)| a * b).sum();
        sums[which].iter().map(|&sum| f64::from(sum)).sum::<f64>() + f64::from(rest)
    })
}

impl Template<FINE> {
    /// The template of a fine alignment, for an image at the given scale that has been smoothed by `image_variance_px2`.
    pub(super) fn fine(patch: &Patch, offset_px: [f64; 2], scale: f64, image_variance_px2: f64) -> Template<FINE> {
        Template::new(patch, offset_px, scale, image_variance_px2)
    }
}

impl Template<COARSE> {
    /// The template of a coarse alignment, for an image at the given scale that has been blurred by `image_variance_px2`.
    pub(super) fn coarse(patch: &Patch, offset_px: [f64; 2], scale: f64, image_variance_px2: f64) -> Template<COARSE> {
        Template::new(patch, offset_px, scale, image_variance_px2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    #[test]
    fn sums_of_products_are_those_of_all_pairs_of_lists() {
        let mut random = Random::new(51);
        for length in [0, 1, 7, 8, 30] {
            let mut list = || -> Vec<f32> { (0..length).map(|_| random.between(-1.0, 1.0) as f32).collect() };
            let one = list();
            for n_others in 0..10 {
                let others: Vec<Vec<f32>> = (0..n_others).map(|_| list()).collect();
                let mut sums = vec![f64::NAN; n_others];
                dots(&one, &others, &mut sums);
                for (other, sum) in others.iter().zip(sums) {
                    let expected: f64 = one.iter().zip(other).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum();
                    assert!((sum - expected).abs() < 1e-5, "{length}, {n_others}: {sum} {expected}");
                }
            }
        }
    }
}
