//! Walls, ceiling, doors, pictures and further rooms about the room that the robot drives in.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What stands about and above the floor, as cameras that look ahead or up see it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Building {
    /// Height of every ceiling above the floor.
    #[schemars(range(min = 1.5, max = 20.0))]
    pub ceiling_height_m: f64,
    /// Albedo of the walls.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wall_albedo: f64,
    /// Albedo of the ceilings.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ceiling_albedo: f64,
    /// Height of the skirting; 0 for none.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub skirting_height_m: f64,
    /// Albedo of the skirting.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub skirting_albedo: f64,
    /// Each piece of furniture stands turned by up to this against its `rotation_deg`, as a seed draws it. The map of errands shows it as
    /// stated.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub furniture_tolerance_deg: f64,
    /// By how much all walls stand turned about the middle of `[room]`; no key, as the map and the localizer must not know: a seed draws it.
    #[serde(skip)]
    pub(crate) turned_rad: f64,
    /// Rooms beside `[room]`, rectangles at any angle. Where two rooms overlap there is no wall.
    #[serde(rename = "room")]
    pub rooms: Vec<FurtherRoom>,
    /// Doors in walls.
    #[serde(rename = "door")]
    pub doors: Vec<Door>,
    /// Pictures on walls.
    #[serde(rename = "picture")]
    pub pictures: Vec<Picture>,
    /// Round retro-reflective dots, which shine back into the lamp at a camera's own lens.
    #[serde(rename = "dot")]
    pub dots: Vec<Dot>,
}

/// A rectangular room at any angle.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FurtherRoom {
    /// World x of one corner.
    pub x_m: f64,
    /// World y of that corner.
    pub y_m: f64,
    /// Direction of the first side from world x; the second is to its left.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: f64,
    /// Length of the first side.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub width_m: f64,
    /// Length of the second side.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub depth_m: f64,
}

/// A door: its two jambs stand on a wall's foot.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// One jamb, world.
    pub from_m: [f64; 2],
    /// Other jamb, world.
    pub to_m: [f64; 2],
    /// Height of its upper edge.
    #[serde(default = "default_door_height_m")]
    #[schemars(range(min = 0.5, max = 5.0))]
    pub height_m: f64,
    /// Whether it is a hole in the walls at whose feet it stands; a closed one is a leaf on them.
    #[serde(default)]
    pub open: bool,
    /// Albedo of leaf and frame.
    #[serde(default = "default_door_albedo")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub albedo: f64,
}

/// A framed picture on a wall, given by the feet of its sides.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Below one side, world.
    pub from_m: [f64; 2],
    /// Below the other side, world.
    pub to_m: [f64; 2],
    /// Height of its lower edge.
    #[serde(default = "default_picture_bottom_m")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub bottom_m: f64,
    /// From its lower to its upper edge.
    #[serde(default = "default_picture_height_m")]
    #[schemars(range(min = 0.05, max = 10.0))]
    pub height_m: f64,
    /// Which picture: another number, another one.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1000000))]
    pub number: u32,
    /// Instead of a painting a chessboard of so many columns and rows of squares, for the calibration of cameras. A square's side is the
    /// height over rows + 2, and the picture must be as wide as columns + 2 of them: a white margin goes round the board.
    #[serde(default)]
    #[schemars(inner(range(min = 2, max = 64)))]
    pub chessboard: Option<[u32; 2]>,
}

/// A round retro-reflective dot that faces down from the ceiling.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dot {
    /// World x of its centre.
    pub x_m: f64,
    /// World y of its centre.
    pub y_m: f64,
    /// Height above the floor: just under the ceiling unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 20.0))]
    pub height_m: Option<f64>,
    /// Radius.
    #[serde(default = "default_dot_radius_m")]
    #[schemars(range(min = 0.001, max = 0.5))]
    pub radius_m: f64,
    /// Coefficient of retroreflection: luminous intensity per illuminance and area. Glass beads 70, microprisms 400.
    #[serde(default = "default_retroreflection")]
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub retroreflection_cd_per_lux_m2: f64,
}

/// What a floor is made of, where it has no tiles.
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
    /// A film of water over what is there, which mirrors.
    Wet,
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

fn default_dot_radius_m() -> f64 {
    0.01
}

pub(super) fn default_retroreflection() -> f64 {
    200.0
}
