//! Compares joints of floor tiles, while they are in view, with their nominal places in the grid.

use localizer::{bounds, reading::Camera};

use crate::{
    devices::{Device, camera::world_from_camera},
    place::building::GroundPlan,
    run::{ImageRecord, RunRecord},
    scene::{FloorCamera, Scene},
};

use super::Monitor;

/// Monitors of three bounds on the joints in view of the floor camera: their offset from their nominal place, their angle and their bend.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let camera = scene.robot.floor_camera.as_ref().filter(|camera| camera.is_relied_on(scene));
    let (Some(camera), Some(tiles), Some(laid)) = (camera, &scene.floor.tiles, &record.drawn.place.tiles) else {
        return Vec::new();
    };
    let names = [bounds::FLOOR_TILES_LAYING, bounds::FLOOR_TILES_LAYING_ANGLE, bounds::FLOOR_TILES_STRAIGHTNESS];
    let mut monitors = names.map(Monitor::new);
    let shortest_m = scene.room.width_m.min(scene.room.depth_m);
    let floor_m = GroundPlan::of(scene).extents_m();
    let declared = [
        tiles.laying_tolerance_m + tiles.corner_tolerance_m,
        2.0 * tiles.laying_tolerance_m / shortest_m,
        tiles.corner_tolerance_m,
    ];
    for image in record.images.iter().filter(|image| image.camera == Some(Camera::Floor)) {
        let Some(centre_m) = view_centre(image, record) else { continue };
        let errors = laid.errors_near(tiles, floor_m, centre_m, half_diagonal_m(camera));
        let span_s = [image.truth.time_s, image.arrived_s];
        let off = [errors.offset_m, errors.angle_rad, errors.bend_m];
        for ((monitor, declared), off) in monitors.iter_mut().zip(declared).zip(off) {
            monitor.watch(span_s, declared, off);
        }
    }
    monitors.into()
}

/// The point on the floor below the floor camera.
fn view_centre(image: &ImageRecord, record: &RunRecord) -> Option<[f64; 2]> {
    let mount = record.drawn.devices.floor_camera.as_ref()?;
    let position = world_from_camera(&image.truth, mount).translation.vector;
    Some([position.x, position.y])
}

fn half_diagonal_m(camera: &FloorCamera) -> f64 {
    let height_m = camera.footprint_width_m * f64::from(camera.height_px) / f64::from(camera.width_px);
    0.5 * camera.footprint_width_m.hypot(height_m)
}
