//! The classical estimators as subjects: what they answer, how they are judged, and how the command names them.

use std::fs;

use serde_json::Value;
use sim::{
    judge::Verdict,
    loading::SceneFile,
    run::{RunOptions, RunRecord, run},
    scene::Scene,
    subject::{SubjectChoice, subject},
};

use crate::{
    command::{blind_scene, folder_of, outcome, root, wherein},
    judging::verdict_of_subject,
    render_studio::renderer,
    wall_ranges::furnished,
};

fn judged(scene: &Scene, name: &str, seed: u64) -> (RunRecord, Verdict) {
    let choice: SubjectChoice = name.parse().unwrap();
    let of = |told: &Scene| subject(&choice, told);
    let record = run(scene, seed, &mut *of(scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of_subject(scene, &record, &of);
    (record, verdict)
}

fn scene_of(path: &str, duration_s: f64) -> Scene {
    let mut scene = SceneFile::load_all(&[root().join(path)]).unwrap().remove(0).scene;
    scene.duration_s = duration_s;
    scene
}

fn rmse_m(verdict: &Verdict) -> f64 {
    verdict.error.x_m.rmse.hypot(verdict.error.y_m.rmse)
}

#[test]
fn filters_find_a_robot_by_satellites_and_are_surer_than_errors_that_last_allow() {
    // The start is known to half a metre and to 20 degrees, positions to a centimetre or two: a filter that reads them is off by centimetres after
    // the first few metres, and dead reckoning from the middle of the start box is not.
    let scene = scene_of("scenes/gnss.toml", 35.0);
    for name in ["ekf", "particles"] {
        let (record, verdict) = judged(&scene, name, 4);
        let odometry = verdict.baselines["odometry"].error.as_ref().unwrap();
        let odometry_m = odometry.x_m.rmse.hypot(odometry.y_m.rmse);
        assert!(rmse_m(&verdict) < 0.5 * odometry_m, "{name}: {} m, odometry {odometry_m} m", rmse_m(&verdict));
        let stated = verdict.distribution.unwrap();
        assert_eq!((stated.checks, stated.unusable), (record.truths.len(), 0), "{name}");
        // The receiver's errors last for seconds, and a filter takes each position's for a new one.
        assert!(stated.nees.mean > 3.0 && stated.calibration.within_99 < 0.99, "{name}: {stated:?}");
        assert!(verdict.latency_s.unwrap().max < 0.1, "{name}");
    }
}

#[test]
fn landmarks_on_no_map_keep_the_kalman_filter_where_odometry_drifts() {
    let scene = scene_of("scenes/papers/rigid_transform_loop.toml", 60.0);
    let (_, verdict) = judged(&scene, "ekf", 2);
    let odometry = verdict.baselines["odometry"].error.as_ref().unwrap();
    let odometry_m = odometry.x_m.rmse.hypot(odometry.y_m.rmse);
    assert!(rmse_m(&verdict) < 0.5 * odometry_m, "{} m, odometry {odometry_m} m", rmse_m(&verdict));
}

#[test]
fn scans_keep_the_filters_among_furniture_and_a_person() {
    let scene = furnished(&[]);
    for name in ["ekf", "particles"] {
        let mut nees = 0.0;
        for seed in 0..4 {
            let (record, verdict) = judged(&scene, name, seed);
            let odometry = verdict.baselines["odometry"].error.as_ref().unwrap();
            let odometry_m = odometry.x_m.rmse.hypot(odometry.y_m.rmse);
            let stated = verdict.distribution.as_ref().unwrap();
            assert_eq!((stated.checks, stated.unusable), (record.truths.len(), 0), "{name}");
            assert!(rmse_m(&verdict) < 0.4 * odometry_m, "{name}: {} m, odometry {odometry_m} m", rmse_m(&verdict));
            nees += 0.25 * stated.nees.mean;
        }
        // The samples have no place for the displacements of walls, and seldom keep that of the scanner's mount.
        let most = if name == "ekf" { 6.0 } else { 30.0 };
        assert!((1.0..most).contains(&nees), "{name}: {nees}");
    }
}

#[test]
fn filters_know_how_well_they_read_markers_joints_and_walls() {
    for (path, duration_s, most_m, least_surer) in [
        ("scenes/papers/ir_markers_lab.toml", 6.0, 0.004, 1.5),
        ("scenes/tiles.toml", 6.0, 0.004, 1.5),
        ("scenes/dark/walls.toml", 6.0, 0.02, 1.1),
    ] {
        let scene = scene_of(path, duration_s);
        let nees_of = |name: &str| {
            let choice: SubjectChoice = name.parse().unwrap();
            let of = |told: &Scene| subject(&choice, told);
            let mut renderer = renderer();
            let renderer = Some(&mut *renderer);
            let record = run(&scene, 3, &mut *of(&scene), renderer, &RunOptions::default(), &mut |_| {}).unwrap();
            let verdict = verdict_of_subject(&scene, &record, &of);
            (verdict.distribution.as_ref().unwrap().nees.mean, rmse_m(&verdict))
        };
        let (nees, error_m) = nees_of("ekf");
        assert!(error_m < most_m, "{path}: {error_m} m");
        assert!((1.0..12.0).contains(&nees), "{path}: {nees}");
        // With a tenth of the noise the filter would be surer by far than it may be.
        let (surer, _) = nees_of("ekf,cues=0.1");
        println!("{path}: {nees}, {error_m} m; with a tenth of the noise {surer}");
        assert!(surer > least_surer * nees, "{path}: {surer} beside {nees}");
    }
}

#[test]
fn the_same_seed_gives_the_same_answers() {
    let scene = scene_of("scenes/gnss.toml", 5.0);
    for name in ["ekf", "particles"] {
        let [first, second] = [0; 2].map(|_| judged(&scene, name, 1).0);
        assert!(first.stated == second.stated, "{name}");
    }
}

#[test]
fn a_localizer_is_chosen_by_its_name_and_named_in_what_it_leaves() {
    let folder = folder_of("subject_named", &[("blind.toml", &blind_scene(2.0, ""))]);
    let (code, _, said) = outcome(&mut wherein(&folder, &["run", "blind.toml", "--subject", "ekf,motion=2"]));
    assert_eq!(code, 0, "{said}");
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("renders/blind/0/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["subject"], "ekf,motion=2");
    assert!(summary["distribution"]["checks"].as_u64().unwrap() > 100, "{summary:#}");
    let steps = fs::read_to_string(folder.join("renders/blind/0/distribution.csv")).unwrap();
    assert!(steps.starts_with("time_s,mean_x_m"), "{steps}");
    assert_eq!(steps.lines().count() as u64, 1 + summary["distribution"]["checks"].as_u64().unwrap());
}

#[test]
fn a_scene_states_other_noise_for_a_filter_and_the_user_still_another() {
    let scene = |filters: &str| Scene::parse(&blind_scene(9.0, filters), "blind.toml").unwrap();
    let (usual, noisier) = (scene(""), scene("[filters.ekf]\nmotion = 3.0\n[filters.particles]\nmotion = 3.0\n"));
    for name in ["ekf", "particles"] {
        let width_m = |scene: &Scene, subject: &str| {
            let verdict = judged(scene, subject, 1).1;
            verdict.distribution.unwrap().region_3_sigma.x_m.mean_by_third[2]
        };
        let [by_default, of_scene] = [&usual, &noisier].map(|scene| width_m(scene, name));
        assert!(of_scene > 1.2 * by_default, "{name}: {of_scene} m beside {by_default} m");
        assert_eq!(width_m(&usual, &format!("{name},motion=3")), of_scene, "{name}");
        assert_eq!(width_m(&noisier, &format!("{name},motion=1")), by_default, "{name}");
        assert_eq!(
            width_m(&noisier, &format!("{name},cues=2")),
            of_scene,
            "{name}: no cue, so that its noise is without effect"
        );
    }
    let Err(error) = Scene::parse(&blind_scene(9.0, "[filters.ekf]\nmotion = 0.0\n"), "blind.toml") else {
        panic!("a factor of 0 was accepted")
    };
    assert!(error.to_string().contains("filters.ekf.motion"), "{error}");
}

#[test]
fn a_scene_states_other_noise_of_cues_for_each_filter() {
    let text = fs::read_to_string(root().join("scenes/gnss.toml")).unwrap();
    let scene = |filters: &str| {
        let mut scene = Scene::parse(&format!("{text}\n{filters}"), "gnss.toml").unwrap();
        scene.duration_s = 5.0;
        scene
    };
    for name in ["ekf", "particles"] {
        let width_m = |scene: &Scene, subject: &str| {
            let verdict = judged(scene, subject, 1).1;
            verdict.distribution.unwrap().region_3_sigma.x_m.mean_by_third[2]
        };
        let (usual, noisier) = (scene(""), scene(&format!("[filters.{name}]\ncues = 5.0\n")));
        let [by_default, of_scene] = [&usual, &noisier].map(|scene| width_m(scene, name));
        println!("{name}: {by_default} m, {of_scene} m");
        assert!(of_scene > 1.5 * by_default, "{name}: {of_scene} m beside {by_default} m");
        assert_eq!(width_m(&usual, &format!("{name},cues=5")), of_scene, "{name}");
        assert_eq!(width_m(&noisier, &format!("{name},cues=1")), by_default, "{name}");
    }
}

#[test]
fn localizers_stand_side_by_side_in_a_report_and_are_compared_run_by_run() {
    let folder = folder_of("subjects_beside", &[("blind.toml", &blind_scene(2.0, ""))]);
    for name in ["intervals", "ekf", "particles"] {
        let arguments = ["run", "blind.toml", "--seeds", "0..2", "--subject", name, "--out", &format!("all/{name}")];
        assert_eq!(outcome(&mut wherein(&folder, &arguments)).0, 0, "{name}");
    }
    let (code, told, said) = outcome(&mut wherein(&folder, &["report", "all"]));
    assert_eq!(code, 0, "{said}");
    // What a passed filter's regions are worth stands beside the verdict, and the columns are those that boxes and filters have both.
    assert!(told.contains("\nekf is ") && told.contains("\nparticles is ") && told.contains("right is 3.0"), "{told}");
    assert!(!told.contains("\nintervals is ") && told.lines().next().unwrap().contains("error, mm"), "{told}");
    let page = fs::read_to_string(folder.join("all/report.html")).unwrap();
    assert!(page.contains("What a guarantee costs, and what overconfidence costs"), "{page}");
    let markdown = fs::read_to_string(folder.join("all/summary.md")).unwrap();
    let rows = |title: &str| {
        let section = markdown.split(title).nth(1).unwrap().split("###").next().unwrap();
        let rows = section.lines().filter(|line| line.starts_with("| blind | "));
        rows.inspect(|row| assert_eq!(row.matches('|').count(), 8 + 1, "{row}")).collect::<Vec<&str>>()
    };
    assert_eq!(rows("What a guarantee costs").len(), 3, "{markdown}");
    // The boxes are no distributions. The share of each filter's steps with the truth in its region of 50 % is in its summary, too.
    let calibrated = rows("How often the truth is in the region");
    assert_eq!(calibrated.len(), 2, "{markdown}");
    for (name, row) in ["ekf", "particles"].iter().zip(calibrated) {
        let within = |seed: usize| -> f64 {
            let text = fs::read_to_string(folder.join(format!("all/{name}/blind/{seed}/summary.json"))).unwrap();
            let summary: Value = serde_json::from_str(&text).unwrap();
            summary["distribution"]["calibration"]["within_50"].as_f64().unwrap()
        };
        let mean = format!("| {:.1} |", 50.0 * (within(0) + within(1)));
        assert!(row.starts_with(&format!("| blind | {name} {mean}")), "{mean}: {row}");
    }
    assert!(page.contains("How well the stated distributions are calibrated"), "{page}");
    let (code, told, said) = outcome(&mut wherein(&folder, &["compare", "all/ekf", "all/particles"]));
    assert!(code < 2 && told.contains("position error") && told.contains("|ln(NEES / 3)|"), "{told}{said}");
    let (_, told, _) = outcome(&mut wherein(&folder, &["compare", "all/intervals", "all/ekf"]));
    assert!(told.contains("2 pairs of two localizers of which only one states boxes"), "{told}");
    assert!(!told.contains("lost containment") && !told.contains("one side has no number"), "{told}");
    // A sweep's file may name the localizer, and the command line has the last word.
    fs::write(folder.join("sweep.toml"), "scene = \"blind.toml\"\nsubject = \"ekf\"\n").unwrap();
    for (more, name) in [(&[][..], "ekf"), (&["--subject", "particles"], "particles")] {
        let arguments = [&["sweep", "sweep.toml", "--out", name], more].concat();
        assert_eq!(outcome(&mut wherein(&folder, &arguments)).0, 0, "{name}");
        let table = fs::read_to_string(folder.join(name).join("results.csv")).unwrap();
        assert!(table.lines().nth(1).unwrap().split(',').any(|cell| cell == name), "{table}");
    }
}

#[test]
fn a_name_that_no_localizer_has_is_refused_with_those_that_there_are() {
    let folder = folder_of("subject_refused", &[("blind.toml", &blind_scene(1.0, ""))]);
    for (name, expected) in [("kalman", "intervals, ekf, particles"), ("ekf,cues=0", "a number from 0.001 to 1000")] {
        let (code, _, said) = outcome(&mut wherein(&folder, &["run", "blind.toml", "--subject", name]));
        assert_eq!(code, 2, "{name}");
        assert!(said.contains(expected), "{said}");
        assert!(!folder.join("renders").exists(), "{name}");
    }
}
