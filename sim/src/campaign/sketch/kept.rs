//! The few cases of a sketch that are kept as a whole: the worst of those that ran, and the first of those that did not.

use std::{
    cmp::Ordering,
    path::{Path, PathBuf},
};

use serde_json::{Map, Value, json};

use crate::{
    campaign::{
        cases::{CaseResult, Cell},
        report::badness,
        sweep::{Recorded, case_folder, read_case},
    },
    judge::figures::Figures,
};

use super::tally::{Columns, Identity};

/// Greatest number of cases that are kept of each kind: ran, could not run, missing. A report shows ten of them in detail and names a hundred.
const MOST: usize = 100;

/// Where the cases of a table were run.
#[derive(Clone, Debug)]
pub(super) struct Origin {
    /// Folder that may have the files of each case.
    pub(super) folder: PathBuf,
    /// Path of the scene's file; empty when it is not known.
    pub(super) scene_path: PathBuf,
}

/// The cases that are kept, the worst first.
#[derive(Debug, Default)]
pub(super) struct Kept {
    ran: Vec<(Badness, CaseResult)>,
    failed: Vec<CaseResult>,
    missing: Vec<CaseResult>,
}

/// The key that [`badness`] gives, greater for worse cases.
type Badness = (bool, u8, f64, f64);

impl Kept {
    /// Keeps the case of a row if it is among the worst so far.
    pub(super) fn add(
        &mut self,
        case: &Identity<'_>,
        figures: &Figures,
        columns: &Columns<'_>,
        row: &[Cell],
        origin: &Origin,
    ) {
        let result = |recorded| CaseResult {
            id: columns.text(row, "case").to_owned(),
            scene: case.scene.to_owned(),
            scene_path: origin.scene_path.clone(),
            settings: columns.settings(row).iter().map(|(key, value)| value.setting(key)).collect(),
            seed: case.seed,
            subject: case.subject.to_owned(),
            subject_is_elsewhere: false,
            folder: case_folder(&origin.folder, columns.text(row, "case")),
            recorded,
        };
        match case.status {
            "failed" if self.failed.len() < MOST => {
                self.failed.push(result(Recorded::Failed(columns.text(row, "missed_expectations").to_owned())));
            }
            "missing" if self.missing.len() < MOST => self.missing.push(result(Recorded::Missing)),
            "failed" | "missing" => {}
            _ => {
                let badness = badness(case.passed, figures);
                // Of equally bad cases the first stay.
                let place = self.ran.partition_point(|(other, _)| other.partial_cmp(&badness) != Some(Ordering::Less));
                if place < MOST {
                    let summary = summary(case, figures, columns, row);
                    self.ran.truncate(MOST - 1);
                    self.ran.insert(place, (badness, result(Recorded::Done { summary, timing: Value::Null })));
                }
            }
        }
    }

    /// Returns the cases that are kept. Those whose files are still there have all that was recorded of them.
    pub(super) fn into_cases(self) -> Vec<CaseResult> {
        let ran = self.ran.into_iter().map(|(_, case)| match case.folder.parent().and_then(Path::parent) {
            Some(folder) if case.folder.is_dir() => match read_case(folder, &case.id) {
                recorded @ Recorded::Done { .. } => CaseResult { recorded, ..case },
                _ => case,
            },
            _ => case,
        });
        ran.chain(self.failed).chain(self.missing).collect()
    }
}

/// The part of a case's summary that its row tells.
fn summary(case: &Identity<'_>, figures: &Figures, columns: &Columns<'_>, row: &[Cell]) -> Value {
    let mut summary = Map::new();
    for (name, value) in figures {
        insert(&mut summary, name, json!(value));
    }
    for (name, column) in [("time_s", "first_failure_s"), ("margin", "first_failure_margin")] {
        if let Some(Cell::Number(value)) = columns.cell(row, column) {
            insert(&mut summary, &format!("containment.first_failure.{name}"), json!(value));
        }
    }
    for (name, column) in [("axis", "first_failure_axis"), ("outcome", "first_failure_outcome"), ("blame", "blame")] {
        let text = columns.text(row, column);
        if !text.is_empty() {
            insert(&mut summary, &format!("containment.first_failure.{name}"), json!(text));
        }
    }
    let missed: Vec<&str> =
        columns.text(row, "missed_expectations").split("; ").filter(|line| !line.is_empty()).collect();
    insert(&mut summary, "verdict", json!({ "passed": case.passed, "failed": missed }));
    for (name, text) in [("version", case.version), ("adapter", case.adapter)] {
        if !text.is_empty() {
            insert(&mut summary, name, json!(text));
        }
    }
    Value::Object(summary)
}

/// Puts a value below a dotted name.
fn insert(table: &mut Map<String, Value>, name: &str, value: Value) {
    match name.split_once('.') {
        None => drop(table.insert(name.to_owned(), value)),
        Some((first, rest)) => {
            let below = table.entry(first).or_insert_with(|| Value::Object(Map::new()));
            if let Value::Object(below) = below {
                insert(below, rest, value);
            }
        }
    }
}
