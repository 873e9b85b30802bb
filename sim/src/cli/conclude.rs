//! What every command that has results does with them: files, a text for people, an exit code.

use std::{path::Path, process::ExitCode};

use crate::{
    report::{Overview, as_text},
    results::{Results, Table, to_csv},
    sweep::write_whole,
};

use super::{CommandError, print};

/// Writes the results' files into `folder`, prints them in short, and says by the exit code how they are: 0 all cases
/// passed, 1 some did not, 2 some are missing or could not run.
pub(super) fn conclude(results: &Results, folder: &Path) -> Result<ExitCode, CommandError> {
    if results.cases.is_empty() {
        return Err(CommandError::NoResults(folder.to_owned()));
    }
    let overview = Overview::of(results);
    let table = Table::of(results);
    write_whole(&folder.join("results.csv"), to_csv(&table).as_bytes())?;
    print(&as_text(&overview, results))?;
    print(&format!("\nRecorded in {}\n", folder.display()))?;
    Ok(exit_code(&overview))
}

fn exit_code(overview: &Overview) -> ExitCode {
    if overview.n_missing + overview.n_failed > 0 {
        ExitCode::from(2)
    } else {
        ExitCode::from(u8::from(overview.n_missed > 0))
    }
}
