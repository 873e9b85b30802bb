//! `wherein report`: writes the report of a folder that holds a sweep or single runs, or of tables of results.

use std::process::ExitCode;

use crate::{
    artefacts::run_files,
    campaign::{cases::Results, sketch::Sketch, sweep::read_plan},
};

use super::{
    CommandError, ReportArguments,
    conclude::{conclude, conclude_sketch, conclude_sweep},
};

/// Writes report.html, summary.md and results.csv into the folder of the results.
pub(super) fn report_folder(arguments: &ReportArguments) -> Result<ExitCode, CommandError> {
    let ReportArguments { folders, out, outputs } = arguments;
    if let Some(out) = out {
        if let Some(junit) = &outputs.junit {
            return Err(CommandError::TestsOfTables(junit.clone()));
        }
        run_files::prepare(out)?;
        let (sketch, plan) = Sketch::of_tables(folders)?;
        return conclude_sketch(sketch, plan, out, outputs);
    }
    outputs.junit.as_deref().map_or(Ok(()), run_files::prepare_for)?;
    let [folder] = folders.as_slice() else { return Err(CommandError::SeveralReported(folders.len())) };
    match read_plan(folder)? {
        Some(plan) => conclude_sweep(folder, plan, &|_| true, outputs),
        None => conclude(&Results::read(folder)?, folder, outputs),
    }
}
