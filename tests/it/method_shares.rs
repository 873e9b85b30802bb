//! Which method did it: the result table's rows where several methods share a drive.

use serde_json::{Value, json};
use sim::table::{Line, Outcome, lines};

/// A run in which `tiles` halved x twice and the heading `tiles_heading` times, and `walls` the heading three times.
fn outcome(seed: u64, tiles_heading: f64) -> Outcome {
    let method = |readings: u32, constraints: u32, halved: [f64; 3]| {
        let [x, y, heading] = halved;
        let halved = json!({ "x_m": x, "y_m": y, "heading_rad": heading });
        json!({ "readings": readings, "constraints": constraints, "halved": halved })
    };
    let methods = json!({ "tiles": method(10, 5, [2.0, 0.0, tiles_heading]), "walls": method(7, 2, [0.0, 0.0, 3.0]) });
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
    assert_eq!((tiles["method.position_share"], walls["method.position_share"]), (1.0, 0.0));
    // 1 + 5 of 6 + 2 · 3 halvings.
    assert_eq!((tiles["method.heading_share"], walls["method.heading_share"]), (0.5, 0.5));
}

#[test]
fn one_method_alone_needs_no_row() {
    let mut alone = outcome(0, 1.0);
    alone.figures.retain(|name, _| !name.starts_with("methods.walls"));
    assert!(line(&[alone], "tiles").is_none());
}
