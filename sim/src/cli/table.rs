//! `wherein table`: a Markdown table of recorded runs.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use clap::Args;

use crate::artefacts::{
    result_table::{
        BEGIN, END, Kind, Outcome, Row, Shown, UnknownColumn, as_csv, as_markdown, from_csv, joined, lines,
    },
    run_files::{self, naming, run_folders},
};

use super::{CommandError, print};

/// Arguments of `wherein table`.
#[derive(Debug, Args)]
pub(super) struct TableArguments {
    /// Folders that `wherein run` wrote.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Replace the text between the lines `<!-- results:begin -->` and `<!-- results:end -->` of this document by the table. A first line such as
    /// `<!-- results:begin floor papers/floor --no-baselines -->` selects scenes whose names begin with `floor` or `papers/floor`, and leaves out the
    /// rows of the baselines, other methods on the same readings. `--columns=scene,run,width` in that line says which columns the rows of runs have.
    #[arg(long, value_name = "FILE")]
    into: Option<PathBuf>,
    /// Columns of the table: all, or names with commas between them, such as scene,run,checks. Without this option those that a reader needs first,
    /// eight at most.
    #[arg(long, value_name = "NAMES", value_parser = Shown::of_result_table)]
    columns: Option<Shown>,
    /// Write the table into this CSV file too, with all columns. Lines that the file has already stay where they are of other scenes, and are in the
    /// document's tables, too.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// Option that leaves out of a results table the rows of the baselines: odometry alone and other methods on the same readings.
const NO_BASELINES: &str = "--no-baselines";

/// Beginning of the option that names the columns of a results table.
const COLUMNS: &str = "--columns=";

/// Prints the results table, or puts it into a document.
pub(super) fn tabulate(arguments: &TableArguments) -> Result<(), CommandError> {
    let mut outcomes = Vec::new();
    for folder in &arguments.folders {
        let before = outcomes.len();
        for run in run_folders(folder, &|_| true)? {
            if let Some((summary, timing)) = run_files::read(&run)? {
                outcomes.push(Outcome::of(&summary, &timing));
            }
        }
        if outcomes.len() == before {
            return Err(CommandError::NoResults(folder.clone()));
        }
    }
    outcomes.sort_by(|one, other| (&one.scene, one.seed).cmp(&(&other.scene, other.seed)));
    let mut rows: Vec<Row> = lines(&outcomes, false).iter().map(Row::from).collect();
    if let Some(path) = &arguments.csv {
        let before = if path.exists() { naming("read", path, fs::read_to_string(path))? } else { String::new() };
        let before = naming("read", path, from_csv(&before))?;
        rows = joined(&rows, before);
        let csv = as_csv(&rows).map_err(io::Error::other);
        run_files::replace_file(path, &naming("write", path, csv)?)?;
    }
    let columns = arguments.columns.clone().unwrap_or_default();
    let Some(document) = &arguments.into else { return print(&as_markdown(&rows, &columns)) };
    let text = naming("read", document, fs::read_to_string(document))?;
    let updated = with_tables(document, &text, &rows, &columns)?;
    Ok(naming("write", document, fs::write(document, updated))?)
}

/// Returns the document with a results table between each pair of marker lines. Refused are a document without such a pair or with one of a pair
/// missing, and marker lines with the name of no column.
fn with_tables(document: &Path, text: &str, rows: &[Row], columns: &Shown) -> Result<String, CommandError> {
    let mut pieces = text.split(BEGIN);
    let mut updated = pieces.next().unwrap_or_default().to_owned();
    let mut n_tables = 0;
    for piece in pieces {
        let marked = piece.split_once("-->").and_then(|(words, rest)| Some((words, rest.split_once(END)?)));
        let Some((words, (old, after))) = marked else { return Err(CommandError::NoMarkers(document.to_owned())) };
        let wanted =
            Wanted::read(words).map_err(|source| CommandError::Marker { document: document.to_owned(), source })?;
        let table = wanted.table(rows, columns);
        let marker = [BEGIN].into_iter().chain(words.split_whitespace()).collect::<Vec<_>>().join(" ");
        // Where no row is of the scenes that a table selects, the table in the document stays as it is.
        let table = table.map_or_else(|| old.to_owned(), |table| format!("\n\n{table}\n"));
        updated += &format!("{marker} -->{table}{END}{after}");
        n_tables += 1;
    }
    if n_tables == 0 { Err(CommandError::NoMarkers(document.to_owned())) } else { Ok(updated) }
}

/// What the first marker line of a results table asks for.
struct Wanted<'a> {
    /// Beginnings of the names of scenes; none stands for all scenes.
    beginnings: Vec<&'a str>,
    /// Whether the table has the rows of baselines.
    with_baselines: bool,
    /// Columns of the rows of runs.
    columns: Option<Shown>,
}

impl Wanted<'_> {
    fn read(words: &str) -> Result<Wanted<'_>, UnknownColumn> {
        let mut wanted = Wanted { beginnings: Vec::new(), with_baselines: true, columns: None };
        for word in words.split_whitespace() {
            match word.strip_prefix(COLUMNS) {
                Some(names) => wanted.columns = Some(Shown::of_result_table(names)?),
                None if word == NO_BASELINES => wanted.with_baselines = false,
                None => wanted.beginnings.push(word),
            }
        }
        Ok(wanted)
    }

    /// The table of those rows that are wanted; `None` where there is none.
    fn table(&self, rows: &[Row], columns: &Shown) -> Option<String> {
        let is_wanted = |row: &&Row| {
            self.beginnings.is_empty() || self.beginnings.iter().any(|beginning| row.scene().starts_with(beginning))
        };
        let wanted = rows.iter().filter(is_wanted).cloned();
        let (runs, others): (Vec<Row>, Vec<Row>) = wanted.partition(|row| row.kind == Kind::Runs);
        let others: Vec<Row> =
            others.into_iter().filter(|row| self.with_baselines || row.kind != Kind::Baseline).collect();
        let mut tables = vec![as_markdown(&runs, self.columns.as_ref().unwrap_or(columns))];
        tables.extend((!others.is_empty()).then(|| as_markdown(&others, columns)));
        (!runs.is_empty()).then(|| tables.join("\n"))
    }
}
