//! The gyroscope and the flow sensor against what was drawn and what was true.

use crate::{run::RunRecord, scene::Scene};
use localizer::bounds;

use super::{Monitor, constant};

/// The bounds of both sensors, and of rest.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let mut all = gyro(scene, record);
    // Nothing is made of the flow without a gyroscope beside it.
    if scene.robot.gyro.is_some() {
        all.extend(flow(scene, record));
    }
    if scene.localizer.learns_gyro && scene.bounds.rest_turn_deg.is_some() {
        all.push(rests(scene, record));
    }
    all
}

fn rests(scene: &Scene, record: &RunRecord) -> Monitor {
    let mut monitor = Monitor::new(bounds::WHEELS_REST);
    let declared_rad = scene.bounds.rest_turn_deg.map_or(f64::INFINITY, f64::to_radians);
    for rest in &record.motion_sensors.rests {
        monitor.watch(rest.span_s, declared_rad, rest.turned_rad);
    }
    monitor
}

/// What varies is dated by the readings that show it.
fn gyro(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let (Some(gyro), Some(drawn)) = (&scene.robot.gyro, &record.drawn.gyro) else { return Vec::new() };
    // Stamps 5 ms apart have lost some digits of their difference.
    const ROUNDING: f64 = 1.0 - 1e-6;
    let (mut bias, mut noise) = (Monitor::new(bounds::GYRO_BIAS), Monitor::new(bounds::GYRO_NOISE));
    let (mut angle, mut wander) = (Monitor::new(bounds::GYRO_ANGLE), Monitor::new(bounds::GYRO_WANDER));
    let floor_rad = gyro.angle_floor_deg.map_or(f64::INFINITY, f64::to_radians);
    bias.watch([0.0, 0.0], gyro.bias_tolerance_deg_per_s.to_radians(), drawn.bias_rad_per_s.abs());
    for sight in &record.motion_sensors.gyro {
        let span_s = [sight.time_s - gyro.period_s, sight.time_s];
        bias.watch(span_s, gyro.bias_tolerance_deg_per_s.to_radians(), sight.bias_rad_per_s);
        noise.watch(span_s, gyro.noise_deg_per_s.to_radians(), sight.noise_rad_per_s);
        angle.watch(span_s, floor_rad, sight.angle_rad * ROUNDING);
        wander.watch(span_s, gyro.bias_wander_deg_per_s2.to_radians(), sight.wander_rad_per_s2 * ROUNDING);
    }
    let scale = constant(record, bounds::GYRO_SCALE, gyro.scale_tolerance, (drawn.scale - 1.0).abs());
    let mut all = vec![bias, scale, angle, noise];
    // Only what is learnt of the bias has to hold from one fix to the next, and where `gyro.angle` is declared, that tells it.
    if scene.localizer.learns_gyro && gyro.angle_floor_deg.is_none() {
        all.push(wander);
    }
    all
}

fn flow(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let (Some(flow), Some(mount)) = (&scene.robot.flow, &record.drawn.flow) else { return Vec::new() };
    let position_error_m = (mount.position_m[0] - flow.forward_m).abs().max((mount.position_m[1] - flow.left_m).abs());
    let (mut scale, mut back_and_forth) = (Monitor::new(bounds::FLOW_SCALE), Monitor::new(bounds::FLOW_BACK_AND_FORTH));
    for sight in &record.motion_sensors.flow {
        let span_s = [sight.measured_s - flow.period_s, sight.measured_s];
        scale.watch(span_s, flow.varying_share(), sight.truth.scale_change);
        back_and_forth.watch(span_s, flow.back_and_forth_m, sight.truth.back_and_forth_m);
    }
    vec![
        constant(record, bounds::FLOW_POSITION, flow.position_tolerance_m, position_error_m),
        constant(record, bounds::FLOW_YAW, flow.yaw_tolerance_deg.to_radians(), mount.yaw_rad.abs()),
        constant(record, bounds::FLOW_CALIBRATION, flow.calibration_share(), (mount.scale - 1.0).abs()),
        scale,
        back_and_forth,
    ]
}
