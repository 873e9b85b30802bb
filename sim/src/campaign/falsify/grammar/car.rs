//! Puts the robot of some scenes drawn at random on the base of a car, and lays its route such that a car can follow it.

use localizer::Pose;
use toml::{Table, Value};

use crate::{
    base::TurningCircle,
    campaign::falsify::dice::{Draws, rounded},
    scene::{Robot, Route, SteeringEncoder},
};

use super::{
    building::Obstacles,
    tables::{meaning, number, place, table},
};

/// Probability with which the robot of a scene with a route is a car, where the room is large enough.
const PROBABILITY: f64 = 0.12;

/// Probability with which a car has a steering encoder.
const ENCODER_PROBABILITY: f64 = 0.7;

/// Room that a car needs besides its body to drive at all.
const FREE_M: f64 = 1.5;

/// Number of places that are tried for a waypoint before the route ends before it.
const TRIES: usize = 40;

/// Makes the robot a car, or leaves it on the wheels of a differential drive. A car's wheelbase is made long enough for the turn's centre to be
/// beside its wheels, and its body large enough to cover them.
pub(super) fn settle(robot: &mut Table, draws: &Draws, room_m: [f64; 2], has_route: bool) {
    let shape = meaning::<Robot>(robot).and_then(|robot| has_route.then_some(robot.base));
    let built = shape.filter(|_| draws.dice("car").chance(PROBABILITY)).map(|base| {
        let car = &base.ackermann;
        let half_m = [base.track_m, car.front_track_m.unwrap_or(base.track_m)].map(|track_m| 0.5 * track_m);
        let least_m = 1.3 * half_m[0].max(half_m[1]) * car.max_steering_deg.to_radians().tan();
        let wheelbase_m = rounded(car.wheelbase_m.max(least_m) + 0.001, 3);
        (wheelbase_m, rounded(wheelbase_m.hypot(half_m[1]) + 0.01, 3))
    });
    let fits = |(_, body_m): &(f64, f64)| room_m[0].min(room_m[1]) > 2.0 * body_m + FREE_M;
    let Some((wheelbase_m, body_m)) = built.filter(fits) else {
        robot.insert("steering_encoder".to_owned(), Value::Boolean(false));
        let base = table(robot, "base");
        base.remove("ackermann");
        if base.contains_key("kind") {
            base.insert("kind".to_owned(), Value::String("differential".to_owned()));
        }
        return;
    };
    robot.insert("body_radius_m".to_owned(), Value::Float(body_m));
    let base = table(robot, "base");
    base.insert("kind".to_owned(), Value::String("ackermann".to_owned()));
    table(base, "ackermann").insert("wheelbase_m".to_owned(), Value::Float(wheelbase_m));
    settle_encoder(robot, draws);
}

/// Fits a steering encoder to some cars, and declares bounds on their steering that such a car keeps: its own steering rate, and slip that is at
/// least ten times the default one, which was measured on one car.
fn settle_encoder(robot: &mut Table, draws: &Draws) {
    let mut dice = draws.dice("steering encoder");
    let rate_deg_per_s = meaning::<Robot>(robot).map(|robot| robot.base.ackermann.steering_rate_deg_per_s);
    let Some(rate_deg_per_s) = rate_deg_per_s.filter(|_| dice.chance(ENCODER_PROBABILITY)) else {
        robot.insert("steering_encoder".to_owned(), Value::Boolean(false));
        return;
    };
    let usual = SteeringEncoder::default();
    let encoder = table(robot, "steering_encoder");
    let mut state = |key: &str, value: f64| encoder.insert(key.to_owned(), Value::Float(rounded(value, 3)));
    state("rate_deg_per_s", rate_deg_per_s * dice.uniform(1.0, 2.0));
    state("slip_share", usual.slip_share * dice.log_uniform(10.0, 60.0));
    state("slip_deg_per_m", usual.slip_deg_per_m * dice.log_uniform(10.0, 100.0));
    state("slip_floor_deg", usual.slip_floor_deg * dice.log_uniform(10.0, 100.0));
}

/// Turns a car at its start towards its first waypoint, and moves the waypoints to places to which it can drive. The route ends where no such place
/// is found.
pub(super) fn settle_route(scene: &mut Table, draws: &Draws, obstacles: &Obstacles, circle: TurningCircle) {
    let mut dice = draws.dice("route of a car");
    let heading_deg = rounded(dice.uniform(-180.0, 180.0), 4);
    let start = table(scene, "start");
    start.insert("heading_deg".to_owned(), Value::Float(heading_deg));
    let at_m = ["x_m", "y_m"].map(|key| number(start, key).unwrap_or(0.0));
    let pose = Pose { x_m: at_m[0], y_m: at_m[1], heading_rad: heading_deg.to_radians() };
    let route = table(scene, "route");
    let Some(Value::Array(drawn)) = route.remove("waypoint") else { return };
    let mut laid = Vec::new();
    let can_follow =
        |route: &Table| meaning::<Route>(route).is_some_and(|route| circle.off_limits(pose, &route).is_none());
    let once = |route: &Table, waypoints: &[Value]| {
        let mut route = route.clone();
        route.remove("repeat");
        route.insert("waypoint".to_owned(), Value::Array(waypoints.to_vec()));
        route
    };
    let mut from_m = at_m;
    for waypoint in drawn {
        let Value::Table(mut waypoint) = waypoint else { continue };
        waypoint.remove("turn_in_place");
        let found = (0..TRIES).find_map(|_| {
            let to_m = obstacles.free_place(&mut dice, 0.1, Some(from_m));
            place(&mut waypoint, to_m);
            let mut all = laid.clone();
            all.push(Value::Table(waypoint.clone()));
            can_follow(&once(route, &all)).then_some((all, to_m))
        });
        let Some((all, to_m)) = found else { break };
        (laid, from_m) = (all, to_m);
    }
    route.insert("waypoint".to_owned(), Value::Array(laid));
    if !can_follow(route) {
        route.remove("repeat");
    }
}
