//! Contradictions about the shapes of further rooms: rectangles and polygons that are none.

use nalgebra::Vector2;

use crate::{
    loading::contradiction::Contradiction,
    place::building::Polygon,
    scene::{FurtherRoom, Scene},
};

use super::{short, things::distance_m};

/// Least length of a side of a polygonal room.
const SHORTEST_SIDE_M: f64 = 0.05;
/// Least area of a polygonal room.
const LEAST_AREA_M2: f64 = 0.25;
/// Distance between two sides of a polygonal room up to which they touch: nothing goes through there.
const TOUCH_M: f64 = 0.001;

/// All contradictions in `scene` about the shapes of its further rooms. Nothing else of the building can be told before there are none.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    for (index, room) in scene.building.rooms.iter().enumerate() {
        let problem = match &room.corners_m {
            None => incomplete(room),
            Some(corners_m) => beside_corners(room).or_else(|| misshapen(corners_m)).map(|it| ("corners_m", it)),
        };
        found.extend(
            problem.map(|(key, expected)| Contradiction { key: format!("building.room[{index}].{key}"), expected }),
        );
    }
}

/// What a room without corners lacks of a rectangle.
fn incomplete(room: &FurtherRoom) -> Option<(&'static str, String)> {
    let keys = [("x_m", room.x_m), ("y_m", room.y_m), ("width_m", room.width_m), ("depth_m", room.depth_m)];
    let (missing, _) = keys.iter().find(|(_, value)| value.is_none())?;
    if keys.iter().all(|(_, value)| value.is_none()) {
        let expected =
            "missing, expected the corners of a room, or `x_m`, `y_m`, `width_m` and `depth_m` of a rectangle";
        return Some(("corners_m", expected.to_owned()));
    }
    let number = if missing.ends_with("y_m") || *missing == "x_m" { "" } else { " from 0.5 to 200" };
    Some((missing, format!("missing, expected a number{number}, as the room has no `corners_m`")))
}

/// Tells that a room states keys of a rectangle beside its corners.
fn beside_corners(room: &FurtherRoom) -> Option<String> {
    let keys = [
        ("x_m", room.x_m),
        ("y_m", room.y_m),
        ("heading_deg", room.heading_deg),
        ("width_m", room.width_m),
        ("depth_m", room.depth_m),
    ];
    let (key, _) = keys.into_iter().find(|(_, value)| value.is_some())?;
    Some(format!("stands beside `{key}`, expected one of the two: the corners of a room, or the keys of a rectangle"))
}

/// What keeps a list of corners from being a simple polygon of the size of a room.
fn misshapen(corners_m: &[[f64; 2]]) -> Option<String> {
    let count = corners_m.len();
    let corner = |index: usize| Vector2::from(corners_m[index % count]);
    let text = |index: usize| {
        let [x_m, y_m] = corners_m[index % count];
        format!("[{x_m}, {y_m}]")
    };
    let pairs = || (0..count).flat_map(|one| (one + 1..count).map(move |other| (one, other)));
    if let Some((one, other)) = pairs().find(|(one, other)| corner(*one) == corner(*other)) {
        let expected = format!("corners {one} and {other} are both {}, expected each corner once", text(one));
        return Some(expected);
    }
    let length_m = |side: usize| (corner(side + 1) - corner(side)).norm();
    if let Some(side) = (0..count).find(|side| length_m(*side) < SHORTEST_SIDE_M - 1e-9) {
        return Some(format!(
            "the side from {} to {} is {} m long, expected at least {SHORTEST_SIDE_M} m",
            text(side),
            text(side + 1),
            short(length_m(side))
        ));
    }
    let meet = |(one, other): &(usize, usize)| {
        let [side, beside] = [*one, *other].map(|side| [corner(side), corner(side + 1)]);
        // Sides with a common corner touch elsewhere where the farther corner of either is on the other.
        if one + 1 == *other || (one + other + 1) % count == 0 && *one == 0 {
            let [before, after] = if one + 1 == *other { [side, beside] } else { [beside, side] };
            return distance_m([before[0]; 2], after) < TOUCH_M || distance_m([after[1]; 2], before) < TOUCH_M;
        }
        distance_m(side, beside) < TOUCH_M
    };
    if let Some((one, other)) = pairs().find(meet) {
        let side = |side: usize| format!("from {} to {}", text(side), text(side + 1));
        return Some(format!(
            "the sides {} and {} cross or touch, expected sides that meet at the corners alone",
            side(one),
            side(other)
        ));
    }
    let area_m2 = Polygon::new(corners_m).area_m2();
    (area_m2 < LEAST_AREA_M2 - 1e-9)
        .then(|| format!("has an area of {} m², expected at least {LEAST_AREA_M2} m²", short(area_m2)))
}
