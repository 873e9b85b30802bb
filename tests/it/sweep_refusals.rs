use std::{fs, path::Path, process::Command};

use crate::command::{blind_scene, folder, outcome, wherein};

const CARPET: &str = "[[floor.region]]\nname = \"carpet\"\nx_m = [1.0, 2.0]\ny_m = [0.2, 1.8]\nfriction = 0.5\n";

fn with_scene(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    fs::write(folder.join("scene.toml"), blind_scene(0.5, CARPET)).unwrap();
    folder
}

/// Asserts that a sweep over these variations is refused with exit code 2 and a message that contains each of `parts`.
fn assert_refused(test: &str, vary: &[&str], parts: &[&str]) {
    let folder = with_scene(test);
    let mut arguments = vec!["sweep", "scene.toml", "--out", "out"];
    vary.iter().for_each(|vary| arguments.extend(["--vary", vary]));
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &arguments));
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let message = stderr.lines().next().unwrap();
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
    assert!(!folder.join("out").exists(), "a refused sweep left a folder behind");
}

#[test]
fn a_wrong_key_is_refused_with_the_nearest_right_ones() {
    let cases = [
        ("lights.illuminance_lux=1,2", "`lights.illuminance_lux`", "`light.illuminance_at_floor_lux`"),
        ("floor.region.carpt.friction=0.1,0.2", "`floor.region.carpt.friction`", "`floor.region.carpet.friction`"),
        ("route.waypoint[7].x_m=1,2", "`route.waypoint[7].x_m`", "`route.waypoint[0].x_m`"),
        ("floor.friction.left=1,2", "`floor.friction.left`", "`floor.friction`"),
        ("duration=1,2", "`duration`", "`duration_s`"),
    ];
    for (vary, found, meant) in cases {
        assert_refused("refused_key", &[vary], &["unknown key", found, meant]);
    }
}

#[test]
fn a_wrong_value_is_refused_by_the_schema() {
    let range = ["with floor.friction=5", "`floor.friction = 5`", "expected a number from 0.01 to 2"];
    assert_refused("refused_range", &["floor.friction=0.5,5"], &range);
    let kind = ["`floor.region[0].friction = \"high\"`", "a text, expected a number from 0.01 to 2"];
    assert_refused("refused_type", &["floor.region.carpet.friction=0.5,high"], &kind);
    let choice = ["`robot.errors = \"korner\"`", "uniform, truncated_gaussian, corner"];
    assert_refused("refused_choice", &["robot.errors=uniform,korner"], &choice);
    assert_refused("refused_place", &["start.x_m=0.6,7"], &["`start.x_m = 7`"]);
}

#[test]
fn a_range_without_its_number_of_values_is_refused() {
    for range in ["0.1..0.8", "0.1..0.8/1", "0.1..x/3", "..1/3"] {
        assert_refused("refused_steps", &[&format!("floor.friction={range}")], &["floor.friction="]);
    }
}

#[test]
fn the_same_key_or_the_same_value_twice_is_refused() {
    assert_refused("refused_twice", &["floor.friction=0.5", "floor.friction=0.6"], &["`floor.friction` twice"]);
    let same = ["floor.friction=0.5 and floor.friction=0.50", "the same scene"];
    assert_refused("refused_same", &["floor.friction=0.5,5e-1"], &[&same[0][..18], same[1]]);
}

#[test]
fn more_cases_than_a_sweep_may_have_are_refused() {
    let many = ["floor.friction=0.1..1/1000", "duration_s=1..2/1001"];
    assert_refused("refused_many", &many, &["1001000 cases", "at most 1000000"]);
}

#[test]
fn two_processes_do_not_share_a_folder() {
    let folder = with_scene("sweep_locked");
    let store = sim::campaign::sweep::Store::open(&folder.join("out")).unwrap();
    let sweep = ["sweep", "scene.toml", "--out", "out"];
    let (code, _, stderr) = outcome(&mut wherein(&folder, &sweep));
    assert_eq!(code, 2, "{stderr}");
    let holder = format!("process {} is sweeping into it", std::process::id());
    assert!(stderr.contains(&holder) && stderr.contains("--out"), "{stderr}");
    drop(store);
    assert_eq!(outcome(&mut wherein(&folder, &sweep)).0, 0);
}

#[test]
fn a_folder_that_cannot_be_written_is_named_before_anything_runs() {
    let folder = with_scene("sweep_unwritable");
    fs::write(folder.join("file"), "").unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["sweep", "scene.toml", "--out", "file/out"]));
    assert_eq!(code, 2);
    assert!(stderr.starts_with("wherein: failed to create the folder file/out: "), "{stderr}");
}

/// A limit on the size of files stands for a full disk: writing a file fails half way.
#[cfg(unix)]
#[test]
fn a_write_that_fails_is_told_and_what_was_recorded_before_stays() {
    let folder = with_scene("sweep_full");
    let sweep = |seeds: &'static str| ["sweep", "scene.toml", "--out", "out", "--jobs", "1", "--seeds", seeds];
    assert_eq!(outcome(&mut wherein(&folder, &sweep("0..2"))).0, 0);
    let program = wherein(Path::new("."), &[]).get_program().to_owned();
    let limited = format!("trap '' XFSZ; ulimit -f 4; exec '{}' {}", program.display(), sweep("0..4").join(" "));
    let (code, _, stderr) = outcome(Command::new("sh").arg("-c").arg(limited).current_dir(&folder));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("wherein: failed to write out/cases/"), "{stderr}");
    let (code, _, stderr) = outcome(&mut wherein(&folder, &sweep("0..4")));
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("2 cases run in") && stderr.contains("2 recorded earlier"), "{stderr}");
}

#[test]
fn a_sweep_file_is_refused_by_key() {
    let folder = with_scene("sweep_file_refused");
    let refuse = |text: &str, part: &str| {
        fs::write(folder.join("grid.toml"), text).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["sweep", "grid.toml", "--out", "out"]));
        assert_eq!(code, 2);
        let message = stderr.lines().next().unwrap();
        assert!(message.contains("grid.toml") && message.contains(part), "`{part}` is missing in: {message}");
    };
    refuse(
        "scene = \"scene.toml\"\nvari = 1\n",
        "`vari`: unknown key, expected one of scene, seeds, subject, baselines, vary",
    );
    refuse("scene = \"scene.toml\"\nseeds = \"2..1\"\n", "`seeds = \"2..1\"`");
    refuse("scene = \"scene.toml\"\n[vary]\nfloor.friction = [0.1,\n", "not a sweep in TOML: line");
    refuse("[vary]\nfloor.friction = [0.5, 0.6]\n", "`scene`: missing, expected the path of a scene");
    refuse("scene = \"scene.toml\"\n[vary]\nfloor.friction = []\n", "`vary.floor.friction`: an empty list");
    refuse(
        "scene = \"scene.toml\"\n[vary]\nfloor.friction = \"0.1..1\"\n",
        "`vary.floor.friction`: expected LOW..HIGH/N",
    );
}

#[test]
fn a_sweep_file_names_entries_of_lists_with_or_without_quotes() {
    let folder = with_scene("sweep_file_lists");
    let cases = |key: &str| {
        let text = format!("scene = \"scene.toml\"\n[vary]\n{key} = [1.0, 1.2]\nfloor.friction = [0.5]\n");
        fs::write(folder.join("grid.toml"), text).unwrap();
        let (code, stdout, stderr) = outcome(&mut wherein(&folder, &["sweep", "grid.toml", "--out", "out"]));
        assert_eq!(code, 0, "{stdout}\n{stderr}");
        let names = fs::read_dir(folder.join("out/cases")).unwrap().map(|entry| entry.unwrap().file_name());
        let mut names: Vec<_> = names.collect();
        names.sort();
        fs::remove_dir_all(folder.join("out")).unwrap();
        names
    };
    let quoted = cases("\"route.waypoint[0].y_m\"");
    assert_eq!(quoted, cases("route.waypoint[0].y_m"));
    assert_eq!(quoted.len(), 2, "{quoted:?}");
}

#[test]
fn a_sweep_whose_methods_have_nothing_to_read_is_told_so() {
    let folder = with_scene("sweep_blind");
    let (code, _, stderr) =
        outcome(&mut wherein(&folder, &["sweep", "scene.toml", "--vary", "floor.friction=0.5,0.6", "--out", "out"]));
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("`floor_tiles` has nothing to read"), "{stderr}");
}

#[test]
fn a_place_where_junit_cannot_be_written_is_refused_before_anything_runs() {
    let folder = with_scene("refused_junit");
    fs::write(folder.join("file"), "no folder").unwrap();
    for command in [["sweep", "scene.toml"], ["run", "scene.toml"]] {
        let arguments = [&command[..], &["--out", "out", "--junit", "file/junit.xml"]].concat();
        let (code, stdout, stderr) = outcome(&mut wherein(&folder, &arguments));
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains("create the folder file"), "{stderr}");
        assert!(!folder.join("out/scene").exists() && !folder.join("out/cases").exists(), "{command:?} ran");
    }
    let made = ["run", "scene.toml", "--out", "out", "--junit", "new/junit.xml"];
    assert_eq!(outcome(&mut wherein(&folder, &made)).0, 0);
    assert!(folder.join("new/junit.xml").exists());
}

#[test]
fn tests_of_tables_are_refused_before_the_tables_are_read() {
    let folder = with_scene("refused_tests_of_tables");
    let (code, _, stderr) =
        outcome(&mut wherein(&folder, &["report", "nowhere", "--out", "whole", "--junit", "junit.xml"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("junit.xml") && stderr.contains("without --out"), "{stderr}");
    assert!(!folder.join("whole").exists());
}

#[test]
fn no_jobs_at_all_are_refused_by_the_options_name() {
    let folder = with_scene("refused_jobs");
    for command in [&["sweep", "scene.toml"][..], &["falsify"]] {
        let (code, _, stderr) = outcome(&mut wherein(&folder, &[command, &["--jobs", "0"]].concat()));
        assert_eq!(code, 2);
        let told = "error: invalid value '0' for '--jobs <N>': expected a whole number of at least 1";
        assert!(stderr.starts_with(told), "{stderr}");
    }
}
