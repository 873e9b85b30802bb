//! Errands: goals that the robot goes to, and how paths to them are planned and followed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::OccupancyGrid;

/// Settings for errands, which are goals to which the robot finds its own path.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Navigation {
    /// YAML file of a map in the format of ROS's map_server, as a path from the folder of the scene's file. Unless given, errands are planned on a
    /// map of the walls and the mapped furniture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// Control law that steers the robot along a planned path.
    pub follower: FollowerName,
    /// Greatest speed of the robot on a planned path.
    #[schemars(range(max = 5.0), extend("exclusiveMinimum" = 0.0))]
    pub speed_m_per_s: f64,
    /// Distance that planned paths keep between the robot's body and everything that the map shows.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub margin_m: f64,
    /// A goal counts as reached when the middle of the estimated box of poses is this near to it, unless the errand states another distance.
    #[schemars(range(min = 0.005, max = 5.0))]
    pub tolerance_m: f64,
    /// Number of goals that the seed draws at random, anywhere that the robot can get to. They come after the goals of `[[errand]]`.
    #[schemars(range(min = 0, max = 1000))]
    pub random_goals: usize,
    /// Time for which the robot waits when its path to a goal is blocked, before it looks for another path.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub patience_s: f64,
    /// Waiting time on the path to one goal, summed up, after which this goal is given up.
    #[schemars(range(max = 36000.0), extend("exclusiveMinimum" = 0.0))]
    pub give_up_s: f64,
    /// Contents of the map file that the key `map` names.
    #[serde(skip)]
    pub surveyed: Option<OccupancyGrid>,
}

/// Control law that steers the robot along a planned path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FollowerName {
    /// Steers towards a point of the path some decimetres ahead, so that small corners become curves. A car follows planned curves so, forwards and
    /// backwards.
    #[default]
    PurePursuit,
    /// Paper 5's law: turns towards the next corner of the path, then drives there. A car cannot.
    TurnThenDrive,
}

/// An errand: a goal to which the robot finds its own path.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Errand {
    /// Name of the errand, for tables.
    #[serde(default)]
    pub name: String,
    /// World x of the goal.
    pub x_m: f64,
    /// World y of the goal.
    pub y_m: f64,
    /// The goal counts as reached when the middle of the estimated box of poses is this near to it. Unless stated, the distance in `[navigation]`
    /// applies.
    #[serde(default)]
    #[schemars(range(min = 0.005, max = 5.0))]
    pub tolerance_m: Option<f64>,
    /// Time for which the robot stands still at the goal.
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
