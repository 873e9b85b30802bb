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

impl Occluders {
    /// The things that block light in a building: its upright boxes, and its walls if it has several rooms, so that no light passes through walls
    /// from room to room.
    pub fn new(building: &Building) -> Occluders {
        let walls = if building.rooms.len() > 1 { building.walls().cloned().collect() } else { Vec::new() };
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
        // A room is convex, so that no wall stands between two points within it.
        let in_one_room = self.rooms.iter().any(|room| places.iter().all(|at| room.contains(*at)));
        let walls = self.walls.iter().filter(|wall| !in_one_room && reaches(&wall.corners()));
        Occluders {
            boxes: self.boxes.iter().filter(|one| reaches(&one.corners)).copied().collect(),
            walls: walls.cloned().collect(),
            rooms: Vec::new(),
        }
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

    /// Whether a point is inside one of the boxes.
    #[inline]
    pub fn contain(&self, at: Point3<f64>) -> bool {
        self.boxes.iter().any(|one| one.contains(at))
    }

    /// Share of the hemisphere over a point of a surface, weighted by the cosine to the surface's normal, that no box within `reach_m` covers.
    pub fn open_share(&self, at: Point3<f64>, normal: Vector3<f64>, reach_m: f64) -> f64 {
        if self.boxes.is_empty() {
            return 1.0;
        }
        const N: usize = 24;
        let from = at + normal * 0.002;
        let aside = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() }.cross(&normal).normalize();
        let other = normal.cross(&aside);
        let open = (0..N).filter(|&index| {
            // The directions are spread evenly over the cosine-weighted hemisphere by the golden angle, with sin²θ uniform.
            let sine = ((index as f64 + 0.5) / N as f64).sqrt();
            let (sin, cos) = (index as f64 * 2.399_963).sin_cos();
            let direction = aside * (sine * cos) + other * (sine * sin) + normal * (1.0 - sine * sine).sqrt();
            let to = from + direction * reach_m;
            !self.boxes.iter().any(|one| one.meets(from, to))
        });
        open.count() as f64 / N as f64
    }

    /// Share of a lamp's light that reaches a point of a surface, computed from `samples` × `samples` points of the lamp.
    pub fn visible_share(&self, source: &Source, at: Point3<f64>, normal: Vector3<f64>, samples: usize) -> f64 {
        if self.is_empty() {
            return 1.0;
        }
        let from = at + normal * 0.001;
        let n = if let Shape::Point { .. } = source.shape { 1 } else { samples };
        let place = |index: usize| (2 * index + 1) as f64 / n as f64 - 1.0;
        let (mut seen, mut total) = (0.0, 0.0);
        for (s, t) in (0..n).flat_map(|i| (0..n).map(move |j| (place(i), place(j)))) {
            let to = source.shape.place(s, t);
            let weight = weight(source, from, to, normal);
            total += weight;
            if weight > 0.0 && !self.block(from, to) {
                seen += weight;
            }
        }
        if total > 0.0 { seen / total } else { 0.0 }
    }
}

/// Relative contribution of one point of a lamp to the illuminance at a point of a surface: cos θ·cos θ'/d².
#[inline]
pub(super) fn weight(source: &Source, at: Point3<f64>, place: Point3<f64>, normal: Vector3<f64>) -> f64 {
    let way = place - at;
    let square = way.norm_squared();
    let shining = source.shape.normal().map_or(1.0, |axis| (-axis.dot(&way)).max(0.0) / square.sqrt());
    normal.dot(&way).max(0.0) * shining / (square * square.sqrt())
}
