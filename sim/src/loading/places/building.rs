//! Contradictions of a scene about lamps, doors, pictures, dots and lenses.

use crate::{
    devices::camera::DrawnCamera,
    loading::contradiction::Contradiction,
    optics::Lens,
    place::building::{
        Enclosure, LEAST_BETWEEN_DOORS_M, Side, between_doors_m, enclosures, leads_into_a_room, level, standing_walls,
    },
    scene::{Door, Lamp, LampKind, MAX_LAMPS, Scene},
};
use localizer::reading::Camera;
use nalgebra::Point3;

/// Greatest length and width of all rooms together, which is that of the largest single room, and the distance outside of the robot's room up to
/// which a lamp may be when there are further rooms. The occupancy grid of a building this large has 16 million cells of 5 cm.
const SITE_M: f64 = 200.0;

/// Tolerance for rounding when distances are compared, as results like 2.24 − 2.1 are not exact.
const ROUNDING_M: f64 = 1e-9;

/// All contradictions in `scene` about its building, its light and its cameras' heights and lenses.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    if scene.lamps.len() > MAX_LAMPS {
        let expected = format!("{} of them, expected at most {MAX_LAMPS}", scene.lamps.len());
        found.push(Contradiction { key: "lamp".to_owned(), expected });
    }
    let rooms = enclosures(scene);
    let walls = standing_walls(&rooms);
    let ceiling_m = scene.building.ceiling_height_m;
    for (index, lamp) in scene.lamps.iter().enumerate() {
        found.extend(
            lamp_problem(scene, &rooms, &walls, lamp)
                .map(|(key, expected)| Contradiction { key: format!("lamp[{index}].{key}"), expected }),
        );
    }
    distant_rooms(scene, &rooms, found);
    doors(scene, &rooms, &walls, found);
    for (index, picture) in scene.building.pictures.iter().enumerate() {
        if picture.from_m == picture.to_m {
            let expected = "expected another place than `from_m`, as a picture has a width".to_owned();
            found.push(Contradiction { key: format!("building.picture[{index}].to_m"), expected });
        }
        for (key, foot_m) in [("from_m", picture.from_m), ("to_m", picture.to_m)] {
            if is_off(&walls, foot_m) {
                let expected = off_walls("hangs", &rooms, foot_m);
                found.push(Contradiction { key: format!("building.picture[{index}].{key}"), expected });
            }
        }
        if picture.bottom_m >= ceiling_m {
            let expected = format!("expected less than the ceiling's height, {ceiling_m} m");
            found.push(Contradiction { key: format!("building.picture[{index}].bottom_m"), expected });
        } else if picture.bottom_m + picture.height_m > ceiling_m {
            let expected = format!("reaches above the ceiling, expected at most {:.3}", ceiling_m - picture.bottom_m);
            found.push(Contradiction { key: format!("building.picture[{index}].height_m"), expected });
        }
        if let Some([columns, rows]) = picture.chessboard {
            let width_m = (picture.to_m[0] - picture.from_m[0]).hypot(picture.to_m[1] - picture.from_m[1]);
            let least_m = picture.height_m / f64::from(rows + 2) * f64::from(columns + 2);
            if width_m < least_m - 1e-9 {
                let expected = format!(
                    "expected a picture at least {least_m:.4} m wide, as its {} squares and margins across are as wide as {} are high",
                    columns + 2,
                    rows + 2
                );
                found.push(Contradiction { key: format!("building.picture[{index}].chessboard"), expected });
            }
        }
    }
    for (index, dot) in scene.building.dots.iter().enumerate() {
        if !is_in_a_room(&rooms, [dot.x_m, dot.y_m]) {
            let expected = "lies in no room, expected a place within one".to_owned();
            found.push(Contradiction { key: format!("building.dot[{index}].x_m"), expected });
        }
        if dot.height_m.is_some_and(|height_m| height_m >= ceiling_m) {
            let expected = format!("expected less than the ceiling's height, {ceiling_m} m");
            found.push(Contradiction { key: format!("building.dot[{index}].height_m"), expected });
        }
    }
    if scene.light.illuminance_at_camera_lux.is_some() && scene.robot.forward_camera.is_none() {
        let expected = "stands without `[robot.forward_camera]`, at whose lens it is measured".to_owned();
        found.push(Contradiction { key: "light.illuminance_at_camera_lux".to_owned(), expected });
    }
    let cameras = [
        ("forward", scene.robot.forward_camera.as_ref().map(|camera| camera.height_m)),
        ("ceiling", scene.robot.ceiling_camera.as_ref().map(|camera| camera.height_m)),
    ];
    for (name, height_m) in cameras {
        if height_m.is_some_and(|height_m| height_m >= ceiling_m) {
            let expected = format!("expected less than the ceiling's height, {ceiling_m} m");
            found.push(Contradiction { key: format!("robot.{name}_camera.height_m"), expected });
        }
    }
    lenses(scene, found);
}

/// Finds further rooms with which the building becomes longer or wider than a site.
fn distant_rooms(scene: &Scene, rooms: &[Enclosure], found: &mut Vec<Contradiction>) {
    let mut extents_m = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for (index, room) in rooms.iter().enumerate() {
        for (axis, name) in ["x_m", "y_m"].into_iter().enumerate() {
            let [mut low_m, mut high_m] = extents_m[axis];
            for corner in room.sides().map(|side| side.from) {
                (low_m, high_m) = (low_m.min(corner[axis]), high_m.max(corner[axis]));
            }
            if high_m - low_m > SITE_M + ROUNDING_M && index > 0 {
                let expected = format!(
                    "the building is {:.1} m long from room to room, expected at most {SITE_M} m",
                    high_m - low_m
                );
                let name = if scene.building.rooms[index - 1].corners_m.is_some() { "corners_m" } else { name };
                found.push(Contradiction { key: format!("building.room[{}].{name}", index - 1), expected });
            } else {
                extents_m[axis] = [low_m, high_m];
            }
        }
    }
}

/// Finds doors without a width, doors off the walls, doors higher than a wall, open doors that lead nowhere, and open doors that run into others.
fn doors(scene: &Scene, rooms: &[Enclosure], walls: &[Side], found: &mut Vec<Contradiction>) {
    for (index, door) in scene.building.doors.iter().enumerate() {
        if door.from_m == door.to_m {
            let expected = "expected another place than `from_m`, as a door has a width".to_owned();
            found.push(Contradiction { key: format!("building.door[{index}].to_m"), expected });
        }
        for (key, jamb_m) in [("from_m", door.from_m), ("to_m", door.to_m)] {
            if is_off(walls, jamb_m) {
                let expected = off_walls("stands", rooms, jamb_m);
                found.push(Contradiction { key: format!("building.door[{index}].{key}"), expected });
            }
        }
        let is_placed = door.from_m != door.to_m && ![door.from_m, door.to_m].iter().any(|jamb| is_off(walls, *jamb));
        if door.open && is_placed && !leads_into_a_room(door, rooms) {
            let expected =
                "leads into no room, expected a `[[building.room]]` behind the wall at its feet, or false".to_owned();
            found.push(Contradiction { key: format!("building.door[{index}].open"), expected });
        }
        if door.height_m >= scene.building.ceiling_height_m {
            let expected = format!("expected less than the ceiling's height, {} m", scene.building.ceiling_height_m);
            found.push(Contradiction { key: format!("building.door[{index}].height_m"), expected });
        }
        let is_crowded = |other: &Door| {
            let is_near = |between_m| between_m < LEAST_BETWEEN_DOORS_M - ROUNDING_M;
            (door.open || other.open) && between_doors_m(rooms, door, other).is_some_and(is_near)
        };
        if let Some(other) = scene.building.doors[..index].iter().position(is_crowded) {
            let expected = format!(
                "in or by building.door[{other}], expected {LEAST_BETWEEN_DOORS_M} m of wall between an open door and another \
                 one, for their frames"
            );
            found.push(Contradiction { key: format!("building.door[{index}].from_m"), expected });
        }
    }
}

/// Greatest distance from the nearest wall of a thing that is stated to be on a wall.
const ON_WALL_M: f64 = 0.3;

/// Distance on the floor from a place to the nearest of the given walls.
fn off_m<'a>(walls: impl Iterator<Item = &'a Side>, [x_m, y_m]: [f64; 2]) -> f64 {
    let at = Point3::new(x_m, y_m, 0.0);
    let to_wall = |wall: &Side| {
        let way = wall.to - wall.from;
        let share = ((at - wall.from).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        (at - (wall.from + way * share)).norm()
    };
    walls.map(to_wall).fold(f64::INFINITY, f64::min)
}

pub(super) fn is_off(walls: &[Side], at_m: [f64; 2]) -> bool {
    off_m(walls.iter(), at_m) > ON_WALL_M
}

/// Describes what is wrong with a place that is off the walls. If the place is on the side of a room, within another room, the text says why there is
/// no wall.
pub(super) fn off_walls(does: &str, rooms: &[Enclosure], at_m: [f64; 2]) -> String {
    let sides: Vec<Side> = rooms.iter().flat_map(Enclosure::sides).collect();
    let within = if is_off(&sides, at_m) { "" } else { ": within another room a room has none" };
    format!("{does} on no wall{within}, expected a place within {ON_WALL_M} m of one")
}

/// Whether a place lies within one of the rooms, or on its walls.
pub(super) fn is_in_a_room(rooms: &[Enclosure], [x_m, y_m]: [f64; 2]) -> bool {
    rooms.iter().any(|room| room.contains(Point3::new(x_m, y_m, 0.0)))
}

/// Whether a wall that faces in the direction `heading_rad` is near the place.
fn is_on_a_wall_facing(walls: &[Side], at_m: [f64; 2], heading_rad: f64) -> bool {
    let facing = level(heading_rad);
    off_m(walls.iter().filter(|wall| wall.inward.dot(&facing) > 0.9), at_m) <= ON_WALL_M
}

fn lamp_problem(scene: &Scene, rooms: &[Enclosure], walls: &[Side], lamp: &Lamp) -> Option<(&'static str, String)> {
    let ceiling_m = scene.building.ceiling_height_m;
    if lamp.lumens.is_some() && lamp.illuminance_at_floor_lux.is_some() {
        return Some(("illuminance_at_floor_lux", "stands beside `lumens`, expected one of the two".to_owned()));
    }
    if lamp.height_m.is_some_and(|height_m| height_m >= ceiling_m) {
        return Some(("height_m", format!("expected less than the ceiling's height, {ceiling_m} m")));
    }
    let (middle_m, [_, height_m]) = (lamp.height_m.unwrap_or(1.5), lamp.size_m.unwrap_or([1.4, 1.2]));
    if lamp.kind == LampKind::Window && (middle_m + height_m / 2.0 > ceiling_m || middle_m < height_m / 2.0) {
        return Some(("size_m", format!("the window reaches beyond its wall, which ends at 0 and {ceiling_m} m")));
    }
    let at_m = [lamp.x_m, lamp.y_m];
    if lamp.kind == LampKind::Window && !is_on_a_wall_facing(walls, at_m, lamp.heading_deg.to_radians()) {
        let expected = format!(
            "no wall within {ON_WALL_M} m faces that way, expected the direction in which a window's wall faces"
        );
        return Some(("heading_deg", expected));
    }
    let widest_m = rooms.iter().map(|room| room.width_m.max(room.depth_m)).fold(0.0, f64::max);
    if lamp.size_m.is_some_and(|size_m| size_m.iter().any(|side_m| *side_m > widest_m)) {
        return Some(("size_m", format!("larger than the widest room, expected at most {widest_m} m")));
    }
    let room_m = [scene.room.width_m, scene.room.depth_m];
    let least_m = if scene.building.rooms.is_empty() { 0.0 } else { -SITE_M };
    for (key, at_m, extent_m) in [("x_m", lamp.x_m, room_m[0]), ("y_m", lamp.y_m, room_m[1])] {
        if at_m < least_m || at_m > extent_m - least_m {
            return Some((
                key,
                format!("outside the building, expected a number from {} to {}", least_m, extent_m - least_m),
            ));
        }
    }
    (lamp.kind != LampKind::Window && !is_in_a_room(rooms, at_m))
        .then(|| ("x_m", "lies in no room, expected a place within one".to_owned()))
}

/// Finds lenses whose principal point is outside the image, or whose distortion folds the image over. The corners and edges, where this happens
/// first, are among the 25 pixels that are tested.
fn lenses(scene: &Scene, found: &mut Vec<Contradiction>) {
    for camera in Camera::ALL.into_iter().filter_map(|name| scene.robot.camera(name)) {
        let key = format!("robot.{}_camera", camera.name().as_str());
        let lens = Lens::of(camera, &DrawnCamera::nominal(camera));
        let [width, height] = lens.size_px.map(|size| f64::from(size) - 1.0);
        let places = [0.0, 0.25, 0.5, 0.75, 1.0];
        let folds = places.iter().any(|s| places.iter().any(|t| lens.ray([s * width, t * height]).is_none()));
        let axis_px = lens.principal_point_px;
        if (0..2).any(|axis| !(0.0..=f64::from(lens.size_px[axis])).contains(&axis_px[axis])) {
            let expected =
                format!("lies outside the image, expected a place within {} × {}", lens.size_px[0], lens.size_px[1]);
            found.push(Contradiction { key: format!("{key}.principal_point_px"), expected });
        }
        if folds {
            let expected =
                "folds the image over within its edges, expected a distortion that grows outwards".to_owned();
            found.push(Contradiction { key: format!("{key}.lens.distortion"), expected });
        }
    }
}
