//! Errands: places to go to, how ways there are found and followed, and the sensor that looks out for what is in the way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::OccupancyGrid;

/// How errands are planned and driven.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Navigation {
    /// YAML file of a map as ROS's map_server reads it, beside the scene's file. Walls and mapped furniture unless given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// What steers along a planned way.
    pub follower: FollowerName,
    /// Greatest speed on a way.
    #[schemars(range(max = 5.0), extend("exclusiveMinimum" = 0.0))]
    pub speed_m_per_s: f64,
    /// Ways keep the robot's body this far from what the map shows.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub margin_m: f64,
    /// A goal is reached when the middle of the estimate is so near to it, unless the errand says otherwise.
    #[schemars(range(min = 0.005, max = 5.0))]
    pub tolerance_m: f64,
    /// So many goals are drawn by the seed, after those of `[[errand]]`, anywhere that the robot can get to.
    #[schemars(range(min = 0, max = 1000))]
    pub random_goals: usize,
    /// How long a robot whose way is blocked waits before it looks for another.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub patience_s: f64,
    /// An errand on which the robot has waited for so long in all is given up.
    #[schemars(range(max = 36000.0), extend("exclusiveMinimum" = 0.0))]
    pub give_up_s: f64,
    /// What the file `map` holds.
    #[serde(skip)]
    pub surveyed: Option<OccupancyGrid>,
}

/// What steers along a planned way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FollowerName {
    /// Towards a point of the way some decimetres ahead, so that small corners become curves.
    #[default]
    PurePursuit,
    /// Paper 5: turn towards the next corner, then drive there.
    TurnThenDrive,
}

/// A place to find a way to.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Errand {
    /// What it is, for tables.
    #[serde(default)]
    pub name: String,
    /// World x.
    pub x_m: f64,
    /// World y.
    pub y_m: f64,
    /// It is reached when the middle of the estimate is so near; as `[navigation]` says unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.005, max = 5.0))]
    pub tolerance_m: Option<f64>,
    /// Stand still there for so long.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub pause_s: f64,
}

impl Default for Navigation {
    fn default() -> Self {
        Navigation {
            map: None,
            follower: FollowerName::default(),
            speed_m_per_s: 0.4,
            margin_m: 0.08,
            tolerance_m: 0.05,
            random_goals: 0,
            patience_s: 3.0,
            give_up_s: 60.0,
            surveyed: None,
        }
    }
}
