//! `wherein replay`: runs the localizer on a recording again.

use std::{path::PathBuf, process::ExitCode};

use clap::Args;

use super::{CommandError, print};
use crate::{
    artefacts::{replay::replay, run_files},
    scene::Scene,
};

/// Arguments of `wherein replay`.
#[derive(Debug, Args)]
#[command(after_help = REPLAY_AFTER_HELP)]
pub(super) struct ReplayArguments {
    /// A recording that `wherein run --record` or `--ros2` wrote.
    #[arg(value_name = "FILE")]
    recording: PathBuf,
    /// Set up the localizer by this scene instead of by the recorded scene.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Folder for estimate.tum and boxes.csv of the replay.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

const REPLAY_AFTER_HELP: &str = "\
Exit code: 0 every estimate is the recorded one bit for bit, 1 some are not, 2 could not replay. With --scene estimates may differ.";

/// Replays a recording and prints whether the localizer's estimates are equal to the recorded ones.
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
    // When the user replays with another scene than the recorded one, different estimates are expected and are no failure.
    let has_failed = found.n_different > 0 && other.is_none();
    Ok(ExitCode::from(u8::from(has_failed)))
}
