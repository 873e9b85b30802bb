//! Compares the declared bounds on the robot's motion with the true motion: wheel slip, side slip, reach (speed, turn rate and acceleration),
//! posture, and distance from walls.

use crate::{run::RunRecord, scene::Scene, truth::Truth};
use localizer::bounds;

use super::{
    monitor::{Monitor, watch_windows},
    steering,
};

/// Monitors of the bounds on the robot's motion, each drive by itself: from one station to the next the robot is put, it does not roll.
pub(super) fn monitors(scene: &Scene, record: &RunRecord) -> Vec<Monitor> {
    let mut all = Vec::new();
    for truths in record.drives() {
        all.extend(slip(scene, truths, record.drawn.base.wheel_radius_m));
        all.extend(reach(scene, truths, record.drawn.base.wheel_radius_m));
        all.extend(posture(scene, truths));
        all.extend(steering::monitors(scene, truths, &record.drawn.base));
    }
    all
}

/// Values since the start of the drive, for the left wheel, the right wheel and the middle of the axle: the path that was rolled, and the error of
/// the travel. The error of a wheel is its true travel less the travel that it rolled; the error of the axle's middle is its lateral travel.
struct Rolled {
    path_m: [f64; 3],
    error_m: [f64; 3],
}

/// Monitors of the bounds on wheel slip and side slip. Both bounds hold over every time window up to the declared length, since the localizer relies
/// on short windows as well.
fn slip(scene: &Scene, truths: &[Truth], wheel_radius_m: [f64; 2]) -> Vec<Monitor> {
    let bounds = &scene.bounds;
    let rolled = rolled(truths, wheel_radius_m);
    let step_s = truths.get(1).map_or(0.01, |second| second.time_s - truths[0].time_s);
    let window_steps = (bounds.slip_window_s / step_s).round().max(1.0) as usize;
    let slip_bound = [bounds.slip_ratio, bounds.slip_floor_m];
    let side_bound = [bounds.side_slip_ratio, bounds.side_slip_floor_m];
    let (mut slip, mut side) = (Monitor::new(bounds::WHEELS_SLIP), Monitor::new(bounds::WHEELS_SIDE_SLIP));
    for end in 1..rolled.len() {
        let starts = end.saturating_sub(window_steps)..end;
        for wheel in 0..2 {
            watch_windows(&mut slip, truths, measure(&rolled, wheel, slip_bound), starts.clone(), end);
        }
        watch_windows(&mut side, truths, measure(&rolled, 2, side_bound), starts, end);
    }
    vec![slip, side]
}

/// The declared bound and the true error of one channel (left wheel, right wheel or lateral travel) from one step to another.
fn measure(rolled: &[Rolled], channel: usize, [ratio, floor_m]: [f64; 2]) -> impl Fn(usize, usize) -> (f64, f64) {
    move |start, end| {
        let path_m = rolled[end].path_m[channel] - rolled[start].path_m[channel];
        let error_m = (rolled[end].error_m[channel] - rolled[start].error_m[channel]).abs();
        (ratio * path_m + floor_m, error_m)
    }
}

fn rolled(truths: &[Truth], wheel_radius_m: [f64; 2]) -> Vec<Rolled> {
    let mut path_m = [0.0; 3];
    let mut before: Option<&Truth> = None;
    truths
        .iter()
        .map(|truth| {
            if let Some(before) = before {
                let step_m = [0, 1].map(|wheel| {
                    wheel_radius_m[wheel] * (truth.wheel_angle_rad[wheel] - before.wheel_angle_rad[wheel]).abs()
                });
                (path_m[0], path_m[1]) = (path_m[0] + step_m[0], path_m[1] + step_m[1]);
                path_m[2] += 0.5 * (step_m[0] + step_m[1]);
            }
            before = Some(truth);
            let error_m =
                [0, 1].map(|wheel| truth.wheel_travel_m[wheel] - wheel_radius_m[wheel] * truth.wheel_angle_rad[wheel]);
            Rolled { path_m, error_m: [error_m[0], error_m[1], truth.lateral_travel_m] }
        })
        .collect()
}

/// Monitors of the bounds on speed, turn rate and acceleration. The acceleration is that of the points of the body above the wheels, and that of the
/// wheels' rims: the localizer assumes that between two readings the wheel counts deviate from a straight line by no more than the bound on
/// acceleration allows.
fn reach(scene: &Scene, truths: &[Truth], wheel_radius_m: [f64; 2]) -> Vec<Monitor> {
    let bounds = &scene.bounds;
    let mut speed = Monitor::new(bounds::REACH_SPEED);
    let mut turn_rate = Monitor::new(bounds::REACH_TURN_RATE);
    let mut acceleration = Monitor::new(bounds::REACH_ACCELERATION);
    for end in 1..truths.len() {
        let (before, truth) = (&truths[end - 1], &truths[end]);
        let (span_s, step_s) = ([before.time_s, truth.time_s], truth.time_s - before.time_s);
        let moved_m = (truth.pose.x_m - before.pose.x_m).hypot(truth.pose.y_m - before.pose.y_m);
        speed.watch(span_s, bounds.reach_speed_m_per_s, moved_m / step_s);
        let turned_rad = (truth.pose.heading_rad - before.pose.heading_rad).abs();
        turn_rate.watch(span_s, bounds.reach_turn_rate_rad_per_s, turned_rad / step_s);
        for side in [-1.0, 1.0] {
            let along = |truth: &Truth| truth.velocity[0] + side * 0.5 * scene.robot.base.track_m * truth.velocity[2];
            let change = (along(truth) - along(before)).abs() / step_s;
            acceleration.watch(span_s, bounds.reach_acceleration_m_per_s2, change);
        }
        let Some(first) = end.checked_sub(2).map(|first| &truths[first]) else { continue };
        let (before, truth, after) = (first, before, truth);
        let (span_s, step_s) = ([before.time_s, after.time_s], 0.5 * (after.time_s - before.time_s));
        for (wheel, radius_m) in wheel_radius_m.into_iter().enumerate() {
            let turned_rad = after.wheel_angle_rad[wheel] - truth.wheel_angle_rad[wheel];
            let turned_before_rad = truth.wheel_angle_rad[wheel] - before.wheel_angle_rad[wheel];
            let rim_m_per_s2 = radius_m * (turned_rad - turned_before_rad).abs() / (step_s * step_s);
            acceleration.watch(span_s, bounds.reach_acceleration_m_per_s2, rim_m_per_s2);
        }
    }
    vec![speed, turn_rate, acceleration]
}

fn posture(scene: &Scene, truths: &[Truth]) -> Vec<Monitor> {
    let (bounds, [x, y]) = (&scene.bounds, scene.room_hull_m());
    let keep_m = scene.robot_model().body.clearance_m;
    let (mut tilt, mut heave, mut walls) =
        (Monitor::new(bounds::BODY_TILT), Monitor::new(bounds::BODY_HEAVE), Monitor::new(bounds::ROOM_WALLS));
    for truth in truths {
        let span_s = [truth.time_s, truth.time_s];
        tilt.watch(span_s, bounds.body_tilt_deg.to_radians(), truth.tilt_rad[0].hypot(truth.tilt_rad[1]));
        heave.watch(span_s, bounds.body_heave_m, truth.heave_m.abs());
        let (x_m, y_m) = (truth.pose.x_m, truth.pose.y_m);
        let to_wall_m =
            [x_m - x.lo(), x.hi() - x_m, y_m - y.lo(), y.hi() - y_m].into_iter().fold(f64::INFINITY, f64::min);
        // The bound on walls is the least distance of the robot's origin from a wall. The value that the monitor compares with 0 is by how much the
        // origin is closer to a wall than that.
        walls.watch(span_s, 0.0, keep_m - to_wall_m);
    }
    vec![tilt, heave, walls]
}
