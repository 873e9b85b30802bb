//! Places of coded landmarks in the robot frame, by a range camera.

use interval::Interval;
use localizer::{
    Reading, RobotModel,
    motion::Twist,
    reading::Sighting,
    robot::{BodyModel, RangeCameraModel},
};
use nalgebra::{Matrix2, Vector2};

use super::{Landmark, Mount, SIGMAS_OF_BOUND, Seen, stray, turned};

/// Landmarks as the range camera sees them.
pub(crate) struct Range {
    camera: RangeCameraModel,
    body: BodyModel,
}

/// Least disparity in its own standard deviations with which a landmark is used: farther away, its distance is far from Gaussian.
const LEAST_DISPARITY_SIGMAS: f64 = 10.0;

impl Range {
    pub(crate) fn new(robot: &RobotModel) -> Option<Range> {
        Some(Range { camera: robot.range_camera.clone()?, body: robot.body })
    }

    /// Position and yaw of the camera, and the tilt of its mount, which moves all landmarks of one height like a wrong position.
    pub(crate) fn mount(&self) -> Mount {
        let tilted_m = self.camera.tilt_rad * self.camera.height_span_m;
        let along = |axis: usize| SIGMAS_OF_BOUND * (0.5 * self.camera.position_m[axis].width()).hypot(tilted_m);
        Mount { sigma: [along(0), along(1), SIGMAS_OF_BOUND * 0.5 * self.camera.yaw_rad.width()] }
    }

    /// Standard deviation of the share by which all distances are wrong in the same way: focal length and baseline scale them.
    pub(crate) fn scale_sigma(&self) -> f64 {
        let share = |of: Interval| 0.5 * of.width() / of.mid();
        SIGMAS_OF_BOUND * share(self.camera.focal_px).hypot(share(self.camera.baseline_m))
    }

    pub(crate) fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let Reading::Range { sightings, .. } = reading else { return None };
        Some(Seen::Landmarks(sightings.iter().filter_map(|one| self.place(one, twist)).collect()))
    }

    /// With u and w the columns from the centre: z = f·b/(u − w) ahead and x = b·u/(u − w) to the right.
    fn place(&self, sighting: &Sighting, twist: &Twist) -> Option<Landmark> {
        let camera = &self.camera;
        let [u_px, w_px] = [sighting.left_px, sighting.right_px].map(|column| column - camera.centre_px);
        let sigma_px = camera.step_px.map(|step_px| SIGMAS_OF_BOUND * 0.5 * step_px);
        let disparity_px = u_px - w_px;
        if disparity_px < LEAST_DISPARITY_SIGMAS * sigma_px[0].hypot(sigma_px[1]) {
            return None;
        }
        let (focal_px, base_m) = (camera.focal_px.mid(), camera.baseline_m.mid());
        let per_px = base_m / disparity_px.powi(2);
        // Derivatives of (ahead, left) by the columns u and w.
        let by_columns = Matrix2::new(-focal_px * per_px, focal_px * per_px, w_px * per_px, -u_px * per_px);
        let in_camera = [focal_px * base_m / disparity_px, -u_px * base_m / disparity_px];
        let yaw_rad = camera.yaw_rad.mid();
        let ahead = Vector2::from(turned(in_camera, yaw_rad));
        let place = ahead + Vector2::new(camera.position_m[0].mid(), camera.position_m[1].mid());
        let (sin, cos) = yaw_rad.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos) * by_columns;
        let columns =
            turn * Matrix2::from_diagonal(&Vector2::new(sigma_px[0].powi(2), sigma_px[1].powi(2))) * turn.transpose();
        // A lean of the body moves the landmark by its height above the floor.
        let leant_m = SIGMAS_OF_BOUND * self.body.tilt_rad * camera.height_span_m.hypot(camera.height_m);
        let [stray_m, stray_rad] = stray(twist, camera.stamp_error_s);
        let aside = Vector2::new(-place.y, place.x) * stray_rad;
        let all_m2 = leant_m.powi(2) + stray_m.powi(2);
        let covariance = columns + aside * aside.transpose() + Matrix2::identity() * all_m2;
        Some(Landmark { code: sighting.landmark.0, in_robot_m: place, ray_m: ahead, covariance })
    }
}
