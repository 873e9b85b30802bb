//! Contradictions about sensors other than cameras: periods that the physics cannot sample, bounds that allow anything, and sensors that a method needs
//! but the robot lacks.

use crate::{
    loading::parse::Contradiction,
    scene::{Flow, Gyro, Scene},
};

use super::short;

/// Everything about sensors in which `scene` contradicts itself.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let (robot, localizer) = (&scene.robot, &scene.localizer);
    let gyro_s = robot.gyro.as_ref().map(|gyro| ("robot.gyro.period_s", gyro.period_s));
    let flow_s = robot.flow.as_ref().map(|flow| ("robot.flow.period_s", flow.period_s));
    let periods = [("robot.encoders.period_s", robot.encoders.period_s)].into_iter().chain(gyro_s).chain(flow_s);
    let mut found_at = |key: &str, expected: String| found.push(Contradiction { key: key.to_owned(), expected });
    for (key, period_s) in periods {
        if !is_sampled(period_s) {
            found_at(key, "expected a multiple of 0.001, the step of the physics".to_owned());
        }
    }
    if let Some(flow) = &robot.flow {
        flow_shares(flow, &mut found_at);
    }
    match &robot.gyro {
        Some(gyro) => gyro_bounds(gyro, &mut found_at),
        None if localizer.learns_gyro => {
            found_at("localizer.learns_gyro", "the robot has none, expected a `[robot.gyro]`".to_owned());
        }
        None => {}
    }
    if let Some(walls) = &localizer.wall_directions
        && !walls.learns
        && walls.mapped_deg.as_ref().is_some_and(Vec::is_empty)
    {
        let expected = "tells of no wall, expected a direction, or `learns = true`";
        found_at("localizer.wall_directions.mapped_deg", expected.to_owned());
    }
}

/// What is drawn of a flow sensor's scale is part of what is declared of it: its calibration of the whole, surfaces and noise together of
/// what the calibration leaves.
fn flow_shares(flow: &Flow, found_at: &mut impl FnMut(&str, String)) {
    if flow.calibration_tolerance > flow.scale_tolerance {
        let expected =
            format!("expected at most `scale_tolerance`, of which it is part and which is {}", flow.scale_tolerance);
        found_at("robot.flow.calibration_tolerance", expected);
        return;
    }
    // Sums like 0.01 + 0.02 are not exact.
    const ROUNDING: f64 = 1e-12;
    if flow.surface_tolerance + flow.noise_tolerance > flow.varying_share() + ROUNDING {
        let key = if flow.surface_tolerance > flow.noise_tolerance { "surface_tolerance" } else { "noise_tolerance" };
        let expected = format!(
            "expected `surface_tolerance` and `noise_tolerance` to come to at most {}, which is what `calibration_tolerance` leaves of \
             `scale_tolerance`",
            short(flow.varying_share())
        );
        found_at(&format!("robot.flow.{key}"), expected);
    }
}

fn gyro_bounds(gyro: &Gyro, found_at: &mut impl FnMut(&str, String)) {
    if let Some(walk_deg) = gyro.angle_random_walk_deg_per_sqrt_h
        && gyro.noise_deg_per_s < 3.0 * gyro.deviation_deg_per_s(walk_deg)
    {
        let least = 3.0 * gyro.deviation_deg_per_s(walk_deg);
        let expected =
            format!("cuts the angle random walk off, expected at least {least:.4}: three standard deviations");
        found_at("robot.gyro.noise_deg_per_s", expected);
    }
    if gyro.bias_wander_deg_per_s2 == 0.0
        && gyro.bias_instability_deg_per_h + gyro.rate_random_walk_deg_per_h_per_sqrt_h > 0.0
    {
        let expected = "the bias would be held fast, expected more than 0 to let it wander".to_owned();
        found_at("robot.gyro.bias_wander_deg_per_s2", expected);
    }
    if gyro.angle_deg_per_s > 0.0 && gyro.angle_floor_deg.is_none() {
        let expected = "bounds nothing alone, expected `angle_floor_deg` beside it".to_owned();
        found_at("robot.gyro.angle_deg_per_s", expected);
    }
}

fn is_sampled(period_s: f64) -> bool {
    let steps = period_s / 0.001;
    (steps - steps.round()).abs() <= 1e-6
}
