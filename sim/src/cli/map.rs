//! `wherein map`: the grid on which errands are planned, for other programs.

use std::slice;

use crate::{
    artefacts::run_files,
    loading::SceneFile,
    navigation::{OccupancyGrid, map_server},
};

use super::{CommandError, MapArguments, print};

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
