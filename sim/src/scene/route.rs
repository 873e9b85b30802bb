//! Start pose of the robot, its route, and the poses at which it stands still.

use std::f64::consts::SQRT_2;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;

/// Pose of the robot at time 0, and the tolerances within which the localizer knows it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// World x of the nominal start.
    pub x_m: f64,
    /// World y of the nominal start.
    pub y_m: f64,
    /// Nominal heading at the start, counter-clockwise from world x.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub heading_deg: f64,
    /// Greatest distance of the true start from the nominal one, in x and y each; drawn at random.
    #[serde(default = "default_tolerance_m")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance_m: f64,
    /// Greatest difference of the true heading from the nominal one at the start; drawn at random.
    #[serde(default = "default_tolerance_deg")]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: f64,
    /// Whether the robot starts at any place that it can reach from `x_m` and `y_m`, with any heading up to 170° from `heading_deg`, both drawn at
    /// random. The localizer is told nothing of either but the map. The tolerances are not used then.
    #[serde(default)]
    pub anywhere: bool,
}

/// A drive through waypoints in their order. The robot is steered by its estimated pose, unless `led` is set.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// Waypoints to pass, in order.
    #[serde(rename = "waypoint")]
    #[schemars(length(min = 1))]
    pub waypoints: Vec<Waypoint>,
    /// Time for which the robot rests at its start before it drives.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub begins_s: f64,
    /// Whether the robot drives the route again after the last waypoint, until the run's time is up. A route whose waypoints are all at one position
    /// is not repeated.
    #[serde(default)]
    pub repeat: bool,
    /// Whether the robot is steered along the route by its true pose instead of its estimate, so that every localizer gets the same drive, even one
    /// that gets lost.
    #[serde(default)]
    pub led: bool,
    /// Width of the estimate's box, along x or y, up to which the robot drives at full speed. The wider the box is, the slower it drives, down to a
    /// quarter of its speed. With a box of more than the 0.2 m that apply unless stated, a waypoint 0.3 m from a wall is a risk.
    #[serde(default = "default_sure_width_m", skip_serializing_if = "is_default_sure_width")]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub sure_width_m: f64,
}

impl Route {
    /// Width up to which a robot is sure enough of its pose to drive at full speed, unless its route states another.
    pub const SURE_WIDTH_M: f64 = 0.2;
}

fn default_sure_width_m() -> f64 {
    Route::SURE_WIDTH_M
}

fn is_default_sure_width(width_m: &f64) -> bool {
    *width_m == Route::SURE_WIDTH_M
}

/// A position that the robot passes on its route.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Waypoint {
    /// World x of the waypoint.
    pub x_m: f64,
    /// World y of the waypoint.
    pub y_m: f64,
    /// Speed of the robot on the way to this waypoint.
    #[serde(default = "default_speed")]
    #[schemars(range(max = 5.0), extend("exclusiveMinimum" = 0.0))]
    pub speed_m_per_s: f64,
    /// Whether the robot turns in place at this waypoint towards the next one, instead of cutting the corner in a curve.
    #[serde(default)]
    pub turn_in_place: bool,
    /// Time for which the robot stands still at this waypoint.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub pause_s: f64,
}

/// A pose at which the robot is put and stands still for one image.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Station {
    /// World x of the station.
    pub x_m: f64,
    /// World y of the station.
    pub y_m: f64,
    /// Heading at the station, counter-clockwise from world x.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub heading_deg: f64,
    /// Greatest distance of the robot's true position at the station from the stated one, in x and y each; drawn at random. Unless stated, the
    /// start's tolerance applies.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance_m: Option<f64>,
    /// Greatest difference of the robot's true heading at the station from the stated one; drawn at random. Unless stated, the start's tolerance
    /// applies.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: Option<f64>,
}

/// Stations (poses at which the robot stands still) spread evenly over the room and over all headings, wherever the robot's body has room. They
/// follow a Halton sequence, so that the first hundred cover the room as evenly as all of them do, and they come after the stations that are stated
/// one by one.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Number of poses to spread over the room.
    #[schemars(range(min = 1, max = 100000))]
    pub count: usize,
    /// Greatest distance of the robot's true position at a station from the position chosen for it, in x and y each; drawn at random. Unless stated,
    /// the start's tolerance applies.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub tolerance_m: Option<f64>,
    /// Greatest difference of the robot's true heading at a station from the heading chosen for it; drawn at random. Unless stated, the start's
    /// tolerance applies.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub tolerance_deg: Option<f64>,
}

impl Scene {
    /// Least distance of furniture from a stated place of the robot that is drawn within a tolerance along each axis. The corners of the square in
    /// which the robot may then stand are farther from its middle than the sides.
    pub(crate) fn furniture_distance_m(&self, tolerance_m: f64) -> f64 {
        self.robot.body_radius_m + SQRT_2 * tolerance_m
    }

    /// Adds the stations (poses at which the robot stands still) that the key `station_spread` demands.
    pub(crate) fn spread_stations(&mut self) {
        let Some(spread) = self.station_spread.clone() else { return };
        let tolerance_m = spread.tolerance_m.unwrap_or(self.start.tolerance_m);
        let (margin_m, keep_m) = (self.robot.body_radius_m + tolerance_m, self.furniture_distance_m(tolerance_m));
        let extent_m = [self.room.width_m - 2.0 * margin_m, self.room.depth_m - 2.0 * margin_m];
        if extent_m.iter().any(|extent_m| *extent_m < 0.0) {
            return;
        }
        let is_clear = |at_m: [f64; 2]| self.furniture.iter().all(|piece| piece.distance_m(at_m) >= keep_m);
        // A room may be so full of furniture that no pose is free, so the search ends after a thousand times as many poses as are wanted.
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

/// Radical inverse of `index`: its digits in `base`, mirrored at the point, which gives a van der Corput sequence in `[0, 1)`.
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
