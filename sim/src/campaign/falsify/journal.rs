//! What a search has done, one line a case, so that it goes on where it stopped.

use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::artefacts::run_files::{self, RecordError, naming, program_digest};

use super::{FalsifyError, Profile, wish::Hit};

/// A case that is done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Its number.
    pub case: u64,
    /// Seed of its run.
    pub run_seed: u64,
    /// Keys for which scenes were refused before one was accepted.
    pub refused: Vec<String>,
    /// Steps judged; 0 of a run that did not end.
    pub steps: usize,
    /// Simulated time.
    pub simulated_s: f64,
    /// Whether images were rendered.
    pub has_cameras: bool,
    /// Bounds that were exceeded.
    pub broken: Vec<String>,
    /// Wishes that came true.
    pub hits: Vec<Hit>,
    /// Where the shrunk scene is, if one was written.
    pub found: Option<PathBuf>,
}

/// The first line: what was asked. Another program draws or runs other cases, so that it has a journal of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Heading {
    seed: u64,
    profile: String,
    version: String,
    program: Option<String>,
    adapter: Option<String>,
}

/// The journal of one search, locked against other processes for as long as this lives.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens or begins the journal of a search in `out`; returns the cases that are done, too.
    ///
    /// A last line that was cut off when the process was killed is dropped: its case runs again.
    pub(super) fn open(
        out: &Path,
        seed: u64,
        profile: Profile,
        adapter: Option<&str>,
    ) -> Result<(Journal, BTreeMap<u64, Done>), FalsifyError> {
        run_files::prepare(out)?;
        let heading = Heading {
            seed,
            profile: profile.name().to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            program: program_digest().map(str::to_owned),
            adapter: adapter.map(str::to_owned),
        };
        let path = out.join(format!("journal_{}.jsonl", identity(&heading)));
        let options = || OpenOptions::new().read(true).append(true).create(true).open(&path);
        let file = naming("open", &path, options())?;
        match file.try_lock() {
            // Some network file systems know no locks; whoever shares a folder there has to take care.
            Ok(()) => {}
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::WouldBlock) => return Err(FalsifyError::Locked(path)),
            Err(TryLockError::Error(source)) => return Err(RecordError { action: "lock", path, source }.into()),
        }
        let text = naming("read", &path, fs::read_to_string(&path))?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        naming("write", &path, file.set_len(whole as u64))?;
        let lines = text[..whole].lines().skip(1);
        // Without the program's digest nothing tells a case of this build from one of another.
        let done =
            lines.filter(|_| heading.program.is_some()).filter_map(|line| serde_json::from_str::<Done>(line).ok());
        let done = done.map(|done| (done.case, done)).collect();
        let mut journal = Journal { path, file };
        if whole == 0 {
            journal.write(&heading)?;
        }
        Ok((journal, done))
    }

    /// Adds a case that is done. It is on the disk when this returns.
    pub(super) fn add(&mut self, done: &Done) -> Result<(), RecordError> {
        self.write(done)
    }

    fn write(&mut self, line: &impl Serialize) -> Result<(), RecordError> {
        let written = serde_json::to_string(line).map_err(io::Error::from).and_then(|text| {
            // One write, so that what is killed leaves a line or a part of one at the end.
            self.file.write_all(format!("{text}\n").as_bytes())?;
            self.file.sync_data()
        });
        naming("write", &self.path, written)
    }
}

/// A name for all that determines what a search finds.
fn identity(heading: &Heading) -> String {
    // A heading's keys are texts, so that nothing in it can fail to serialise.
    let digest = Sha256::digest(serde_json::to_vec(heading).unwrap_or_default());
    digest.iter().take(6).map(|byte| format!("{byte:02x}")).collect()
}
