//! Where a robot can go: occupancy grids, their files, and shortest paths through them. Only [`map_server`] touches files.

mod grid;
pub mod map_server;
mod planner;
pub mod reeds_shepp;
mod curve_planner;

pub use crate::scene::{Cell, OccupancyGrid};
pub use curve_planner::CurvePlanner;
pub use planner::{Planner, Reach, length_m};
