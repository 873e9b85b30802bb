//! Tests of the driver, which steers the robot along its route by the estimated pose: it reaches what the route demands, and drives gently enough for
//! the bounds that a scene declares by default.

use localizer::{Estimate, PoseUnion, Status};
use sim::{
    base::DriveCommand,
    driver::Driver,
    scene::{Bounds, Scene},
    truth::Truth,
    world::{Drawn, World},
};

use crate::world_setup::{drive, estimate, hold, nominal, scene};

fn waypoint(x_m: f64, y_m: f64, turn_in_place: bool, pause_s: f64) -> serde_json::Value {
    serde_json::json!({ "x_m": x_m, "y_m": y_m, "speed_m_per_s": 0.5, "turn_in_place": turn_in_place, "pause_s": pause_s })
}

/// A 3.6 × 2.4 m room with a route of lanes, in which the robot takes some corners in a curve and turns on the spot in others.
fn lanes() -> Scene {
    let corners =
        [(3.1, 0.5, true), (3.1, 0.9, true), (0.5, 0.9, true), (0.5, 1.9, false), (3.1, 1.9, false), (1.8, 0.5, true)];
    let waypoints: Vec<_> = corners.iter().map(|(x_m, y_m, in_place)| waypoint(*x_m, *y_m, *in_place, 0.0)).collect();
    scene(serde_json::json!({
        "room": { "width_m": 3.6, "depth_m": 2.4 },
        "start": { "x_m": 0.5, "y_m": 0.5 },
        "route": { "waypoint": waypoints, "repeat": true },
    }))
}

fn distance_m(truth: &Truth, place_m: [f64; 2]) -> f64 {
    (truth.pose.x_m - place_m[0]).hypot(truth.pose.y_m - place_m[1])
}

#[test]
fn the_driver_passes_every_waypoint_and_stops_at_the_last() {
    let waypoints = [
        waypoint(4.0, 3.0, true, 0.0),
        waypoint(4.0, 4.5, false, 0.0),
        waypoint(2.0, 4.5, false, 1.5),
        waypoint(2.0, 3.5, false, 0.0),
    ];
    let scene = scene(serde_json::json!({ "route": { "waypoint": waypoints } }));
    let truths = drive(&scene, &nominal(&scene), 30.0);
    for (place_m, within_m) in [([4.0, 3.0], 0.02), ([4.0, 4.5], 0.2), ([2.0, 4.5], 0.02), ([2.0, 3.5], 0.02)] {
        let nearest_m = truths.iter().map(|truth| distance_m(truth, place_m)).fold(f64::INFINITY, f64::min);
        assert!(nearest_m < within_m, "came within {nearest_m} m of {place_m:?}");
    }
    let paused_s = 0.01
        * truths
            .iter()
            .filter(|truth| {
                distance_m(truth, [2.0, 4.5]) < 0.02 && truth.velocity[0].abs() < 1e-3 && truth.velocity[2].abs() < 1e-3
            })
            .count() as f64;
    assert!((1.4..2.5).contains(&paused_s), "paused for {paused_s} s");
    let end = truths.last().unwrap();
    assert!(distance_m(end, [2.0, 3.5]) < 0.02 && end.velocity.iter().all(|speed| speed.abs() < 1e-6), "{end:?}");
}

#[test]
fn the_driver_turns_on_the_spot_where_the_route_says_so() {
    let corner_m = |in_place: bool| {
        let waypoints = [waypoint(3.5, 3.0, in_place, 0.0), waypoint(3.5, 4.5, false, 0.0)];
        let scene = scene(serde_json::json!({ "route": { "waypoint": waypoints } }));
        let truths = drive(&scene, &nominal(&scene), 15.0);
        let turning = truths.iter().find(|truth| truth.pose.heading_rad > 0.8).unwrap();
        distance_m(turning, [3.5, 3.0])
    };
    assert!(corner_m(true) < 0.02, "turned {} m off the corner", corner_m(true));
    assert!(corner_m(false) > 0.05, "cut the corner by {} m only", corner_m(false));
}

#[test]
fn a_repeated_route_goes_round_again() {
    let truths = drive(&lanes(), &nominal(&lanes()), 120.0);
    let arrivals = truths
        .windows(2)
        .filter(|pair| distance_m(&pair[0], [3.1, 0.5]) >= 0.1 && distance_m(&pair[1], [3.1, 0.5]) < 0.1)
        .count();
    assert!(arrivals >= 2, "passed the first waypoint {arrivals} times in 120 s");
}

/// Greatest slip and side slip of the robot over all time windows up to the declared length, each divided by the declared bound.
fn used_shares(truths: &[Truth], drawn: &Drawn, bounds: &Bounds) -> [f64; 2] {
    let rolled_m = |from: &Truth, to: &Truth, wheel: usize| {
        drawn.base.wheel_radius_m[wheel] * (to.wheel_angle_rad[wheel] - from.wheel_angle_rad[wheel])
    };
    let mut path_m = vec![[0.0; 2]];
    for pair in truths.windows(2) {
        let before_m = path_m[path_m.len() - 1];
        path_m.push([0, 1].map(|wheel| before_m[wheel] + rolled_m(&pair[0], &pair[1], wheel).abs()));
    }
    let n_steps = (bounds.slip_window_s / 0.01).round() as usize;
    let mut used = [0.0_f64; 2];
    for to in 1..truths.len() {
        for from in to.saturating_sub(n_steps)..to {
            let paths_m = [0, 1].map(|wheel| path_m[to][wheel] - path_m[from][wheel]);
            for (wheel, path_m) in paths_m.into_iter().enumerate() {
                let travel_m = truths[to].wheel_travel_m[wheel] - truths[from].wheel_travel_m[wheel];
                let slip_m = (travel_m - rolled_m(&truths[from], &truths[to], wheel)).abs();
                used[0] = used[0].max(slip_m / (bounds.slip_ratio * path_m + bounds.slip_floor_m));
            }
            let side_m = (truths[to].lateral_travel_m - truths[from].lateral_travel_m).abs();
            let path_m = 0.5 * (paths_m[0] + paths_m[1]);
            used[1] = used[1].max(side_m / (bounds.side_slip_ratio * path_m + bounds.side_slip_floor_m));
        }
    }
    used
}

#[test]
fn a_nominal_drive_keeps_the_default_bounds() {
    let scene = lanes();
    let bounds = Bounds::default();
    for seed in 0..2 {
        let drawn = Drawn::draw(&scene, seed);
        let truths = drive(&scene, &drawn, 60.0);
        let used = used_shares(&truths, &drawn, &bounds);
        assert!(used[0] < 0.75 && used[1] < 0.75, "seed {seed}: slip uses {used:?} of its bounds");
        for pair in truths.windows(2) {
            let truth = &pair[1];
            assert!(truth.tilt_rad[0].hypot(truth.tilt_rad[1]).to_degrees() < 0.75 * bounds.body_tilt_deg, "{truth:?}");
            assert!(truth.heave_m.abs() < 0.75 * bounds.body_heave_m, "{truth:?}");
            for side in [-0.165, 0.165] {
                let along = |truth: &Truth| truth.velocity[0] + side * truth.velocity[2];
                let acceleration_m_per_s2 = (along(truth) - along(&pair[0])).abs() / 0.01;
                assert!(
                    acceleration_m_per_s2 < 0.75 * bounds.reach_acceleration_m_per_s2,
                    "{acceleration_m_per_s2} m/s²"
                );
            }
        }
    }
}

#[test]
fn a_jumping_estimate_neither_stops_the_driver_nor_breaks_the_slip_bound() {
    let scene = lanes();
    let drawn = nominal(&scene);
    let (mut world, mut driver) = (World::new(&scene, &drawn), Driver::new(&scene));
    let mut truths = vec![world.truth()];
    for step in 0..6000_usize {
        let mut seen = world.truth();
        // The estimated pose jumps every 0.2 s by up to 2 cm and 1°, as when fixes of heading and position move the middle of the estimate's box.
        let jump = ((step / 20 * 7919) % 101) as f64 / 50.0 - 1.0;
        seen.pose.x_m += 0.02 * jump;
        seen.pose.y_m -= 0.02 * jump;
        seen.pose.heading_rad += 0.017 * jump;
        let command = driver.command(&estimate(&seen), step as f64 * 0.01);
        truths.push(hold(&mut world, command, 0.01));
    }
    let path_m: f64 = truths.windows(2).map(|pair| distance_m(&pair[0], [pair[1].pose.x_m, pair[1].pose.y_m])).sum();
    assert!(path_m > 12.0, "drove {path_m} m in 60 s");
    let used = used_shares(&truths, &drawn, &Bounds::default());
    assert!(used[0] < 1.0 && used[1] < 1.0, "slip uses {used:?} of its bounds");
}

#[test]
fn a_doubting_robot_by_a_wall_looks_around_and_then_goes_on() {
    let scene = lanes();
    let (mut world, mut driver) = (World::new(&scene, &nominal(&scene)), Driver::new(&scene));
    let mut progress_m = Vec::new();
    for step in 0..4000 {
        let mut doubt: Estimate = estimate(&world.truth());
        doubt.status = Status::Recovering;
        let mut hull = doubt.pose.hull();
        hull[1] = hull[1].inflate(0.3);
        doubt.pose = PoseUnion::single(hull);
        let command = driver.command(&doubt, f64::from(step) * 0.01);
        progress_m.push(distance_m(&hold(&mut world, command, 0.01), [0.5, 0.5]));
    }
    assert!(progress_m[900] < 0.02, "moved {} m while in doubt by a wall", progress_m[900]);
    assert!(progress_m[3999] > 0.5, "stuck for ever, {} m from the start", progress_m[3999]);
}

#[test]
fn without_a_route_or_an_estimate_the_robot_stands() {
    let scene = scene(serde_json::json!({}));
    let mut driver = Driver::new(&scene);
    let nowhere = Estimate { pose: PoseUnion::default(), ..estimate(&Truth::default()) };
    for step in 0..200 {
        let time_s = f64::from(step) * 0.01;
        assert_eq!(driver.command(&nowhere, time_s), DriveCommand::default());
    }
    assert_eq!(driver.command(&estimate(&Truth::default()), 2.0), DriveCommand::default());
}
