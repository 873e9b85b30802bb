//! Contradictions about sensors other than cameras: periods that the physics cannot sample, tolerances that contradict one another, and settings of
//! the localizer for a gyroscope or a map of walls that is missing.

use crate::{
    devices::{self, unsampled},
    loading::contradiction::Contradiction,
    scene::Scene,
};

/// All contradictions in `scene` about its sensors other than cameras, and about what the localizer learns from them.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let (robot, localizer) = (&scene.robot, &scene.localizer);
    let mut found_at = |key: &str, expected: String| found.push(Contradiction { key: key.to_owned(), expected });
    if let Some(expected) = unsampled(robot.encoders.period_s) {
        found_at("robot.encoders.period_s", expected);
    }
    for (key, expected) in devices::contradictions(robot) {
        found_at(&key, expected);
    }
    if robot.gyro.is_none() && localizer.learns_gyro {
        found_at("localizer.learns_gyro", "the robot has none, expected a `[robot.gyro]`".to_owned());
    }
    if localizer.post_window.is_some() && !scene.stations.is_empty() {
        let expected = "a robot at `[[station]]`s makes no way, expected a `[route]` or errands";
        found_at("localizer.post_window", expected.to_owned());
    }
    if let Some(walls) = &localizer.wall_directions
        && !walls.learns
        && walls.mapped_deg.as_ref().is_some_and(Vec::is_empty)
    {
        let expected = "tells of no wall, expected a direction, or `learns = true`";
        found_at("localizer.wall_directions.mapped_deg", expected.to_owned());
    }
}
