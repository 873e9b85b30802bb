//! The table of `results.csv`: one row for each case, with the columns in a stable order.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::{campaign::sweep::Recorded, judge::figures::Figures};

use super::{CaseResult, Results};

/// Contents of one cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// An empty cell.
    Empty,
    /// A text in a cell.
    Text(String),
    /// A floating-point number in a cell.
    Number(f64),
    /// A whole number, not negative.
    Whole(u64),
    /// A truth value, true or false.
    Truth(bool),
}

/// A table of results: named columns, and rows of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names of the table's columns.
    pub columns: Vec<String>,
    /// Rows of the table, one for each case, with one cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

/// Names of the first columns of the table of results. The columns of the scene keys that vary follow.
const IDENTITY: [&str; 2] = ["case", "scene"];
/// Names of the columns of the table of results that follow the columns of the scene keys that vary.
const OUTCOME: [&str; 10] = [
    "seed",
    "status",
    "passed",
    "missed_expectations",
    "first_failure_s",
    "first_failure_axis",
    "first_failure_margin",
    "first_failure_outcome",
    "blame",
    "violated_bounds",
];
/// Names of the last columns of the table of results.
const ORIGIN: [&str; 5] = ["subject", "version", "adapter", "digest.scene", "digest.estimates"];

/// Whether the cells of a column with this name are texts, even those that look like numbers.
pub(super) fn is_text(name: &str) -> bool {
    let others =
        OUTCOME.iter().filter(|name| !["seed", "passed", "first_failure_s", "first_failure_margin"].contains(name));
    IDENTITY.iter().chain(others).chain(&ORIGIN).any(|text| *text == name)
}

impl Table {
    /// Creates the table of `results`. The row of a case that did not run has no numerical results.
    pub fn of(results: &Results) -> Table {
        let keys = results.keys();
        let figures: Vec<Figures> = results.cases.iter().map(shown_figures).collect();
        let names: BTreeSet<&String> = figures.iter().flat_map(Figures::keys).collect();
        let columns = IDENTITY.iter().map(|name| (*name).to_owned());
        let columns = columns.chain(keys.iter().map(|key| format!("set.{key}")));
        let columns = columns.chain(OUTCOME.iter().map(|name| (*name).to_owned()));
        let columns = columns.chain(names.iter().map(|name| (*name).clone()));
        let columns = columns.chain(ORIGIN.iter().map(|name| (*name).to_owned())).collect();
        let row = |(case, figures): (&CaseResult, &Figures)| {
            let mut row = vec![text(&case.id), text(&case.scene)];
            row.extend(keys.iter().map(|key| setting(case, key)));
            row.extend(outcome(case));
            row.extend(names.iter().map(|name| figures.get(*name).map_or(Cell::Empty, |value| Cell::Number(*value))));
            row.extend(origin(case));
            row
        };
        Table { columns, rows: results.cases.iter().zip(&figures).map(row).collect() }
    }
}

/// Returns the numerical results of a case, without the seed and the first failure, which have columns of their own.
fn shown_figures(case: &CaseResult) -> Figures {
    let mut figures = case.figures();
    figures.retain(|name, _| name != "seed" && !name.starts_with("containment.first_failure."));
    figures
}

fn setting(case: &CaseResult, key: &str) -> Cell {
    let value = case.settings.iter().find(|setting| setting.key == key).map(|setting| &setting.value);
    match value {
        None => Cell::Empty,
        Some(toml::Value::Integer(number)) => Cell::Number(*number as f64),
        Some(toml::Value::Float(number)) => Cell::Number(*number),
        Some(toml::Value::Boolean(truth)) => Cell::Truth(*truth),
        Some(toml::Value::String(chosen)) => text(chosen),
        Some(other) => text(&other.to_string()),
    }
}

fn outcome(case: &CaseResult) -> [Cell; 10] {
    let first = case.first_failure();
    let said = |value: &Value| value.as_str().map_or(Cell::Empty, text);
    let measured = |value: &Value| value.as_f64().map_or(Cell::Empty, Cell::Number);
    let status = match &case.recorded {
        Recorded::Done { .. } => "done",
        Recorded::Failed(_) => "failed",
        Recorded::Missing => "missing",
    };
    let missed = match &case.recorded {
        Recorded::Failed(reason) => reason.clone(),
        _ => case.missed_expectations().join("; "),
    };
    [
        Cell::Whole(case.seed),
        text(status),
        case.passed().map_or(Cell::Empty, Cell::Truth),
        text(&missed),
        measured(&first["time_s"]),
        said(&first["axis"]),
        measured(&first["margin"]),
        said(&first["outcome"]),
        said(&first["blame"]),
        text(&violated_bounds(case)),
    ]
}

/// Returns the names of the declared bounds that were exceeded in a case, each once, separated by blanks.
fn violated_bounds(case: &CaseResult) -> String {
    let violations = case.summary().and_then(|summary| summary["violations"].as_array());
    let names: BTreeSet<&str> = violations.into_iter().flatten().filter_map(|one| one["bound"].as_str()).collect();
    names.into_iter().collect::<Vec<_>>().join(" ")
}

fn origin(case: &CaseResult) -> [Cell; 5] {
    let summary = case.summary().unwrap_or(&Value::Null);
    let said = |value: &Value| value.as_str().map_or(Cell::Empty, text);
    [
        text(&case.subject),
        said(&summary["version"]),
        said(&summary["adapter"]),
        said(&summary["digest"]["scene"]),
        said(&summary["digest"]["estimates"]),
    ]
}

fn text(text: &str) -> Cell {
    if text.is_empty() { Cell::Empty } else { Cell::Text(text.to_owned()) }
}
