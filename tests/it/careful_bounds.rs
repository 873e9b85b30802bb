//! Tests of the bounds that a careful user can know: they apply where a scene states none, errors are drawn within them, and they are kept in six
//! scenes.

use serde_json::Value;
use sim::{
    judge::Verdict,
    loading::{SceneTemplate, Setting},
    render::Renderer,
    run::{RunOptions, run},
    scene::Scene,
    subject::IntervalLocalizer,
};

use crate::{command::root, judging::verdict_of};

fn parse(top: &str, more: &str) -> Scene {
    let text = format!(
        "{top}\n[room]\nwidth_m = 8\ndepth_m = 6\n[start]\nx_m = 2\ny_m = 3\nheading_deg = 0\n\
         [[route.waypoint]]\nx_m = 4\ny_m = 3\n[expect]\nunsound = 0\n{more}"
    );
    Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

const CAREFUL: &str = "bounds_from = \"careful_user\"";
const THROUGHOUT: &str = "bounds_from = \"careful_user_throughout\"";

#[test]
fn what_a_scene_states_stays_and_all_else_is_a_careful_users() {
    let stated = "[robot.floor_camera]\nyaw_tolerance_deg = 0.05\n[bounds]\nbody_tilt_deg = 0.9\n[floor.tiles]\n";
    let scene = parse(CAREFUL, stated);
    let camera = scene.robot.floor_camera.as_ref().unwrap();
    assert_eq!((camera.yaw_tolerance_deg, camera.tilt_tolerance_deg, camera.stamp_tolerance_s), (0.05, 0.3, 0.001));
    assert_eq!((scene.bounds.body_tilt_deg, scene.bounds.body_heave_m), (0.9, 0.0008));
    assert_eq!(scene.floor.tiles.as_ref().unwrap().laying_tolerance_m, 0.003);
    assert!(scene.robot.gyro.is_none() && scene.robot.flow.is_none() && scene.robot.forward_camera.is_none());
    // Keys of the scene that are no tolerances are unchanged by the choice of bounds: camera height and track are still those of the P3-DX robot.
    assert_eq!((camera.height_m, scene.robot.base.track_m), (0.25, 0.33));

    let throughout = parse(THROUGHOUT, stated);
    assert_eq!(throughout.robot.floor_camera.unwrap().yaw_tolerance_deg, 0.3);
    assert_eq!(throughout.bounds.body_tilt_deg, 0.9);
}

#[test]
fn each_device_that_a_scene_or_its_preset_has_is_careful_and_no_other_one() {
    let fitted = parse(CAREFUL, "[robot]\ngyro = true\nfloor_camera = false\nrange_camera = true\n");
    assert!(fitted.robot.floor_camera.is_none() && fitted.robot.flow.is_none());
    assert_eq!(fitted.robot.gyro.unwrap().scale_tolerance, 0.01);
    assert_eq!(fitted.robot.range_camera.unwrap().column_noise_px, 0.3);
    let vacuum = parse(CAREFUL, "[robot]\npreset = \"vacuum\"\n").robot;
    assert!(vacuum.floor_camera.is_none() && vacuum.base.track_m == 0.23);
    assert_eq!((vacuum.gyro.unwrap().noise_redrawn, vacuum.flow.unwrap().scale_tolerance), (false, 0.03));
}

#[test]
fn noise_that_a_scene_states_in_part_is_not_mixed_with_a_careful_users() {
    let gyro = parse(CAREFUL, "[robot.gyro]\nnoise_deg_per_s = 0.02\n").robot.gyro.unwrap();
    assert!(gyro.noise_redrawn && gyro.angle_floor_deg.is_none() && gyro.noise_deg_per_s == 0.02);
    assert_eq!(gyro.bias_tolerance_deg_per_s, 0.1);
    let gyro = parse(THROUGHOUT, "[robot.gyro]\nnoise_deg_per_s = 0.02\n").robot.gyro.unwrap();
    assert!(!gyro.noise_redrawn && gyro.angle_floor_deg == Some(0.06) && gyro.noise_deg_per_s == 0.6);
}

#[test]
fn a_scene_that_says_nothing_of_its_bounds_has_those_of_a_laboratory() {
    let everything = "[robot]\ngyro = true\nflow = true\n[floor.tiles]\n";
    let [silent, stated] =
        ["", "bounds_from = \"laboratory\""].map(|top| serde_json::to_value(parse(top, everything)).unwrap());
    assert_eq!(silent, stated);
    assert_eq!(silent["robot"]["floor_camera"]["yaw_tolerance_deg"], 0.1);
}

#[test]
fn no_bound_of_a_careful_user_is_narrower_than_a_laboratorys() {
    let everything = "[robot]\ngyro = true\nflow = true\nforward_camera = true\nceiling_camera = true\nrange_camera = true\n\
                      [floor.tiles]\n[markers]\n[localizer]\nmethods = [\"floor_tiles\", \"wall_directions\"]\n\
                      [localizer.wall_directions]\n";
    let [laboratory, careful] = ["", CAREFUL].map(|top| serde_json::to_value(parse(top, everything)).unwrap());
    fn walk(path: &str, laboratory: &Value, careful: &Value, n_wider: &mut usize) {
        match (laboratory, careful) {
            (Value::Object(one), Value::Object(other)) => {
                for (key, value) in one {
                    walk(&format!("{path}.{key}"), value, &other[key], n_wider);
                }
            }
            _ => {
                if let Some((one, other)) = laboratory.as_f64().zip(careful.as_f64()) {
                    assert!(other >= one, "{path}: {other} is narrower than {one}");
                    *n_wider += usize::from(other > one);
                }
            }
        }
    }
    let mut n_wider = 0;
    walk("", &laboratory, &careful, &mut n_wider);
    assert!(n_wider > 40, "only {n_wider} bounds are wider");
}

#[test]
fn a_key_that_names_no_bounds_is_refused() {
    let text = "bounds_from = \"hope\"\n[room]\nwidth_m = 8\ndepth_m = 6\n[start]\nx_m = 2\ny_m = 3\n";
    let shown = Scene::parse(text, "scene.toml").unwrap_err().to_string();
    assert!(shown.contains("laboratory") && shown.contains("careful_user"), "{shown}");
}

/// A scene of the repository, shortened to `duration_s`. Bounds that it states more narrowly than a careful user can know them are widened to what
/// such a user can know.
fn careful(path: &str, duration_s: f64, errors: &str) -> Scene {
    let settings: Vec<Setting> = [
        "bounds_from=careful_user_throughout".to_owned(),
        format!("duration_s={duration_s}"),
        format!("robot.errors={errors}"),
    ]
    .iter()
    .map(|setting| setting.parse().unwrap())
    .collect();
    let template = SceneTemplate::load(&root().join("scenes").join(path)).unwrap();
    template.with(&settings).unwrap_or_else(|error| panic!("failed to {error}")).scene
}

fn judged(scene: &Scene, seed: u64) -> Verdict {
    let mut renderer = scene.has_camera().then(|| Renderer::new().unwrap());
    let record =
        run(scene, seed, &mut IntervalLocalizer::of(scene), renderer.as_mut(), &RunOptions::default(), &mut |_| {})
            .unwrap();
    verdict_of(scene, &record)
}

fn assert_sound(path: &str, duration_s: f64) {
    for (errors, seed) in [("uniform", 51), ("drift", 52)] {
        let verdict = judged(&careful(path, duration_s, errors), seed);
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!(containment.contained, containment.checks, "{path}, {errors}: {containment:?}");
        assert!(verdict.violations.is_empty(), "{path}, {errors}: {:?}", verdict.violations);
    }
}

#[test]
fn tiles_hold_the_truth_with_bounds_that_a_person_can_know() {
    assert_sound("tiles.toml", 6.0);
}

#[test]
fn a_loop_among_landmarks_holds_the_truth_with_bounds_that_a_person_can_know() {
    assert_sound("papers/rigid_transform_loop.toml", 20.0);
}

#[test]
fn a_laboratory_holds_the_truth_with_bounds_that_a_person_can_know() {
    assert_sound("papers/ir_markers_lab.toml", 25.0);
}

#[test]
fn a_dark_carpet_holds_the_truth_with_bounds_that_a_person_can_know() {
    assert_sound("dark/carpet.toml", 6.0);
}

#[test]
fn a_home_holds_the_truth_with_bounds_that_a_person_can_know() {
    assert_sound("home.toml", 6.0);
}

#[test]
fn a_bent_lens_with_a_rolling_shutter_holds_the_truth_with_bounds_that_a_person_can_know() {
    assert_sound("floor/bent_rolling_lens.toml", 6.0);
}
