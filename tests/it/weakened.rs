//! What becomes of a run when the localizer is given narrower bounds than those that hold.

use localizer::PoseUnion;
use serde_json::Value;
use sim::{
    campaign::weaken::{Lost, weaken},
    loading::SceneFile,
    run::{RunOptions, RunRecord, run},
    scene::{Bounds, Distribution, Scene},
    subject::IntervalLocalizer,
};

use crate::{
    command::{blind_scene, folder, outcome, root, wherein},
    judging::verdict_of,
};

/// A drive straight on from an exactly known start: both wheel radii are 1 % off, and 0.8 % of slip is declared in addition.
fn cornered(more: &str) -> (Scene, RunRecord) {
    let text = blind_scene(6.0, &format!("[bounds]\nslip_ratio = 0.008\n[localizer]\nmethods = []\n{more}"))
        .replace(
            "floor_camera = false",
            "floor_camera = false\nerrors = \"corner\"\nbase.wheel_radius_tolerance = 0.01",
        )
        .replace("x_m = 0.6\ny_m = 0.6", "x_m = 0.6\ny_m = 0.6\ntolerance_m = 0.0\ntolerance_deg = 0.0")
        .replace("y_m = 1.2", "y_m = 0.6");
    let scene = Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let record = run(&scene, 5, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    (scene, record)
}

#[test]
fn told_ever_narrower_bounds_a_run_loses_the_truth_where_they_end() {
    // By hand: the distance driven is off by 1 %, while 1 % of wheel radius and 0.8 % of slip are declared. If all declared bounds are scaled down by
    // one factor, the box contains the true pose down to a factor of 1 / 1.8 = 0.56, or a little less because constant parts of the slip bounds are
    // declared too. So it still contains it at 0.6, and 0.5 or 0.4 is the first factor tried that loses it.
    let (scene, record) = cornered("");
    let verdict = verdict_of(&scene, &record);
    assert_eq!(
        verdict.containment.as_ref().unwrap().contained,
        verdict.containment.as_ref().unwrap().checks,
        "{:?}",
        verdict.violations
    );
    let weakened = weaken(&scene, &record, &IntervalLocalizer::boxed, None, &mut |_, _| {}).unwrap();
    let (factor, tightness) = (weakened.factor.unwrap(), weakened.tightness.unwrap());
    assert!([0.4, 0.5].contains(&factor) && (tightness * factor - 1.0).abs() < 1e-12, "{weakened:?}");
    assert_eq!(weakened.lost, Some(Lost::Outside));
    // Here ten times the slip is declared and no more occurs, so that the true pose is kept until the declared bounds are scaled down to about 1 / 9.
    let loose = Scene { bounds: Bounds { slip_ratio: 0.08, ..scene.bounds.clone() }, ..scene };
    let narrower =
        run(&loose, 5, &mut IntervalLocalizer::of(&loose), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let weakened = weaken(&loose, &narrower, &IntervalLocalizer::boxed, None, &mut |_, _| {}).unwrap();
    assert!(weakened.factor.is_none_or(|loose| loose <= 0.2), "{weakened:?}");
}

#[test]
fn a_run_that_loses_the_truth_anyway_is_lost_at_its_own_bounds() {
    let (scene, record) =
        cornered("[[event]]\nkind = \"push\"\nat_s = 1.0\ndisplacement_m = [0.0, 0.15]\nlasts_s = 0.3\n");
    let weakened = weaken(&scene, &record, &IntervalLocalizer::boxed, None, &mut |_, _| {}).unwrap();
    assert_eq!((weakened.factor, weakened.tightness), (Some(1.0), Some(1.0)));
    // The box misses the true pose from the push at 1 s on, but such a loss counts only in the second half of the drive of 6 s.
    assert_eq!((weakened.counted_after_s, weakened.lost_at_s), (3.0, Some(3.0)), "{weakened:?}");
}

#[test]
fn what_is_lost_before_a_method_has_told_anything_and_held_again_since_does_not_count() {
    let (scene, record) = cornered("");
    let lost_to = |share: f64| {
        let mut record =
            run(&scene, 5, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
        let n_lost = (share * record.estimates.len() as f64) as usize;
        record.estimates[1..n_lost].iter_mut().for_each(|estimate| estimate.pose = PoseUnion::default());
        weaken(&scene, &record, &IntervalLocalizer::boxed, None, &mut |_, _| {}).unwrap()
    };
    assert_eq!(lost_to(0.4), weaken(&scene, &record, &IntervalLocalizer::boxed, None, &mut |_, _| {}).unwrap());
    let late = lost_to(0.6);
    assert_eq!((late.factor, late.lost_at_s, late.lost), (Some(1.0), Some(3.0), Some(Lost::Empty)));
}

#[test]
fn landmarks_in_a_drift_are_not_lost_by_the_first_steps_of_wheels_and_gyroscope() {
    let path = root().join("scenes/papers/rigid_transform_loop.toml");
    let mut scene = SceneFile::load_all(&[path]).unwrap().remove(0).scene;
    (scene.duration_s, scene.robot.errors) = (12.0, Distribution::Drift);
    let record = run(&scene, 0, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let weakened = weaken(&scene, &record, &IntervalLocalizer::boxed, None, &mut |_, _| {}).unwrap();
    println!("{weakened:?}");
    assert_eq!(weakened.counted_after_s, 5.0);
    assert!(weakened.lost_at_s.is_none_or(|lost_at_s| lost_at_s >= 5.0 - 1e-6), "{weakened:?}");
}

#[test]
fn the_command_prints_how_tight_bounds_are() {
    let place = folder("weaken");
    std::fs::write(place.join("scene.toml"), blind_scene(2.0, "")).unwrap();
    let arguments = ["weaken", "scene.toml", "--seeds", "0..2", "--set", "robot.errors=corner", "--json"];
    let (code, output, errors) = outcome(&mut wherein(&place, &arguments));
    assert_eq!(code, 0, "{errors}");
    let rows: Value = serde_json::from_str(&output).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 2);
    for row in rows.as_array().unwrap() {
        let weakened = &row["weakened"];
        assert!(weakened["factor"].as_f64().is_none_or(|factor| (0.1..1.0).contains(&factor)), "{rows:#}");
        assert_eq!(weakened["factor"].is_null(), weakened["lost"].is_null());
    }
    let (_, table, _) = outcome(&mut wherein(&place, &arguments[..6]));
    assert!(table.lines().next().unwrap().ends_with("lost at"), "{table}");
    assert!(table.starts_with("scene") && table.lines().count() == 3, "{table}");
}

#[test]
fn a_drive_too_short_to_lose_anything_in_is_said_to_be_too_short() {
    let place = folder("weaken_too_short");
    let scene = blind_scene(1.0, "").replace("x_m = 0.6\ny_m = 0.6\n", "x_m = 0.6\ny_m = 0.6\ntolerance_m = 0.1\n");
    std::fs::write(place.join("scene.toml"), scene).unwrap();
    let (code, table, errors) = outcome(&mut wherein(&place, &["weaken", "scene.toml"]));
    assert_eq!(code, 0, "{errors}");
    assert!(table.contains("too short to tell: losses count after 0.50 s"), "{table}");
    assert!(!table.contains("never"), "{table}");
}
