//! Folders of runs below a folder.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use super::{RecordError, naming};

/// The folders below `folder`, itself included, that hold a run, in the order of their paths. Folders with hidden names are left out, and those for
/// which `enters` is false. A folder to which several links lead is found once, so that links in a circle end.
pub fn run_folders(folder: &Path, enters: &dyn Fn(&Path) -> bool) -> Result<Vec<PathBuf>, RecordError> {
    let mut found = Vec::new();
    walk(folder, enters, &mut BTreeSet::new(), &mut found)?;
    found.sort();
    Ok(found)
}

fn walk(
    folder: &Path,
    enters: &dyn Fn(&Path) -> bool,
    seen: &mut BTreeSet<PathBuf>,
    found: &mut Vec<PathBuf>,
) -> Result<(), RecordError> {
    if !seen.insert(naming("read the folder", folder, fs::canonicalize(folder))?) {
        return Ok(());
    }
    if folder.join("summary.json").exists() {
        found.push(folder.to_owned());
        return Ok(());
    }
    let entries = naming("read the folder", folder, fs::read_dir(folder))?;
    let mut below: Vec<PathBuf> = Vec::new();
    for entry in entries {
        let path = naming("read the folder", folder, entry)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() && !is_hidden && enters(&path) {
            below.push(path);
        }
    }
    // Of two links to one folder the first by name counts, whatever the order in which the system lists them; folders come before links.
    below.sort_by_key(|path| (path.is_symlink(), path.clone()));
    below.iter().try_for_each(|path| walk(path, enters, seen, found))
}
