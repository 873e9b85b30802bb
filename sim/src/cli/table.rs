//! `wherein table`: recorded runs as a Markdown table.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    record::{self, naming},
    table::{Outcome, as_markdown, lines},
};

use super::{CommandError, TableArguments, print};

/// The line of a document after which the table stands.
pub(super) const BEGIN: &str = "<!-- results:begin -->";

/// The line of a document before which the table stands.
pub(super) const END: &str = "<!-- results:end -->";

/// Prints the table, or puts it into a document.
pub(super) fn tabulate(arguments: &TableArguments) -> Result<(), CommandError> {
    let mut outcomes = Vec::new();
    for folder in &arguments.folders {
        let before = outcomes.len();
        collect(folder, &mut outcomes)?;
        if outcomes.len() == before {
            return Err(CommandError::NoResults(folder.clone()));
        }
    }
    outcomes.sort_by(|one, other| (&one.scene, one.seed).cmp(&(&other.scene, other.seed)));
    let table = as_markdown(&lines(&outcomes, false));
    let Some(document) = &arguments.into else { return print(&table) };
    let text = naming("read", document, fs::read_to_string(document))?;
    let updated = between_markers(&text, &table).ok_or_else(|| CommandError::NoMarkers(document.clone()))?;
    Ok(naming("write", document, fs::write(document, updated))?)
}

fn collect(folder: &Path, outcomes: &mut Vec<Outcome>) -> Result<(), CommandError> {
    if let Some((summary, timing)) = record::read(folder)? {
        outcomes.push(Outcome::of(&summary, &timing));
        return Ok(());
    }
    for entry in naming("read the folder", folder, fs::read_dir(folder))? {
        let path: PathBuf = naming("read the folder", folder, entry)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() && !is_hidden {
            collect(&path, outcomes)?;
        }
    }
    Ok(())
}

fn between_markers(text: &str, table: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n\n{table}\n{END}{after}"))
}
