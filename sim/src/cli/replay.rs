//! `wherein replay`: a recording through the localizer again.

use std::process::ExitCode;

use super::{CommandError, ReplayArguments, print};
use crate::{
    artefacts::{replay::replay, run_files},
    scene::Scene,
};

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
