//! How `wall_directions` is set up.

use localizer::methods::wall_directions::{LEARNT_APART_RAD, Quotas};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{MethodName, Scene};

/// What `wall_directions` knows of the building and how it looks for level edges.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallDirectionsSetup {
    /// Vision chain.
    pub chain: WallDirectionsChain,
    /// Directions of walls from world x that the map tells, modulo 90. Those of `[room]` and of every `[[building.room]]` unless stated.
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub mapped_deg: Option<Vec<f64>>,
    /// `wall_directions.direction`: a direction that the map tells is within this of a wall's, and each wall's is within this of one that the map
    /// tells; with `learns` set, those of walls that are more than 10 degrees off every direction that the map tells need not. A seed draws by how much all walls together stand turned within it.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub tolerance_deg: f64,
    /// `wall_directions.askew`: furniture that stands along walls, turned by at most 5 degrees against one in the scene, is within this of a
    /// wall's direction. Every box of headings by walls grows by as much on either side.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub askew_deg: f64,
    /// Whether the edges of an image tell the body's lean together; otherwise each of them may have been seen at any lean within `body.tilt`.
    /// Together fewer of them may be wrong: `wrong_held_share` and `wrong_held_edges` in place of `wrong_images`.
    pub solves_lean: bool,
    /// At most this share of an image's level edges run along none of the directions, and of its upright edges are not upright: clutter,
    /// people, pictures that hang askew.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_edge_share: f64,
    /// Of ten images held at most so many have more wrong edges than that.
    #[schemars(range(min = 0, max = 10))]
    pub wrong_images: usize,
    /// With `solves_lean`, at most this share of the level edges of twenty images held, and `wrong_held_edges` more, run along none of the
    /// directions.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_held_share: f64,
    /// See `wrong_held_share`: what clutter that stays in view for a while adds.
    #[schemars(range(min = 0, max = 1000))]
    pub wrong_held_edges: usize,
    /// With `solves_lean`, of twenty images held at most so many have any wrong edge.
    #[schemars(range(min = 0, max = 20))]
    pub spoilt_images: usize,
    /// Whether edges on the floor run along walls if they are long, as skirtings, foots of walls and borders of fitted carpets do. Joints of tiles
    /// need not.
    pub floor_edges: bool,
    /// Whether the building may have directions that the map does not tell, to be learnt: each more than 10 degrees off every one that it tells.
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
        let quotas = Quotas::default();
        WallDirectionsSetup {
            chain: WallDirectionsChain::Direct,
            mapped_deg: None,
            tolerance_deg: 0.05,
            askew_deg: 0.0,
            solves_lean: false,
            wrong_edge_share: quotas.edge_share,
            wrong_images: quotas.images,
            wrong_held_share: quotas.held_share,
            wrong_held_edges: quotas.held_edges,
            spoilt_images: quotas.spoilt_images,
            floor_edges: false,
            learns: false,
        }
    }
}

impl WallDirectionsSetup {
    /// How many edges may be wrong, as the localizer and its judge are told.
    pub fn quotas(&self) -> Quotas {
        Quotas {
            edge_share: self.wrong_edge_share,
            images: self.wrong_images,
            held_share: self.wrong_held_share,
            held_edges: self.wrong_held_edges,
            spoilt_images: self.spoilt_images,
        }
    }
}

impl Scene {
    /// Directions of the walls from world x as the scene states them, modulo 90: the room's, then each further room's.
    pub fn stated_wall_directions_deg(&self) -> Vec<f64> {
        std::iter::once(0.0).chain(self.building.rooms.iter().map(|room| room.heading_deg)).collect()
    }

    /// Directions that the map tells.
    pub fn mapped_wall_directions_deg(&self) -> Vec<f64> {
        let mapped = self.localizer.wall_directions.as_ref().and_then(|setup| setup.mapped_deg.clone());
        mapped.unwrap_or_else(|| self.stated_wall_directions_deg())
    }

    /// How far the map is off: its direction that is farthest from every wall's, or the wall's that is farthest from every mapped one,
    /// modulo quarter turns.
    pub(crate) fn wall_directions_off_deg(&self, true_deg: &[f64]) -> f64 {
        let mapped_deg = self.mapped_wall_directions_deg();
        let farthest_deg = |some_deg: &[f64], others_deg: &[f64]| {
            let off_deg = |of_deg: &f64| {
                let from = |other_deg: &f64| {
                    let turn_deg = (of_deg - other_deg).rem_euclid(90.0);
                    turn_deg.min(90.0 - turn_deg)
                };
                others_deg.iter().map(from).fold(90.0, f64::min)
            };
            some_deg.iter().map(off_deg).fold(0.0, f64::max)
        };
        // A direction that the map does not tell is as wrong as one that no wall has, unless the building is said to have such that can be learnt.
        let untold_deg = true_deg.iter().map(|deg| farthest_deg(&[*deg], &mapped_deg));
        let untold_deg = untold_deg.filter(|off_deg| !self.is_learnt_at(*off_deg)).fold(0.0, f64::max);
        farthest_deg(&mapped_deg, true_deg).max(untold_deg)
    }

    /// Whether a wall's direction so far off every one that the map tells is surely learnt, and need not be told.
    pub(crate) fn is_learnt_at(&self, off_deg: f64) -> bool {
        self.localizer.wall_directions().learns && off_deg > LEARNT_APART_RAD.to_degrees()
    }

    /// Whether a seed draws how walls stand: where a method reads them.
    pub(crate) fn draws_walls(&self) -> bool {
        self.localizer.methods.contains(&MethodName::WallDirections)
    }

    /// How far walls may stand turned against where the scene has them: what a map that is off as stated leaves of its tolerance.
    pub(crate) fn walls_askew_deg(&self) -> f64 {
        if !self.draws_walls() {
            return 0.0;
        }
        let off_deg = self.wall_directions_off_deg(&self.stated_wall_directions_deg());
        (self.localizer.wall_directions().tolerance_deg - off_deg).max(0.0)
    }
}
