//! The ceiling camera and the markers above it against what was drawn.

use localizer::{Claim, bounds, markers::dot_in_marker_m};
use nalgebra::{UnitQuaternion, Vector3};

use crate::{
    drawn::{DrawnCamera, DrawnMarker},
    optics::Lens,
    run::RunRecord,
    scene::{Marker, MethodName, Scene},
};

use super::{Monitor, constant, stamps};

/// The bounds of mount, lens, clock and markers.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let (Some(camera), Some(drawn)) = (&scene.robot.ceiling_camera, &record.drawn.ceiling_camera) else {
        return Vec::new();
    };
    if !scene.localizer.methods.contains(&MethodName::CeilingMarkers) {
        return Vec::new();
    }
    let (calibration, nominal) = (&camera.calibration, DrawnCamera::ceiling(camera));
    let shift_m = drawn.body_from_camera.translation.vector - nominal.body_from_camera.translation.vector;
    let (tilt_rad, yaw_rad) =
        tilt_and_yaw(drawn.body_from_camera.rotation * nominal.body_from_camera.rotation.inverse());
    let angle_rad = calibration.angle_tolerance_deg.to_radians();
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    let focal_share = [0, 1].map(|axis| drawn.focal_px[axis] / nominal.focal_px[axis]);
    let position_m = calibration.position_tolerance_m;
    let mut all = vec![
        constant(record, bounds::CEILING_CAMERA_POSITION, position_m, shift_m.x.abs().max(shift_m.y.abs())),
        constant(record, bounds::CEILING_CAMERA_HEIGHT, position_m, shift_m.z.abs()),
        constant(record, bounds::CEILING_CAMERA_YAW, angle_rad, yaw_rad.abs()),
        constant(record, bounds::CEILING_CAMERA_TILT, angle_rad, tilt_rad),
        constant(record, bounds::CEILING_CAMERA_FOCAL, calibration.focal_tolerance, apart(focal_share, [1.0; 2])),
        constant(
            record,
            bounds::CEILING_CAMERA_CENTRE,
            calibration.principal_point_tolerance_px,
            apart(drawn.principal_point_px, nominal.principal_point_px),
        ),
        constant(
            record,
            bounds::CEILING_CAMERA_DISTORTION,
            calibration.distortion_tolerance_px,
            bent_px(&Lens::ceiling(camera, drawn), camera.lens.distortion),
        ),
        stamps(record, "ceiling_markers", bounds::CEILING_CAMERA_STAMP, &camera.timing()),
    ];
    all.extend(markers(scene, record));
    all
}

/// Greatest distance, along u or v, between what the true coefficients and the declared ones make of the same ray: at a corner, as the error
/// grows with the third power of the distance from the middle.
pub(super) fn bent_px(lens: &Lens, declared: [f64; 5]) -> f64 {
    let declared = Lens { distortion: declared, ..lens.clone() };
    let off_px = lens.corners().into_iter().flat_map(|ray| {
        let (seen, stated) = (lens.pixel(ray), declared.pixel(ray));
        [0, 1].map(|axis| (seen[axis] - stated[axis]).abs())
    });
    off_px.fold(0.0, f64::max)
}

/// Markers that are claimed in an image: where they were pasted, how they were turned, printed and hung.
fn markers(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let Some(markers) = &scene.markers else { return Vec::new() };
    let names = [bounds::MARKERS_PLACEMENT, bounds::MARKERS_ROTATION, bounds::MARKERS_PRINT, bounds::MARKERS_HEIGHT];
    let mut monitors = names.map(Monitor::new);
    let declared = [
        markers.placement_tolerance_m,
        markers.rotation_tolerance_deg.to_radians(),
        markers.print_tolerance_m,
        markers.height_tolerance_m,
    ];
    for image in record.images.iter().filter(|image| image.method == "ceiling_markers") {
        let span_s = [image.truth.time_s, image.arrived_s];
        for claim in &image.claims {
            let Claim::Marker { marker: id, .. } = claim else { continue };
            let pasted = record.drawn.markers.iter().filter(|drawn| drawn.id == *id);
            let stated = pasted.filter_map(|drawn| Some((markers.all().get(drawn.index)?, drawn)));
            for (marker, drawn) in stated.filter(|(marker, _)| marker.on_map) {
                let errors = errors_of(marker, drawn, markers.height_m(marker, scene));
                for ((monitor, declared), error) in monitors.iter_mut().zip(declared).zip(errors) {
                    monitor.watch(span_s, declared, error);
                }
            }
        }
    }
    monitors.into()
}

/// Distance, angle, farthest dot and height by which a marker is off.
fn errors_of(marker: &Marker, drawn: &DrawnMarker, nominal_height_m: f64) -> [f64; 4] {
    let [x_m, y_m] = drawn.centre_m;
    let turned = drawn.rotation_rad - marker.rotation_deg.to_radians();
    let (sin, cos) = drawn.rotation_rad.sin_cos();
    let off_m = drawn.dots.iter().map(|dot| {
        let [along_m, across_m] = dot_in_marker_m(dot.place);
        let [dot_x_m, dot_y_m] = [x_m + cos * along_m - sin * across_m, y_m + sin * along_m + cos * across_m];
        (dot.centre_in_world.x - dot_x_m).hypot(dot.centre_in_world.y - dot_y_m)
    });
    // A tolerance of 0 is one: what rounding leaves is not beyond it.
    const ROUNDING: f64 = 1e-12;
    let errors = [
        (x_m - marker.x_m).hypot(y_m - marker.y_m),
        turned.sin().atan2(turned.cos()).abs(),
        off_m.fold(0.0, f64::max),
        (drawn.height_m - nominal_height_m).abs(),
    ];
    errors.map(|error| (error - ROUNDING).max(0.0))
}

/// The two parts of a small turn: by how much it tips the vertical, and by how much it turns about it.
pub(super) fn tilt_and_yaw(turn: UnitQuaternion<f64>) -> (f64, f64) {
    let yaw_rad = 2.0 * turn.k.atan2(turn.w);
    ((turn * Vector3::z()).xy().norm().asin(), yaw_rad)
}
