//! What the robot knows of the building.
//!
//! Frame `world`: x and y along two walls of the room, z up, heading counter-clockwise from x.

use crate::Interval;

/// Room and floor as surveyed.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Inner faces of the room's walls: x range and y range.
    pub room_m: [Interval; 2],
    /// The grid of tile joints, if the floor is tiled.
    pub tiles: Option<TileGrid>,
}

/// Joints of a tiled floor: two families of parallel lines.
///
/// Frame `grid`: the world frame turned by `rotation_rad` about the world origin. Joint `i` of axis `a` follows a straight
/// line near grid coordinate `edge_m[a]·i + phase_m[a]`.
#[derive(Clone, Debug, PartialEq)]
pub struct TileGrid {
    /// Pitch of the joints along grid x and grid y.
    pub edge_m: [f64; 2],
    /// Angle from world x to grid x.
    pub rotation_rad: f64,
    /// Grid coordinate of joint 0 of each axis.
    pub phase_m: [f64; 2],
    /// Width of a joint.
    pub joint_width_m: f64,
    /// Greatest distance, anywhere in the room, of a joint's straight line from its nominal place, `floor_tiles.laying`.
    pub laying_m: f64,
    /// Greatest angle of a joint's straight line to its nominal direction, `floor_tiles.laying_angle`.
    pub laying_angle_rad: f64,
    /// Greatest distance of a joint's centre line from its own straight line, `floor_tiles.straightness`.
    pub straightness_m: f64,
}
