//! Why a search cannot go on.

use std::{io, path::PathBuf};

use thiserror::Error;

use crate::artefacts::run_files::RecordError;

/// Why a search cannot go on. Its text follows "failed to".
#[derive(Debug, Error)]
pub enum FalsifyError {
    /// A file of the search cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Another process searches into the same journal.
    #[error("search into {}: another process does, expected another --out", .0.display())]
    Locked(PathBuf),
    /// A process for a case cannot be started or heard.
    #[error("run case {case} in a process of its own: {source}")]
    Process {
        /// The case.
        case: u64,
        /// What the system said.
        source: io::Error,
    },
    /// A case's process says that it cannot render.
    #[error("run case {case}: {reason}")]
    CouldNotRun {
        /// The case.
        case: u64,
        /// What it said.
        reason: String,
    },
    /// The grammar draws nothing that is accepted.
    #[error("draw case {case}: {attempts} scenes in a row were refused, the last one for `{reason}`")]
    AllRefused {
        /// The case.
        case: u64,
        /// Scenes that were drawn.
        attempts: u64,
        /// Key of the last refusal.
        reason: String,
    },
}
