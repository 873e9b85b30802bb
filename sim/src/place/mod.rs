//! The place that the robot is in: what the scene's keys state of it, and the errors of floor, walls, furniture and markers that a seed draws at
//! random.
//!
//! | module | what it has |
//! |---|---|
//! | [`drawn`] | tiles as laid, walls and furniture as they stand, markers as pasted |
//! | [`building`] | walls, doors, furniture and people as faces |
//! | `draw` | the random draw of what [`drawn`] holds, within what the ground plan leaves room for |
//! | [`light`] | what lamps give, shadows, light from wall to wall, light maps |
//! | `floor` | the floor under a point: friction, height, pile |
//! | `sight` | what stands between two points |
//! | [`landmark_map`] | files of maps of landmarks that a drive has learnt |
//! | `confused_landmarks` | landmarks of a map that are confused with each other, where a scene asks for it |
//! | [`navigation`] | where a robot can go: occupancy grids, their files, paths through them |

pub mod drawn;
pub mod building;
mod draw;
pub mod light;
pub(crate) mod floor;
pub(crate) mod sight;
pub mod landmark_map;
mod confused_landmarks;
pub mod navigation;

/// A person at an instant, as an upright cylinder on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bystander {
    /// Position where the person stands, world frame.
    pub place_m: [f64; 2],
    /// Radius of the cylinder that stands for the person.
    pub radius_m: f64,
    /// Height of the person.
    pub height_m: f64,
    /// Direction that the person faces, measured from world x.
    pub heading_rad: f64,
    /// Distance that the person has walked since the start.
    pub walked_m: f64,
    /// Velocity of the person in the last time step, along world x and y.
    pub velocity_m_per_s: [f64; 2],
}
