//! Every declared bound against the true value behind it.

mod ceiling;
mod forward;
mod monitor;
mod motion;
mod motion_sensors;
mod range;

use localizer::bounds;
use std::collections::BTreeSet;

use crate::{
    drawn::cameras::world_from_floor_camera,
    optics::Lens,
    run::{ImageRecord, RunRecord},
    scene::{CameraTiming, FloorCamera, MethodName, Scene},
};

use super::verdict::Violation;
use monitor::Monitor;

/// All time ranges in which a declared bound was exceeded, in the order of their beginning.
pub fn violations(scene: &Scene, record: &RunRecord) -> Vec<Violation> {
    let mut found: Vec<Violation> = monitors(scene, record).into_iter().flat_map(Monitor::finish).collect();
    found.sort_by(|a, b| a.from_s.total_cmp(&b.from_s).then_with(|| a.bound.cmp(&b.bound)));
    found
}

/// Names of all bounds that are watched in a run of the scene: those that an estimate of it may stand on.
pub fn watched(scene: &Scene, record: &RunRecord) -> BTreeSet<&'static str> {
    monitors(scene, record).iter().map(Monitor::bound).collect()
}

/// Every bound of the scene, held against what was true in the run.
fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let mut all = motion::monitors(scene, record);
    all.extend(wheels(scene, record));
    all.extend(motion_sensors::monitors(scene, record));
    all.extend(range::monitors(scene, record));
    all.extend(ceiling::monitors(scene, record));
    all.extend(forward::monitors(scene, record));
    let reads_floor = scene.localizer.methods.contains(&MethodName::FloorTiles);
    if let (Some(camera), Some(_), true) = (&scene.robot.floor_camera, &record.drawn.floor_camera, reads_floor) {
        all.extend(floor_camera(camera, record));
        all.extend(tiles(scene, camera, record));
    }
    all
}

/// Radii, track and the base's clock are drawn inside their bounds; a scene that draws them outside would show here.
fn wheels(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let (robot, drawn) = (&scene.robot, &record.drawn);
    let radius_error_m = drawn.wheel_radius_m.map(|radius_m| (radius_m - robot.wheel_radius_m).abs());
    let mut all = vec![
        constant(
            record,
            bounds::WHEELS_RADIUS,
            robot.wheel_radius_m * robot.wheel_radius_tolerance,
            radius_error_m[0].max(radius_error_m[1]),
        ),
        constant(
            record,
            bounds::WHEELS_TRACK,
            robot.track_m * robot.track_tolerance,
            (drawn.track_m - robot.track_m).abs(),
        ),
    ];
    // Without a tolerance there is one clock.
    if robot.delivery.stamp_tolerance_s > 0.0 {
        all.push(constant(record, bounds::BASE_STAMP, robot.delivery.stamp_tolerance_s, drawn.base_clock_s.abs()));
    }
    all
}

/// A bound on a value that is the same over the whole run.
fn constant(record: &RunRecord, bound: &'static str, declared: f64, true_value: f64) -> Monitor {
    let end_s = record.truths.last().map_or(0.0, |truth| truth.time_s);
    let mut monitor = Monitor::new(bound);
    monitor.watch([0.0, end_s], declared, true_value);
    monitor
}

/// The mount, the lens and the clock of the floor camera.
fn floor_camera(camera: &FloorCamera, record: &RunRecord) -> Vec<Monitor> {
    let Some(mount) = &record.drawn.floor_camera else { return Vec::new() };
    let position_error_m =
        (mount.position_m[0] - camera.forward_m).abs().max((mount.position_m[1] - camera.left_m).abs());
    let nominal_scale = f64::from(camera.width_px) / camera.footprint_width_m;
    vec![
        constant(record, bounds::FLOOR_CAMERA_POSITION, camera.position_tolerance_m, position_error_m),
        constant(record, bounds::FLOOR_CAMERA_YAW, camera.yaw_tolerance_deg.to_radians(), mount.yaw_rad.abs()),
        constant(
            record,
            bounds::FLOOR_CAMERA_TILT,
            camera.tilt_tolerance_deg.to_radians(),
            mount.tilt_rad[0].hypot(mount.tilt_rad[1]),
        ),
        constant(
            record,
            bounds::FLOOR_CAMERA_SCALE,
            nominal_scale * camera.scale_tolerance,
            (mount.focal_px / mount.height_m - nominal_scale).abs(),
        ),
        constant(
            record,
            bounds::FLOOR_CAMERA_DISTORTION,
            camera.distortion_tolerance_px,
            ceiling::bent_px(&Lens::floor(camera, mount), camera.lens.distortion),
        ),
        stamps(record, "floor_tiles", bounds::FLOOR_CAMERA_STAMP, &camera.timing()),
    ]
}

/// Stamps of the images that a method read.
fn stamps(record: &RunRecord, method: &str, bound: &'static str, timing: &CameraTiming) -> Monitor {
    let mut monitor = Monitor::new(bound);
    for image in record.images.iter().filter(|image| image.method == method) {
        let span_s = [image.truth.time_s, image.arrived_s];
        monitor.watch(span_s, timing.stamp_tolerance_s, (image.measured_s - image.truth.time_s).abs());
    }
    monitor
}

/// Joints that lie off their place, while they are in view.
fn tiles(scene: &Scene, camera: &FloorCamera, record: &RunRecord) -> Vec<Monitor> {
    let (Some(tiles), Some(laid)) = (&scene.floor.tiles, &record.drawn.tiles) else { return Vec::new() };
    let names = [bounds::FLOOR_TILES_LAYING, bounds::FLOOR_TILES_LAYING_ANGLE, bounds::FLOOR_TILES_STRAIGHTNESS];
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
    monitors.into()
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
