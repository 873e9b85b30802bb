//! Setup of the method `wall_ranges`, which locates the robot by the distances of walls.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Setup of the method `wall_ranges`, which locates the robot by the distances that a planar range scanner measures: what it knows of the building's
/// walls. They are the sides of all rooms without their doors, and the pieces of furniture whose key `wall` is set.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WallRangesSetup {
    /// Bound `walls.placement`: greatest distance of any point of a wall from its place on the map. Each seed turns all walls together by a random
    /// angle that keeps them within it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub placement_tolerance_m: f64,
    /// Greatest share of the beams of a scan that end elsewhere than at a mapped wall, of those that end at anything: at furniture, people, doors.
    /// Unless stated, only the rule is used that no beam passes through a wall, which holds whatever the beams meet.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_share: Option<f64>,
}

impl Default for WallRangesSetup {
    fn default() -> Self {
        WallRangesSetup { placement_tolerance_m: 0.01, wrong_share: None }
    }
}
