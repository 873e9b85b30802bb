//! Reasons why a search for failing scenes cannot go on.

use std::{io, path::PathBuf};

use thiserror::Error;

use crate::artefacts::run_files::RecordError;

/// Why a search cannot go on. The text of the error follows "failed to".
#[derive(Debug, Error)]
pub enum FalsifyError {
    /// A file of the search cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Another process is at the same search: it holds the journal, the file in which finished cases are recorded.
    #[error("search into {}: another process does, expected another --out", .0.display())]
    Locked(PathBuf),
    /// The child process in which a case runs cannot be started, or its output cannot be read.
    #[error("run case {case} in a process of its own: {source}")]
    Process {
        /// Number of the case.
        case: u64,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// The child process in which a case runs cannot render, or somebody outside the search interrupted it.
    #[error("run case {case}: {reason}")]
    CouldNotRun {
        /// Number of the case.
        case: u64,
        /// Reason that the process reported.
        reason: String,
    },
    /// No valid scene was found for a case: all scenes that were drawn at random for it were refused.
    #[error("draw case {case}: {attempts} scenes in a row were refused, the last one for `{reason}`")]
    AllRefused {
        /// Number of the case.
        case: u64,
        /// Number of scenes that were drawn for the case.
        attempts: u64,
        /// Key for which the last scene was refused.
        reason: String,
    },
}
