//! Layouts of ceiling markers that were found earlier, kept in files, because the search takes many seconds in a large hall and is the same each time.
//!
//! A file's name is a digest of everything that the layout depends on: the field of view, the ceiling, and the program text that lays out. A layout
//! from a file is therefore the one that the search would find. A file that is missing, damaged or unwritable costs only the time of the search.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use super::{Ceiling, Field, Place, Unlaid, smallest};

/// Environment variable that names the folder for files that spare time; an empty value keeps no files.
const FOLDER_VARIABLE: &str = "WHEREIN_CACHE";
/// Number of markers from which on a layout is kept. A layout of fewer is found in less than a second.
const WORTH_KEEPING: usize = 100;
/// Program text that decides how markers are laid out. It is a part of each digest, so that a changed search finds no layouts of the former one.
const SEARCH: [&str; 3] = [include_str!("../coverage.rs"), include_str!("field.rs"), include_str!("lattice.rs")];

/// The layout that [`smallest`] finds, from a file if an earlier run has left one.
pub fn smallest_kept(field: &Field, ceiling: &Ceiling) -> Result<Vec<Place>, Unlaid> {
    kept_in(folder().as_deref(), field, ceiling, smallest)
}

/// The layout that `search` finds, from a file in the folder if there is one; otherwise it is searched for, and kept there if it is large.
fn kept_in(
    folder: Option<&Path>,
    field: &Field,
    ceiling: &Ceiling,
    search: impl FnOnce(&Field, &Ceiling) -> Result<Vec<Place>, Unlaid>,
) -> Result<Vec<Place>, Unlaid> {
    let path = folder.map(|folder| folder.join(format!("{}.markers", digest_of(&asked(field, ceiling)))));
    if let Some(places) = path.as_deref().and_then(|path| places_in(&fs::read_to_string(path).ok()?)) {
        return Ok(places);
    }
    let places = search(field, ceiling)?;
    if let Some(path) = path.filter(|_| places.len() >= WORTH_KEEPING) {
        keep(&path, &places);
    }
    Ok(places)
}

/// Folder for the user's files that spare time, as the operating system has it; `None` if there is none or none is wanted.
fn folder() -> Option<PathBuf> {
    let stated = |name: &str| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    if env::var_os(FOLDER_VARIABLE).is_some() {
        return stated(FOLDER_VARIABLE);
    }
    let of_system = stated("XDG_CACHE_HOME").or_else(|| stated("LOCALAPPDATA"));
    Some(of_system.or_else(|| Some(stated("HOME")?.join(".cache")))?.join("wherein"))
}

/// Everything that a layout depends on, as text. Numbers are written so that different ones have different texts.
fn asked(field: &Field, ceiling: &Ceiling) -> String {
    format!("{field:?}\n{ceiling:?}\n{}", SEARCH.concat())
}

fn digest_of(text: &str) -> String {
    Sha256::digest(text).iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// The places in the text of a file; `None` if the text is not whole.
fn places_in(text: &str) -> Option<Vec<Place>> {
    let (digest, places) = text.split_once('\n')?;
    if digest != digest_of(places) {
        return None;
    }
    let place = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
        Place::try_from(numbers).ok()
    };
    places.lines().map(place).collect()
}

/// Writes places into a file: a digest of the rest first, then a line for each place. What cannot be written is left out.
fn keep(path: &Path, places: &[Place]) {
    let lines: String = places.iter().map(|[x_m, y_m, z_m]| format!("{x_m:?} {y_m:?} {z_m:?}\n")).collect();
    // The file gets its name when it is whole, as other processes may look for it meanwhile.
    let unfinished = path.with_extension(format!("{}.part", std::process::id()));
    let written = path.parent().is_some_and(|folder| fs::create_dir_all(folder).is_ok())
        && fs::write(&unfinished, format!("{}\n{lines}", digest_of(&lines))).is_ok();
    if !written || fs::rename(&unfinished, path).is_err() {
        drop(fs::remove_file(&unfinished));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn hall() -> (Field, Ceiling) {
        let text = "[room]\nwidth_m = 6.0\ndepth_m = 4.0\n[robot.ceiling_camera]\n[markers]\n[start]\nx_m = 1.0\ny_m = 1.0\n\
                    [[route.waypoint]]\nx_m = 2.0\ny_m = 1.0\n";
        let scene = Scene::parse(text, "hall.toml").unwrap();
        let ceiling = Ceiling {
            reach_m: [[0.2, 5.8], [0.2, 3.8]],
            markers_m: [[0.1, 5.9], [0.1, 3.9]],
            height_m: 2.5,
            seen_at_once: 2,
            most_markers: 4096,
        };
        (Field::new(&scene, 4.0).unwrap(), ceiling)
    }

    fn lattice(n_markers: usize) -> Vec<Place> {
        (0..n_markers).map(|index| [index as f64 / 3.0, 1.0 / (index as f64 + 0.7), 2.5]).collect()
    }

    /// An empty folder for one test.
    fn empty_folder(test: &str) -> PathBuf {
        let folder = env::temp_dir().join(format!("wherein_{test}_{}", std::process::id()));
        drop(fs::remove_dir_all(&folder));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn a_large_layout_is_searched_for_once_and_comes_back_to_the_last_bit() {
        let folder = empty_folder("kept_once");
        let (field, ceiling) = hall();
        let first = kept_in(Some(&folder), &field, &ceiling, |_, _| Ok(lattice(150)));
        let again = kept_in(Some(&folder), &field, &ceiling, |_, _| unreachable!("it is kept"));
        assert_eq!((first, again), (Ok(lattice(150)), Ok(lattice(150))));
        // Another ceiling has another layout.
        let higher = Ceiling { height_m: 2.6, ..ceiling };
        assert_eq!(kept_in(Some(&folder), &field, &higher, |_, _| Ok(lattice(120))), Ok(lattice(120)));
    }

    #[test]
    fn a_damaged_file_is_searched_for_anew_and_small_layouts_leave_none() {
        let folder = empty_folder("kept_damaged");
        let (field, ceiling) = hall();
        assert_eq!(kept_in(Some(&folder), &field, &ceiling, |_, _| Ok(lattice(20))), Ok(lattice(20)));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
        assert_eq!(kept_in(Some(&folder), &field, &ceiling, |_, _| Ok(lattice(150))), Ok(lattice(150)));
        let file = fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, &text[..text.len() - 30]).unwrap();
        assert_eq!(kept_in(Some(&folder), &field, &ceiling, |_, _| Ok(lattice(151))), Ok(lattice(151)));
    }

    #[test]
    fn no_folder_and_no_layout_leave_nothing() {
        let (field, ceiling) = hall();
        assert_eq!(kept_in(None, &field, &ceiling, |_, _| Ok(lattice(150))), Ok(lattice(150)));
        let folder = empty_folder("kept_none");
        let none = kept_in(Some(&folder), &field, &ceiling, |_, _| Err(Unlaid::TooMany(7)));
        assert_eq!(none, Err(Unlaid::TooMany(7)));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    }
}
