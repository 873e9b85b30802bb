//! Claims about the whole system that could be false, checked from outside: one binary, each module states what belongs in it.

// A failing assumption of a test should stop it where it stands.
#![allow(clippy::unwrap_used, clippy::expect_used)]

/// Runs the `wherein` command in folders of its own.
mod command;

/// Contractors and pavings on problems worked out by hand.
mod contractor_by_hand;
/// Attempts to make the rigid contractors lose the truth.
mod contractor_falsification;
/// Laws that every contractor keeps.
mod contractor_laws;
/// Interval arithmetic against the ITF1788 collection of cases from outside.
mod interval_itf1788;
/// Interval arithmetic against arithmetic with many more bits.
mod interval_precision;
/// Printing and reading intervals.
mod interval_text;
/// The wheels' enclosure against motion integrated much finer.
mod motion_enclosure;
/// Tile joints to poses, against a camera and a floor of the tests' own.
mod floor_tiles_geometry;
/// Scenes that must be refused, and what the refusal says.
mod scene_refusals;
/// What `[expect]` holds a run against.
mod scene_expectations;
/// What a user meets on the command line besides refusals: exit codes, output, replay, resumption.
mod cli_runs;
/// What a run leaves behind, read back by other means than ours.
mod record_files;
/// What every scene file, the schema and the documents keep true.
mod repository;
