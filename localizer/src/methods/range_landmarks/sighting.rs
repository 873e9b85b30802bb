//! From two columns to a box in the robot frame: paper 3, Fig. 2.
//!
//! Any point of the quadrilateral between the rays of both cells has the same two columns. With u and w the columns from the
//! optical axis, z = f·b/(u − w) and x = b·u/(u − w). Each is monotone in u for a given w and in w for a given u, so that its
//! extremes over the cells are at the corners, and the box around the quadrilateral is exact.

use crate::{
    Interval,
    reading::Sighting,
    robot::{RangeCameraModel, RobotModel},
};

/// Box of the landmark in the robot frame, forward and left; `None` where the cells reach to infinity and nothing is said.
pub(super) fn in_robot(sighting: &Sighting, camera: &RangeCameraModel, robot: &RobotModel) -> Option<[Interval; 2]> {
    let [right, ahead] = in_sensor(sighting, camera)?;
    let range_m = right.hypot(ahead).hi();
    let unsure_m = tilted_by(camera, robot, range_m) + moved_by(camera, robot, range_m);
    let (right, ahead) = (right.inflate(unsure_m), ahead.inflate(unsure_m));
    let (cos, sin) = (camera.yaw_rad.cos(), camera.yaw_rad.sin());
    let [forward, left] = camera.position_m;
    Some([forward + ahead * cos + right * sin, left + ahead * sin - right * cos])
}

/// Box around the quadrilateral in the sensor frame: x (right) and z (forward).
fn in_sensor(sighting: &Sighting, camera: &RangeCameraModel) -> Option<[Interval; 2]> {
    let cell = |column_px: f64, step_px: f64| Interval::centred(column_px - camera.centre_px, 0.5 * step_px);
    let (left, right) = (cell(sighting.left_px, camera.step_px[0]), cell(sighting.right_px, camera.step_px[1]));
    let disparity = left - right;
    if disparity.lo() <= 0.0 {
        return None;
    }
    let mut share = Interval::EMPTY;
    for u in [left.lo(), left.hi()].map(Interval::point) {
        for w in [right.lo(), right.hi()].map(Interval::point) {
            share = share.hull(u / (u - w));
        }
    }
    Some([camera.baseline_m * share, camera.focal_px * camera.baseline_m / disparity])
}

/// How far tilt moves a point at a range in the horizontal plane.
///
/// A tilt by τ about a horizontal axis k moves p by sin τ·(k × p) + (1 − cos τ)·k × (k × p) (Rodrigues). Horizontally the first term
/// is at most τ times the height over the sensor, the second at most τ²/2 times the horizontal range. The body tilts about the
/// robot origin, which also moves the sensor by its height times τ.
fn tilted_by(camera: &RangeCameraModel, robot: &RobotModel, range_m: f64) -> f64 {
    let tilt = |tilt_rad: f64, height_m: f64| {
        let square = 0.5 * tilt_rad * tilt_rad;
        let first_m = tilt_rad * height_m;
        first_m + square * (range_m + first_m) / (1.0 - square)
    };
    let (mount_rad, body_rad) = (camera.tilt_rad, robot.body.tilt_rad);
    let span_m = camera.height_span_m;
    // Seen from the tilted body, the height of a far point differs by the body's tilt times its range.
    let seen_m = span_m + body_rad * (range_m + span_m) * 1.01;
    (tilt(mount_rad, seen_m) + tilt(body_rad, span_m) + body_rad * camera.height_m) * (1.0 + 1e-9)
}

/// How far the landmark moves in the robot frame within the error of the stamp.
fn moved_by(camera: &RangeCameraModel, robot: &RobotModel, range_m: f64) -> f64 {
    let reach = &robot.reach;
    let arm_m = camera.position_m[0].hypot(camera.position_m[1]).hi();
    camera.stamp_error_s * (reach.speed_m_per_s + reach.turn_rate_rad_per_s * (range_m + arm_m)) * (1.0 + 1e-9)
}
