//! `wherein markers`: a sheet of ceiling markers to print, and a map of where to paste them.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use clap::Args;

use super::{CommandError, print};
use crate::{
    artefacts::marker_sheet::marker_sheet,
    loading::{
        SceneFile,
        coverage::{Coverage, coverage},
    },
};

/// Arguments of `wherein markers`.
#[derive(Debug, Args)]
#[command(after_help = MARKERS_AFTER_HELP)]
pub(super) struct MarkersArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Folder for the results. The sheet and the map are written into a subfolder with the scene's name.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

const MARKERS_AFTER_HELP: &str = "\
Writes DIR/<scene>/markers.pdf, one marker a page of A4 at true scale, and DIR/<scene>/markers.toml, the keys of a scene
that place them one by one. Files that are there already are left alone: exit code 2.";

/// Prints the ceiling markers of a scene and whether the ceiling camera sees enough of them from every pose in the room, and writes the printable
/// sheet and the map of the markers.
pub(super) fn markers(arguments: &MarkersArguments) -> Result<(), CommandError> {
    let file = SceneFile::load(&arguments.scene)?;
    let no_markers = || CommandError::NoCeilingMarkers(arguments.scene.clone());
    let markers = file.scene.markers.as_ref().filter(|markers| !markers.all().is_empty()).ok_or_else(no_markers)?;
    let folder = arguments.out.join(&file.name);
    let [sheet, map] = ["markers.pdf", "markers.toml"].map(|name| folder.join(name));
    if let Some(path) = [&sheet, &map].into_iter().find(|path| path.exists()) {
        return Err(CommandError::Exists(path.clone()));
    }
    let mut table = format!("{:>5} {:>8} {:>8} {:>8} {:>8}\n", "id", "x m", "y m", "turn °", "height m");
    for marker in markers.all().iter().filter(|marker| marker.on_map) {
        let height_m = markers.height_m(marker, &file.scene);
        table += &format!(
            "{:>5} {:>8.3} {:>8.3} {:>8.1} {height_m:>8.3}\n",
            marker.id, marker.x_m, marker.y_m, marker.rotation_deg
        );
    }
    print(&table)?;
    print(&verdict(&file))?;
    fs::create_dir_all(&folder).map_err(|error| CommandError::Unwritable(folder.clone(), error))?;
    write(&sheet, marker_sheet(&file.scene, markers))?;
    write(&map, markers.keys().map_err(|error| CommandError::Unwritable(map.clone(), io::Error::other(error)))?)
}

fn verdict(file: &SceneFile) -> String {
    let seen_at_once = file.scene.markers.as_ref().map_or(1, |markers| markers.goal().seen_at_once);
    match coverage(&file.scene) {
        None => "No ceiling camera whose coverage could be told.\n".to_owned(),
        Some(Coverage::Covered) => {
            let rooms = &file.scene.building.rooms;
            let further = if rooms.is_empty() { "" } else { " and in each `[[building.room]]` that is a rectangle" };
            format!(
                "Covered: at least {seen_at_once} wholly in the image from every pose in `[room]`{further} while it is empty, within all tolerances.\n"
            )
        }
        Some(Coverage::Uncovered { pose, .. }) => format!(
            "Not covered: fewer than {seen_at_once} surely in the image at x {:.3} m, y {:.3} m, heading {:.1}°.\n",
            pose.x_m,
            pose.y_m,
            pose.heading_rad.to_degrees()
        ),
    }
}

fn write(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), CommandError> {
    fs::write(path, contents).map_err(|error| CommandError::Unwritable(path.to_owned(), error))?;
    print(&format!("{}\n", path.display()))
}
