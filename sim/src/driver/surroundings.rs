//! What the scanner shows of the area ahead of the robot, and the obstacles that it has seen and that are not on the map.

use std::collections::BTreeMap;

use localizer::Pose;

use crate::{devices::scanner::Fan, place::navigation::OccupancyGrid};

/// Distance to something on the map within which a scan is taken to be of that thing. It covers the errors of the
/// estimate and of the sensor, and one grid cell.
const KNOWN_M: f64 = 0.15;

/// Distances at which the robot stops, measured from its body's edge: before obstacles that are not on the map, which may move, and before
/// obstacles that are.
const GAP_M: [f64; 2] = [0.2, 0.02];

/// Widths beyond the robot's body, on either side, within which an obstacle counts as ahead: for obstacles not on the map, and for those on it.
/// Both are less than the distance that planned paths keep from things.
const BESIDE_M: [f64; 2] = [0.06, 0.02];

/// Time from a scan until the robot brakes: the sensor's period and the acceleration's rise time.
const REACTION_S: f64 = 0.3;

/// How long an obstacle that was seen is assumed to be still there while the sensor does not look at it.
const MEMORY_S: f64 = 20.0;

/// Distance by which a beam of the scanner must reach beyond the remembered place of an obstacle to show that the place is free again.
const BEYOND_M: f64 = 0.15;

/// What the driver knows of the robot's surroundings: the map, the scanner's last scan, and obstacles seen that are not on the map.
#[derive(Clone, Debug)]
pub(super) struct Surroundings {
    map: OccupancyGrid,
    body_radius_m: f64,
    /// Greatest distance that the scanner measures.
    range_m: f64,
    /// End points of the last reading's beams in the robot frame, each with whether the map shows something there.
    ends_m: Vec<([f64; 2], bool)>,
    /// Grid cells with an obstacle that is not on the map, and when it was last seen.
    seen: BTreeMap<[usize; 2], f64>,
}

impl Surroundings {
    /// Surroundings of which only the map is known.
    pub(super) fn new(map: OccupancyGrid, body_radius_m: f64, range_m: f64) -> Self {
        Surroundings { map, body_radius_m, range_m, ends_m: Vec::new(), seen: BTreeMap::new() }
    }

    /// Takes in a scan, made at an estimated pose.
    pub(super) fn look(&mut self, fan: &Fan, pose: Pose) {
        self.forget(fan, pose);
        let beams = fan.beams.iter().filter_map(|beam| Some((beam.bearing_rad, beam.distance_m?)));
        self.ends_m = beams
            .map(|(bearing_rad, distance_m)| {
                let end_m = [distance_m * bearing_rad.cos(), distance_m * bearing_rad.sin()];
                let place_m = in_world(pose, end_m);
                let is_known = self.map.is_crowded(place_m, KNOWN_M);
                if let (false, Some(cell)) = (is_known, self.map.cell_at(place_m)) {
                    self.seen.insert(cell, fan.measured_s);
                }
                (end_m, is_known)
            })
            .collect();
    }

    /// Notes that the robot has run into something ahead of it.
    pub(super) fn bump(&mut self, pose: Pose, time_s: f64) {
        for bearing_rad in [-0.5, -0.25, 0.0, 0.25, 0.5_f64] {
            let reach_m = self.body_radius_m + 0.5 * self.map.resolution_m;
            let place_m = in_world(pose, [reach_m * bearing_rad.cos(), reach_m * bearing_rad.sin()]);
            self.seen.extend(self.map.cell_at(place_m).map(|cell| (cell, time_s)));
        }
    }

    /// Greatest speed from which the robot, braking with half of the given acceleration, stops before anything straight ahead.
    pub(super) fn speed_limit_m_per_s(&self, speed_m_per_s: f64, acceleration_m_per_s2: f64) -> f64 {
        let limit = |(end_m, is_known): &([f64; 2], bool)| {
            let side_m = self.body_radius_m + BESIDE_M[usize::from(*is_known)];
            if end_m[0] <= 0.0 || end_m[1].abs() >= side_m {
                return f64::INFINITY;
            }
            // The edge of the round body meets an obstacle before the body's middle does.
            let free_m = end_m[0] - (side_m * side_m - end_m[1] * end_m[1]).sqrt();
            let left_m = free_m - GAP_M[usize::from(*is_known)] - REACTION_S * speed_m_per_s.max(0.0);
            (acceleration_m_per_s2 * left_m.max(0.0)).sqrt()
        };
        self.ends_m.iter().map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Greatest speed from which the robot, braking with half of the given acceleration, stops before anything on its path: points ahead, each with
    /// the length of the path to it.
    pub(super) fn speed_limit_along_m_per_s(
        &self,
        pose: Pose,
        ahead: &[([f64; 2], f64)],
        speed_m_per_s: f64,
        acceleration_m_per_s2: f64,
    ) -> f64 {
        let (sin, cos) = pose.heading_rad.sin_cos();
        let in_robot = |[x_m, y_m]: [f64; 2]| {
            let (x_m, y_m) = (x_m - pose.x_m, y_m - pose.y_m);
            [cos * x_m + sin * y_m, cos * y_m - sin * x_m]
        };
        let ahead: Vec<([f64; 2], f64)> = ahead.iter().map(|(at_m, length_m)| (in_robot(*at_m), *length_m)).collect();
        let limit = |(end_m, is_known): &([f64; 2], bool)| {
            let side_m = self.body_radius_m + BESIDE_M[usize::from(*is_known)];
            // What is beside the robot already is in its way only if the path leads towards it.
            let near_m = side_m.min(end_m[0].hypot(end_m[1]) - 1e-3);
            let is_near = |at_m: &[f64; 2]| (at_m[0] - end_m[0]).hypot(at_m[1] - end_m[1]) < near_m;
            let Some((_, free_m)) = ahead.iter().find(|(at_m, _)| is_near(at_m)) else { return f64::INFINITY };
            let left_m = free_m - GAP_M[usize::from(*is_known)] - REACTION_S * speed_m_per_s;
            (acceleration_m_per_s2 * left_m.max(0.0)).sqrt()
        };
        self.ends_m.iter().map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Distance of a point from the nearest obstacle seen that is not on the map; infinite if there is none.
    pub(super) fn distance_m(&self, place_m: [f64; 2]) -> f64 {
        let places_m = self.seen.keys().map(|cell| self.map.centre_m(*cell));
        places_m.map(|at_m| (at_m[0] - place_m[0]).hypot(at_m[1] - place_m[1])).fold(f64::INFINITY, f64::min)
    }

    /// The map with the obstacles seen that are not on it added, and whether there are any.
    pub(super) fn map(&self) -> (OccupancyGrid, bool) {
        let mut map = self.map.clone();
        self.seen.keys().for_each(|cell| map.occupy(map.centre_m(*cell)));
        (map, !self.seen.is_empty())
    }

    /// Forgets obstacles that were seen long ago, and those through whose place a beam passes in the new reading.
    fn forget(&mut self, fan: &Fan, pose: Pose) {
        let (sin, cos) = pose.heading_rad.sin_cos();
        let spread_rad = match fan.beams.as_slice() {
            [first, second, ..] => second.bearing_rad - first.bearing_rad,
            _ => 0.0,
        };
        let (map, range_m) = (&self.map, self.range_m);
        self.seen.retain(|cell, seen_s| {
            let place_m = map.centre_m(*cell);
            let (x_m, y_m) = (place_m[0] - pose.x_m, place_m[1] - pose.y_m);
            let bearing_rad = (cos * y_m - sin * x_m).atan2(cos * x_m + sin * y_m);
            let far_m = x_m.hypot(y_m) + BEYOND_M;
            let mut near =
                fan.beams.iter().filter(|beam| (beam.bearing_rad - bearing_rad).abs() <= spread_rad).peekable();
            // A beam of the scanner that meets nothing has gone as far as the sensor's range.
            let is_through = near.peek().is_some() && near.all(|beam| beam.distance_m.unwrap_or(range_m) > far_m);
            !is_through && fan.measured_s - *seen_s < MEMORY_S
        });
    }
}

fn in_world(pose: Pose, [forward_m, left_m]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sin_cos();
    [pose.x_m + cos * forward_m - sin * left_m, pose.y_m + sin * forward_m + cos * left_m]
}
