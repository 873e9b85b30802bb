//! The car as a base: its motion against closed forms, its rear wheels as the localizer reads them, its driver, and drives that are refused.

use std::f64::consts::TAU;

use localizer::{
    PoseBox,
    motion::{WheelHistory, moved},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use sim::{
    driver::Driver,
    scene::{Scene, SceneError},
    truth::Truth,
    world::{Drawn, World},
};

use crate::world_setup::{command, drive, estimate, gather_speed, hold, nominal_world, scene};

const WHEELBASE_M: f64 = 0.5;

/// A car of 10 kg with a wheelbase of 0.5 m, tracks of 0.4 m, half of its weight on the front wheels and its centre of mass 0.275 m above the floor.
/// Its smallest circle has a radius of 0.866 m.
fn car(more: Value) -> Scene {
    let mut keys = json!({
        "room": { "width_m": 40.0, "depth_m": 40.0 },
        "start": { "x_m": 20.0, "y_m": 20.0, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
        "robot": { "mass_kg": 10.0, "body_radius_m": 0.55,
                   "base": { "kind": "ackermann", "wheel_radius_m": 0.1, "track_m": 0.4 } },
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        keys[key] = value.clone();
    }
    scene(keys)
}

/// Distance that the middle of the rear axle has gone between two instants of a circle, over the angle by which the robot has turned.
fn radius_m(before: &Truth, after: &Truth) -> f64 {
    let gone_m = |truth: &Truth| 0.5 * (truth.wheel_travel_m[0] + truth.wheel_travel_m[1]);
    (gone_m(after) - gone_m(before)) / (after.pose.heading_rad - before.pose.heading_rad)
}

#[test]
fn a_car_at_rest_stays_at_rest_however_it_steers() {
    for turn_rad_per_s in [0.0, 1.0, -1.0] {
        let scene = car(json!({}));
        let mut world = nominal_world(&scene);
        let truth = hold(&mut world, command(0.0, turn_rad_per_s), 10.0);
        let drift_m = (truth.pose.x_m - 20.0).hypot(truth.pose.y_m - 20.0);
        assert!(drift_m < 1e-7, "drifted {drift_m} m in 10 s");
        assert!(truth.pose.heading_rad.abs() < 1e-7, "turned to {}", truth.pose.heading_rad);
        assert!(truth.tilt_rad.iter().all(|tilt_rad| tilt_rad.abs() < 1e-9) && truth.heave_m.abs() < 1e-9, "{truth:?}");
    }
}

#[test]
fn slow_circles_have_the_radius_of_the_steering_geometry() {
    for (steering_rad, side) in [(0.1_f64, 1.0), (0.3, 1.0), (0.5, -1.0)] {
        for direction in [1.0, -1.0] {
            let wanted_m = side * WHEELBASE_M / steering_rad.tan();
            let mut world = nominal_world(&car(json!({})));
            let motion = command(direction * 0.1, direction * 0.1 / wanted_m);
            let before = hold(&mut world, motion, 3.0);
            let after = hold(&mut world, motion, 10.0);
            let circle_m = radius_m(&before, &after);
            assert!((circle_m / wanted_m - 1.0).abs() < 0.01, "radius {circle_m} m, expected {wanted_m} m");
        }
    }
}

#[test]
fn a_command_beyond_the_greatest_steering_angle_drives_the_smallest_circle() {
    let mut world = nominal_world(&car(json!({})));
    let before = hold(&mut world, command(0.1, 1.0), 3.0);
    let after = hold(&mut world, command(0.1, 1.0), 10.0);
    let (circle_m, least_m) = (radius_m(&before, &after), WHEELBASE_M / 30.0_f64.to_radians().tan());
    assert!((circle_m / least_m - 1.0).abs() < 0.01, "radius {circle_m} m, expected {least_m} m");
}

/// At 0.5 m/s on a circle of 1 m the centre of mass, 0.25 m before the rear axle, is accelerated by 0.25 m/s² to the left. By the moment about the
/// rear axle the front wheels give half of that force in their sideways part, `F·cos δ = m·a/2`, and the rear wheels the other half.
#[test]
fn wheels_on_a_circle_have_the_slip_angles_of_the_brush() {
    let mut world = nominal_world(&car(json!({})));
    gather_speed(&mut world, 0.5, 0.5);
    let truth = hold(&mut world, command(0.5, 0.5), 5.0);
    let [forward_m_per_s, left_m_per_s, turn_rad_per_s] = truth.velocity;
    // To first order of the brush, F = Cσ(1 − s) with s = Cσ/(3μ), both over the load.
    let slip_of = |force_over_load: f64| force_over_load / 25.0 * (1.0 + force_over_load / (3.0 * 0.8));
    // The motors of the rear wheels, which hold their speeds, bear a little of the moment, so that the shares of the axles are not quite equal.
    let axle_load = 0.5 * 9.80665;
    let rear = -left_m_per_s / forward_m_per_s;
    let rear_expected = slip_of(0.5 * 0.25 / axle_load);
    assert!((rear / rear_expected - 1.0).abs() < 0.15, "rear slip {rear}, expected {rear_expected}");

    let steering_rad = 0.5_f64.atan();
    let front: f64 = [(0.2_f64, 0.5_f64 / 0.8), (-0.2, 0.5 / 1.2)]
        .map(|(left_m, tangent)| {
            let rolling = forward_m_per_s - turn_rad_per_s * left_m;
            let aside = left_m_per_s + turn_rad_per_s * WHEELBASE_M;
            0.5 * (tangent.atan() - aside.atan2(rolling)).tan()
        })
        .iter()
        .sum();
    let front_expected = slip_of(0.5 * 0.25 / steering_rad.cos() / axle_load);
    assert!((front / front_expected - 1.0).abs() < 0.15, "front slip {front}, expected {front_expected}");
    // Together the axles give the whole force, whatever the share of each.
    let force_of = |slip: f64| 25.0 * axle_load * slip * (1.0 - 25.0 * slip / (3.0 * 0.8));
    let whole = force_of(rear) + force_of(front) * steering_rad.cos();
    assert!((whole / 0.25 - 1.0).abs() < 0.05, "{whole} N per kg sideways, expected 0.25");
}

#[test]
fn gathering_speed_and_braking_straight_follow_the_command_and_slip_as_the_brush_says() {
    let mut world = nominal_world(&car(json!({})));
    let ramp = |world: &mut World, from: usize, to: usize| {
        for step in from..to {
            world.step(command(0.4 * step as f64 / 1000.0, 0.0));
        }
        world.truth()
    };
    let (before, after) = (ramp(&mut world, 0, 1000), ramp(&mut world, 1000, 1100));
    // The motor follows with a lag of 20 ms, in which the command gets on by 0.008 m/s.
    assert!((after.velocity[0] - (0.44 - 0.008)).abs() < 0.004, "speed {}", after.velocity[0]);
    let rolled_m = 0.1 * (after.wheel_angle_rad[0] - before.wheel_angle_rad[0]);
    let slip = 1.0 - (after.wheel_travel_m[0] - before.wheel_travel_m[0]) / rolled_m;
    // The rear wheels push the car and turn the front wheels, each 2 % of its mass. They bear half of the weight, and more by m·a·h/L.
    let needed = 0.4 * 1.04 / (9.80665 * 0.5 + 0.4 * 0.275 / WHEELBASE_M);
    let expected = needed / 25.0 * (1.0 + needed / (3.0 * 0.8));
    assert!((slip / expected - 1.0).abs() < 0.03, "slip {slip}, expected {expected}");

    for step in 0..1100 {
        world.step(command(0.44 * (1.0 - step as f64 / 1100.0), 0.0));
    }
    let end = hold(&mut world, command(0.0, 0.0), 1.0);
    assert!(end.velocity.iter().all(|rate| rate.abs() < 1e-4), "{:?}", end.velocity);
    // 0.4 m/s² up to 0.44 m/s and down again takes 2.2 s at 0.22 m/s on average.
    assert!((end.pose.x_m - 20.0 - 0.484).abs() < 0.005 && (end.pose.y_m - 20.0).abs() < 1e-6, "{:?}", end.pose);
}

#[test]
fn the_energy_of_a_car_that_comes_to_rest_does_not_grow() {
    let mut world = nominal_world(&car(json!({})));
    gather_speed(&mut world, 0.5, 0.4);
    let energy = |truth: &Truth| {
        let [forward, left, turn] = truth.velocity;
        // The centre of mass is 0.25 m before the axle, and the body is a cylinder of radius 0.55 m.
        0.5 * (forward * forward + (left + 0.25 * turn).powi(2)) + 0.5 * (0.5 * 0.55 * 0.55) * turn * turn
    };
    let whole = energy(&hold(&mut world, command(0.5, 0.4), 1.0));
    // Less than a fiftieth comes back when the tyres' bristles, bent by the braking, spring back.
    let mut least = whole;
    for _ in 0..100 {
        let now = energy(&hold(&mut world, command(0.0, 0.0), 0.01));
        assert!(now < least + 0.02 * whole, "{now} after {least} of {whole}");
        least = least.min(now);
    }
    assert!(least < 1e-4 * whole, "{least} of {whole}");
}

/// Twenty random drives of 10 s, forwards and backwards, with steering to the limits on either side.
#[test]
fn rear_wheels_alone_enclose_the_motion_of_a_car() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut sharpest_rad_per_s = 0.0_f64;
    for seed in 0..20 {
        let scene = car(json!({}));
        let mut world = World::new(&scene, &Drawn::draw(&scene, seed));
        let model = scene.robot_model();
        let ticks_per_turn = f64::from(scene.robot.encoders.ticks_per_turn);
        let (mut history, mut poses) = (WheelHistory::new(20.0), Vec::new());
        let (mut speed_m_per_s, mut wanted_m_per_s, mut turn_rad_per_s) = (0.0_f64, 0.0_f64, 0.0);
        for reading in 0..1000 {
            let truth = world.truth();
            let ticks = truth.wheel_angle_rad.map(|angle_rad| (angle_rad / TAU * ticks_per_turn).floor() as i64);
            history.push(f64::from(reading) * 0.01, ticks);
            poses.push([truth.pose.x_m, truth.pose.y_m, truth.pose.heading_rad]);
            sharpest_rad_per_s = sharpest_rad_per_s.max(truth.velocity[2].abs());
            if reading % 150 == 0 {
                wanted_m_per_s = rng.random_range(-0.5..0.5);
            }
            if reading % 100 == 0 {
                turn_rad_per_s = [-2.0, 2.0, rng.random_range(-0.5..0.5)][rng.random_range(0..3)];
            }
            speed_m_per_s += (wanted_m_per_s - speed_m_per_s).clamp(-0.003, 0.003);
            hold(&mut world, command(speed_m_per_s, turn_rad_per_s), 0.01);
        }
        for from in (0..990).step_by(90) {
            for to in [from + 1, from + 10, (from + 100).min(999), 999] {
                let stamps_s = [from, to].map(|reading| reading as f64 * 0.01);
                let motion =
                    history.motion(stamps_s[0], stamps_s[1], &model.wheels, &model.reach).expect("in the history");
                let start = PoseBox::from(poses[from].map(|value| interval::Interval::centred(value, 1e-9)));
                let reached = moved(&start, &motion);
                assert!(
                    reached.contains(&poses[to]),
                    "{seed}: from {from} to {to}: {reached:?} misses {:?}",
                    poses[to]
                );
            }
        }
    }
    assert!(sharpest_rad_per_s > 0.4, "the drives turned by {sharpest_rad_per_s} rad/s at most");
}

#[test]
fn a_driver_never_asks_a_car_for_less_than_its_turning_circle_and_passes_the_waypoints() {
    let waypoints_m = [[25.0, 20.0], [25.0, 24.0], [20.0, 25.0], [17.0, 22.0]];
    let listed = waypoints_m.map(|[x_m, y_m]| json!({ "x_m": x_m, "y_m": y_m, "speed_m_per_s": 0.5 }));
    let scene = car(json!({ "route": { "waypoint": listed } }));
    let drawn = crate::world_setup::nominal(&scene);
    let (mut world, mut driver) = (World::new(&scene, &drawn), Driver::new(&scene));
    let least_m = WHEELBASE_M / 30.0_f64.to_radians().tan();
    let mut nearest_m = [f64::INFINITY; 4];
    let (mut before, mut most_aside) = (world.truth(), 0.0_f64);
    for step in 0..6000 {
        let asked = driver.command(&estimate(&world.truth()), f64::from(step) * 0.01);
        assert!(asked.turn_rad_per_s.abs() * least_m <= asked.speed_m_per_s.abs() + 1e-12, "{asked:?}");
        let truth = hold(&mut world, asked, 0.01);
        if step % 20 == 19 {
            let rolled_m = 0.05
                * [0, 1].map(|side| truth.wheel_angle_rad[side] - before.wheel_angle_rad[side]).iter().sum::<f64>();
            let bound_m = scene.bounds.side_slip_ratio * rolled_m.abs() + scene.bounds.side_slip_floor_m;
            most_aside = most_aside.max((truth.lateral_travel_m - before.lateral_travel_m).abs() / bound_m);
            before = truth;
        }
        for (nearest_m, [x_m, y_m]) in nearest_m.iter_mut().zip(waypoints_m) {
            *nearest_m = nearest_m.min((truth.pose.x_m - x_m).hypot(truth.pose.y_m - y_m));
        }
    }
    assert!(most_aside < 1.0, "side slip reaches {most_aside} of its declared bound");
    // In a curve of radius R a corner of 90° is passed at 0.41·R.
    assert!(nearest_m.iter().all(|near_m| *near_m < 0.5), "{nearest_m:?}");
    assert!(nearest_m[3] < 0.05 && world.truth().velocity[0].abs() < 1e-6, "{nearest_m:?}");
}

/// Waypoints close by, beside and behind the car: it comes to rest, whether it reaches them or gives them up.
#[test]
fn a_car_never_circles_for_ever() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..12 {
        let listed: Vec<Value> = (0..3)
            .map(|_| {
                let [x_m, y_m] = [0, 1].map(|_| 20.0 + rng.random_range(-1.2..1.2));
                json!({ "x_m": x_m, "y_m": y_m, "pause_s": 0.1 })
            })
            .collect();
        let scene = car(json!({ "route": { "waypoint": listed } }));
        let end = drive(&scene, &crate::world_setup::nominal(&scene), 150.0).pop().expect("a state");
        assert!(end.velocity.iter().all(|rate| rate.abs() < 1e-6), "still moving: {:?}", end.velocity);
    }
}

#[test]
fn a_push_and_a_lift_put_a_car_where_the_hand_means_to() {
    for kind in ["push", "lift"] {
        let event = json!({ "kind": kind, "at_s": 1.0, "displacement_m": [0.1, 0.2], "lasts_s": 1.0 });
        let mut world = nominal_world(&car(json!({ "event": [event] })));
        let end = hold(&mut world, command(0.0, 0.0), 4.0);
        let off_m = (end.pose.x_m - 20.1).hypot(end.pose.y_m - 20.2);
        assert!(off_m < 0.005 && end.pose.heading_rad.abs() < 0.01, "{kind}: {:?}", end.pose);
    }
}

/// The route of the scene of [`refusal`].
const ROUTE: &str = r#"[route]
waypoint = [
    { x_m = 9.0, y_m = 2.0 },
    { x_m = 9.0, y_m = 6.0 },
    { x_m = 2.0, y_m = 6.0 },
]
"#;

/// Key, value and expectation of the first problem of a car's scene in which `from` is replaced by `to`.
fn refusal(from: &str, to: &str) -> String {
    let text = r#"
duration_s = 10.0
[room]
width_m = 12.0
depth_m = 8.0
[floor]
[start]
x_m = 2.0
y_m = 2.0
[robot]
body_radius_m = 0.55
[robot.base]
kind = "ackermann"
track_m = 0.4
"#;
    let text = [text, ROUTE].concat();
    assert!(text.contains(from));
    match Scene::parse(&text.replace(from, to), "car.toml") {
        Err(error @ SceneError::Invalid { .. }) => error.to_string(),
        other => panic!("{from} to {to}: {other:?}"),
    }
}

#[test]
fn drives_that_a_car_cannot_do_are_refused_with_file_key_value_and_expectation() {
    let corner = "{ x_m = 9.0, y_m = 6.0 }";
    for (from, to, said) in [
        (
            corner,
            "{ x_m = 9.0, y_m = 6.0, turn_in_place = true }",
            ["waypoint[1].turn_in_place", "true", "expected false"],
        ),
        (corner, "{ x_m = 9.0, y_m = 3.0 }", ["waypoint[1].x_m", "9.0", "expected longer legs"]),
        (corner, "{ x_m = 3.0, y_m = 2.2 }", ["waypoint[0].x_m", "9.0", "expected 115°"]),
        ("{ x_m = 9.0, y_m = 2.0 }", "{ x_m = 2.2, y_m = 2.6 }", ["waypoint[0].x_m", "2.2", "ahead of the start"]),
        ("y_m = 2.0\n[robot]", "y_m = 2.0\nheading_deg = 180\n[robot]", ["waypoint[0].x_m", "9.0", "faces away"]),
        ("y_m = 2.0\n[robot]", "y_m = 2.0\nanywhere = true\n[robot]", ["start.anywhere", "true", "expected false"]),
        ("body_radius_m = 0.55", "body_radius_m = 0.5", ["robot.body_radius_m", "0.5", "expected that or more"]),
        (
            "[route]",
            "[robot.base.ackermann]\nmax_steering_deg = 60\nwheelbase_m = 0.3\n[route]",
            ["max_steering_deg", "60", "expected a smaller angle"],
        ),
        (
            ROUTE,
            "[navigation]\nfollower = \"turn_then_drive\"\n[[errand]]\nx_m = 5.0\ny_m = 2.0\n",
            ["navigation.follower", "turn_then_drive", "expected \"pure_pursuit\""],
        ),
        // A wall leaves 1.2 m, which the body takes with its margins.
        (
            ROUTE,
            "[[furniture]]\nx_m = 6.0\ny_m = 3.4\nsize_m = [0.1, 6.8]\n[[errand]]\nx_m = 9.0\ny_m = 2.0\n",
            ["errand[0].x_m", "9.0", "expected one with 0.63 m to either side"],
        ),
    ] {
        let message = refusal(from, to);
        let all = ["car.toml"].into_iter().chain(said);
        all.for_each(|part| assert!(message.contains(part), "{part:?} missing in: {message}"));
    }
}
