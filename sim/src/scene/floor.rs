//! The floor: tiles and their joints, friction by region, and things that lie on the floor.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{building::Covering, markers::is_zero};

/// Floor of the room: tiles or covering, friction, regions with properties of their own, and things that lie on the floor.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Floor {
    /// Tiles over the whole room. Without this table the floor is plain.
    pub tiles: Option<Tiles>,
    /// Covering of the floor where it has no tiles, as cameras that look ahead see it.
    pub covering: Covering,
    /// Share of the light that the floor mirrors at perpendicular incidence, except in regions with a covering of their own. Unless stated, that of
    /// the tiles or the covering: 0.03 for tiles and concrete, 0.04 for wood, 0.02 for water, none for the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub gloss: Option<f64>,
    /// Friction coefficient between tyre and floor outside every region.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub friction: f64,
    /// Share of the flow sensor's periods in which the sensor finds nothing to follow, outside every region.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub flow_dropout: f64,
    /// Rectangles of floor with properties of their own. Where they overlap, the last one listed counts.
    #[serde(rename = "region")]
    pub regions: Vec<Region>,
    /// Wires, tapes and other straight things on the floor that are not joints between tiles.
    #[serde(rename = "stray")]
    pub strays: Vec<Stray>,
}

/// A tiled floor. Its frame `grid` is the world frame turned by `rotation_deg` about the world origin.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tiles {
    /// Distance from one joint's centre line to the next joint's along grid x: a tile's edge and a joint's width.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub edge_x_m: f64,
    /// Distance from one joint's centre line to the next joint's along grid y: a tile's edge and a joint's width.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub edge_y_m: f64,
    /// Angle from world x to the x axis of the tiles' grid.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Coordinate, along the x axis of the tiles' grid, of the centre line of the joint with index 0.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub phase_x_m: f64,
    /// Coordinate, along the y axis of the tiles' grid, of the centre line of the joint with index 0.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub phase_y_m: f64,
    /// Width of the joints.
    #[schemars(range(min = 0.0005, max = 0.05))]
    pub joint_width_m: f64,
    /// Albedo of the joints.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub joint_albedo: f64,
    /// Mean albedo of the tiles.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tile_albedo: f64,
    /// Greatest departure of a single tile's albedo from the mean.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub tile_albedo_spread: f64,
    /// Pattern on the surface of each tile.
    pub pattern: Pattern,
    /// Amplitude of the tiles' pattern, as a share of the tile's albedo.
    #[schemars(range(min = 0.0, max = 0.6))]
    pub pattern_contrast: f64,
    /// Greatest displacement of each end of a joint from its nominal position, drawn at random. Between its ends every joint is laid along a straight
    /// line.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub laying_tolerance_m: f64,
    /// Greatest further displacement of each corner of the grid, in x and y each, drawn at random. It makes joints bend from tile to tile.
    #[schemars(range(min = 0.0, max = 0.02))]
    pub corner_tolerance_m: f64,
    /// Share of the length of all joints that is worn. There the joint's contrast fades to a third.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub worn_share: f64,
    /// Share of the tiles' edges along which the joint cannot be seen at all.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub missing_share: f64,
    /// Tiles that are displaced from their nominal position. The localizer is not given the displacement.
    pub misplaced: Vec<Misplaced>,
}

/// Pattern on the surface of each tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// The same albedo all over each tile.
    Plain,
    /// Fine irregular spots.
    #[default]
    Speckle,
    /// Broad cloudy veins.
    Marble,
    /// Printed straight stripes, parallel to grid y and a fifth of the tile apart.
    Stripes,
}

/// A tile whose four corners are all displaced by the same vector.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Misplaced {
    /// Indices `[i, j]` of the tile, which lies between joints `i` and `i + 1` of grid x, and `j` and `j + 1` of grid y.
    pub tile: [i32; 2],
    /// Displacement of the tile along grid x and grid y.
    #[schemars(inner(range(min = -0.05, max = 0.05)))]
    pub offset_m: [f64; 2],
}

/// A rectangle of floor with properties of its own: a carpet, a threshold, a wet place.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Name of the region, by which events, and sweeps over a key's values, refer to it.
    pub name: String,
    /// Range of world x that the floor region covers before it is turned by `rotation_deg`, from the least to the greatest.
    pub x_m: [f64; 2],
    /// Range of world y that the floor region covers before it is turned by `rotation_deg`, from the least to the greatest.
    pub y_m: [f64; 2],
    /// Angle by which the floor region is turned about its middle, counter-clockwise; 0 unless stated. The region must lie within the room as it is
    /// turned.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Friction coefficient between tyre and floor in the region.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub friction: f64,
    /// Covering of the floor in the region, as cameras that look ahead see it. Unless stated, that of the floor around it.
    #[serde(default)]
    pub covering: Option<Covering>,
    /// Stiffness of a carpet's pile under a tyre: force per load and unit of slip. It acts in series with the tyre's own stiffness of 25. Unless
    /// stated, the floor is hard.
    #[serde(default)]
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub pile_stiffness: Option<f64>,
    /// Drift of a wheel with the carpet's nap: metres per metre rolled, apart from any slip.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub nap_drift: f64,
    /// Direction in which the carpet's nap carries a wheel, measured from world x. It is the same whichever way the wheel rolls.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub nap_direction_deg: f64,
    /// Drag of a carpet's pile on wheels and casters that roll over it, as a share of the load on them.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub drag: f64,
    /// Height, above the room's floor, of the surface that wheels roll on in the region, such as a carpet's or a threshold's.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.05))]
    pub height_m: f64,
    /// Width of the ramp along the inside of the region's edges, over which the floor rises to `height_m`. A wheel of radius R rises over a step h
    /// within √(2Rh − h²).
    #[serde(default = "default_ramp_m")]
    #[schemars(range(min = 0.005, max = 1.0))]
    pub ramp_m: f64,
    /// Height of the tips of a carpet's pile above the surface that wheels roll on. A flow sensor looks at these tips.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.05))]
    pub pile_height_m: f64,
    /// Share of the flow sensor's periods in which the sensor finds nothing to follow in the region. Unless stated, that of the floor around it.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub flow_dropout: Option<f64>,
}

/// A straight thing on the floor that is not a joint between tiles, such as a wire or a tape.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stray {
    /// World x and y of one end of the wire, tape or other straight thing.
    pub from_m: [f64; 2],
    /// World x and y of the other end of the wire, tape or other straight thing.
    pub to_m: [f64; 2],
    /// Width of the straight thing.
    #[schemars(range(min = 0.0005, max = 0.2))]
    pub width_m: f64,
    /// Albedo of the straight thing.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub albedo: f64,
}

impl Region {
    /// Where a point of the world was before the region was turned about its middle, together with the region.
    pub(crate) fn unturned(&self, at_m: [f64; 2]) -> [f64; 2] {
        self.turned_about_middle(at_m, -self.rotation_deg)
    }

    /// The place in the world of a point that is given as it was before the region was turned about its middle.
    pub(crate) fn in_world(&self, at_m: [f64; 2]) -> [f64; 2] {
        self.turned_about_middle(at_m, self.rotation_deg)
    }

    /// Whether a point of the world lies in the region or on its edge.
    pub(crate) fn covers(&self, at_m: [f64; 2]) -> bool {
        let [x_m, y_m] = self.unturned(at_m);
        (self.x_m[0]..=self.x_m[1]).contains(&x_m) && (self.y_m[0]..=self.y_m[1]).contains(&y_m)
    }

    /// The region's corners in the world, counter-clockwise.
    pub(crate) fn corners_m(&self) -> [[f64; 2]; 4] {
        let ([x0, x1], [y0, y1]) = (self.x_m, self.y_m);
        [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|corner_m| self.in_world(corner_m))
    }

    /// The direction in the world of a vector that is given as it was before the region was turned.
    pub(crate) fn direction_in_world(&self, vector: [f64; 2]) -> [f64; 2] {
        turned(vector, self.rotation_deg)
    }

    fn turned_about_middle(&self, at_m: [f64; 2], by_deg: f64) -> [f64; 2] {
        // A region that is not turned keeps its corners to the last digit.
        if by_deg == 0.0 {
            return at_m;
        }
        let middle_m = [self.x_m, self.y_m].map(|[low, high]| 0.5 * (low + high));
        let off_m = turned([at_m[0] - middle_m[0], at_m[1] - middle_m[1]], by_deg);
        [middle_m[0] + off_m[0], middle_m[1] + off_m[1]]
    }
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

/// A vector turned counter-clockwise.
fn turned([x, y]: [f64; 2], by_deg: f64) -> [f64; 2] {
    let (sin, cos) = by_deg.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

fn default_ramp_m() -> f64 {
    0.03
}
