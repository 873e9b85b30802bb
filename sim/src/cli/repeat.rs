//! `wherein repeat`: drives by a map of landmarks that an earlier drive has learnt.

use std::{path::PathBuf, process::ExitCode};

use clap::Args;

use crate::{
    artefacts::{
        run_files::{folder, read},
        seen_again,
    },
    loading::Setting,
    place::landmark_map,
    scene::MethodName,
};

use super::{
    CommandError, print,
    run::{RunArguments, run_scenes},
};

/// Arguments of `wherein repeat`.
#[derive(Debug, Args)]
#[command(after_help = REPEAT_AFTER_HELP)]
pub(super) struct RepeatArguments {
    #[command(flatten)]
    run: RunArguments,
    /// Map that `wherein teach` has written.
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
}

const REPEAT_AFTER_HELP: &str = "\
The same as `wherein run` with the key `localizer.mapped_landmarks.map` set to the file. The scene may have another start, other
errors and another camera than that of the drive that has learnt the map; its room must be the same.";

/// Runs the scenes with the map.
pub(super) fn repeat(mut arguments: RepeatArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    if let Some(subject) = arguments.run.tested.other() {
        return Err(CommandError::KnowsNoMap { command: "repeat a drive by a map", subject });
    }
    // A file that is no map is refused by its own name, before any scene is read.
    landmark_map::read(&arguments.map)?;
    let methods = MethodName::MappedLandmarks;
    if let Some(file) = arguments.run.which.load()?.iter().find(|file| !file.scene.localizer.methods.contains(&methods))
    {
        return Err(CommandError::UsesNoMap(file.path.clone()));
    }
    let path = std::fs::canonicalize(&arguments.map)?;
    let quoted = toml::Value::String(path.to_string_lossy().into_owned());
    let setting: Setting = format!("localizer.mapped_landmarks.map={quoted}").parse().map_err(CommandError::Setting)?;
    arguments.run.which.set.push(setting);
    let outcome = run_scenes(&arguments.run, adapter)?;
    for file in &arguments.run.which.load()? {
        for seed in arguments.run.which.seeds() {
            let summary = read(&folder(&arguments.run.out, &file.name, seed))?.map(|(summary, _)| summary);
            if let Some(told) = summary.as_ref().and_then(seen_again::in_words) {
                print(&format!("{}, seed {seed}: {told}\n", file.name))?;
            }
        }
    }
    Ok(outcome)
}
