//! Rooms and their walls. A wall is left out where another room is, and has an opening where a door stands open.

use nalgebra::{Point3, Vector3, vector};

use super::{LAYER_M, Material, Panel, Part, Texture, level, raised};
use crate::scene::{Door, Scene};

/// Greatest distance on the floor plan between a door and a wall at which the door still counts as a door in that wall.
pub(super) const DOOR_TO_WALL_M: f64 = 0.15;

/// A rectangular room.
#[derive(Clone, Debug, PartialEq)]
pub struct Enclosure {
    /// One corner of the room, on the floor, world frame.
    pub corner: Point3<f64>,
    /// Direction of the room's first side, of length `width_m`, measured from world x; the second side is a quarter turn to its left.
    pub heading_rad: f64,
    /// Length of the room's first side.
    pub width_m: f64,
    /// Length of the room's second side.
    pub depth_m: f64,
    /// Height of the room's ceiling.
    pub height_m: f64,
}

/// One side of a room, as a line on the floor with the room on its left.
pub(crate) struct Side {
    pub(crate) from: Point3<f64>,
    pub(crate) to: Point3<f64>,
    pub(crate) inward: Vector3<f64>,
}

impl Enclosure {
    /// Whether a point is within the room's walls, whatever its height.
    pub fn contains(&self, at: Point3<f64>) -> bool {
        // A point on a wall counts as inside, however its coordinates are rounded.
        self.sides().all(|side| side.inward.dot(&(at - side.from)) >= -1e-9)
    }

    pub(crate) fn axes(&self) -> [Vector3<f64>; 2] {
        let along = level(self.heading_rad);
        [along * self.width_m, vector![-along.y, along.x, 0.0] * self.depth_m]
    }

    pub(crate) fn sides(&self) -> impl Iterator<Item = Side> + use<> {
        let [along, across] = self.axes();
        let corners = [self.corner, self.corner + along, self.corner + along + across, self.corner + across];
        (0..4).map(move |index| {
            let (from, to) = (corners[index], corners[(index + 1) % 4]);
            let direction = (to - from).normalize();
            Side { from, to, inward: vector![-direction.y, direction.x, 0.0] }
        })
    }

    /// The part of another room's side that lies within this room, as shares of the side's length from 0 to 1. A wall that both rooms have in
    /// common counts as inside if this room comes first in the list.
    pub(super) fn covers(&self, side: &Side, is_first: bool) -> Option<[f64; 2]> {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for own in self.sides() {
            let (start, end) = (own.inward.dot(&(side.from - own.from)), own.inward.dot(&(side.to - own.from)));
            // A side of another room that only touches this room is not inside it, unless it is the same wall.
            const TOUCH_M: f64 = 1e-6;
            let is_same_wall = is_first && own.inward.dot(&side.inward) > 1.0 - 1e-9;
            let inside_m = if is_same_wall { -TOUCH_M } else { TOUCH_M };
            let (start, end) = (start - inside_m, end - inside_m);
            match (start > 0.0, end > 0.0) {
                (true, true) => {}
                (false, false) => return None,
                (true, false) => high = high.min(start / (start - end)),
                (false, true) => low = low.max(start / (start - end)),
            }
        }
        (low < high).then_some([low, high])
    }
}

/// The rooms of a scene, the robot's own room first. For a scene in which walls have been turned to where they truly stand, they are the true
/// rooms.
pub(crate) fn enclosures(scene: &Scene) -> Vec<Enclosure> {
    let (height_m, plan) = (scene.building.ceiling_height_m, scene.plan());
    let own = Enclosure {
        corner: raised(plan.stands([0.0; 2]), 0.0),
        heading_rad: plan.turn_rad,
        width_m: scene.room.width_m,
        depth_m: scene.room.depth_m,
        height_m,
    };
    let further = scene.building.rooms.iter().map(|room| Enclosure {
        corner: raised([room.x_m, room.y_m], 0.0),
        heading_rad: room.heading_deg.to_radians(),
        width_m: room.width_m,
        depth_m: room.depth_m,
        height_m,
    });
    std::iter::once(own).chain(further).collect()
}

/// Flat faces (panels) of the building's geometry for the walls of all rooms, with their skirting boards.
pub(crate) fn wall_panels(scene: &Scene, rooms: &[Enclosure]) -> Vec<Panel> {
    let mut panels = Vec::new();
    for (index, room) in rooms.iter().enumerate() {
        for side in room.sides() {
            let mut gaps = covered(rooms, index, &side);
            let doors: Vec<(&Door, [f64; 2])> = scene
                .building
                .doors
                .iter()
                .filter(|door| door.open)
                .filter_map(|door| Some((door, on_side(door, &side)?)))
                .collect();
            for (door, shares) in &doors {
                panels.extend(face(scene, &side, *shares, [door.height_m, room.height_m], index));
            }
            gaps.extend(doors.iter().map(|(_, shares)| *shares));
            for shares in remaining(gaps) {
                panels.extend(face(scene, &side, shares, [0.0, room.height_m], index));
            }
        }
    }
    panels
}

/// The parts of the rooms' walls that exist, whether or not there are doors in them: a wall is left out where another room is.
pub(crate) fn standing_walls(rooms: &[Enclosure]) -> Vec<Side> {
    let of_room = |(index, room): (usize, &Enclosure)| -> Vec<Side> {
        let of_side = |side: Side| -> Vec<Side> {
            let at = |share: f64| side.from + (side.to - side.from) * share;
            let stands = remaining(covered(rooms, index, &side)).into_iter();
            stands.map(|[from, to]| Side { from: at(from), to: at(to), inward: side.inward }).collect()
        };
        room.sides().flat_map(of_side).collect()
    };
    rooms.iter().enumerate().flat_map(of_room).collect()
}

/// The parts of a room's side on which there is no wall because another room is there, as shares of the side's length.
pub(super) fn covered(rooms: &[Enclosure], index: usize, side: &Side) -> Vec<[f64; 2]> {
    others(rooms, index).filter_map(|(other, room)| room.covers(side, other < index)).collect()
}

/// Flat faces (panels) of the building's geometry for the ceilings of all rooms.
pub(super) fn ceiling_panels(scene: &Scene, rooms: &[Enclosure]) -> Vec<Panel> {
    let material = Material::matt(scene.building.ceiling_albedo).with(Texture::Plaster);
    let panel = |(room, enclosure): (usize, &Enclosure)| {
        let [along, across] = enclosure.axes();
        // Where rooms overlap, only the ceiling of the first of them is visible, because the others are a little higher.
        let corner = enclosure.corner + vector![0.0, 0.0, enclosure.height_m + LAYER_M * room as f64];
        // The sides of the ceiling's flat face are given in reverse order, so that the face is visible from below.
        Panel { corner, along: across, up: along, material, part: Part::Ceiling, room }
    };
    rooms.iter().enumerate().map(panel).collect()
}

pub(super) fn others(rooms: &[Enclosure], index: usize) -> impl Iterator<Item = (usize, &Enclosure)> {
    rooms.iter().enumerate().filter(move |(other, _)| *other != index)
}

/// The part of a room's side between a door's jambs, as shares of its length; `None` if the door does not stand on that side.
pub(super) fn on_side(door: &Door, side: &Side) -> Option<[f64; 2]> {
    let along = side.to - side.from;
    let shares = [door.from_m, door.to_m].map(|jamb| {
        let from_corner = raised(jamb, 0.0) - side.from;
        let beside_m = side.inward.dot(&from_corner).abs();
        (from_corner.dot(&along) / along.norm_squared(), beside_m)
    });
    // The tolerance is for rounding: a door that ends where its wall ends still does so when both are turned.
    const ROUNDING: f64 = 1e-9;
    let is_near = |beside_m: f64| beside_m <= DOOR_TO_WALL_M + ROUNDING;
    let stands =
        shares.iter().all(|(share, beside_m)| is_near(*beside_m) && (-ROUNDING..=1.0 + ROUNDING).contains(share));
    let [one, other] = shares.map(|(share, _)| share.clamp(0.0, 1.0));
    stands.then(|| [one.min(other), one.max(other)])
}

/// Least distance along a wall between two doors that stand in it, negative where they overlap; `None` for doors in different walls.
pub(crate) fn between_doors_m(rooms: &[Enclosure], one: &Door, other: &Door) -> Option<f64> {
    let on_a_side = |side: Side| {
        let [one, other] = [on_side(one, &side)?, on_side(other, &side)?];
        Some((one[0].max(other[0]) - one[1].min(other[1])) * (side.to - side.from).norm())
    };
    rooms.iter().flat_map(Enclosure::sides).filter_map(on_a_side).min_by(f64::total_cmp)
}

/// The parts of the range from 0 to 1 that are left when the given gaps are taken out.
pub(super) fn remaining(mut gaps: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    gaps.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let (mut left, mut at) = (Vec::new(), 0.0);
    for [from, to] in gaps {
        if from > at {
            left.push([at, from]);
        }
        at = to.max(at);
    }
    if at < 1.0 {
        left.push([at, 1.0]);
    }
    left
}

/// Flat faces (panels) for a part of a wall between two heights: the skirting board, if the part reaches the floor, and the wall above it.
fn face(scene: &Scene, side: &Side, shares: [f64; 2], between_m: [f64; 2], room: usize) -> Vec<Panel> {
    let building = &scene.building;
    let way = side.to - side.from;
    // The flat face of the wall runs backwards along the room's side, so that it faces the room.
    let strip = |low_m: f64, high_m: f64, material: Material| Panel {
        corner: side.from + way * shares[1] + vector![0.0, 0.0, low_m],
        along: way * (shares[0] - shares[1]),
        up: vector![0.0, 0.0, high_m - low_m],
        material,
        part: Part::Wall,
        room,
    };
    let paint = Material::matt(building.wall_albedo).with(Texture::Plaster);
    if between_m[0] > 0.0 || building.skirting_height_m == 0.0 {
        return vec![strip(between_m[0], between_m[1], paint)];
    }
    let skirting = Material::matt(building.skirting_albedo).glossy(0.03, 0.1);
    vec![strip(0.0, building.skirting_height_m, skirting), strip(building.skirting_height_m, between_m[1], paint)]
}
