//! `wherein upgrade`: rewrites scenes of older versions whose keys have moved.

use std::{fs, path::PathBuf};

use clap::Args;

use crate::{
    artefacts::run_files,
    loading::{self, Upgraded, upgraded},
    scene::text_of,
};

use super::{CommandError, print};

/// Arguments of `wherein upgrade`.
#[derive(Debug, Args)]
pub(super) struct UpgradeArguments {
    /// Scene files, files that scenes extend, and folders of such files.
    #[arg(value_name = "SCENE", required = true)]
    paths: Vec<PathBuf>,
}

/// Rewrites each file in place and prints which keys were moved. No file is written before all of them have been read.
pub(super) fn upgrade(arguments: &UpgradeArguments) -> Result<(), CommandError> {
    let mut files = Vec::new();
    for path in loading::texts(&arguments.paths)? {
        let text = text_of(&path)?;
        let upgraded = upgraded(&text).map_err(|error| CommandError::Upgrade(path.clone(), error))?;
        files.push((path, upgraded));
    }
    for (path, Upgraded { text, moved }) in files {
        if moved.is_empty() {
            print(&format!("{}: nothing to change\n", path.display()))?;
            continue;
        }
        // A link to a file stays a link, and the file itself is rewritten.
        let file = fs::canonicalize(&path).unwrap_or_else(|_| path.clone());
        run_files::replace_file(&file, &text)?;
        for (before, now) in moved {
            print(&format!("{}: {before} is now {now}\n", path.display()))?;
        }
    }
    Ok(())
}
