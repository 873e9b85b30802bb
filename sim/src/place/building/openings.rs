//! Openings between rooms: open doors, and places where rooms run into each other.

use nalgebra::{Point3, vector};

use super::{
    raised,
    walls::{DOOR_TO_WALL_M, Enclosure, Side, on_side, others},
};
use crate::scene::{Door, Scene};

/// An opening between two rooms through which light passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Indices of the two rooms that the opening connects, the smaller index first.
    pub rooms: [usize; 2],
    /// Total area of the opening.
    pub area_m2: f64,
    /// Upright rectangles that the opening consists of, each as its corners in order, world frame.
    pub holes: Vec<[Point3<f64>; 4]>,
}

/// Finds the openings between all pairs of rooms: open doors, and places where rooms run into each other.
pub(crate) fn openings(scene: &Scene, rooms: &[Enclosure]) -> Vec<Opening> {
    let pairs = (0..rooms.len()).flat_map(|one| (one + 1..rooms.len()).map(move |other| [one, other]));
    let mut found = Vec::new();
    for pair in pairs {
        let [one, other] = pair.map(|index| &rooms[index]);
        // Of one room, the parts of its walls that do not exist because they lie within the other room. Where the line along which the two rooms
        // meet is straight, both rooms give the same parts.
        let within = |room: &Enclosure, other: &Enclosure| -> Vec<[Point3<f64>; 4]> {
            room.sides().filter_map(|side| Some(hole(&side, other.covers(&side, false)?, room.height_m))).collect()
        };
        let seams = [within(one, other), within(other, one)];
        let seam_m2 = seams.iter().map(|holes| area_m2(holes)).fold(f64::INFINITY, f64::min);
        let doors = scene.building.doors.iter().filter(|door| door.open).filter_map(|door| {
            let on = |room: &Enclosure| {
                room.sides().find_map(|side| Some(hole(&side, on_side(door, &side)?, door.height_m)))
            };
            on(one).zip(on(other)).map(|(hole, _)| hole)
        });
        let doors: Vec<_> = doors.collect();
        let opening =
            Opening { rooms: pair, area_m2: seam_m2 + area_m2(&doors), holes: [seams[0].clone(), doors].concat() };
        if opening.area_m2 > 0.0 {
            found.push(opening);
        }
    }
    found
}

/// The upright rectangle on a room's side between two points of that side, given as shares of its length, from the floor up to a height.
fn hole(side: &Side, [from, to]: [f64; 2], height_m: f64) -> [Point3<f64>; 4] {
    let way = side.to - side.from;
    let up = vector![0.0, 0.0, height_m];
    let feet = [side.from + way * from, side.from + way * to];
    [feet[0], feet[1], feet[1] + up, feet[0] + up]
}

fn area_m2(holes: &[[Point3<f64>; 4]]) -> f64 {
    holes.iter().map(|[first, second, _, last]| (second - first).norm() * (last - first).norm()).sum()
}

/// Whether there is another room behind an open door, so that the door is an opening through which that room is seen.
pub(crate) fn leads_into_a_room(door: &Door, rooms: &[Enclosure]) -> bool {
    // Distance behind the door at which the other room is looked for: beyond both walls where two rooms stand back to back.
    const BEYOND_M: f64 = 2.0 * DOOR_TO_WALL_M + 0.05;
    let middle = raised([0, 1].map(|axis| (door.from_m[axis] + door.to_m[axis]) / 2.0), 0.0);
    rooms.iter().enumerate().any(|(index, room)| {
        room.sides().filter(|side| on_side(door, side).is_some()).any(|side| {
            let behind = middle - side.inward * BEYOND_M;
            others(rooms, index).any(|(_, other)| other.contains(behind))
        })
    })
}
