//! The path of a route: the polyline through its waypoints, segment by segment; endless if the route repeats.

use crate::scene::{Route, Waypoint};

use super::ARRIVED_M;

/// Corner angle beyond which the robot always turns in place, whatever the route asks for: it cannot steer to a look-ahead point that lies
/// behind it.
const SHARPEST_CURVE_RAD: f64 = 2.0;

/// Distance below which two waypoints count as one position.
const SAME_PLACE_M: f64 = 1e-6;

/// The polyline that a robot on a route is to follow.
#[derive(Clone, Debug)]
pub(super) struct Path {
    origin_m: [f64; 2],
    waypoints: Vec<Waypoint>,
    repeat: bool,
}

/// A straight segment of the path, from one waypoint to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    from_m: [f64; 2],
    along: [f64; 2],
    /// Length of the path segment; 0 if both ends coincide.
    pub(super) length_m: f64,
}

impl Path {
    /// The path along a route, beginning at the place where the robot stands. A route that repeats, but whose round trip leads nowhere, is
    /// followed only once.
    pub(super) fn new(origin_m: [f64; 2], route: &Route) -> Self {
        Path {
            origin_m,
            waypoints: route.waypoints.clone(),
            repeat: route.repeat && round_m(&route.waypoints) > ARRIVED_M,
        }
    }

    /// The waypoint at the end of a segment, or `None` if the path has no such segment.
    pub(super) fn waypoint(&self, segment_idx: usize) -> Option<&Waypoint> {
        let n_waypoints = self.waypoints.len();
        if segment_idx < n_waypoints {
            return self.waypoints.get(segment_idx);
        }
        if self.repeat && n_waypoints > 0 { self.waypoints.get(segment_idx % n_waypoints) } else { None }
    }

    /// The segment of the given index, or `None` beyond the path's last segment.
    pub(super) fn segment(&self, segment_idx: usize) -> Option<Segment> {
        let to = self.waypoint(segment_idx)?;
        let from_m = match segment_idx.checked_sub(1) {
            Some(before_idx) => {
                self.waypoint(before_idx).map_or(self.origin_m, |waypoint| [waypoint.x_m, waypoint.y_m])
            }
            None => self.origin_m,
        };
        let (x_m, y_m) = (to.x_m - from_m[0], to.y_m - from_m[1]);
        let length_m = x_m.hypot(y_m);
        if length_m < SAME_PLACE_M {
            return Some(Segment { from_m, along: [1.0, 0.0], length_m: 0.0 });
        }
        Some(Segment { from_m, along: [x_m / length_m, y_m / length_m], length_m })
    }

    /// Whether the robot comes to a stand at the end of a path segment.
    pub(super) fn stops_after(&self, segment_idx: usize) -> bool {
        let Some(waypoint) = self.waypoint(segment_idx) else { return true };
        let stands = waypoint.turn_in_place || waypoint.pause_s > 0.0;
        stands || self.corner_rad(segment_idx).is_none_or(|corner_rad| corner_rad > SHARPEST_CURVE_RAD)
    }

    /// Angle by which the path turns at the end of a segment, in `[0, π]`, or `None` if the path ends there.
    pub(super) fn corner_rad(&self, segment_idx: usize) -> Option<f64> {
        let (before, after) = (self.segment(segment_idx)?, self.segment(segment_idx + 1)?);
        if before.length_m == 0.0 || after.length_m == 0.0 {
            return Some(0.0);
        }
        let cross = before.along[0] * after.along[1] - before.along[1] * after.along[0];
        let dot = before.along[0] * after.along[0] + before.along[1] * after.along[1];
        Some(cross.abs().atan2(dot))
    }

    /// The look-ahead point of the path: the point at a given distance ahead of a position on a segment. Beyond a stop it is taken on the
    /// segment's straight extension.
    pub(super) fn ahead_m(&self, mut segment_idx: usize, mut along_m: f64, ahead_m: f64) -> [f64; 2] {
        along_m += ahead_m;
        let Some(mut segment) = self.segment(segment_idx) else { return self.origin_m };
        while along_m > segment.length_m && !self.stops_after(segment_idx) {
            let Some(next) = self.segment(segment_idx + 1) else { break };
            along_m -= segment.length_m;
            segment_idx += 1;
            segment = next;
        }
        segment.point(along_m)
    }
}

/// Length of the round trip through all waypoints and back to the first.
fn round_m(waypoints: &[Waypoint]) -> f64 {
    let next = waypoints.iter().cycle().skip(1);
    waypoints.iter().zip(next).map(|(here, next)| (next.x_m - here.x_m).hypot(next.y_m - here.y_m)).sum()
}

impl Segment {
    /// The point at a distance from the path segment's start; it may lie beyond the segment's ends.
    pub(super) fn point(&self, along_m: f64) -> [f64; 2] {
        [self.from_m[0] + along_m * self.along[0], self.from_m[1] + along_m * self.along[1]]
    }

    /// Distance from the segment's start to the foot of the perpendicular from a point onto the endless line through the segment.
    pub(super) fn foot_m(&self, place_m: [f64; 2]) -> f64 {
        (place_m[0] - self.from_m[0]) * self.along[0] + (place_m[1] - self.from_m[1]) * self.along[1]
    }

    /// Distance of a point from the path segment.
    pub(super) fn distance_m(&self, place_m: [f64; 2]) -> f64 {
        let [x_m, y_m] = self.point(self.foot_m(place_m).clamp(0.0, self.length_m));
        (place_m[0] - x_m).hypot(place_m[1] - y_m)
    }
}
