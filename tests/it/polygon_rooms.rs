//! Rooms of any polygon: their walls, beams, light and pictures against rays that are met with polygons here, and against the same rooms stated as
//! rectangles.

use std::f64::consts::{FRAC_PI_4, TAU};

use localizer::Pose;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use serde_json::{Value, json};
use sim::{
    optics::Lens,
    place::{
        building::Part,
        light::FloorField,
        navigation::{Cell, OccupancyGrid},
    },
    render::View,
    run::sensors::Sensors,
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use crate::{
    command::{blind_scene, root},
    light_of_lamps::baked,
    render_room::{level, looking_ahead, quiet_view},
    render_studio::renderer,
    scene_refusals::assert_refused,
    world_setup::{command, nominal, nominal_world, scene},
};

/// An L with its corner at (4.1, 0), each arm 4 m long and 2 m wide.
const L_M: [[f64; 2]; 6] = [[4.1, 0.0], [8.1, 0.0], [8.1, 2.0], [6.1, 2.0], [6.1, 4.0], [4.1, 4.0]];

/// A room of 4 m by 3 m and further rooms, with an open door from y = 1 to 2 m in the wall at x = 4 m.
fn with_rooms(rooms: Value, more: Value) -> Scene {
    let mut keys = json!({
        "room": { "width_m": 4.0, "depth_m": 3.0 },
        "building": { "room": rooms, "door": [{ "from_m": [4.0, 1.0], "to_m": [4.0, 2.0], "open": true }] },
        "start": { "x_m": 1.5, "y_m": 1.5, "tolerance_m": 0.0, "tolerance_deg": 0.0 },
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        keys[key] = value.clone();
    }
    scene(keys)
}

/// The L as one polygon, and as two rectangles that overlap.
fn both_ways(more: &Value) -> [Scene; 2] {
    let rectangles = json!([
        { "x_m": 4.1, "y_m": 0.0, "width_m": 4.0, "depth_m": 2.0 },
        { "x_m": 4.1, "y_m": 0.0, "width_m": 2.0, "depth_m": 4.0 },
    ]);
    [json!([{ "corners_m": L_M }]), rectangles].map(|rooms| with_rooms(rooms, more.clone()))
}

/// Distances at which the scanner's beams end all around, from a place 0.3 m above the floor.
fn beams_m(scene: &Scene, [x_m, y_m]: [f64; 2]) -> Vec<f64> {
    let mut sensors = Sensors::new(scene, 0, &nominal(scene), None);
    let truth = Truth { pose: Pose { x_m, y_m, heading_rad: 0.3 }, ..Truth::default() };
    sensors.observe(&truth, &[], None).unwrap();
    let beams = sensors.look_out().unwrap().beams;
    beams.iter().map(|beam| beam.distance_m.unwrap_or(f64::INFINITY)).collect()
}

fn with_scanner() -> Value {
    let scanner = json!({
        "field_deg": 340.0, "beams": 341, "range_m": 30.0, "height_m": 0.3, "tolerance_m": 0.0,
        "position_tolerance_m": 0.0, "angle_tolerance_deg": 0.0,
    });
    json!({ "robot": { "floor_camera": false, "scanner": scanner } })
}

/// Distance at which a ray meets the nearest side of a polygon, by the two equations in two unknowns.
fn met_m(corners_m: &[[f64; 2]], from: [f64; 2], angle_rad: f64) -> f64 {
    let (dy, dx) = angle_rad.sin_cos();
    let sides = (0..corners_m.len()).map(|index| [corners_m[index], corners_m[(index + 1) % corners_m.len()]]);
    let met = sides.filter_map(|[[x0, y0], [x1, y1]]| {
        let (sx, sy) = (x1 - x0, y1 - y0);
        let determinant = dy * sx - dx * sy;
        let (ox, oy) = (x0 - from[0], y0 - from[1]);
        let (distance, share) = ((oy * sx - ox * sy) / determinant, (dx * oy - dy * ox) / determinant);
        (distance > 0.0 && (-1e-12..=1.0 + 1e-12).contains(&share)).then_some(distance)
    });
    met.fold(f64::INFINITY, f64::min)
}

/// A polygon around a point, whose corners are between 0.8 and 4 m from it.
fn star(seed: u32, count: u32, [x_m, y_m]: [f64; 2]) -> Vec<[f64; 2]> {
    let corner = |index: u32| {
        let angle = TAU * (f64::from(index) + 0.4 * f64::from(seed * 7 % 11) / 11.0) / f64::from(count);
        let away_m = 0.8 + 3.2 * (f64::from((index * 37 + seed * 101) % 64) / 64.0);
        [x_m + away_m * angle.cos(), y_m + away_m * angle.sin()]
    };
    (0..count).map(corner).collect()
}

#[test]
fn beams_in_a_polygonal_room_end_where_rays_meet_the_polygon() {
    for (seed, count) in (0..12).zip([3, 4, 5, 6, 7, 9, 12, 16, 24, 33, 48, 64]) {
        let mut corners_m = star(seed, count, [12.0, 1.0]);
        if seed % 2 == 0 {
            corners_m.reverse();
        }
        let mut scene = with_rooms(json!([{ "corners_m": corners_m }]), with_scanner());
        scene.building.doors.clear();
        for away_m in [0.0, 0.3, 0.6] {
            let at_m = [12.0 + away_m * f64::from(seed).cos(), 1.0 + away_m * f64::from(seed).sin()];
            for (index, found_m) in beams_m(&scene, at_m).into_iter().enumerate() {
                let angle = 0.3 + (index as f64 - 170.0).to_radians();
                let expected_m = met_m(&corners_m, at_m, angle);
                assert!((found_m - expected_m).abs() < 1e-9, "{corners_m:?}, {at_m:?}: {found_m}, not {expected_m}");
            }
        }
    }
}

#[test]
fn an_l_of_one_polygon_has_the_walls_the_free_cells_and_the_beams_of_two_rectangles() {
    let [one, two] = both_ways(&with_scanner());
    // Where one has a wall from corner to corner, the other may have two that touch: they are compared by points along them.
    let walls = [&one, &two].map(|scene| scene.map().walls.unwrap().walls);
    let length_m = |wall: &[[f64; 2]; 2]| (wall[1][0] - wall[0][0]).hypot(wall[1][1] - wall[0][1]);
    let total_m = [0, 1].map(|which| walls[which].iter().map(|wall| length_m(&wall.ends_m)).sum::<f64>());
    // Both rooms, 14 m and 16 m around, without the door in both walls.
    assert!(total_m.iter().all(|total_m| (total_m - 28.0).abs() < 1e-4), "{total_m:?}");
    for [these, others] in [[&walls[0], &walls[1]], [&walls[1], &walls[0]]] {
        // What is left of a wall where rectangles touch may be a micrometre long.
        for wall in these.iter().filter(|wall| length_m(&wall.ends_m) > 1e-5) {
            let [from, to] = wall.ends_m.map(Vector2::from);
            for step in 0..=10 {
                let at = from + (to - from) * (f64::from(step) / 10.0);
                let is_on = |other: &localizer::map::Wall| {
                    let [start, end] = other.ends_m.map(Vector2::from);
                    let way = end - start;
                    let share = ((at - start).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
                    let faces_alike = way.normalize().dot(&(to - from).normalize()) > 0.999;
                    faces_alike && (at - start - way * share).norm() < 1e-5
                };
                assert!(others.iter().any(is_on), "no wall at {at}");
            }
        }
    }
    let grids = [&one, &two].map(OccupancyGrid::from_scene);
    assert_eq!(grids[0].size, grids[1].size);
    // The same micrometre of wall takes cells away from the floor of the two rectangles, where the lines end in which they meet.
    let taken = grids[0].cells.iter().zip(&grids[1].cells).enumerate().filter(|(_, (one, two))| one != two);
    for (index, (one, two)) in taken {
        let at_m = Vector2::from(grids[0].centre_m([index % grids[0].size[0], index / grids[0].size[0]]));
        let is_beside = |end_m: [f64; 2]| (at_m - Vector2::from(end_m)).amax() < 0.051;
        assert!((*one, *two) == (Cell::Free, Cell::Occupied), "{at_m} is {one:?} and {two:?}");
        let ends_m = [[4.1, 2.0], [6.1, 0.0], [6.1, 2.0]];
        assert!(ends_m.into_iter().any(is_beside), "{at_m} is {one:?} and {two:?}");
    }
    for at_m in [[1.0, 1.0], [3.7, 1.5], [4.05, 1.5], [5.0, 1.0], [7.8, 0.3], [5.9, 3.7], [6.0, 1.9], [7.0, 1.99]] {
        let [by_one, by_two] = [&one, &two].map(|scene| beams_m(scene, at_m));
        for (one_m, two_m) in by_one.into_iter().zip(by_two) {
            assert!((one_m - two_m).abs() < 1e-9, "from {at_m:?}: {one_m} and {two_m}");
        }
    }
}

fn with_lamps() -> Value {
    let lamp = |x_m: f64, y_m: f64, lumens: f64| json!({ "kind": "panel", "x_m": x_m, "y_m": y_m, "lumens": lumens, "spectrum": "monochrome" });
    json!({ "lamp": [lamp(2.0, 1.5, 1500.0), lamp(7.2, 1.0, 2000.0), lamp(5.1, 3.2, 1000.0)] })
}

#[test]
fn an_l_of_one_polygon_is_lit_nearly_as_two_rectangles_are() {
    let floors = both_ways(&with_lamps()).map(|scene| {
        let (building, lighting, map) = baked(&scene, &[]);
        let floor = FloorField::new(&building, &map, &map.nodes).unwrap();
        (building, lighting, floor)
    });
    let (mut count, mut sum, mut most, mut on_people, mut most_on_people) = (0.0, 0.0, 0.0_f64, 0.0, 0.0_f64);
    for (x_m, y_m) in
        (0..80).flat_map(|i| (0..80).map(move |j| (4.12 + 0.05 * f64::from(i), 0.02 + 0.05 * f64::from(j))))
    {
        if x_m > 6.08 && y_m > 1.98 {
            continue;
        }
        let [one, two] = [0, 1].map(|which| floors[which].2.at(Vector2::new(x_m, y_m)));
        let off = (one / two - 1.0).abs();
        (count, sum, most) = (count + 1.0, sum + off, most.max(off));
        // Reflected light on a person there, by the lattice of the room.
        let at = Point3::new(x_m, y_m, 1.0);
        let [one, two] = [0, 1].map(|which| {
            let (building, lighting, _) = &floors[which];
            lighting.at(at, Vector3::x(), building.room_at(at), 4).lux
        });
        let off = (one / two - 1.0).abs();
        (on_people, most_on_people) = (on_people + off, most_on_people.max(off));
    }
    assert!(sum / count < 0.01 && most < 0.1, "{} on average, {most} at most", sum / count);
    // The points of the lattices are a metre apart and at other places, which tells by the inner corner.
    let mean = on_people / count;
    assert!(mean < 0.03 && most_on_people < 0.25, "{mean} on average, {most_on_people} at most");
}

#[test]
fn no_step_of_light_shows_where_the_parts_of_a_polygon_meet() {
    // The L is cut from its inner corner, at (6.1, 2), to the outer one at (4.1, 0) or beside it. A circle around the inner corner crosses any cut.
    let [scene, _] = both_ways(&with_lamps());
    let (building, lighting, map) = baked(&scene, &[]);
    let floor = FloorField::new(&building, &map, &map.nodes).unwrap();
    let place = |step: u32| {
        let angle = TAU * (0.26 + 0.73 * f64::from(step) / 2000.0);
        Vector2::new(6.1 + 1.2 * angle.cos(), 2.0 + 1.2 * angle.sin())
    };
    let ambient = |at: Vector2<f64>| {
        let at = Point3::new(at.x, at.y, 1.0);
        let direct_lux = lighting.direct_at(at, Vector3::x(), 1).lux;
        lighting.at(at, Vector3::x(), building.room_at(at), 1).lux - direct_lux
    };
    for step in 0..2000 {
        let [here, next] = [step, step + 1].map(place);
        assert!((floor.at(next) / floor.at(here) - 1.0).abs() < 0.01, "on the floor at {here}");
        // Reflected light on an upright face, such as a person's.
        let [one, other] = [here, next].map(ambient);
        assert!((other / one - 1.0).abs() < 0.05, "1 m above {here}: {one} and {other} lx");
    }
}

#[test]
fn an_l_of_one_polygon_looks_nearly_as_two_rectangles_do() {
    let images = both_ways(&with_lamps()).map(|scene| {
        let mut renderer = renderer();
        let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
        let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
        let at = |x_m: f64, y_m: f64, turn: f64| {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
            Isometry3::from_parts(Translation3::new(x_m, y_m, 0.8), turn * looking_ahead().rotation)
        };
        let poses = [at(4.6, 0.5, FRAC_PI_4), at(5.0, 3.6, -1.2), at(7.8, 0.4, 2.8), at(3.2, 1.5, 0.0)];
        let views = poses.map(|pose| View {
            illuminance_at_floor_lux,
            ..quiet_view(Lens::ideal([320, 240], 160.0), vec![pose], 1.0)
        });
        views.map(|view| renderer.draw(&world, &[view]).unwrap().remove(0))
    });
    let [one, two] = &images;
    for (index, (one, two)) in one.iter().zip(two).enumerate() {
        let off: Vec<f64> = (0..240)
            .flat_map(|v| (0..320).map(move |u| (u, v)))
            .map(|(u, v)| (level(one, u, v) - level(two, u, v)).abs())
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let n_far = off.iter().filter(|off| **off > 12.0).count();
        let bright = (0..240).map(|v| level(one, 160, v)).sum::<f64>() / 240.0;
        assert!(bright > 10.0, "view {index} shows {bright}");
        assert!(
            mean < 0.02 * bright && n_far < 80,
            "view {index}: {mean} of {bright} on average, {n_far} pixels far off"
        );
    }
}

#[test]
fn no_ray_leaves_the_polygonal_rooms_and_no_floor_or_ceiling_reaches_beyond_them() {
    let scene = Scene::load(&root().join("scenes/rooms/polygon_rooms.toml")).unwrap();
    let (building, ..) = baked(&scene, &[]);
    let seen_m = |from: [f64; 3], ray: [f64; 3]| {
        let seen = building.panels.iter().filter_map(|panel| panel.seen_along(from.into(), ray.into()));
        seen.fold(f64::INFINITY, f64::min)
    };
    for place in [[1.5, 1.4, 0.3], [3.6, 4.2, 1.0], [4.8, 0.4, 2.2], [6.7, 1.0, 0.6], [6.8, 0.6, 1.1], [8.5, -0.2, 0.3]]
    {
        for idx in 0..4_000 {
            // Directions spread over the sphere by the golden angle. Where a ray meets the seam of two faces, one a little higher does not.
            let z = 1.0 - (2.0 * f64::from(idx) + 1.0) / 4_000.0;
            let (angle, flat) = (f64::from(idx) * 2.399_963, (1.0 - z * z).sqrt());
            let seen_m = [0.0, 0.004]
                .map(|up| seen_m(place, [flat * angle.cos(), flat * angle.sin(), z + up]))
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            assert!(seen_m < 10.0, "from {place:?}, angle {angle}, rise {z}: {seen_m}");
        }
    }
    let polygons: Vec<&Vec<[f64; 2]>> =
        scene.building.rooms.iter().filter_map(|room| room.corners_m.as_ref()).collect();
    for (x_m, y_m) in
        (0..250).flat_map(|i| (0..170).map(move |j| (2.513 + 0.0307 * f64::from(i), -1.983 + 0.0409 * f64::from(j))))
    {
        // A ray from within a polygon meets it an odd number of times; here it is looked at from outside by the sum of the angles to its corners.
        let winds = |corners_m: &Vec<[f64; 2]>| {
            let angle = |corner: [f64; 2]| (corner[1] - y_m).atan2(corner[0] - x_m);
            let turns = (0..corners_m.len()).map(|index| {
                let turn = angle(corners_m[(index + 1) % corners_m.len()]) - angle(corners_m[index]);
                (turn + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
            });
            turns.sum::<f64>().abs() > 3.0
        };
        for (room, corners_m) in polygons.iter().enumerate() {
            for (part, way) in [(Part::Floor, -1.0), (Part::Ceiling, 1.0)] {
                let panels = building.panels.iter().filter(|panel| panel.part == part && panel.room == room + 1);
                let is_seen =
                    panels.filter_map(|panel| panel.seen_along([x_m, y_m, 1.0].into(), [0.0, 0.0, way].into())).count();
                assert_eq!(is_seen, usize::from(winds(corners_m)), "{part:?} of room {room} at ({x_m}, {y_m})");
            }
        }
    }
}

#[test]
fn a_slanted_wall_stops_the_robot_at_its_bodys_radius() {
    // The wall at the far end is along x − y = 6 from (6, 0) to (9, 3), and the robot comes along y = 1.5 m.
    let corners = json!([{ "corners_m": [[4.1, 0.0], [6.0, 0.0], [9.0, 3.0], [4.1, 3.0]] }]);
    let mut world = nominal_world(&with_rooms(corners, json!({})));
    let (mut nearest_m, mut farthest_m) = (f64::INFINITY, 0.0_f64);
    for _ in 0..16_000 {
        let pose = world.step(command(0.5, 0.0)).pose;
        nearest_m = nearest_m.min((pose.y_m + 6.0 - pose.x_m) / 2.0_f64.sqrt());
        farthest_m = farthest_m.max(pose.x_m);
    }
    assert!((0.248..0.252).contains(&nearest_m) && farthest_m > 7.0, "{nearest_m} from the wall, at x = {farthest_m}");
}

#[test]
fn a_door_leads_from_one_arm_of_a_u_into_the_other() {
    // The arms are from x = 5 to 7 m and from 7.1 to 9 m, and the wall between them ends at y = 1 m.
    let u = [[5.0, 0.0], [9.0, 0.0], [9.0, 4.0], [7.1, 4.0], [7.1, 1.0], [7.0, 1.0], [7.0, 4.0], [5.0, 4.0]];
    let mut scene = with_rooms(json!([{ "corners_m": u }]), with_scanner());
    let ahead_m = |scene: &Scene| {
        let found_m = beams_m(scene, [6.0, 2.5]);
        // The beam along world x is turned by −0.3 rad against the heading: none is exactly along it, and the nearest is at −17°.
        (found_m[153], 0.3 - 17.0_f64.to_radians())
    };
    let (found_m, angle) = ahead_m(&scene);
    let closed_m = 1.0 / angle.cos();
    scene.building.doors[0].from_m = [7.0, 2.0];
    scene.building.doors[0].to_m = [7.0, 3.0];
    let through_m = 3.0 / angle.cos();
    let (open_m, _) = ahead_m(&scene);
    assert!((found_m - closed_m).abs() < 1e-9 && (open_m - through_m).abs() < 1e-9, "{found_m}, {open_m}");
}

#[test]
fn rooms_that_are_no_polygons_are_refused_by_what_is_wrong_with_them() {
    let cases = [
        ("corners_m = [[4.0, 0.0], [6.0, 0.0]]", "at least 3"),
        (
            "corners_m = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0]]\nwidth_m = 2.0",
            "`building.room[0].corners_m = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0]]`: stands beside `width_m`, expected one of the two",
        ),
        ("", "`building.room[0].corners_m`: missing, expected the corners of a room, or `x_m`"),
        (
            "x_m = 4.0\ny_m = 0.0\nwidth_m = 2.0",
            "`building.room[0].depth_m`: missing, expected a number from 0.5 to 200, as the room has no `corners_m`",
        ),
        (
            "corners_m = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0], [6.0, 0.0]]",
            "corners 1 and 3 are both [6, 0], expected each corner once",
        ),
        (
            "corners_m = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0], [5.96, 2.0]]",
            "the side from [6, 2] to [5.96, 2] is 0.04 m long, expected at least 0.05 m",
        ),
        (
            "corners_m = [[4.0, 0.0], [6.0, 2.0], [6.0, 0.0], [4.0, 2.0]]",
            "the sides from [4, 0] to [6, 2] and from [6, 0] to [4, 2] cross or touch, expected sides that meet at the corners alone",
        ),
        (
            "corners_m = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0], [5.0, 0.0], [4.0, 2.0]]",
            "the sides from [4, 0] to [6, 0] and from [6, 2] to [5, 0] cross or touch",
        ),
        (
            "corners_m = [[4.0, 0.0], [6.0, 0.0], [5.0, 0.0], [4.0, 2.0]]",
            "the sides from [4, 0] to [6, 0] and from [6, 0] to [5, 0] cross or touch",
        ),
        ("corners_m = [[4.0, 0.0], [4.8, 0.0], [4.8, 0.3]]", "has an area of 0.12 m², expected at least 0.25 m²"),
        ("corners_m = [[4.0, 0.0], [300.0, 0.0], [6.0, 2.0]]", "the building is 300.0 m long from room to room"),
    ];
    for (index, (keys, part)) in cases.into_iter().enumerate() {
        let text = blind_scene(0.1, &format!("[[building.room]]\n{keys}\n"));
        assert_refused(&format!("no_polygon_{index}"), text, &["building.room[0]", part]);
    }
}

#[test]
fn a_rectangular_room_is_written_as_before_there_were_polygons() {
    let rooms = json!([{ "x_m": 4.1, "y_m": 0.0, "width_m": 3.0, "depth_m": 2.0 }, { "corners_m": L_M }]);
    let written = serde_json::to_value(with_rooms(rooms, json!({}))).unwrap();
    let expected = json!([
        { "x_m": 4.1, "y_m": 0.0, "heading_deg": 0.0, "width_m": 3.0, "depth_m": 2.0 },
        { "corners_m": L_M },
    ]);
    assert_eq!(written["building"]["room"], expected);
}

#[test]
fn every_side_of_a_polygon_is_a_direction_of_walls() {
    let slanted = json!([{ "corners_m": [[4.1, 0.0], [6.0, 0.0], [9.0, 3.0], [4.1, 2.5]] }]);
    let directions_deg = with_rooms(slanted, json!({})).mapped_wall_directions_deg();
    let expected_deg = [0.0, 0.0, 45.0, (0.5_f64 / 4.9).atan().to_degrees()];
    assert_eq!(directions_deg.len(), expected_deg.len(), "{directions_deg:?}");
    for (found, expected) in directions_deg.iter().zip(expected_deg) {
        assert!((found - expected).abs() < 1e-9, "{directions_deg:?}");
    }
}
