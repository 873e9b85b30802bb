//! The result table: which method contributed how much, and how the figures of several runs are pooled; the report's measures; the reader of CSV
//! files.

use serde_json::{Value, json};
use sim::{
    artefacts::result_table::{Line, Outcome, lines},
    campaign::{cases::from_csv, report::MEASURES},
    judge::figures::Figures,
};

/// Figures of a run in which the method `tiles` halved the width of the box in x twice and that of the heading `tiles_heading` times, and the method
/// `walls` halved y once and the heading three times.
fn outcome(seed: u64, tiles_heading: f64) -> Outcome {
    let method = |readings: u32, constraints: u32, halved: [f64; 3]| {
        let [x, y, heading] = halved;
        let halved = json!({ "x_m": x, "y_m": y, "heading_rad": heading });
        json!({ "readings": readings, "constraints": constraints, "halved": halved })
    };
    let methods = json!({ "tiles": method(10, 5, [2.0, 0.0, tiles_heading]), "walls": method(7, 2, [0.0, 1.0, 3.0]) });
    Outcome::of(&json!({ "scene": "flat", "seed": seed, "methods": methods }), &Value::Null)
}

fn line(outcomes: &[Outcome], run: &str) -> Option<Line> {
    lines(outcomes, true).into_iter().find(|line| line.run == run)
}

#[test]
fn a_methods_share_is_of_all_that_was_halved_in_all_runs() {
    let runs = [outcome(0, 1.0), outcome(1, 5.0)];
    let (tiles, walls) = (line(&runs, "tiles").unwrap().figures, line(&runs, "walls").unwrap().figures);
    assert_eq!((tiles["method.readings"], tiles["method.constraints"]), (20.0, 10.0));
    // In each of the two runs `tiles` halved the box's width in x twice and `walls` halved that in y once: two thirds of all halvings of the position
    // are due to `tiles`.
    let third = 1.0 / 3.0;
    assert_eq!((tiles["method.position_share"], walls["method.position_share"]), (2.0 * third, third));
    // In the two runs together `tiles` halved the heading's width 1 + 5 times, of 6 + 2 · 3 halvings by both methods.
    assert_eq!((tiles["method.heading_share"], walls["method.heading_share"]), (0.5, 0.5));
}

#[test]
fn one_method_alone_needs_no_row() {
    let mut alone = outcome(0, 1.0);
    alone.figures.retain(|name, _| !name.starts_with("methods.walls"));
    assert!(line(&[alone], "tiles").is_none());
}

#[test]
fn counts_add_up_squares_pool_and_the_worst_stays_the_worst() {
    let run = |collisions: u32, clearance: f64, deviation: f64, thirds: [f64; 3]| {
        let error = json!({ "x_m": { "rmse": thirds[2], "rmse_by_third": thirds } });
        let metrics = json!({ "collisions": collisions, "clearance_least_m": clearance, "path_greatest_m": deviation });
        Outcome::of(&json!({ "scene": "flat", "seed": 0, "error": error, "metrics": metrics }), &Value::Null)
    };
    let runs = [run(2, 0.3, 0.1, [1.0, 0.0, 3.0]), run(5, 0.2, 0.4, [7.0, 0.0, 4.0])];
    let pooled = line(&runs, "2 seeds").unwrap().figures;
    assert_eq!(pooled["metrics.collisions"], 7.0);
    assert_eq!((pooled["metrics.clearance_least_m"], pooled["metrics.path_greatest_m"]), (0.2, 0.4));
    // The error pooled over both runs is √((3² + 4²)/2). Pooled likewise, the errors in the three thirds of the runs are 5, 0 and that error, of
    // which 5 is the greatest.
    assert!((pooled["error.x_m.rmse"] - 12.5_f64.sqrt()).abs() < 1e-12);
    assert!((pooled["error.x_m.rmse_worst_third"] - 5.0).abs() < 1e-12, "{pooled:?}");
}

#[test]
fn goals_are_a_share_of_errands_and_a_hundred_means_all() {
    let goals = MEASURES.iter().find(|measure| measure.name == "goals").unwrap();
    let of = |errands: f64, reached: f64| {
        let figures = [("metrics.errands", errands), ("metrics.goals_reached", reached)];
        goals.of(&figures.map(|(name, value)| (name.to_owned(), value)).into())
    };
    assert_eq!((of(4.0, 3.0), of(4.0, 4.0), of(0.0, 0.0)), ("75.0".to_owned(), "100".to_owned(), String::new()));
    assert_eq!(goals.of(&Figures::new()), "");
    // A share of 24 999 of 25 000 goals reached, 99.996 %, must not be printed as 100, which means all of them.
    assert_eq!(of(25_000.0, 24_999.0), "99.99");
}

#[test]
fn a_table_that_is_no_whole_table_is_refused() {
    assert_eq!(from_csv("a,b\n1,\"x, \"\"y\"\"\"\r\n3,4").unwrap().1, [["1", "x, \"y\""], ["3", "4"]]);
    for (text, told) in [("", "an empty file"), ("a,b\n1\n", "row 2 has 1 fields, expected 2"), ("a\n\"1\n", "quot")] {
        let refusal = from_csv(text).unwrap_err();
        assert!(refusal.contains(told), "{refusal}");
    }
}
