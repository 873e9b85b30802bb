//! Tests that further rooms and open doors are there for body, beams, landmarks and paths, with distances worked out by hand.

use std::f64::consts::FRAC_PI_6;

use localizer::{Pose, Reading};
use serde_json::{Value, json};
use sim::{
    devices::Sensor,
    place::{
        building::Building,
        navigation::{Cell, OccupancyGrid, Planner},
    },
    run::{Clearance, sensors::Sensors},
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use crate::{
    command::{root, scene_text},
    render_studio::judged,
    world_setup::{command, hold, nominal, nominal_world, range_sensor, scene},
};

/// Two rooms of 3 m depth, the robot's from x = 0 to 4 m and another from x = 4.1 to 7.1 m. In the wall of 10 cm between them is a door from y = 1 to
/// 2 m. The robot's body has a radius of 0.25 m. `more` replaces keys.
fn two_rooms(more: Value) -> Scene {
    let mut keys = json!({
        "room": { "width_m": 4.0, "depth_m": 3.0 },
        "building": {
            "room": [{ "x_m": 4.1, "y_m": 0.0, "width_m": 3.0, "depth_m": 3.0 }],
            "door": [{ "from_m": [4.0, 1.0], "to_m": [4.0, 2.0], "open": true }],
        },
        "start": { "x_m": 1.5, "y_m": 1.5, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        keys[key] = value.clone();
    }
    scene(keys)
}

/// The same with other doors.
fn with_doors(doors: Value) -> Value {
    json!({ "room": [{ "x_m": 4.1, "y_m": 0.0, "width_m": 3.0, "depth_m": 3.0 }], "door": doors })
}

/// Greatest x that the robot reaches when it drives along x for 16 s, from x = 1.5 m and the given y.
fn drives_to_m(y_m: f64, building: Option<Value>) -> f64 {
    let mut more = json!({ "start": { "x_m": 1.5, "y_m": y_m, "tolerance_m": 0.0, "tolerance_deg": 0.0 } });
    if let Some(building) = building {
        more["building"] = building;
    }
    hold(&mut nominal_world(&two_rooms(more)), command(0.5, 0.0), 16.0).pose.x_m
}

fn standing(x_m: f64, y_m: f64, heading_rad: f64) -> Truth {
    Truth { pose: Pose { x_m, y_m, heading_rad }, ..Truth::default() }
}

#[test]
fn the_robot_drives_through_an_open_door_and_bumps_into_the_far_rooms_wall() {
    let reached_m = drives_to_m(1.5, None);
    assert!((reached_m - 6.85).abs() < 0.002, "{reached_m}");
    // An open door in the far wall leads into no room, so that nothing goes through it.
    let way_out = with_doors(json!([
        { "from_m": [4.0, 1.0], "to_m": [4.0, 2.0], "open": true },
        { "from_m": [7.1, 1.0], "to_m": [7.1, 2.0], "open": true },
    ]));
    let reached_m = drives_to_m(1.5, Some(way_out));
    assert!((reached_m - 6.85).abs() < 0.002, "{reached_m}");
}

#[test]
fn beside_an_open_door_and_at_a_closed_one_the_wall_between_rooms_stops_the_robot() {
    for y_m in [0.5, 2.5] {
        let reached_m = drives_to_m(y_m, None);
        assert!((reached_m - 3.75).abs() < 0.002, "from y = {y_m}: {reached_m}");
    }
    // Rooms without a wall's thickness between them have a thin wall for the body, which begins some millimetres before the one that is seen.
    let wall_to_wall = json!({ "room": [{ "x_m": 4.0, "y_m": 0.0, "width_m": 3.0, "depth_m": 3.0 }] });
    let reached_m = drives_to_m(1.5, Some(wall_to_wall));
    assert!((3.744..3.752).contains(&reached_m), "{reached_m}");
    let closed = with_doors(json!([{ "from_m": [4.0, 1.0], "to_m": [4.0, 2.0] }]));
    let reached_m = drives_to_m(1.5, Some(closed));
    assert!((reached_m - 3.75).abs() < 0.002, "{reached_m}");
}

#[test]
fn a_jamb_is_as_hard_as_a_wall() {
    // At y = 1.15 m the body, 0.25 m in radius, meets the jamb at (4, 1) when its origin is at x = 3.8 m.
    let start = json!({ "x_m": 1.5, "y_m": 1.15, "tolerance_m": 0.0, "tolerance_deg": 0.0 });
    let scene = two_rooms(json!({ "start": start }));
    let mut world = nominal_world(&scene);
    let (mut nearest_m, mut met_at_m) = (f64::INFINITY, None);
    for _ in 0..12_000 {
        let pose = world.step(command(0.3, 0.0)).pose;
        let to_jamb_m = (pose.x_m - 4.0).hypot(pose.y_m - 1.0);
        nearest_m = to_jamb_m.min(nearest_m);
        met_at_m = met_at_m.or_else(|| (to_jamb_m < 0.2515).then_some(pose.x_m));
    }
    assert!(nearest_m > 0.249, "{nearest_m}");
    assert!(met_at_m.is_some_and(|x_m| (x_m - 3.8).abs() < 0.004), "{met_at_m:?}");
}

#[test]
fn beams_go_through_the_door_and_end_at_the_far_rooms_walls() {
    let fan = |truth: Truth, height_m: f64, building: Option<Value>| -> Vec<f64> {
        let scanner = json!({
            "field_deg": 60.0, "beams": 3, "range_m": 8.0, "height_m": height_m, "tolerance_m": 0.0,
            "position_tolerance_m": 0.0, "angle_tolerance_deg": 0.0,
        });
        let mut more = json!({ "robot": { "floor_camera": false, "scanner": scanner } });
        if let Some(building) = building {
            more["building"] = building;
        }
        let scene = two_rooms(more);
        let mut sensors = Sensors::new(&scene, 0, &nominal(&scene), None);
        sensors.observe(&truth, &[], None).unwrap();
        let beams = sensors.look_out().unwrap().beams;
        beams.iter().map(|beam| beam.distance_m.unwrap_or(f64::INFINITY)).collect()
    };
    let meets =
        |found_m: f64, expected_m: f64| assert!((found_m - expected_m).abs() < 1e-9, "{found_m}, not {expected_m}");
    meets(fan(standing(2.0, 1.5, 0.0), 0.3, None)[1], 5.1);
    meets(fan(standing(2.0, 0.5, 0.0), 0.3, None)[1], 2.0);
    // To the left by 30° from (3, 1.5), a beam is at y = 2.08 when it gets to the wall between the rooms: it ends there.
    meets(fan(standing(3.0, 1.5, 0.0), 0.3, None)[2], 1.0 / FRAC_PI_6.cos());
    // From (3.5, 1.5) it passes the door and ends at y = 3 in the other room. From (3.2, 1.5) it ends at the jamb at y = 2, 6.6 cm into the wall.
    meets(fan(standing(3.5, 1.5, 0.0), 0.3, None)[2], 3.0);
    meets(fan(standing(3.2, 1.5, 0.0), 0.3, None)[2], 1.0);
    // A beam above the door meets the wall over it, and one that comes back meets the robot's own room.
    let low = with_doors(json!([{ "from_m": [4.0, 1.0], "to_m": [4.0, 2.0], "height_m": 0.5, "open": true }]));
    meets(fan(standing(2.0, 1.5, 0.0), 0.6, Some(low))[1], 2.0);
    meets(fan(standing(6.0, 1.5, std::f64::consts::PI), 0.3, None)[1], 6.0);
}

/// Distance from a place to the nearest face that is seen along a ray; infinite where a ray meets nothing.
fn seen_at_m(building: &Building, from: [f64; 3], ray: [f64; 3]) -> f64 {
    let seen = building.panels.iter().filter_map(|panel| panel.seen_along(from.into(), ray.into()));
    seen.fold(f64::INFINITY, f64::min)
}

fn built(scene: &Scene) -> Building {
    Building::new(scene, &Drawn::draw(scene, 0).place)
}

#[test]
fn the_inside_of_an_open_door_is_seen_where_it_is_felt() {
    // From the middle of the passage, 1 m above the floor: floor, lintel (2.05 m), both jambs, and the far walls of both rooms.
    let building = built(&two_rooms(json!({})));
    let distances_m = [
        ([0.0, 0.0, -1.0], 1.0),
        ([0.0, 0.0, 1.0], 1.05),
        ([0.0, 1.0, 0.0], 0.5),
        ([0.0, -1.0, 0.0], 0.5),
        ([1.0, 0.0, 0.0], 3.05),
        ([-1.0, 0.0, 0.0], 4.05),
    ];
    for (ray, distance_m) in distances_m {
        let seen_m = seen_at_m(&building, [4.05, 1.5, 1.0], ray);
        // Floors lie in layers of 1 mm.
        assert!((seen_m - distance_m).abs() < 0.003, "{ray:?}: {seen_m}, expected {distance_m}");
    }
}

#[test]
fn no_ray_leaves_rooms_at_an_angle_through_their_door() {
    let rooms = json!([{ "x_m": 4.4, "y_m": 0.0, "width_m": 3.0, "depth_m": 2.6, "heading_deg": 8.0 }]);
    let doors = json!([{ "from_m": [4.13, 0.9], "to_m": [4.10, 1.9], "open": true }]);
    let building = built(&two_rooms(json!({ "building": { "room": rooms, "door": doors } })));
    for place in [[3.5, 1.4, 0.3], [4.1, 1.4, 1.0], [5.2, 1.6, 0.3], [4.6, 0.9, 1.6]] {
        for idx in 0..4_000 {
            // Directions spread over the sphere by the golden angle.
            let z = 1.0 - (2.0 * f64::from(idx) + 1.0) / 4_000.0;
            let (angle, level) = (f64::from(idx) * 2.399_963, (1.0 - z * z).sqrt());
            // The floors of further rooms lie 1 mm lower than their walls begin. A ray through that seam ends where one a little higher does.
            let seen_m = [0.0, 0.004]
                .map(|up| seen_at_m(&building, place, [level * angle.cos(), level * angle.sin(), z + up]))
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            assert!(seen_m < 8.0, "from {place:?}, angle {angle}, rise {z}: {seen_m}");
        }
    }
}

#[test]
fn landmarks_of_the_far_room_are_seen_through_the_door_only() {
    let is_seen = |x_m: f64, y_m: f64, height_m: f64| {
        let camera =
            json!({ "focal_px": 500.0, "forward_m": 0.0, "left_m": 0.0, "height_m": 0.5, "greatest_range_m": 8.0 });
        let scene = two_rooms(json!({
            "robot": { "floor_camera": false, "range_camera": camera },
            "landmark": [{ "x_m": x_m, "y_m": y_m, "height_m": height_m }],
        }));
        let mut sensor = range_sensor(&scene, 0);
        let mut truth = standing(2.0, 1.5, 0.0);
        truth.time_s = 0.1;
        match sensor.observe(&truth, &[]).unwrap().reading {
            Reading::Range { sightings, .. } => !sightings.is_empty(),
            other => panic!("{other:?}"),
        }
    };
    assert!(is_seen(6.0, 1.5, 0.5) && is_seen(7.1, 1.5, 0.5), "through the door, and on the far wall");
    // The line of sight to (6, 0.3) passes the wall between the rooms at y = 0.9, beside the door; that to (6, 0.7) at y = 1.1, in the door.
    assert!(!is_seen(6.0, 0.3, 0.5) && is_seen(6.0, 0.7, 0.5));
    assert!(is_seen(3.99, 0.5, 0.5), "in the robot's own room");
    // The line of sight to a height of 3.9 m at x = 6 is at 2.2 m when it gets to the door, which is 2 m high by default.
    assert!(!is_seen(6.0, 1.5, 3.9));
}

#[test]
fn clearance_is_measured_from_jambs_and_from_the_walls_of_the_room_the_robot_is_in() {
    let scene = two_rooms(json!({}));
    let walls_m = |x_m: f64, y_m: f64| Clearance::of(&scene, &standing(x_m, y_m, 0.0), &[]).walls_m + 0.25;
    assert!((walls_m(4.05, 1.5) - 0.5).abs() < 1e-9, "in the middle of the door");
    // The nearest walls at (5.1, 1.5) are the two jambs at (4.1, 1) and (4.1, 2).
    assert!((walls_m(5.1, 1.5) - 1.25_f64.sqrt()).abs() < 1e-9);
    assert!((walls_m(6.5, 1.5) - 0.6).abs() < 1e-9 && (walls_m(5.0, 0.4) - 0.4).abs() < 1e-9);
    assert!(walls_m(4.05, 0.5) < 0.0 && walls_m(8.0, 1.5) < 0.0, "inside a wall, and outside of the building");
}

#[test]
fn the_grid_has_both_rooms_and_a_path_through_the_door() {
    let grid = OccupancyGrid::from_scene(&two_rooms(json!({})));
    let is_free = |x_m: f64, y_m: f64| grid.at(grid.cell_at([x_m, y_m]).unwrap()) == Cell::Free;
    assert!(is_free(1.0, 1.0) && is_free(5.52, 1.52) && is_free(7.07, 2.97), "floors of both rooms");
    assert!(is_free(4.02, 1.52) && is_free(4.07, 1.02) && is_free(4.07, 1.97), "the floor of the door");
    assert!(!is_free(4.02, 0.52) && !is_free(4.07, 2.52), "the wall between the rooms");
    assert!(!is_free(7.12, 1.52) && !is_free(-0.02, 1.52) && !is_free(5.52, 3.02), "what is outside");
    let way = Planner::new(grid, 0.3).plan([1.5, 0.5], [6.0, 0.5]).unwrap();
    let in_door = way.windows(2).filter(|leg| leg[0][0] < 4.05 && leg[1][0] >= 4.05);
    let at_y_m: Vec<f64> = in_door
        .map(|leg| {
            let share = (4.05 - leg[0][0]) / (leg[1][0] - leg[0][0]);
            leg[0][1] + share * (leg[1][1] - leg[0][1])
        })
        .collect();
    assert!(at_y_m.len() == 1 && (1.3 - 0.05..=1.7 + 0.05).contains(&at_y_m[0]), "{at_y_m:?}");
}

#[test]
fn rooms_that_meet_on_a_border_of_cells_have_a_wall_on_the_grid_and_a_way_through_their_door() {
    // Cells are 5 cm long, so that x = 4 m is a border between two of them.
    let wall_to_wall = |doors: Value| {
        two_rooms(json!({ "building": {
            "room": [{ "x_m": 4.0, "y_m": 0.0, "width_m": 3.0, "depth_m": 3.0 }], "door": doors,
        } }))
    };
    let free_beside_m = |scene: &Scene, x_m: f64| -> Vec<f64> {
        let grid = OccupancyGrid::from_scene(scene);
        let centres_m = (0..60).map(|cell| 0.05 * f64::from(cell) + 0.025);
        centres_m.filter(|y_m| grid.at(grid.cell_at([x_m, *y_m]).unwrap()) == Cell::Free).collect()
    };
    let closed = wall_to_wall(json!([]));
    assert!(free_beside_m(&closed, 3.975).is_empty() && free_beside_m(&closed, 4.025).is_empty());
    assert!(free_beside_m(&closed, 3.925).len() == 60 && free_beside_m(&closed, 4.075).len() == 60);
    assert_eq!(Planner::new(OccupancyGrid::from_scene(&closed), 0.1).plan([1.5, 1.5], [6.0, 1.5]), None);
    // A door from y = 1 to 2 m leaves twenty cells free.
    let open = wall_to_wall(json!([{ "from_m": [4.0, 1.0], "to_m": [4.0, 2.0], "open": true }]));
    for x_m in [3.975, 4.025] {
        let free_m = free_beside_m(&open, x_m);
        assert!(free_m.len() == 20 && free_m.iter().all(|y_m| (1.0..2.0).contains(y_m)), "{x_m}: {free_m:?}");
    }
    assert!(Planner::new(OccupancyGrid::from_scene(&open), 0.1).plan([1.5, 1.5], [6.0, 1.5]).is_some());
}

#[test]
fn places_in_walls_and_outside_of_all_rooms_are_refused() {
    let text = scene_text("rooms/two_rooms.toml");
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        match Scene::parse(&text.replace(from, to), "two_rooms.toml") {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{to} is no mistake"),
        }
    };
    for (x_m, y_m) in [("4.05", "0.6"), ("8.0", "0.6"), ("4.3", "0.6"), ("-1.0", "0.6")] {
        let told = refused("x_m = 4.6\ny_m = 0.6", &format!("x_m = {x_m}\ny_m = {y_m}"));
        assert!(told.contains("errand[2].x_m") && told.contains("expected 0.25 m of distance from walls"), "{told}");
    }
    let told = refused("x_m = 1.0\ny_m = 0.8", "x_m = 0.2\ny_m = 0.8");
    assert!(told.contains("start.x_m"), "{told}");
}

#[test]
#[ignore = "takes half a minute: make test-long"]
fn errands_in_both_rooms_keep_the_truth_by_the_tiles_of_both_floors() {
    let scene = Scene::load(&root().join("scenes/rooms/two_rooms.toml")).unwrap();
    for seed in 0..1 {
        let (record, verdict) = judged(&scene, seed);
        let containment = verdict.containment.as_ref().unwrap();
        assert_eq!(containment.contained, containment.checks, "seed {seed}: {containment:?}");
        assert!(verdict.verdict.failed.is_empty(), "seed {seed}: {:?}", verdict.verdict.failed);
        let in_far_room = record.truths.iter().zip(&record.estimates).filter(|(truth, _)| truth.pose.x_m > 4.5);
        let widths_m: Vec<f64> = in_far_room.map(|(_, estimate)| estimate.pose.hull()[0].width()).collect();
        let mean_m = widths_m.iter().sum::<f64>() / widths_m.len() as f64;
        assert!(widths_m.len() > 500 && mean_m < 0.02, "seed {seed}: {} estimates, {mean_m} m wide", widths_m.len());
    }
}
