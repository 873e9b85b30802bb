//! Contradictions about furniture, landmarks and people: places outside every room, and paths through walls and furniture.

use crate::{
    loading::contradiction::Contradiction,
    place::building::{Doorway, Enclosure, GroundPlan, Panel, enclosures, wall_panels},
    scene::{Furniture, Person, Scene, Station},
};
use nalgebra::Vector2;

use super::short;

use super::building::is_in_a_room;

/// Tolerance for rounding when distances are compared, as results like 0.4 − 0.15 are not exact.
const ROUNDING_M: f64 = 1e-9;

/// All contradictions in `scene` about what stands and walks in the building.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let (rooms, plan) = (enclosures(scene), GroundPlan::of(scene));
    let floor = Floor { rooms: &rooms, doorways: plan.doorways() };
    for (index, furniture) in scene.furniture.iter().enumerate() {
        found.extend(place_problem(&floor, &format!("furniture[{index}]"), [furniture.x_m, furniture.y_m]));
    }
    for (index, landmark) in scene.landmarks.iter().enumerate() {
        found.extend(place_problem(&floor, &format!("landmark[{index}]"), [landmark.x_m, landmark.y_m]));
    }
    let walls = wall_panels(scene, &rooms);
    for (index, person) in scene.people.iter().enumerate() {
        let expected = person_problem(&floor, &walls, person)
            .or_else(|| meets_furniture(scene, person))
            .or_else(|| meets_start(scene, person));
        found.extend(expected.map(|expected| Contradiction { key: format!("person[{index}].waypoints_m"), expected }));
    }
}

/// Where things stand and people walk: the floors of rooms, and those of the open doors between them.
struct Floor<'a> {
    rooms: &'a [Enclosure],
    doorways: &'a [Doorway],
}

impl Floor<'_> {
    fn contains(&self, at_m: [f64; 2]) -> bool {
        is_in_a_room(self.rooms, at_m) || self.doorways.iter().any(|door| door.contains(at_m.into()))
    }
}

fn place_problem(floor: &Floor<'_>, key: &str, at_m: [f64; 2]) -> Option<Contradiction> {
    if floor.contains(at_m) {
        return None;
    }
    let rooms = floor.rooms;
    let own = &rooms[0];
    let extents_m = [own.width_m, own.depth_m];
    // The coordinate axis along which the position is outside the robot's room, if there is one.
    let axis = (0..2).find(|axis| !(0.0..=extents_m[*axis]).contains(&at_m[*axis]))?;
    let further = if rooms.len() > 1 { ", or a place in a further room or an open door" } else { "" };
    let expected = format!("outside the room, expected a number from 0 to {}{further}", extents_m[axis]);
    Some(Contradiction { key: format!("{key}.{}", ["x_m", "y_m"][axis]), expected })
}

/// Describes what is wrong with where a person walks: waypoints in no room, or stretches between them that come too near to a wall. Open doors leave
/// holes in walls, between two jambs.
fn person_problem(floor: &Floor<'_>, walls: &[Panel], person: &Person) -> Option<String> {
    let ways_m = &person.waypoints_m;
    if let Some([x_m, y_m]) = ways_m.iter().find(|at_m| !floor.contains(**at_m)) {
        return Some(format!("[{x_m}, {y_m}] is in no room and no open door, expected places within one"));
    }
    let stands = walls.iter().filter(|wall| wall.corner.z < person.height_m).map(foot);
    let feet: Vec<[Vector2<f64>; 2]> = stands.chain(floor.doorways.iter().flat_map(Doorway::jambs)).collect();
    let is_near = |way: [[f64; 2]; 2]| {
        let way = way.map(Vector2::from);
        feet.iter().any(|foot| distance_m(way, *foot) < person.radius_m - ROUNDING_M)
    };
    let margin = format!("expected {} m of distance, the person's radius", person.radius_m);
    if let Some([x_m, y_m]) = ways_m.iter().find(|at_m| is_near([**at_m; 2])) {
        return Some(format!("[{x_m}, {y_m}] is a place too near to a wall, {margin}"));
    }
    let leg = ways_m.windows(2).find(|leg| is_near([leg[0], leg[1]]))?;
    let [[x0_m, y0_m], [x1_m, y1_m]] = [leg[0], leg[1]];
    Some(format!("the way from [{x0_m}, {y0_m}] to [{x1_m}, {y1_m}] comes too near to a wall, {margin}"))
}

/// Checks that no person stands in furniture or walks through it, as nobody can. A shoulder may reach over the edge of a table, so that it is the
/// middle of the body that must keep out.
fn meets_furniture(scene: &Scene, person: &Person) -> Option<String> {
    let ways_m = &person.waypoints_m;
    // A person with a single waypoint stands there.
    let stands = ways_m.first().map(|at_m| [*at_m; 2]);
    let legs = stands.into_iter().chain(ways_m.windows(2).map(|leg| [leg[0], leg[1]]));
    let met = |leg: [[f64; 2]; 2]| {
        let index = scene.furniture.iter().position(|piece| meets(piece, leg, 2.0 * ROUNDING_M))?;
        Some((leg, index))
    };
    let ([[x0_m, y0_m], [x1_m, y1_m]], index) = legs.into_iter().find_map(met)?;
    Some(format!(
        "the way from [{x0_m}, {y0_m}] to [{x1_m}, {y1_m}] leads through {}, expected a way beside it",
        scene.furniture[index].told(index)
    ))
}

/// Whether a straight way leads through a piece of furniture or comes nearer to it than `keep_m`.
pub(super) fn meets(piece: &Furniture, way_m: [[f64; 2]; 2], keep_m: f64) -> bool {
    let way = way_m.map(Vector2::from);
    piece.distance_m(way_m[0]) == 0.0
        || sides(piece).into_iter().any(|side| distance_m(way, side) < keep_m - ROUNDING_M)
}

/// The four sides of a piece of furniture's footprint.
fn sides(piece: &Furniture) -> [[Vector2<f64>; 2]; 4] {
    let (sin, cos) = piece.rotation_deg.to_radians().sin_cos();
    let [along_m, across_m] = piece.size_m.map(|extent_m| 0.5 * extent_m);
    let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[one, other]: [f64; 2]| {
        let (forward_m, left_m) = (one * along_m, other * across_m);
        Vector2::new(piece.x_m + cos * forward_m - sin * left_m, piece.y_m + sin * forward_m + cos * left_m)
    });
    [0, 1, 2, 3].map(|index| [corners[index], corners[(index + 1) % 4]])
}

/// Checks that no person stands where the robot may be put down, at the start or at a station, as the physics would push each through the other from
/// the first step on.
fn meets_start(scene: &Scene, person: &Person) -> Option<String> {
    let [x_m, y_m] = *person.waypoints_m.first()?;
    let (start, keep_m) = (&scene.start, person.radius_m + scene.robot.body_radius_m);
    let put_down = match scene.stations.is_empty() {
        true if start.anywhere => Vec::new(),
        true => vec![("start", [start.x_m, start.y_m], start.tolerance_m)],
        false => {
            let tolerance_m = |station: &Station| station.tolerance_m.unwrap_or(start.tolerance_m);
            scene.stations.iter().map(|at| ("station", [at.x_m, at.y_m], tolerance_m(at))).collect()
        }
    };
    put_down.into_iter().find_map(|(name, at_m, tolerance_m)| {
        // The robot may stand anywhere in a square about the stated place.
        let away_m = [x_m - at_m[0], y_m - at_m[1]].map(|off_m| (off_m.abs() - tolerance_m).max(0.0));
        let expected = || {
            let [at_x_m, at_y_m] = at_m;
            let apart = format!("expected {} m of distance from [{at_x_m}, {at_y_m}]", short(keep_m));
            let drawn = match tolerance_m > 0.0 {
                true => format!("; the {name} is drawn within {tolerance_m} m"),
                false => String::new(),
            };
            format!("[{x_m}, {y_m}] is in the robot's {name}, {apart}, the radii of person and robot{drawn}")
        };
        (away_m[0].hypot(away_m[1]) < keep_m - ROUNDING_M).then(expected)
    })
}

/// The line along which a wall panel, a flat rectangular piece of a wall, stands on the floor.
fn foot(wall: &Panel) -> [Vector2<f64>; 2] {
    [wall.corner.coords.xy(), (wall.corner + wall.along).coords.xy()]
}

/// Least distance between two line segments in the plane.
pub(super) fn distance_m(one: [Vector2<f64>; 2], other: [Vector2<f64>; 2]) -> f64 {
    let side = |[from, to]: [Vector2<f64>; 2], at: Vector2<f64>| (to - from).perp(&(at - from));
    let parts = |line: [Vector2<f64>; 2], ends: [Vector2<f64>; 2]| side(line, ends[0]) * side(line, ends[1]) < 0.0;
    if parts(one, other) && parts(other, one) {
        return 0.0;
    }
    let from_end = |at: Vector2<f64>, [from, to]: [Vector2<f64>; 2]| {
        let along = to - from;
        let share = (at - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (at - from - along * share.clamp(0.0, 1.0)).norm()
    };
    let of_ends = [from_end(one[0], other), from_end(one[1], other), from_end(other[0], one), from_end(other[1], one)];
    of_ends.into_iter().fold(f64::INFINITY, f64::min)
}
