//! `wherein teach`: a drive that learns where landmarks are, and a map of them for later drives.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::Args;
use localizer::map::things;
use serde_json::Value;

use crate::{
    artefacts::run_files::{LANDMARKS, folder, prepare_for, read, replace_file},
    place::landmark_map,
    scene::MethodName,
};

use super::{
    CommandError, print,
    run::{RunArguments, run_scenes},
};

/// Arguments of `wherein teach`.
#[derive(Debug, Args)]
#[command(after_help = TEACH_AFTER_HELP)]
pub(super) struct TeachArguments {
    #[command(flatten)]
    run: RunArguments,
    /// File for the map. An existing map is replaced when the drive is over and its expectations are met, never before.
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
}

const TEACH_AFTER_HELP: &str = "\
The scene's localizer needs the method `mapped_landmarks`, and another one that tells where the robot is, such as
`gnss_positions`, `ceiling_markers` or `floor_tiles`. The map has every landmark as a ray with a bounded inverse depth, and
the names of the bounds that it relies on. `wherein repeat` uses it.
Exit code: 0 the map is written; 1 no map is written, as the drive did not meet its expectations or broke a declared bound;
2 could not run.";

/// Runs the scene and keeps the map that its localizer has learnt.
pub(super) fn teach(mut arguments: TeachArguments, adapter: Option<&str>) -> Result<ExitCode, CommandError> {
    if let Some(subject) = arguments.run.tested.other() {
        return Err(CommandError::KnowsNoMap { command: "teach a map", subject });
    }
    let files = arguments.run.which.load()?;
    let [file] = &files[..] else { return Err(CommandError::SeveralTaught(files.len())) };
    let seeds = arguments.run.which.seeds();
    if seeds.end - seeds.start != 1 {
        return Err(CommandError::SeveralTaught((seeds.end - seeds.start) as usize));
    }
    let setup = file.scene.localizer.mapped_landmarks();
    if !file.scene.localizer.methods.contains(&MethodName::MappedLandmarks) {
        return Err(CommandError::TeachesNothing {
            scene: file.path.clone(),
            key: "localizer.methods",
            expected: "`mapped_landmarks` among them",
        });
    }
    if file.scene.localizer.methods == [MethodName::MappedLandmarks] {
        return Err(CommandError::TeachesNothing {
            scene: file.path.clone(),
            key: "localizer.methods",
            expected: "a teacher beside `mapped_landmarks`, such as `gnss_positions`, `ceiling_markers` or `floor_tiles`",
        });
    }
    if !setup.learns {
        return Err(CommandError::TeachesNothing {
            scene: file.path.clone(),
            key: "localizer.mapped_landmarks.learns",
            expected: "true",
        });
    }
    if arguments.map.is_dir() {
        return Err(CommandError::Unwritable(arguments.map, io::ErrorKind::IsADirectory.into()));
    }
    if arguments.map.exists() && !landmark_map::is_one(&arguments.map) {
        return Err(CommandError::NoMapToReplace(arguments.map));
    }
    // Folders that were made for a map which is not written are removed again.
    let _made = MissingFolders::of(&arguments.map);
    prepare_for(&arguments.map)?;
    arguments.run.which.set.push("localizer.mapped_landmarks.teaches=true".parse().map_err(CommandError::Setting)?);
    let outcome = run_scenes(&arguments.run, adapter)?;
    if outcome != ExitCode::SUCCESS {
        print("No map is written: the drive did not meet its expectations.\n")?;
        return Ok(outcome);
    }
    let folder = folder(&arguments.run.out, &file.name, seeds.start);
    let summary = read(&folder)?.map(|(summary, _)| summary).unwrap_or_default();
    let containment = &summary["containment"];
    // Whatever the scene expects: what was learnt while a bound was broken may be false for ever.
    let is_kept =
        containment["contained"] == containment["checks"] && summary["violations"].as_array().is_none_or(Vec::is_empty);
    if !is_kept {
        print(
            "No map is written: a declared bound was broken on the drive, and what was learnt since may be false.\n",
        )?;
        return Ok(ExitCode::from(1));
    }
    let learnt = folder.join(LANDMARKS);
    let text = fs::read_to_string(&learnt).map_err(|_| CommandError::LearntNothing(file.path.clone()))?;
    replace_file(&arguments.map, &text)?;
    let map = landmark_map::read(&arguments.map)?;
    let things: BTreeSet<u32> = things(&map.landmarks).into_values().collect();
    let n_bounded = map.landmarks.iter().filter(|(_, point)| point.place_m().is_some()).count();
    print(&format!(
        "Map of {} landmarks on {} things, the depth of {n_bounded} of them bounded: {}\n{}",
        map.landmarks.len(),
        things.len(),
        arguments.map.display(),
        boxes_in_words(&summary["metrics"])
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The folders of a file that do not exist; those that are empty when this is dropped are removed.
struct MissingFolders(Vec<PathBuf>);

impl MissingFolders {
    fn of(file: &Path) -> MissingFolders {
        let folders = file.ancestors().skip(1).take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        MissingFolders(folders.map(Path::to_owned).collect())
    }
}

impl Drop for MissingFolders {
    fn drop(&mut self) {
        // A folder with something in it stays: that it cannot be removed is as it should be.
        self.0.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

/// A sentence on how large the boxes of the map's landmarks are, by the figures of the drive; empty where it has none.
fn boxes_in_words(metrics: &Value) -> String {
    let figure = |name: &str| metrics[name].as_f64();
    let share = |most: &str| Some(100.0 * figure(&format!("map_boxes_below_{most}_m3_share"))?);
    let [Some(small), Some(middle), Some(large)] = ["0_001", "0_004", "0_008"].map(share) else { return String::new() };
    let median = figure("map_box_median_m3").map_or("unbounded".to_owned(), |median_m3| format!("{median_m3:.4} m³"));
    format!(
        "Boxes of landmarks: {median} at the median; {small:.0} %, {middle:.0} % and {large:.0} % of them are below 0.001, 0.004 and 0.008 m³.\n"
    )
}
