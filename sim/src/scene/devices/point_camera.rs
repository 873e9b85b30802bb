//! Keys of the point camera, which tells where in its image it sees which landmark, and the tolerances of its errors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A camera with a front end that finds landmarks in its image and knows them again. Its readings are image points with a bounded error, as in the
/// numerical experiment of paper 4; no image is rendered.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PointCamera {
    /// Number of pixel columns of the point camera.
    #[schemars(range(min = 16, max = 10000))]
    pub width_px: u32,
    /// Number of pixel rows of the point camera.
    #[schemars(range(min = 16, max = 10000))]
    pub height_px: u32,
    /// Nominal focal length of the point camera.
    #[schemars(range(min = 10.0, max = 10000.0))]
    pub focal_px: f64,
    /// Bound `point_camera.focal`: greatest error of the focal length, as a share of its nominal value; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub focal_tolerance: f64,
    /// Bound `point_camera.centre`: greatest distance, along u and along v, of the principal point from the middle of the image; drawn at random.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub centre_tolerance_px: f64,
    /// Bound `point_camera.points`: greatest error of an image point, along u and along v; drawn at random for each.
    #[schemars(range(min = 0.001, max = 20.0))]
    pub point_tolerance_px: f64,
    /// Distance of the optical centre forward of the wheel axle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the optical centre to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Bounds `point_camera.position` and `point_camera.height`: greatest error of the point camera's mounted position, forward, left and up each;
    /// drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Nominal direction of the optical axis, counter-clockwise from robot forward. Any angle.
    pub yaw_deg: f64,
    /// Upward tilt of the point camera's optical axis.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub tilt_up_deg: f64,
    /// Bounds `point_camera.yaw` and `point_camera.tilt`: greatest error of the point camera's yaw on its mount, and greatest angle of its vertical to
    /// the nominal one; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub angle_tolerance_deg: f64,
    /// Bound `point_camera.least_depth`: least depth, along the optical axis, at which the point camera finds a landmark.
    #[schemars(range(min = 0.05, max = 100.0))]
    pub least_depth_m: f64,
    /// Greatest depth at which the point camera finds a landmark.
    #[schemars(range(min = 0.1, max = 10000.0))]
    pub greatest_depth_m: f64,
    /// Greatest number of landmarks of one image; where more are in view, those with the least numbers are found.
    #[schemars(range(min = 1, max = 1000))]
    pub most_points: usize,
    /// Time between two images of the point camera.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub period_s: f64,
    /// Time from the exposure of an image to the delivery of its points.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Bound `point_camera.stamp`: greatest error of an image's stamp against the true time, drawn at random for each image.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
}

impl PointCamera {
    /// Middle of the image, which is the nominal principal point; 0 is the centre of the first pixel.
    pub fn centre_px(&self) -> [f64; 2] {
        [self.width_px, self.height_px].map(|size| 0.5 * (f64::from(size) - 1.0))
    }

    /// Bounds on the point camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.003, "angle_tolerance_deg": 0.3, "focal_tolerance": 0.003,
            "centre_tolerance_px": 2.0,
        }))
    }
}

impl Default for PointCamera {
    /// The camera of paper 4's numerical experiment: 640 × 480 pixels, a focal length of 320 and an error of one pixel.
    fn default() -> Self {
        PointCamera {
            width_px: 640,
            height_px: 480,
            focal_px: 320.0,
            focal_tolerance: 0.001,
            centre_tolerance_px: 0.5,
            point_tolerance_px: 1.0,
            forward_m: 0.1,
            left_m: 0.0,
            height_m: 0.4,
            position_tolerance_m: 0.001,
            yaw_deg: 0.0,
            tilt_up_deg: 0.0,
            angle_tolerance_deg: 0.1,
            least_depth_m: 0.4,
            greatest_depth_m: 30.0,
            most_points: 40,
            period_s: 0.1,
            latency_s: 0.05,
            stamp_tolerance_s: 0.0005,
        }
    }
}
