//! What the proximity sensor says about the way ahead, and what it has seen that the map does not show.

use std::collections::BTreeMap;

use localizer::Pose;

use crate::{devices::proximity::Fan, navigation::OccupancyGrid};

/// What lies nearer than this to something on the map is taken for it: the estimate's error, the sensor's and a cell.
const KNOWN_M: f64 = 0.15;

/// The body's edge stops this far from what the map does not show, which may move, and from what it shows.
const GAP_M: [f64; 2] = [0.2, 0.02];

/// What counts as ahead reaches this far beyond the body to either side, for the same two; less than ways keep away.
const BESIDE_M: [f64; 2] = [0.06, 0.02];

/// Time from a reading to the brakes: the sensor's period and the ramp's rise.
const REACTION_S: f64 = 0.3;

/// How long what was seen is believed to be there while nobody looks.
const MEMORY_S: f64 = 20.0;

/// A beam that goes so much beyond a remembered place shows that it is free again.
const BEYOND_M: f64 = 0.15;

/// What is about the robot.
#[derive(Clone, Debug)]
pub(super) struct Surroundings {
    map: OccupancyGrid,
    body_radius_m: f64,
    /// How far the sensor reaches.
    range_m: f64,
    /// Ends of the last reading's beams in the robot frame, and whether the map shows something there.
    ends_m: Vec<([f64; 2], bool)>,
    /// Cells with something that the map does not show, and when it was seen last.
    seen: BTreeMap<[usize; 2], f64>,
}

impl Surroundings {
    /// Nothing but the map is known.
    pub(super) fn new(map: OccupancyGrid, body_radius_m: f64, range_m: f64) -> Self {
        Surroundings { map, body_radius_m, range_m, ends_m: Vec::new(), seen: BTreeMap::new() }
    }

    /// Takes a reading, made at an estimated pose.
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

    /// Notes that the robot runs into something ahead.
    pub(super) fn bump(&mut self, pose: Pose, time_s: f64) {
        for bearing_rad in [-0.5, -0.25, 0.0, 0.25, 0.5_f64] {
            let reach_m = self.body_radius_m + 0.5 * self.map.resolution_m;
            let place_m = in_world(pose, [reach_m * bearing_rad.cos(), reach_m * bearing_rad.sin()]);
            self.seen.extend(self.map.cell_at(place_m).map(|cell| (cell, time_s)));
        }
    }

    /// Greatest speed from which half of an acceleration stops the robot before what is straight ahead.
    pub(super) fn speed_limit_m_per_s(&self, speed_m_per_s: f64, acceleration_m_per_s2: f64) -> f64 {
        let limit = |(end_m, is_known): &([f64; 2], bool)| {
            let side_m = self.body_radius_m + BESIDE_M[usize::from(*is_known)];
            if end_m[0] <= 0.0 || end_m[1].abs() >= side_m {
                return f64::INFINITY;
            }
            // The round body's edge, not its middle, meets the point.
            let free_m = end_m[0] - (side_m * side_m - end_m[1] * end_m[1]).sqrt();
            let left_m = free_m - GAP_M[usize::from(*is_known)] - REACTION_S * speed_m_per_s.max(0.0);
            (acceleration_m_per_s2 * left_m.max(0.0)).sqrt()
        };
        self.ends_m.iter().map(limit).fold(f64::INFINITY, f64::min)
    }

    /// Distance of a place from what has been seen that the map does not show; infinite when there is nothing.
    pub(super) fn distance_m(&self, place_m: [f64; 2]) -> f64 {
        let places_m = self.seen.keys().map(|cell| self.map.centre_m(*cell));
        places_m.map(|at_m| (at_m[0] - place_m[0]).hypot(at_m[1] - place_m[1])).fold(f64::INFINITY, f64::min)
    }

    /// The map with what stands there besides, and whether there is anything.
    pub(super) fn map(&self) -> (OccupancyGrid, bool) {
        let mut map = self.map.clone();
        self.seen.keys().for_each(|cell| map.occupy(map.centre_m(*cell)));
        (map, !self.seen.is_empty())
    }

    /// Drops what was seen long ago, and where a beam now goes on beyond.
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
            // A beam without an end has gone as far as the sensor reaches.
            let is_through = near.peek().is_some() && near.all(|beam| beam.distance_m.unwrap_or(range_m) > far_m);
            !is_through && fan.measured_s - *seen_s < MEMORY_S
        });
    }
}

fn in_world(pose: Pose, [forward_m, left_m]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sin_cos();
    [pose.x_m + cos * forward_m - sin * left_m, pose.y_m + sin * forward_m + cos * left_m]
}
