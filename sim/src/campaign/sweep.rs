//! A sweep: many runs of one scene, with every combination of the values of some keys and several seeds for each.
//!
//! ```text
//! Sweep (what the user states) ─> Plan (every case and its name) ─> workers ─> Store (cases/<id>/) ─> results
//! ```
//!
//! The name of a case is a digest of everything that determines the bytes of its results, and a case is recorded completely or not at all.
//! A sweep that was killed can therefore continue where it stopped, and the parts that several machines ran can be merged.

mod begun;
mod error;
mod file;
mod merge;
mod plan;
mod seeds;
mod shard;
mod store;
mod variable;
mod workers;

use std::{ops::Range, path::PathBuf};

use crate::subject::SubjectChoice;

pub use begun::Begun;
pub use error::SweepError;
pub use merge::{expect_same, merge};
pub use plan::{Case, Plan, PlannedCase};
pub use seeds::Seeds;
pub use shard::Shard;
pub use store::{Recorded, Store, case_folder, read_case, read_plan, write_whole};
pub use variable::Variable;
pub use workers::{Finished, Work, run_cases};

/// A sweep as the user states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Path of the scene's file.
    pub scene: PathBuf,
    /// Scene keys that vary, with their values; the key that changes slowest from case to case comes first.
    pub vary: Vec<Variable>,
    /// Seeds with which each combination of the keys' values runs.
    pub seeds: Range<u64>,
    /// The localizer that the sweep tests.
    pub subject: SubjectChoice,
    /// Whether the methods to compare with (baselines) are run on each run's readings, too.
    pub baselines: bool,
}
