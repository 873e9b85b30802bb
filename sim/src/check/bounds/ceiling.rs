//! The ceiling camera and the markers above it against what was drawn.

use nalgebra::{UnitQuaternion, Vector3};

use crate::{check::verdict::Violation, drawn::DrawnCamera, run::RunRecord, scene::Scene};

use super::{constant, deliveries};

/// Violations of the bounds of mount, lens and clock.
pub(super) fn violations(scene: &Scene, record: &RunRecord) -> Vec<Violation> {
    let (Some(camera), Some(drawn)) = (&scene.robot.ceiling_camera, &record.drawn.ceiling_camera) else {
        return Vec::new();
    };
    let (calibration, nominal) = (&camera.calibration, DrawnCamera::ceiling(camera));
    let shift_m = drawn.body_from_camera.translation.vector - nominal.body_from_camera.translation.vector;
    let (tilt_rad, yaw_rad) =
        tilt_and_yaw(drawn.body_from_camera.rotation * nominal.body_from_camera.rotation.inverse());
    let angle_rad = calibration.angle_tolerance_deg.to_radians();
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    let focal_share = [0, 1].map(|axis| drawn.focal_px[axis] / nominal.focal_px[axis]);
    let position_m = calibration.position_tolerance_m;
    let mut found: Vec<Violation> = [
        constant(record, "ceiling_camera.position", position_m, shift_m.x.abs().max(shift_m.y.abs())),
        constant(record, "ceiling_camera.height", position_m, shift_m.z.abs()),
        constant(record, "ceiling_camera.yaw", angle_rad, yaw_rad.abs()),
        constant(record, "ceiling_camera.tilt", angle_rad, tilt_rad),
        constant(record, "ceiling_camera.focal", calibration.focal_tolerance, apart(focal_share, [1.0; 2])),
        constant(
            record,
            "ceiling_camera.centre",
            calibration.principal_point_tolerance_px,
            apart(drawn.principal_point_px, nominal.principal_point_px),
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    let names = ["ceiling_camera.stamp", "ceiling_camera.latency"];
    found.extend(deliveries(record, "ceiling_markers", names, &camera.timing()));
    found
}

/// The two parts of a small turn: by how much it tips the vertical, and by how much it turns about it.
fn tilt_and_yaw(turn: UnitQuaternion<f64>) -> (f64, f64) {
    let yaw_rad = 2.0 * turn.k.atan2(turn.w);
    ((turn * Vector3::z()).xy().norm().asin(), yaw_rad)
}
