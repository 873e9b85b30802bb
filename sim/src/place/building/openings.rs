//! Open doors between rooms, through which the room behind is seen.

use super::{
    raised,
    walls::{DOOR_TO_WALL_M, Enclosure, on_side},
};
use crate::scene::Door;

/// Whether there is a room behind an open door, so that the door is an opening through which that room is seen.
pub(crate) fn leads_into_a_room(door: &Door, rooms: &[Enclosure]) -> bool {
    // Distance behind the door at which the other room is looked for: beyond both walls where two rooms stand back to back.
    const BEYOND_M: f64 = 2.0 * DOOR_TO_WALL_M + 0.05;
    let middle = raised([0, 1].map(|axis| (door.from_m[axis] + door.to_m[axis]) / 2.0), 0.0);
    // A door may lead into the room itself, if that is not convex.
    rooms.iter().any(|room| {
        room.sides().filter(|side| on_side(door, side).is_some()).any(|side| {
            let behind = middle - side.inward * BEYOND_M;
            rooms.iter().any(|other| other.contains(behind))
        })
    })
}
