//! Motion of the simulated robot against closed forms: at rest, straight on and in a circle; and the consistency of its true state.

use sim::world::{Drawn, World};

use crate::world_setup::{command, gather_speed, hold, nominal, nominal_world, scene};

#[test]
fn a_robot_at_rest_stays_at_rest() {
    let scene = scene(serde_json::json!({ "start": { "x_m": 2.0, "y_m": 3.0, "heading_deg": 33.0 } }));
    let drawn = Drawn::draw(&scene, 5);
    let mut world = World::new(&scene, &drawn);
    let truth = hold(&mut world, command(0.0, 0.0), 10.0);
    let drift_m = (truth.pose.x_m - drawn.start.x_m).hypot(truth.pose.y_m - drawn.start.y_m);
    assert!(drift_m < 1e-9, "drifted {drift_m} m in 10 s");
    assert!((truth.pose.heading_rad - drawn.start.heading_rad).abs() < 1e-9, "turned to {}", truth.pose.heading_rad);
    assert!(truth.heave_m.abs() < 1e-9 && truth.tilt_rad.iter().all(|tilt| tilt.abs() < 1e-9), "{truth:?}");
    assert_eq!(world.truth().time_s, 10.0);
}

#[test]
fn cruising_travels_what_the_wheels_roll() {
    let mut world = nominal_world(&scene(serde_json::json!({})));
    gather_speed(&mut world, 0.5, 0.0);
    let before = hold(&mut world, command(0.5, 0.0), 0.5);
    let after = hold(&mut world, command(0.5, 0.0), 10.0);
    let rolled_m = 0.0975 * (after.wheel_angle_rad[0] - before.wheel_angle_rad[0]);
    let travelled_m = after.pose.x_m - before.pose.x_m;
    assert!((travelled_m - 5.0).abs() < 0.005, "drove {travelled_m} m");
    assert!((travelled_m / rolled_m - 1.0).abs() < 50e-6, "travelled {travelled_m} m on {rolled_m} m rolled");
    assert!((after.pose.y_m - 3.0).abs() < 1e-9, "left the straight line: {:?}", after.pose);
}

#[test]
fn gathering_speed_slips_as_the_brush_says() {
    let mut world = nominal_world(&scene(serde_json::json!({})));
    for step in 0..1000 {
        world.step(command(0.4 * step as f64 / 1000.0, 0.0));
    }
    let before = world.truth();
    let after = {
        for step in 1000..1100 {
            world.step(command(0.4 * step as f64 / 1000.0, 0.0));
        }
        world.truth()
    };
    let rolled_m = 0.0975 * (after.wheel_angle_rad[0] - before.wheel_angle_rad[0]);
    let slip = 1.0 - (after.wheel_travel_m[0] - before.wheel_travel_m[0]) / rolled_m;
    // The force is m·a = C·σ·N for slip stiffness C, slip σ and 85 % of the weight N on the driven wheels; the curvature of the brush model is F
    // = Cσ(1 − s + s²/3).
    let needed = 0.4 / (9.80665 * 0.85);
    let linear = needed / 25.0;
    let expected = linear * (1.0 + linear * 25.0 / (3.0 * 0.8));
    assert!((slip / expected - 1.0).abs() < 0.03, "slip {slip}, expected {expected}");
}

#[test]
fn a_circle_has_the_closed_form_turn_rate_and_slip_angle() {
    let start = serde_json::json!({ "x_m": 4.0, "y_m": 1.5, "tolerance_m": 0.0, "tolerance_deg": 0.0 });
    let mut world = nominal_world(&scene(serde_json::json!({ "start": start })));
    let (speed_m_per_s, turn_rad_per_s) = (0.5, 0.4);
    gather_speed(&mut world, speed_m_per_s, turn_rad_per_s);
    let before = hold(&mut world, command(speed_m_per_s, turn_rad_per_s), 2.0);
    let lap_s = std::f64::consts::TAU / turn_rad_per_s;
    let after = hold(&mut world, command(speed_m_per_s, turn_rad_per_s), (lap_s * 1000.0).round() / 1000.0);
    let turned_rad = after.pose.heading_rad - before.pose.heading_rad;
    assert!((turned_rad / std::f64::consts::TAU - 1.0).abs() < 5e-4, "turned {turned_rad} rad in a lap");
    let gap_m = (after.pose.x_m - before.pose.x_m).hypot(after.pose.y_m - before.pose.y_m);
    assert!(gap_m < 0.002, "the circle does not close: {gap_m} m");

    // The centripetal force m·v·ω acts on wheels that bear 85 % of the weight, the outer one more by m·a·h/t, with sideways acceleration a,
    // height h of the mass and track t. Both wheels slide sideways at the same speed v_y, so that σ = v_y/V_r. To first order of the brush model,
    // F = Σ C·N·σ·(1 − s).
    let (mass_kg, height_m, track_m) = (9.0, 0.125, 0.33);
    let sideways_m_per_s2 = speed_m_per_s * turn_rad_per_s;
    let shift_n = mass_kg * sideways_m_per_s2 * height_m / track_m;
    let mean_n = 0.5 * 0.85 * mass_kg * 9.80665;
    let wheels = [(mean_n - shift_n, 0.5 - 0.165 * 0.4), (mean_n + shift_n, 0.5 + 0.165 * 0.4)];
    let force_n = |v_m_per_s: f64| -> f64 {
        wheels
            .iter()
            .map(|(load_n, rolling)| 0.8 * load_n * (1.0 - (1.0 - v_m_per_s / rolling * 25.0 / 2.4).powi(3)))
            .sum()
    };
    let (mut low, mut high) = (0.0, 0.05);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if force_n(middle) < mass_kg * sideways_m_per_s2 { low = middle } else { high = middle }
    }
    let outward_m_per_s = -after.velocity[1];
    assert!((outward_m_per_s / low - 1.0).abs() < 0.01, "slides out at {outward_m_per_s} m/s, closed form {low} m/s");
    let outward_m = before.lateral_travel_m - after.lateral_travel_m;
    assert!((outward_m / (low * lap_s) - 1.0).abs() < 0.01, "{outward_m} m in a lap");
}

#[test]
fn travel_of_the_wheels_agrees_with_the_heading() {
    let mut world = nominal_world(&scene(serde_json::json!({})));
    for part in 0..10 {
        hold(&mut world, command(0.3 - 0.06 * f64::from(part), if part % 3 == 0 { -0.9 } else { 0.8 }), 1.7);
        let truth = world.truth();
        let turned_rad = (truth.wheel_travel_m[1] - truth.wheel_travel_m[0]) / 0.33;
        assert!((turned_rad - truth.pose.heading_rad).abs() < 1e-9, "{turned_rad} rad against {truth:?}");
    }
}

#[test]
fn travel_integrates_to_the_pose() {
    let mut world = nominal_world(&scene(serde_json::json!({})));
    let mut before = world.truth();
    let (mut x_m, mut y_m) = (before.pose.x_m, before.pose.y_m);
    for step in 0..6000 {
        let truth = world.step(command(0.4, 0.9 * (f64::from(step) * 0.002).sin()));
        let forward_m =
            0.5 * (0..2).map(|wheel| truth.wheel_travel_m[wheel] - before.wheel_travel_m[wheel]).sum::<f64>();
        let left_m = truth.lateral_travel_m - before.lateral_travel_m;
        let (sin, cos) = (0.5 * (truth.pose.heading_rad + before.pose.heading_rad)).sin_cos();
        x_m += cos * forward_m - sin * left_m;
        y_m += sin * forward_m + cos * left_m;
        before = truth;
    }
    let gap_m = (x_m - before.pose.x_m).hypot(y_m - before.pose.y_m);
    assert!(gap_m < 1e-6, "travel and pose part by {gap_m} m");
}

#[test]
fn a_larger_wheel_turns_the_robot_away_from_it() {
    let scene = scene(serde_json::json!({}));
    let mut drawn = nominal(&scene);
    drawn.base.wheel_radius_m[1] *= 1.002;
    let mut world = World::new(&scene, &drawn);
    gather_speed(&mut world, 0.5, 0.0);
    let before = world.truth();
    let after = hold(&mut world, command(0.5, 0.0), 8.0);
    let expected_rad = 0.002 * 0.5 * 8.0 / 0.33;
    let turned_rad = after.pose.heading_rad - before.pose.heading_rad;
    assert!((turned_rad / expected_rad - 1.0).abs() < 0.005, "turned {turned_rad} rad, expected {expected_rad} rad");
}

#[test]
fn the_same_world_twice_gives_the_same_bytes() {
    let scene = scene(
        serde_json::json!({ "event": [{ "kind": "push", "at_s": 1.0, "displacement_m": [0.0, 0.05], "lasts_s": 0.5 }] }),
    );
    let bytes = |seed: u64| {
        let mut world = World::new(&scene, &Drawn::draw(&scene, seed));
        (0..3000)
            .flat_map(|_| {
                let truth = world.step(command(0.4, 0.5));
                [truth.pose.x_m, truth.pose.heading_rad, truth.wheel_angle_rad[0], truth.lateral_travel_m]
                    .map(f64::to_bits)
            })
            .collect::<Vec<u64>>()
    };
    assert_eq!(bytes(3), bytes(3));
    assert_ne!(bytes(3), bytes(4));
}

#[test]
fn walls_keep_the_body_out_and_let_it_go() {
    for heading_deg in [0.0, 30.0, 90.0, 180.0] {
        let start = serde_json::json!({ "x_m": 0.7, "y_m": 0.7, "heading_deg": heading_deg, "tolerance_m": 0.0, "tolerance_deg": 0.0 });
        let room = serde_json::json!({ "width_m": 1.4, "depth_m": 1.4 });
        let mut world = nominal_world(&scene(serde_json::json!({ "start": start, "room": room })));
        let mut nearest_m = f64::INFINITY;
        for _ in 0..4000 {
            let pose = world.step(command(0.5, 0.0)).pose;
            nearest_m = nearest_m.min(pose.x_m).min(1.4 - pose.x_m).min(pose.y_m).min(1.4 - pose.y_m);
        }
        assert!((0.25..0.252).contains(&nearest_m), "heading {heading_deg}: came within {nearest_m} m of a wall");
        let blocked = world.truth();
        let freed = hold(&mut world, command(-0.3, 0.0), 1.0);
        let back_m = (freed.pose.x_m - blocked.pose.x_m).hypot(freed.pose.y_m - blocked.pose.y_m);
        assert!(back_m > 0.2, "heading {heading_deg}: held by the wall, {back_m} m");
    }
}

#[test]
fn light_and_heavy_robots_stand_and_drive() {
    for (mass_kg, body_radius_m, wheel_radius_m, track_m) in
        [(0.5, 0.05, 0.01, 0.08), (3.0, 0.17, 0.035, 0.23), (200.0, 0.6, 0.2, 0.9)]
    {
        let robot = serde_json::json!({
            "mass_kg": mass_kg, "body_radius_m": body_radius_m,
            "base": { "wheel_radius_m": wheel_radius_m, "track_m": track_m },
        });
        let mut world = nominal_world(&scene(serde_json::json!({ "robot": robot })));
        let stood = hold(&mut world, command(0.0, 0.0), 2.0);
        assert!((stood.pose.x_m - 1.5).hypot(stood.pose.y_m - 3.0) < 1e-9, "{mass_kg} kg: {stood:?}");
        for step in 0..800 {
            world.step(command(0.0005 * f64::from(step), 0.0));
        }
        let before = hold(&mut world, command(0.4, 0.0), 0.5);
        let after = hold(&mut world, command(0.4, 0.0), 2.0);
        let rolled_m = wheel_radius_m * (after.wheel_angle_rad[0] - before.wheel_angle_rad[0]);
        let ratio = (after.pose.x_m - before.pose.x_m) / rolled_m;
        assert!((rolled_m - 0.8).abs() < 1e-3 && (ratio - 1.0).abs() < 50e-6, "{mass_kg} kg: {ratio} of {rolled_m} m");
        assert!(after.tilt_rad.iter().all(|tilt| tilt.abs() < 1e-4), "{mass_kg} kg: {after:?}");
    }
}
