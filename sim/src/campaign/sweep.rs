//! Many runs of one scene: every combination of the values of some keys, each with several seeds.
//!
//! ```text
//! Sweep (what is asked) ─> Plan (every case and its name) ─> workers ─> Store (cases/<id>/) ─> results
//! ```
//!
//! A case is named by a digest of everything that determines its bytes, and is recorded whole or not at all. A sweep that
//! was killed therefore goes on where it stopped, and the parts that several machines ran can be merged.

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

pub use error::SweepError;
pub use merge::merge;
pub use plan::{Case, Plan, PlannedCase};
pub use seeds::Seeds;
pub use shard::Shard;
pub use store::{Recorded, Store, case_folder, read_case, read_plan, write_whole};
pub use variable::Variable;
pub use workers::{Finished, Work, run_cases};

/// What a sweep is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The scene's file.
    pub scene: PathBuf,
    /// Keys that vary, the one that changes slowest first.
    pub vary: Vec<Variable>,
    /// Seeds that each combination runs with.
    pub seeds: Range<u64>,
}
