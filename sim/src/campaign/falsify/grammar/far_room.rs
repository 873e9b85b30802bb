//! Puts a second room behind an open door into some scenes drawn at random, and sends the robot there.

use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Draws, rounded},
    scene::Robot,
};

use super::tables::{items, number, table};

/// Probability with which a scene with a route gets a room behind an open door.
const PROBABILITY: f64 = 0.08;

/// Gives some scenes a second room beside the robot's, behind a wall of some centimetres with an open door in it. The route then begins with the way
/// through this door to the middle of the room behind it, as runs are too short for a way that comes last. Such a scene has no other doors and rooms.
pub(super) fn settle(scene: &mut Table, draws: &Draws, [width_m, depth_m]: [f64; 2], robot: &Robot) {
    let mut dice = draws.dice("room behind a door");
    let radius_m = robot.body_radius_m;
    let door_m = 2.0 * radius_m + dice.uniform(0.1, 0.6);
    let has_route = scene.get("route").is_some_and(Value::is_table);
    if !dice.chance(PROBABILITY) || !has_route || door_m + 0.1 > depth_m || 2.0 * radius_m + 0.2 > width_m {
        return;
    }
    let middle_m = dice.uniform(0.5 * door_m + 0.04, depth_m - 0.5 * door_m - 0.04);
    let far_x_m = width_m + dice.uniform(0.03, 0.14);
    let [below_m, above_m] = [0; 2].map(|_| dice.uniform(0.0, 1.5));
    let far_width_m = 2.0 * radius_m + dice.uniform(0.6, 2.5);
    let numbers = |pairs: &[(&str, f64)]| -> Table {
        pairs.iter().map(|(key, value)| ((*key).to_owned(), Value::Float(rounded(*value, 3)))).collect()
    };
    let room = numbers(&[
        ("x_m", far_x_m),
        ("y_m", -below_m),
        ("width_m", far_width_m),
        ("depth_m", depth_m + below_m + above_m),
    ]);
    let jamb = |y_m: f64| Value::Array([width_m, y_m].map(|at_m| Value::Float(rounded(at_m, 4))).to_vec());
    let mut door = Table::new();
    door.insert("from_m".to_owned(), jamb(middle_m - 0.5 * door_m));
    door.insert("to_m".to_owned(), jamb(middle_m + 0.5 * door_m));
    door.insert("open".to_owned(), Value::Boolean(true));
    let building = table(scene, "building");
    building.insert("room".to_owned(), Value::Array(vec![Value::Table(room)]));
    building.insert("door".to_owned(), Value::Array(vec![Value::Table(door)]));
    let route = table(scene, "route");
    let speed_m_per_s = items(route, "waypoint").find_map(|waypoint| number(waypoint, "speed_m_per_s")).unwrap_or(0.3);
    let way = [width_m - radius_m - 0.05, far_x_m + 0.5 * far_width_m]
        .map(|x_m| Value::Table(numbers(&[("x_m", x_m), ("y_m", middle_m), ("speed_m_per_s", speed_m_per_s)])));
    if let Some(Value::Array(waypoints)) = route.get_mut("waypoint") {
        waypoints.splice(0..0, way);
    }
}
