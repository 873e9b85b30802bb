//! Checks of a scene that a schema cannot express: everything is inside the room and within the run's time, and every name that is used exists.

mod building;
mod cameras;
mod cars;
mod errands;
mod logs;
mod markers;
mod outdoors;
mod rooms;
mod sensors;
mod things;

use std::collections::BTreeSet;

use super::contradiction::Contradiction;
use crate::{
    place::building::GroundPlan,
    scene::{Event, MethodName, Scene, conform::nearest},
};

/// Steepest ramp at the edge of a carpet. Rubber of friction 0.8 holds on this slope, and wheels keep their load.
const GREATEST_SLOPE: f64 = 0.5;

/// All contradictions of `scene` with itself.
pub(super) fn contradictions(scene: &Scene) -> Vec<Contradiction> {
    let mut found = Vec::new();
    rooms::contradictions(scene, &mut found);
    if !found.is_empty() {
        return found;
    }
    drive(scene, &mut found);
    robot_places(scene, &mut found);
    route_legs(scene, &mut found);
    floor_places(scene, &mut found);
    things::contradictions(scene, &mut found);
    methods(scene, &mut found);
    declared_widths(scene, &mut found);
    events(scene, &mut found);
    building::contradictions(scene, &mut found);
    outdoors::contradictions(scene, &mut found);
    cameras::contradictions(scene, &mut found);
    cars::contradictions(scene, &mut found);
    errands::contradictions(scene, &mut found);
    markers::contradictions(scene, &mut found);
    sensors::contradictions(scene, &mut found);
    logs::contradictions(scene, &mut found);
    found.extend(
        scene
            .expect
            .unknown()
            .into_iter()
            .map(|(name, expected)| Contradiction { key: format!("expect.{name}"), expected }),
    );
    found
}

fn drive(scene: &Scene, found: &mut Vec<Contradiction>) {
    let (key, expected) = match (&scene.route, scene.has_errands(), scene.stations.is_empty()) {
        (None, _, true) if scene.station_spread.is_some() => {
            ("station_spread.count", "the room has no place for the robot's body, expected a larger one")
        }
        (None, false, true) if scene.log.is_none() => (
            "route",
            "missing, expected a `[route]` to drive, an `[[errand]]`, or at least one `[[station]]` to stand at",
        ),
        (Some(_), _, false) => {
            ("route", "stands beside `[[station]]`, expected one of the two: a drive, or still poses")
        }
        (Some(_), true, true) => ("route", "stands beside errands, expected one of the two: a given way, or goals"),
        (None, true, false) => {
            ("errand", "stands beside `[[station]]`, expected one of the two: goals, or still poses")
        }
        _ => return,
    };
    found.push(Contradiction { key: key.to_owned(), expected: expected.to_owned() });
}

/// Checks that the robot's origin keeps its body's radius from every wall and every piece of furniture, wherever the scene puts the robot.
fn robot_places(scene: &Scene, found: &mut Vec<Contradiction>) {
    // Tolerance for rounding when positions are compared: sums like 0.25 + 0.01 are not exact, and nobody places a wall that finely.
    const ROUNDING_M: f64 = 1e-9;
    let (radius_m, ground_plan) = (scene.robot.body_radius_m, GroundPlan::of(scene));
    let mut place = |key: String, at_m: [f64; 2], tolerance_m: f64, why: &str| {
        let (margin_m, keep_m) = (radius_m + tolerance_m, scene.furniture_distance_m(tolerance_m));
        if ground_plan.has_further_rooms()
            && ground_plan.wall_distance_from_square_m(at_m, tolerance_m) < radius_m - ROUNDING_M
        {
            let expected =
                format!("in no room or by a wall, expected {} m of distance from walls, {why}", short(margin_m));
            found.push(Contradiction { key: format!("{key}.x_m"), expected });
        }
        let axes = [("x_m", scene.room.width_m), ("y_m", scene.room.depth_m)];
        for (axis, extent_m) in axes.into_iter().filter(|_| !ground_plan.has_further_rooms()) {
            let value_m = at_m[usize::from(axis == "y_m")];
            let (least_m, most_m) = (margin_m, extent_m - margin_m);
            if value_m < least_m - ROUNDING_M || value_m > most_m + ROUNDING_M {
                let expected = if least_m <= most_m {
                    format!("outside the room, expected a number from {} to {}, {why}", short(least_m), short(most_m))
                } else {
                    format!("the room is {extent_m} m wide here, which leaves no place, {why}")
                };
                found.push(Contradiction { key: format!("{key}.{axis}"), expected });
            }
        }
        for (index, furniture) in scene.furniture.iter().enumerate() {
            if furniture.distance_m(at_m) < keep_m {
                let piece = furniture.told(index);
                let expected = format!("in or by {piece}, expected {} m of distance, {why}", short(keep_m));
                found.push(Contradiction { key: format!("{key}.x_m"), expected });
            }
        }
    };
    let body = format!("as the robot's body reaches {radius_m} m about its origin");
    let start = &scene.start;
    let drawn = format!("{body} and the start is drawn within {} m", start.tolerance_m);
    let (within_m, drawn) = if start.anywhere { (0.0, &body) } else { (start.tolerance_m, &drawn) };
    place("start".to_owned(), [start.x_m, start.y_m], within_m, drawn);
    for (index, waypoint) in scene.route.iter().flat_map(|route| &route.waypoints).enumerate() {
        place(format!("route.waypoint[{index}]"), [waypoint.x_m, waypoint.y_m], 0.0, &body);
    }
    for (index, errand) in scene.errands.iter().enumerate() {
        place(format!("errand[{index}]"), [errand.x_m, errand.y_m], 0.0, &body);
    }
    for (index, station) in scene.stations.iter().enumerate() {
        let tolerance_m = station.tolerance_m.unwrap_or(start.tolerance_m);
        let drawn = format!("{body} and a station is drawn within {tolerance_m} m");
        place(format!("station[{index}]"), [station.x_m, station.y_m], tolerance_m, &drawn);
    }
}

/// Checks that a route's straight ways lead through no furniture that is on the map. The robot does not plan a route's ways but drives them, and would
/// push at the furniture until the run ends.
fn route_legs(scene: &Scene, found: &mut Vec<Contradiction>) {
    let Some(route) = &scene.route else { return };
    let radius_m = scene.robot.body_radius_m;
    let mut from_m = [scene.start.x_m, scene.start.y_m];
    for (index, waypoint) in route.waypoints.iter().enumerate() {
        let way_m = [from_m, [waypoint.x_m, waypoint.y_m]];
        for (number, piece) in scene.furniture.iter().enumerate().filter(|(_, piece)| piece.is_mapped()) {
            // Where an end of the way is itself too near, the place is refused already.
            let ends_apart = way_m.iter().all(|at_m| piece.distance_m(*at_m) >= radius_m);
            if ends_apart && things::meets(piece, way_m, radius_m) {
                let [[x0_m, y0_m], [x1_m, y1_m]] = way_m;
                let expected = format!(
                    "the way from [{x0_m}, {y0_m}] to [{x1_m}, {y1_m}] leads through or by {}, expected {} m of \
                     distance, the radius of the robot's body, or `mapped = false` for furniture that it is to run into",
                    piece.told(number),
                    short(radius_m)
                );
                found.push(Contradiction { key: format!("route.waypoint[{index}].x_m"), expected });
            }
        }
        from_m = way_m[1];
    }
}

/// Checks the widths below which an estimate counts as available. An estimate that says no more than the room itself must not count.
fn declared_widths(scene: &Scene, found: &mut Vec<Contradiction>) {
    let setup = &scene.localizer;
    let [x_m, y_m] = scene.left_to_origin_m();
    let shortest_m = x_m.min(y_m);
    let mut refuse =
        |key: &str, expected: String| found.push(Contradiction { key: format!("localizer.{key}"), expected });
    if setup.declared_width_m >= shortest_m {
        let expected = format!(
            "no estimate is wider, expected less than the {} m that the walls leave to the middle of the robot's body",
            short(shortest_m)
        );
        refuse("declared_width_m", expected);
    }
    if setup.declared_width_deg >= 360.0 {
        refuse("declared_width_deg", "every heading is within it, expected less than 360".to_owned());
    }
}

/// Checks that the robot has the device that each localization method reads, that no method is listed twice, and that the range camera's numbers of
/// wrong landmarks and its ranges leave it something to measure.
fn methods(scene: &Scene, found: &mut Vec<Contradiction>) {
    // The list that scenes have by default holds `floor_tiles` alone, which then reads tiles only where there are any.
    let stated = scene.localizer.methods.iter().filter(|_| scene.localizer.states_methods);
    for (method, device) in stated.filter_map(|method| Some((method, scene.robot.lacks(*method)?))) {
        let name = serde_json::to_value(method).unwrap_or_default();
        // Landmarks are read from either of two cameras.
        let first = if *method == MethodName::MappedLandmarks { "`robot.forward_camera` or " } else { "" };
        let expected =
            format!("`{}` among them, expected {first}`{device}` for it to read", name.as_str().unwrap_or_default());
        found.push(Contradiction { key: "localizer.methods".to_owned(), expected });
    }
    let methods = &scene.localizer.methods;
    if (1..methods.len()).any(|index| methods[..index].contains(&methods[index])) {
        let expected = "a method twice, expected each at most once".to_owned();
        found.push(Contradiction { key: "localizer.methods".to_owned(), expected });
    }
    let q_items = scene.robot.range_camera.as_ref().map_or(0, |camera| camera.q_items);
    if q_items > 0 && q_items >= scene.landmarks.len() {
        let expected = format!("nothing could be told, expected fewer than the {} landmarks", scene.landmarks.len());
        found.push(Contradiction { key: "robot.range_camera.q_items".to_owned(), expected });
    }
    let ranges = scene.robot.range_camera.as_ref().map(|camera| [camera.least_range_m, camera.greatest_range_m]);
    if let Some([least_m, greatest_m]) = ranges
        && least_m >= greatest_m
    {
        let expected = format!("expected more than `least_range_m`, which is {least_m}");
        found.push(Contradiction { key: "robot.range_camera.greatest_range_m".to_owned(), expected });
    }
}

fn floor_places(scene: &Scene, found: &mut Vec<Contradiction>) {
    if let Some(tiles) = &scene.floor.tiles {
        let shorter_m = tiles.edge_x_m.min(tiles.edge_y_m);
        // A joint wider than half a tile is a stripe in its own right, whose centre line gives no position.
        if tiles.joint_width_m > 0.5 * shorter_m {
            let expected = format!("wider than half a tile, expected at most {}", 0.5 * shorter_m);
            found.push(Contradiction { key: "floor.tiles.joint_width_m".to_owned(), expected });
        }
    }
    let room_m = [scene.room.width_m, scene.room.depth_m];
    for (index, stray) in scene.floor.strays.iter().enumerate() {
        for (end, at_m) in [("from_m", stray.from_m), ("to_m", stray.to_m)] {
            if (0..2).any(|axis| at_m[axis] < 0.0 || at_m[axis] > room_m[axis]) {
                let expected = format!("outside the room, expected [0, 0] to [{}, {}]", room_m[0], room_m[1]);
                found.push(Contradiction { key: format!("floor.stray[{index}].{end}"), expected });
            }
        }
    }
    for (index, region) in scene.floor.regions.iter().enumerate() {
        for (name, range_m, extent_m) in [("x_m", region.x_m, room_m[0]), ("y_m", region.y_m, room_m[1])] {
            if !(0.0 <= range_m[0] && range_m[0] < range_m[1] && range_m[1] <= extent_m) {
                let expected = format!("expected two rising numbers inside the room, from 0 to {extent_m}");
                found.push(Contradiction { key: format!("floor.region[{index}].{name}"), expected });
            }
        }
        let is_within = |at_m: &[f64; 2]| (0..2).all(|axis| (0.0..=room_m[axis]).contains(&at_m[axis]));
        let is_upright = region.rotation_deg == 0.0;
        if let Some([x_m, y_m]) = region.corners_m().iter().find(|at_m| !is_upright && !is_within(at_m)) {
            let expected = format!(
                "turns a corner to [{}, {}], outside the room, expected corners within [0, 0] to [{}, {}]",
                short(*x_m),
                short(*y_m),
                room_m[0],
                room_m[1]
            );
            found.push(Contradiction { key: format!("floor.region[{index}].rotation_deg"), expected });
        }
        if region.height_m > GREATEST_SLOPE * region.ramp_m {
            let expected = format!(
                "expected at least {}, as ramps rise by at most {GREATEST_SLOPE}",
                short(region.height_m / GREATEST_SLOPE)
            );
            found.push(Contradiction { key: format!("floor.region[{index}].ramp_m"), expected });
        }
        if scene.floor.regions[..index].iter().any(|earlier| earlier.name == region.name) {
            let expected = "expected a name that no other region has".to_owned();
            found.push(Contradiction { key: format!("floor.region[{index}].name"), expected });
        }
    }
}

fn events(scene: &Scene, found: &mut Vec<Contradiction>) {
    for (index, event) in scene.events.iter().enumerate() {
        let lasts_s = event.lasts_s();
        if scene.stations.is_empty() && event.at_s() + lasts_s > scene.duration_s {
            let expected = format!(
                "after the end, expected at most {}, as the run lasts {} s",
                short(scene.duration_s - lasts_s),
                scene.duration_s
            );
            found.push(Contradiction { key: format!("event[{index}].at_s"), expected });
        }
        if let Event::Lamp { lamp: name, .. } = event
            && !scene.lamps.iter().any(|lamp| lamp.name.as_ref() == Some(name))
        {
            let names: BTreeSet<&str> = scene.lamps.iter().filter_map(|lamp| lamp.name.as_deref()).collect();
            let expected = match names.is_empty() {
                true => "unknown lamp, expected a `[[lamp]]` of that `name`, of which the scene has none".to_owned(),
                false => {
                    format!("unknown lamp, expected one of {}", names.into_iter().collect::<Vec<_>>().join(", "))
                }
            };
            found.push(Contradiction { key: format!("event[{index}].lamp"), expected });
        }
        if let Event::Friction { region: Some(name), .. } = event {
            let names: Vec<&str> = scene.floor.regions.iter().map(|region| region.name.as_str()).collect();
            if !names.contains(&name.as_str()) {
                let expected = match (nearest(name, names.iter().copied()), names.is_empty()) {
                    (_, true) => "unknown region, expected a `[[floor.region]]` of that name".to_owned(),
                    (Some(meant), _) => format!("unknown region, expected \"{meant}\"?"),
                    (None, _) => format!("unknown region, expected one of {}", names.join(", ")),
                };
                found.push(Contradiction { key: format!("event[{index}].region"), expected });
            }
        }
    }
}

/// Rounds a number to six decimals, which removes the noise of binary fractions.
fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
