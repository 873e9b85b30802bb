//! Output that all commands on the results of many runs have in common: result files, a short text for people, an exit code.

use std::{
    io,
    path::{Path, PathBuf},
    process::ExitCode,
};

use crate::{
    artefacts::run_files::naming,
    campaign::{
        cases::Results,
        junit::to_junit,
        report::{self, Overview, as_text},
        sweep::write_whole,
    },
};

use super::{CommandError, Outputs, github::tell_github, print};

/// Writes the files of the results into `folder`, prints a short report, and returns the exit code: 0 when all cases passed, 1 when some
/// did not, 2 when some are missing or could not run.
pub(super) fn conclude(results: &Results, folder: &Path, outputs: &Outputs) -> Result<ExitCode, CommandError> {
    if results.cases.is_empty() {
        return Err(CommandError::NoResults(folder.to_owned()));
    }
    let overview = report::write(results, folder)?;
    write_junit(results, outputs.junit.as_ref())?;
    print(&as_text(&overview, results))?;
    print(&format!("Recorded in {}: report.html, results.csv, summary.md\n", folder.display()))?;
    tell_github(&overview, results)?;
    Ok(exit_code(&overview))
}

/// Writes the results as JUnit XML if the user has named a file for it.
pub(super) fn write_junit(results: &Results, path: Option<&PathBuf>) -> Result<(), CommandError> {
    let Some(path) = path else { return Ok(()) };
    let text = naming("write", path, to_junit(results).map_err(io::Error::other))?;
    Ok(write_whole(path, text.as_bytes())?)
}

fn exit_code(overview: &Overview) -> ExitCode {
    if overview.n_missing + overview.n_failed > 0 {
        ExitCode::from(2)
    } else {
        ExitCode::from(u8::from(overview.n_missed > 0))
    }
}
