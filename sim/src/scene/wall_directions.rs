//! Setup of the method `wall_directions`, which finds the heading from level edges along walls.

use localizer::methods::wall_directions::{LEARNT_APART_RAD, Quotas};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FurtherRoom, Scene};

/// Setup of the method `wall_directions`, which finds the heading by level edges in images: what it knows of the building's walls, and how it
/// finds the edges.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallDirectionsSetup {
    /// Image processing by which the method `wall_directions` finds level edges.
    pub chain: WallDirectionsChain,
    /// Directions of walls on the localizer's map, measured from world x, modulo 90. Unless stated, those of `[room]` and of every
    /// `[[building.room]]`: of one with `corners_m`, those of all its sides.
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub mapped_deg: Option<Vec<f64>>,
    /// Bound `wall_directions.direction`: greatest angle from each direction on the localizer's map to the nearest true direction of a wall, and from
    /// each wall's true direction to the nearest one on the map. With `learns` set, walls more than 10 degrees off every direction on the map are
    /// exempt. Each seed turns all walls together by a random angle within this tolerance.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub tolerance_deg: f64,
    /// Bound `wall_directions.askew`: greatest angle between a wall and the furniture along it. Furniture counts as along a wall if it is turned by
    /// at most 5 degrees against a wall of the scene. Every range of headings found from walls is widened by this angle on either side.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub askew_deg: f64,
    /// Whether the tilt of the robot's body is solved for from all edges of an image together. Otherwise each edge may have been seen at any tilt
    /// within the bound `body.tilt`. If the tilt is solved for, fewer edges may be wrong: `wrong_held_share` and `wrong_held_edges` replace
    /// `wrong_images`.
    pub solves_lean: bool,
    /// Greatest share of an image's level edges that run along no wall direction, and of its upright edges that are not truly upright. Such wrong
    /// edges come from clutter, people and pictures that hang askew.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_edge_share: f64,
    /// Greatest number of images with more wrong edges than `wrong_edge_share` allows, among the ten latest images, which the localizer uses
    /// together.
    #[schemars(range(min = 0, max = 10))]
    pub wrong_images: usize,
    /// With `solves_lean`: greatest share of wrong edges, which run along no wall direction, among the level edges of the twenty latest images, which
    /// the localizer uses together. `wrong_held_edges` more are allowed.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_held_share: f64,
    /// With `solves_lean`: number of wrong edges allowed in the twenty latest images in addition to `wrong_held_share`, for clutter that stays in
    /// view for a while.
    #[schemars(range(min = 0, max = 1000))]
    pub wrong_held_edges: usize,
    /// With `solves_lean`: greatest number of images that have any wrong edge, among the twenty latest images, which the localizer uses together.
    #[schemars(range(min = 0, max = 20))]
    pub spoilt_images: usize,
    /// Whether long edges on the floor are taken to run along walls, as skirtings, feet of walls and borders of fitted carpets do. Joints between
    /// tiles need not run along walls.
    pub floor_edges: bool,
    /// Whether the building may have wall directions that are not on the localizer's map and that it learns during the run. Each of these is more
    /// than 10 degrees off every direction on the map.
    pub learns: bool,
}

/// Image processing by which the method `wall_directions` finds level edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallDirectionsChain {
    /// Direct processing chain for finding level edges: noise made even, 2 × 2 binning, rolling guidance filter, line segments, each measured again
    /// in the unfiltered image.
    #[default]
    Direct,
    /// Paper 2's processing chain for finding level edges: histogram equalisation, rolling guidance filter, line segments, the paper's sets A and B,
    /// RANSAC, Levenberg and Marquardt's fit.
    Paper,
    /// Paper 2's processing chain for finding level edges, with CLAHE in place of histogram equalisation.
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
    /// Numbers and shares of edges that may be wrong, as declared to the localizer and to the judge that checks its results.
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
    /// Directions of the walls as the scene states them, measured from world x, modulo 90: the room's first, then each further room's, of which a
    /// polygon may have several.
    pub fn stated_wall_directions_deg(&self) -> Vec<f64> {
        std::iter::once(0.0).chain(self.building.rooms.iter().flat_map(FurtherRoom::wall_directions_deg)).collect()
    }

    /// Directions of the walls on the localizer's map, measured from world x, modulo 90.
    pub fn mapped_wall_directions_deg(&self) -> Vec<f64> {
        let mapped = self.localizer.wall_directions.as_ref().and_then(|setup| setup.mapped_deg.clone());
        mapped.unwrap_or_else(|| self.stated_wall_directions_deg())
    }

    /// Error of the localizer's map of wall directions: the greatest angle from a mapped direction to the nearest wall's, or from a wall's direction
    /// to the nearest mapped one, modulo quarter turns.
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
        // A wall direction missing on the map counts as an error just as a mapped one that no wall has, unless the scene lets such directions be
        // learnt.
        let untold_deg = true_deg.iter().map(|deg| farthest_deg(&[*deg], &mapped_deg));
        let untold_deg = untold_deg.filter(|off_deg| !self.is_learnt_at(*off_deg)).fold(0.0, f64::max);
        farthest_deg(&mapped_deg, true_deg).max(untold_deg)
    }

    /// Whether a wall direction that is `off_deg` off every mapped one is certain to be learnt by the localizer, so that its map need not have it.
    pub(crate) fn is_learnt_at(&self, off_deg: f64) -> bool {
        self.localizer.wall_directions().learns && off_deg > LEARNT_APART_RAD.to_degrees()
    }
}
