//! `wherein replay`: runs a localizer on the readings of a recording, or of a log that another program recorded.

use std::{path::PathBuf, process::ExitCode};

use clap::Args;

use super::{CommandError, print, tested::Tested};
use crate::{
    artefacts::{log::replay_log, replay::replay, run_files},
    loading::SceneFile,
    scene::Scene,
};

/// Arguments of `wherein replay`.
#[derive(Debug, Args)]
#[command(after_help = REPLAY_AFTER_HELP)]
pub(super) struct ReplayArguments {
    /// A recording that `wherein run --record` or `--ros2` wrote; with --robot an MCAP file or a bag of rosbag2 that another program wrote.
    #[arg(value_name = "FILE")]
    recording: PathBuf,
    /// Set up the localizer by this scene instead of by the recorded scene.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Read a log that another program recorded, of the robot and the place that this scene describes; its table `[log]` says how the log is read.
    #[arg(long, value_name = "SCENE", conflicts_with = "scene")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    tested: Tested,
    /// Folder for estimate.tum and boxes.csv of the replay; with --robot for a folder of the log's name with summary.json and map.png too.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// With --robot, print the summary as JSON instead of a text.
    #[arg(long, requires = "robot")]
    json: bool,
}

const REPLAY_AFTER_HELP: &str = "\
Exit code: 0 every estimate is the recorded one bit for bit, 1 some are not or the localizer failed, 2 could not replay. With --scene, or with a
--subject that is not the recorded one, estimates may differ; what they are worth says `wherein judge` for the estimate.tum or boxes.csv in --out.

With --robot: 0 nothing speaks against what is declared, 1 a true pose was outside of the boxes, a declared bound was exceeded, readings
contradicted each other, or a limit of [expect] was not kept, 2 could not replay. Messages that cannot be used are dropped and reported
with topic and time. --subject chooses the localizer that is given the log.";

/// Replays a recording, and prints whether the localizer's estimates are equal to the recorded ones where the recorded run tested the same localizer.
pub(super) fn replay_recording(arguments: &ReplayArguments) -> Result<ExitCode, CommandError> {
    if let Some(robot) = &arguments.robot {
        return replay_foreign(arguments, &SceneFile::load(robot)?);
    }
    let other = arguments.scene.as_deref().map(Scene::load).transpose()?;
    let choice = arguments.tested.choice();
    let found = replay(&arguments.recording, other.as_ref(), &choice)?;
    if let Some(folder) = &arguments.out {
        run_files::write_estimates(folder, &found.estimates)?;
    }
    let (run, n_estimates) = (format!("{} seed {}", found.scene, found.seed), found.estimates.len());
    if let Some(failure) = &found.failure {
        print(&format!("{run}: {n_estimates} estimates of {choice}, then {failure}\n"))?;
        return Ok(ExitCode::FAILURE);
    }
    let recorded = &found.recorded_subject;
    if !recorded.is_empty() && *recorded != choice.to_string() {
        print(&format!(
            "{run}: {n_estimates} estimates of {choice}, on the readings of a drive that tested {recorded}\ndigest.estimates {}\n",
            found.digest()
        ))?;
        return Ok(ExitCode::SUCCESS);
    }
    let compared = match found.first_different_s {
        None => "equal to the recorded ones bit for bit".to_owned(),
        Some(time_s) => {
            format!("{} differ from the recorded ones, the first at {time_s:.2} s", found.n_different)
        }
    };
    print(&format!(
        "{run}: {n_estimates} estimates, {compared}\ndigest.estimates {}, recorded {}\n",
        found.digest(),
        found.recorded_digest
    ))?;
    // When the user replays with another scene than the recorded one, different estimates are expected and are no failure.
    let has_failed = found.n_different > 0 && other.is_none();
    Ok(ExitCode::from(u8::from(has_failed)))
}

/// Replays a log that another program recorded, and prints what came of it.
fn replay_foreign(arguments: &ReplayArguments, robot: &SceneFile) -> Result<ExitCode, CommandError> {
    if let Some(folder) = &arguments.out {
        run_files::prepare(folder)?;
    }
    let found = replay_log(robot, &arguments.recording, &arguments.tested.choice())?;
    let folder = arguments.out.as_deref().map(|folder| found.write(folder)).transpose()?;
    if arguments.json {
        print(&format!("{:#}\n", found.summary))?;
    } else {
        let written = folder.map_or_else(String::new, |folder| format!("written to {}\n", folder.display()));
        print(&format!("{}{written}", found.text))?;
    }
    Ok(ExitCode::from(u8::from(!found.passed)))
}
