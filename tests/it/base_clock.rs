//! Tests of a mobile base whose clock has an unknown offset: its stamps, the estimates for true instants, and whole runs.

use localizer::{Localizer, Reading};
use sim::{
    loading::SceneTemplate,
    run::{RunOptions, run},
    scene::Scene,
    subject::IntervalLocalizer,
};

use crate::judging::verdict_of;
use crate::{command::root, world_setup::scene};

const STAMP_ERROR_S: f64 = 0.02;

/// A robot whose wheel readings give its motion exactly, on a mobile base whose stamps are off by up to `stamp_error_s`.
fn robot(stamp_error_s: f64) -> Scene {
    let robot = serde_json::json!({
        "floor_camera": false, "base": { "wheel_radius_tolerance": 0.0, "track_tolerance": 0.0 },
        "delivery": { "stamp_tolerance_s": stamp_error_s }, "encoders": { "ticks_per_turn": 1_000_000 },
    });
    let bounds = serde_json::json!({
        "slip_ratio": 0.0, "slip_floor_m": 1e-6, "side_slip_ratio": 0.0, "side_slip_floor_m": 1e-6,
    });
    scene(serde_json::json!({ "robot": robot, "bounds": bounds, "localizer": { "methods": [] } }))
}

/// Distance travelled by a robot that accelerates from rest at 0.5 m/s² for a second, straight ahead, and then keeps its speed.
fn path_m(time_s: f64) -> f64 {
    let gathering_s = time_s.clamp(0.0, 1.0);
    0.25 * gathering_s * gathering_s + 0.5 * (time_s - gathering_s).max(0.0)
}

/// Greatest amount by which the true x lies outside of the estimated boxes during three seconds. The time stamps of the wheels are late by `late_s`,
/// and the localizer is given `told_s` as the bound on that error.
fn outside_m(late_s: f64, told_s: f64) -> f64 {
    let scene = robot(told_s);
    let (map, start) = (scene.map(), scene.start_box());
    let mut localizer = Localizer::new(map, scene.robot_model(), Vec::new(), start).with_base_clock(told_s);
    let mut outside_m = 0.0_f64;
    for step in -10..300 {
        let taken_s = f64::from(step) * 0.01;
        let measured_s = taken_s + late_s;
        if measured_s >= -0.015 {
            let ticks = (path_m(taken_s) / 0.0975 / std::f64::consts::TAU * 1e6) as i64;
            localizer.observe(&Reading::Wheels { measured_s, arrived_s: taken_s + STAMP_ERROR_S, ticks: [ticks; 2] });
        }
        let now_s = taken_s + STAMP_ERROR_S;
        if now_s > 0.0 {
            let x = localizer.estimate_at(now_s).pose.hull()[0];
            let true_m = 1.5 + path_m(now_s);
            outside_m = outside_m.max(x.lo() - true_m).max(true_m - x.hi());
        }
    }
    outside_m
}

#[test]
fn answers_hold_the_truth_while_the_clock_is_off_within_its_bound() {
    for late_s in [-STAMP_ERROR_S, -0.007, 0.0, 0.013, STAMP_ERROR_S] {
        assert!(
            outside_m(late_s, STAMP_ERROR_S) == 0.0,
            "{late_s} s late: outside by {}",
            outside_m(late_s, STAMP_ERROR_S)
        );
    }
}

#[test]
fn a_clock_that_is_late_shows_where_it_is_told_to_be_exact() {
    // At 0.5 m/s, a position that is 20 ms old is 10 mm behind.
    let off_m = outside_m(STAMP_ERROR_S, 0.0);
    assert!((off_m - 0.01).abs() < 0.002, "{off_m}");
}

#[test]
fn a_clock_that_is_off_is_paid_once_and_not_at_each_slot() {
    let width_m = |stamp_error_s: f64| {
        let scene = robot(stamp_error_s);
        let mut localizer = Localizer::new(scene.map(), scene.robot_model(), Vec::new(), scene.start_box())
            .with_base_clock(stamp_error_s);
        for step in 0..500 {
            let time_s = f64::from(step) * 0.01;
            localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [0; 2] });
        }
        localizer.estimate().pose.hull()[0].width()
    };
    // In these five seconds the localizer stores about ten poses. The clock's offset must nevertheless widen the box only once: by 0.7 m/s, the
    // greatest declared speed, times 20 ms, which is 14 mm to either side.
    let paid_m = width_m(STAMP_ERROR_S) - width_m(0.0);
    assert!((paid_m - 0.028).abs() < 0.003, "{paid_m}");
}

#[test]
fn a_loop_among_landmarks_holds_the_truth_with_a_clock_that_is_off() {
    for (errors, seed) in [("corner", 3), ("corner", 4), ("drift", 5)] {
        let settings = ["robot.delivery.stamp_tolerance_s=0.01", "duration_s=12", &format!("robot.errors={errors}")]
            .map(|setting| setting.parse().unwrap());
        let template = SceneTemplate::load(&root().join("scenes/papers/rigid_transform_loop.toml")).unwrap();
        let scene = template.with(&settings).unwrap().scene;
        let record =
            run(&scene, seed, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
        assert!(record.drawn.base.clock_s.abs() == 0.01);
        let verdict = verdict_of(&scene, &record);
        assert_eq!(
            verdict.containment.as_ref().unwrap().contained,
            verdict.containment.as_ref().unwrap().checks,
            "{:?}",
            verdict.containment
        );
        assert!(verdict.violations.is_empty(), "{:?}", verdict.violations);
    }
}
