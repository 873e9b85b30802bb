//! `wherein judge`: compares estimates of any program with the true poses of a recording.

use std::{path::PathBuf, process::ExitCode};

use clap::Args;

use super::{CommandError, print};
use crate::artefacts::log::judge_estimates;

/// Arguments of `wherein judge`.
#[derive(Debug, Args)]
#[command(after_help = JUDGE_AFTER_HELP)]
pub(super) struct JudgeArguments {
    /// A recording that `wherein run --record` or `--ros2` wrote.
    #[arg(value_name = "RECORDING")]
    recording: PathBuf,
    /// The estimates: boxes in a file that ends in .csv, as boxes.csv of a run, or poses in any other file, in the TUM format. Times are seconds since the
    /// begin of the run.
    #[arg(long, value_name = "FILE")]
    estimate: PathBuf,
    /// Print a JSON object instead of a text.
    #[arg(long)]
    json: bool,
}

const JUDGE_AFTER_HELP: &str = "\
The run is not simulated again, so that the program that made the estimates may be any, at any time. Boxes are checked for whether they
hold the true pose, and measured; of boxes and poses the error is told. A heading is right up to whole turns.
Exit code: 0 every box holds the true pose, or the file has poses, 1 some box does not, 2 the files could not be compared.";

/// Compares a file of estimates with a recording and prints what was found.
pub(super) fn judge(arguments: &JudgeArguments) -> Result<ExitCode, CommandError> {
    let found = judge_estimates(&arguments.recording, &arguments.estimate)?;
    print(&if arguments.json { format!("{:#}\n", found.summary) } else { found.text })?;
    Ok(ExitCode::from(u8::from(!found.passed)))
}
