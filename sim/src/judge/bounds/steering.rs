//! Compares the declared bounds on a car's steering with its true motion: how fast it is steered, and how far the tyres' sideways slip turns it.

use localizer::bounds;

use crate::{base::DrawnBase, scene::Scene, truth::Truth};

use super::monitor::{Monitor, watch_windows};

/// Monitors of the bounds on steering rate and steering slip in one drive; none for a robot without a steering encoder.
pub(super) fn monitors(scene: &Scene, truths: &[Truth], base: &DrawnBase) -> Vec<Monitor> {
    let Some(encoder) = &scene.robot.steering_encoder else { return Vec::new() };
    let mut rate = Monitor::new(bounds::WHEELS_STEERING_RATE);
    let mut slip = Monitor::new(bounds::WHEELS_STEERING_SLIP);
    let gone = gone(truths, base);
    let step_s = truths.get(1).map_or(0.01, |second| second.time_s - truths[0].time_s);
    let window_steps = (scene.bounds.slip_window_s / step_s).round().max(1.0) as usize;
    let [per_m_rad, floor_rad] = [encoder.slip_deg_per_m, encoder.slip_floor_deg].map(f64::to_radians);
    let measure = |start: usize, end: usize| {
        let rolled_m = gone[end].rolled_m - gone[start].rolled_m;
        let turning_rad = gone[end].turning_rad - gone[start].turning_rad;
        let declared_rad = encoder.slip_share * turning_rad + per_m_rad * rolled_m + floor_rad;
        (declared_rad, (gone[end].aside_rad - gone[start].aside_rad).abs())
    };
    for end in 1..truths.len() {
        let (before, truth) = (&truths[end - 1], &truths[end]);
        let steered_rad = (truth.steering_rad - before.steering_rad).abs();
        let span_s = [before.time_s, truth.time_s];
        rate.watch(span_s, encoder.rate_deg_per_s.to_radians(), steered_rad / (truth.time_s - before.time_s));
        watch_windows(&mut slip, truths, measure, end.saturating_sub(window_steps)..end, end);
    }
    vec![rate, slip]
}

/// What has come together since the start of a drive.
#[derive(Clone, Copy, Default)]
struct Gone {
    /// Mean distance that both rear wheels have rolled, forth and back.
    rolled_m: f64,
    /// Turn by steering angle and travel, to either side without regard to sign.
    turning_rad: f64,
    /// Turn of the car, less that by its steering angle δ and its travel T, with the wheelbase L: Δφ = tan δ/L·ΔT.
    aside_rad: f64,
}

/// What has come together at each step. From one step to the next, steering angle and travel change evenly.
fn gone(truths: &[Truth], base: &DrawnBase) -> Vec<Gone> {
    let mut gone = Gone::default();
    let mut all = vec![gone];
    for pair in truths.windows(2) {
        let mean = |of: [f64; 2]| 0.5 * (of[0] + of[1]);
        let travel_m = mean(pair[1].wheel_travel_m) - mean(pair[0].wheel_travel_m);
        let middle_rad = mean([pair[0].steering_rad, pair[1].steering_rad]);
        let turn_rad = pair[1].pose.heading_rad - pair[0].pose.heading_rad;
        let steered_rad = travel_m * middle_rad.tan() / base.wheelbase_m;
        gone.turning_rad += steered_rad.abs();
        gone.aside_rad += turn_rad - steered_rad;
        let rolled_m = |wheel: usize| {
            base.wheel_radius_m[wheel] * (pair[1].wheel_angle_rad[wheel] - pair[0].wheel_angle_rad[wheel]).abs()
        };
        gone.rolled_m += mean([rolled_m(0), rolled_m(1)]);
        all.push(gone);
    }
    all
}
