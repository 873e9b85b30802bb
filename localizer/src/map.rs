//! What the robot knows of the building.
//!
//! Frame `world`: x and y along two walls of the room, z up, heading counter-clockwise from x.

use interval::Interval;

use crate::markers::{Coding, MarkerId};

/// Room and floor as surveyed.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Inner faces of the room's walls: x range and y range.
    pub room_m: [Interval; 2],
    /// The grid of tile joints, if the floor is tiled.
    pub tiles: Option<TileGrid>,
    /// Markers on the ceiling, if there are any.
    pub markers: Option<MarkerMap>,
    /// Directions of walls from world x, modulo quarter turns, `wall_directions.direction`.
    pub wall_directions_rad: Vec<Interval>,
}

/// Dot-matrix markers as pasted on the ceiling.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerMap {
    /// The set that their identities are from.
    pub coding: Coding,
    /// Each identity once.
    pub markers: Vec<PlacedMarker>,
    /// Greatest distance of a marker's centre from its nominal place, `markers.placement`.
    pub placement_m: f64,
    /// Greatest angle between a marker and its nominal direction, `markers.rotation`.
    pub rotation_tolerance_rad: f64,
    /// Greatest distance of a dot's centre from its place in the marker frame, `markers.print`.
    pub print_m: f64,
}

/// Where one marker is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedMarker {
    /// Identity printed on it.
    pub id: MarkerId,
    /// World x and y of the middle of its grid.
    pub centre_m: [f64; 2],
    /// Angle from world x to its own x, counter-clockwise seen from above.
    pub rotation_rad: f64,
    /// Height of all of its dots above the floor, `markers.height`.
    pub height_m: Interval,
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
