//! The lens of the ceiling camera, by its nominal values.
//!
//! Dots are measured in the picture as it was taken, so that nothing is resampled. Whether they form a marker is decided where a pinhole would show
//! them: there a marker's grid is straight, evenly spaced and equally large all over the picture.

use crate::vision::distortion;

/// A lens by Brown and Conrady's model, with the focal lengths and the principal point that belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Coefficients k1, k2, p1, p2, k3, in OpenCV's order.
    pub distortion: [f64; 5],
    /// Focal lengths along u and v.
    pub focal_px: [f64; 2],
    /// Principal point, `[u, v]`.
    pub centre_px: [f64; 2],
}

/// What a lens does about one place of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bend {
    /// Where a pinhole would show what the lens shows at the place.
    pub(super) pinhole_px: [f64; 2],
    /// Least and greatest factor by which the lens stretches a short way in the pinhole's picture.
    pub(super) stretch: [f64; 2],
}

impl Bend {
    /// Factor by which the lens stretches a small area.
    pub(super) fn area(&self) -> f64 {
        self.stretch[0] * self.stretch[1]
    }
}

/// Distances from the middle of a disc, in radii, and weights of the points by which a polynomial of degree five is averaged over the disc: the middle
/// and six points around it (A. H. Stroud, *Approximate Calculation of Multiple Integrals*, 1971, formula S2 5-1).
const RING: f64 = 0.816_496_580_927_726;
const MIDDLE_WEIGHT: f64 = 0.25;
const RING_WEIGHT: f64 = 0.125;

impl Lens {
    /// What the lens does about a place of the picture as taken; `None` where the lens folds (shows two points at one place).
    pub(super) fn about(&self, raw_px: [f64; 2]) -> Option<Bend> {
        let at = distortion::unbent_point(self.distortion, self.in_focal_lengths(raw_px))?;
        let [a, mixed, b] = distortion::slopes(self.distortion, at);
        let (middle, half) = (0.5 * (a + b), (0.5 * (a - b)).hypot(mixed));
        Some(Bend { pinhole_px: self.in_pixels(at), stretch: [middle - half, middle + half] })
    }

    /// Where the lens shows what a pinhole would show at a place.
    pub(super) fn bent_px(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let at = self.in_focal_lengths(pinhole_px);
        let by = distortion::bend(self.distortion, at);
        self.in_pixels([at[0] + by[0], at[1] + by[1]])
    }

    /// Distance by which the centroid of a disc's image lies beside the image of the disc's centre, as the lens does not stretch all of the disc
    /// alike. The disc is given as a pinhole would show it.
    pub(super) fn centroid_shift_px(&self, pinhole_px: [f64; 2], radius_px: f64) -> f64 {
        let weighted = |offset: [f64; 2], weight: f64| {
            let at_px = [pinhole_px[0] + radius_px * offset[0], pinhole_px[1] + radius_px * offset[1]];
            let [a, mixed, b] = distortion::slopes(self.distortion, self.in_focal_lengths(at_px));
            (self.bent_px(at_px), weight * (a * b - mixed * mixed))
        };
        let ring = (0..6).map(|corner| {
            let (sin, cos) = (f64::from(corner) * std::f64::consts::FRAC_PI_3).sin_cos();
            weighted([RING * cos, RING * sin], RING_WEIGHT)
        });
        let (mut sum, mut total) = ([0.0; 2], 0.0);
        for (at_px, weight) in ring.chain([weighted([0.0; 2], MIDDLE_WEIGHT)]) {
            (0..2).for_each(|axis| sum[axis] += weight * at_px[axis]);
            total += weight;
        }
        let centre_px = self.bent_px(pinhole_px);
        (sum[0] / total - centre_px[0]).hypot(sum[1] / total - centre_px[1])
    }

    fn in_focal_lengths(&self, px: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (px[axis] - self.centre_px[axis]) / self.focal_px[axis])
    }

    fn in_pixels(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.focal_px[axis] * at[axis] + self.centre_px[axis])
    }
}

#[cfg(test)]
mod tests;
