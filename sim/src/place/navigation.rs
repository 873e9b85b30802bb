//! Where a robot can go: occupancy grids, their files, and shortest paths through them. Only [`map_server`] touches files.

mod grid;
pub mod map_server;
mod planner;

pub use crate::scene::{Cell, OccupancyGrid};
pub use planner::{Planner, Reach, length_m};
