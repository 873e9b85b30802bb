//! Witnesses of runs whose images claim joints or edges: the truth with every error at a corner of its tolerance is accepted, and what is found lies in
//! the localizer's boxes.

use std::path::Path;

use sim::{
    campaign::sharpness::{N_INSTANTS, ReadingLog, Sharpness, measure},
    loading::SceneTemplate,
    render::Renderer,
    run::{RunOptions, run_witnessed},
    scene::Scene,
    subject::IntervalLocalizer,
};

fn sharpness(scene: &Scene, seed: u64) -> Sharpness {
    let mut renderer = Renderer::new().unwrap();
    let (mut log, mut subject) = (ReadingLog::default(), IntervalLocalizer::of(scene));
    let options = RunOptions::default();
    let record =
        run_witnessed(scene, seed, &mut subject, Some(&mut renderer), &options, &mut log, &mut |_| {}).unwrap();
    measure(scene, "scene", &record, &log, N_INSTANTS, &mut |_| {}).unwrap()
}

/// A drive over tiles with some keys set and with every error at an end of its tolerance.
fn over_tiles(keys: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/tiles.toml");
    let keys: Vec<_> = keys.iter().chain(&["robot.errors=corner"]).map(|key| key.parse().unwrap()).collect();
    SceneTemplate::load(&path).unwrap().with(&keys).unwrap().scene
}

/// Demands witnesses in the box along every axis, at all instants but a few, and a box no wider than `most` times their distance at the median instant.
pub(crate) fn demand_witnesses(found: &Sharpness, most: f64) {
    for instant in &found.instants {
        assert!(instant.in_box, "{instant:?}");
        let is_truth_refused = instant.broken.as_ref().is_some_and(|broken| broken.starts_with("the truth"));
        assert!(!is_truth_refused, "{instant:?}");
    }
    let n_found = found.instants.iter().filter(|instant| instant.has_pair()).count();
    assert!(n_found + 2 >= found.instants.len(), "{found:?}");
    for axis in 0..3 {
        let ratio = found.median(axis).unwrap();
        assert!((1.0..most).contains(&ratio), "axis {axis}: {ratio}");
    }
}

#[test]
fn witnesses_on_tiles_keep_the_bounds_of_a_careful_user() {
    demand_witnesses(&sharpness(&over_tiles(&["duration_s=2", "bounds_from=careful_user_throughout"]), 2), 3.0);
}

/// In the dark the flow sensor's one scale for both axes, and edges of walls of which some may be false, leave nearly as much open as the boxes say.
#[test]
fn witnesses_in_the_dark_use_most_of_what_flow_sensor_and_walls_leave_open() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/papers/dark_carpet.toml");
    let scene = SceneTemplate::load(&path).unwrap().with(&["duration_s=9".parse().unwrap()]).unwrap().scene;
    demand_witnesses(&sharpness(&scene, 2), 1.5);
}

/// Of the twenty images whose edges count together, the localizer holds those of the last three seconds alone. All wrong edges may be among these: boxes
/// that took a share of the edges held excluded witnesses of this drive.
#[test]
fn witnesses_with_wrong_edges_in_the_latest_images_are_in_the_box() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/dark/walls.toml");
    let scene = SceneTemplate::load(&path).unwrap().with(&["duration_s=9".parse().unwrap()]).unwrap().scene;
    demand_witnesses(&sharpness(&scene, 12), 1.5);
}

#[test]
fn what_makes_most_of_a_width_is_told_with_the_witnesses() {
    // Landmarks, wheels and a gyroscope relate key frames from the second second on.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/papers/rigid_transform_loop.toml");
    let scene = SceneTemplate::load(&path).unwrap().with(&["duration_s=9".parse().unwrap()]).unwrap().scene;
    let found = sharpness(&scene, 2);
    let told: Vec<_> = found.instants.iter().filter_map(|instant| instant.dominant[0].as_ref()).collect();
    let by_bounds: Vec<_> = told.iter().filter_map(|dominant| Some((dominant, dominant.bound?))).collect();
    assert!(2 * by_bounds.len() > found.instants.len(), "{found:?}");
    for (dominant, bound) in by_bounds {
        assert!(["wheels.", "range_camera.", "gyro."].iter().any(|of| bound.starts_with(of)), "{dominant:?}");
        // What is saved because both ends follow from different readings is less than half.
        assert!(dominant.part > 0.0 && dominant.part + dominant.boxes < 1.5 * dominant.width, "{dominant:?}");
    }
}
