//! Holes between rooms: open doors, and where rooms run into each other.

use super::{
    raised,
    walls::{DOOR_TO_WALL_M, Enclosure, Side, on_side, others},
};
use crate::scene::{Door, Scene};

/// A hole between two rooms through which light passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Numbers of the rooms, the lesser first.
    pub rooms: [usize; 2],
    /// Area.
    pub area_m2: f64,
}

/// Open doors, and where rooms run into each other.
pub(crate) fn openings(scene: &Scene, rooms: &[Enclosure]) -> Vec<Opening> {
    let length_m = |side: &Side, [from, to]: [f64; 2]| (to - from) * (side.to - side.from).norm();
    let pairs = (0..rooms.len()).flat_map(|one| (one + 1..rooms.len()).map(move |other| [one, other]));
    let mut found = Vec::new();
    for pair in pairs {
        let [one, other] = pair.map(|index| &rooms[index]);
        // What of one room's walls is left out within the other one; a straight cut has the same on both sides.
        let within = |room: &Enclosure, other: &Enclosure| -> f64 {
            room.sides().filter_map(|side| Some(length_m(&side, other.covers(&side, false)?))).sum()
        };
        let seam_m2 = within(one, other).min(within(other, one)) * one.height_m;
        let doors_m2 = scene.building.doors.iter().filter(|door| door.open).filter_map(|door| {
            let width_m = |room: &Enclosure| room.sides().find_map(|side| Some(length_m(&side, on_side(door, &side)?)));
            Some(width_m(one)?.min(width_m(other)?) * door.height_m)
        });
        let area_m2 = seam_m2 + doors_m2.sum::<f64>();
        if area_m2 > 0.0 {
            found.push(Opening { rooms: pair, area_m2 });
        }
    }
    found
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
