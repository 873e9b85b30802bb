//! Walls, ceilings, doors, pictures and further rooms around the room that the robot drives in.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FurtherRoom;

/// Everything around and above the floor that cameras looking ahead or up can see: ceilings, walls, doors, pictures, further rooms.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Building {
    /// Height of every ceiling above the floor; with `[outdoors]`, where there is none, of the walls.
    #[schemars(range(min = 1.5, max = 20.0))]
    pub ceiling_height_m: f64,
    /// Albedo of the walls.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wall_albedo: f64,
    /// Albedo of the ceilings.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ceiling_albedo: f64,
    /// Height of the skirting boards; 0 for none.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub skirting_height_m: f64,
    /// Albedo of the skirting boards.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub skirting_albedo: f64,
    /// Greatest angle by which each piece of furniture stands turned against its `rotation_deg`, drawn at random for each seed. The map on which the
    /// robot plans its paths shows the stated angle.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub furniture_tolerance_deg: f64,
    /// Angle by which all walls stand turned about the middle of the robot's room, drawn at random for a seed. It is not a key of the scene, as
    /// neither the map nor the localizer may know it.
    #[serde(skip)]
    pub(crate) turned_rad: f64,
    /// Rooms besides the robot's own, which is stated as `[room]`: rectangles by `x_m`, `y_m`, `width_m` and `depth_m`, or polygons by `corners_m`.
    /// Where two rooms overlap there is no wall. All rooms together are at most 200 m long and wide.
    #[serde(rename = "room")]
    pub rooms: Vec<FurtherRoom>,
    /// Doors in walls. Between an open door and another door in its wall there are at least 14 cm of wall, for their frames.
    #[serde(rename = "door")]
    pub doors: Vec<Door>,
    /// Pictures on walls.
    #[serde(rename = "picture")]
    pub pictures: Vec<Picture>,
    /// Facades: stretches of wall of brick, with windows and doors.
    #[serde(rename = "facade", skip_serializing_if = "Vec::is_empty")]
    pub facades: Vec<Facade>,
    /// Round retro-reflective dots, which send the light of a lamp at a camera's lens back to that camera.
    #[serde(rename = "dot")]
    pub dots: Vec<Dot>,
}

/// A door in a wall. Its two jambs stand at the foot of the wall.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// World x and y of one jamb of the door.
    pub from_m: [f64; 2],
    /// World x and y of the other jamb of the door.
    pub to_m: [f64; 2],
    /// Height of the door's upper edge.
    #[serde(default = "default_door_height_m")]
    #[schemars(range(min = 0.5, max = 5.0))]
    pub height_m: f64,
    /// Whether the door is open, a hole in the walls at which it stands. A closed door is a leaf on these walls.
    #[serde(default)]
    pub open: bool,
    /// Albedo of the door's leaf and frame.
    #[serde(default = "default_door_albedo")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub albedo: f64,
}

/// A framed picture on a wall. Its left and right sides are stated by the points below them at the foot of the wall.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// World x and y of the point of the floor below one side of the picture.
    pub from_m: [f64; 2],
    /// World x and y of the point of the floor below the other side of the picture.
    pub to_m: [f64; 2],
    /// Height of the picture's lower edge above the floor.
    #[serde(default = "default_picture_bottom_m")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub bottom_m: f64,
    /// Height of the picture, from its lower to its upper edge.
    #[serde(default = "default_picture_height_m")]
    #[schemars(range(min = 0.05, max = 10.0))]
    pub height_m: f64,
    /// Number of the painting: each number gives a different painting.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1000000))]
    pub number: u32,
    /// Columns and rows of squares of a chessboard that is shown in place of a painting, for the calibration of cameras. A square's side is the
    /// picture's height over rows + 2, and the picture must be at least as wide as columns + 2 squares: a white margin goes round the board.
    #[serde(default)]
    #[schemars(inner(range(min = 2, max = 64)))]
    pub chessboard: Option<[u32; 2]>,
}

/// A facade along a stretch of wall, over the wall's whole height: bricks of uneven brightness, rows of windows, and doors at the ground. Its two ends
/// are points at the foot of the wall.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Facade {
    /// World x and y of the foot of one end of the facade.
    pub from_m: [f64; 2],
    /// World x and y of the foot of the other end of the facade.
    pub to_m: [f64; 2],
    /// Number of the facade: each number gives other bricks, windows, doors and stains.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1000000))]
    pub number: u32,
    /// Mean albedo of the facade.
    #[serde(default = "default_facade_albedo")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub albedo: f64,
}

/// A round retro-reflective dot that faces down from the ceiling.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dot {
    /// World x of the dot's centre.
    pub x_m: f64,
    /// World y of the dot's centre.
    pub y_m: f64,
    /// Height of the dot above the floor; just under the ceiling unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 20.0))]
    pub height_m: Option<f64>,
    /// Radius of the dot.
    #[serde(default = "default_dot_radius_m")]
    #[schemars(range(min = 0.001, max = 0.5))]
    pub radius_m: f64,
    /// Coefficient of retroreflection of the dot: luminous intensity per illuminance and area. Glass beads have 70, microprisms 400.
    #[serde(default = "default_retroreflection")]
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub retroreflection_cd_per_lux_m2: f64,
}

/// Coverings of a floor without tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Covering {
    /// Even grey screed.
    #[default]
    Screed,
    /// Cloudy, slightly glossy concrete.
    Concrete,
    /// Varnished boards along world x.
    Wood,
    /// Loop pile.
    Carpet,
    /// A film of water over the floor, which mirrors.
    Wet,
    /// Asphalt with stones, spots, patches and cracks.
    Asphalt,
}

impl Default for Building {
    fn default() -> Self {
        Building {
            ceiling_height_m: 2.6,
            wall_albedo: 0.65,
            ceiling_albedo: 0.8,
            skirting_height_m: 0.08,
            skirting_albedo: 0.35,
            furniture_tolerance_deg: 0.0,
            turned_rad: 0.0,
            rooms: Vec::new(),
            doors: Vec::new(),
            pictures: Vec::new(),
            facades: Vec::new(),
            dots: Vec::new(),
        }
    }
}

fn default_door_height_m() -> f64 {
    2.05
}

fn default_door_albedo() -> f64 {
    0.45
}

fn default_picture_bottom_m() -> f64 {
    1.2
}

fn default_picture_height_m() -> f64 {
    0.6
}

fn default_facade_albedo() -> f64 {
    0.35
}

fn default_dot_radius_m() -> f64 {
    0.01
}

pub(super) fn default_retroreflection() -> f64 {
    200.0
}
