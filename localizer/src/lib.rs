//! Where is the robot? A union of boxes that it is surely in, under assumptions that each have a name and a bound.
//!
//! ```text
//! Reading ──> Method::constrain ──> Constraint ─┐
//! (wheels, camera)   (vision, once per image)   │ hung on the stamp of its reading
//!                                               v
//! wheel history ──> motion ──> Localizer: ring of stamped PoseUnions ──> Estimate
//! ```
//!
//! The crate owns its inputs and knows neither files, clocks, graphics nor the simulator: truth cannot leak in. Intervals, boxes and their
//! contractors come from the crate `interval` (package `wherein-interval`), by whose name they are used.
//!
//! # What to start with
//!
//! Start with [`Localizer`]: give it a [`RobotModel`], a [`Map`] and methods, then one [`Reading`] after the other, and ask it for an [`Estimate`].
//! To add a way to see, read [`method`] and take the shortest of [`methods`] as an example.
//!
//! | module | holds |
//! |---|---|
//! | [`pose`] | what is asked for: a [`Pose`], a box of poses ([`PoseBox`]), and the union of boxes that an answer is ([`PoseUnion`]) |
//! | [`rigid_motion`] | contractors of a pose, from landmarks known in two frames |
//! | [`robot`] | what the robot knows of itself: [`RobotModel`], its devices and their declared bounds |
//! | [`markers`], [`map`] | what it knows of the building: printed markers, and the [`Map`] with tiles, walls and markers |
//! | [`reading`] | what it senses: [`Reading`] |
//! | [`motion`] | wheels, flow sensor and gyroscope to an enclosure of where it has gone |
//! | [`vision`] | an image to features, without poses or maps |
//! | [`calibration`] | what is measured before a robot drives |
//! | [`method`] | what every method offers: [`Method`], which makes a [`Constraint`] of a reading, with [`Claim`]s and [`Assumption`]s |
//! | [`methods`] | one file for each cue: joints of floor tiles, directions of walls, landmarks, markers of the ceiling |
//! | [`baselines`] | point methods and printed algorithms, to compare with; nothing else uses them |
//! | [`localizer`] | the [`Localizer`], its [`Estimate`]s and their [`Status`] |
//!
//! Modules in reading order, from geometry to answer.

pub mod pose;
pub mod rigid_motion;
pub mod bounds;
pub mod robot;
pub mod markers;
pub mod map;
pub mod reading;
pub mod motion;
pub mod vision;
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
