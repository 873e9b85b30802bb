//! The result table. It has a line for each run, one for all seeds of a scene, one for each method where several share the work, and one
//! for each baseline.

use serde_json::Value;

use crate::judge::figures::{Figures, figures};

mod columns;
mod layout;
mod pool;

pub(crate) use pool::{methods, pool};

pub use layout::{as_markdown, as_text};

/// The outcome of one run, taken from its summary and its timing.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Name of the scene.
    pub scene: String,
    /// The run's seed.
    pub seed: u64,
    /// Whether the scene's expectations were met.
    pub passed: bool,
    /// All figures that were measured in the run.
    pub figures: Figures,
}

/// What a line of the result table is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One run, or all runs of a scene.
    Runs,
    /// The part that one of the localizer's methods had in the runs of a scene.
    Method,
    /// A baseline: the result of another localization method from the readings that the localizer was given.
    Baseline,
}

/// One line of the result table.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name of the scene.
    pub scene: String,
    /// What the line is about.
    pub kind: Kind,
    /// Text in the column that names the run: seed, number of seeds, or name of a method or baseline.
    pub run: String,
    /// `passed`, `FAILED`, or the number of runs that passed; empty for a method or baseline.
    pub verdict: String,
    /// The figures that the line's cells show.
    pub figures: Figures,
}

impl Outcome {
    /// Reads the outcome of a run from the contents of `summary.json` and `timing.json`.
    pub fn of(summary: &Value, timing: &Value) -> Outcome {
        let mut measured = figures(summary);
        for name in ["wall_s", "real_time_factor"] {
            measured.extend(timing[name].as_f64().map(|value| (format!("timing.{name}"), value)));
        }
        for (name, value) in timing["solve_us"].as_object().into_iter().flatten() {
            measured.extend(value.as_f64().map(|value| (format!("baselines.{name}.timing.solve_us"), value)));
        }
        Outcome {
            scene: summary["scene"].as_str().unwrap_or_default().to_owned(),
            seed: summary["seed"].as_u64().unwrap_or_default(),
            passed: summary["verdict"]["passed"].as_bool().unwrap_or_default(),
            figures: measured,
        }
    }
}

/// The lines of the table for `outcomes`, grouped by scene in order of appearance. With `each_seed` every single run has a line of its own.
pub fn lines(outcomes: &[Outcome], each_seed: bool) -> Vec<Line> {
    let mut scenes: Vec<&str> = Vec::new();
    for outcome in outcomes {
        if !scenes.contains(&outcome.scene.as_str()) {
            scenes.push(&outcome.scene);
        }
    }
    let of_scene = |scene: &str| outcomes.iter().filter(|outcome| outcome.scene == scene).collect::<Vec<_>>();
    scenes.into_iter().flat_map(|scene| scene_lines(scene, &of_scene(scene), each_seed)).collect()
}

fn scene_lines(scene: &str, runs: &[&Outcome], each_seed: bool) -> Vec<Line> {
    let line = |kind: Kind, run: String, verdict: String, figures: Figures| Line {
        scene: scene.to_owned(),
        kind,
        run,
        verdict,
        figures,
    };
    let mut lines = Vec::new();
    if each_seed || runs.len() == 1 {
        lines.extend(runs.iter().map(|run| {
            let verdict = if run.passed { "passed" } else { "FAILED" };
            line(Kind::Runs, format!("seed {}", run.seed), verdict.to_owned(), run.figures.clone())
        }));
    }
    let pooled = pool(&runs.iter().map(|run| &run.figures).collect::<Vec<_>>());
    let (methods, baselines) = (pool::methods(&pooled), pool::baselines(&pooled));
    if runs.len() > 1 {
        let passed = runs.iter().filter(|run| run.passed).count();
        let verdict = format!("{passed}/{} passed", runs.len());
        lines.push(line(Kind::Runs, format!("{} seeds", runs.len()), verdict, pooled));
    }
    for (kind, parts) in [(Kind::Method, methods), (Kind::Baseline, baselines)] {
        lines.extend(parts.into_iter().map(|(name, figures)| line(kind, name, String::new(), figures)));
    }
    lines
}
