//! Contractor for the pinhole projection of a point in front of a camera, stated without a division.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// Projection of a point in front of a pinhole camera with a known focal length.
///
/// **Constraint.** u · z = f · x, v · z = f · y, z > 0, where (x, y, z) is the point in the camera frame (x right, y down, z forward), (u, v) is
/// its pixel relative to the principal point, and f is the focal length in pixels. The variables are x, y, z, u, v.
///
/// **Sound.** Each product is enclosed, and is inverted by a division with two result intervals, so that a depth interval that reaches 0, or a
/// pixel interval around 0, costs nothing.
///
/// **Not optimal.** The depth z occurs twice; apply the contractor repeatedly, to a fixpoint.
///
/// **Source.** R. Hartley, A. Zisserman, *Multiple View Geometry*, 2nd ed., (6.1), multiplied by z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Focal length in pixels; positive.
    pub focal_px: Interval,
}

impl Contractor<5> for Pinhole {
    fn contract(&self, domain: &mut IntervalBox<5>) -> Outcome {
        let [mut x, mut y, mut z, mut u, mut v] = domain.components();
        z = z.intersect(Interval::new(0.0, f64::INFINITY));
        for (across, pixel) in [(&mut x, &mut u), (&mut y, &mut v)] {
            let product = (*pixel * z).intersect(self.focal_px * *across);
            *across = product.mul_rev(self.focal_px, *across);
            z = product.mul_rev(*pixel, z);
            *pixel = product.mul_rev(z, *pixel);
        }
        // A point at depth 0 is in no image, so the depth has to be positive.
        let behind = z.hi() <= 0.0;
        let left = if behind { IntervalBox::EMPTY } else { IntervalBox::new([x, y, z, u, v]) };
        settle(domain, left, "no point in front of the camera is seen at that pixel")
    }
}
