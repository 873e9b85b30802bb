//! Output that all commands on the results of many runs have in common: result files, a short text for people, an exit code.

use std::{
    io,
    path::{Path, PathBuf},
    process::ExitCode,
};

use crate::{
    artefacts::{result_table::Shown, run_files::naming},
    campaign::{
        cases::Results,
        junit::to_junit,
        report::{self, Overview, as_text},
        sketch::{self, MOST_WHOLE, Sketch},
        sweep::{Plan, write_whole},
    },
};

use super::{CommandError, Outputs, github::tell_github, print};

/// Writes the files of the results into `folder`, prints a short report, and returns the exit code: 0 when all cases passed, 1 when some
/// did not, 2 when some are missing or could not run.
pub(super) fn conclude(results: &Results, folder: &Path, outputs: &Outputs) -> Result<ExitCode, CommandError> {
    if results.cases.is_empty() {
        return Err(CommandError::NoResults(folder.to_owned()));
    }
    let overview = report::write(results, &shown(outputs), folder)?;
    write_junit(results, outputs.junit.as_ref())?;
    print(&as_text(&overview, results))?;
    print(&format!("Recorded in {}: report.html, results.csv, summary.md\n", folder.display()))?;
    tell_github(&overview, results)?;
    Ok(exit_code(&overview))
}

/// The same for those cases of the sweep in `folder` for whose index `is_meant` is true, however many these are. There are none where a sweep has
/// fewer cases than parts, which is no failure.
pub(super) fn conclude_sweep(
    folder: &Path,
    plan: Plan,
    is_meant: &dyn Fn(usize) -> bool,
    outputs: &Outputs,
) -> Result<ExitCode, CommandError> {
    let n_meant = (0..plan.cases.len()).filter(|index| is_meant(*index)).count();
    if n_meant == 0 {
        return conclude_without_cases(&Results::of_sweep(folder, plan, is_meant), folder, outputs);
    }
    if n_meant <= MOST_WHOLE {
        return conclude(&Results::of_sweep(folder, plan, is_meant), folder, outputs);
    }
    let sketch = Sketch::of_sweep(folder, &plan, is_meant)?;
    conclude_sketch(sketch, Some(plan), folder, outputs)
}

/// Writes the files of a part without cases, so that it can be merged and reported on like the other parts.
fn conclude_without_cases(results: &Results, folder: &Path, outputs: &Outputs) -> Result<ExitCode, CommandError> {
    report::write(results, &shown(outputs), folder)?;
    write_junit(results, outputs.junit.as_ref())?;
    let n_cases = results.plan.as_ref().map_or(0, |plan| plan.cases.len());
    print(&format!("This shard has no cases, as the sweep has {n_cases} only\n"))?;
    print(&format!("Recorded in {}: report.html, results.csv, summary.md\n", folder.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// The same for cases whose rows were added up one by one.
pub(super) fn conclude_sketch(
    sketch: Sketch,
    plan: Option<Plan>,
    folder: &Path,
    outputs: &Outputs,
) -> Result<ExitCode, CommandError> {
    let n_cases = sketch.n_cases();
    if n_cases == 0 {
        return Err(CommandError::NoResults(folder.to_owned()));
    }
    let (overview, results) = sketch.finish(plan);
    let overview = Overview { shown: shown(outputs), ..overview };
    sketch::write(&overview, &results, folder)?;
    print(&as_text(&overview, &results))?;
    print(&format!("Recorded in {}: report.html, summary.md\n", folder.display()))?;
    tell_github(&overview, &results)?;
    match &outputs.junit {
        Some(path) => Err(CommandError::TooManyTests { path: path.clone(), n_cases, most: MOST_WHOLE }),
        None => Ok(exit_code(&overview)),
    }
}

/// The figures that the tables of a report have.
fn shown(outputs: &Outputs) -> Shown {
    outputs.columns.clone().unwrap_or_default()
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
