//! `wherein calibrate drive` against robots whose constants are known: those that a seed draws, and those of the logs of scripts/foreign_logs.

use std::{fs, path::Path};

use serde_json::Value;
use sim::{scene::Scene, world::Drawn};

use crate::command::{folder, outcome, root, rounds, wherein};

/// A robot that drives round a room, turning both ways, and how its recordings are read as logs.
const ROBOT: &str = "duration_s = 90.0\nroom = { width_m = 6.0, depth_m = 5.0 }\nstart = { x_m = 1.0, y_m = 1.0, heading_deg = 0.0 }\n\
    [robot]\nfloor_camera = false\nbase = { wheel_radius_tolerance = 0.01, track_tolerance = 0.02 }\n\
    gyro = { bias_tolerance_deg_per_s = 0.1, scale_tolerance = 0.01 }\n[localizer]\nmethods = []\n\
    [route]\nrepeat = true\n[[route.waypoint]]\nx_m = 5.0\ny_m = 1.0\n[[route.waypoint]]\nx_m = 5.0\ny_m = 4.0\n\
    [[route.waypoint]]\nx_m = 1.0\ny_m = 4.0\n[[route.waypoint]]\nx_m = 3.0\ny_m = 2.0\n[[route.waypoint]]\nx_m = 1.0\ny_m = 1.0\n\
    [log]\njoints = { left = \"left_wheel\", right = \"right_wheel\" }\n\
    truth = { topic = \"/truth\", tolerance_m = 0.001, tolerance_deg = 0.05 }\n";

/// What the command finds in a log, as JSON.
fn calibrated(place: &Path, log: &str, more: &[&str]) -> Value {
    let command = [&["calibrate", "drive", log, "--robot", "robot.toml", "--json"], more].concat();
    let (code, told, errors) = outcome(&mut wherein(place, &command));
    assert_eq!(code, 0, "{errors}");
    serde_json::from_str(&told).unwrap()
}

/// The value of a constant, and three of its standard deviations.
fn constant(found: &Value, name: &str) -> [f64; 2] {
    let all = found["constants"].as_array().unwrap();
    let one = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("no {name}: {found}"));
    [one["value"].as_f64().unwrap(), 3.0 * one["deviation"].as_f64().unwrap()]
}

#[test]
fn a_drive_tells_the_wheels_and_the_gyroscope_that_the_seed_drew() {
    let place = folder("calibrated_drive");
    fs::write(place.join("robot.toml"), ROBOT).unwrap();
    let scene = Scene::load(&place.join("robot.toml")).unwrap();
    for seed in 0..rounds(2, 10) {
        let run = ["run", "robot.toml", "--seed", &seed.to_string(), "--ros2", "--out", "out"];
        assert_eq!(outcome(&mut wherein(&place, &run)).0, 0);
        let log = format!("out/robot/{seed}/rosbag2");
        let found = calibrated(&place, &log, &["--out", "calibrated.toml"]);
        let (drawn, declared) = (Drawn::draw(&scene, seed), Scene::load(&place.join("calibrated.toml")).unwrap());
        let base = &declared.robot.base;
        println!("seed {seed}: {:?}, {found:#}", drawn.base);
        for (wheel, radius_m) in drawn.base.wheel_radius_m.into_iter().enumerate() {
            let [value_m, _] = constant(&found, ["radius of the left wheel", "radius of the right wheel"][wheel]);
            // The tyres creep by the force that drives them over their stiffness; rolling at a steady speed takes little.
            assert!((value_m / radius_m - 1.0).abs() < 3e-4, "seed {seed}: {value_m} for {radius_m}");
            let off = (radius_m / base.wheel_radius_m - 1.0).abs();
            assert!(off < base.wheel_radius_tolerance + 3e-4, "seed {seed}: {off} of {base:?}");
        }
        let off = (drawn.base.track_m / base.track_m - 1.0).abs();
        assert!(off < base.track_tolerance + 1e-3 && base.track_tolerance < 2e-3, "seed {seed}: {off} of {base:?}");
        let gyro = drawn.devices.gyro.unwrap();
        let [scale, within] = constant(&found, "scale of the gyroscope");
        assert!((scale - gyro.scale).abs() < 1.5 * within && within < 1e-3, "seed {seed}: {scale} for {}", gyro.scale);
        let [bias_deg_per_s, within] = constant(&found, "bias of the gyroscope");
        let off_deg_per_s = (bias_deg_per_s - gyro.bias_rad_per_s.to_degrees()).abs();
        assert!(off_deg_per_s < 1.5 * within && within < 0.01, "seed {seed}: {bias_deg_per_s} for {gyro:?}");
        // With what was found the same drive keeps every bound, by the replay's own comparison.
        let (code, told, errors) = outcome(&mut wherein(&place, &["replay", &log, "--robot", "calibrated.toml"]));
        assert_eq!(code, 0, "seed {seed}: {told}{errors}");
    }
}

#[test]
fn a_push_is_set_aside_and_moves_no_constant() {
    let place = folder("calibrated_pushed");
    let push = "[[event]]\nkind = \"push\"\nat_s = 40.5\ndisplacement_m = [0.0, 0.1]\nlasts_s = 0.3\n";
    fs::write(place.join("robot.toml"), ROBOT).unwrap();
    fs::write(place.join("pushed.toml"), format!("{ROBOT}{push}")).unwrap();
    let found = ["robot", "pushed"].map(|name| {
        let run = ["run", &format!("{name}.toml"), "--seed", "4", "--ros2", "--out", "out"];
        outcome(&mut wherein(&place, &run));
        calibrated(&place, &format!("out/{name}/4/rosbag2"), &[])
    });
    let aside = found[1]["set_aside"].as_array().unwrap();
    let is_push = |one: &&Value| one["from_s"].as_f64().unwrap() < 40.8 && one["to_s"].as_f64().unwrap() > 40.5;
    assert!(aside.iter().any(|one| one["what"] == "wheels" && is_push(&one)), "{:#}", found[1]);
    for name in ["radius of the left wheel", "radius of the right wheel", "track"] {
        let [[calm, _], [pushed, _]] = [0, 1].map(|one| constant(&found[one], name));
        assert!((pushed / calm - 1.0).abs() < 1e-3, "{name}: {pushed} for {calm}");
    }
    // No bound is made to cover the push.
    let least = |one: usize| found[one]["bounds"][1]["least"].as_f64().unwrap();
    assert!((least(1) - least(0)).abs() < 1e-3, "{} and {}", least(1), least(0));
}

#[test]
fn a_log_of_another_program_tells_its_slip_and_its_antenna() {
    let place = folder("calibrated_logs");
    let logs = root().join("tests/logs");
    fs::copy(logs.join("wheels.toml"), place.join("robot.toml")).unwrap();
    let log = logs.join("disorderly").display().to_string();
    let found = calibrated(&place, &log, &["--span-s", "0.4"]);
    // The wheels of that log turn by 0.3 % more than they roll, and the gyroscope has a bias of 0.05°/s.
    for wheel in ["radius of the left wheel", "radius of the right wheel"] {
        let [radius_m, within_m] = constant(&found, wheel);
        assert!((radius_m - 0.0975 / 1.003).abs() < 2.0 * within_m && within_m < 1e-4, "{wheel}: {radius_m}");
    }
    let [bias_deg_per_s, within] = constant(&found, "bias of the gyroscope");
    assert!((bias_deg_per_s - 0.05).abs() < 1.5 * within && within < 0.03, "{bias_deg_per_s} ± {within}");
    fs::copy(logs.join("odometry.toml"), place.join("robot.toml")).unwrap();
    let found = calibrated(&place, &logs.join("satellites").display().to_string(), &[]);
    for (name, place_m) in [("antenna, forward", 0.1), ("antenna, to the left", 0.0)] {
        let [value_m, within_m] = constant(&found, name);
        assert!((value_m - place_m).abs() < 1.5 * within_m && within_m < 0.01, "{name}: {value_m} ± {within_m}");
    }
    assert!(found["unknown"].to_string().contains("odometry in place of the wheels' angles"), "{found}");
}

#[test]
fn a_log_that_calibrates_nothing_is_refused_and_nothing_is_written() {
    let place = folder("calibrated_not");
    let logs = root().join("tests/logs");
    let without_truth = fs::read_to_string(logs.join("wheels.toml")).unwrap().replace("truth =", "# truth =");
    fs::write(place.join("blind.toml"), without_truth).unwrap();
    fs::copy(logs.join("wheels.toml"), place.join("robot.toml")).unwrap();
    let log = logs.join("wheels_mcap").display().to_string();
    for (robot, more, part) in [
        ("blind.toml", &[][..], "`log.truth` is missing"),
        (
            "robot.toml",
            &[],
            "wheels: 1 spans with true poses, expected at least 20, of a longer drive or by a smaller --span-s",
        ),
        ("missing.toml", &[], "missing.toml"),
        ("robot.toml", &["--span-s", "0"], "expected a number above 0"),
    ] {
        let command = [&["calibrate", "drive", &log, "--robot", robot, "--out", "out.toml"], more].concat();
        let (code, _, errors) = outcome(&mut wherein(&place, &command));
        assert!(code == 2 && errors.contains(part), "{robot} {more:?}: {code} {errors}");
        assert!(!place.join("out.toml").exists());
    }
    let before = fs::read(place.join("robot.toml")).unwrap();
    let command = ["calibrate", "drive", &log, "--robot", "robot.toml", "--out", "./robot.toml"];
    let (code, _, errors) = outcome(&mut wherein(&place, &command));
    assert!(
        code == 2 && errors.contains("write `--out ./robot.toml`: it is the scene of the robot itself"),
        "{errors}"
    );
    assert_eq!(fs::read(place.join("robot.toml")).unwrap(), before);
}
