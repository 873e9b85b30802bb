//! The result table. It has a line for each run, one for all seeds of a scene, one for each method where several share the work, and one
//! for each baseline.

use serde_json::Value;

use crate::{
    artefacts::run_files::subject_of,
    judge::figures::{Figures, figures},
    subject::SubjectChoice,
};

mod columns;
mod csv_file;
mod layout;
mod pool;
mod shown;

pub(crate) use pool::{Moments, methods, pool, pooled};

pub use csv_file::{as_csv, from_csv, joined};
pub use layout::{as_markdown, as_text};
pub use shown::{MOST_COLUMNS, Shown, UnknownColumn};

/// Beginning of the line of a document below which a results table stands. Between this text and `-->` the line may list beginnings of the names of
/// scenes that the table shows, and options.
pub(crate) const BEGIN: &str = "<!-- results:begin";

/// Line of a document at which a results table ends.
pub(crate) const END: &str = "<!-- results:end -->";

/// The outcome of one run, taken from its summary and its timing.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Name of the scene.
    pub scene: String,
    /// The run's seed.
    pub seed: u64,
    /// Name of the localizer under test.
    pub subject: String,
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
    /// Name of the localizer under test; empty in a table of the usual localizer alone.
    pub subject: String,
    /// What the line is about.
    pub kind: Kind,
    /// Text in the column that names the run: seed, number of seeds, or name of a method or baseline.
    pub run: String,
    /// `passed`, `FAILED`, or the number of runs that passed; empty for a method or baseline.
    pub verdict: String,
    /// The figures that the line's cells show.
    pub figures: Figures,
}

/// A line of the result table as the texts of all its cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// What the line is about.
    pub kind: Kind,
    /// The texts of the cells, one for each column of the result table.
    cells: Vec<String>,
}

impl Row {
    /// Name of the scene.
    pub fn scene(&self) -> &str {
        &self.cells[columns::SCENE]
    }
}

impl From<&Line> for Row {
    fn from(line: &Line) -> Row {
        Row { kind: line.kind, cells: columns::COLUMNS.iter().map(|column| (column.cell)(line)).collect() }
    }
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
            subject: subject_of(summary),
            passed: summary["verdict"]["passed"].as_bool().unwrap_or_default(),
            figures: measured,
        }
    }

    /// The scene, and the localizer that it tested.
    fn tested(&self) -> [&str; 2] {
        [&self.scene, &self.subject]
    }
}

/// The lines of the table for `outcomes`, grouped by scene and localizer in order of appearance. With `each_seed` every single run has a line of its own.
pub fn lines(outcomes: &[Outcome], each_seed: bool) -> Vec<Line> {
    let mut tested: Vec<[&str; 2]> = Vec::new();
    for outcome in outcomes {
        if !tested.contains(&outcome.tested()) {
            tested.push(outcome.tested());
        }
    }
    // Where every run tests the usual localizer, the table needs no column for its name.
    let is_named = tested.iter().any(|[_, subject]| *subject != SubjectChoice::default().to_string());
    let runs_of = |tested: [&str; 2]| outcomes.iter().filter(|one| one.tested() == tested).collect::<Vec<_>>();
    let of = |[scene, subject]: [&str; 2]| {
        let mut lines = scene_lines(scene, &runs_of([scene, subject]), each_seed);
        lines.iter_mut().for_each(|line| line.subject = if is_named { subject.to_owned() } else { String::new() });
        lines
    };
    tested.into_iter().flat_map(of).collect()
}

fn scene_lines(scene: &str, runs: &[&Outcome], each_seed: bool) -> Vec<Line> {
    let line = |kind: Kind, run: String, verdict: String, figures: Figures| Line {
        scene: scene.to_owned(),
        subject: String::new(),
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
