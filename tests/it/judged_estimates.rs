use std::{fs, path::Path};

use serde_json::Value;

use crate::command::{blind_scene, folder, outcome, wherein};

/// Exit code, text or JSON, and errors of `wherein judge` for a file of estimates.
fn judged(place: &Path, file: &str, more: &[&str]) -> (i32, String, String) {
    outcome(&mut wherein(place, &[&["judge", "out/scene/0/recording.mcap", "--estimate", file], more].concat()))
}

#[test]
fn estimates_of_a_file_are_judged_as_the_run_judged_its_own() {
    let place = folder("judged_estimates");
    // The robot is pushed aside, which breaks the bound on slip; nothing measures its position after that.
    let pushed = "[[event]]\nkind = \"push\"\nat_s = 1.0\ndisplacement_m = [0.0, 0.3]\nlasts_s = 0.5\n";
    fs::write(place.join("scene.toml"), blind_scene(4.0, pushed)).unwrap();
    let (_, _, errors) = outcome(&mut wherein(&place, &["run", "scene.toml", "--record", "--out", "out"]));
    let run = place.join("out/scene/0");
    let summary: Value = serde_json::from_str(&fs::read_to_string(run.join("summary.json")).expect(&errors)).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();

    let (code, json, errors) = judged(&place, "out/scene/0/boxes.csv", &["--json"]);
    let found: Value = serde_json::from_str(&json).unwrap_or_else(|_| panic!("{errors}"));
    let containment = &found["containment"];
    assert_eq!(containment["checks"], summary["containment"]["checks"]);
    assert_eq!(containment["contained"], summary["containment"]["contained"]);
    assert_eq!(code, i32::from(containment["outside"] != 0));
    assert!(number(&containment["outside"]) > 20.0, "the push is not seen: {found}");
    let at_s = |value: &Value| number(&value["time_s"]);
    let (first, of_run) = (&containment["first_outside"], &summary["containment"]["first_failure"]);
    assert!((at_s(first) - at_s(of_run)).abs() < 1e-6, "{first} {of_run}");
    for axis in ["x_m", "y_m", "heading_rad"] {
        let (mine, own) = (number(&found["error"][axis]["rmse"]), number(&summary["error"][axis]["rmse"]));
        assert!((mine - own).abs() < 1e-9, "{axis}: {mine} for {own}");
        let (mine, own) = (number(&found["mean_width"][axis]), number(&summary["width"][axis]["mean"]));
        assert!((mine - own).abs() < 1e-9, "{axis}: {mine} for {own}");
    }
    let broken = found["broken_bounds"].as_array().unwrap();
    assert_eq!(broken.len(), summary["violations"].as_array().unwrap().len());
    assert!(broken.iter().any(|one| one.as_str().unwrap().contains("slip")), "{broken:?}");

    // Poses promise no region, and their error is that of the middles.
    let (code, text, errors) = judged(&place, "out/scene/0/estimate.tum", &[]);
    assert!(code == 0 && !text.contains("inside the boxes") && text.contains("RMSE"), "{text}{errors}");
    // A heading that is off by whole turns is right.
    let boxes = fs::read_to_string(run.join("boxes.csv")).unwrap();
    let turned: Vec<String> = boxes
        .lines()
        .map(|line| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            for field in &mut fields[7..9] {
                if let Ok(rad) = field.parse::<f64>() {
                    *field = (rad + 4.0 * std::f64::consts::PI).to_string();
                }
            }
            fields.join(",")
        })
        .collect();
    fs::write(place.join("turned.csv"), turned.join("\n")).unwrap();
    let again: Value = serde_json::from_str(&judged(&place, "turned.csv", &["--json"]).1).unwrap();
    assert_eq!(again["containment"]["contained"], containment["contained"]);
}

#[test]
fn what_cannot_be_judged_is_refused_with_file_and_expectation() {
    let place = folder("judged_refused");
    fs::write(place.join("scene.toml"), blind_scene(0.5, "")).unwrap();
    assert_eq!(outcome(&mut wherein(&place, &["run", "scene.toml", "--record", "--out", "out"])).0, 0);
    let head = "time_s,x_min_m,x_max_m,y_min_m,y_max_m,heading_min_rad,heading_max_rad\n";
    fs::write(place.join("late.csv"), format!("{head}1700000000,0,1,0,1,0,1\n")).unwrap();
    fs::write(place.join("short.csv"), format!("{head}0.1,0,1,0\n")).unwrap();
    fs::write(place.join("words.tum"), "0.1 here 0 0 0 0 0 1\n").unwrap();
    for (file, told) in [
        ("late.csv", "expected seconds since the begin of the run, which has true poses from 0.000 s to 0.500 s"),
        ("short.csv", "fields"),
        ("words.tum", "line 1: a word is no number, expected eight finite numbers"),
        ("none.tum", "No such file"),
    ] {
        let (code, output, errors) = judged(&place, file, &[]);
        assert!(code == 2 && output.is_empty() && errors.contains(told) && errors.contains(file), "{file}: {errors}");
    }
    let (code, _, errors) = outcome(&mut wherein(&place, &["judge", "scene.toml", "--estimate", "late.csv"]));
    assert!(code == 2 && errors.contains("expected an MCAP file that `wherein run --record` wrote"), "{errors}");
}
