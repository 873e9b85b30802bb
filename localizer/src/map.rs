//! The map: what the localizer is given about the building.
//!
//! Frame `world`: x and y along two walls of the room, z up, heading counter-clockwise from x.

mod seen_again;
mod space_point;
mod things;
mod views;

use interval::Interval;

use crate::markers::{Coding, MarkerId};

pub use seen_again::SeenAgain;
pub use space_point::{Anchor, SpacePoint};
pub use things::things;
pub use views::{ViewCamera, ViewPicture, ViewSight, Views};

/// Map of a room and its floor, as surveyed.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Inner faces of the room's walls: x range and y range.
    pub room_m: [Interval; 2],
    /// The grid of tile joints, if the floor is tiled.
    pub tiles: Option<TileGrid>,
    /// Markers on the ceiling, if there are any.
    pub markers: Option<MarkerMap>,
    /// Directions of the walls, as angles from world x modulo quarter turns (bound `wall_directions.direction`).
    pub wall_directions_rad: Vec<Interval>,
    /// Walls with their places, if these are known.
    pub walls: Option<WallMap>,
}

impl Map {
    /// A map of a room of which nothing is known but the intervals of x and y in which it lies.
    pub fn of_room(room_m: [Interval; 2]) -> Map {
        Map { room_m, tiles: None, markers: None, wall_directions_rad: Vec::new(), walls: None }
    }
}

/// Map of the walls of a building. Between them are doors and other openings, of which the map says nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct WallMap {
    /// Fronts of all walls, in no particular order.
    pub walls: Vec<Wall>,
    /// Greatest distance of any point of a wall from its place on the map (bound `walls.placement`).
    pub placement_m: f64,
}

/// The front of a straight upright wall from the floor to the ceiling, through which nothing is seen. Its front is to the left of the way from its
/// start to its end; a wall that stands free in a room is on the map once for each of its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Start and end of the wall on the floor plan, each as world x and y.
    pub ends_m: [[f64; 2]; 2],
}

/// Map of the dot-matrix markers that are pasted on the ceiling.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerMap {
    /// Set of allowed marker identities, from which the identities of the ceiling's markers are taken.
    pub coding: Coding,
    /// All markers of the ceiling; each identity occurs once.
    pub markers: Vec<PlacedMarker>,
    /// Greatest distance of a ceiling marker's centre from its place on the map (bound `markers.placement`).
    pub placement_m: f64,
    /// Greatest angle between a ceiling marker and its direction on the map (bound `markers.rotation`).
    pub rotation_tolerance_rad: f64,
    /// Greatest distance of a dot's centre from its nominal place in the marker frame (bound `markers.print`).
    pub print_m: f64,
}

/// Identity, position and orientation of one ceiling marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedMarker {
    /// Identity that is printed on the marker.
    pub id: MarkerId,
    /// World x and y of the middle of the marker's grid of dots.
    pub centre_m: [f64; 2],
    /// Angle from world x to the marker's own x axis, counter-clockwise seen from above.
    pub rotation_rad: f64,
    /// Height of all of the marker's dots above the floor (bound `markers.height`).
    pub height_m: Interval,
}

/// Joints of a tiled floor: two families of parallel lines.
///
/// Frame `grid`: the world frame turned by `rotation_rad` about the world origin. Joint `i` of axis `a` follows a straight line near grid
/// coordinate `edge_m[a]·i + phase_m[a]`.
#[derive(Clone, Debug, PartialEq)]
pub struct TileGrid {
    /// Distance between neighbouring joints along grid x and along grid y.
    pub edge_m: [f64; 2],
    /// Angle from world x to grid x.
    pub rotation_rad: f64,
    /// Grid coordinate of the joint with index 0 on each axis.
    pub phase_m: [f64; 2],
    /// Width of a joint between tiles.
    pub joint_width_m: f64,
    /// Greatest distance, anywhere in the room, of a joint's straight line from its nominal place in the tile grid (bound
    /// `floor_tiles.laying`).
    pub laying_m: f64,
    /// Greatest angle between a joint's straight line and its nominal direction in the tile grid (bound `floor_tiles.laying_angle`).
    pub laying_angle_rad: f64,
    /// Greatest distance of a joint's true centre line from the straight line that stands for the joint (bound `floor_tiles.straightness`).
    pub straightness_m: f64,
}
