//! Where the robot starts and where it goes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;

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
    /// The robot rests at its start for so long.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub begins_s: f64,
    /// Whether to begin again after the last waypoint, until the time is up. A route of one place alone ends there all the same.
    #[serde(default)]
    pub repeat: bool,
    /// Whether the robot is steered along the route by its true pose and not by its estimate, so that every localizer is given the same drive, also one that gets lost.
    #[serde(default)]
    pub led: bool,
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

/// Poses spread evenly over the room and over all headings, wherever the robot's body has room: a Halton sequence, so that the first
/// hundred cover the room as evenly as all do. They come after the stations that are stated.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// How many.
    #[schemars(range(min = 1, max = 100000))]
    pub count: usize,
    /// The true place is drawn within this of x and y, each; as for the start unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance_m: Option<f64>,
    /// The true heading is drawn within this; as for the start unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: Option<f64>,
}

impl Scene {
    /// Adds the stations that `spread` asks for.
    pub(crate) fn spread_stations(&mut self) {
        let Some(spread) = self.station_spread.clone() else { return };
        let margin_m = self.robot.body_radius_m + spread.tolerance_m.unwrap_or(self.start.tolerance_m);
        let extent_m = [self.room.width_m - 2.0 * margin_m, self.room.depth_m - 2.0 * margin_m];
        if extent_m.iter().any(|extent_m| *extent_m < 0.0) {
            return;
        }
        let is_clear = |at_m: [f64; 2]| self.furniture.iter().all(|piece| piece.distance_m(at_m) >= margin_m);
        // A room that is all furniture has no place; trying a thousand times as many poses is trying long enough.
        let poses = (1..=1000 * spread.count as u64).map(|index| {
            let [across, along, around] = [2, 3, 5].map(|base| radical_inverse(index, base));
            ([margin_m + across * extent_m[0], margin_m + along * extent_m[1]], 360.0 * around)
        });
        let stations = poses.filter(|(at_m, _)| is_clear(*at_m)).take(spread.count).map(|([x_m, y_m], heading_deg)| {
            Station { x_m, y_m, heading_deg, tolerance_m: spread.tolerance_m, tolerance_deg: spread.tolerance_deg }
        });
        let stations: Vec<Station> = stations.collect();
        self.stations.extend(stations);
    }
}

/// The digits of `index` mirrored at the point: a van der Corput sequence, in [0, 1).
fn radical_inverse(mut index: u64, base: u64) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f64;
        value += weight * (index % base) as f64;
        index /= base;
    }
    value
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
