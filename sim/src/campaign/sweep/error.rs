//! Reasons why a sweep cannot be carried out.

use std::{io, path::PathBuf};

use thiserror::Error;

use crate::{artefacts::run_files::RecordError, render::RenderError, scene::SceneError};

/// Why a sweep cannot be carried out. The text of the error follows "failed to".
#[derive(Debug, Error)]
pub enum SweepError {
    /// The scene, or a variation of it, is refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Pictures cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A sweep file has invalid contents.
    #[error("read sweep {}: {expected}", path.display())]
    BadFile {
        /// Path of the sweep file.
        path: PathBuf,
        /// Description of what is wrong with the sweep file and of what was expected.
        expected: String,
    },
    /// A key is listed twice among the keys to vary.
    #[error("vary `{key}` twice: expected one list of its values")]
    TwiceVaried {
        /// Key that is listed twice.
        key: String,
    },
    /// Two combinations of values result in the same scene.
    #[error("tell {one} and {other} apart: both state the same scene, expected each value once")]
    SameCase {
        /// First of the two combinations.
        one: String,
        /// Second of the two combinations.
        other: String,
    },
    /// The sweep has more cases than a sweep may have.
    #[error("sweep over {cases} cases: expected at most {limit}")]
    TooManyCases {
        /// Number of cases: combinations times seeds.
        cases: u128,
        /// Greatest number of cases that a sweep may have.
        limit: u128,
    },
    /// Another process works in the folder of the sweep.
    #[error("use the folder {}: {holder} is sweeping into it; wait until it is done, or choose another --out", folder.display())]
    Locked {
        /// Path of the folder.
        folder: PathBuf,
        /// Process that holds the lock.
        holder: String,
    },
    /// The folder cannot be locked.
    #[error("lock the folder {}: {source}", folder.display())]
    NoLock {
        /// Path of the folder.
        folder: PathBuf,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// A folder does not hold a sweep.
    #[error("find a sweep in {}: expected the file sweep.json that `wherein sweep` wrote", folder.display())]
    NoSweep {
        /// Path of the folder.
        folder: PathBuf,
    },
    /// Two folders that are to be joined hold parts of different sweeps.
    #[error("{join} {} and {}: their sweeps differ in {what}", one.display(), other.display())]
    DifferentSweeps {
        /// What was to be done with both folders together: "merge".
        join: &'static str,
        /// First of the two folders.
        one: PathBuf,
        /// Second of the two folders.
        other: PathBuf,
        /// Description of what differs, with both values.
        what: String,
    },
    /// A table of results has a case that is none of the sweep with whose parts it is reported on.
    #[error("report on {} and {}: the table has the case {case}, expected cases of that sweep only", folder.display(), table.display())]
    OtherCase {
        /// Path of the table.
        table: PathBuf,
        /// Folder of a part of the sweep.
        folder: PathBuf,
        /// Name of the case.
        case: String,
    },
}
