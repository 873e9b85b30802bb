//! Where is the robot? A union of boxes that it is surely in, under assumptions that each have a name and a bound.
//!
//! ```text
//! Reading ──> Method::constrain ──> Constraint ─┐
//! (wheels, camera)   (vision, once per image)   │ hung on the stamp of its reading
//!                                               v
//! wheel history ──> motion ──> Localizer: ring of stamped PoseUnions ──> Estimate
//! ```
//!
//! The crate owns its inputs and knows neither files, clocks, graphics nor the simulator: truth cannot leak in.
//! Modules in reading order, from arithmetic to answer.

pub mod rigid_motion;
pub mod pose;
pub mod robot;
pub mod markers;
pub mod map;
pub mod reading;
pub mod motion;
pub mod vision;
pub mod calibration;
pub mod method;
pub mod methods;
pub mod baselines;
pub mod localizer;

pub use localizer::{Estimate, Localizer, Status};
pub use map::Map;
pub use method::{Assumption, Claim, Constraint, Method};
pub use pose::{Pose, PoseBox, PoseUnion};
pub use reading::Reading;
pub use robot::RobotModel;
