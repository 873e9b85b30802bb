//! Tests of how much of the boxes is used (error over half of the width), and of what counts as available or as measured.

use interval::Interval;
use localizer::{PoseBox, PoseUnion, Status};
use serde_json::Value;
use sim::{
    run::{RunOptions, RunRecord, run},
    scene::Scene,
    subject::IntervalLocalizer,
};

use crate::{
    command::{blind_scene, folder, outcome, wherein},
    judging::verdict_of,
};

fn recorded(duration_s: f64, more: &str) -> (Scene, RunRecord) {
    let scene = Scene::parse(&blind_scene(duration_s, more), "scene.toml").unwrap();
    let record = run(&scene, 5, &mut IntervalLocalizer::of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    (scene, record)
}

/// Replaces the boxes of a record by boxes of ±1 about the truth; along x, the box of each step is moved by `off` for that step.
fn with_boxes(record: &mut RunRecord, off: impl Fn(usize) -> f64) {
    for (step, (estimate, truth)) in record.estimates.iter_mut().zip(&record.truths).enumerate() {
        let [x_m, y_m, heading_rad] = truth.pose.to_array();
        let sides = [x_m + off(step), y_m, heading_rad].map(|middle| Interval::centred(middle, 1.0));
        estimate.pose = PoseUnion::single(PoseBox::from(sides));
        estimate.status = Status::Sound;
    }
}

#[test]
fn power_is_the_greatest_error_over_half_the_width_and_what_one_step_in_a_thousand_exceeds() {
    let (scene, mut record) = recorded(20.0, "");
    // In all but two of 2 001 steps the error is 0.25 of half of the box's width; it is 0.9 once before 5 s and 0.8 once after that. The
    // 0.999 quantile is at rank 0.999 · 2 001 = 1 998.999.
    with_boxes(&mut record, |step| match step {
        100 => 0.9,
        1000 => -0.8,
        _ => 0.25,
    });
    let power = verdict_of(&scene, &record).power.unwrap();
    let is = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value}, expected {expected}");
    is(power.over_all.x_m.max, 0.9);
    is(power.over_all.x_m.p999, 0.25);
    is(power.over_all.y_m.max, 0.0);
    // From 5 s on there are 1 501 steps, so that the 0.999 quantile is at rank 0.999 · 1 501 = 1 499.5.
    is(power.after_5_s.x_m.max, 0.8);
    is(power.after_5_s.x_m.p999, 0.25);
}

#[test]
fn a_step_counts_as_available_only_with_the_truth_inside() {
    let (scene, mut record) = recorded(1.0, "[localizer]\ndeclared_width_m = 1.5\ndeclared_width_deg = 350.0\n");
    // In the last 51 of 101 steps the boxes are 2 mm wide and their middles are off by 1.1 mm, so that they do not contain the true pose.
    for (step, (estimate, truth)) in record.estimates.iter_mut().zip(&record.truths).enumerate() {
        let [x_m, y_m, heading_rad] = truth.pose.to_array();
        let off_m = if step < 50 { 0.0 } else { 0.0011 };
        let sides = [x_m + off_m, y_m, heading_rad].map(|middle| Interval::centred(middle, 0.001));
        estimate.pose = PoseUnion::single(PoseBox::from(sides));
    }
    let availability = verdict_of(&scene, &record).availability.unwrap();
    assert!((availability - 50.0 / 101.0).abs() < 1e-12, "{availability}");
}

#[test]
fn what_was_not_measured_is_null_and_meets_no_expectation() {
    let place = folder("never_fixed");
    let scene = blind_scene(
        2.0,
        "[expect]\nwidth.at_fix.x_m.mean_max = 0.001\nerror.at_fix.x_m.rmse_max = 0.001\n\
         error.at_fix.x_m.rmse_worst_third_max = 0.001\npower.after_5_s.x_m.max_max = 1.0\npower.x_m.max_max = 1.0\n",
    );
    std::fs::write(place.join("scene.toml"), scene).unwrap();
    let (code, output, errors) = outcome(&mut wherein(&place, &["run", "scene.toml", "--json"]));
    assert_eq!(code, 1, "{errors}");
    let summary: Value = serde_json::from_str::<Value>(&output).unwrap()[0].clone();
    for figure in [
        &summary["width"]["at_fix"]["x_m"]["mean"],
        &summary["error"]["at_fix"]["x_m"]["rmse"],
        &summary["power"]["after_5_s"]["x_m"]["max"],
    ] {
        assert_eq!(figure, &Value::Null, "{summary:#}");
    }
    let missed = summary["verdict"]["failed"].as_array().unwrap();
    assert_eq!(missed.len(), 4, "{missed:?}");
    assert!(missed.iter().all(|line| line.as_str().unwrap().contains("did not measure")), "{missed:?}");
    assert!(summary["power"]["x_m"]["max"].as_f64().unwrap() < 1.0);
}
