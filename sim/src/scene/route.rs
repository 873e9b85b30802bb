//! Where the robot starts and where it goes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The pose at time 0 and the box in which the localizer is told that it lies.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// World x.
    pub x_m: f64,
    /// World y.
    pub y_m: f64,
    /// Heading from world x, counter-clockwise.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub heading_deg: f64,
    /// The true start is drawn within this of x and y, each.
    #[serde(default = "default_tolerance_m")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance_m: f64,
    /// The true start is drawn within this of the heading.
    #[serde(default = "default_tolerance_deg")]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: f64,
}

/// A drive through waypoints, in order, by the estimated pose.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// Places to pass, world.
    #[serde(rename = "waypoint")]
    #[schemars(length(min = 1))]
    pub waypoints: Vec<Waypoint>,
    /// Whether to begin again after the last waypoint, until the time is up.
    #[serde(default)]
    pub repeat: bool,
}

/// One place to pass.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Waypoint {
    /// World x.
    pub x_m: f64,
    /// World y.
    pub y_m: f64,
    /// Speed on the way here.
    #[serde(default = "default_speed")]
    #[schemars(range(max = 5.0), extend("exclusiveMinimum" = 0.0))]
    pub speed_m_per_s: f64,
    /// Turn in place towards the next waypoint here, instead of cutting the corner in a curve.
    #[serde(default)]
    pub turn_in_place: bool,
    /// Stand still here for so long.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub pause_s: f64,
}

/// A pose at which the robot is put and stands still for one image.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Station {
    /// World x.
    pub x_m: f64,
    /// World y.
    pub y_m: f64,
    /// Heading from world x, counter-clockwise.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub heading_deg: f64,
    /// The true place is drawn within this of x and y, each; as for the start unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance_m: Option<f64>,
    /// The true heading is drawn within this; as for the start unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: Option<f64>,
}

fn default_tolerance_m() -> f64 {
    0.01
}

fn default_tolerance_deg() -> f64 {
    1.0
}

fn default_speed() -> f64 {
    0.4
}
