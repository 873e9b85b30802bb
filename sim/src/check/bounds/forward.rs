//! The forward camera, and the walls before it, against what was drawn and what stands there.

use crate::{
    drawn::DrawnCamera,
    run::RunRecord,
    scene::{MethodName, Scene},
    sensors::lens::Lens,
};

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
        constant(record, "forward_camera.yaw", angle_rad, yaw_rad.abs()),
        constant(record, "forward_camera.tilt", angle_rad, tilt_rad),
        constant(record, "forward_camera.focal", calibration.focal_tolerance, farthest(focal_share, [1.0; 2])),
        constant(record, "forward_camera.principal_point", calibration.principal_point_tolerance_px, principal_px),
        constant(
            record,
            "forward_camera.distortion",
            calibration.distortion_tolerance_px,
            bent_px(&Lens::forward(camera, drawn), camera.lens.distortion),
        ),
        mapped_directions(scene, record),
        stamps(record, "wall_directions", "forward_camera.stamp", &camera.timing()),
    ]
}

/// The mapped direction that is farthest from every wall's, or the wall's that is farthest from every mapped one, modulo quarter turns.
fn mapped_directions(scene: &Scene, record: &RunRecord) -> Monitor {
    let true_deg = scene.true_wall_directions_deg();
    let mapped_deg = scene.mapped_wall_directions_deg();
    let farthest_deg = |some_deg: &[f64], others_deg: &[f64]| {
        let off_deg = |of_deg: &f64| {
            let from = |other_deg: &f64| {
                let turn_deg = (of_deg - other_deg).rem_euclid(90.0);
                turn_deg.min(90.0 - turn_deg)
            };
            others_deg.iter().map(from).fold(90.0, f64::min)
        };
        some_deg.iter().map(off_deg).fold(0.0, f64::max)
    };
    // A direction that the map does not tell is as wrong as one that no wall has, unless the building is said to have such.
    let untold_deg = if scene.localizer.wall_directions().learns { 0.0 } else { farthest_deg(&true_deg, &mapped_deg) };
    let farthest_deg = farthest_deg(&mapped_deg, &true_deg).max(untold_deg);
    let tolerance_deg = scene.localizer.wall_directions().tolerance_deg;
    constant(record, "wall_directions.direction", tolerance_deg.to_radians(), farthest_deg.to_radians())
}
