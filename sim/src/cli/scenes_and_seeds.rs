//! Arguments that name the runs of a command: scenes, seeds, and keys set for all of them.

use std::{ops::Range, path::PathBuf};

use clap::Args;

use crate::{
    campaign::sweep::Seeds,
    loading::{SceneFile, SceneTemplate, Setting},
    scene::SceneError,
};

use super::{CommandError, reading::while_reading};

/// Arguments that name the runs of a command.
#[derive(Debug, Args)]
pub(super) struct ScenesAndSeeds {
    /// Scene files, or folders that stand for all scenes below them.
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Seed of everything that is drawn at random in the run.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "seeds", allow_negative_numbers = true, value_parser = one_seed)]
    seed: u64,
    /// Range of seeds, A included and B not; each scene runs with each of these seeds.
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    seeds: Option<Seeds>,
    /// Set a key of the scenes, such as robot.errors=corner; may be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    pub(super) set: Vec<Setting>,
}

/// A seed as an argument states it.
pub(super) fn one_seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| {
        "expected a whole number of at least 0; a range A..B of several is an argument of its own".to_owned()
    })
}

impl ScenesAndSeeds {
    /// Loads the scenes, with the keys that are set. Errors for a file that is no valid scene, or becomes none by what is set.
    pub(super) fn load(&self) -> Result<Vec<SceneFile>, CommandError> {
        let load = || -> Result<Vec<SceneFile>, SceneError> {
            let files = SceneFile::load_all(&self.paths)?;
            if self.set.is_empty() {
                return Ok(files);
            }
            files.iter().map(|file| SceneTemplate::load(&file.path)?.with(&self.set)).collect()
        };
        Ok(while_reading(load)?)
    }

    /// Seeds with which each scene runs.
    pub(super) fn seeds(&self) -> Range<u64> {
        self.seeds.clone().map_or(self.seed..self.seed + 1, |Seeds(seeds)| seeds)
    }
}
