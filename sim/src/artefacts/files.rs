//! What all files that are written have in common: where the folder of a run is, and the error that names what failed.

use std::{
    io,
    path::{Path, PathBuf},
};

use thiserror::Error;

/// Reason why a run cannot be recorded. The error's text is phrased to follow "failed to".
#[derive(Debug, Error)]
#[error("{action} {}: {source}", path.display())]
pub struct RecordError {
    /// The action that failed.
    pub action: &'static str,
    /// The file or folder for which the action failed.
    pub path: PathBuf,
    /// Error that the system reported.
    pub source: io::Error,
}

/// Adds `action` and `path` to the error of a file operation.
pub(crate) fn naming<T>(action: &'static str, path: &Path, result: io::Result<T>) -> Result<T, RecordError> {
    result.map_err(|source| RecordError { action, path: path.to_owned(), source })
}

/// Path of the folder of one run.
pub fn folder(out: &Path, scene: &str, seed: u64) -> PathBuf {
    out.join(scene).join(seed.to_string())
}
