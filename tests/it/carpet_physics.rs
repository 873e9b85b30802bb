//! Tests of carpets, ramps, stuck wheels, lifts and snapshots against closed forms, and of Borenstein's square path.

use sim::{
    scene::Scene,
    truth::Truth,
    world::{Drawn, World},
};

use crate::command::rounds;
use crate::world_setup::{command, hold, nominal, nominal_world, scene};

/// Share of the robot's weight that the drive wheels carry.
const WHEEL_SHARE: f64 = 0.85;
const TYRE_STIFFNESS: f64 = 25.0;

/// A scene with a vacuum robot in the middle of an 8 × 6 m room whose whole floor is a region with these keys.
fn on_carpet(heading_deg: f64, keys: serde_json::Value) -> Scene {
    let mut region = serde_json::json!({ "name": "carpet", "x_m": [0.0, 8.0], "y_m": [0.0, 6.0], "friction": 0.8 });
    for (key, value) in keys.as_object().unwrap() {
        region[key] = value.clone();
    }
    scene(serde_json::json!({
        "robot": { "preset": "vacuum" },
        "floor": { "region": [region] },
        "start": { "x_m": 4.0, "y_m": 3.0, "heading_deg": heading_deg, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
    }))
}

/// Drives straight ahead, accelerating for a second, and returns the true states before and after the drive at constant speed.
fn cruise(world: &mut World, speed_m_per_s: f64, lasts_s: f64) -> (Truth, Truth) {
    for step in 0..1000 {
        world.step(command(speed_m_per_s * f64::from(step) / 1000.0, 0.0));
    }
    let before = hold(world, command(speed_m_per_s, 0.0), 0.5);
    (before, hold(world, command(speed_m_per_s, 0.0), lasts_s))
}

fn rolled_m(before: &Truth, after: &Truth) -> f64 {
    0.035 * 0.5 * (0..2).map(|wheel| after.wheel_angle_rad[wheel] - before.wheel_angle_rad[wheel]).sum::<f64>()
}

#[test]
fn the_nap_carries_the_robot_its_own_way_whatever_way_it_drives() {
    let (drift, direction_deg) = (0.02, 40.0_f64);
    let keys = serde_json::json!({ "nap_drift": drift, "nap_direction_deg": direction_deg, "pile_stiffness": 10.0 });
    for (heading_deg, speed_m_per_s) in [(0.0_f64, 0.2), (100.0, 0.2), (250.0, -0.2)] {
        let mut world = nominal_world(&on_carpet(heading_deg, keys.clone()));
        let (before, after) = cruise(&mut world, speed_m_per_s, 5.0);
        let rolled_m = rolled_m(&before, &after);
        let (sin, cos) = heading_deg.to_radians().sin_cos();
        let carried_m =
            [after.pose.x_m - before.pose.x_m - rolled_m * cos, after.pose.y_m - before.pose.y_m - rolled_m * sin];
        let expected_m = [direction_deg.to_radians().cos(), direction_deg.to_radians().sin()]
            .map(|along| along * drift * rolled_m.abs());
        let off_m = (carried_m[0] - expected_m[0]).hypot(carried_m[1] - expected_m[1]);
        assert!(off_m < 0.005 * drift * rolled_m.abs(), "at {heading_deg}°: carried {carried_m:?}, not {expected_m:?}");
        let turned_rad = after.pose.heading_rad - heading_deg.to_radians();
        assert!(turned_rad.abs() < 1e-4, "the nap turned the robot by {turned_rad} rad");
    }
}

/// Slip of brush wheels of this stiffness that bear a force, given as a share of the robot's weight: F = μN·(1 − (1 − s)³), σ = 3μ·s/C.
fn closed_form_slip(force_over_weight: f64, friction: f64, stiffness: f64) -> f64 {
    let s = 1.0 - (1.0 - force_over_weight / (friction * WHEEL_SHARE)).cbrt();
    3.0 * friction * s / stiffness
}

#[test]
fn pile_bends_in_series_with_the_tyre_and_drags_at_wheels_and_casters() {
    for (pile, drag) in [(10.0, 0.05), (4.0, 0.08)] {
        let keys = serde_json::json!({ "pile_stiffness": pile, "drag": drag });
        let mut world = nominal_world(&on_carpet(0.0, keys));
        let (before, after) = cruise(&mut world, 0.2, 4.0);
        let slip = 1.0 - (after.pose.x_m - before.pose.x_m) / rolled_m(&before, &after);
        let expected = closed_form_slip(drag, 0.8, TYRE_STIFFNESS * pile / (TYRE_STIFFNESS + pile));
        assert!(
            (slip / expected - 1.0).abs() < 0.005,
            "slip {slip} on pile {pile} with drag {drag}, expected {expected}"
        );
    }
}

#[test]
fn the_vacuum_robot_travels_what_its_wheels_roll() {
    let mut world = nominal_world(&on_carpet(0.0, serde_json::json!({})));
    let (before, after) = cruise(&mut world, 0.25, 8.0);
    let (travelled_m, rolled_m) = (after.pose.x_m - before.pose.x_m, rolled_m(&before, &after));
    assert!(
        (rolled_m - 2.0).abs() < 1e-3 && (travelled_m / rolled_m - 1.0).abs() < 50e-6,
        "{travelled_m} of {rolled_m} m"
    );
}

#[test]
fn a_robot_climbs_onto_a_carpet_and_down_again() {
    let (height_m, ramp_m) = (0.004, 0.03_f64);
    let region = serde_json::json!({
        "name": "rug", "x_m": [2.6, 4.0], "y_m": [0.0, 6.0], "friction": 0.8, "height_m": height_m, "ramp_m": ramp_m,
    });
    let scene = scene(serde_json::json!({ "robot": { "preset": "vacuum" }, "floor": { "region": [region] } }));
    let mut world = nominal_world(&scene);
    let (before, mut greatest_tilt_rad, mut on_top) = (world.truth(), 0.0_f64, None);
    while world.truth().pose.x_m < 4.6 && world.truth().time_s < 30.0 {
        let truth = world.step(command(0.2, 0.0));
        greatest_tilt_rad = greatest_tilt_rad.max(truth.tilt_rad[1].abs());
        on_top = on_top.or((truth.pose.x_m > 3.3).then_some(truth));
    }
    let (on_top, after) = (on_top.unwrap(), hold(&mut world, command(0.0, 0.0), 1.0));
    assert!((on_top.heave_m - height_m).abs() < 5e-5 && on_top.tilt_rad[1].abs() < 1e-3, "{on_top:?}");
    assert!(after.heave_m.abs() < 1e-6, "{after:?}");
    // The tilt is greatest with one caster on the rug and the other, 0.272 m away, off it.
    assert!((0.5 * height_m / 0.272..2.5 * height_m / 0.272).contains(&greatest_tilt_rad), "{greatest_tilt_rad} rad");
    // The path along both ramps is longer than its projection on the floor; slip on the way up is cancelled by slip on the way down.
    let longer_m = rolled_m(&before, &after) - (after.pose.x_m - before.pose.x_m);
    let expected_m = 2.0 * (ramp_m.hypot(height_m) - ramp_m);
    assert!(
        (longer_m / expected_m - 1.0).abs() < 0.25,
        "rolled {longer_m} m more than travelled, expected {expected_m} m"
    );
}

fn with_event(event: serde_json::Value) -> Scene {
    scene(serde_json::json!({ "robot": { "preset": "vacuum" }, "event": [event] }))
}

#[test]
fn a_blocked_wheel_is_what_the_robot_turns_about() {
    let event = serde_json::json!({ "kind": "stuck_wheel", "at_s": 2.0, "wheel": "left", "lasts_s": 2.0 });
    let mut world = nominal_world(&with_event(event));
    let (before, stuck) = (hold(&mut world, command(0.2, 0.0), 2.5), hold(&mut world, command(0.2, 0.0), 1.0));
    assert_eq!(before.wheel_angle_rad[0], stuck.wheel_angle_rad[0]);
    let turned_rad = stuck.pose.heading_rad - before.pose.heading_rad;
    assert!((turned_rad / (0.2 / 0.23) - 1.0).abs() < 0.02, "turned {turned_rad} rad in a second");
    assert!((stuck.wheel_travel_m[0] - before.wheel_travel_m[0]).abs() < 1e-3, "{stuck:?}");
    let freed = hold(&mut world, command(0.2, 0.0), 1.5);
    assert!(freed.velocity[0] > 0.19 && freed.velocity[2].abs() < 0.01, "{freed:?}");
}

#[test]
fn a_spinning_wheel_rolls_on_without_taking_the_robot_along() {
    let event =
        serde_json::json!({ "kind": "stuck_wheel", "at_s": 1.0, "wheel": "right", "how": "spinning", "lasts_s": 2.0 });
    let mut world = nominal_world(&with_event(event));
    let before = hold(&mut world, command(0.0, 0.5), 1.2);
    let after = hold(&mut world, command(0.3, 0.0), 1.5);
    let rolled_m = 0.035 * (after.wheel_angle_rad[1] - before.wheel_angle_rad[1]);
    let travelled_m = after.wheel_travel_m[1] - before.wheel_travel_m[1];
    assert!(rolled_m > 0.35 && rolled_m - travelled_m > 0.05, "rolled {rolled_m} m, travelled {travelled_m} m");
}

#[test]
fn a_lifted_robot_is_put_down_where_and_as_hands_want() {
    let event = serde_json::json!({
        "kind": "lift", "at_s": 1.0, "displacement_m": [0.1, -0.05], "turn_deg": 20.0, "lasts_s": 1.5,
    });
    let mut world = nominal_world(&with_event(event));
    let before = hold(&mut world, command(0.2, 0.0), 1.0);
    let highest_m = (0..1500).map(|_| world.step(command(0.2, 0.0)).heave_m).fold(0.0, f64::max);
    let after = world.truth();
    assert!((0.05..0.07).contains(&highest_m), "{highest_m} m");
    let moved_m = [after.pose.x_m - before.pose.x_m, after.pose.y_m - before.pose.y_m];
    assert!((moved_m[0] - 0.1).abs() < 0.004 && (moved_m[1] + 0.05).abs() < 0.004, "{moved_m:?}");
    let turned_deg = (after.pose.heading_rad - before.pose.heading_rad).to_degrees();
    assert!((turned_deg - 20.0).abs() < 0.3, "{turned_deg}°");
    assert!(0.035 * (after.wheel_angle_rad[0] - before.wheel_angle_rad[0]) > 0.25, "the wheels stood in the air");
    let on = hold(&mut world, command(0.2, 0.0), 1.0);
    assert!(on.heave_m.abs() < 1e-5 && (on.velocity[0] - 0.2).abs() < 1e-3, "{on:?}");
}

#[test]
fn a_robot_at_rest_drifts_less_than_five_micrometres_an_hour() {
    let minutes = rounds(4.0, 15.0);
    let carpet = serde_json::json!({ "pile_stiffness": 5.0, "nap_drift": 0.02, "drag": 0.05, "height_m": 0.004 });
    let rests = |scene: &Scene| {
        let mut world = World::new(scene, &Drawn::draw(scene, 5));
        let settled = hold(&mut world, command(0.0, 0.0), 5.0);
        let truth = hold(&mut world, command(0.0, 0.0), minutes * 60.0);
        let drift_m = (truth.pose.x_m - settled.pose.x_m).hypot(truth.pose.y_m - settled.pose.y_m);
        assert!(drift_m <= 5e-6 * minutes / 60.0, "drifted {drift_m} m in {minutes} minutes");
    };
    let scenes = [scene(serde_json::json!({})), on_carpet(33.0, carpet)];
    std::thread::scope(|scope| scenes.iter().for_each(|scene| drop(scope.spawn(move || rests(scene)))));
}

#[test]
fn a_restored_snapshot_goes_on_with_the_same_bytes() {
    // The scene contains everything of the simulated world that changes with time and that a snapshot therefore has to restore: a wall to touch, a
    // person, a push, a carpet's edge, a stuck wheel and a lift.
    let scene = scene(serde_json::json!({
        "robot": { "preset": "vacuum" },
        "room": { "width_m": 3.0, "depth_m": 3.0 },
        "start": { "x_m": 0.5, "y_m": 1.5 },
        "person": [{ "waypoints_m": [[2.5, 0.5], [2.5, 2.5]], "speed_m_per_s": 0.5 }],
        "floor": { "region": [{
            "name": "rug", "x_m": [1.0, 2.0], "y_m": [0.0, 3.0], "friction": 0.7, "height_m": 0.004, "drag": 0.05,
            "pile_stiffness": 8.0, "nap_drift": 0.02,
        }] },
        "event": [
            { "kind": "push", "at_s": 3.0, "displacement_m": [0.0, 0.05], "lasts_s": 0.5 },
            { "kind": "stuck_wheel", "at_s": 5.0, "wheel": "left", "lasts_s": 0.5 },
            { "kind": "lift", "at_s": 6.0, "turn_deg": 20.0, "lasts_s": 0.6 },
        ],
    }));
    let bits = |world: &mut World| -> Vec<u64> {
        let truth = world.step(command(0.3, 0.05));
        let pose = truth.pose.to_array();
        let more =
            [truth.heave_m, truth.tilt_rad[0], truth.tilt_rad[1], truth.wheel_angle_rad[0], truth.wheel_angle_rad[1]];
        pose.into_iter().chain(more).chain(truth.velocity).map(f64::to_bits).collect()
    };
    for at_step in [100, 3200, 5300, 6300, 8500] {
        let mut world = World::new(&scene, &Drawn::draw(&scene, 3));
        (0..at_step).for_each(|_| drop(bits(&mut world)));
        let mut restored = world.clone();
        for step in at_step..at_step + 4000 {
            assert_eq!(bits(&mut world), bits(&mut restored), "{step} differs after a snapshot at {at_step}");
        }
    }
}

/// End position relative to the start, x and y, of a robot commanded to drive a square of 4 m, with left (`turn` = 1) or right (−1) turns at its
/// corners.
fn square(scene: &Scene, drawn: &Drawn, turn: f64) -> [f64; 2] {
    let mut world = World::new(scene, drawn);
    let robot = &scene.robot;
    // Each wheel is commanded to roll a given length, as by a robot that relies on its nominal dimensions, with a constant acceleration of 0.25
    // m/s².
    let mut roll = |left_m: f64, right_m: f64| {
        let (longest_m, peak_m_per_s, rise_s) = (left_m.abs().max(right_m.abs()), 0.3_f64, 1.2);
        let hold_s = longest_m / peak_m_per_s - rise_s;
        let (peak_m_per_s, hold_s) = if hold_s > 0.0 { (peak_m_per_s, hold_s) } else { (longest_m / rise_s, 0.0) };
        let n_steps = ((2.0 * rise_s + hold_s) * 1000.0).ceil() as usize + 1000;
        let mut told = 0.0;
        for step in 0..n_steps {
            let time_s = (step as f64 + 0.5) * 0.001;
            let speed = (time_s / rise_s).min((2.0 * rise_s + hold_s - time_s) / rise_s).clamp(0.0, 1.0) * peak_m_per_s;
            let speed = speed.min(((longest_m - told) / 0.001).max(0.0));
            told += speed * 0.001;
            let wheel = |way_m: f64| way_m / longest_m * speed / robot.base.wheel_radius_m;
            world.step_wheels([wheel(left_m), wheel(right_m)]);
        }
    };
    let quarter_m = turn * std::f64::consts::FRAC_PI_2 * 0.5 * robot.base.track_m;
    for _ in 0..4 {
        roll(4.0, 4.0);
        roll(-quarter_m, quarter_m);
    }
    let end = world.truth().pose;
    [end.x_m - drawn.start.x_m, end.y_m - drawn.start.y_m]
}

#[test]
fn borensteins_square_recovers_wheel_and_track_errors() {
    let start = serde_json::json!({ "x_m": 5.0, "y_m": 5.0, "tolerance_m": 0.0, "tolerance_deg": 0.0 });
    let scene = scene(serde_json::json!({ "room": { "width_m": 10.0, "depth_m": 10.0 }, "start": start }));
    let (unequal, wider) = (1.0003, 1.003);
    let mut drawn = nominal(&scene);
    drawn.base.wheel_radius_m = [0.0975 * 2.0 / (1.0 + unequal), 0.0975 * 2.0 * unequal / (1.0 + unequal)];
    drawn.base.track_m = 0.33 * wider;
    let (left, right) = (square(&scene, &drawn, 1.0), square(&scene, &drawn, -1.0));
    // Borenstein and Feng 1996, eqs. 15 to 21: error angles α per corner and β per leg, each computed from x and from y.
    let side_m = 4.0;
    let alpha = [(right[0] + left[0]) / (-4.0 * side_m), (right[1] - left[1]) / (-4.0 * side_m)];
    let beta = [(right[0] - left[0]) / (-4.0 * side_m), (right[1] + left[1]) / (-4.0 * side_m)];
    let (alpha_rad, beta_rad) = (0.5 * (alpha[0] + alpha[1]), 0.5 * (beta[0] + beta[1]));
    let radius_m = 0.5 * side_m / (0.5 * beta_rad).sin();
    let found_unequal = (radius_m + 0.5 * drawn.base.track_m) / (radius_m - 0.5 * drawn.base.track_m);
    let quarter_rad = std::f64::consts::FRAC_PI_2;
    let found_wider = quarter_rad / (quarter_rad - alpha_rad);
    assert!(((found_unequal - 1.0) / (unequal - 1.0) - 1.0).abs() < 0.01, "wheels {found_unequal}, injected {unequal}");
    assert!(((found_wider - 1.0) / (wider - 1.0) - 1.0).abs() < 0.01, "track {found_wider}, injected {wider}");
}
