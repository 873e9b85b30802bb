//! The claim of an observation: how far a landmark may be from where the alignment put it.
//!
//! # What a claim relies on
//!
//! A claim says: the image of the surface point that the landmark was created at is within the half widths of the stated position. It holds if
//!
//! - the surface is plane over the patch, and slanted against the line of sight by at most [`ImageBounds::slant`] in both images;
//! - the noise of both images is independent from pixel to pixel, with a variance of at most [`ImageBounds::variance`];
//! - what else differs between the images is a gain that changes linearly over the patch, an offset, and a blur that is symmetric about
//!   mid-exposure;
//! - the match is right: the patch shows the same surface.
//!
//! The last of these is what a quota of false claims is for; the others are declared bounds.
//!
//! # How it is computed
//!
//! All parameters of the model that the patch is aligned by are unknown: each enters with a standard deviation of half of its bound. With the
//! columns J, weights W, bounds Σ and the variance ν² of the noise, the covariance of the displacement is the upper left block of
//! ν²·(JᵀWJ + ν²Σ⁻²)⁻¹. Weights of at most 1 make that too large rather than too small. ν² is the declared noise of both images or, where it is more,
//! what the model leaves of the image. The half width is a number of standard deviations and a constant.

use nalgebra::Matrix2;

use super::alignment::{Aligned, Prior, Warp, with_prior};
use super::patch::{COARSE, FINE, Template, UNIT_PX};

/// Number of standard deviations in a half width.
const SIGMAS: f64 = 5.0;
/// Part of a half width that no noise explains, in pixels: a lens that is sharper than the pixels leaves all edges along a row or a column off by the
/// same few hundredths of a pixel. Without this part, errors of books on shelves were up to 5.2 times the standard deviation from noise, of other
/// textures up to 4.3 times.
const FLOOR_PX: f64 = 0.07;
/// What the model leaves of the image is spread evenly over all its parameters and the rest; the variance of what it hides is taken to be this many
/// times that of what it leaves.
const HIDDEN: f64 = 1.5;
/// Bound of the linear change that an alignment may have missed: the slant of 45° that it starts without.
const CHANGE: f64 = 0.3;
/// Bound of the difference of blur that the template's smoothing does not account for, as half of a difference of variances, in px² of the patch:
/// motion by 3 px in one image alone gives 0.375.
const BLUR_PX2: f64 = 0.6;
/// Bound of the relative change of gain per pixel: a lens that darkens with the fourth power of the cosine has 0.002 at 30° and a focal length of
/// 500 px.
const GAIN_PER_PX: f64 = 0.008;

/// Declared bounds of a camera's images, and of the surfaces that they show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageBounds {
    /// Focal length of the camera, in pixels. The landmarks of its images keep it.
    pub focal_px: f64,
    /// Tangent of the greatest angle between a surface's normal and the line of sight to it.
    pub slant: f64,
    /// Greatest standard deviation of the noise that a pixel has in darkness, in grey levels.
    pub dark_noise_grey: f64,
    /// Least number of photoelectrons per grey level; it determines how much shot noise a pixel's own light adds.
    pub electrons_per_grey: f64,
}

impl ImageBounds {
    /// Variance of the noise of a pixel with this grey level: noise in darkness, shot noise, and rounding to whole grey levels.
    pub fn variance(&self, grey: f64) -> f64 {
        self.dark_noise_grey.powi(2) + grey / self.electrons_per_grey + 1.0 / 12.0
    }

    /// What is known of the parameters of a coarse alignment.
    pub(super) fn coarse_prior() -> Prior<COARSE> {
        let change = 0.5 * CHANGE * UNIT_PX;
        Prior { deviations: [2.0, 2.0, change, change, change, change, 1.0, 1.0] }
    }

    /// What is known of the parameters of a fine alignment, for an image at the given scale, and with a focal length of `enlargement` times that of
    /// the patch's own image.
    pub(super) fn prior(&self, scale: f64, enlargement: f64) -> Prior<FINE> {
        let change = 0.5 * CHANGE * UNIT_PX;
        let gain = 0.5 * GAIN_PER_PX * UNIT_PX;
        let blur = 0.5 * BLUR_PX2;
        // The inverse depth of a plane changes by slant/f per pixel; in the warp from one image to the other, both images' slants count. The patch's own
        // image has a focal length of f/enlargement, and one of its pixels covers `scale` pixels of this image.
        let perspective = 0.5 * self.slant * (enlargement + scale) / self.focal_px * UNIT_PX * UNIT_PX;
        #[rustfmt::skip]
        let deviations = [
            2.0, 2.0,
            change, change, change, change,
            1.0, 1.0,
            gain, gain,
            blur, blur, blur,
            perspective, perspective,
        ];
        Prior { deviations }
    }
}

/// How accurately the parameters of an aligned patch are known.
pub(super) struct Accuracy {
    /// Covariance of the displacement, in px² of the patch.
    displacement: Matrix2<f64>,
    /// Standard deviation of the least known part of the linear change.
    pub(super) change: f64,
}

impl Accuracy {
    /// The accuracy of an alignment; `None` if the patch determines nothing. `patch_grey` is the patch's mean grey level, `enlargement` as for
    /// [`ImageBounds::prior`].
    pub(super) fn of(
        template: &Template<FINE>,
        aligned: &Aligned,
        bounds: &ImageBounds,
        patch_grey: f64,
        enlargement: f64,
    ) -> Option<Accuracy> {
        let scale2 = aligned.warp.image_from_patch.determinant();
        let declared = declared_variance(aligned, bounds, patch_grey);
        // What is left is smooth over the area of the smoothing kernel, 4π times its variance, and counts as one value there.
        let left = aligned.residual * HIDDEN * 4.0 * std::f64::consts::PI * template.variance_px2.max(1.0 / scale2);
        let noise = declared.max(left);
        let prior = bounds.prior(scale2.sqrt(), enlargement);
        let covariance = with_prior(template, &prior, noise).cholesky()?.inverse() * noise;
        let change = (2..6).map(|idx| covariance[(idx, idx)]).fold(0.0, f64::max).sqrt() / UNIT_PX;
        Some(Accuracy { displacement: covariance.fixed_view::<2, 2>(0, 0).into_owned(), change })
    }

    /// Half widths `[u, v]` of the claim, in pixels of the image.
    pub(super) fn half_widths_px(&self, warp: &Warp) -> [f64; 2] {
        let m = warp.image_from_patch;
        let in_image = m * self.displacement * m.transpose();
        let floor_px = FLOOR_PX * m.determinant().sqrt().max(1.0);
        [0, 1].map(|axis| floor_px + SIGMAS * in_image[(axis, axis)].max(0.0).sqrt())
    }
}

/// Declared variance of the noise of the patch and the image together, in squared grey levels of the patch and per pixel of it.
fn declared_variance(aligned: &Aligned, bounds: &ImageBounds, patch_grey: f64) -> f64 {
    // One pixel of the patch covers this many of the image, whose noise it averages.
    let scale2 = aligned.warp.image_from_patch.determinant();
    bounds.variance(patch_grey) + bounds.variance(aligned.mean_grey) / (aligned.gain * aligned.gain * scale2)
}

/// Share of a patch's variance that noise and the model's errors may leave unexplained where the match is right. Of 5360 right matches of synthetic
/// textures, none left more than half of the constant beyond the noise.
pub(super) fn allowed_share(
    template: &Template<FINE>,
    aligned: &Aligned,
    bounds: &ImageBounds,
    patch_grey: f64,
) -> f64 {
    const MODEL: f64 = 0.008;
    // The smoothing leaves this part of the noise; a factor of two is for its scatter.
    let smoothed =
        declared_variance(aligned, bounds, patch_grey) / (4.0 * std::f64::consts::PI * template.variance_px2.max(0.5));
    2.0 * smoothed / (template.contrast * template.contrast) + MODEL
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_perspective_of_a_patch_is_that_of_both_cameras() {
        // A plane at a slant of 45° before a camera of 400 px and one of 600 px that shows it 1.5 times larger: its inverse depth changes by 1/400
        // per pixel of the patch in either. The bound of both together is 0.005, half of it a standard deviation, over 10 px each way.
        let bounds = ImageBounds { focal_px: 600.0, slant: 1.0, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };
        let deviations = bounds.prior(1.5, 600.0 / 400.0).deviations;
        assert!(deviations[13..].iter().all(|deviation| (deviation - 0.25).abs() < 1e-12), "{deviations:?}");
    }
}
