//! Sums over cases: the figures of a row under short numbers instead of names, and what is added up of them.

use std::{cmp::Ordering, collections::BTreeMap};

use crate::{
    artefacts::result_table::Moments,
    campaign::cases::{Cell, Table},
    loading::Setting,
};

/// The names of figures, each with its slot: its place in a [`Tally`].
#[derive(Debug, Default)]
pub(super) struct Names(BTreeMap<String, usize>);

impl Names {
    fn slot(&mut self, name: &str) -> usize {
        let next = self.0.len();
        *self.0.entry(name.to_owned()).or_insert(next)
    }
}

/// What is added up of some cases.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    pub(super) n_cases: usize,
    pub(super) n_passed: usize,
    moments: Vec<Moments>,
}

impl Tally {
    /// Adds a case with its figures by their slots.
    pub(super) fn add(&mut self, passed: Option<bool>, figures: impl Iterator<Item = (usize, f64)>) {
        self.n_cases += 1;
        self.n_passed += usize::from(passed == Some(true));
        for (slot, value) in figures {
            if slot >= self.moments.len() {
                self.moments.resize(slot + 1, Moments::default());
            }
            self.moments[slot].add(value);
        }
    }

    /// Returns what was added up of each figure that any case has.
    pub(super) fn moments<'a>(&'a self, names: &'a Names) -> impl Iterator<Item = (&'a str, &'a Moments)> {
        let known = |(name, slot): (&'a String, &usize)| Some((name.as_str(), self.moments.get(*slot)?));
        names.0.iter().filter_map(known).filter(|(_, moments)| !moments.is_empty())
    }
}

/// Where the rows of a table have what.
pub(super) struct Columns<'a> {
    table: &'a Table,
    /// Columns with figures, each with the figure's slot.
    figures: Vec<(usize, usize)>,
    settings: Vec<usize>,
    identity: [Option<usize>; 7],
}

/// What a row says of its case beside figures. A text is empty where the row has none.
pub(super) struct Identity<'a> {
    pub(super) scene: &'a str,
    pub(super) subject: &'a str,
    pub(super) status: &'a str,
    pub(super) passed: Option<bool>,
    pub(super) seed: u64,
    pub(super) version: &'a str,
    pub(super) adapter: &'a str,
}

impl<'a> Columns<'a> {
    /// Finds the columns of a table.
    pub(super) fn of(table: &'a Table, names: &mut Names) -> Columns<'a> {
        let column = |name: &str| table.columns.iter().position(|column| column == name);
        // The name of every figure has a dot but for these.
        let is_figure = |name: &str| {
            !name.starts_with("set.") && !name.starts_with("digest.") && (name.contains('.') || name == "availability")
        };
        let figures = table.columns.iter().enumerate().filter(|(_, name)| is_figure(name));
        Columns {
            table,
            figures: figures.map(|(column, name)| (column, names.slot(name))).collect(),
            settings: (0..table.columns.len()).filter(|column| table.columns[*column].starts_with("set.")).collect(),
            identity: ["scene", "subject", "status", "passed", "seed", "version", "adapter"].map(column),
        }
    }

    /// Returns what a row of the table says beside figures.
    pub(super) fn identity<'r>(&self, row: &'r [Cell]) -> Identity<'r> {
        let [scene, subject, status, passed, seed, version, adapter] =
            self.identity.map(|column| column.map_or(&Cell::Empty, |column| &row[column]));
        let text = |cell: &'r Cell| if let Cell::Text(text) = cell { text.as_str() } else { "" };
        Identity {
            scene: text(scene),
            subject: text(subject),
            status: text(status),
            passed: if let Cell::Truth(passed) = passed { Some(*passed) } else { None },
            seed: if let Cell::Whole(seed) = seed { *seed } else { 0 },
            version: text(version),
            adapter: text(adapter),
        }
    }

    /// Returns the cell of a row in the column with this name, if the table has that.
    pub(super) fn cell<'r>(&self, row: &'r [Cell], name: &str) -> Option<&'r Cell> {
        self.table.columns.iter().position(|column| column == name).map(|column| &row[column])
    }

    /// Returns those cells of a row that are not empty, each with the name of its column.
    pub(super) fn cells<'r>(&'r self, row: &'r [Cell]) -> impl Iterator<Item = (&'r str, &'r Cell)> {
        self.table.columns.iter().map(String::as_str).zip(row).filter(|(_, cell)| **cell != Cell::Empty)
    }

    /// Returns the text of a row in the column with this name; empty where it has none.
    pub(super) fn text<'r>(&self, row: &'r [Cell], name: &str) -> &'r str {
        if let Some(Cell::Text(text)) = self.cell(row, name) { text } else { "" }
    }

    /// Returns the figures of a row of the table by their names.
    pub(super) fn figures<'r>(&'r self, row: &'r [Cell]) -> impl Iterator<Item = (&'r str, f64)> {
        self.figures
            .iter()
            .filter_map(|(column, _)| Some((self.table.columns[*column].as_str(), number(&row[*column])?)))
    }

    /// Returns the figures of a row of the table by their slots.
    pub(super) fn slots<'r>(&'r self, row: &'r [Cell]) -> impl Iterator<Item = (usize, f64)> {
        self.figures.iter().filter_map(|(column, slot)| Some((*slot, number(&row[*column])?)))
    }

    /// Returns the keys that a row of the table sets, with their values.
    pub(super) fn settings(&self, row: &[Cell]) -> Vec<(String, Ordered)> {
        let set = self.settings.iter().filter(|column| row[**column] != Cell::Empty);
        set.map(|column| (self.table.columns[*column]["set.".len()..].to_owned(), Ordered(row[*column].clone())))
            .collect()
    }
}

fn number(cell: &Cell) -> Option<f64> {
    if let Cell::Number(number) = cell { Some(*number) } else { None }
}

/// A cell of a column, ordered by its value: truth values, then numbers, then texts.
#[derive(Clone, Debug)]
pub(super) struct Ordered(Cell);

impl Ordered {
    /// Returns the setting of `key` to this value. A whole number is set as an integer, which a scene takes for any number.
    pub(super) fn setting(&self, key: &str) -> Setting {
        let value = match &self.0 {
            Cell::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
                toml::Value::Integer(*number as i64)
            }
            Cell::Number(number) => toml::Value::Float(*number),
            Cell::Whole(number) => toml::Value::Integer(*number as i64),
            Cell::Truth(truth) => toml::Value::Boolean(*truth),
            Cell::Text(text) => toml::Value::String(text.clone()),
            Cell::Empty => toml::Value::String(String::new()),
        };
        Setting { key: key.to_owned(), value }
    }

    fn rank(&self) -> (u8, f64, &str) {
        match &self.0 {
            Cell::Empty => (0, 0.0, ""),
            Cell::Truth(truth) => (1, f64::from(u8::from(*truth)), ""),
            Cell::Number(number) => (2, *number, ""),
            Cell::Whole(number) => (2, *number as f64, ""),
            Cell::Text(text) => (3, 0.0, text),
        }
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Ordered) -> Ordering {
        let ((kind, number, text), (other_kind, other_number, other_text)) = (self.rank(), other.rank());
        kind.cmp(&other_kind).then(number.total_cmp(&other_number)).then(text.cmp(other_text))
    }
}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Ordered) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ordered {
    fn eq(&self, other: &Ordered) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ordered {}
