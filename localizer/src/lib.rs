//! Interval localization of a mobile robot: a union of boxes that surely contains the robot's pose, under assumptions that each have a name and a
//! bound.
//!
//! ```text
//! Reading ──> Method::constrain ──> Constraint ─┐
//! (wheels, camera)   (vision, once per image)   │ attached to the stamp of its reading
//!                                               v
//! wheel history ──> motion ──> Localizer: ring of stamped PoseUnions ──> Estimate
//! ```
//!
//! The crate owns its input types and uses no files, clocks, graphics or simulator, so that the true pose cannot leak in. Intervals, boxes and
//! their contractors come from the crate `interval` (package `wherein-interval`), by whose name they are used.
//!
//! # Where to start
//!
//! Start with [`Localizer`]: give it a [`RobotModel`], a [`Map`] and methods, then one [`Reading`] after the other, and query it for an
//! [`Estimate`]. To add a localization cue, read [`method`] and take the shortest of [`methods`] as an example.
//!
//! | module | holds |
//! |---|---|
//! | [`pose`] | a [`Pose`], a box of poses ([`PoseBox`]), and the union of boxes that an estimate consists of ([`PoseUnion`]) |
//! | [`rigid_motion`] | contractors of a pose, from landmarks known in two frames |
//! | [`bounds`] | the table of declared bounds, each an [`Assumption`]: name, unit and meaning |
//! | [`robot`] | what is known of the robot: [`RobotModel`], its devices and their declared bounds |
//! | [`markers`], [`map`] | what is known of the building: printed markers, and the [`Map`] with tiles, walls and markers |
//! | [`reading`] | the sensor readings that the localizer is given: [`Reading`] |
//! | [`motion`] | an enclosure of the robot's motion from wheels, flow sensor and gyroscope |
//! | [`graph`] | linear rows that relate poses, landmarks and constants, and keep what boxes lose |
//! | [`vision`] | from an image to features, without poses or maps |
//! | [`calibration`] | what is measured before a robot drives |
//! | [`quota`] | how many of a method's claims may be false |
//! | [`method`] | what every method offers: [`Method`], which makes a [`Constraint`] of a reading, with [`Claim`]s and the bounds that it relies on |
//! | [`methods`] | one file for each cue: joints of floor tiles, directions of walls, landmarks, markers of the ceiling |
//! | [`baselines`] | point methods and printed algorithms, to compare with; nothing else uses them |
//! | [`localizer`] | the [`Localizer`], its [`Estimate`]s and their [`Status`] |
//!
//! The modules are listed in reading order, from geometry to estimate.

pub mod pose;
pub mod rigid_motion;
pub mod bounds;
pub mod robot;
pub mod markers;
pub mod map;
pub mod reading;
pub mod motion;
pub mod graph;
#[cfg(feature = "vision")]
pub mod vision;
#[cfg(feature = "vision")]
pub mod calibration;
pub mod quota;
pub mod method;
pub mod methods;
pub mod baselines;
pub mod localizer;

pub use bounds::Assumption;
pub use localizer::{Estimate, Localizer, Status};
pub use map::Map;
pub use method::{Claim, Constraint, Method};
pub use pose::{Pose, PoseBox, PoseUnion};
pub use reading::Reading;
pub use robot::RobotModel;
