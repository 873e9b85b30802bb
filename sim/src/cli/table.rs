//! `wherein table`: a Markdown table of recorded runs.

use std::{fs, path::PathBuf};

use clap::Args;

use crate::artefacts::{
    result_table::{BEGIN, END, Kind, Outcome, Shown, as_markdown, lines},
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
    /// rows of the baselines, other methods on the same readings.
    #[arg(long, value_name = "FILE")]
    into: Option<PathBuf>,
    /// Columns of the table: all, or names with commas between them, such as scene,run,checks. Without this option those that a reader needs first,
    /// eight at most.
    #[arg(long, value_name = "NAMES")]
    columns: Option<Shown>,
}

/// Option that leaves out of a results table the rows of the baselines: odometry alone and other methods on the same readings.
const NO_BASELINES: &str = "--no-baselines";

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
    let columns = arguments.columns.clone().unwrap_or_default();
    let Some(document) = &arguments.into else { return print(&as_markdown(&lines(&outcomes, false), &columns)) };
    let text = naming("read", document, fs::read_to_string(document))?;
    let updated = with_tables(&text, &outcomes, &columns).ok_or_else(|| CommandError::NoMarkers(document.clone()))?;
    Ok(naming("write", document, fs::write(document, updated))?)
}

/// Returns the document with a results table between each pair of marker lines; `None` when there is no such pair, or when one of a pair is missing.
fn with_tables(text: &str, outcomes: &[Outcome], columns: &Shown) -> Option<String> {
    let mut pieces = text.split(BEGIN);
    let mut updated = pieces.next()?.to_owned();
    let mut n_tables = 0;
    for piece in pieces {
        let (beginnings, rest) = piece.split_once("-->")?;
        let (old, after) = rest.split_once(END)?;
        let words: Vec<&str> = beginnings.split_whitespace().collect();
        let (options, beginnings): (Vec<&str>, Vec<&str>) = words.iter().partition(|word| **word == NO_BASELINES);
        let is_wanted = |outcome: &&Outcome| {
            beginnings.is_empty() || beginnings.iter().any(|beginning| outcome.scene.starts_with(beginning))
        };
        let wanted: Vec<Outcome> = outcomes.iter().filter(is_wanted).cloned().collect();
        // Where none of the recorded runs belongs to the scenes that a table selects, the table in the document stays as it is.
        let mut shown = lines(&wanted, false);
        shown.retain(|line| options.is_empty() || line.kind != Kind::Baseline);
        let table = if wanted.is_empty() { old } else { &format!("\n\n{}\n", as_markdown(&shown, columns)) };
        let marker = [BEGIN].into_iter().chain(words).collect::<Vec<_>>().join(" ");
        updated += &format!("{marker} -->{table}{END}{after}");
        n_tables += 1;
    }
    (n_tables > 0).then_some(updated)
}
