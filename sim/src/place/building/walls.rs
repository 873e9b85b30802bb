//! Rooms and their walls. A wall is left out where another room is, and has an opening where a door stands open.

mod facades;

use std::{f64::consts::FRAC_PI_2, sync::Arc};

use nalgebra::{Point3, Vector2, Vector3, vector};

use super::{
    LAYER_M, Material, Panel, Part, Texture, level,
    polygon::{Piece, Polygon, overlap},
    raised,
};
use crate::scene::{Door, RoomShape, Scene};

/// Greatest distance on the floor plan between a door and a wall at which the door still counts as a door in that wall.
pub(super) const DOOR_TO_WALL_M: f64 = 0.15;

/// Depth to which walls outdoors reach into the ground.
const FOOT_M: f64 = 0.02;

/// A room.
#[derive(Clone, Debug, PartialEq)]
pub struct Enclosure {
    /// One corner of the rectangle around the room, on the floor, world frame. A room that is a rectangle fills it.
    pub corner: Point3<f64>,
    /// Direction of the first side of the rectangle around the room, of length `width_m`, measured from world x; the second side is a quarter turn to
    /// its left.
    pub heading_rad: f64,
    /// Length of the first side of the rectangle around the room.
    pub width_m: f64,
    /// Length of the second side of the rectangle around the room.
    pub depth_m: f64,
    /// Height of the room's ceiling.
    pub height_m: f64,
    /// Outline of a room that is stated by its corners, on the floor, world frame.
    pub(crate) outline: Option<Arc<Polygon>>,
}

/// One side of a room, as a line on the floor with the room on its left.
pub(crate) struct Side {
    pub(crate) from: Point3<f64>,
    pub(crate) to: Point3<f64>,
    pub(crate) inward: Vector3<f64>,
}

impl Side {
    fn between(from: Point3<f64>, to: Point3<f64>) -> Side {
        let direction = (to - from).normalize();
        Side { from, to, inward: vector![-direction.y, direction.x, 0.0] }
    }
}

impl Enclosure {
    /// Whether a point is within the room's walls, whatever its height.
    pub fn contains(&self, at: Point3<f64>) -> bool {
        match &self.outline {
            // A point on a wall counts as inside, however its coordinates are rounded.
            None => self.around().all(|side| side.inward.dot(&(at - side.from)) >= -1e-9),
            Some(outline) => outline.contains(at.xy().coords),
        }
    }

    /// Whether all points are within one convex part of the room, so that none of its walls stands between any two of them.
    pub(crate) fn holds_together(&self, places: &[Point3<f64>]) -> bool {
        match &self.outline {
            None => places.iter().all(|at| self.contains(*at)),
            Some(outline) => {
                outline.pieces().iter().any(|piece| places.iter().all(|at| piece.contains(at.xy().coords)))
            }
        }
    }

    /// Sides of the rectangle around the room, from its corner.
    pub(crate) fn axes(&self) -> [Vector3<f64>; 2] {
        let along = level(self.heading_rad);
        [along * self.width_m, vector![-along.y, along.x, 0.0] * self.depth_m]
    }

    /// Outline of the room in the plane of a level panel, a flat rectangle over the rectangle around the room, as [`Panel::outline`] has it.
    pub(super) fn outline_on(&self, corner: Point3<f64>, sides: [Vector3<f64>; 2]) -> Option<Arc<Polygon>> {
        let [along, up] = sides.map(|side| side.xy().normalize());
        let outline = self.outline.as_ref()?;
        Some(Arc::new(outline.moved(|at| {
            let from_corner = at - corner.xy().coords;
            vector![along.dot(&from_corner), up.dot(&from_corner)]
        })))
    }

    /// The room's sides in order, counter-clockwise.
    pub(crate) fn sides(&self) -> impl Iterator<Item = Side> + use<> {
        let straight = self.outline.is_none().then(|| self.around()).into_iter().flatten();
        let of_outline = self.outline.iter().flat_map(|outline| outline.sides());
        let slanted: Vec<Side> = of_outline
            .map(|ends| ends.map(|end| raised(end.into(), 0.0)))
            .map(|[from, to]| Side::between(from, to))
            .collect();
        straight.chain(slanted)
    }

    /// The sides of the rectangle around the room.
    fn around(&self) -> impl Iterator<Item = Side> + use<> {
        let [along, across] = self.axes();
        let corners = [self.corner, self.corner + along, self.corner + along + across, self.corner + across];
        (0..4).map(move |index| Side::between(corners[index], corners[(index + 1) % 4]))
    }

    /// Corners of the convex parts of the room's floor, in order.
    pub(crate) fn floors(&self) -> Vec<Vec<Vector2<f64>>> {
        match &self.outline {
            None => vec![self.around().map(|side| side.from.xy().coords).collect()],
            Some(outline) => outline.pieces().iter().map(|piece| piece.corners.clone()).collect(),
        }
    }

    /// How far the floor behind the line of one of the room's sides is no floor of the room, beyond the side's start and beyond its end.
    pub(crate) fn free_beyond_m(&self, side: &Side) -> [f64; 2] {
        let ends = [side.from, side.to].map(|end| end.xy().coords);
        self.outline.as_ref().map_or([f64::INFINITY; 2], |outline| outline.free_beyond_m(ends))
    }

    /// The parts of another room's side that lie within this room, as shares of the side's length from 0 to 1. A wall that both rooms have in
    /// common counts as inside if this room comes first in the list.
    pub(super) fn covers(&self, side: &Side, is_first: bool) -> Vec<[f64; 2]> {
        let Some(outline) = &self.outline else {
            return covered_by(self.around().map(|own| (own, true)), side, is_first).into_iter().collect();
        };
        let of_piece = |piece: &Piece| {
            let own = piece.sides().map(|ends| ends.map(|end| raised(end.into(), 0.0)));
            let own = own.map(|[from, to]| Side::between(from, to));
            covered_by(own.zip(piece.is_side.iter().copied()), side, is_first)
        };
        outline.pieces().iter().filter_map(of_piece).collect()
    }
}

/// The part of a side that lies within a convex part of another room, as shares of the side's length from 0 to 1. That part is given by its sides,
/// each with whether it is a side of the room and not a cut through it.
fn covered_by(part: impl Iterator<Item = (Side, bool)>, side: &Side, is_first: bool) -> Option<[f64; 2]> {
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for (own, is_wall) in part {
        let (start, end) = (own.inward.dot(&(side.from - own.from)), own.inward.dot(&(side.to - own.from)));
        // A side of another room that only touches this room is not inside it, unless it is the same wall. What touches a cut is inside.
        const TOUCH_M: f64 = 1e-6;
        let is_same_wall = is_first && own.inward.dot(&side.inward) > 1.0 - 1e-9;
        let inside_m = if is_same_wall || !is_wall { -TOUCH_M } else { TOUCH_M };
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
        outline: None,
    };
    let further = scene.building.rooms.iter().map(|room| match room.shape() {
        RoomShape::Rectangle { corner_m, heading_deg, width_m, depth_m } => Enclosure {
            corner: raised(corner_m, 0.0),
            heading_rad: heading_deg.to_radians(),
            width_m,
            depth_m,
            height_m,
            outline: None,
        },
        RoomShape::Polygon { corners_m } => around(Polygon::new(corners_m), height_m),
    });
    std::iter::once(own).chain(further).collect()
}

/// The room with the given outline, within the smallest rectangle along one of its sides.
fn around(outline: Polygon, height_m: f64) -> Enclosure {
    let rectangle = |[from, to]: [Vector2<f64>; 2]| {
        // Of the four directions of a rectangle's sides the one from 0 to a quarter turn, whatever the side of the outline is.
        let way = to - from;
        let heading_rad = way.y.atan2(way.x).rem_euclid(FRAC_PI_2);
        let along = level(heading_rad).xy();
        let axes = [along, vector![-along.y, along.x]];
        let extents_m = axes.map(|axis| {
            let at_m = outline.corners().iter().map(|corner| axis.dot(corner));
            at_m.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
        });
        let corner = axes[0] * extents_m[0][0] + axes[1] * extents_m[1][0];
        Enclosure {
            corner: raised(corner.into(), 0.0),
            heading_rad,
            width_m: extents_m[0][1] - extents_m[0][0],
            depth_m: extents_m[1][1] - extents_m[1][0],
            height_m,
            outline: None,
        }
    };
    // Rounding does not decide between rectangles of the same area.
    const ROUNDING_M2: f64 = 1e-6;
    let smaller = |best: Enclosure, next: Enclosure| {
        if next.width_m * next.depth_m < best.width_m * best.depth_m - ROUNDING_M2 { next } else { best }
    };
    let nothing =
        Enclosure { corner: Point3::origin(), heading_rad: 0.0, width_m: 0.0, depth_m: 0.0, height_m, outline: None };
    let smallest = outline.sides().map(rectangle).reduce(smaller).unwrap_or(nothing);
    Enclosure { outline: Some(Arc::new(outline)), ..smallest }
}

/// Flat faces (panels) of the building's geometry for the walls of all rooms, with their skirting boards.
pub(crate) fn wall_panels(scene: &Scene, rooms: &[Enclosure]) -> Vec<Panel> {
    // Outdoors walls reach into the ground: through the gap to a ground that is drawn in a lower layer the sky would be seen.
    let foot_m = if scene.outdoors.is_some() { -FOOT_M } else { 0.0 };
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
                for (facade, shares) in facades::cut(scene, &side, shares) {
                    match facade {
                        None => panels.extend(face(scene, &side, shares, [foot_m, room.height_m], index)),
                        Some(facade) => {
                            panels.push(facades::panel(facade, &side, shares, [foot_m, room.height_m], index))
                        }
                    }
                }
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
    others(rooms, index).flat_map(|(other, room)| room.covers(side, other < index)).collect()
}

/// Numbers of the layers in which the rooms' floors and ceilings are drawn, so that rooms that overlap have different ones. The higher a layer, the
/// more do floor and ceiling stand off from the walls, by which they lie exactly in layer 0.
pub(super) fn layers(rooms: &[Enclosure]) -> Vec<usize> {
    let floors: Vec<Vec<Vec<Vector2<f64>>>> = rooms.iter().map(Enclosure::floors).collect();
    let mut layers = Vec::with_capacity(rooms.len());
    for (index, room) in rooms.iter().enumerate() {
        let overlaps = |other: &usize| floors[index].iter().any(|one| floors[*other].iter().any(|it| overlap(one, it)));
        let over = |layers: &[usize]| (0..index).filter(overlaps).map(|other| layers[other] + 1).max();
        let layer = if room.outline.is_some() { over(&layers).unwrap_or(0) } else { index };
        layers.push(layer);
    }
    layers
}

/// Flat faces (panels) of the building's geometry for the ceilings of all rooms.
pub(super) fn ceiling_panels(scene: &Scene, rooms: &[Enclosure]) -> Vec<Panel> {
    let material = Material::matt(scene.building.ceiling_albedo).with(Texture::Plaster);
    let layers = layers(rooms);
    let panel = |(room, enclosure): (usize, &Enclosure)| {
        let [along, across] = enclosure.axes();
        // Where rooms overlap, only the ceiling of the first of them is visible, because the others are a little higher.
        let corner = enclosure.corner + vector![0.0, 0.0, enclosure.height_m + LAYER_M * layers[room] as f64];
        // The sides of the ceiling's flat face are given in reverse order, so that the face is visible from below.
        let outline = enclosure.outline_on(corner, [across, along]);
        Panel { corner, along: across, up: along, material, part: Part::Ceiling, room, outline }
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
        outline: None,
    };
    let paint = Material::matt(building.wall_albedo).with(Texture::Plaster);
    if between_m[0] > 0.0 || building.skirting_height_m == 0.0 {
        return vec![strip(between_m[0], between_m[1], paint)];
    }
    let skirting = Material::matt(building.skirting_albedo).glossy(0.03, 0.1);
    vec![
        strip(between_m[0], building.skirting_height_m, skirting),
        strip(building.skirting_height_m, between_m[1], paint),
    ]
}
