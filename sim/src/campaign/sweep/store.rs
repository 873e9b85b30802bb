//! The folder of a sweep: `sweep.json`, and in `cases/` one folder for each case, which is written completely or not at all.

use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Write},
    path::{Path, PathBuf},
    process,
};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::{
    artefacts::run_files::{self, Followed, RecordError, naming, replace_whole},
    judge::Verdict,
    run::{FramesPolicy, RunRecord},
};

use super::{Case, Plan, PlannedCase, SweepError};

/// The folder of a sweep, locked against other processes as long as this value lives.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// Open file that holds the lock. The system releases the lock when the process ends, however it ends.
    _lock: File,
}

/// Record of a case in the folder of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub enum Recorded {
    /// The case has run.
    Done {
        /// Contents of the case's `summary.json`.
        summary: Value,
        /// Contents of the case's `timing.json`.
        timing: Value,
    },
    /// The case could not run, for this reason.
    Failed(String),
    /// The case has no record, or none that can be read.
    Missing,
}

/// Contents of `case.json`, a case's record: what identifies the case, and the digests by which its other files can be checked.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Seal {
    id: String,
    set: Vec<String>,
    seed: u64,
    /// Choice of the images for which the case wrote debug frames, pictures of what the vision found.
    frames: String,
    /// Reason why the case could not run, if it could not.
    failure: Option<String>,
    /// SHA-256 of every other file in the case's folder, by its name.
    files: BTreeMap<String, String>,
}

const PLAN: &str = "sweep.json";
const SEAL: &str = "case.json";

impl Store {
    /// Creates or opens the folder of a sweep, makes sure that files can be written there, and locks it.
    pub fn open(folder: &Path) -> Result<Store, SweepError> {
        run_files::prepare(folder)?;
        let store = Store { folder: folder.to_owned(), _lock: lock(folder)? };
        // As the folder is locked, no other process is writing now: a hidden folder in it was left half written by a process that was killed, and is
        // removed.
        remove_hidden(&folder.join("cases"))?;
        Ok(store)
    }

    /// Returns the path of the sweep's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes the plan as `sweep.json`.
    pub fn write_plan(&self, plan: &Plan) -> Result<(), SweepError> {
        // Writing the plan as JSON cannot fail, as all its keys are texts.
        let text = serde_json::to_string_pretty(plan).unwrap_or_default() + "\n";
        Ok(write_whole(&self.folder.join(PLAN), text.as_bytes())?)
    }

    /// Records the run of a case.
    pub fn write(
        &self,
        case: &Case,
        frames: FramesPolicy,
        record: &RunRecord,
        verdict: &Verdict,
    ) -> Result<(), RecordError> {
        replace_whole(&case_folder(&self.folder, &case.planned.id), |partial| {
            run_files::fill(partial, &case.file, record, verdict, Followed::default())?;
            seal(partial, &case.planned, frames, None)
        })
    }

    /// Records that a case could not run, and why.
    pub fn write_failure(&self, case: &Case, frames: FramesPolicy, reason: &str) -> Result<(), RecordError> {
        replace_whole(&case_folder(&self.folder, &case.planned.id), |partial| {
            seal(partial, &case.planned, frames, Some(reason.to_owned()))
        })
    }

    /// Whether the case has run, its files are unchanged since they were written, and the debug frames (pictures of what the vision found) that the
    /// user wants are among them.
    pub fn has(&self, case: &PlannedCase, frames: FramesPolicy) -> bool {
        let folder = case_folder(&self.folder, &case.id);
        let Some(seal) = read_seal(&folder) else { return false };
        let has_frames = frames == FramesPolicy::None || seal.frames == frames.to_string();
        has_frames && seal.failure.is_none() && is_intact(&folder, &seal)
    }

    /// Copies a case, run or failed, from another folder if that folder holds it with unchanged files. Returns whether the case was copied.
    pub fn adopt(&self, id: &str, from: &Path) -> Result<bool, SweepError> {
        let source = case_folder(from, id);
        let Some(seal) = read_seal(&source).filter(|seal| is_intact(&source, seal)) else { return Ok(false) };
        replace_whole(&case_folder(&self.folder, id), |partial| {
            for name in seal.files.keys().map(String::as_str).chain([SEAL]) {
                naming("copy", &source.join(name), fs::copy(source.join(name), partial.join(name)))?;
            }
            Ok(())
        })?;
        Ok(true)
    }
}

/// Reads the plan of the sweep in `folder`; none when the folder holds no sweep.
pub fn read_plan(folder: &Path) -> Result<Option<Plan>, SweepError> {
    let path = folder.join(PLAN);
    if !path.exists() {
        return Ok(None);
    }
    let text = naming("read", &path, fs::read_to_string(&path))?;
    Ok(Some(naming("read", &path, serde_json::from_str(&text).map_err(io::Error::from))?))
}

/// Reads the record of the case `id` in the folder of a sweep.
pub fn read_case(folder: &Path, id: &str) -> Recorded {
    let folder = case_folder(folder, id);
    let Some(seal) = read_seal(&folder) else { return Recorded::Missing };
    if let Some(reason) = seal.failure {
        return Recorded::Failed(reason);
    }
    if !is_intact(&folder, &seal) {
        return Recorded::Failed("its files are not those that were recorded; run the sweep again".to_owned());
    }
    // A record that cannot be read counts as missing: the next sweep into the folder runs the case again.
    match run_files::read(&folder) {
        Ok(Some((summary, timing))) => Recorded::Done { summary, timing },
        _ => Recorded::Missing,
    }
}

/// Returns the folder in which a case is recorded.
pub fn case_folder(folder: &Path, id: &str) -> PathBuf {
    folder.join("cases").join(id)
}

/// Writes a file completely or not at all.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    run_files::replace_file(path, bytes)
}

fn lock(folder: &Path) -> Result<File, SweepError> {
    let path = folder.join(".lock");
    let options = || OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
    let mut file = naming("open", &path, options())?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            let holder = fs::read_to_string(&path).ok().filter(|holder| !holder.is_empty());
            let holder = holder.unwrap_or_else(|| "another process".to_owned());
            return Err(SweepError::Locked { folder: folder.to_owned(), holder });
        }
        // On a network file system without locks the sweep goes on without one; the user has to make sure that no other process writes into the
        // folder.
        Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
        Err(TryLockError::Error(source)) => return Err(SweepError::NoLock { folder: folder.to_owned(), source }),
    }
    let holder = format!("process {}", process::id());
    naming("write", &path, file.set_len(0).and_then(|()| file.write_all(holder.as_bytes())))?;
    Ok(file)
}

/// Deletes the folders that an interrupted sweep has left half written. Hidden files are others': network file systems and desktops make some.
fn remove_hidden(folder: &Path) -> Result<(), RecordError> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    let is_hidden = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
    for entry in entries.flatten().filter(|entry| is_hidden(entry) && entry.path().is_dir()) {
        naming("delete", &entry.path(), fs::remove_dir_all(entry.path()))?;
    }
    Ok(())
}

/// Writes `case.json`, the record of a case, with the digests of all files that are in the case's folder so far.
fn seal(folder: &Path, case: &PlannedCase, frames: FramesPolicy, failure: Option<String>) -> Result<(), RecordError> {
    let mut files = BTreeMap::new();
    for entry in naming("read the folder", folder, fs::read_dir(folder))? {
        let name = naming("read the folder", folder, entry)?.file_name().to_string_lossy().into_owned();
        let digest = naming("read", &folder.join(&name), digest(&folder.join(&name)))?;
        files.insert(name, digest);
    }
    let set = case.settings.iter().map(ToString::to_string).collect();
    let seal = Seal { id: case.id.clone(), set, seed: case.seed, frames: frames.to_string(), failure, files };
    // Writing `case.json` as JSON cannot fail, as all its keys are texts.
    let text = serde_json::to_string_pretty(&seal).unwrap_or_default() + "\n";
    naming("write", &folder.join(SEAL), fs::write(folder.join(SEAL), text))
}

fn read_seal(folder: &Path) -> Option<Seal> {
    let text = fs::read_to_string(folder.join(SEAL)).ok()?;
    let seal: Seal = serde_json::from_str(&text).ok()?;
    let is_own = folder.file_name().is_some_and(|name| name.to_string_lossy() == seal.id);
    is_own.then_some(seal)
}

fn is_intact(folder: &Path, seal: &Seal) -> bool {
    seal.files.iter().all(|(name, sealed)| digest(&folder.join(name)).is_ok_and(|found| found == *sealed))
}

fn digest(path: &Path) -> io::Result<String> {
    Ok(Sha256::digest(fs::read(path)?).iter().map(|byte| format!("{byte:02x}")).collect())
}
