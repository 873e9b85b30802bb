//! Makes the parts of a scene drawn at random fit together, which a schema cannot demand. A scene that still does not fit is refused and drawn again.

use toml::{Table, Value};

use crate::{
    campaign::falsify::dice::{Draws, rounded},
    scene::{MethodName, Robot},
};

use super::{
    building, ceiling, drive, far_room, robot,
    tables::{items, number, table, text},
};

/// Changes a drawn scene so that it can be simulated.
pub(super) fn settle(scene: &mut Table, draws: &Draws, room_m: [f64; 2], has_cameras: bool) {
    let room = [("width_m", room_m[0]), ("depth_m", room_m[1])];
    scene.insert(
        "room".to_owned(),
        Value::Table(room.map(|(key, m)| (key.to_owned(), Value::Float(m))).into_iter().collect()),
    );
    // Runs with cameras are slow to simulate, so that their scenes have a shorter duration.
    let most_s = if has_cameras { 8.0 } else { 20.0 };
    let duration_s = rounded(draws.dice("duration_s").uniform(most_s / 4.0, most_s), 3);
    scene.insert("duration_s".to_owned(), Value::Float(duration_s));
    let fitted = robot::settle(scene, draws, room_m, has_cameras);
    methods(scene, draws, &fitted);
    building::settle(scene, draws, room_m, &fitted);
    drive::settle(scene, draws, room_m, &fitted);
    far_room::settle(scene, draws, room_m, &fitted);
    ceiling::settle(scene, draws, room_m, &fitted);
    floor(scene, draws, room_m);
    events(scene, draws, duration_s);
}

/// Chooses localization methods for which the robot has the devices. Each of them is kept with a probability of 0.9, so that most methods work
/// together: then an error of one method misleads the others.
fn methods(scene: &mut Table, draws: &Draws, robot: &Robot) {
    let mut dice = draws.dice("methods that are used");
    // Pictures of landmarks have to be exposed at once.
    let rolls = robot.forward_camera.as_ref().is_some_and(|camera| camera.lens.row_time_s > 0.0);
    let is_possible = |method: MethodName| robot.lacks(method).is_none() && !(rolls && robot.shows_landmarks(method));
    let used = MethodName::ALL.iter().copied().filter(|method| is_possible(*method) && dice.chance(0.9));
    let names: Vec<Value> = used.filter_map(|method| Value::try_from(method).ok()).collect();
    let setup = table(scene, "localizer");
    setup.insert("methods".to_owned(), Value::Array(names));
    if robot.gyro.is_none() {
        setup.remove("learns_gyro");
    }
    if robot.forward_camera.is_none() {
        setup.remove("wall_directions");
        setup.remove("wall_bearings");
    }
}

/// Gives each region of the floor, such as a carpet, a position within the room, and a ramp along its edges over which the floor rises gently to the
/// region's height.
fn floor(scene: &mut Table, draws: &Draws, room_m: [f64; 2]) {
    let Some(Value::Table(floor)) = scene.get_mut("floor") else { return };
    for (index, region) in items(floor, "region").enumerate() {
        let mut dice = draws.dice(&format!("place of region {index}"));
        for (key, extent_m) in [("x_m", room_m[0]), ("y_m", room_m[1])] {
            let from_m = dice.uniform(0.0, 0.7 * extent_m);
            let to_m = dice.uniform(from_m + 0.1 * extent_m, extent_m);
            let range_m = [from_m, to_m].map(|m| Value::Float(rounded(m, 3).min(extent_m)));
            region.insert(key.to_owned(), Value::Array(range_m.to_vec()));
        }
        if region.contains_key("rotation_deg") {
            shrink_to_turn(region, room_m);
        }
        // A scene is valid with ramps of a slope of up to 0.5. The slope is 0.1 at most here, as small wheels could not climb more.
        let height_m = number(region, "height_m").unwrap_or(0.0);
        let ramp_m = rounded((10.0 * height_m).max(0.03), 3);
        region.insert("ramp_m".to_owned(), Value::Float(ramp_m));
    }
}

/// Makes a region of the floor so small about its middle that it stays within the room, however it is turned.
fn shrink_to_turn(region: &mut Table, room_m: [f64; 2]) {
    let ranges_m = ["x_m", "y_m"].map(|key| match region.get(key) {
        Some(Value::Array(range_m)) => [0, 1].map(|end| range_m[end].as_float().unwrap_or(0.0)),
        _ => [0.0; 2],
    });
    let middle_m = ranges_m.map(|[from_m, to_m]| 0.5 * (from_m + to_m));
    let half_m = ranges_m.map(|[from_m, to_m]| 0.5 * (to_m - from_m));
    let free_m = [0, 1].map(|axis| middle_m[axis].min(room_m[axis] - middle_m[axis]));
    // A hundredth less, as ends are rounded to millimetres.
    let share = (0.99 * free_m[0].min(free_m[1]) / half_m[0].hypot(half_m[1])).min(1.0);
    for (axis, key) in ["x_m", "y_m"].into_iter().enumerate() {
        let ends_m = [-1.0, 1.0].map(|side| Value::Float(rounded(middle_m[axis] + side * share * half_m[axis], 3)));
        region.insert(key.to_owned(), Value::Array(ends_m.to_vec()));
    }
}

/// Gives each event a time within the run, and lets it name only regions of the floor and lamps that the scene has.
fn events(scene: &mut Table, draws: &Draws, duration_s: f64) {
    let regions: Vec<String> = match scene.get_mut("floor") {
        Some(Value::Table(floor)) => items(floor, "region").filter_map(|region| text(region, "name")).collect(),
        _ => Vec::new(),
    };
    let lamps = lamp_names(scene);
    if let (true, Some(Value::Array(events))) = (lamps.is_empty(), scene.get_mut("event")) {
        events.retain(|event| event.get("lamp").is_none());
    }
    for (index, event) in items(scene, "event").enumerate() {
        let mut dice = draws.dice(&format!("time of event {index}"));
        let lasts_s = number(event, "lasts_s").unwrap_or(0.0).min(0.5 * duration_s);
        if event.contains_key("lasts_s") {
            event.insert("lasts_s".to_owned(), Value::Float(rounded(lasts_s, 3)));
        }
        let at_s = rounded(dice.uniform(0.0, 0.95 * (duration_s - lasts_s)), 3);
        event.insert("at_s".to_owned(), Value::Float(at_s));
        if event.contains_key("region") {
            match regions.is_empty() {
                true => event.remove("region"),
                false => event.insert("region".to_owned(), Value::String(dice.choose(&regions).clone())),
            };
        }
        if event.contains_key("lamp") {
            event.insert("lamp".to_owned(), Value::String(dice.choose(&lamps).clone()));
        }
    }
}

/// Returns the names of the scene's lamps, for events that switch them. If none has a name, the first lamp is given one.
fn lamp_names(scene: &mut Table) -> Vec<String> {
    let names: Vec<String> = items(scene, "lamp").filter_map(|lamp| text(lamp, "name")).collect();
    match items(scene, "lamp").next() {
        Some(first) if names.is_empty() => {
            first.insert("name".to_owned(), Value::String("first".to_owned()));
            vec!["first".to_owned()]
        }
        _ => names,
    }
}
