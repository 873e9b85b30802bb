//! Compares ceiling markers with their places on the map.

use localizer::{Claim, bounds, markers::dot_in_marker_m, reading::Camera};

use crate::{
    devices::Device,
    place::drawn::DrawnMarker,
    run::RunRecord,
    scene::{Marker, Scene},
};

use super::Monitor;

/// Monitors of the markers that are claimed in an image: bounds on where they were pasted, how they were rotated, how they were printed and
/// how high they hang.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let is_relied_on = scene.robot.ceiling_camera.as_ref().is_some_and(|camera| camera.is_relied_on(scene));
    let Some(markers) = scene.markers.as_ref().filter(|_| is_relied_on) else { return Vec::new() };
    let names = [bounds::MARKERS_PLACEMENT, bounds::MARKERS_ROTATION, bounds::MARKERS_PRINT, bounds::MARKERS_HEIGHT];
    let mut monitors = names.map(Monitor::new);
    let declared = [
        markers.placement_tolerance_m,
        markers.rotation_tolerance_deg.to_radians(),
        markers.print_tolerance_m,
        markers.height_tolerance_m,
    ];
    for image in record.images.iter().filter(|image| image.camera == Some(Camera::Ceiling)) {
        let span_s = [image.truth.time_s, image.arrived_s];
        for claim in &image.claims {
            let Claim::Marker { marker: id, .. } = claim else { continue };
            let pasted = record.drawn.place.markers.iter().filter(|drawn| drawn.id == *id);
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

/// Errors of a marker: distance of its centre, its angle, the greatest distance of a dot from its place in the grid, and its height.
fn errors_of(marker: &Marker, drawn: &DrawnMarker, nominal_height_m: f64) -> [f64; 4] {
    let [x_m, y_m] = drawn.centre_m;
    let turned = drawn.rotation_rad - marker.rotation_deg.to_radians();
    let (sin, cos) = drawn.rotation_rad.sin_cos();
    let off_m = drawn.dots.iter().map(|dot| {
        let [along_m, across_m] = dot_in_marker_m(dot.place);
        let [dot_x_m, dot_y_m] = [x_m + cos * along_m - sin * across_m, y_m + sin * along_m + cos * across_m];
        (dot.centre_in_world.x - dot_x_m).hypot(dot.centre_in_world.y - dot_y_m)
    });
    // A tolerance of 0 is valid: an error that comes from rounding must not exceed it.
    const ROUNDING: f64 = 1e-12;
    let errors = [
        (x_m - marker.x_m).hypot(y_m - marker.y_m),
        turned.sin().atan2(turned.cos()).abs(),
        off_m.fold(0.0, f64::max),
        (drawn.height_m - nominal_height_m).abs(),
    ];
    errors.map(|error| (error - ROUNDING).max(0.0))
}
