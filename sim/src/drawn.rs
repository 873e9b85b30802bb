//! True values that a seed draws at random within the declared bounds. The localizer never sees them.

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

/// Everything about a run that is drawn at random once, before the run starts.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// True pose of the robot at time 0.
    pub start: Pose,
    /// True dimensions of the robot's base, and the error of its clock.
    pub base: DrawnBase,
    /// True mounts, lenses, scales and biases of the robot's devices.
    pub devices: DrawnDevices,
    /// The floor's tiles as they were truly laid; `None` if the floor has none.
    pub tiles: Option<LaidTiles>,
    /// Angle by which each piece of furniture is turned away from where the scene states it.
    pub furniture_turn_deg: Vec<f64>,
    /// Angle by which all walls and the things that hang on them are turned about the middle of the robot's room, away from where the scene
    /// states them.
    pub walls_turn_deg: f64,
    /// Goals of random errands, world frame. They are no secret: the driver is given them.
    pub goals_m: Vec<[f64; 2]>,
    /// Markers on the ceiling as they were truly printed and pasted.
    pub markers: Vec<DrawnMarker>,
}
