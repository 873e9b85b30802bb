//! `wherein report`: writes the report of a folder that holds a sweep or single runs.

use std::process::ExitCode;

use crate::campaign::cases::Results;

use super::{CommandError, ReportArguments, conclude::conclude};

/// Writes report.html, summary.md and results.csv into the folder of the results.
pub(super) fn report_folder(arguments: &ReportArguments) -> Result<ExitCode, CommandError> {
    let results = Results::read(&arguments.folder)?;
    conclude(&results, &arguments.folder, &arguments.outputs)
}
