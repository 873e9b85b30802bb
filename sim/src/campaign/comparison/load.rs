//! One side of a comparison: the results of a folder, or a `results.csv` kept as a baseline.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

use thiserror::Error;

use crate::{
    artefacts::run_files::{RecordError, naming},
    campaign::{
        cases::{Results, Table, from_csv, to_csv},
        sweep::SweepError,
    },
    judge::figures::Figures,
};

/// One of the two sets of results that are compared: its cases, named by scene, settings and seed, and by the localizer where it
/// tests several.
#[derive(Clone, Debug, Default)]
pub struct Side {
    /// Cases that ran, by name.
    pub cases: BTreeMap<String, Case>,
    /// Names of the cases that should have run but failed or are missing.
    pub not_run: BTreeSet<String>,
}

/// One case that ran, with the results that a comparison needs.
#[derive(Clone, Debug)]
pub struct Case {
    /// Seed of the case.
    pub seed: u64,
    /// Name of the localizer that the case tests; none when the table of results has no column for this.
    pub subject: Option<String>,
    /// Whether the case met its scene's expectations; none when the table of results has no column for this.
    pub passed: Option<bool>,
    /// Numerical results of the case by name, as far as they are finite numbers.
    pub figures: Figures,
}

/// Why one side of a comparison cannot be read. The text of the error follows "failed to".
#[derive(Debug, Error)]
pub enum SideError {
    /// A file cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A folder of results cannot be read.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A file is not a table of results.
    #[error("read results {}: {expected}", path.display())]
    BadTable {
        /// Path of the file.
        path: PathBuf,
        /// Description of what is wrong with the table.
        expected: String,
    },
}

/// Figure that is made here of a case's mean normalised error squared: the magnitude of the logarithm of its ratio to 3.
pub(super) const NEES_OFF: &str = "distribution.nees.off";

impl Case {
    /// Whether the case's localizer states boxes.
    pub(super) fn has_boxes(&self) -> bool {
        self.figures.contains_key("containment.checks")
    }
}

impl Side {
    /// Reads one side of a comparison from a folder of results or from a `results.csv`.
    pub fn load(path: &Path) -> Result<Side, SideError> {
        // The results of a folder are converted into a CSV text and parsed again, so that a folder and its own `results.csv` cannot differ.
        let text = if path.is_dir() {
            to_csv(&Table::of(&Results::read(path)?))
        } else {
            naming("read", path, fs::read_to_string(path))?
        };
        Side::parse(&text).map_err(|expected| SideError::BadTable { path: path.to_owned(), expected })
    }

    /// Parses the text of a `results.csv` as one side of a comparison.
    pub fn parse(text: &str) -> Result<Side, String> {
        let (columns, rows) = from_csv(text)?;
        let column = |name: &str| columns.iter().position(|column| column == name).ok_or(format!("no column `{name}`"));
        let (scene, seed, status) = (column("scene")?, column("seed")?, column("status")?);
        // A side that tests several localizers has several cases of one scene, settings and seed; one with a single localizer is compared with the other
        // side whatever localizer that tests.
        let tests = columns.iter().position(|column| column == "subject");
        let subject = tests.filter(|subject| rows.iter().any(|row| row[*subject] != rows[0][*subject]));
        let passed = columns.iter().position(|column| column == "passed");
        let settings: Vec<usize> = (0..columns.len()).filter(|index| columns[*index].starts_with("set.")).collect();
        let mut side = Side::default();
        for row in &rows {
            let set = settings.iter().filter(|index| !row[**index].is_empty());
            let set: Vec<String> = set.map(|index| format!("{}={} ", &columns[*index][4..], row[*index])).collect();
            let tested = subject.map(|subject| format!("{} ", row[subject])).unwrap_or_default();
            let name = format!("{} {tested}{}seed {}", row[scene], set.concat(), row[seed]);
            let seed = row[seed].parse().map_err(|_| format!("`seed` is `{}`, expected a whole number", row[seed]))?;
            if row[status] != "done" {
                side.not_run.insert(name);
                continue;
            }
            let number = |(name, text): (&String, &String)| {
                let value: f64 = text.parse().ok()?;
                value.is_finite().then(|| (name.clone(), value))
            };
            let mut figures: Figures = columns.iter().zip(row).filter_map(number).collect();
            // A right filter has 3; one that states its errors too small and one that states them too great are both off.
            let off = figures.get("distribution.nees.mean").map(|nees| (nees / 3.0).ln().abs());
            figures.extend(off.filter(|off| off.is_finite()).map(|off| (NEES_OFF.to_owned(), off)));
            let subject = tests.map(|column| row[column].clone());
            let passed = passed.and_then(|column| row[column].parse().ok());
            side.cases.insert(name, Case { seed, subject, passed, figures });
        }
        Ok(side)
    }
}
