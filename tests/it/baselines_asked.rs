use std::{collections::BTreeSet, fs, path::Path, time::Instant};

use serde_json::Value;
use sim::{
    campaign::sweep::Sweep,
    run::{RunOptions, run},
    scene::Scene,
    subject::IntervalLocalizer,
};

use crate::command::{blind_scene, folder, outcome, root, wherein};

/// A scene with a range camera and landmarks around the robot, so that every kind of method to compare with has something to read but images.
fn among_landmarks(expect: &str) -> String {
    let landmarks: String = [(2.8, 0.3), (2.8, 1.0), (2.7, 1.7), (1.9, 1.8)]
        .map(|(x_m, y_m)| format!("[[landmark]]\nx_m = {x_m}\ny_m = {y_m}\n"))
        .concat();
    let more = format!("[localizer]\nmethods = [\"range_landmarks\"]\n{landmarks}{expect}");
    blind_scene(3.0, &more).replace("floor_camera = false", "floor_camera = false\nrange_camera = true")
}

/// The JSON file of this name that a run of the scene with seed 0 left.
fn left(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("renders/scene/0").join(name)).unwrap()).unwrap()
}

/// Names of the methods to compare with in the summary of the scene's run.
fn compared(folder: &Path) -> BTreeSet<String> {
    left(folder, "summary.json")["baselines"].as_object().unwrap().keys().cloned().collect()
}

#[test]
fn other_methods_run_only_when_asked_and_change_nothing_else() {
    let folder = folder("baselines_asked");
    fs::write(folder.join("scene.toml"), among_landmarks("")).unwrap();
    let ran = |more: &[&str]| {
        let (code, stdout, stderr) = outcome(&mut wherein(&folder, &[&["run", "scene.toml"], more].concat()));
        assert_eq!(code, 0, "{stderr}");
        stdout
    };
    let stdout = ran(&[]);
    assert_eq!(compared(&folder), BTreeSet::from(["odometry".to_owned()]));
    assert!(stdout.contains("--baselines"), "nothing says what else there is:\n{stdout}");
    assert!(left(&folder, "timing.json")["stages_ms"]["baselines"].is_null());
    let digests = left(&folder, "summary.json")["digest"].clone();

    // What was recorded without them does not serve a command that asks for them.
    let stdout = ran(&["--baselines", "--resume"]);
    let names = compared(&folder);
    for name in ["odometry", "least_squares", "closest_points", "ransac", "gated_icp", "sivia", "table_iv_printed"] {
        assert!(names.contains(name) && stdout.contains(name), "{name}: {names:?}\n{stdout}");
    }
    assert!(left(&folder, "timing.json")["stages_ms"]["baselines"].as_f64().unwrap() > 0.0);
    assert_eq!(left(&folder, "summary.json")["digest"], digests);
}

#[test]
fn the_time_of_other_methods_is_no_part_of_the_wall_time() {
    // At stations every reading is given to every interval solver, which takes some 10 ms.
    let stations =
        "[[station]]\nx_m = 0.6\ny_m = 0.6\nheading_deg = 0\n[[station]]\nx_m = 1.0\ny_m = 0.8\nheading_deg = 30\n";
    let text = among_landmarks("").replace("[[route.waypoint]]\nx_m = 2.4\ny_m = 1.2\n", stations);
    let scene = Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let options = RunOptions { baselines: true, ..RunOptions::default() };
    let began = Instant::now();
    let record = run(&scene, 0, &mut IntervalLocalizer::of(&scene), None, &options, &mut |_| {}).unwrap();
    let took_s = began.elapsed().as_secs_f64();
    let (wall_s, baselines_s) = (record.timing.wall_s, record.timing.baselines_s.unwrap());
    assert!(wall_s > 0.0 && baselines_s > 0.0, "{:?}", record.timing);
    assert!(wall_s + baselines_s <= took_s, "{wall_s} s and {baselines_s} s in {took_s} s");
}

#[test]
fn a_method_that_the_scene_expects_something_of_runs_unasked() {
    let folder = folder("baselines_expected");
    let expect = "[expect.baselines.ransac.error.x_m]\nrmse_max = 0.5\n";
    fs::write(folder.join("scene.toml"), among_landmarks(expect)).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
    assert_eq!(code, 0, "{stderr}");
    assert!(compared(&folder).contains("ransac"));
    let scene = |expect: &str| Scene::parse(&blind_scene(1.0, expect), "scene.toml").unwrap();
    for asks in [
        "[expect.metrics]\nvanishing_point_share_min = 0.1\n",
        "[expect.metrics]\nnearest_marker_misread = 0\n",
        "[expect.metrics]\npoint_matches_fix_share_min = 0.1\n",
        "[expect.baselines.point_matching.error.x_m]\nrmse_max = 0.1\n",
    ] {
        assert!(scene(asks).expect.needs_baselines(), "{asks}");
    }
    for asks_not in ["[expect]\nunsound = 0\n", "[expect.baselines.odometry.error.x_m]\nrmse_max = 9\n"] {
        assert!(!scene(asks_not).expect.needs_baselines(), "{asks_not}");
    }
}

#[test]
fn a_sweep_file_asks_for_other_methods_by_a_key() {
    let folder = folder("baselines_swept");
    fs::write(folder.join("scene.toml"), among_landmarks("")).unwrap();
    let column = |file: &str, text: &str, out: &str| {
        fs::write(folder.join(file), format!("scene = \"scene.toml\"\n{text}")).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["sweep", file, "--out", out]));
        assert_eq!(code, 0, "{stderr}");
        fs::read_to_string(folder.join(out).join("results.csv")).unwrap().contains("baselines.ransac.error.x_m.rmse")
    };
    // The same folder serves both: cases with other methods have names of their own.
    assert!(!column("without.toml", "", "out"));
    assert!(column("with.toml", "baselines = true\n", "out"));
    let dark = Sweep::load(&root().join("experiments/dark_lux.toml")).unwrap().unwrap();
    assert!(dark.baselines, "the book's figure shows paper 2's vision, too");
    fs::write(folder.join("wrong.toml"), "scene = \"scene.toml\"\nbaselines = 1\n").unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["sweep", "wrong.toml"]));
    assert!(code == 2 && stderr.contains("`baselines`: expected true or false"), "{stderr}");
}
