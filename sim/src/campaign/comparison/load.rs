//! One side of a comparison: a folder of results, or a `results.csv` kept as a baseline.

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

/// Cases by scene, settings and seed.
#[derive(Clone, Debug, Default)]
pub struct Side {
    /// Its cases.
    pub cases: BTreeMap<String, Case>,
    /// Cases that it was to run and that failed or are missing.
    pub not_run: BTreeSet<String>,
}

/// One case that ran.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its seed.
    pub seed: u64,
    /// Whether it met its scene's expectations; not known of a table that does not say.
    pub passed: Option<bool>,
    /// Its figures, those that are finite numbers.
    pub figures: Figures,
}

/// Why a side cannot be read. Its text follows "failed to".
#[derive(Debug, Error)]
pub enum SideError {
    /// A file cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A folder cannot be read.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A table is not one of ours.
    #[error("read results {}: {expected}", path.display())]
    BadTable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        expected: String,
    },
}

impl Side {
    /// Reads a folder of results or a `results.csv`.
    pub fn load(path: &Path) -> Result<Side, SideError> {
        // A folder goes through the same text, so that it cannot say anything else than its own table.
        let text = if path.is_dir() {
            to_csv(&Table::of(&Results::read(path)?))
        } else {
            naming("read", path, fs::read_to_string(path))?
        };
        Side::parse(&text).map_err(|expected| SideError::BadTable { path: path.to_owned(), expected })
    }

    /// Reads the text of a `results.csv`.
    pub fn parse(text: &str) -> Result<Side, String> {
        let (columns, rows) = from_csv(text)?;
        let column = |name: &str| columns.iter().position(|column| column == name).ok_or(format!("no column `{name}`"));
        let (scene, seed, status) = (column("scene")?, column("seed")?, column("status")?);
        let passed = columns.iter().position(|column| column == "passed");
        let settings: Vec<usize> = (0..columns.len()).filter(|index| columns[*index].starts_with("set.")).collect();
        let mut side = Side::default();
        for row in &rows {
            let set = settings.iter().filter(|index| !row[**index].is_empty());
            let set: Vec<String> = set.map(|index| format!("{}={} ", &columns[*index][4..], row[*index])).collect();
            let name = format!("{} {}seed {}", row[scene], set.concat(), row[seed]);
            let seed = row[seed].parse().map_err(|_| format!("`seed` is `{}`, expected a whole number", row[seed]))?;
            if row[status] != "done" {
                side.not_run.insert(name);
                continue;
            }
            let number = |(name, text): (&String, &String)| {
                let value: f64 = text.parse().ok()?;
                value.is_finite().then(|| (name.clone(), value))
            };
            let figures = columns.iter().zip(row).filter_map(number).collect();
            let passed = passed.and_then(|column| row[column].parse().ok());
            side.cases.insert(name, Case { seed, passed, figures });
        }
        Ok(side)
    }
}
