//! Where a robot can go: occupancy grids, their files, and ways through them. Pure but for [`map_server`]'s files.

mod grid;
pub mod map_server;
mod planner;

pub use crate::scene::{Cell, OccupancyGrid};
pub use planner::{Planner, Reach, length_m};
