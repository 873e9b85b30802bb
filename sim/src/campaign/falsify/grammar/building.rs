//! Gives the people, landmarks, doors, pictures and lamps of a scene drawn at random positions where such things can be.

use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Dice, Draws, rounded},
    scene::Robot,
};

use super::tables::{items, number, place, table, text};

/// Gives positions to all things in and around the room of a scene drawn at random. Things that only cameras see are removed if the robot has no
/// camera.
pub(super) fn settle(scene: &mut Table, draws: &Draws, room_m: [f64; 2], robot: &Robot) {
    let has_cameras = !robot.cameras().is_empty();
    if !has_cameras {
        ["light", "lamp", "building"].iter().for_each(|key| drop(scene.remove(*key)));
    }
    if robot.range_camera.is_none() {
        scene.remove("landmark");
    }
    for (index, landmark) in items(scene, "landmark").enumerate() {
        let mut dice = draws.dice(&format!("place of landmark {index}"));
        // Most landmarks are placed on walls, the others anywhere in the room.
        let at_m = if dice.chance(0.8) { on_wall(&mut dice, room_m, 0.0).0 } else { inside(&mut dice, room_m, 0.05) };
        place(landmark, at_m);
        let height_m = robot.range_camera.as_ref().map_or(0.5, |camera| camera.height_m);
        landmark
            .insert("height_m".to_owned(), Value::Float(rounded((height_m + dice.uniform(-0.12, 0.12)).max(0.02), 3)));
    }
    // People walk about furniture, as the robot does.
    let obstacles = Obstacles::of(scene, room_m, 0.0);
    for (index, person) in items(scene, "person").enumerate() {
        let mut dice = draws.dice(&format!("ways of person {index}"));
        let margin_m = number(person, "radius_m").unwrap_or(0.25) + 0.02;
        let count = person.get("waypoints_m").and_then(Value::as_array).map_or(1, Vec::len);
        let (mut ways, mut from_m) = (Vec::with_capacity(count), None);
        for _ in 0..count {
            let at_m = obstacles.free_place(&mut dice, margin_m, from_m);
            ways.push(pair(at_m));
            from_m = Some(at_m);
        }
        person.insert("waypoints_m".to_owned(), Value::Array(ways));
    }
    if has_cameras {
        settle_light(scene, draws, room_m, robot);
    }
    if let Some(Value::Table(building)) = scene.get_mut("building") {
        settle_walls(building, draws, room_m);
    }
    settle_askew(scene);
}

/// Declares a bound on how far furniture along the walls stands askew. The bound covers the angle that the scene states for each piece and the random
/// error that each seed adds to it.
fn settle_askew(scene: &mut Table) {
    let building = scene.get("building").and_then(Value::as_table);
    let drawn_deg = building.and_then(|building| number(building, "furniture_tolerance_deg")).unwrap_or(0.0);
    let turn_deg = |piece: &mut Table| {
        let stated_deg = number(piece, "rotation_deg").unwrap_or(0.0);
        ((stated_deg + 45.0).rem_euclid(90.0) - 45.0).abs()
    };
    let stands_deg = items(scene, "furniture").map(turn_deg).filter(|turn_deg| *turn_deg <= 5.0);
    // Without furniture along the walls no bound on the angle of furniture has to be declared.
    let Some(most_deg) = stands_deg.reduce(f64::max).map(|turn_deg| rounded(turn_deg + drawn_deg + 0.0005, 3)) else {
        return;
    };
    let Some(Value::Table(localizer)) = scene.get_mut("localizer") else { return };
    let methods = localizer.get("methods").and_then(Value::as_array).into_iter().flatten();
    if !methods.filter_map(Value::as_str).any(|method| method == "wall_directions") || most_deg < 0.001 {
        return;
    }
    let setup = table(localizer, "wall_directions");
    if number(setup, "askew_deg").unwrap_or(0.0) < most_deg {
        setup.insert("askew_deg".to_owned(), Value::Float(most_deg));
    }
}

/// Gives doors and pictures places on the walls of the robot's room.
fn settle_walls(building: &mut Table, draws: &Draws, room_m: [f64; 2]) {
    let ceiling_m = number(building, "ceiling_height_m").unwrap_or(2.6);
    let has_rooms = items(building, "room").count() > 0;
    for (list, longest_m) in [("door", 1.1), ("picture", 1.5)] {
        for (index, thing) in items(building, list).enumerate() {
            let mut dice = draws.dice(&format!("place of {list} {index}"));
            let length_m = dice.uniform(0.3, longest_m);
            let (from_m, heading_deg) = on_wall(&mut dice, room_m, length_m);
            let (sin, cos) = (heading_deg + 90.0).to_radians().sin_cos();
            thing.insert(
                "from_m".to_owned(),
                pair([from_m[0] - 0.5 * length_m * cos, from_m[1] - 0.5 * length_m * sin]),
            );
            thing.insert("to_m".to_owned(), pair([from_m[0] + 0.5 * length_m * cos, from_m[1] + 0.5 * length_m * sin]));
            if !has_rooms {
                thing.remove("open");
            }
            // No picture of a random scene is a chessboard: its proportions would have to be those of the pattern, and only scenes for calibration
            // need one.
            thing.remove("chessboard");
            let bottom_m = number(thing, "bottom_m").unwrap_or(1.2);
            let height_m = number(thing, "height_m").unwrap_or(0.6).min(ceiling_m - bottom_m - 0.01);
            if list == "picture" {
                thing.insert("height_m".to_owned(), Value::Float(rounded(height_m, 3)));
            }
        }
    }
    for dot in items(building, "dot") {
        dot.remove("height_m");
    }
}

/// Places lamps below the ceiling and windows in walls. Where a drawn scene states the brightness of the light by two keys that exclude each other,
/// one of them is removed.
fn settle_light(scene: &mut Table, draws: &Draws, room_m: [f64; 2], robot: &Robot) {
    if let Some(Value::Table(light)) = scene.get_mut("light") {
        let is_twice =
            light.contains_key("illuminance_at_floor_lux") && light.contains_key("illuminance_at_camera_lux");
        if is_twice || robot.forward_camera.is_none() {
            light.remove("illuminance_at_camera_lux");
        }
    }
    let smallest_m = room_m[0].min(room_m[1]);
    for (index, lamp) in items(scene, "lamp").enumerate() {
        let mut dice = draws.dice(&format!("place of lamp {index}"));
        if lamp.contains_key("lumens") {
            lamp.remove("illuminance_at_floor_lux");
        }
        lamp.remove("height_m");
        if text(lamp, "kind").as_deref() == Some("window") {
            let width_m = dice.uniform(0.3, 0.8 * smallest_m);
            let (at_m, heading_deg) = on_wall(&mut dice, room_m, width_m);
            place(lamp, at_m);
            lamp.insert("heading_deg".to_owned(), Value::Float(heading_deg));
            lamp.insert("height_m".to_owned(), Value::Float(1.2));
            lamp.insert("size_m".to_owned(), pair([width_m, dice.uniform(0.3, 1.2)]));
        } else {
            place(lamp, inside(&mut dice, room_m, 0.2));
        }
    }
}

/// The room, the radius of a body that moves in it, and the obstacles to be kept clear of: a circle around each piece of furniture.
pub(super) struct Obstacles {
    room_m: [f64; 2],
    body_radius_m: f64,
    circles: Vec<([f64; 2], f64)>,
}

impl Obstacles {
    /// Collects the furniture that `scene` puts into the room.
    pub(super) fn of(scene: &mut Table, room_m: [f64; 2], body_radius_m: f64) -> Obstacles {
        let circle = |furniture: &mut Table| {
            let side = |index: usize| furniture.get("size_m")?.as_array()?.get(index)?.as_float();
            let reach_m = side(0)?.hypot(side(1)?) / 2.0;
            Some(([number(furniture, "x_m")?, number(furniture, "y_m")?], reach_m))
        };
        Obstacles { room_m, body_radius_m, circles: items(scene, "furniture").filter_map(circle).collect() }
    }

    /// Draws a position of the body with `margin_m` between it and every obstacle, also along the straight path from `from_m`. If no such
    /// position is found, the last one tried is returned: the scene is then refused, or the robot bumps into something.
    pub(super) fn free_place(&self, dice: &mut Dice, margin_m: f64, from_m: Option<[f64; 2]>) -> [f64; 2] {
        /// Number of positions of the robot to try: in rooms half full of furniture nine in ten positions are not free.
        const TRIES: usize = 60;
        let keep_m = self.body_radius_m + margin_m;
        let mut at_m = inside(dice, self.room_m, keep_m);
        for _ in 0..TRIES {
            let is_clear = |(centre_m, reach_m): &([f64; 2], f64)| {
                distance_m(from_m.unwrap_or(at_m), at_m, *centre_m) >= keep_m + reach_m
            };
            if self.circles.iter().all(is_clear) {
                break;
            }
            at_m = inside(dice, self.room_m, keep_m);
        }
        at_m
    }
}

/// Returns the least distance of a point from a line segment.
fn distance_m(from_m: [f64; 2], to_m: [f64; 2], point_m: [f64; 2]) -> f64 {
    let way = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
    let off = [point_m[0] - from_m[0], point_m[1] - from_m[1]];
    let length2 = way[0] * way[0] + way[1] * way[1];
    let share = if length2 > 0.0 { ((off[0] * way[0] + off[1] * way[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (off[0] - share * way[0]).hypot(off[1] - share * way[1])
}

/// Draws a position in the room, at least `margin_m` away from its walls where the room is wide enough.
pub(super) fn inside(dice: &mut Dice, room_m: [f64; 2], margin_m: f64) -> [f64; 2] {
    room_m.map(|extent_m| {
        let margin_m = margin_m.min(extent_m / 2.0);
        dice.uniform(margin_m, extent_m - margin_m)
    })
}

/// Draws a position on one of the room's walls for a thing of the given length, such as a door. Returns the middle of the thing and the direction in
/// which the wall faces.
fn on_wall(dice: &mut Dice, [width_m, depth_m]: [f64; 2], length_m: f64) -> ([f64; 2], f64) {
    let mut along = |extent_m: f64| {
        let half_m = (length_m / 2.0).min(extent_m / 2.0);
        dice.uniform(half_m, extent_m - half_m)
    };
    let (x_m, y_m) = (along(width_m), along(depth_m));
    let walls = [([x_m, 0.0], 90.0), ([width_m, y_m], 180.0), ([x_m, depth_m], -90.0), ([0.0, y_m], 0.0)];
    *dice.choose(&walls)
}

fn pair(at_m: [f64; 2]) -> Value {
    Value::Array(at_m.map(|value_m| Value::Float(rounded(value_m, 4))).to_vec())
}
