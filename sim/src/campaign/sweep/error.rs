//! Why a sweep cannot be carried out.

use std::{io, path::PathBuf};

use thiserror::Error;

use crate::{artefacts::run_files::RecordError, render::RenderError, scene::SceneError};

/// Why a sweep cannot be carried out. Its text follows "failed to".
#[derive(Debug, Error)]
pub enum SweepError {
    /// The scene, or a variation of it, is refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No picture can be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A sweep file says what cannot be.
    #[error("read sweep {}: {expected}", path.display())]
    BadFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what was expected.
        expected: String,
    },
    /// A key is to vary twice.
    #[error("vary `{key}` twice: expected one list of its values")]
    TwiceVaried {
        /// The key.
        key: String,
    },
    /// Two combinations of values state the same scene.
    #[error("tell {one} and {other} apart: both state the same scene, expected each value once")]
    SameCase {
        /// One combination.
        one: String,
        /// The other.
        other: String,
    },
    /// More cases than a sweep may have.
    #[error("sweep over {cases} cases: expected at most {limit}")]
    TooManyCases {
        /// Combinations times seeds.
        cases: u128,
        /// The limit.
        limit: u128,
    },
    /// Another process works in the folder.
    #[error("use the folder {}: {holder} is sweeping into it; wait until it is done, or choose another --out", folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// The process.
        holder: String,
    },
    /// The folder cannot be locked.
    #[error("lock the folder {}: {source}", folder.display())]
    NoLock {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A folder holds no sweep.
    #[error("find a sweep in {}: expected the file sweep.json that `wherein sweep` wrote", folder.display())]
    NoSweep {
        /// The folder.
        folder: PathBuf,
    },
    /// Two folders hold parts of different sweeps.
    #[error("merge {} and {}: their sweeps differ in {what}", one.display(), other.display())]
    DifferentSweeps {
        /// One folder.
        one: PathBuf,
        /// The other.
        other: PathBuf,
        /// What differs, with both values.
        what: String,
    },
}
