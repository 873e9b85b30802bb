//! Everything that runs, sweeps and comparisons leave behind.
//!
//! | module | what it writes or reads |
//! |---|---|
//! | [`run_files`] | the folder of one run: `summary.json`, trajectories, boxes, steps |
//! | [`recording`] | a run as a stream of messages: an MCAP file, or live to a viewer |
//! | [`debug_frames`] | pictures of one run: what a camera saw, with what the localizer made of it drawn over |
//! | [`figures`] | every number of a `summary.json` by its dotted name |
//! | [`result_table`] | the table of results that a terminal and README show |
//! | [`cases`] | the cases of a sweep or the runs below a folder, read back, one row each |
//! | [`report`] | what those cases come to: a page, Markdown, or lines for a terminal |
//! | [`comparison`] | two sets of cases against each other |
//! | [`junit`] | cases as JUnit XML for CI systems |
//! | [`machine`] | the words for the machine that ran, which files name |

pub mod run_files;
pub mod recording;
pub mod debug_frames;
pub mod figures;
pub mod result_table;
pub mod cases;
pub mod report;
pub mod comparison;
pub mod junit;
pub mod machine;
