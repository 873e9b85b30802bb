//! The circle that bounds how sharply a base turns that cannot turn in place, and the routes that such a base can follow.

use std::f64::consts::{FRAC_PI_2, PI};

use localizer::Pose;

use crate::scene::Route;

/// Greatest angle between the heading at the start and the direction to the first waypoint: with a greater one the robot faces away.
const MOST_ASIDE_RAD: f64 = FRAC_PI_2;

/// Sharpest corner of a route: a robot that drives no closer circle leaves a sharper one by far.
const SHARPEST_CORNER_RAD: f64 = 2.0;

/// Radius of the circles on which paths are planned, over that of the smallest circle: what is left lets the robot steer back to a path beside it.
const PLANNED_OVER_SMALLEST: f64 = 1.1;

/// The smallest circle that the middle of the axle can drive, to either side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningCircle {
    /// Radius of the circle.
    pub(crate) radius_m: f64,
    /// Time in which the base steers from the circle to one side to that to the other.
    pub(crate) lock_to_lock_s: f64,
}

/// A waypoint of a route that a robot with a turning circle cannot drive to as the route asks, and why.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OffLimits {
    /// Index of the waypoint in the route.
    pub(crate) waypoint_idx: usize,
    /// Key of the waypoint that asks for what is impossible.
    pub(crate) key: &'static str,
    /// What is wrong, and what was expected.
    pub(crate) expected: String,
}

impl TurningCircle {
    /// Radius of the smallest circle on which paths are planned.
    pub(crate) fn planned_radius_m(&self) -> f64 {
        PLANNED_OVER_SMALLEST * self.radius_m
    }

    /// The first waypoint of a route that a robot cannot drive to as the route asks when it starts at a pose.
    ///
    /// At a corner of angle θ an arc of radius R touches both legs at a distance R·tan(θ/2) from the waypoint. These distances at both ends of a leg
    /// must fit on it; otherwise the robot comes out of a corner too late for the next one.
    pub(crate) fn off_limits(&self, start: Pose, route: &Route) -> Option<OffLimits> {
        let places_m: Vec<[f64; 2]> = route.waypoints.iter().map(|waypoint| [waypoint.x_m, waypoint.y_m]).collect();
        let refused = |waypoint_idx, key, expected| Some(OffLimits { waypoint_idx, key, expected });
        for (idx, waypoint) in route.waypoints.iter().enumerate() {
            if waypoint.turn_in_place {
                let expected = "the base cannot turn in place, expected false, or another kind of base".to_owned();
                return refused(idx, "turn_in_place", expected);
            }
        }
        let aside_rad = self.aside_rad(start, *places_m.first()?);
        if aside_rad.is_none_or(|aside_rad| aside_rad > MOST_ASIDE_RAD) {
            let expected = format!(
                "the start faces away from here, or is too near and aside for a turning circle of radius {:.2} m, \
                 expected a place ahead of the start",
                self.radius_m
            );
            return refused(0, "x_m", expected);
        }
        // The place before the first waypoint is the start, and on a route that repeats the first waypoint follows the last.
        let mut stops_m = vec![[start.x_m, start.y_m]];
        stops_m.extend(&places_m);
        let n_places = places_m.len();
        if route.repeat && n_places > 1 {
            stops_m.extend([places_m[0], places_m[1], places_m[2 % n_places]]);
        }
        let mut before_m = 0.0;
        for (idx, three_m) in stops_m.windows(3).enumerate() {
            let waypoint_idx = idx % n_places;
            let (leg_m, next_m) = (distance_m(three_m[0], three_m[1]), distance_m(three_m[1], three_m[2]));
            let corner_rad = corner_rad([three_m[0], three_m[1], three_m[2]]);
            let cut_m = self.radius_m * (0.5 * corner_rad).tan();
            if corner_rad > SHARPEST_CORNER_RAD {
                let expected = format!(
                    "the route turns here by {:.0}°, expected {:.0}° at most for a base that cannot turn in place",
                    corner_rad.to_degrees(),
                    SHARPEST_CORNER_RAD.to_degrees()
                );
                return refused(waypoint_idx, "x_m", expected);
            }
            if before_m + cut_m > leg_m || cut_m > next_m {
                let expected = format!(
                    "this corner takes {cut_m:.2} m of the legs before and after it with a turning circle of radius \
                     {:.2} m, expected longer legs or a flatter corner",
                    self.radius_m
                );
                return refused(waypoint_idx, "x_m", expected);
            }
            before_m = cut_m;
        }
        None
    }

    /// Angle between the heading of a pose and the direction of a place, in `[0, π]`; `None` if the place lies within the turning circle on its side,
    /// where an arc ahead does not lead.
    fn aside_rad(&self, start: Pose, place_m: [f64; 2]) -> Option<f64> {
        let (x_m, y_m) = (place_m[0] - start.x_m, place_m[1] - start.y_m);
        let (sin, cos) = start.heading_rad.sin_cos();
        let (forward_m, aside_m) = (cos * x_m + sin * y_m, (cos * y_m - sin * x_m).abs());
        let is_within = forward_m.hypot(aside_m - self.radius_m) < self.radius_m;
        (!is_within).then(|| aside_m.atan2(forward_m))
    }
}

/// Angle in `[0, π]` by which a path turns at the middle of three places; 0 where two of them are one.
fn corner_rad([from_m, at_m, to_m]: [[f64; 2]; 3]) -> f64 {
    let legs = [[at_m[0] - from_m[0], at_m[1] - from_m[1]], [to_m[0] - at_m[0], to_m[1] - at_m[1]]];
    let cross = legs[0][0] * legs[1][1] - legs[0][1] * legs[1][0];
    let dot = legs[0][0] * legs[1][0] + legs[0][1] * legs[1][1];
    cross.abs().atan2(dot).min(PI)
}

fn distance_m(from_m: [f64; 2], to_m: [f64; 2]) -> f64 {
    (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1])
}
