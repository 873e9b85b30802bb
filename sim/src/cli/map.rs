//! `wherein map`: the grid on which errands are planned, for other programs.

use std::{path::PathBuf, slice};

use clap::Args;

use crate::{
    artefacts::run_files,
    loading::SceneFile,
    navigation::{OccupancyGrid, map_server},
};

use super::{CommandError, print};

/// What `wherein map` is asked.
#[derive(Debug, Args)]
pub(super) struct MapArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Where map.yaml and map.pgm go, below the scene's name.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

/// Writes the map and prints where.
pub(super) fn write_map(arguments: &MapArguments) -> Result<(), CommandError> {
    for file in SceneFile::load_all(slice::from_ref(&arguments.scene))? {
        let folder = arguments.out.join(&file.name);
        run_files::prepare(&folder)?;
        let path = map_server::write(&OccupancyGrid::of(&file.scene), &folder, "map")?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(())
}
