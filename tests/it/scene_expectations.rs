use serde_json::json;
use sim::scene::Scene;

use crate::command::blind_scene;

fn missed(expectations: &str, summary: &serde_json::Value) -> Vec<String> {
    let text = blind_scene(10.0, &format!("[expect]\n{expectations}\n"));
    Scene::parse(&text, "scene.toml").unwrap().expect.evaluate(summary).failed
}

fn summary() -> serde_json::Value {
    json!({
        "containment": { "checks": 200, "contained": 199, "unsound": 1, "perception": 0, "bound_broken": 0 },
        "error": { "x_m": { "rmse": 0.002, "max": 0.005, "rmse_by_third": [0.001, 0.003, 0.002] } },
        "violations": [{ "bound": "wheels.slip" }, { "bound": "body.tilt" }],
        "availability": 0.98,
        "metrics": { "goals_reached": 3.0 },
    })
}

#[test]
fn met_expectations_leave_no_line() {
    let expectations = "perception = 0\nunsound_max = 1\nerror.x_m.rmse_max = 0.002\nerror.x_m.max_max = 0.005\n\
                        availability_min = 0.98\nviolations = 2\nmetrics.goals_reached_min = 3";
    assert_eq!(missed(expectations, &summary()), Vec::<String>::new());
}

#[test]
fn a_missed_expectation_names_figure_value_and_limit() {
    assert_eq!(missed("unsound = 0", &summary()), ["containment.unsound is 1, expected 0"]);
    assert_eq!(missed("availability_min = 0.99", &summary()), ["availability is 0.98, expected at least 0.99"]);
    assert_eq!(missed("error.x_m.rmse_max = 0.001", &summary()), ["error.x_m.rmse is 0.002, expected at most 0.001"]);
}

#[test]
fn the_contained_share_is_one_only_when_every_check_is_contained() {
    // In the summary of this test, the box contains the true pose in 199 of 200 checks: a share of 0.995.
    assert_eq!(missed("containment.contained_share_min = 0.995", &summary()), Vec::<String>::new());
    assert_eq!(missed("containment.contained_share_min = 1", &summary()).len(), 1);
}

#[test]
fn the_worst_third_counts() {
    assert_eq!(missed("error.x_m.rmse_worst_third_max = 0.003", &summary()), Vec::<String>::new());
    assert_eq!(missed("error.x_m.rmse_worst_third_max = 0.0029", &summary()).len(), 1);
}

#[test]
fn a_figure_that_was_not_measured_misses_every_limit() {
    for limit in ["", "_min", "_max"] {
        let lines = missed(&format!("metrics.collisions{limit} = 0"), &summary());
        assert_eq!(lines.len(), 1);
        assert!(lines[0].contains("did not measure"), "{}", lines[0]);
    }
}

#[test]
fn a_run_without_checks_has_contained_nothing() {
    let nothing = json!({ "containment": { "checks": 0, "contained": 0 } });
    assert_eq!(missed("containment.contained_share_min = 1", &nothing).len(), 1);
}

#[test]
fn limits_of_boxes_do_not_apply_to_a_localizer_without_boxes() {
    // A filter states no boxes: nothing is contained, and nothing has a width. Its error is measured, and its goals are.
    let filter = json!({
        "containment": null,
        "error": { "x_m": { "rmse": 0.002 } },
        "metrics": { "goals_reached": 3.0 },
    });
    let expectations = "unsound = 0\nwidth.x_m.mean_max = 0.1\navailability_min = 0.9\nerror.x_m.rmse_max = 0.001\n\
                        metrics.goals_reached_min = 3\nmetrics.collisions = 0";
    let text = blind_scene(10.0, &format!("[expect]\n{expectations}\n"));
    let expect = Scene::parse(&text, "scene.toml").unwrap().expect;
    let verdict = expect.evaluate(&filter);
    assert_eq!(verdict.not_applicable, ["availability_min = 0.9", "unsound = 0", "width.x_m.mean_max = 0.1"]);
    // What is missed remains so: the error is too great, and collisions were not counted.
    assert_eq!(verdict.failed.len(), 2, "{:?}", verdict.failed);
    // Nor do limits of distributions apply to boxes; where some steps have none, though, the mean of the others' normalised errors meets no limit.
    let of_filters = "distribution.nees.mean_max = 6\ndistribution.within_3_sigma_share_min = 0.9";
    let text = blind_scene(10.0, &format!("[expect]\nunsound = 0\n{of_filters}\n"));
    let both = Scene::parse(&text, "scene.toml").unwrap().expect;
    let boxes = both.evaluate(&json!({ "containment": { "checks": 1, "contained": 1, "unsound": 0 } }));
    assert!(boxes.passed && boxes.not_applicable.len() == 2, "{boxes:?}");
    let mut stated = json!({ "distribution": { "checks": 100, "unusable": 0, "within_3_sigma_share": 0.99, "nees": { "mean": 2.0 } } });
    assert!(both.evaluate(&stated).passed);
    stated["distribution"]["unusable"] = 97.into();
    let mostly_none = both.evaluate(&stated);
    assert!(
        mostly_none.failed.len() == 1 && mostly_none.failed[0].contains("97 steps state no distribution"),
        "{mostly_none:?}"
    );
    // Where boxes are stated, the same limits apply.
    let stated = json!({ "containment": { "checks": 1, "contained": 1, "unsound": 0 } });
    assert!(expect.evaluate(&stated).not_applicable.is_empty());
}
