//! Things that block light in a building: upright boxes and walls.

use nalgebra::{Point3, Vector3};

use super::source::{Shape, Source};
use crate::place::building::{BoxFrame, Building, Enclosure, Panel};

/// Everything in a building that casts shadows and does not move.
#[derive(Clone, Debug)]
pub struct Occluders {
    boxes: Vec<BoxFrame>,
    walls: Vec<Panel>,
    rooms: Vec<Enclosure>,
}

/// The boxes and walls that may stand between a point and a face.
#[derive(Default)]
pub(super) struct Between<'a> {
    boxes: Vec<&'a BoxFrame>,
    walls: Vec<&'a Panel>,
}

impl Between<'_> {
    /// Whether nothing can stand there.
    pub(super) fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.walls.is_empty()
    }

    /// Whether a box or a wall stands on the straight line between two points.
    #[inline]
    pub(super) fn block(&self, from: Point3<f64>, to: Point3<f64>) -> bool {
        self.boxes.iter().any(|one| one.meets(from, to)) || self.walls.iter().any(|wall| wall.meets(from, to))
    }

    /// Whether a single box stands between any point of one convex flat shape and any point of another, given by their corners: because a box is
    /// convex too, it does if it stands between all pairs of corners.
    pub(super) fn hide<const N: usize, const M: usize>(
        &self,
        one: &[Point3<f64>; N],
        other: &[Point3<f64>; M],
    ) -> bool {
        let hides = |piece: &&BoxFrame| one.iter().all(|from| other.iter().all(|to| piece.meets(*from, *to)));
        self.boxes.iter().any(hides)
    }

    /// Whether a point is inside one of the boxes.
    #[inline]
    pub(super) fn contain(&self, at: Point3<f64>) -> bool {
        self.boxes.iter().any(|one| one.contains(at))
    }
}

impl Occluders {
    /// The things that block light in a building: its upright boxes, and its walls if it has several rooms, so that no light passes through walls
    /// from room to room, or if it is open to the sun.
    pub fn new(building: &Building) -> Occluders {
        let walls =
            if building.rooms.len() > 1 || building.is_open { building.walls().cloned().collect() } else { Vec::new() };
        let boxes = building.boxes.iter().map(BoxFrame::of).collect();
        Occluders { boxes, walls, rooms: building.rooms.clone() }
    }

    /// The boxes and walls that may stand between any two of the given points.
    pub fn among(&self, places: &[Point3<f64>]) -> Occluders {
        let low = places.iter().fold(Point3::from([f64::INFINITY; 3]), |low, at| low.inf(at));
        let high = places.iter().fold(Point3::from([f64::NEG_INFINITY; 3]), |high, at| high.sup(at));
        let reaches = |corners: &[Point3<f64>]| {
            (0..3).all(|axis| {
                corners.iter().any(|corner| corner[axis] >= low[axis])
                    && corners.iter().any(|corner| corner[axis] <= high[axis])
            })
        };
        // No wall stands between two points within a convex part of a room.
        let in_one_room = self.rooms.iter().any(|room| room.holds_together(places));
        let walls = self.walls.iter().filter(|wall| !in_one_room && reaches(&wall.corners()));
        Occluders {
            boxes: self.boxes.iter().filter(|one| reaches(&one.corners)).copied().collect(),
            walls: walls.cloned().collect(),
            rooms: Vec::new(),
        }
    }

    /// Finds the boxes and walls that may stand between two balls, given by their middles and radii. A wall may not if both balls are on one side of
    /// it.
    pub(super) fn between_balls<'a>(&'a self, middles: [Point3<f64>; 2], radii_m: [f64; 2], found: &mut Between<'a>) {
        found.boxes.clear();
        found.walls.clear();
        found.boxes.extend(self.boxes.iter().filter(|one| one.may_meet(middles, radii_m)));
        let separates = |wall: &&Panel| {
            let normal = wall.normal();
            let [one_m, other_m] = middles.map(|middle| normal.dot(&(middle - wall.corner)));
            !(one_m > radii_m[0] && other_m > radii_m[1] || one_m < -radii_m[0] && other_m < -radii_m[1])
        };
        found.walls.extend(self.walls.iter().filter(separates));
    }

    /// Whether there is furniture that casts shadows.
    pub(super) fn has_boxes(&self) -> bool {
        !self.boxes.is_empty()
    }

    /// Whether there is nothing that casts shadows.
    pub fn is_empty(&self) -> bool {
        self.boxes.is_empty() && self.walls.is_empty()
    }

    /// Whether a box or a wall stands on the straight line between two points.
    #[inline]
    pub fn block(&self, from: Point3<f64>, to: Point3<f64>) -> bool {
        self.boxes.iter().any(|one| one.meets(from, to)) || self.walls.iter().any(|wall| wall.meets(from, to))
    }

    /// Finds what may stand between a point and any point of a flat rectangle, given by its corners.
    pub(super) fn towards<'a>(&'a self, at: Point3<f64>, corners: &[Point3<f64>; 4], found: &mut Between<'a>) {
        found.boxes.clear();
        found.walls.clear();
        let low = corners.iter().fold(at, |low, corner| low.inf(corner));
        let high = corners.iter().fold(at, |high, corner| high.sup(corner));
        found.boxes.extend(self.boxes.iter().filter(|one| one.reaches(low, high)));
        let separates = |wall: &&Panel| {
            let normal = wall.along.cross(&wall.up);
            let height = |place: &Point3<f64>| normal.dot(&(place - wall.corner));
            let own = height(&at);
            corners.iter().any(|corner| height(corner) * own < 0.0)
        };
        found.walls.extend(self.walls.iter().filter(separates));
    }

    /// Whether a point is inside one of the boxes.
    #[inline]
    pub fn contain(&self, at: Point3<f64>) -> bool {
        self.boxes.iter().any(|one| one.contains(at))
    }

    /// Share of a lamp's light that reaches a point of a surface, computed from `samples` × `samples` points of the lamp.
    pub fn visible_share(&self, source: &Source, at: Point3<f64>, normal: Vector3<f64>, samples: usize) -> f64 {
        if self.is_empty() {
            return 1.0;
        }
        let from = at + normal * 0.001;
        let n = if let Shape::Point { .. } = source.shape { 1 } else { samples };
        let place = |index: usize| (2 * index + 1) as f64 / n as f64 - 1.0;
        let axis = source.shape.normal();
        let (mut seen, mut total) = (0.0, 0.0);
        for (s, t) in (0..n).flat_map(|i| (0..n).map(move |j| (place(i), place(j)))) {
            let to = source.shape.place(s, t);
            let weight = weight(axis, from, to, normal);
            total += weight;
            if weight > 0.0 && !self.block(from, to) {
                seen += weight;
            }
        }
        if total > 0.0 { seen / total } else { 0.0 }
    }
}

/// Relative contribution of one point of a lamp to the illuminance at a point of a surface: cos θ·cos θ'/d². The lamp shines along `axis`, or in all
/// directions.
#[inline]
pub(super) fn weight(axis: Option<Vector3<f64>>, at: Point3<f64>, place: Point3<f64>, normal: Vector3<f64>) -> f64 {
    let way = place - at;
    let square = way.norm_squared();
    let shining = axis.map_or(1.0, |axis| (-axis.dot(&way)).max(0.0) / square.sqrt());
    normal.dot(&way).max(0.0) * shining / (square * square.sqrt())
}
