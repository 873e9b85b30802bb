//! `wherein replay`: a recording through the localizer again.

use std::{path::PathBuf, process::ExitCode};

use clap::Args;

use super::{CommandError, print};
use crate::{
    artefacts::{replay::replay, run_files},
    scene::Scene,
};

/// What `wherein replay` is asked.
#[derive(Debug, Args)]
#[command(after_help = REPLAY_AFTER_HELP)]
pub(super) struct ReplayArguments {
    /// A recording that `wherein run --record` or `--ros2` left.
    #[arg(value_name = "FILE")]
    recording: PathBuf,
    /// Set up the localizer as this scene does instead of the recorded one.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Write estimate.tum and boxes.csv of the replay there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

const REPLAY_AFTER_HELP: &str = "\
Exit code: 0 every estimate is the recorded one bit for bit, 1 some are not, 2 could not replay. With --scene estimates may differ.";

/// Replays a recording and says whether the localizer answered as it did then.
pub(super) fn replay_recording(arguments: &ReplayArguments) -> Result<ExitCode, CommandError> {
    let other = arguments.scene.as_deref().map(Scene::load).transpose()?;
    let found = replay(&arguments.recording, other.as_ref())?;
    if let Some(folder) = &arguments.out {
        run_files::write_estimates(folder, &found.estimates)?;
    }
    let n_estimates = found.estimates.len();
    let compared = match found.first_different_s {
        None => "equal to the recorded ones bit for bit".to_owned(),
        Some(time_s) => {
            format!("{} differ from the recorded ones, the first at {time_s:.2} s", found.n_different)
        }
    };
    print(&format!(
        "{} seed {}: {n_estimates} estimates, {compared}\ndigest.estimates {}, recorded {}\n",
        found.scene,
        found.seed,
        found.digest(),
        found.recorded_digest
    ))?;
    // Another localizer is expected to answer differently.
    let has_failed = found.n_different > 0 && other.is_none();
    Ok(ExitCode::from(u8::from(has_failed)))
}
