//! Reasons why a log of another program cannot be replayed at all. What is wrong with single messages is no such reason: it is reported.

use std::{io, path::PathBuf};

use thiserror::Error;

use super::{raw_message::Damage, sqlite::SqliteError};
use crate::{
    artefacts::{recording::RecordingError, run_files::RecordError},
    scene::SceneError,
};

/// Reason why a log cannot be replayed. The error's text is phrased to follow "failed to".
#[derive(Debug, Error)]
pub enum LogError {
    /// The robot's file is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The results cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A file of the log cannot be read.
    #[error("read log {}: {source}", path.display())]
    Unreadable {
        /// The file that was read.
        path: PathBuf,
        /// Error that the system reported.
        source: io::Error,
    },
    /// A file of the log has another content than its kind demands.
    #[error("read log {}: {found}, expected {expected}", path.display())]
    Invalid {
        /// The file that was read.
        path: PathBuf,
        /// What is wrong.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The robot's file has no table `[log]`.
    #[error("read {}: `log` is missing, expected a table `[log]` that says how the log is read, which may be empty", .0.display())]
    NoTable(PathBuf),
    /// A topic cannot be chosen.
    #[error("read log {}: `{key}` of {} {found}", log.display(), robot.display())]
    Topic {
        /// Path of the log.
        log: PathBuf,
        /// Path of the robot's file.
        robot: PathBuf,
        /// Dotted path of the key that names or should name the topic.
        key: String,
        /// What was found, and what was expected.
        found: String,
    },
    /// The log has no reading of the wheels, or none that can be used.
    #[error("replay log {}: {found}", log.display())]
    Unusable {
        /// Path of the log.
        log: PathBuf,
        /// What was found, and what was expected.
        found: String,
    },
    /// The log tells no constant of the robot.
    #[error("calibrate by log {}: {found}", log.display())]
    Uncalibrated {
        /// Path of the log.
        log: PathBuf,
        /// What was found, and what was expected.
        found: String,
    },
    /// The recording of a run cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A file of estimates cannot be used.
    #[error("read estimates {}: {found}", path.display())]
    Estimates {
        /// Path of the file.
        path: PathBuf,
        /// What was found, and what was expected.
        found: String,
    },
    /// The file of the true poses cannot be used.
    #[error("read true poses {}: {found}", path.display())]
    Truth {
        /// Path of the file.
        path: PathBuf,
        /// What was found, and what was expected.
        found: String,
    },
}

impl LogError {
    /// The error with the damage of the log, which may be what keeps it from being replayed.
    pub(super) fn with_damage(mut self, damage: &[Damage]) -> LogError {
        if let LogError::Topic { found, .. } | LogError::Unusable { found, .. } = &mut self {
            for one in damage {
                *found += &format!("; {}", one.what);
            }
        }
        self
    }

    /// The error of a database file.
    pub(super) fn of_database(path: &std::path::Path, error: SqliteError) -> LogError {
        match error {
            SqliteError::Io(source) => LogError::Unreadable { path: path.to_owned(), source },
            other => LogError::Invalid {
                path: path.to_owned(),
                found: other.to_string(),
                expected: "a bag of ROS 2 that was closed after recording",
            },
        }
    }
}
