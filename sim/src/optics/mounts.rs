//! Mounts of cameras on the robot's body: their nominal poses, and poses with errors.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};

use crate::scene::{CeilingCamera, ForwardCamera};

/// Nominal pose of the forward camera on the body: image right is robot right (−y), image down is robot down, and the camera is tilted up about the
/// image's u axis.
pub(crate) fn body_from_forward_camera(camera: &ForwardCamera) -> Isometry3<f64> {
    // The matrix's columns are the camera's axes in the body's frame.
    let level = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), camera.yaw_deg.to_radians());
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), camera.tilt_up_deg.to_radians());
    Isometry3::from_parts(
        Translation3::new(camera.forward_m, camera.left_m, camera.height_m),
        yaw * attitude(level) * tilt,
    )
}

/// Nominal pose of the ceiling camera on the body: image right is robot right (−y), image down is robot forward, the camera's forward axis points up,
/// and then the camera leans.
pub(crate) fn body_from_ceiling_camera(camera: &CeilingCamera) -> Isometry3<f64> {
    let upward = Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let lean = leaning([camera.lean_forward_deg, camera.lean_left_deg].map(f64::to_radians));
    Isometry3::from_parts(Translation3::new(camera.forward_m, camera.left_m, camera.height_m), lean * attitude(upward))
}

/// Focal length of the forward camera from its angle of view: half the image width over the tangent of half the angle.
pub(crate) fn forward_focal_px(camera: &ForwardCamera) -> f64 {
    f64::from(camera.width_px) / 2.0 / (camera.horizontal_view_deg.to_radians() / 2.0).tan()
}

/// A camera's pose with mounting errors: the nominal pose is tilted towards forward and left, then turned about the vertical, and its position is
/// shifted.
pub(crate) fn misplaced(pose: Isometry3<f64>, tilt_rad: [f64; 2], yaw_rad: f64, shift_m: [f64; 3]) -> Isometry3<f64> {
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    let shift = Translation3::from(Vector3::from(shift_m));
    Isometry3::from_parts(shift * pose.translation, yaw * leaning(tilt_rad) * pose.rotation)
}

/// The rotation about a level axis that tilts the vertical by these angles towards forward and left.
fn leaning([forward_rad, left_rad]: [f64; 2]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(vector![-left_rad, forward_rad, 0.0])
}

fn attitude(columns: Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}

/// Nominal attitude of the floor camera: image right is robot right (−y), image down is robot backward (−x), and the camera's forward axis points
/// down (−z).
pub(crate) fn mount_from_looking_down() -> UnitQuaternion<f64> {
    let columns = Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    attitude(columns)
}
