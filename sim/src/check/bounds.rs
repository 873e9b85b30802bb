//! Every declared bound against the true value behind it.

mod ceiling;
mod forward;
mod monitor;
mod motion;
mod motion_sensors;
mod range;

use crate::{
    run::{ImageRecord, RunRecord},
    scene::{CameraTiming, FloorCamera, Scene},
    sensors::{camera::world_from_floor_camera, lens::Lens},
};

use super::verdict::Violation;
use monitor::Monitor;

/// All time ranges in which a declared bound was exceeded, in the order of their beginning.
pub fn violations(scene: &Scene, record: &RunRecord) -> Vec<Violation> {
    let mut found = motion::violations(scene, record);
    found.extend(wheels(scene, record));
    found.extend(motion_sensors::violations(scene, record));
    found.extend(range::violations(scene, record));
    found.extend(ceiling::violations(scene, record));
    found.extend(forward::violations(scene, record));
    if let (Some(camera), Some(_)) = (&scene.robot.floor_camera, &record.drawn.floor_camera) {
        found.extend(floor_camera(camera, record));
        found.extend(tiles(scene, camera, record));
    }
    found.sort_by(|a, b| a.from_s.total_cmp(&b.from_s).then_with(|| a.bound.cmp(&b.bound)));
    found
}

/// Radii and track are drawn inside their bounds; a scene that draws them outside would show here.
fn wheels(scene: &Scene, record: &RunRecord) -> Vec<Violation> {
    let (robot, drawn) = (&scene.robot, &record.drawn);
    let radius_error_m = drawn.wheel_radius_m.map(|radius_m| (radius_m - robot.wheel_radius_m).abs());
    [
        constant(
            record,
            "wheels.radius",
            robot.wheel_radius_m * robot.wheel_radius_tolerance,
            radius_error_m[0].max(radius_error_m[1]),
        ),
        constant(record, "wheels.track", robot.track_m * robot.track_tolerance, (drawn.track_m - robot.track_m).abs()),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A bound on a value that is the same over the whole run.
fn constant(record: &RunRecord, bound: &'static str, declared: f64, true_value: f64) -> Option<Violation> {
    let end_s = record.truths.last().map_or(0.0, |truth| truth.time_s);
    let mut monitor = Monitor::new(bound);
    monitor.watch([0.0, end_s], declared, true_value);
    monitor.finish().pop()
}

/// The mount, the lens and the clock of the floor camera.
fn floor_camera(camera: &FloorCamera, record: &RunRecord) -> Vec<Violation> {
    let Some(mount) = &record.drawn.floor_camera else { return Vec::new() };
    let position_error_m =
        (mount.position_m[0] - camera.forward_m).abs().max((mount.position_m[1] - camera.left_m).abs());
    let nominal_scale = f64::from(camera.width_px) / camera.footprint_width_m;
    let mut found: Vec<Violation> = [
        constant(record, "floor_camera.position", camera.position_tolerance_m, position_error_m),
        constant(record, "floor_camera.yaw", camera.yaw_tolerance_deg.to_radians(), mount.yaw_rad.abs()),
        constant(
            record,
            "floor_camera.tilt",
            camera.tilt_tolerance_deg.to_radians(),
            mount.tilt_rad[0].hypot(mount.tilt_rad[1]),
        ),
        constant(
            record,
            "floor_camera.scale",
            nominal_scale * camera.scale_tolerance,
            (mount.focal_px / mount.height_m - nominal_scale).abs(),
        ),
        constant(
            record,
            "floor_camera.distortion",
            camera.distortion_tolerance_px,
            ceiling::bent_px(&Lens::floor(camera, mount), camera.lens.distortion),
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    let names = ["floor_camera.stamp", "floor_camera.latency"];
    found.extend(deliveries(record, "floor_tiles", names, &camera.timing()));
    found
}

/// Stamps and latencies of the images that a method read, against the two bounds named.
fn deliveries(
    record: &RunRecord,
    method: &str,
    [stamp, latency]: [&'static str; 2],
    timing: &CameraTiming,
) -> Vec<Violation> {
    let (mut stamp, mut latency) = (Monitor::new(stamp), Monitor::new(latency));
    for image in record.images.iter().filter(|image| image.method == method) {
        let span_s = [image.truth.time_s, image.arrived_s];
        stamp.watch(span_s, timing.stamp_tolerance_s, (image.measured_s - image.truth.time_s).abs());
        let late_s = image.arrived_s - image.truth.time_s - timing.latency_s;
        latency.watch(span_s, timing.latency_tolerance_s, late_s.abs());
    }
    let mut found = stamp.finish();
    found.extend(latency.finish());
    found
}

/// Joints that lie off their place, while they are in view.
fn tiles(scene: &Scene, camera: &FloorCamera, record: &RunRecord) -> Vec<Violation> {
    let (Some(tiles), Some(laid)) = (&scene.floor.tiles, &record.drawn.tiles) else { return Vec::new() };
    let names = ["floor_tiles.laying", "floor_tiles.laying_angle", "floor_tiles.straightness"];
    let mut monitors = names.map(Monitor::new);
    let shortest_m = scene.room.width_m.min(scene.room.depth_m);
    let declared = [
        tiles.laying_tolerance_m + tiles.corner_tolerance_m,
        2.0 * tiles.laying_tolerance_m / shortest_m,
        tiles.corner_tolerance_m,
    ];
    for image in images(record) {
        let Some(centre_m) = view_centre(image, record) else { continue };
        let errors = laid.errors_near(tiles, &scene.room, centre_m, half_diagonal_m(camera));
        let span_s = [image.truth.time_s, image.arrived_s];
        let off = [errors.offset_m, errors.angle_rad, errors.bend_m];
        for ((monitor, declared), off) in monitors.iter_mut().zip(declared).zip(off) {
            monitor.watch(span_s, declared, off);
        }
    }
    monitors.into_iter().flat_map(Monitor::finish).collect()
}

/// The images of the floor camera.
fn images(record: &RunRecord) -> impl Iterator<Item = &ImageRecord> {
    record.images.iter().filter(|image| image.method == "floor_tiles")
}

/// Place on the floor below the camera.
fn view_centre(image: &ImageRecord, record: &RunRecord) -> Option<[f64; 2]> {
    let position = world_from_floor_camera(&image.truth, record.drawn.floor_camera.as_ref()?).translation.vector;
    Some([position.x, position.y])
}

fn half_diagonal_m(camera: &FloorCamera) -> f64 {
    let height_m = camera.footprint_width_m * f64::from(camera.height_px) / f64::from(camera.width_px);
    0.5 * camera.footprint_width_m.hypot(height_m)
}
