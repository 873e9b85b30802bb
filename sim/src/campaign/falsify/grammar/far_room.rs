//! Puts a second room behind an open door into some scenes drawn at random, and sends the robot there.

use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Dice, Draws, rounded},
    scene::Robot,
};

use super::tables::{items, number, table};

/// Probability with which a scene with a route gets a room behind an open door.
const PROBABILITY: f64 = 0.08;

/// Probability with which that room is a polygon and not a rectangle.
const POLYGONAL: f64 = 0.4;

/// Gives some scenes a second room beside the robot's, behind a wall of some centimetres with an open door in it. The route then begins with the way
/// through this door to the middle of the room behind it, as runs are too short for a way that comes last. Such a scene has no other doors and rooms.
pub(super) fn settle(scene: &mut Table, draws: &Draws, [width_m, depth_m]: [f64; 2], robot: &Robot) {
    let mut dice = draws.dice("room behind a door");
    let radius_m = robot.body_radius_m;
    let door_m = 2.0 * radius_m + dice.uniform(0.1, 0.6);
    let has_route = scene.get("route").is_some_and(Value::is_table);
    // The way through the door would have corners that a car cannot take.
    let is_car = robot.base.drivetrain().turning_circle().is_some();
    if !dice.chance(PROBABILITY) || !has_route || is_car || door_m + 0.1 > depth_m || 2.0 * radius_m + 0.2 > width_m {
        return;
    }
    let middle_m = dice.uniform(0.5 * door_m + 0.04, depth_m - 0.5 * door_m - 0.04);
    let far_x_m = width_m + dice.uniform(0.03, 0.14);
    let [below_m, above_m] = [0; 2].map(|_| dice.uniform(0.0, 1.5));
    let far_width_m = 2.0 * radius_m + dice.uniform(0.6, 2.5);
    let numbers = |pairs: &[(&str, f64)]| -> Table {
        pairs.iter().map(|(key, value)| ((*key).to_owned(), Value::Float(rounded(*value, 3)))).collect()
    };
    let mut shape = draws.dice("shape of the room behind a door");
    let room = if shape.chance(POLYGONAL) {
        let corners_m = polygon(&mut shape, [far_x_m, -below_m], [far_width_m, depth_m + below_m + above_m]);
        let place = |corner_m: [f64; 2]| Value::Array(corner_m.map(|at_m| Value::Float(rounded(at_m, 4))).to_vec());
        let corners = corners_m.into_iter().map(place).collect();
        std::iter::once(("corners_m".to_owned(), Value::Array(corners))).collect()
    } else {
        numbers(&[
            ("x_m", far_x_m),
            ("y_m", -below_m),
            ("width_m", far_width_m),
            ("depth_m", depth_m + below_m + above_m),
        ])
    };
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

/// Draws a polygon that holds a rectangle and has the whole of its left side: with a slanted wall at the right, or the bend of two, and with an arm
/// at the upper end in half of all cases. The corners go round either way.
fn polygon(dice: &mut Dice, [x_m, y_m]: [f64; 2], [width_m, depth_m]: [f64; 2]) -> Vec<[f64; 2]> {
    let [right_m, top_m] = [x_m + width_m, y_m + depth_m];
    let mut out_m = || right_m + dice.uniform(0.0, 1.0);
    let mut corners_m = vec![[x_m, y_m], [out_m(), y_m], [out_m(), y_m + 0.6 * depth_m], [out_m(), top_m]];
    if dice.chance(0.5) {
        let inner_m = x_m + width_m * dice.uniform(0.3, 0.9);
        let end_m = top_m + dice.uniform(0.3, 2.0);
        corners_m.extend([[inner_m, top_m], [inner_m, end_m], [x_m, end_m]]);
    } else {
        corners_m.push([x_m, top_m]);
    }
    if dice.chance(0.5) {
        corners_m.reverse();
    }
    corners_m
}
