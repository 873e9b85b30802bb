//! Journal of a search for failing scenes: a file with one line for each case that is done, so that a search can continue where it stopped.

use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::artefacts::run_files::{self, RecordError, naming, program_digest};

use super::{FalsifyError, Profile, probe::Witnesses, wish::Hit};

/// Record of a case of the search that is done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Number of the case in the search.
    pub case: u64,
    /// Seed of the case's run.
    pub run_seed: u64,
    /// Invalid keys of the scenes that were drawn and refused before a valid scene was drawn for the case.
    pub refused: Vec<String>,
    /// Number of steps of the run whose estimates were checked against the truth; 0 for a run that did not reach its end.
    pub steps: usize,
    /// Simulated time of the run in seconds.
    pub simulated_s: f64,
    /// Whether images were rendered in the run.
    pub has_cameras: bool,
    /// What the search for witnesses found; `None` for a run that did not reach its end.
    pub witnesses: Option<Witnesses>,
    /// Names of the declared bounds that were exceeded in the run.
    pub broken: Vec<String>,
    /// Failures that the run showed.
    pub hits: Vec<Hit>,
    /// Path of the file with the shrunk failing scene, if one was written.
    pub found: Option<PathBuf>,
}

/// First line of a journal: everything that determines the cases of the search. Another build of the program may draw or run its cases otherwise, so
/// that it has a journal of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Heading {
    seed: u64,
    profile: String,
    seeks_witnesses: bool,
    version: String,
    program: Option<String>,
    adapter: Option<String>,
}

/// The journal of one search, locked against other processes as long as this value lives.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens or creates the journal of a search in the folder `out`, and returns it with the cases that are done.
    ///
    /// A last line that was cut off when the process was killed is dropped, and its case runs again.
    pub(super) fn open(
        out: &Path,
        seed: u64,
        profile: Profile,
        seeks_witnesses: bool,
        adapter: Option<&str>,
    ) -> Result<(Journal, BTreeMap<u64, Done>), FalsifyError> {
        run_files::prepare(out)?;
        let heading = Heading {
            seed,
            profile: profile.name().to_owned(),
            seeks_witnesses,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            program: program_digest().map(str::to_owned),
            adapter: adapter.map(str::to_owned),
        };
        let path = out.join(format!("journal_{}.jsonl", identity(&heading)));
        let options = || OpenOptions::new().read(true).append(true).create(true).open(&path);
        let file = naming("open", &path, options())?;
        match file.try_lock() {
            // On a network file system without locks the search goes on without one; the user has to make sure that no other process writes into the
            // folder.
            Ok(()) => {}
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::WouldBlock) => return Err(FalsifyError::Locked(path)),
            Err(TryLockError::Error(source)) => return Err(RecordError { action: "lock", path, source }.into()),
        }
        let text = naming("read", &path, fs::read_to_string(&path))?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        naming("write", &path, file.set_len(whole as u64))?;
        let lines = text[..whole].lines().skip(1);
        // Without a digest of the program, a case that this build recorded cannot be told from a case of another build, so that every
        // case runs again.
        let done =
            lines.filter(|_| heading.program.is_some()).filter_map(|line| serde_json::from_str::<Done>(line).ok());
        let done = done.map(|done| (done.case, done)).collect();
        let mut journal = Journal { path, file };
        if whole == 0 {
            journal.write(&heading)?;
        }
        Ok((journal, done))
    }

    /// Adds a case that is done. The case is on the disk when this function returns.
    pub(super) fn add(&mut self, done: &Done) -> Result<(), RecordError> {
        self.write(done)
    }

    fn write(&mut self, line: &impl Serialize) -> Result<(), RecordError> {
        let written = serde_json::to_string(line).map_err(io::Error::from).and_then(|text| {
            // The line is written by a single call, so that a process that is killed leaves a complete line, or a part of one at the end of the file.
            self.file.write_all(format!("{text}\n").as_bytes())?;
            self.file.sync_data()
        });
        naming("write", &self.path, written)
    }
}

/// Returns a name that depends on everything that determines the cases of a search.
fn identity(heading: &Heading) -> String {
    // Serialising cannot fail, as all keys of a heading are texts.
    let digest = Sha256::digest(serde_json::to_vec(heading).unwrap_or_default());
    digest.iter().take(6).map(|byte| format!("{byte:02x}")).collect()
}
