//! Slip by floor region, friction events and pushes.

use sim::{truth::Truth, world::World};

use crate::world_setup::{command, hold, nominal, nominal_world, scene};

/// Share of the rolled distance that the left wheel does not travel, while the robot is commanded to start at full speed for a second.
fn slip_of_a_dash(world: &mut World) -> f64 {
    let before = world.truth();
    let after = hold(world, command(0.5, 0.0), 1.0);
    let rolled_m = 0.0975 * (after.wheel_angle_rad[0] - before.wheel_angle_rad[0]);
    1.0 - (after.wheel_travel_m[0] - before.wheel_travel_m[0]) / rolled_m
}

#[test]
fn a_slippery_region_makes_wheels_spin() {
    let region = serde_json::json!([{ "name": "wet", "x_m": [1.0, 2.5], "y_m": [2.0, 4.0], "friction": 0.05 }]);
    let wet = slip_of_a_dash(&mut nominal_world(&scene(serde_json::json!({ "floor": { "region": region } }))));
    let dry = slip_of_a_dash(&mut nominal_world(&scene(serde_json::json!({}))));
    assert!(wet > 0.1, "slip {wet} on the wet region");
    assert!(dry < 0.03, "slip {dry} on dry floor");
}

#[test]
fn a_wheel_spins_at_the_friction_limit() {
    let floor = serde_json::json!({ "friction": 0.05 });
    let mut world = nominal_world(&scene(serde_json::json!({ "floor": floor })));
    hold(&mut world, command(0.5, 0.0), 0.2);
    let before = world.truth();
    let after = hold(&mut world, command(0.5, 0.0), 0.3);
    // Coulomb friction: a = μ·g·(share of the weight on the driven wheels).
    let acceleration_m_per_s2 = (after.velocity[0] - before.velocity[0]) / 0.3;
    let expected_m_per_s2 = 0.05 * 9.80665 * 0.85;
    assert!((acceleration_m_per_s2 / expected_m_per_s2 - 1.0).abs() < 0.005, "{acceleration_m_per_s2} m/s²");
}

#[test]
fn a_friction_event_changes_the_slip_at_its_time() {
    let slip = |region: serde_json::Value, event: serde_json::Value| {
        let mut world = nominal_world(&scene(serde_json::json!({ "floor": { "region": region }, "event": [event] })));
        let early = slip_of_a_dash(&mut world);
        hold(&mut world, command(0.0, 0.0), 1.0);
        (early, slip_of_a_dash(&mut world))
    };
    let everywhere = serde_json::json!({ "kind": "friction", "at_s": 1.5, "friction": 0.05 });
    let (early, late) = slip(serde_json::json!([]), everywhere);
    assert!(early < 0.03 && late > 0.1, "slip {early}, then {late}");
    let mat = serde_json::json!([{ "name": "mat", "x_m": [1.0, 7.0], "y_m": [2.0, 4.0], "friction": 0.05 }]);
    let dried = serde_json::json!({ "kind": "friction", "at_s": 1.5, "region": "mat", "friction": 0.8 });
    let (early, late) = slip(mat, dried);
    assert!(early > 0.1 && late < 0.03, "slip {early}, then {late}");
}

#[test]
fn of_overlapping_regions_the_last_one_counts() {
    let region =
        |friction: f64| serde_json::json!({ "name": "", "x_m": [1.0, 7.0], "y_m": [2.0, 4.0], "friction": friction });
    let slip = |regions: [f64; 2]| {
        let floor = serde_json::json!({ "region": regions.map(region) });
        slip_of_a_dash(&mut nominal_world(&scene(serde_json::json!({ "floor": floor }))))
    };
    assert!(slip([0.05, 0.8]) < 0.03);
    assert!(slip([0.8, 0.05]) > 0.1);
}

/// Displacement of a pushed robot from where its wheels alone would have taken it, in the robot's frame at the start of the push, and the
/// greatest speed of that displacement.
fn pushed(displacement_m: [f64; 2], lasts_s: f64, motion: [f64; 2]) -> ([f64; 2], f64) {
    let push = serde_json::json!({ "kind": "push", "at_s": 1.0, "displacement_m": displacement_m, "lasts_s": lasts_s });
    let scene = scene(serde_json::json!({ "start": { "x_m": 3.0, "y_m": 3.0, "heading_deg": 25.0 }, "event": [push] }));
    let drawn = nominal(&scene);
    let mut world = World::new(&scene, &drawn);
    let mut before = hold(&mut world, command(motion[0], motion[1]), 1.0);
    let heading_rad = before.pose.heading_rad;
    let (mut wheels_alone, mut off_m, mut greatest_m_per_s) = (before.pose, [0.0; 2], 0.0_f64);
    for _ in 0..((lasts_s + 0.5) * 1000.0) as usize {
        let truth: Truth = world.step(command(motion[0], motion[1]));
        let tilt_deg = truth.tilt_rad[0].hypot(truth.tilt_rad[1]).to_degrees();
        assert!(truth.time_s > 1.0 + lasts_s || tilt_deg < 0.1, "the push tilts the robot: {truth:?}");
        let [left_m, right_m] =
            [0, 1].map(|wheel| 0.0975 * (truth.wheel_angle_rad[wheel] - before.wheel_angle_rad[wheel]));
        let turned_rad = (right_m - left_m) / 0.33;
        let (sin, cos) = (wheels_alone.heading_rad + 0.5 * turned_rad).sin_cos();
        wheels_alone.x_m += 0.5 * (left_m + right_m) * cos;
        wheels_alone.y_m += 0.5 * (left_m + right_m) * sin;
        wheels_alone.heading_rad += turned_rad;
        let (x_m, y_m) = (truth.pose.x_m - wheels_alone.x_m, truth.pose.y_m - wheels_alone.y_m);
        let (sin, cos) = heading_rad.sin_cos();
        let now_m = [cos * x_m + sin * y_m, cos * y_m - sin * x_m];
        greatest_m_per_s = greatest_m_per_s.max((now_m[0] - off_m[0]).hypot(now_m[1] - off_m[1]) / 0.001);
        off_m = now_m;
        before = truth;
    }
    assert!((before.pose.heading_rad - wheels_alone.heading_rad).abs() < 0.01, "the push turned the robot");
    (off_m, greatest_m_per_s)
}

#[test]
fn a_push_displaces_by_the_stated_amount_while_the_wheels_go_on() {
    for (displacement_m, lasts_s) in [([0.0, 0.04], 0.2), ([0.0, -0.25], 1.0), ([0.25, 0.0], 0.5), ([-0.03, 0.04], 0.3)]
    {
        for motion in [[0.0, 0.0], [0.4, 0.0], [0.3, 0.6], [0.0, 0.8]] {
            let (off_m, greatest_m_per_s) = pushed(displacement_m, lasts_s, motion);
            let size_m = displacement_m[0].hypot(displacement_m[1]);
            let error_m = (off_m[0] - displacement_m[0]).hypot(off_m[1] - displacement_m[1]);
            assert!(error_m < 0.02 * size_m, "push {displacement_m:?} at {motion:?} displaced by {off_m:?}");
            assert!(
                greatest_m_per_s < 1.3 * size_m / lasts_s,
                "push {displacement_m:?} at {motion:?}: {greatest_m_per_s} m/s"
            );
        }
    }
}

#[test]
fn a_push_into_a_wall_ends_at_the_wall() {
    let push = serde_json::json!({ "kind": "push", "at_s": 0.1, "displacement_m": [0.0, 1.0], "lasts_s": 0.5 });
    let start = serde_json::json!({ "x_m": 3.0, "y_m": 5.5, "tolerance_m": 0.0, "tolerance_deg": 0.0 });
    let mut world = nominal_world(&scene(serde_json::json!({ "start": start, "event": [push] })));
    for _ in 0..1000 {
        let y_m = world.step(command(0.0, 0.0)).pose.y_m;
        assert!(y_m < 5.75, "pushed into the wall: y = {y_m} m");
    }
    assert!(world.truth().pose.y_m > 5.7, "{:?}", world.truth().pose);
}
