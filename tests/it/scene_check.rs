use std::{fs, path::Path};

use serde_json::Value;

use crate::command::{blind_scene, folder, outcome, root, rounds, wherein};

/// Writes the hall of the book's first tutorial into a folder.
fn write_hall(place: &Path) {
    let page = fs::read_to_string(root().join("docs/src/ci.md")).unwrap();
    let hall = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    fs::write(place.join("hall.toml"), hall).unwrap();
}

/// Exit code and JSON of `wherein check`.
fn checked(place: &Path, more: &[&str]) -> (i32, Value) {
    let (code, json, errors) = outcome(&mut wherein(place, &[&["check", "hall.toml", "--json"], more].concat()));
    (code, serde_json::from_str(&json).unwrap_or_else(|_| panic!("{errors}")))
}

/// The doubts of a check, one a line.
fn doubts(found: &Value) -> String {
    found["doubts"].as_array().unwrap().iter().map(|doubt| doubt.as_str().unwrap().to_owned() + "\n").collect()
}

#[test]
fn nothing_is_doubtful_in_the_tutorials_hall() {
    let place = folder("check_hall");
    write_hall(&place);
    let (code, found) = checked(&place, &[]);
    assert_eq!((code, doubts(&found)), (0, String::new()));
    let pictures = &found["pictures"];
    // From (1, 1) by (5, 0.8) to (4.8, 3.2) it is 4.005 m and 2.408 m, and somewhat more around the desk.
    let way_m = pictures["way_m"].as_f64().unwrap();
    assert!(way_m > 6.41 && way_m < 8.0, "{way_m} m");
    assert_eq!(pictures["n_places"], 24);
    let camera = &pictures["cameras"][0];
    assert_eq!(camera["camera"], "ceiling");
    assert_eq!(camera["markers_in_view"], camera["markers_read"]);
    // The layout has one marker in view from everywhere.
    assert_eq!((&camera["pictures_with_marker"], &camera["methods"][0]["constraints"]), (&24.into(), &24.into()));
    assert!(camera["markers_in_view"].as_u64().unwrap() >= 24);
    assert_eq!((&camera["methods"][0]["false_claims"], &pictures["places_with_constraint"]), (&0.into(), &24.into()));
    assert_eq!(pictures["without_position"], serde_json::json!([]));
    let (code, text, _) = outcome(&mut wherein(&place, &["check", "hall.toml"]));
    assert!(code == 0 && text.contains("24 of 24 pictures") && text.ends_with("Nothing is doubtful.\n"), "{text}");
}

#[test]
fn exposures_and_ceilings_that_hide_the_markers_are_doubtful() {
    let place = folder("check_doubts");
    write_hall(&place);
    for blinding in ["sensor.exposure_s=0.00001", "lens.defocus_px=5"].into_iter().take(rounds(1, 2)) {
        let (code, found) = checked(&place, &["--set", &format!("robot.ceiling_camera.{blinding}")]);
        assert_eq!(code, 1);
        assert!(doubts(&found).contains("`robot.ceiling_camera`: 0 of 45 markers in view are read"), "{found}");
        assert!(doubts(&found).contains("learns nothing about the pose from any of 24 pictures"), "{found}");
        assert!(!doubts(&found).contains("[markers.layout]"), "{found}");
    }
    // A single marker in a corner is out of view from nearly everywhere.
    let hall = fs::read_to_string(place.join("hall.toml")).unwrap();
    let alone = "[[markers.marker]]\nid = 125\nx_m = 0.3\ny_m = 0.3\n";
    fs::write(place.join("hall.toml"), hall.replace("[markers]\n[markers.layout]\n", alone)).unwrap();
    let (code, found) = checked(&place, &[]);
    assert_eq!(code, 1);
    assert!(doubts(&found).contains("places some method learns something about the pose"), "{found}");
    assert!(doubts(&found).contains("[markers.layout]"), "{found}");
    // The camera looks straight up, and the way begins a metre beside the marker.
    let without = found["pictures"]["without_position"].as_array().unwrap();
    let n_without: u64 = without.iter().map(|stretch| stretch["n_places"].as_u64().unwrap()).sum();
    assert!(n_without > 12, "{found}");
    let last = without.last().unwrap();
    assert_eq!((&last["along_way_m"][1], &last["n_with_heading"]), (&found["pictures"]["way_m"], &0.into()), "{found}");
    let (_, text, _) = outcome(&mut wherein(&place, &["check", "hall.toml"]));
    assert!(text.contains("No picture bounds the position from "), "{text}");
}

#[test]
fn pictures_that_are_white_are_doubtful() {
    let place = folder("check_white");
    let keys = "[robot.floor_camera]\n[floor.tiles]\n[light]\nilluminance_at_floor_lux = 1000.0\n";
    let scene = blind_scene(1.0, "").replace("floor_camera = false\n", "") + keys;
    fs::write(place.join("hall.toml"), &scene).unwrap();
    let (code, found) = checked(&place, &[]);
    assert_eq!((code, doubts(&found)), (0, String::new()));
    let (code, found) = checked(&place, &["--set", "robot.floor_camera.sensor.exposure_s=0.15"]);
    assert_eq!(code, 1);
    assert!(doubts(&found).contains("`robot.floor_camera`: up to"), "{found}");
    assert!(found["pictures"]["cameras"][0]["white_share_max"].as_f64().unwrap() > 0.5, "{found}");
}

#[test]
fn a_scene_without_cameras_is_checked_without_pictures() {
    let place = folder("check_blind");
    fs::write(place.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    let (code, text, _) = outcome(&mut wherein(&place, &["check", "scene.toml"]));
    assert_eq!(code, 1);
    assert!(text.contains("has no camera") && text.contains("`floor_tiles` has nothing to read"), "{text}");
    fs::write(place.join("scene.toml"), "duration_s = -1.0\n").unwrap();
    let (code, _, errors) = outcome(&mut wherein(&place, &["check", "scene.toml"]));
    assert!(code == 2 && errors.contains("duration_s"), "{errors}");
}
