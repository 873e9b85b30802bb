//! Mounts of cameras on the robot's body: their nominal poses, and poses with errors.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};

use crate::scene::{CameraKeys, Looks};

/// Nominal pose of a camera on the body.
pub(crate) fn body_from_camera(camera: &dyn CameraKeys) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(camera.shared().position_m), attitude(camera.looks()))
}

/// Nominal attitude of a camera on the body. The matrices' columns are the axes of the camera, before it is tilted or leans, in the body's frame.
fn attitude(looks: Looks) -> UnitQuaternion<f64> {
    match looks {
        // Image right is robot right (−y), image down is robot backward (−x), and the camera's forward axis points down (−z).
        Looks::Down => rotation(Matrix3::new(0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0)),
        // Image right is robot right, image down is robot down; then the camera is tilted up about the image's u axis and turned about the vertical.
        Looks::Ahead { yaw_deg, tilt_up_deg } => {
            let level = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
            let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_deg.to_radians());
            let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), tilt_up_deg.to_radians());
            yaw * rotation(level) * tilt
        }
        // Image right is robot right, image down is robot forward, the camera's forward axis points up; then the camera leans.
        Looks::Up { lean_forward_deg, lean_left_deg } => {
            let upward = Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
            leaning([lean_forward_deg, lean_left_deg].map(f64::to_radians)) * rotation(upward)
        }
    }
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

fn rotation(columns: Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
}
