use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Stdio,
    thread,
    time::Duration,
};

use serde_json::Value;
use sim::campaign::cases::from_csv;

use crate::command::{blind_scene, folder, outcome, wherein};

/// Text of a scene file: a floor with a carpet, and the expectation that the judge calls no check unsound (a true pose outside of the box without an
/// excuse).
const CARPET: &str = "[floor]\nfriction = 0.8\n[[floor.region]]\nname = \"carpet\"\nx_m = [1.0, 2.0]\ny_m = [0.2, 1.8]\n\
                      friction = 0.5\n[expect]\nunsound = 0\n";

fn write_scene(folder: &Path, duration_s: f64) {
    fs::write(folder.join("scene.toml"), blind_scene(duration_s, CARPET)).unwrap();
}

/// Arguments of `wherein sweep scene.toml` over friction of carpet and floor, with two seeds: 12 cases.
fn grid<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = vec!["sweep", "scene.toml", "--vary", "floor.region.carpet.friction=0.2..0.4/3"];
    arguments.extend(["--vary", "floor.friction=0.5,0.8", "--seeds", "3..5", "--out", out]);
    arguments.extend(more);
    arguments
}

/// Columns of a table by name, each as a list of texts.
fn columns(path: &Path) -> BTreeMap<String, Vec<String>> {
    let (names, rows) = from_csv(&fs::read_to_string(path).unwrap()).unwrap();
    let column = |index: usize| rows.iter().map(|row| row[index].clone()).collect();
    names.into_iter().enumerate().map(|(index, name)| (name, column(index))).collect()
}

/// Files that are the result of a sweep, by path: the table and the files of each case.
fn result_bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut bytes = BTreeMap::from([(PathBuf::from("results.csv"), fs::read(folder.join("results.csv")).unwrap())]);
    for case in fs::read_dir(folder.join("cases")).unwrap() {
        let case = case.unwrap().path();
        for name in ["summary.json", "boxes.csv", "steps.csv", "truth.tum", "estimate.tum"] {
            let path = case.join(name);
            bytes.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap());
        }
    }
    bytes
}

fn assert_same_results(one: &Path, other: &Path) {
    let (one, other) = (result_bytes(one), result_bytes(other));
    assert_eq!(one.keys().collect::<Vec<_>>(), other.keys().collect::<Vec<_>>());
    for (path, bytes) in &one {
        assert!(*bytes == other[path], "{} differs", path.display());
    }
}

#[test]
fn a_sweep_has_a_row_for_every_combination_and_seed_in_the_order_asked() {
    let folder = folder("sweep_rows");
    write_scene(&folder, 0.5);
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &grid("out", &[])));
    assert_eq!(code, 0, "{stdout}{stderr}");
    let columns = columns(&folder.join("out/results.csv"));
    assert_eq!(columns["set.floor.region.carpet.friction"].concat(), "0.20.20.20.20.30.30.30.30.40.40.40.4");
    assert_eq!(columns["set.floor.friction"].concat(), "0.50.50.80.8".repeat(3));
    assert_eq!(columns["seed"].concat(), "34".repeat(6));
    assert_eq!(columns["case"].iter().collect::<BTreeSet<_>>().len(), 12);
    assert!(columns["passed"].iter().all(|passed| passed == "true"));
}

#[test]
fn a_row_holds_the_figures_of_the_same_run_alone() {
    let folder = folder("sweep_alone");
    write_scene(&folder, 1.0);
    assert_eq!(outcome(&mut wherein(&folder, &grid("out", &[]))).0, 0);
    let alone = ["run", "scene.toml", "--set", "floor.region.carpet.friction=0.3", "--set", "floor.friction=0.8"];
    assert_eq!(outcome(&mut wherein(&folder, &[&alone[..], &["--seed", "4"]].concat())).0, 0);
    let text = fs::read_to_string(folder.join("renders/scene/4/summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    let columns = columns(&folder.join("out/results.csv"));
    // Row of the results for the second carpet friction, the second floor friction and the second seed, which was also run alone.
    let row = 7;
    assert_eq!(columns["digest.estimates"][row], summary["digest"]["estimates"].as_str().unwrap());
    let number = |name: &str| columns[name][row].parse::<f64>().unwrap();
    assert_eq!(number("error.y_m.max"), summary["error"]["y_m"]["max"].as_f64().unwrap());
    assert_eq!(number("width.heading_rad.mean"), summary["width"]["heading_rad"]["mean"].as_f64().unwrap());
    assert_eq!(number("containment.checks"), 101.0, "one check every 10 ms of 1 s, and one at the start");
}

#[test]
fn a_setting_reaches_the_world() {
    let folder = folder("sweep_world");
    fs::write(folder.join("scene.toml"), blind_scene(2.0, "")).unwrap();
    let slow = ["sweep", "scene.toml", "--vary", "robot.max_speed_m_per_s=0.05,0.2", "--out", "out"];
    assert_eq!(outcome(&mut wherein(&folder, &slow)).0, 0);
    let distance_m = &columns(&folder.join("out/results.csv"))["metrics.distance_m"];
    let [slow_m, fast_m] = [0, 1].map(|row| distance_m[row].parse::<f64>().unwrap());
    // In 2 s the robot drives at most as far as its greatest speed of 0.05 or 0.2 m/s allows, less what starting and turning cost.
    assert!(slow_m < 0.1 && 0.1 < fast_m && fast_m < 0.4, "{slow_m} {fast_m}");
}

#[test]
fn any_number_of_jobs_gives_the_same_bytes() {
    let folder = folder("sweep_jobs");
    write_scene(&folder, 0.5);
    for (out, jobs) in [("one", "1"), ("three", "3")] {
        assert_eq!(outcome(&mut wherein(&folder, &grid(out, &["--jobs", jobs]))).0, 0);
    }
    assert_same_results(&folder.join("one"), &folder.join("three"));
}

#[test]
fn jobs_that_share_a_graphics_device_give_the_same_bytes() {
    let folder = folder("sweep_device");
    let scene = blind_scene(0.5, "[floor.tiles]\n").replace("floor_camera = false", "floor_camera = true");
    fs::write(folder.join("scene.toml"), scene).unwrap();
    for (out, jobs) in [("one", "1"), ("two", "2")] {
        let lux = "light.illuminance_at_floor_lux=1,100";
        let sweep = ["sweep", "scene.toml", "--vary", lux, "--seeds", "0..2", "--jobs", jobs, "--out", out];
        let (code, _, stderr) = outcome(&mut wherein(&folder, &sweep));
        assert_eq!(code, 0, "{stderr}");
    }
    assert_same_results(&folder.join("one"), &folder.join("two"));
}

#[test]
fn a_killed_sweep_goes_on_where_it_stopped_and_ends_with_the_same_bytes() {
    let folder = folder("sweep_killed");
    write_scene(&folder, 3.0);
    assert_eq!(outcome(&mut wherein(&folder, &grid("whole", &["--jobs", "2"]))).0, 0);
    for after_ms in [30, 90, 170] {
        let mut child = wherein(&folder, &grid("killed", &["--jobs", "2"]))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        thread::sleep(Duration::from_millis(after_ms));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert_eq!(outcome(&mut wherein(&folder, &grid("killed", &["--jobs", "2"]))).0, 0);
    assert_same_results(&folder.join("whole"), &folder.join("killed"));
    let cases = fs::read_dir(folder.join("killed/cases")).unwrap();
    assert_eq!(cases.count(), 12, "something half written was left");
}

#[test]
fn what_is_recorded_is_not_run_again_unless_it_is_damaged() {
    let folder = folder("sweep_damaged");
    write_scene(&folder, 0.5);
    let sweep = || outcome(&mut wherein(&folder, &grid("out", &[])));
    assert_eq!(sweep().0, 0);
    let before = result_bytes(&folder.join("out"));
    let (_, _, stderr) = sweep();
    assert!(stderr.contains("0 cases run in") && stderr.contains("12 recorded earlier"), "{stderr}");

    let mut cases: Vec<PathBuf> =
        fs::read_dir(folder.join("out/cases")).unwrap().map(|case| case.unwrap().path()).collect();
    cases.sort();
    // Four cases of the recorded sweep are damaged: a digit is changed, a file is cut short, a file is removed, a folder is removed. Only these must
    // be run again.
    let summary = fs::read_to_string(cases[0].join("summary.json")).unwrap();
    fs::write(cases[0].join("summary.json"), summary.replacen("\"checks\": 51", "\"checks\": 61", 1)).unwrap();
    fs::write(cases[1].join("case.json"), "{").unwrap();
    fs::remove_file(cases[2].join("boxes.csv")).unwrap();
    fs::remove_dir_all(&cases[3]).unwrap();
    // Neither a report nor a merger accepts files that differ from what was recorded.
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["report", "out"]));
    assert_eq!((code, stdout.matches("its files are not those that were recorded").count()), (2, 2), "{stdout}");
    assert_eq!(stdout.matches("MISSING").count(), 2, "{stdout}");
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["merge", "out", "--out", "merged"]));
    assert_eq!((code, stdout.matches("MISSING").count()), (2, 4), "{stdout}");
    let (code, _, stderr) = sweep();
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("4 cases run in") && stderr.contains("8 recorded earlier"), "{stderr}");
    assert!(result_bytes(&folder.join("out")) == before);
}

#[test]
fn another_scene_or_other_frames_are_run_again() {
    let folder = folder("sweep_stale");
    write_scene(&folder, 0.5);
    assert_eq!(outcome(&mut wherein(&folder, &grid("out", &[]))).0, 0);
    let (_, _, stderr) = outcome(&mut wherein(&folder, &grid("out", &["--frames", "all"])));
    assert!(stderr.contains("12 cases run in"), "{stderr}");
    write_scene(&folder, 0.6);
    let (_, _, stderr) = outcome(&mut wherein(&folder, &grid("out", &[])));
    assert!(stderr.contains("12 cases run in"), "{stderr}");
    assert_eq!(columns(&folder.join("out/results.csv"))["containment.checks"][0], "61");
}

#[test]
fn merged_parts_are_the_bytes_of_the_whole() {
    let folder = folder("sweep_merged");
    write_scene(&folder, 0.5);
    assert_eq!(outcome(&mut wherein(&folder, &grid("whole", &[]))).0, 0);
    let parts = ["a", "b", "c", "d"];
    for (index, out) in parts.iter().enumerate() {
        let shard = format!("{}/4", index + 1);
        assert_eq!(outcome(&mut wherein(&folder, &grid(out, &["--shard", &shard]))).0, 0);
        assert_eq!(columns(&folder.join(out).join("results.csv"))["seed"].len(), 3, "a part of 12 cases");
    }
    let merge = [&["merge"], &parts[..], &["--out", "merged"]].concat();
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &merge));
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert_same_results(&folder.join("whole"), &folder.join("merged"));
}

#[test]
fn merge_names_every_missing_case_and_ends_with_code_2() {
    let folder = folder("sweep_missing");
    write_scene(&folder, 0.5);
    for (out, shard) in [("a", "1/4"), ("c", "3/4")] {
        assert_eq!(outcome(&mut wherein(&folder, &grid(out, &["--shard", shard]))).0, 0);
    }
    let merge = ["merge", "a", "c", "--out", "merged", "--junit", "junit.xml"];
    let (code, stdout, _) = outcome(&mut wherein(&folder, &merge));
    assert_eq!(code, 2, "{stdout}");
    let junit = fs::read_to_string(folder.join("junit.xml")).unwrap();
    assert_eq!(junit.matches("<error message=\"missing: the case has not run\"").count(), 6, "{junit}");
    assert!(junit.contains("tests=\"12\"") && junit.contains("errors=\"6\""), "{junit}");
    // The merged sweep lacks its cases 1, 3, 5, …, 11, counted from 0: those with the second seed, for every combination of the two frictions.
    let missing: Vec<&str> = stdout.lines().filter_map(|line| line.strip_prefix("MISSING ")).collect();
    assert_eq!(missing.len(), 6, "{stdout}");
    assert_eq!(missing[1], "floor.region.carpet.friction=0.2 floor.friction=0.8 seed 4");
    let status = &columns(&folder.join("merged/results.csv"))["status"];
    assert_eq!(status.concat(), "donemissing".repeat(6));
}

#[test]
fn parts_of_different_sweeps_are_not_merged() {
    let folder = folder("sweep_different");
    write_scene(&folder, 0.5);
    assert_eq!(outcome(&mut wherein(&folder, &grid("a", &["--shard", "1/2"]))).0, 0);
    let other = ["sweep", "scene.toml", "--seeds", "0..2", "--out", "b"];
    assert_eq!(outcome(&mut wherein(&folder, &other)).0, 0);
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["merge", "a", "b", "--out", "merged"]));
    assert_eq!(code, 2);
    assert!(stderr.starts_with("wherein: failed to merge a and b: their sweeps differ in what varies"), "{stderr}");
}

#[test]
fn a_sweep_file_states_the_same_sweep() {
    let folder = folder("sweep_file");
    write_scene(&folder, 0.5);
    fs::create_dir(folder.join("plans")).unwrap();
    let text = "scene = \"../scene.toml\"\nseeds = \"3..5\"\n[vary]\n\
                floor.region.carpet.friction = \"0.2..0.4/3\"\nfloor.friction = [0.5, 0.8]\n";
    fs::write(folder.join("plans/grid.toml"), text).unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &grid("typed", &[]))).0, 0);
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["sweep", "plans/grid.toml", "--out", "filed"]));
    assert_eq!(code, 0, "{stderr}");
    assert_same_results(&folder.join("typed"), &folder.join("filed"));
}

#[test]
fn a_part_without_cases_is_a_success_and_is_merged_and_reported_on_with_the_others() {
    let folder = folder("sweep_empty_part");
    write_scene(&folder, 0.1);
    let sweep = |part: usize, more: &[&str]| {
        let (shard, out) = (format!("{part}/16"), format!("part-{part}"));
        let sweep = ["sweep", "scene.toml", "--seeds", "0..4", "--shard", &shard, "--out", &out];
        outcome(&mut wherein(&folder, &[&sweep, more].concat()))
    };
    let (code, stdout, stderr) = sweep(9, &["--junit", "junit.xml"]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert!(stdout.starts_with("This shard has no cases, as the sweep has 4 only\n"), "{stdout}");
    let table = fs::read_to_string(folder.join("part-9/results.csv")).unwrap();
    assert!(table.lines().count() == 1 && table.starts_with("case,scene,seed,"), "{table}");
    assert!(fs::read_to_string(folder.join("junit.xml")).unwrap().contains("tests=\"0\""));
    for part in 1..=16 {
        assert_eq!(sweep(part, &[]).0, 0);
    }
    let parts: Vec<String> = (1..=16).map(|part| format!("part-{part}")).collect();
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    for command in ["merge", "report"] {
        let (code, stdout, stderr) =
            outcome(&mut wherein(&folder, &[&[command], &parts[..], &["--out", "whole"]].concat()));
        assert!(code == 0 && stdout.contains("passed: All 4 cases"), "{command}: {stdout}{stderr}");
    }
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["report", "part-9", "--out", "whole"]));
    assert!(code == 2 && stdout.contains("FAILED: Of 4 cases, 4 are missing."), "{stdout}");
}

/// Writes the record of a case that could not run into the folder of a sweep.
fn write_failed(sweep: &Path, id: &str) {
    let seal = serde_json::json!({
        "id": id, "set": [], "seed": 3, "frames": "none", "failure": "the run panicked", "files": {}
    });
    let _ = fs::remove_dir_all(sweep.join("cases").join(id));
    fs::create_dir_all(sweep.join("cases").join(id)).unwrap();
    fs::write(sweep.join("cases").join(id).join("case.json"), seal.to_string()).unwrap();
}

/// Names of the cases of a sweep in the order of its plan.
fn case_names(sweep: &Path) -> Vec<String> {
    let plan: Value = serde_json::from_str(&fs::read_to_string(sweep.join("sweep.json")).unwrap()).unwrap();
    plan["cases"].as_array().unwrap().iter().map(|id| id.as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_case_that_failed_is_merged_from_a_part_in_which_it_ran() {
    let folder = folder("sweep_failed_once");
    write_scene(&folder, 0.1);
    assert_eq!(outcome(&mut wherein(&folder, &grid("ran", &[]))).0, 0);
    fs::create_dir(folder.join("failed")).unwrap();
    fs::copy(folder.join("ran/sweep.json"), folder.join("failed/sweep.json")).unwrap();
    write_failed(&folder.join("failed"), &case_names(&folder.join("ran"))[5]);
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["merge", "failed", "ran", "--out", "merged"]));
    assert_eq!(code, 0, "{stdout}");
    assert_same_results(&folder.join("ran"), &folder.join("merged"));
    let (code, stdout, _) = outcome(&mut wherein(&folder, &["merge", "failed", "--out", "alone"]));
    assert!(code == 2 && stdout.contains("Of 12 cases, 1 could not run, 11 are missing"), "{stdout}");
}

#[test]
fn parts_of_different_programs_or_adapters_are_not_merged() {
    let folder = folder("sweep_programs");
    write_scene(&folder, 0.1);
    assert_eq!(outcome(&mut wherein(&folder, &grid("a", &[]))).0, 0);
    let plan: Value = serde_json::from_str(&fs::read_to_string(folder.join("a/sweep.json")).unwrap()).unwrap();
    fs::create_dir(folder.join("b")).unwrap();
    for (key, shown) in
        [("version", "version"), ("program", "program"), ("adapter", "adapter"), ("subject", "localizer")]
    {
        let mut other = plan.clone();
        other[key] = "another one".into();
        fs::write(folder.join("b/sweep.json"), other.to_string()).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["merge", "a", "b", "--out", "merged"]));
        let told = format!("wherein: failed to merge a and b: their sweeps differ in {shown}: ");
        assert!(code == 2 && stderr.starts_with(&told) && stderr.contains(" and another one"), "{key}: {stderr}");
    }
}

#[test]
fn what_failed_is_of_another_case_or_half_written_is_run_again() {
    let folder = folder("sweep_not_its_own");
    write_scene(&folder, 0.1);
    let sweep = || outcome(&mut wherein(&folder, &grid("out", &[])));
    assert_eq!(sweep().0, 0);
    let before = result_bytes(&folder.join("out"));
    let (cases, names) = (folder.join("out/cases"), case_names(&folder.join("out")));
    write_failed(&folder.join("out"), &names[0]);
    fs::remove_dir_all(cases.join(&names[1])).unwrap();
    // A case under the name of another one is not that case.
    fs::rename(cases.join(&names[2]), cases.join(&names[1])).unwrap();
    fs::create_dir(cases.join(".half_written")).unwrap();
    let (code, _, stderr) = sweep();
    assert!(code == 0 && stderr.contains("3 cases run in") && stderr.contains("9 recorded earlier"), "{stderr}");
    assert!(!cases.join(".half_written").exists(), "what a killed process left half written is removed");
    assert!(result_bytes(&folder.join("out")) == before);
}
