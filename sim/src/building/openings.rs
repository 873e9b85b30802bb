//! Holes between rooms: open doors, and where rooms run into each other.

use nalgebra::{Point3, vector};

use super::{
    raised,
    walls::{DOOR_TO_WALL_M, Enclosure, Side, on_side, others},
};
use crate::scene::{Door, Scene};

/// A hole between two rooms through which light passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Numbers of the rooms, the lesser first.
    pub rooms: [usize; 2],
    /// Area of all of it.
    pub area_m2: f64,
    /// Its upright rectangles, each by its corners in order, world.
    pub holes: Vec<[Point3<f64>; 4]>,
}

/// Open doors, and where rooms run into each other.
pub(crate) fn openings(scene: &Scene, rooms: &[Enclosure]) -> Vec<Opening> {
    let pairs = (0..rooms.len()).flat_map(|one| (one + 1..rooms.len()).map(move |other| [one, other]));
    let mut found = Vec::new();
    for pair in pairs {
        let [one, other] = pair.map(|index| &rooms[index]);
        // What of one room's walls is left out within the other one; a straight cut has the same on both sides.
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

/// The part of a side between two shares of its length, up to a height.
fn hole(side: &Side, [from, to]: [f64; 2], height_m: f64) -> [Point3<f64>; 4] {
    let way = side.to - side.from;
    let up = vector![0.0, 0.0, height_m];
    let feet = [side.from + way * from, side.from + way * to];
    [feet[0], feet[1], feet[1] + up, feet[0] + up]
}

fn area_m2(holes: &[[Point3<f64>; 4]]) -> f64 {
    holes.iter().map(|[first, second, _, last]| (second - first).norm() * (last - first).norm()).sum()
}

/// Whether an open door is a hole through which another room is seen.
pub(crate) fn leads_into_a_room(door: &Door, rooms: &[Enclosure]) -> bool {
    // Beyond both walls, where two rooms stand back to back.
    const BEYOND_M: f64 = 2.0 * DOOR_TO_WALL_M + 0.05;
    let middle = raised([0, 1].map(|axis| (door.from_m[axis] + door.to_m[axis]) / 2.0), 0.0);
    rooms.iter().enumerate().any(|(index, room)| {
        room.sides().filter(|side| on_side(door, side).is_some()).any(|side| {
            let behind = middle - side.inward * BEYOND_M;
            others(rooms, index).any(|(_, other)| other.contains(behind))
        })
    })
}
