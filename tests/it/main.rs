//! Claims about the whole system that could be false, checked from outside.

// A failing assumption of a test should stop it where it stands.
#![allow(clippy::unwrap_used, clippy::expect_used)]

/// Runs the `wherein` command in folders of its own.
mod command;

/// What every scene file, the schema and the documents keep true.
mod repository;
/// Scenes that must be refused, and what the refusal says.
mod scene_refusals;
/// What `[expect]` holds a run against.
mod scene_expectations;
/// What a user meets on the command line besides refusals: exit codes, output, replay, resumption.
mod cli_runs;
/// What a run leaves behind, read back by other means than ours.
mod record_files;
/// The floor's geometry against a derivation of the tests' own.
mod floor_tiles_geometry;
/// The motion of a robot against exact arcs.
mod motion_enclosure;
