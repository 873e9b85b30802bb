//! Whole runs on rendered images: soundness, recovery from broken bounds, and the same bytes for the same seed.

use std::fs;

use serde_json::Value;
use sim::{
    judge::Verdict,
    loading::SceneFile,
    render::Renderer,
    run::{RunOptions, RunRecord, run},
    scene::Scene,
    subject::IntervalLocalizer,
};

use crate::command::{folder, outcome, root, scene_text, wherein};
use crate::judging::verdict_of;

/// A scene of the repository, shortened to `duration_s`.
fn scene(path: &str, duration_s: f64) -> Scene {
    let mut scene = SceneFile::load_all(&[root().join("scenes").join(path)]).unwrap().remove(0).scene;
    scene.duration_s = duration_s;
    scene
}

fn judged(scene: &Scene, seed: u64) -> (RunRecord, Verdict) {
    let mut renderer = Renderer::new().unwrap();
    let record =
        run(scene, seed, &mut IntervalLocalizer::of(scene), Some(&mut renderer), &RunOptions::default(), &mut |_| {})
            .unwrap();
    let verdict = verdict_of(scene, &record);
    (record, verdict)
}

fn assert_clean(verdict: &Verdict) {
    let containment = verdict.containment.as_ref().unwrap();
    assert_eq!(containment.contained, containment.checks, "{containment:?}");
    assert!(verdict.violations.is_empty(), "{:?}", verdict.violations);
}

#[test]
fn on_plain_tiles_the_truth_is_in_a_box_of_millimetres() {
    let (_, verdict) = judged(&scene("tiles.toml", 12.0), 31);
    assert_clean(&verdict);
    assert!(
        verdict.width.as_ref().unwrap().at_fix.x_m.mean < 0.006
            && verdict.width.as_ref().unwrap().at_fix.y_m.mean < 0.006,
        "{:?}",
        verdict.width
    );
    assert!(verdict.width.as_ref().unwrap().at_fix.heading_rad.mean < 0.6_f64.to_radians(), "{:?}", verdict.width);
    // Odometry alone must be clearly worse than the estimate: if it were as good, the images would have contributed nothing.
    let odometry = verdict.baselines["odometry"].error.as_ref().unwrap();
    assert!(odometry.position_m.max > 3.0 * verdict.error.position_m.mean);
}

#[test]
fn a_turned_grid_of_unequal_tiles_keeps_the_truth() {
    assert_clean(&judged(&scene("floor/rotated_grid.toml", 12.0), 32).1);
}

#[test]
fn a_bent_lens_and_a_rolling_shutter_keep_the_truth_and_make_no_claim_false() {
    for (name, greatest_m) in [("bent_lens", 0.006), ("rolling_shutter", 0.009)] {
        let (_, verdict) = judged(&scene(&format!("floor/{name}.toml"), 12.0), 35);
        assert_clean(&verdict);
        let method = &verdict.methods["floor_tiles"];
        assert!(method.constraints > 45 && method.false_claims == 0, "{name}: {method:?}");
        assert!(verdict.width.as_ref().unwrap().at_fix.x_m.mean < greatest_m, "{name}: {:?}", verdict.width);
    }
}

#[test]
fn the_papers_chain_keeps_the_truth() {
    let scene = scene("papers/floor_vision_odometry_paper_chain.toml", 8.0);
    let (_, verdict) = judged(&scene, 33);
    assert_clean(&verdict);
    assert!(verdict.methods["floor_tiles"].constraints > 20, "{:?}", verdict.methods);
}

#[test]
fn every_station_is_contained() {
    let scene = scene("stations.toml", 1.0);
    let (record, verdict) = judged(&scene, 34);
    assert_eq!(record.drives().count(), scene.stations.len());
    assert_clean(&verdict);
    assert_eq!(verdict.methods["floor_tiles"].constraints, scene.stations.len());
}

#[test]
fn a_start_known_to_a_quarter_metre_keeps_a_branch_for_each_tile() {
    let (record, verdict) = judged(&scene("floor/ambiguous_start.toml", 4.0), 35);
    assert_clean(&verdict);
    let most = record.estimates.iter().map(|estimate| estimate.pose.branches.len()).max();
    assert!(most >= Some(2), "two tiles fit into half a metre: {most:?}");
}

#[test]
fn a_push_is_told_by_name_time_and_amount_and_forgotten_within_two_seconds() {
    let (record, verdict) = judged(&scene("broken/push_4cm.toml", 11.0), 36);
    assert_eq!(
        (verdict.containment.as_ref().unwrap().unsound, verdict.containment.as_ref().unwrap().perception),
        (0, 0),
        "{:?}",
        verdict.containment
    );
    assert!(verdict.metrics["longest_outside_s"] <= 2.0);
    assert_eq!(record.estimates.last().unwrap().pose.branches.len(), 1);
    let slip = verdict.violations.iter().find(|violation| violation.bound == "wheels.side_slip").unwrap();
    assert!((slip.from_s - 8.0).abs() <= 0.03 && (8.15..8.5).contains(&slip.to_s), "{slip:?}");
    // The greatest lateral travel within a window of 0.2 s (20 steps), computed from the true states alone.
    let travel = |index: usize| record.truths[index].lateral_travel_m;
    let greatest = (20..record.truths.len()).map(|end| (travel(end) - travel(end - 20)).abs()).fold(0.0, f64::max);
    assert!((slip.true_value / greatest - 1.0).abs() < 0.02, "{slip:?} against {greatest}");
}

#[test]
fn a_tile_laid_off_its_place_is_told_while_it_is_in_view() {
    let scene = scene("broken/misplaced_tile.toml", 8.0);
    let (record, verdict) = judged(&scene, 37);
    assert_eq!(
        (verdict.containment.as_ref().unwrap().unsound, verdict.containment.as_ref().unwrap().perception),
        (0, 0),
        "{:?}",
        verdict.containment
    );
    let told = verdict.violations.iter().find(|violation| violation.bound == "floor_tiles.laying").unwrap();
    let first = verdict.containment.as_ref().unwrap().first_failure.as_ref().map(|first| first.blame.as_str());
    assert!(first.is_none_or(|blame| blame.starts_with("floor_tiles.")), "{first:?}");
    // The misplaced tile is [7, 2]. It is moved by 8 mm along x, in addition to the errors drawn for its four corners.
    let laid = record.drawn.place.tiles.as_ref().unwrap();
    let corner = |i: i32, j: i32| {
        laid.corner_offset_m[(i - laid.first[0]) as usize * laid.count[1] + (j - laid.first[1]) as usize][0].abs()
    };
    let greatest = [corner(7, 2), corner(8, 2), corner(7, 3), corner(8, 3)].into_iter().fold(0.0, f64::max);
    assert!((0.0075..0.0085).contains(&greatest));
    assert!((told.true_value / greatest - 1.0).abs() < 0.02, "{told:?} against {greatest}");
    assert!(verdict.metrics["longest_outside_s"] <= 2.0, "{:?}", verdict.metrics);
}

#[test]
fn the_same_seed_gives_the_same_bytes_in_any_process_on_any_number_of_threads() {
    let place = folder("same_bytes");
    let text = scene_text("tiles.toml").replace("duration_s = 20.0", "duration_s = 2.0");
    fs::write(place.join("short.toml"), text).unwrap();
    let digest = |seed: &str, threads: &str| -> Value {
        let arguments = ["run", "short.toml", "--seed", seed, "--out", "out", "--json"];
        let mut command = wherein(&place, &arguments);
        // Mesa's software graphics drivers read the number of threads to use from this environment variable.
        let (_, output, errors) = outcome(command.env("LP_NUM_THREADS", threads));
        let summaries: Value = serde_json::from_str(&output).unwrap_or_else(|error| panic!("{error}: {errors}"));
        summaries[0]["digest"].clone()
    };
    let first = digest("5", "1");
    assert!(first["readings"].is_string() && first["truth"].is_string() && first["estimates"].is_string());
    assert_eq!(first, digest("5", "2"));
    assert_eq!(first, digest("5", "4"));
    let other = digest("6", "2");
    for part in ["truth", "readings", "estimates"] {
        assert_ne!(first[part], other[part], "{part}");
    }
}
