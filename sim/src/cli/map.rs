//! `wherein map`: the occupancy grid on which errands are planned, written for other programs.

use std::{path::PathBuf, slice};

use clap::Args;

use crate::{
    artefacts::run_files,
    loading::SceneFile,
    place::navigation::{OccupancyGrid, map_server},
};

use super::{CommandError, print, reading::while_reading};

/// Arguments of `wherein map`.
#[derive(Debug, Args)]
pub(super) struct MapArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Folder for the results. The files map.yaml and map.pgm are written into a subfolder with the scene's name.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

/// Writes the map of each scene and prints the path of its file.
pub(super) fn write_map(arguments: &MapArguments) -> Result<(), CommandError> {
    let files = while_reading(|| SceneFile::load_all(slice::from_ref(&arguments.scene)))?;
    for file in files {
        let folder = arguments.out.join(&file.name);
        run_files::prepare(&folder)?;
        let path = map_server::write(&OccupancyGrid::of(&file.scene), &folder, "map")?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(())
}
