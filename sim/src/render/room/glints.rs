//! Determines where on glossy faces lamps can be seen reflected, so that other pixels need not search for them.

use nalgebra::{Point3, Vector3};

use crate::place::light::{Occluders, Shape};

/// Distance, in standard deviations, at which the bump through which mirror.wgsl blurs lamps ends, √20/2, with a margin for cells across
/// which the ray's length changes.
const BUMP_REACH: f64 = 2.236 * 1.3;
/// Distance, in standard deviations, at which the bell through which a bulb is blurred has fallen below 10⁻⁶ of its height.
const BELL_REACH: f64 = 5.3;
/// Least roughness in radians that is assumed for a glossy surface, as in mirror.wgsl.
const LEAST_ROUGHNESS_RAD: f64 = 0.002;

/// Distance from the surfaces that they leave and meet at which rays begin and end, so that these surfaces do not block the rays.
const OFF_M: f64 = 0.002;

/// A cell of a glossy face of the building, in which lamps may be seen reflected.
#[derive(Clone, Debug)]
pub(super) struct GlossyCell {
    pub(super) corners: [Point3<f64>; 4],
    /// Unit normal of the glossy cell.
    pub(super) normal: Vector3<f64>,
    pub(super) roughness_rad: f64,
    /// Indices of the lamps, in their order on the device, from which at least some light reaches the glossy cell.
    pub(super) lamps: Vec<u32>,
}

impl GlossyCell {
    /// Whether light can come straight from some point of a lamp to the middle of the glossy cell or to one of its corners.
    pub(super) fn sees(&self, lamp: &Shape, occluders: &Occluders) -> bool {
        let middle = Point3::from(self.corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0);
        let places = match *lamp {
            Shape::Rectangle { centre, half_u, half_v } => {
                let towards = half_u.cross(&half_v).normalize() * OFF_M;
                let corner = |(u, v): (f64, f64)| centre + half_u * (0.95 * u) + half_v * (0.95 * v) + towards;
                [(0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec()
            }
            Shape::Point { at, .. } => vec![at],
        };
        let on_cell = self.corners.iter().map(|corner| corner + (middle - corner) * 0.05).chain([middle]);
        on_cell.map(|at| at + self.normal * OFF_M).any(|at| places.iter().any(|place| !occluders.block(at, *place)))
    }

    /// Whether a lamp may be seen reflected in the glossy cell from `eye`. The answer is on the safe side: it may be true although the lamp
    /// cannot be seen.
    pub(super) fn shows(&self, eye: Point3<f64>, lamp: &Shape) -> bool {
        let roughness = self.roughness_rad.max(LEAST_ROUGHNESS_RAD);
        // An eye that is mirrored at the glossy cell's plane sees straight through the cell what the real eye sees reflected in it.
        let mirrored_eye = eye - self.normal * (2.0 * self.normal.dot(&(eye - self.corners[0])));
        match *lamp {
            Shape::Rectangle { centre, half_u, half_v } => {
                self.shows_rectangle(mirrored_eye, centre, [half_u, half_v], roughness)
            }
            Shape::Point { at, radius_m } => self.shows_bulb(mirrored_eye, at, radius_m, roughness),
        }
    }

    /// Whether a rectangular lamp may be seen reflected in the glossy cell. The rays through the cell's corners meet the lamp's plane at
    /// the corners of a figure that contains all rays through the cell.
    fn shows_rectangle(
        &self,
        mirrored_eye: Point3<f64>,
        centre: Point3<f64>,
        halves: [Vector3<f64>; 2],
        roughness: f64,
    ) -> bool {
        let normal = halves[0].cross(&halves[1]).normalize();
        let rays = self.corners.map(|corner| (corner - mirrored_eye).normalize());
        let heights_m = self.corners.map(|corner| normal.dot(&(corner - centre)));
        let sinking = rays.map(|ray| -normal.dot(&ray));
        if heights_m.iter().all(|height_m| *height_m <= 0.0) || sinking.iter().all(|share| *share <= 0.0) {
            return false;
        }
        // Some rays through the cell's corners run past the lamp's plane, so that they have no figure of intersections with it.
        if heights_m.iter().any(|height_m| *height_m <= 0.0) || sinking.iter().any(|share| *share <= 1e-3) {
            return true;
        }
        let lengths_m: [f64; 4] = std::array::from_fn(|index| heights_m[index] / sinking[index]);
        let reach_m = BUMP_REACH * roughness * lengths_m.into_iter().fold(0.0, f64::max);
        halves.into_iter().all(|half| {
            let half_m = half.norm();
            let along =
                |index: usize| (self.corners[index] + rays[index] * lengths_m[index] - centre).dot(&half) / half_m;
            let places_m: [f64; 4] = std::array::from_fn(along);
            let low_m = places_m.into_iter().fold(f64::INFINITY, f64::min);
            let high_m = places_m.into_iter().fold(f64::NEG_INFINITY, f64::max);
            low_m - reach_m < half_m && high_m + reach_m > -half_m
        })
    }

    /// Whether a bulb may be seen reflected in the glossy cell: compares the angle between ray and bulb in the cell's middle with the blur
    /// and with how much the angle can differ in the corners.
    fn shows_bulb(&self, mirrored_eye: Point3<f64>, at: Point3<f64>, radius_m: f64, roughness: f64) -> bool {
        let middle = Point3::from(self.corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() / 4.0);
        let half_m = (self.corners[0] - middle).norm();
        let (ray, way) = (middle - mirrored_eye, at - middle);
        let (from_eye_m, from_bulb_m) = (ray.norm() - half_m, way.norm() - half_m);
        if from_eye_m <= 0.0 || from_bulb_m <= 0.0 {
            return true;
        }
        let differs_rad = half_m / from_eye_m + half_m / from_bulb_m;
        let spread = roughness.max(0.5 * radius_m / from_bulb_m);
        ray.angle(&way) - differs_rad < (BELL_REACH * spread).atan()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::vector;

    use super::*;

    /// A square of floor with sides of half a metre, centred on the x axis at the given x.
    fn floor_cell(x_m: f64) -> GlossyCell {
        let corner = |dx: f64, dy: f64| Point3::new(x_m + dx, dy, 0.0);
        GlossyCell {
            corners: [corner(-0.25, -0.25), corner(0.25, -0.25), corner(0.25, 0.25), corner(-0.25, 0.25)],
            normal: Vector3::z(),
            roughness_rad: 0.03,
            lamps: Vec::new(),
        }
    }

    #[test]
    fn a_panel_is_seen_where_the_angles_of_incidence_and_reflection_are_equal() {
        // Eye and lamp panel are 1 m and 2 m above the floor and 3 m apart, so that the reflected ray meets the floor at a third of the distance.
        // Half of the lamp's side of 0.4 m covers 0.07 m of the floor, and its blur, 0.09 rad over the ray's 2.8 m, another 0.08 m. Cells 1 m
        // away show nothing.
        let eye = Point3::new(0.0, 0.0, 1.0);
        let (centre, halves) = (Point3::new(3.0, 0.0, 2.0), [vector![0.0, 0.2, 0.0], vector![0.2, 0.0, 0.0]]);
        let shows = |x_m: f64| {
            let cell = floor_cell(x_m);
            let mirrored = Point3::new(eye.x, eye.y, -eye.z);
            cell.shows_rectangle(mirrored, centre, halves, cell.roughness_rad)
        };
        assert!(shows(1.0) && shows(1.2));
        assert!(!shows(2.0) && !shows(0.0));
    }

    #[test]
    fn a_bulb_is_seen_where_the_angles_of_incidence_and_reflection_are_equal() {
        let mirrored = Point3::new(0.0, 0.0, -1.0);
        let shows = |x_m: f64| floor_cell(x_m).shows_bulb(mirrored, Point3::new(3.0, 0.0, 2.0), 0.03, 0.01);
        assert!(shows(1.0) && shows(1.2));
        assert!(!shows(2.5) && !shows(-1.0));
    }
}
