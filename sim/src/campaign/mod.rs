//! Experiments of many runs: sweeps over keys and seeds, the search for scenes that make the program or the localizer fail, and their results.
//!
//! | module | what it does |
//! |---|---|
//! | [`judged_run`] | one run with all that its verdict needs |
//! | [`sweep`] | runs every combination of some keys' values with several seeds, and continues where it was stopped |
//! | [`falsify`] | runs random scenes and reduces each one that fails to a small scene |
//! | [`check`] | looks at the pictures along a scene's way before it is run |
//! | [`board`] | calibrates a camera from pictures of a chessboard |
//! | [`mount`] | finds where the ceiling camera is mounted, from pictures of turns on the spot |
//! | [`weaken`] | gives the localizer ever narrower bounds until it loses the truth |
//! | [`sharpness`] | compares the boxes of a run with what its readings and bounds leave open |
//! | [`cases`] | reads the cases of a sweep, or the runs below a folder: one row each |
//! | [`report`] | sums cases up: an HTML page, Markdown, or lines for a terminal |
//! | [`sketch`] | sums more cases up than memory holds, row by row, for the same report |
//! | [`comparison`] | compares two sets of cases |
//! | [`junit`] | writes cases as JUnit XML for CI systems |

pub mod judged_run;
pub mod sweep;
pub mod falsify;
pub mod check;
pub mod board;
pub mod mount;
pub mod weaken;
pub mod sharpness;
pub mod cases;
pub mod report;
pub mod sketch;
pub mod comparison;
pub mod junit;
