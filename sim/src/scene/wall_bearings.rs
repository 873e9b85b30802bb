//! Setup of the method `wall_bearings`, which locates the robot by upright edges of walls.

use localizer::methods::wall_bearings::{Quotas, Setup};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Setup of the method `wall_bearings`, which locates the robot by upright edges of walls in images: corners of walls that stand out into a room,
/// as at the ends of free walls. The walls are those of the method `wall_ranges`, and `localizer.wall_ranges.placement_tolerance_m` says how
/// exactly their places are known.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallBearingsSetup {
    /// Height above the floor up to which furniture and other things have upright edges. An image edge is left out if it ended lower, were it an edge
    /// of a wall, and does not go on beyond the image.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tallest_thing_m: f64,
    /// Greatest share of the sightings of the twelve latest images, which the localizer uses together, that may be false. A sighting says that one of
    /// some image edges is one of some edges of walls; it is false where all these image edges are furniture, pictures, shadows or people.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_share: f64,
    /// Number of sightings of the twelve latest images that may be false in addition to `wrong_share`, for clutter that stays in view for a while.
    #[schemars(range(min = 0, max = 1000))]
    pub wrong_sightings: usize,
}

impl Default for WallBearingsSetup {
    fn default() -> Self {
        let Setup { tallest_thing_m, quotas } = Setup::default();
        WallBearingsSetup { tallest_thing_m, wrong_share: quotas.held_share, wrong_sightings: quotas.held_more }
    }
}

impl WallBearingsSetup {
    /// The settings of the method, as the localizer is given them.
    pub(crate) fn method(&self) -> Setup {
        let quotas = Quotas { held_share: self.wrong_share, held_more: self.wrong_sightings };
        Setup { tallest_thing_m: self.tallest_thing_m, quotas }
    }
}
