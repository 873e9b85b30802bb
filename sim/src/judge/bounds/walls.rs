//! Walls and furniture against what the map and the scene tell of them.

use localizer::bounds;

use crate::{devices::Device, run::RunRecord, scene::Scene};

use super::{Monitor, constant};

/// How far the map is off what stands there, and how far furniture is askew.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    if !scene.robot.forward_camera.as_ref().is_some_and(|camera| camera.is_relied_on(scene)) {
        return Vec::new();
    }
    let setup = scene.localizer.wall_directions();
    let off_deg = scene.wall_directions_off_deg(&scene.true_wall_directions_deg(&record.drawn));
    // The piece of furniture that stands most askew.
    let askew_deg = scene.furniture_askew_deg(&record.drawn).into_iter().map(f64::abs).fold(0.0, f64::max);
    let degrees = [
        (bounds::WALL_DIRECTIONS_DIRECTION, setup.tolerance_deg, off_deg),
        (bounds::WALL_DIRECTIONS_ASKEW, setup.askew_deg, askew_deg),
    ];
    let monitor = |(bound, declared_deg, true_deg): (_, f64, f64)| {
        constant(record, bound, declared_deg.to_radians(), true_deg.to_radians())
    };
    degrees.map(monitor).into()
}
