//! The true values that a seed draws inside the declared bounds. The localizer never sees them.

use localizer::Pose;

use crate::{base::DrawnBase, devices::DrawnDevices};

mod clip;
mod draw;
pub mod markers;
pub mod tiles;
mod walls;

pub(crate) use clip::is_clipped;
pub use markers::{DrawnDot, DrawnMarker};
pub use tiles::LaidTiles;
pub(crate) use walls::turn_from_nearest_deg;

/// Everything about a run that is drawn once, before it starts.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// True pose at time 0.
    pub start: Pose,
    /// True dimensions of the base, and its clock.
    pub base: DrawnBase,
    /// True mounts, lenses, scales and biases of the devices.
    pub devices: DrawnDevices,
    /// The tiles as they were laid.
    pub tiles: Option<LaidTiles>,
    /// By how much each piece of furniture is turned against where the scene has it.
    pub furniture_turn_deg: Vec<f64>,
    /// By how much all walls, with what hangs on them, are turned about the middle of the robot's room against where the scene has them.
    pub walls_turn_deg: f64,
    /// Goals of random errands, world; nothing secret, and the driver is told.
    pub goals_m: Vec<[f64; 2]>,
    /// The markers that are on the ceiling, as they were pasted.
    pub markers: Vec<DrawnMarker>,
}
