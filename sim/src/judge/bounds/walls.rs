//! Compares the true directions of walls and furniture with those that the map and the scene give.

use localizer::bounds;

use crate::{devices::Device, run::RunRecord, scene::Scene};

use super::{Monitor, constant};

/// Monitors of two bounds: the angle between the map's wall directions and the true ones, and the angle by which furniture stands askew.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    if !scene.robot.forward_camera.as_ref().is_some_and(|camera| camera.is_relied_on(scene)) {
        return Vec::new();
    }
    let setup = scene.localizer.wall_directions();
    let off_deg = scene.wall_directions_off_deg(&scene.true_wall_directions_deg(&record.drawn.place));
    // Angle by which the piece of furniture that stands most askew is turned.
    let askew_deg = scene.furniture_askew_deg(&record.drawn.place).into_iter().map(f64::abs).fold(0.0, f64::max);
    let degrees = [
        (bounds::WALL_DIRECTIONS_DIRECTION, setup.tolerance_deg, off_deg),
        (bounds::WALL_DIRECTIONS_ASKEW, setup.askew_deg, askew_deg),
    ];
    let monitor = |(bound, declared_deg, true_deg): (_, f64, f64)| {
        constant(record, bound, declared_deg.to_radians(), true_deg.to_radians())
    };
    degrees.map(monitor).into()
}
