//! Reflected light anywhere in a room, for people, lamps and dots: from a coarse lattice of points, each with the light from six sides.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use super::{Illuminance, gathered::Thrown, parallel::in_parallel};
use crate::place::building::{Enclosure, Polygon};

/// Wanted distance between the points of the lattice.
const DISTANCE_M: f64 = 1.0;
/// Greatest number of such points in a building.
const MAX_POINTS: usize = 1200;
/// Distance of the outermost points from walls, floor and ceiling.
const FROM_WALLS_M: f64 = 0.01;

/// Light that arrives by reflection at a lattice of points in each room.
#[derive(Clone, Debug, Default)]
pub(super) struct Ambient {
    rooms: Vec<Lattice>,
}

/// The lattice of one room, which fills the rectangle around it.
#[derive(Clone, Debug)]
struct Lattice {
    corner: Point3<f64>,
    /// Outline of a room that is not that rectangle, on the floor, world frame.
    outline: Option<Arc<Polygon>>,
    /// Unit vectors along the rectangle's sides, and up.
    axes: [Vector3<f64>; 3],
    size_m: [f64; 3],
    count: [usize; 3],
    /// Light at each point onto surfaces that face along each axis and against it; `None` inside furniture.
    points: Vec<Option<[[Illuminance; 2]; 3]>>,
}

impl Ambient {
    /// Gathers the reflected light at the lattices of all rooms.
    pub(super) fn new(thrown: &Thrown) -> Ambient {
        let rooms = &thrown.building.rooms;
        let counts = |distance_m: f64| -> Vec<[usize; 3]> {
            let along = |side_m: f64| (side_m / distance_m).ceil() as usize + 1;
            rooms.iter().map(|room| [room.width_m, room.depth_m, room.height_m].map(along)).collect()
        };
        let mut distance_m = DISTANCE_M;
        while counts(distance_m).iter().map(|count| count.iter().product::<usize>()).sum::<usize>() > MAX_POINTS
            && distance_m < 50.0
        {
            distance_m *= 1.1;
        }
        let of_room = |(room, count): (&Enclosure, [usize; 3])| Lattice::new(room, count, thrown);
        Ambient { rooms: rooms.iter().zip(counts(distance_m)).map(of_room).collect() }
    }

    /// The sum of several lamps' reflected light, each times a factor.
    pub(super) fn sum<'a>(mut weighted: impl Iterator<Item = (f64, &'a Ambient)>) -> Ambient {
        let Some((factor, first)) = weighted.next() else { return Ambient::default() };
        let mut sum = first.clone();
        sum.each_light(|light, _| *light = light.times(factor), first);
        weighted.for_each(|(factor, next)| sum.each_light(|light, other| *light = light.plus(factor, other), next));
        sum
    }

    /// Calls `visit` for each light of all lattices, together with the same light of the same building's lattices in `other`.
    fn each_light(&mut self, visit: impl Fn(&mut Illuminance, Illuminance), other: &Ambient) {
        let points = self.rooms.iter_mut().flat_map(|room| &mut room.points);
        let others = other.rooms.iter().flat_map(|room| &room.points);
        for (lights, others) in points.flatten().zip(others.flatten()) {
            let lights = lights.as_flattened_mut().iter_mut();
            lights.zip(others.as_flattened()).for_each(|(light, other)| visit(light, *other));
        }
    }

    /// Reflected light onto a surface at a point of a room.
    pub(super) fn at(&self, room: usize, at: Point3<f64>, normal: Vector3<f64>) -> Illuminance {
        self.rooms.get(room).map_or_else(Illuminance::default, |lattice| lattice.at(at, normal))
    }
}

impl Lattice {
    fn new(room: &Enclosure, count: [usize; 3], thrown: &Thrown) -> Lattice {
        let [along, across] = room.axes();
        let axes = [along.normalize(), across.normalize(), Vector3::z()];
        let size_m = [room.width_m, room.depth_m, room.height_m];
        let outline = room.outline.clone();
        let mut lattice = Lattice { corner: room.corner, outline, axes, size_m, count, points: Vec::new() };
        let nodes: Vec<[usize; 3]> = (0..count.iter().product())
            .map(|node| [node % count[0], node / count[0] % count[1], node / count[0] / count[1]])
            .collect();
        lattice.points = in_parallel(&nodes, |node| {
            let at = lattice.place(*node);
            let normals = [axes[0], -axes[0], axes[1], -axes[1], axes[2], -axes[2]];
            (!thrown.occluders.contain(at)).then(|| {
                let light = thrown.onto(at, &normals, node.iter().sum());
                [[light[0], light[1]], [light[2], light[3]], [light[4], light[5]]]
            })
        });
        lattice
    }

    /// World position of a point of the lattice. What would be beyond the room's outline is at the nearest place within, whose light serves for the
    /// places between it and the points inside.
    fn place(&self, node: [usize; 3]) -> Point3<f64> {
        let along = |axis: usize| {
            let share = node[axis] as f64 / (self.count[axis] - 1) as f64;
            self.axes[axis] * (FROM_WALLS_M + share * (self.size_m[axis] - 2.0 * FROM_WALLS_M))
        };
        let at = self.corner + along(0) + along(1) + along(2);
        let within = self.outline.as_ref().map(|outline| outline.nearest_within(at.xy().coords, FROM_WALLS_M));
        within.map_or(at, |within| Point3::new(within.x, within.y, at.z))
    }

    /// Light onto a surface, trilinear between the points of the lattice; onto a surface that faces along none of the axes, light from its three
    /// sides is mixed by the squares of the normal's components (McTaggart, Half-Life 2 / Valve Source Shading, 2004).
    fn at(&self, at: Point3<f64>, normal: Vector3<f64>) -> Illuminance {
        let from_corner = at - self.corner;
        let split = [0, 1, 2].map(|axis| {
            let last = (self.count[axis] - 1) as f64;
            let place = (from_corner.dot(&self.axes[axis]) / self.size_m[axis]).clamp(0.0, 1.0) * last;
            let low = (place as usize).min(self.count[axis] - 2);
            (low, place - low as f64)
        });
        let facing = self.axes.map(|axis| axis.dot(&normal));
        let (mut sum, mut total) = (Illuminance::default(), 0.0);
        for corner in 0..8_usize {
            let beyond = [0, 1, 2].map(|axis| corner >> axis & 1);
            let weight: f64 =
                (0..3).map(|axis| if beyond[axis] == 1 { split[axis].1 } else { 1.0 - split[axis].1 }).product();
            let [i, j, k] = [0, 1, 2].map(|axis| split[axis].0 + beyond[axis]);
            let Some(light) = &self.points[(k * self.count[1] + j) * self.count[0] + i] else { continue };
            for axis in 0..3 {
                sum = sum.plus(weight * facing[axis] * facing[axis], light[axis][usize::from(facing[axis] < 0.0)]);
            }
            total += weight;
        }
        if total > 0.0 { sum.times(1.0 / total) } else { sum }
    }
}
