//! Scenes that once made motion, its sensors or landmarks fail: each is run unchanged, in a thread that is abandoned if the run does not end.

use std::{sync::mpsc, thread, time::Duration};

use sim::{
    judge::Verdict,
    loading::SceneFile,
    render::Renderer,
    run::{RunOptions, run},
    scene::Scene,
    subject::IntervalLocalizer,
};

use crate::{command::root, judging::verdict_of};

/// Time limit after which a simulated run counts as one that never ends, on any machine: the slowest run takes seconds.
const PATIENCE: Duration = Duration::from_secs(400);

/// A scene of the repository.
fn scene(path: &str) -> Scene {
    SceneFile::load_all(&[root().join("scenes").join(path)]).unwrap().remove(0).scene
}

/// The verdict of a run that is abandoned if it does not end.
fn verdict(scene: Scene, seed: u64) -> Verdict {
    let (sender, receiver) = mpsc::channel();
    let told = scene.description.clone();
    thread::spawn(move || {
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
        let _ = sender.send(verdict_of(&scene, &record));
    });
    receiver.recv_timeout(PATIENCE).unwrap_or_else(|cause| panic!("{told}, seed {seed}: {cause}"))
}

fn assert_met(name: &str, seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let verdict = verdict(scene(&format!("found/{name}.toml")), seed);
        let missed = &verdict.verdict.failed;
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

#[test]
fn a_loop_by_landmarks_with_readings_late_by_up_to_a_third_of_a_second_ends_and_holds_the_truth() {
    let mut scene = scene("papers/rigid_transform_loop.toml");
    scene.robot.delivery.late_s = 0.3;
    let containment = verdict(scene, 1).containment.unwrap();
    assert_eq!(containment.contained, containment.checks, "{containment:?}");
}

#[test]
fn wrong_codes_a_second_late_past_a_column_and_a_person_keep_the_truth() {
    let mut scene = scene("found/wrong_codes_out_of_order.toml");
    scene.duration_s = 30.0;
    scene.route.as_mut().unwrap().waypoints.iter_mut().for_each(|waypoint| waypoint.speed_m_per_s = 0.2);
    let more = "furniture = [{ name = 'column', x_m = 2.0, y_m = 2.0, size_m = [0.3, 0.3], height_m = 2.5 }]
                person = [{ waypoints_m = [[2.9, 1.75], [2.9, 2.25]], speed_m_per_s = 0.4 }]
                landmark = [{ x_m = 1.84, y_m = 2.0, height_m = 0.45 }, { x_m = 2.16, y_m = 2.0, height_m = 0.4 },
                            { x_m = 2.0, y_m = 1.84, height_m = 0.5 }, { x_m = 2.0, y_m = 2.16, height_m = 0.4 }]";
    let mut more: toml::Table = more.parse().unwrap();
    scene.furniture = more.remove("furniture").unwrap().try_into().unwrap();
    scene.people = more.remove("person").unwrap().try_into().unwrap();
    scene.landmarks.extend(more.remove("landmark").unwrap().try_into::<Vec<_>>().unwrap());
    for seed in [4, 5] {
        let verdict = verdict(scene.clone(), seed);
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!(containment.contained, containment.checks, "seed {seed}: {containment:?}");
        assert_eq!(verdict.metrics["landmarks_outside"], 0.0, "seed {seed}");
    }
}

#[test]
fn markers_and_late_stamped_landmarks_together_leave_no_stale_box() {
    assert_met("markers_beside_landmarks_stamped_late", 63..64);
}

#[test]
fn three_landmarks_on_ice_with_a_third_of_the_readings_lost_are_worked_out_in_time() {
    assert_met("three_landmarks_on_ice", 94..95);
}
