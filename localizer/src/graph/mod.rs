//! The graph of key frames: poses along the drive, landmarks and constants of the robot, with linear rows that relate them.
//!
//! A box of a pose keeps no relation between x, y and heading, nor between the pose and the landmarks that are seen from it. The graph keeps them:
//! each sensor reading gives rows of a linear program, in the deviations of all quantities from reference values. What is not linear in a row is
//! enclosed over the boxes of the quantities and added to the sides of the row, so that the true values satisfy every row as long as the declared
//! bounds hold. Bounds of the program, certified as [`interval::linear_program`] describes, are therefore bounds of the true values.
//!
//! Rotations enter by identities that are exact for any angle: with a direction n that turns by δ from n₀, and its perpendicular,
//! n₀·d = (n·d) cos δ − (m·d) sin δ. Only sin δ − δ and 1 − cos δ have to be enclosed, and no box of a landmark is needed.

mod conflict;
mod despite_wrong;
mod domain;
mod flow;
mod hull;
mod key_frames;
mod link;
mod over_readings;
mod place;
mod related;
mod relations;
mod row;
mod sighting;
mod stray;
#[cfg(test)]
pub(crate) mod trial;
mod way;
mod width;

pub use conflict::{Conflict, ConflictSearch};
pub(crate) use despite_wrong::{DespiteWrong, choices};
pub use domain::{Constant, Domain, Variable};
pub use flow::flow_rows;
pub use hull::Hull;
pub use key_frames::{FrameReading, KeyFrames, Place, Unlinked, WIDEST_RAD, Ways};
pub(crate) use over_readings::{PoseByRows, bounds_over, is_linear_over};
pub use place::SeenPlace;
pub use related::{BoxLabel, Readings, Related, RowLabel, Suspect};
pub use relations::{Disc, Relations};
pub use row::Row;
pub use sighting::{Columns, sighting_rows};
pub use stray::Stray;
pub use way::way_rows;
pub use width::WidthParts;
