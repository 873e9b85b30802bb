//! Tests of keys that have moved: a scene of an older version is refused with the new names, and `wherein upgrade` rewrites it.

use std::fs;

use sim::loading::{SceneTemplate, Setting, UpgradeError, upgraded};
use sim::scene::Scene;

use crate::command::{folder_of, outcome, wherein};

/// A scene as older versions had it, with comments.
const OLDER: &str = r#"# A narrow robot.
duration_s = 1.0

[floor]

[robot]
# Measured with a tape.
track_m = 0.2 # from tyre to tyre
wheel_radius_tolerance = 0.001
floor_camera = false
caster_stiffness = 0.5

[robot.gyro]
period_s = 0.02

[localizer]
methods = []

[room]
width_m = 3.0
depth_m = 2.0

[start]
x_m = 0.6
y_m = 0.6

[[route.waypoint]]
x_m = 2.4
y_m = 1.2
"#;

/// The same scene as this version has it, written by hand.
const NOW: &str = r#"# A narrow robot.
duration_s = 1.0

[floor]

[robot]
floor_camera = false

[robot.base]
wheel_radius_tolerance = 0.001
# Measured with a tape.
track_m = 0.2 # from tyre to tyre

[robot.base.differential]
caster_stiffness = 0.5

[robot.gyro]
period_s = 0.02

[localizer]
methods = []

[room]
width_m = 3.0
depth_m = 2.0

[start]
x_m = 0.6
y_m = 0.6

[[route.waypoint]]
x_m = 2.4
y_m = 1.2
"#;

#[test]
fn keys_and_their_comments_are_put_where_they_stand_now() {
    let result = upgraded(OLDER).unwrap();
    assert_eq!(result.text, NOW);
    let before: Vec<&str> = result.moved.iter().map(|(before, _)| *before).collect();
    assert_eq!(before, ["robot.wheel_radius_tolerance", "robot.track_m", "robot.caster_stiffness"]);
    let robot = Scene::parse(&result.text, "scene.toml").unwrap().robot;
    assert_eq!((robot.base.track_m, robot.base.differential.caster_stiffness), (0.2, 0.5));
}

#[test]
fn every_style_of_table_is_understood_and_kept() {
    for (older, now) in [
        ("robot.track_m = 0.2\nrobot.gyro = true\n", "robot.gyro = true\nrobot.base.track_m = 0.2\n"),
        ("robot = { track_m = 0.2, gyro = true }\n", "robot = { gyro = true, base = { track_m = 0.2 } }\n"),
        (
            "[robot]\ntrack_m = 0.2\nbase = { wheel_radius_m = 0.1 }\n",
            "[robot]\nbase = { wheel_radius_m = 0.1, track_m = 0.2 }\n",
        ),
        (
            "[robot.base]\nwheel_radius_m = 0.1\n[robot]\ntrack_m = 0.2\n",
            "[robot.base]\nwheel_radius_m = 0.1\ntrack_m = 0.2\n[robot]\n",
        ),
    ] {
        let result = upgraded(older).unwrap();
        let value = |text: &str| text.parse::<toml::Table>().unwrap();
        assert_eq!(value(&result.text), value(now), "{older} became {}", result.text);
        assert_eq!(upgraded(&result.text).unwrap().moved, []);
    }
}

#[test]
fn what_has_not_moved_stays_to_the_byte() {
    let text = "# CRLF\r\nduration_s = 1.0\r\n[floor]\r\n";
    assert_eq!(upgraded(text).unwrap().text, text);
}

#[test]
fn what_cannot_be_moved_is_refused() {
    let twice = upgraded("[robot]\ntrack_m = 0.2\nbase = { track_m = 0.3 }\n");
    assert!(matches!(twice, Err(UpgradeError::Twice { before: "robot.track_m", now: "robot.base.track_m" })));
    let no_table = upgraded("[robot]\ntrack_m = 0.2\nbase = 3\n");
    assert!(matches!(no_table, Err(UpgradeError::NoTable { at: "base", .. })));
    assert!(matches!(upgraded("[robot\n"), Err(UpgradeError::NotToml(_))));
}

#[test]
fn an_older_scene_is_refused_with_the_new_names() {
    let error = Scene::parse(OLDER, "scene.toml").unwrap_err().to_string();
    for expected in ["`robot.track_m`: moved, expected `robot.base.track_m`", "`wherein upgrade SCENE`"] {
        assert!(error.contains(expected), "{error}");
    }
    let folder = folder_of("moved_setting", &[("scene.toml", NOW)]);
    let setting: Setting = "robot.track_m=0.3".parse().unwrap();
    let error = SceneTemplate::load(&folder.join("scene.toml")).unwrap().with(&[setting]).unwrap_err().to_string();
    assert!(error.contains("expected one such as `robot.base.track_m`"), "{error}");
}

#[test]
fn the_hint_names_the_extended_file_that_holds_the_old_key() {
    let scene = format!("extends = \"old.base.toml\"\n{}", NOW.replace("track_m = 0.2 # from tyre to tyre\n", ""));
    let files = [("scene.toml", scene.as_str()), ("old.base.toml", "[robot]\ntrack_m = 0.2\n")];
    let folder = folder_of("moved_in_a_base", &files);
    let error = Scene::load(&folder.join("scene.toml")).unwrap_err().to_string();
    let base = folder.join("old.base.toml");
    assert!(error.contains(&format!("`wherein upgrade {}` rewrites a scene", base.display())), "{error}");
    let (code, _, errors) = outcome(&mut wherein(&folder, &["upgrade", base.to_str().unwrap()]));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(Scene::load(&folder.join("scene.toml")).unwrap().robot.base.track_m, 0.2);
}

#[test]
fn the_command_rewrites_files_and_folders_or_none_of_them() {
    let folder = folder_of(
        "upgrade",
        &[("all/x.toml", OLDER), ("all/lab.base.toml", "[robot]\ntrack_m = 0.2\n"), ("y.toml", NOW)],
    );
    let (code, text, errors) = outcome(&mut wherein(&folder, &["upgrade", "all", "y.toml"]));
    assert_eq!(code, 0, "{errors}");
    assert!(text.contains("all/x.toml: robot.track_m is now robot.base.track_m\n"), "{text}");
    assert!(text.contains("y.toml: nothing to change\n"), "{text}");
    assert_eq!(fs::read_to_string(folder.join("all/x.toml")).unwrap(), NOW);
    assert!(fs::read_to_string(folder.join("all/lab.base.toml")).unwrap().contains("[robot.base]\ntrack_m = 0.2\n"));

    fs::write(folder.join("all/x.toml"), OLDER).unwrap();
    fs::write(folder.join("all/y.toml"), "[robot]\ntrack_m = 0.2\nbase = { track_m = 0.3 }\n").unwrap();
    let (code, _, errors) = outcome(&mut wherein(&folder, &["upgrade", "all"]));
    assert_eq!(code, 2);
    assert!(errors.contains("all/y.toml") && errors.contains("both are stated"), "{errors}");
    assert_eq!(fs::read_to_string(folder.join("all/x.toml")).unwrap(), OLDER);
}
