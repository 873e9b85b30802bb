//! Gives the robot of a scene drawn at random a start, goals and waypoints that are clear of walls and furniture, and speeds that the robot can
//! reach.

use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Dice, Draws, rounded},
    scene::Robot,
};

use super::{
    building::Obstacles,
    car,
    tables::{items, number, place, table},
};

/// The kinds of drive, of which a scene has exactly one: the scene keys of each kind, and the probability of the kind.
const DRIVES: [(&[&str], f64); 4] =
    [(&["route"], 0.8), (&["errand", "navigation"], 0.1), (&["station"], 0.07), (&["station_spread"], 0.03)];

/// Keeps one kind of drive in the scene, and gives its goals, waypoints or stations positions that the robot can reach.
pub(super) fn settle(scene: &mut Table, draws: &Draws, room_m: [f64; 2], robot: &Robot) {
    let mut dice = draws.dice("drive");
    let chosen = choose(&mut dice);
    for (keys, _) in DRIVES {
        if keys != chosen {
            keys.iter().for_each(|key| drop(scene.remove(*key)));
        }
    }
    let obstacles = Obstacles::of(scene, room_m, robot.body_radius_m);
    let has_goals =
        scene.get("navigation").and_then(|one| one.get("random_goals")?.as_integer()).is_some_and(|n| n > 0);
    let has_errands = scene.contains_key("errand") || (chosen.contains(&"navigation") && has_goals);
    let start = table(scene, "start");
    if !has_errands {
        // Only on errands the robot plans its way from wherever it is.
        start.remove("anywhere");
    }
    let tolerance_m = number(start, "tolerance_m").unwrap_or(0.01);
    // Each seed puts the robot at a random start within the tolerance. The tolerance is therefore limited, so that every possible start lies in the
    // room.
    let most_m = 0.4 * (room_m[0].min(room_m[1]) / 2.0 - robot.body_radius_m).max(0.0);
    let tolerance_m = rounded(tolerance_m.min(most_m), 3);
    start.insert("tolerance_m".to_owned(), Value::Float(tolerance_m));
    let start_m = obstacles.free_place(&mut dice, tolerance_m + 0.01, None);
    place(start, start_m);
    keep_people_off(scene, start_m, robot.body_radius_m);
    if let Some(Value::Table(route)) = scene.get_mut("route") {
        settle_route(route, &mut dice, &obstacles, start_m, robot);
    }
    if let Some(circle) = robot.base.drivetrain().turning_circle() {
        car::settle_route(scene, draws, &obstacles, circle);
    }
    for errand in items(scene, "errand") {
        place(errand, obstacles.free_place(&mut dice, 0.1, None));
    }
    for station in items(scene, "station") {
        let tolerance_m = number(station, "tolerance_m").unwrap_or(0.0).min(most_m);
        if station.contains_key("tolerance_m") {
            station.insert("tolerance_m".to_owned(), Value::Float(rounded(tolerance_m, 3)));
        }
        place(station, obstacles.free_place(&mut dice, tolerance_m + 0.01, None));
    }
}

/// Removes people who begin where the robot is put down, as the physics would push them through the robot.
fn keep_people_off(scene: &mut Table, start_m: [f64; 2], body_radius_m: f64) {
    let Some(Value::Array(people)) = scene.get_mut("person") else { return };
    people.retain(|person| {
        let Some(person) = person.as_table() else { return false };
        let first = person.get("waypoints_m").and_then(Value::as_array).and_then(|ways| ways.first()?.as_array());
        let at_m = |axis: usize| first.and_then(|place| place.get(axis)?.as_float());
        let keep_m = number(person, "radius_m").unwrap_or(0.25) + body_radius_m;
        let away_m = at_m(0).zip(at_m(1)).map(|(x_m, y_m)| (x_m - start_m[0]).hypot(y_m - start_m[1]));
        away_m.is_some_and(|away_m| away_m >= keep_m)
    });
}

fn settle_route(route: &mut Table, dice: &mut Dice, obstacles: &Obstacles, start_m: [f64; 2], robot: &Robot) {
    let mut at_m = start_m;
    for waypoint in items(route, "waypoint") {
        // The straight way from one waypoint to the next keeps clear of furniture, as it would in a route that a person lays out.
        at_m = obstacles.free_place(dice, 0.02, Some(at_m));
        place(waypoint, at_m);
        let speed_m_per_s = number(waypoint, "speed_m_per_s").unwrap_or(0.4).min(robot.max_speed_m_per_s);
        waypoint.insert("speed_m_per_s".to_owned(), Value::Float(rounded(speed_m_per_s, 3)));
    }
}

/// Whether the kind of drive that [`settle`] chooses is a route.
pub(super) fn has_route(draws: &Draws) -> bool {
    choose(&mut draws.dice("drive")).contains(&"route")
}

fn choose(dice: &mut Dice) -> &'static [&'static str] {
    let mut left = dice.uniform(0.0, 1.0);
    for (keys, share) in DRIVES {
        left -= share;
        if left < 0.0 {
            return keys;
        }
    }
    DRIVES[0].0
}
