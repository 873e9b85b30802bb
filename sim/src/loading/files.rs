//! Scene files: reads one, and finds all below a folder.

use std::{
    collections::BTreeMap,
    ffi::OsStr,
    fs, io,
    path::{Path, PathBuf},
};

use super::{Setting, parse};
use crate::scene::{Scene, SceneError, Sources};

/// End of the names of files that other scene files extend but that are not scenes themselves.
const BASE_ENDING: &str = ".base.toml";

/// A scene, the file that it came from, and the name under which its runs are recorded.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Name of the scene: path of its file below the nearest folder called `scenes`, without the ending, such as `papers/floor_vision_odometry`.
    pub name: String,
    /// Path of the scene's file.
    pub path: PathBuf,
    /// Keys of the scene that are set to other values than its file states.
    pub settings: Vec<Setting>,
    /// Text of the scene as it was read from its file. If `settings` change keys, or if the file extends another, it is instead one new text of the
    /// whole scene.
    pub text: String,
    /// Scene that the text states.
    pub scene: Scene,
}

impl Scene {
    /// Reads a scene file and the files that it extends.
    pub fn load(path: &Path) -> Result<Scene, SceneError> {
        SceneFile::load(path).map(|file| file.scene)
    }
}

impl SceneFile {
    /// Reads a scene's file and the files that it extends, and gives the scene its name.
    pub fn load(path: &Path) -> Result<SceneFile, SceneError> {
        let (scene, text) = parse::read(Sources::load(path)?, path.parent())?;
        Ok(SceneFile { name: name_of(path), settings: Vec::new(), text, scene, path: path.to_owned() })
    }

    /// Reads every scene that `paths` name. A folder stands for all scenes below it, in the order of their paths, except files that end in
    /// `.base.toml`.
    pub fn load_all(paths: &[PathBuf]) -> Result<Vec<SceneFile>, SceneError> {
        let mut files = Vec::new();
        for path in paths {
            if path.is_dir() {
                let before = files.len();
                collect(path, &|name| !name.ends_with(BASE_ENDING), &mut files)?;
                if files.len() == before {
                    return Err(SceneError::NoScenes { folder: path.clone() });
                }
            } else {
                files.push(path.clone());
            }
        }
        let mut by_name: BTreeMap<String, PathBuf> = BTreeMap::new();
        let mut scenes = Vec::new();
        for path in files {
            let name = name_of(&path);
            match by_name.insert(name.clone(), path.clone()) {
                // A file that is named twice runs only once.
                Some(first) if first == path => continue,
                Some(first) => return Err(SceneError::SameName { name, first, second: path }),
                None => scenes.push(SceneFile::load(&path)?),
            }
        }
        Ok(scenes)
    }
}

/// The files that `paths` name: files as they are, and for each folder all files below it that end in `.toml`, which are scenes and what they extend.
pub(crate) fn texts(paths: &[PathBuf]) -> Result<Vec<PathBuf>, SceneError> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            collect(path, &|_| true, &mut files)?;
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

/// Adds all files below a folder that end in `.toml` and whose path is wanted, in the order of their paths.
fn collect(folder: &Path, is_wanted: &dyn Fn(&str) -> bool, files: &mut Vec<PathBuf>) -> Result<(), SceneError> {
    let unreadable = |source: io::Error| SceneError::Unreadable { path: folder.to_owned(), source };
    let entries: io::Result<Vec<PathBuf>> =
        fs::read_dir(folder).map_err(unreadable)?.map(|entry| Ok(entry?.path())).collect();
    let mut entries = entries.map_err(unreadable)?;
    entries.sort();
    for path in entries {
        if path.is_dir() {
            collect(&path, is_wanted, files)?;
        } else if path.extension() == Some(OsStr::new("toml")) && is_wanted(&path.to_string_lossy()) {
            files.push(path);
        }
    }
    Ok(())
}

fn name_of(path: &Path) -> String {
    let stem = path.with_extension("");
    let parts: Vec<_> = stem.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    let file = parts.len().saturating_sub(1);
    let first = parts[..file].iter().rposition(|part| part == "scenes").map_or(file, |at| at + 1);
    parts[first..].join("/")
}
