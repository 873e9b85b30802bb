//! The example is the whole command `wherein` with one more localizer: a run, a sweep and its report.
#![allow(clippy::unwrap_used)]

use std::{fs, path::Path, process::Command};

use serde_json::Value;

const SCENE: &str = "duration_s = 6.0\n[room]\nwidth_m = 3.0\ndepth_m = 2.0\n[robot]\nfloor_camera = false\n\
                     [start]\nx_m = 0.6\ny_m = 0.6\n[[route.waypoint]]\nx_m = 2.4\ny_m = 1.2\n";

#[test]
fn a_program_runs_sweeps_and_reports_its_own_localizer() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("own_subject");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let command = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_own-subject")).current_dir(&folder).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert_eq!(command(&["run", "scene.toml", "--subject", "reckoning", "--out", "run"]), (Some(0), String::new()));
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("run/scene/0/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["subject"], "reckoning");
    // Every run computes odometry for comparison, by other code, which takes the turn at the middle of each step instead of its end.
    let rmse_m = |of: &Value| of["x_m"]["rmse"].as_f64().unwrap();
    let (own_m, odometry_m) = (rmse_m(&summary["error"]), rmse_m(&summary["baselines"]["odometry"]["error"]));
    assert!((own_m - odometry_m).abs() < 1e-3 && own_m > 1e-6, "{own_m} m, odometry {odometry_m} m");
    let sweep = ["sweep", "scene.toml", "--seeds", "0..3", "--subject", "reckoning", "--out", "sweep"];
    assert_eq!(command(&sweep).0, Some(0));
    fs::remove_file(folder.join("sweep/report.html")).unwrap();
    assert_eq!(command(&["report", "sweep"]).0, Some(0));
    assert!(folder.join("sweep/report.html").exists());
    let table = fs::read_to_string(folder.join("sweep/results.csv")).unwrap();
    assert_eq!(table.lines().filter(|line| line.contains("reckoning")).count(), 3, "{table}");
    let (code, said) = command(&["run", "scene.toml", "--subject", "reckonin"]);
    // The refusal lists the names that there are, the built-in ones and that of the example.
    let names = said.split_once("expected one of ").map_or("", |(_, names)| names);
    assert!(code == Some(2) && names.contains("intervals, ") && names.contains(", reckoning, or"), "{said}");
}
