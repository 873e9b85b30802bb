//! Many runs: sweeps over keys and seeds, the search for what breaks the promise, and what their cases come to.
//!
//! | module | what it does |
//! |---|---|
//! | [`sweep`] | runs every combination of some keys' values with several seeds, and goes on where it was stopped |
//! | [`falsify`] | runs random scenes against the promise and makes small what broke it |
//! | [`weaken`] | tells the localizer ever narrower bounds until it loses the truth |
//! | [`cases`] | the cases of a sweep, or the runs below a folder, read back: one row each |
//! | [`report`] | what those cases come to: a page, Markdown, or lines for a terminal |
//! | [`comparison`] | two sets of cases against each other |
//! | [`junit`] | cases as JUnit XML for CI systems |

pub mod sweep;
pub mod falsify;
pub mod weaken;
pub mod cases;
pub mod report;
pub mod comparison;
pub mod junit;
