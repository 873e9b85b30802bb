//! Scenes that once broke motion, its sensors and landmarks: each is run as it is, in a thread that may be given up.

use std::{sync::mpsc, thread, time::Duration};

use sim::{
    judge::Verdict,
    render::Renderer,
    run::{RunOptions, run},
    scene::SceneFile,
    subject::IntervalLocalizer,
};

use crate::{command::root, judging::verdict_of};

/// A run that takes longer than this on any machine never ends: the slowest takes seconds.
const PATIENCE: Duration = Duration::from_secs(400);

/// The verdict of a scene of scenes/found, and what it missed of what it expects.
fn verdict(name: &'static str, seed: u64) -> (Verdict, Vec<String>) {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let path = root().join("scenes/found").join(format!("{name}.toml"));
        let scene = SceneFile::load_all(&[path]).unwrap().remove(0).scene;
        let mut renderer = scene.has_camera().then(|| Renderer::new().unwrap());
        let record = run(
            &scene,
            seed,
            &mut IntervalLocalizer::of(&scene),
            renderer.as_mut(),
            &RunOptions::default(),
            &mut |_| {},
        )
        .unwrap();
        let verdict = verdict_of(&scene, &record);
        let missed = scene.expect.evaluate(&serde_json::to_value(&verdict).unwrap());
        let _ = sender.send((verdict, missed));
    });
    receiver.recv_timeout(PATIENCE).unwrap_or_else(|cause| panic!("{name}, seed {seed}: {cause}"))
}

fn assert_met(name: &'static str, seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let (verdict, missed) = verdict(name, seed);
        assert!(missed.is_empty(), "seed {seed}: {missed:?}, {:?}", verdict.violations);
    }
}

#[test]
fn a_scale_of_the_flow_sensor_that_changes_in_turns_keeps_the_truth() {
    assert_met("flow_scale_in_turns", 0..4);
}

#[test]
fn bisection_of_a_heading_without_bounds_ends() {
    assert_met("heading_without_bounds", 20..21);
}

#[test]
fn range_readings_that_overtake_one_another_keep_the_truth() {
    assert_met("range_readings_out_of_order", 0..4);
    assert_met("wrong_codes_out_of_order", 0..4);
}

#[test]
fn codes_that_may_be_wrong_at_any_time_teach_nothing_false() {
    assert_met("wrong_codes_at_any_time", 86..87);
}

#[test]
fn a_robot_lifted_over_tiles_is_looked_for_at_any_heading() {
    assert_met("lifted_over_tiles", 0..2);
    assert_met("slipping_over_narrow_tiles", 90..91);
}

#[test]
fn a_route_of_one_place_ends_there() {
    assert_met("route_of_one_place", 0..1);
}

#[test]
fn a_bias_that_wanders_keeps_the_bound_of_the_angle() {
    assert_met("gyro_bias_beyond_its_angle", 0..2);
}
