//! Determines what a picture cannot show, so that it need not be drawn.

use nalgebra::{Isometry3, Point3};

use super::motion::SubFrame;

/// Distance from the camera up to which nothing is drawn (the near plane), as in view.wgsl.
const NEAR_M: f64 = 0.02;
/// Share of the image's size by which rows of a rolling shutter and soft edges may reach beyond the image.
const MARGIN: f64 = 0.1;

/// The viewing cones of a camera at all sub-frames, the instants by which an exposure is approximated.
pub(super) struct Frustum {
    camera_from_world: Vec<Isometry3<f64>>,
    /// Tangents of the angles that limit the viewing cone along u and v: the least in `low`, the greatest in `high`.
    low: [f64; 2],
    high: [f64; 2],
}

impl Frustum {
    /// The viewing cones for an image of the given size and principal point, one for each sub-frame (instant of the exposure).
    pub(super) fn new(frames: &[SubFrame], focal_px: [f64; 2], size_px: [u32; 2], centre_px: [f64; 2]) -> Frustum {
        let tangent = |axis: usize, share: f64| (share * f64::from(size_px[axis]) - centre_px[axis]) / focal_px[axis];
        Frustum {
            camera_from_world: frames.iter().map(|frame| frame.world_from_camera.inverse()).collect(),
            low: [0, 1].map(|axis| tangent(axis, -MARGIN)),
            high: [0, 1].map(|axis| tangent(axis, 1.0 + MARGIN)),
        }
    }

    /// Whether nothing between the given points can be seen, because they all lie beyond the same side of the viewing cone. Sometimes this misses
    /// a thing that cannot be seen, which is then drawn in vain.
    pub(super) fn hides(&self, places: &[Point3<f64>]) -> bool {
        self.camera_from_world.iter().all(|camera_from_world| {
            let seen = || places.iter().map(|place| camera_from_world * place);
            seen().all(|at| at.z < NEAR_M)
                || seen().all(|at| at.x < self.low[0] * at.z)
                || seen().all(|at| at.x > self.high[0] * at.z)
                || seen().all(|at| at.y < self.low[1] * at.z)
                || seen().all(|at| at.y > self.high[1] * at.z)
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, Vector3};

    use super::*;

    fn frame(x_m: f64) -> SubFrame {
        SubFrame {
            world_from_camera: Isometry3::from(Translation3::new(x_m, 0.0, 0.0)),
            turn_rad_per_s: Vector3::zeros(),
            drift_m_per_s: Vector3::zeros(),
            before_end_s: 0.0,
        }
    }

    #[test]
    fn a_thing_is_left_out_only_where_no_sub_frame_shows_it() {
        // The view is 200 px wide at a focal length of 100 px: it shows up to x = z on both sides, with the margin up to x = 1.2·z.
        let view = |frames: &[SubFrame]| Frustum::new(frames, [100.0; 2], [200, 200], [100.0; 2]);
        let square = |x_m: f64, z_m: f64| [[0.0, 0.0], [0.1, 0.1]].map(|[x, y]| Point3::new(x_m + x, y, z_m));
        assert!(!view(&[frame(0.0)]).hides(&square(0.9, 1.0)));
        assert!(!view(&[frame(0.0)]).hides(&square(1.15, 1.0)));
        assert!(view(&[frame(0.0)]).hides(&square(1.25, 1.0)));
        assert!(!view(&[frame(0.0), frame(0.2)]).hides(&square(1.25, 1.0)));
        assert!(view(&[frame(0.0)]).hides(&square(0.0, -1.0)));
        // The points lie beyond opposite sides of the picture. Between them something may be visible, so that it must not be left out.
        assert!(!view(&[frame(0.0)]).hides(&[Point3::new(5.0, 0.0, 1.0), Point3::new(-5.0, 0.0, 1.0)]));
    }
}
