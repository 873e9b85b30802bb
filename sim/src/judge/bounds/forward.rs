//! The forward camera, and the walls before it, against what was drawn and what stands there.

use crate::{
    drawn::DrawnCamera,
    optics::Lens,
    run::RunRecord,
    scene::{MethodName, Scene},
};
use localizer::bounds;

use super::{
    Monitor,
    ceiling::{bent_px, tilt_and_yaw},
    constant, stamps,
};

/// The bounds of mount, lens, clock and mapped directions.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let (Some(camera), Some(drawn)) = (&scene.robot.forward_camera, &record.drawn.forward_camera) else {
        return Vec::new();
    };
    if !scene.localizer.methods.contains(&MethodName::WallDirections) {
        return Vec::new();
    }
    let (calibration, nominal) = (&camera.calibration, DrawnCamera::forward(camera));
    let (tilt_rad, yaw_rad) =
        tilt_and_yaw(drawn.body_from_camera.rotation * nominal.body_from_camera.rotation.inverse());
    let angle_rad = calibration.angle_tolerance_deg.to_radians();
    let farthest = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    let focal_share = [0, 1].map(|axis| drawn.focal_px[axis] / nominal.focal_px[axis]);
    let principal_px = farthest(drawn.principal_point_px, nominal.principal_point_px);
    vec![
        constant(record, bounds::FORWARD_CAMERA_YAW, angle_rad, yaw_rad.abs()),
        constant(record, bounds::FORWARD_CAMERA_TILT, angle_rad, tilt_rad),
        constant(record, bounds::FORWARD_CAMERA_FOCAL, calibration.focal_tolerance, farthest(focal_share, [1.0; 2])),
        constant(
            record,
            bounds::FORWARD_CAMERA_PRINCIPAL_POINT,
            calibration.principal_point_tolerance_px,
            principal_px,
        ),
        constant(
            record,
            bounds::FORWARD_CAMERA_DISTORTION,
            calibration.distortion_tolerance_px,
            bent_px(&Lens::forward(camera, drawn), camera.lens.distortion),
        ),
        mapped_directions(scene, record),
        furniture(scene, record),
        stamps(record, "wall_directions", bounds::FORWARD_CAMERA_STAMP, &camera.timing()),
    ]
}

/// How far the map is off what stands there.
fn mapped_directions(scene: &Scene, record: &RunRecord) -> Monitor {
    let off_deg = scene.wall_directions_off_deg(&scene.true_wall_directions_deg(&record.drawn));
    let tolerance_deg = scene.localizer.wall_directions().tolerance_deg;
    constant(record, bounds::WALL_DIRECTIONS_DIRECTION, tolerance_deg.to_radians(), off_deg.to_radians())
}

/// The piece of furniture that stands most askew.
fn furniture(scene: &Scene, record: &RunRecord) -> Monitor {
    let most_deg = scene.furniture_askew_deg(&record.drawn).into_iter().map(f64::abs).fold(0.0, f64::max);
    let declared_deg = scene.localizer.wall_directions().askew_deg;
    constant(record, bounds::WALL_DIRECTIONS_ASKEW, declared_deg.to_radians(), most_deg.to_radians())
}
