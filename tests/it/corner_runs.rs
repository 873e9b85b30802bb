use localizer::{Interval, PoseBox};
use sim::{
    render::Renderer,
    run::{RunOptions, RunRecord, run},
    scene::{Distribution, Scene, SceneFile},
};

use crate::{command::root, judging::verdict_of};

/// A scene of the repository, cut to `duration_s`, with every error as far as its bound lets it.
fn scene(path: &str, duration_s: f64, errors: Distribution) -> Scene {
    let mut scene = SceneFile::load_all(&[root().join("scenes").join(path)]).unwrap().remove(0).scene;
    scene.duration_s = duration_s;
    scene.robot.errors = errors;
    scene
}

fn contained(path: &str, duration_s: f64, errors: Distribution, seed: u64) -> RunRecord {
    let scene = scene(path, duration_s, errors);
    let mut renderer = scene.has_camera().then(|| Renderer::new().unwrap());
    let record = run(&scene, seed, renderer.as_mut(), &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of(&scene, &record);
    assert_eq!(verdict.containment.contained, verdict.containment.checks, "{path} {errors:?} {seed}");
    assert!(verdict.violations.is_empty(), "{path} {errors:?} {seed}: {:?}", verdict.violations);
    record
}

/// What a fault would leave that makes boxes 45 % too small about their middle, along some axes.
fn too_small(pose: &PoseBox, axes: &[usize]) -> PoseBox {
    PoseBox::from([0, 1, 2].map(|axis| match pose[axis] {
        side if axes.contains(&axis) => Interval::centred(side.mid(), 0.55 * 0.5 * side.width()),
        side => side,
    }))
}

/// Whether some box after the first second, so small along these axes, would no longer hold the truth.
fn would_lose(record: &RunRecord, axes: &[usize]) -> bool {
    record.truths.iter().zip(&record.estimates).skip(100).any(|(truth, estimate)| {
        let pose = truth.pose.to_array();
        !estimate.pose.branches.iter().any(|branch| too_small(branch, axes).contains(&pose))
    })
}

#[test]
fn with_tiles_at_their_corners_a_place_45_percent_too_narrow_loses_the_truth() {
    let records: Vec<RunRecord> =
        (0..3).map(|seed| contained("tiles.toml", 15.0, Distribution::Corner, seed)).collect();
    for axes in [&[0, 1, 2][..], &[0], &[1]] {
        assert!(records.iter().any(|record| would_lose(record, axes)), "axes {axes:?}");
    }
}

#[test]
fn with_landmarks_in_a_drift_a_heading_45_percent_too_narrow_loses_the_truth() {
    let record = contained("papers/rigid_transform_loop.toml", 40.0, Distribution::Drift, 0);
    assert!(would_lose(&record, &[2]) && would_lose(&record, &[0, 1, 2]));
}

#[test]
fn with_walls_in_a_drift_a_heading_45_percent_too_narrow_loses_the_truth() {
    let record = contained("dark/walls.toml", 15.0, Distribution::Drift, 0);
    assert!(would_lose(&record, &[2]) && would_lose(&record, &[0, 1, 2]));
}

#[test]
fn with_markers_at_their_corners_a_place_45_percent_too_narrow_loses_the_truth() {
    let records: Vec<RunRecord> =
        (0..3).map(|seed| contained("navigation/lab.toml", 20.0, Distribution::Corner, seed)).collect();
    for axes in [&[0, 1, 2][..], &[0], &[1]] {
        assert!(records.iter().any(|record| would_lose(record, axes)), "axes {axes:?}");
    }
}
