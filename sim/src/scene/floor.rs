//! The floor: tiles and their joints, friction by region, and things that lie on it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::building::Covering;

/// The floor of the room.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Floor {
    /// Tiles over the whole room; without them the floor is plain.
    pub tiles: Option<Tiles>,
    /// What the floor is made of where it has no tiles, as cameras that look ahead see it.
    pub covering: Covering,
    /// Share of the light that the floor mirrors at right incidence, regions with a covering of their own apart; as its tiles or its
    /// covering do unless stated: 0.03 tiles and concrete, 0.04 wood, 0.02 water, none others.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub gloss: Option<f64>,
    /// Friction coefficient between tyre and floor outside every region.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub friction: f64,
    /// Share of the flow sensor's periods in which it finds nothing to follow, outside every region.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub flow_dropout: f64,
    /// Rectangles with properties of their own; the last one listed wins.
    #[serde(rename = "region")]
    pub regions: Vec<Region>,
    /// Wires, tape and other straight things that are no joints.
    #[serde(rename = "stray")]
    pub strays: Vec<Stray>,
}

/// A tiled floor. Frame `grid`: the world frame turned by `rotation_deg` about the world origin.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tiles {
    /// Pitch of the joints along grid x, joint included.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub edge_x_m: f64,
    /// Pitch of the joints along grid y, joint included.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub edge_y_m: f64,
    /// Angle from world x to grid x.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Grid x of the centre line of joint 0.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub phase_x_m: f64,
    /// Grid y of the centre line of joint 0.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub phase_y_m: f64,
    /// Width of a joint.
    #[schemars(range(min = 0.0005, max = 0.05))]
    pub joint_width_m: f64,
    /// Albedo of a joint.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub joint_albedo: f64,
    /// Mean albedo of a tile.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tile_albedo: f64,
    /// Greatest departure of one tile's albedo from the mean.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub tile_albedo_spread: f64,
    /// What is printed or grown on the tiles.
    pub pattern: Pattern,
    /// Amplitude of the pattern, as a share of the tile's albedo.
    #[schemars(range(min = 0.0, max = 0.6))]
    pub pattern_contrast: f64,
    /// Each joint is a straight line, both of its ends drawn within this of their nominal place.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub laying_tolerance_m: f64,
    /// Each corner of the grid is moved besides by up to this in x and y, so that joints bend from tile to tile.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub corner_tolerance_m: f64,
    /// Share of the length of joints that is worn: its contrast fades to a third.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub worn_share: f64,
    /// Share of tile edges whose joint is not to be seen at all.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub missing_share: f64,
    /// Tiles laid off their place, undeclared to the localizer.
    pub misplaced: Vec<Misplaced>,
}

/// What is on a tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// One albedo over the tile.
    Plain,
    /// Fine irregular spots.
    #[default]
    Speckle,
    /// Broad cloudy veins.
    Marble,
    /// Printed straight stripes, parallel to grid y, a fifth of the tile apart.
    Stripes,
}

/// A tile whose four corners are all displaced.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Misplaced {
    /// Tile between joints `i` and `i + 1` of grid x, and `j` and `j + 1` of grid y.
    pub tile: [i32; 2],
    /// Displacement along grid x and grid y.
    #[schemars(inner(range(min = -0.05, max = 0.05)))]
    pub offset_m: [f64; 2],
}

/// A rectangle of floor with properties of its own: a carpet, a threshold, a wet place.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Name, for events and sweeps.
    pub name: String,
    /// World x range.
    pub x_m: [f64; 2],
    /// World y range.
    pub y_m: [f64; 2],
    /// Friction coefficient.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub friction: f64,
    /// What covers the floor here, as cameras that look ahead see it; what is around when absent.
    #[serde(default)]
    pub covering: Option<Covering>,
    /// Stiffness of the pile under a tyre: force per load and unit of slip, in series with the tyre's own 25. A hard floor when absent.
    #[serde(default)]
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub pile_stiffness: Option<f64>,
    /// How far the nap carries a wheel per metre rolled, apart from any slip.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub nap_drift: f64,
    /// Where to the nap carries it, from world x, whatever way the wheel rolls.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub nap_direction_deg: f64,
    /// Drag of the pile on wheels and casters that pass, as a share of the load on them.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub drag: f64,
    /// Height above the room's floor of what the wheels roll on: a carpet's or a threshold's.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.05))]
    pub height_m: f64,
    /// Width, inside of the edges, in which the height is gathered. A wheel of radius R rises over a step h in √(2Rh − h²).
    #[serde(default = "default_ramp_m")]
    #[schemars(range(min = 0.005, max = 1.0))]
    pub ramp_m: f64,
    /// How far the tips of the pile stand above what the wheels roll on: it is them that a flow sensor looks at.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.05))]
    pub pile_height_m: f64,
    /// Share of the flow sensor's periods in which it finds nothing to follow here; as around when absent.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub flow_dropout: Option<f64>,
}

/// A straight thing on the floor that is no joint: a wire, a tape.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stray {
    /// One end, world.
    pub from_m: [f64; 2],
    /// Other end, world.
    pub to_m: [f64; 2],
    /// Width.
    #[schemars(range(min = 0.0005, max = 0.2))]
    pub width_m: f64,
    /// Albedo.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub albedo: f64,
}

impl Default for Floor {
    /// A plain floor with the grip of rubber on dry ceramic.
    fn default() -> Self {
        Floor {
            tiles: None,
            covering: Covering::default(),
            gloss: None,
            friction: 0.8,
            flow_dropout: 0.0,
            regions: Vec::new(),
            strays: Vec::new(),
        }
    }
}

impl Default for Tiles {
    fn default() -> Self {
        Tiles {
            edge_x_m: 0.30,
            edge_y_m: 0.30,
            rotation_deg: 0.0,
            phase_x_m: 0.0,
            phase_y_m: 0.0,
            joint_width_m: 0.004,
            joint_albedo: 0.25,
            tile_albedo: 0.55,
            tile_albedo_spread: 0.03,
            pattern: Pattern::Speckle,
            pattern_contrast: 0.04,
            laying_tolerance_m: 0.0005,
            corner_tolerance_m: 0.0,
            worn_share: 0.0,
            missing_share: 0.0,
            misplaced: Vec::new(),
        }
    }
}

fn default_ramp_m() -> f64 {
    0.03
}
