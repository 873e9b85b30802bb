//! How `wall_directions` is set up.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;

/// What `wall_directions` knows of the building and how it looks for level edges.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallDirectionsSetup {
    /// Vision chain.
    pub chain: WallDirectionsChain,
    /// Directions of walls from world x that the map tells, modulo 90. Those of `[room]` and of every `[[building.room]]` unless stated.
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub mapped_deg: Option<Vec<f64>>,
    /// `wall_directions.direction`: a direction that the map tells is within this of a wall's, and each wall's, unless `learns` is set, is
    /// within this of one that the map tells.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub tolerance_deg: f64,
    /// Whether the edges of an image tell the body's lean together; otherwise each of them may have been seen at any lean within `body.tilt`.
    /// Together fewer of them may be wrong: a sixth and five of those of twenty images, and none in six of them.
    pub solves_lean: bool,
    /// Whether edges on the floor run along walls if they are long, as skirtings, foots of walls and borders of fitted carpets do. Joints of tiles
    /// need not.
    pub floor_edges: bool,
    /// Whether the building may have directions that the map does not tell, to be learnt.
    pub learns: bool,
}

/// How `wall_directions` finds level edges in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallDirectionsChain {
    /// Even noise, 2 × 2 bins, rolling guidance, segments, each measured again in the unfiltered image.
    #[default]
    Direct,
    /// Paper 2: histogram equalisation, rolling guidance, segments, sets A and B, RANSAC, Levenberg and Marquardt.
    Paper,
    /// The same with CLAHE in place of the equalisation.
    PaperByTiles,
}

impl Default for WallDirectionsSetup {
    fn default() -> Self {
        WallDirectionsSetup {
            chain: WallDirectionsChain::Direct,
            mapped_deg: None,
            tolerance_deg: 0.05,
            solves_lean: false,
            floor_edges: false,
            learns: false,
        }
    }
}

impl Scene {
    /// True directions of the walls from world x, modulo 90: the room's, then each further room's.
    pub fn true_wall_directions_deg(&self) -> Vec<f64> {
        std::iter::once(0.0).chain(self.building.rooms.iter().map(|room| room.heading_deg)).collect()
    }

    /// Directions that the map tells.
    pub fn mapped_wall_directions_deg(&self) -> Vec<f64> {
        let mapped = self.localizer.wall_directions.as_ref().and_then(|setup| setup.mapped_deg.clone());
        mapped.unwrap_or_else(|| self.true_wall_directions_deg())
    }
}
