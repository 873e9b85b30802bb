//! Contractors of a planar pose (x, y, heading), from landmarks whose boxes are known in two frames.
//!
//! A rigid motion rotates a point by the heading θ and translates it by t: a = t + R(θ) b. With a in the world frame and b in the robot frame, t
//! and θ are the pose of the robot. All contractors of this module stand for that constraint; they differ in what they compare, in computing
//! time and in the width of the result.

mod rigid_rows;
mod rigid_planar;
mod linear_pose;
mod rigid_polar;
mod rigid_table;
mod relaxed_pose;
mod translated;

pub use linear_pose::LinearPose;
pub use relaxed_pose::RelaxedPose;
pub use rigid_planar::RigidPlanar;
pub use rigid_polar::RigidPolar;
pub use rigid_rows::Landmark;
pub use rigid_table::RigidTable;
pub use translated::Translated;
