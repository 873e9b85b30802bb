//! The files that runs leave behind, the replay of a recorded run or of another program's log through the localizer, and markers
//! to print.
//!
//! | module | what it writes or reads |
//! |---|---|
//! | `files` | where the folder of a run is, and the error of writing |
//! | `digest` | what identifies a scene, a run and this program |
//! | `occurrences` | the scene's events as they came about in a run, for its summary |
//! | `wording` | quantities in words, with their units |
//! | `summary` | the files `summary.json` and `timing.json` |
//! | [`seen_again`] | which landmarks of a map a drive saw again, and which seem to have gone |
//! | `map_changes` | the places from which landmarks of a map have gone or moved together |
//! | [`run_files`] | the folder of one run: its summary, trajectories, boxes, steps |
//! | [`recording`] | a run as a stream of messages, in an MCAP file or live to a viewer |
//! | [`replay`] | a recording, whose readings it gives to a localizer without the simulator |
//! | [`log`] | a log that another program recorded, whose readings it gives to a localizer |
//! | [`debug_frames`] | pictures of one run: what a camera saw, with what the localizer made of it drawn over |
//! | [`result_table`] | the table of results that a terminal and the book show |
//! | [`machine`] | the description in words of the computer that ran, which result files name |
//! | [`marker_sheet`](mod@marker_sheet) | ceiling markers to print, as a PDF file |

mod files;
mod digest;
mod occurrences;
mod summary;
pub mod seen_again;
pub mod map_changes;
pub(crate) mod wording;
pub mod run_files;
pub mod recording;
pub mod replay;
pub mod log;
pub mod debug_frames;
pub mod result_table;
pub mod machine;
pub mod marker_sheet;
