//! Alignment of a landmark's patch with an image, to a fraction of a pixel.
//!
//! The model of the image I at the warped point q + M·y of the patch T, with y counted from the landmark, is
//!
//! ```text
//! I(q + M·y) = g·[ T(y + d + D·y + y·(b·y)) + k:∇∇T ] + (h·y)·T + o
//! ```
//!
//! with a displacement d, a linear change D, perspective b, a difference of blur k, gain g with gradient h, and offset o. It is linear in all of them
//! once T is expanded about y, so that the columns come from the patch alone and are computed once: the inverse compositional form of Lucas and
//! Kanade's method (Baker and Matthews, *Lucas-Kanade 20 years on*, IJCV 56, 2004). Each step solves for all and applies d and D to the warp.

use nalgebra::{Cholesky, Const, Matrix2, SMatrix, SVector, Vector2};

use crate::vision::forward::Picture;

use super::patch::{COARSE, FINE, GAIN, LANES, OFFSET, RADIUS_PX as REACH_PX, Template, UNIT_PX, dot, dots};
use super::smoothing::{Between, is_inside};

/// Steps of a coarse alignment. It starts within about 4 px and comes within half a pixel.
const COARSE_STEPS: usize = 8;
/// Greatest number of steps of a fine alignment; two of three need four.
const FINE_STEPS: usize = 12;
/// A step that displaces by less than this, in pixels of the patch, ends the alignment.
const SETTLED_PX: f64 = 0.005;
/// Greatest displacement of one step, in pixels of the patch: beyond it the expansion of T says nothing.
const LONGEST_STEP_PX: f64 = 3.0;
/// Greatest displacement from where an alignment starts, in pixels of the patch.
const FARTHEST_PX: f64 = 8.0;
/// Least and greatest factor by which a warp may shorten or lengthen the patch, relative to the scale that was expected: a slant of 45° in either
/// image gives 0.7 and 1.4.
const STRETCH: [f64; 2] = [0.5, 1.8];
/// Share of the patch's contrast that the model is taken to leave unexplained while the warp is still wrong.
const UNSETTLED_SHARE: f64 = 0.05;

/// An affine map from a patch, in pixels counted from the landmark, to an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Warp {
    /// Where the landmark is in the image.
    pub(super) origin_px: [f64; 2],
    /// Change of the position in the image, in pixels, per pixel of the patch.
    pub(super) image_from_patch: Matrix2<f64>,
}

impl Warp {
    /// The warp that turns by an angle, positive from u towards v, and enlarges.
    pub(super) fn similarity(origin_px: [f64; 2], scale: f64, turn_rad: f64) -> Warp {
        let (sin, cos) = turn_rad.sin_cos();
        Warp { origin_px, image_from_patch: Matrix2::new(cos, -sin, sin, cos) * scale }
    }

    /// The warp after the patch was found to be displaced by d + D·y, in pixels of the patch; `None` if D is singular or too large.
    fn composed(&self, [d_u, d_v]: [f64; 2], change: Matrix2<f64>) -> Option<Warp> {
        // T(z) at z = y + d + D·y is what the image shows at q + M·y, so that y = (1 + D)⁻¹(z − d).
        let image_from_patch = self.image_from_patch * (Matrix2::identity() + change).try_inverse()?;
        let moved = image_from_patch * Vector2::new(d_u, d_v);
        Some(Warp { origin_px: [self.origin_px[0] - moved.x, self.origin_px[1] - moved.y], image_from_patch })
    }

    /// Whether the warp is near a similarity of the given scale, without mirroring.
    fn is_likely(&self, scale: f64) -> bool {
        let stretches = self.image_from_patch.singular_values() / scale;
        self.image_from_patch.determinant() > 0.0 && stretches.iter().all(|s| (STRETCH[0]..STRETCH[1]).contains(s))
    }
}

/// Standard deviations of the parameters before anything is seen, in the units of the template's columns. They hold back what the patch does not
/// determine: an edge through the landmark, for instance, looks the same at any scale.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior<const P: usize> {
    pub(super) deviations: [f64; P],
}

/// An aligned patch.
pub(super) struct Aligned {
    pub(super) warp: Warp,
    /// Zero-mean normalised cross-correlation of the image and the fitted model.
    pub(super) zncc: f64,
    /// Contrast of the image as a multiple of the patch's.
    pub(super) gain: f64,
    /// Mean square of what the model leaves of the image, in squared grey levels of the patch.
    pub(super) residual: f64,
    /// Mean grey level of the image over the patch.
    pub(super) mean_grey: f64,
}

/// An image at the resolution of an alignment: its pixel (0, 0) lies at `first_px` of the full image, and its pixels are `pitch_px` apart.
#[derive(Clone, Copy)]
pub(super) struct Plane<'a> {
    picture: &'a Picture,
    first_px: f64,
    pitch_px: f64,
}

impl<'a> Plane<'a> {
    pub(super) fn fine(picture: &'a Picture) -> Plane<'a> {
        Plane { picture, first_px: 0.0, pitch_px: 1.0 }
    }

    pub(super) fn coarse(picture: &'a Picture) -> Plane<'a> {
        Plane { picture, first_px: 0.5, pitch_px: 2.0 }
    }

    /// Grey levels at the warped points; `None` if one may be outside of the image.
    fn at(self, points_px: &[[f32; 2]], warp: &Warp) -> Option<Vec<f32>> {
        let origin = warp.origin_px.map(|at| (at - self.first_px) / self.pitch_px);
        let matrix = warp.image_from_patch / self.pitch_px;
        // One pixel more, because positions are rounded to single precision.
        if !is_inside(self.picture, origin, greatest_stretch(&matrix) * REACH_PX + 1.0) {
            return None;
        }
        let ([u, v], m) = (origin.map(|at| at as f32), matrix.map(|part| part as f32));
        let place = |[x, y]: [f32; 2]| [u + m.m11 * x + m.m12 * y, v + m.m21 * x + m.m22 * y];
        let (chunks, rest) = points_px.as_chunks::<LANES>();
        let mut levels = Vec::with_capacity(points_px.len());
        for chunk in chunks {
            let places = chunk.map(place);
            let between = Between::new(&[0, 1].map(|axis| places.map(|at| at[axis])));
            levels.extend((0..LANES).map(|lane| between.value(self.picture, lane)));
        }
        let level = |&point: &[f32; 2]| Between::new(&place(point).map(|at| [at])).value(self.picture, 0);
        levels.extend(rest.iter().map(level));
        Some(levels)
    }
}

/// Greatest factor by which a linear map lengthens a vector: its greater singular value.
fn greatest_stretch(matrix: &Matrix2<f64>) -> f64 {
    let (squares, area) = (matrix.norm_squared(), matrix.determinant());
    (0.5 * (squares + (squares * squares - 4.0 * area * area).max(0.0).sqrt())).sqrt()
}

/// Brings a warp that is a few pixels off within half a pixel, on the coarse image. `None` if it does not stay near where it began.
pub(super) fn align_coarsely(
    template: &Template<COARSE>,
    prior: &Prior<COARSE>,
    plane: Plane,
    start: Warp,
) -> Option<Warp> {
    let scale = start.image_from_patch.determinant().sqrt();
    let steps = Steps::new(template, prior)?;
    let mut warp = start;
    for _ in 0..COARSE_STEPS {
        let (next, length_px) = steps.next(template, plane, &warp)?;
        warp = next;
        if length_px < 10.0 * SETTLED_PX {
            break;
        }
    }
    is_near(&start, &warp, scale).then_some(warp)
}

/// Aligns a patch with the fine image, from a warp that is within about a pixel. `None` if the steps do not settle near where they began.
pub(super) fn align(template: &Template<FINE>, prior: &Prior<FINE>, plane: Plane, start: Warp) -> Option<Aligned> {
    let scale = start.image_from_patch.determinant().sqrt();
    let steps = Steps::new(template, prior)?;
    let mut warp = start;
    for _ in 0..FINE_STEPS {
        let (next, length_px) = steps.next(template, plane, &warp)?;
        warp = next;
        if length_px < SETTLED_PX {
            return is_near(&start, &warp, scale).then(|| steps.compare(template, plane, warp)).flatten();
        }
    }
    None
}

fn is_near(start: &Warp, warp: &Warp, scale: f64) -> bool {
    let moved = [0, 1].map(|axis| warp.origin_px[axis] - start.origin_px[axis]);
    moved[0].hypot(moved[1]) < FARTHEST_PX * scale && warp.is_likely(scale)
}

/// The linear system of all steps of an alignment.
struct Steps<const P: usize> {
    /// Factors of JᵀWJ + prior.
    factors: Cholesky<f64, Const<P>>,
}

impl<const P: usize> Steps<P> {
    fn new(template: &Template<P>, prior: &Prior<P>) -> Option<Steps<P>> {
        let noise = (UNSETTLED_SHARE * template.contrast).powi(2) + 1.0;
        Some(Steps { factors: Cholesky::new(with_prior(template, prior, noise))? })
    }

    /// Parameters of an image with the given levels.
    fn solve(&self, template: &Template<P>, levels: &[f32]) -> SVector<f64, P> {
        let weighted: Vec<f32> = levels.iter().zip(&template.weights).map(|(level, weight)| level * weight).collect();
        let mut right = SVector::<f64, P>::zeros();
        dots(&weighted, &template.columns, right.as_mut_slice());
        self.factors.solve(&right)
    }

    /// The warp after one step, and how far the step displaced it in pixels of the patch. `None` if the image does not look like the patch.
    fn next(&self, template: &Template<P>, plane: Plane, warp: &Warp) -> Option<(Warp, f64)> {
        let levels = plane.at(&template.points_px, warp)?;
        let theta = self.solve(template, &levels);
        let gain = theta[GAIN];
        // A negative gain would be an image with dark and bright exchanged.
        if gain < LEAST_GAIN {
            return None;
        }
        let (d, change) = geometry(&theta, gain);
        let length_px = d[0].hypot(d[1]) + UNIT_PX * 0.3 * change.norm();
        let shortened = (LONGEST_STEP_PX / length_px.max(1e-9)).min(1.0);
        Some((warp.composed(d.map(|part| part * shortened), change * shortened)?, length_px))
    }

    /// What the model leaves of the image at a warp.
    fn compare(&self, template: &Template<P>, plane: Plane, warp: Warp) -> Option<Aligned> {
        let levels = plane.at(&template.points_px, &warp)?;
        let theta = self.solve(template, &levels);
        let mut left = levels.clone();
        for (column, part) in template.columns.iter().zip(theta.iter()) {
            left.iter_mut().zip(column).for_each(|(left, change)| *left -= *part as f32 * change);
        }
        let weighted = |values: &[f32]| -> Vec<f32> {
            values.iter().zip(&template.weights).map(|(value, weight)| value * weight).collect()
        };
        let (weights, levels_weighted) = (f64::from(template.weights.iter().sum::<f32>()), weighted(&levels));
        let mean_grey = levels_weighted.iter().map(|&level| f64::from(level)).sum::<f64>() / weights;
        let varied = dot(&levels_weighted, &levels) / weights - mean_grey * mean_grey;
        let residual = dot(&weighted(&left), &left) / weights;
        let zncc = (1.0 - residual / varied.max(1e-9)).max(0.0).sqrt();
        let gain = theta[GAIN];
        Some(Aligned { warp, zncc, gain, residual: residual / (gain * gain), mean_grey })
    }
}

/// Least gain at which an image is taken to show the patch.
const LEAST_GAIN: f64 = 0.1;

/// Displacement and linear change, in pixels of the patch, among the parameters of a fit.
fn geometry<const P: usize>(theta: &SVector<f64, P>, gain: f64) -> ([f64; 2], Matrix2<f64>) {
    let change = Matrix2::new(theta[2], theta[3], theta[4], theta[5]) / (gain * UNIT_PX);
    ([theta[0] / gain, theta[1] / gain], change)
}

/// JᵀWJ + ν²·Σ⁻², with the variance ν² of the noise of a unit of weight and the prior's standard deviations Σ.
pub(super) fn with_prior<const P: usize>(template: &Template<P>, prior: &Prior<P>, noise: f64) -> SMatrix<f64, P, P> {
    let mut matrix = template.normal;
    for (idx, deviation) in prior.deviations.iter().enumerate() {
        // Gain and offset are known by no prior.
        if idx != GAIN && idx != OFFSET {
            matrix[(idx, idx)] += noise / (deviation * deviation);
        }
    }
    matrix
}
