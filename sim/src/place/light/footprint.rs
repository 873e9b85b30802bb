//! The part of a face that a person may shade from a lamp, so that the light of all other points of the face need not be asked for.

use std::ops::Range;

use nalgebra::{Point2, Point3};

use super::Patch;
use crate::place::building::Panel;

/// Distance, in distances between nodes, by which a footprint is made larger than it has to be, because its corners are rounded numbers.
const SLACK: f64 = 0.01;

/// A box in space, by its least and its greatest coordinates.
pub(super) struct Around {
    pub(super) low: Point3<f64>,
    pub(super) high: Point3<f64>,
}

impl Around {
    fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|index| {
            let at = |axis: usize| if index >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            Point3::new(at(0), at(1), at(2))
        })
    }

    fn distance_m(&self, from: Point3<f64>) -> f64 {
        (from.sup(&self.low).inf(&self.high) - from).norm()
    }
}

/// The nodes of a face from which the straight line to a lamp's middle may pass through a box: for each row of nodes that has any, its number and the
/// range of such nodes. No such node is left out.
///
/// Seen from the lamp, the box covers a convex part of the face's plane: the hull of the projections of its corners.
pub(super) fn footprint(panel: &Panel, patch: Patch, lamp: Point3<f64>, around: &Around) -> Vec<(usize, Range<usize>)> {
    let whole = || (0..patch.count[1]).map(|row| (row, 0..patch.count[0])).collect();
    let normal = panel.normal();
    let height_m = |at: &Point3<f64>| normal.dot(&(at - panel.corner));
    let lamp_m = height_m(&lamp);
    let nearest_m = around.distance_m(lamp);
    if lamp_m <= 0.0 || (0..3).any(|axis| around.low[axis] > around.high[axis]) {
        return Vec::new();
    }
    let farthest_m = panel.corners().iter().map(|corner| (corner - lamp).norm()).fold(0.0, f64::max);
    if nearest_m <= 1e-6 * farthest_m {
        return whole();
    }
    // A line from the lamp to the face that meets the box goes at least `nearest_m` of its way before it does, and has then come so much nearer to
    // the face's plane. What of the box is above that height casts no shadow onto the face.
    let highest_m = lamp_m * (1.0 - 0.999 * nearest_m / farthest_m);
    let corners = around.corners();
    let mut casting: Vec<Point3<f64>> =
        corners.iter().copied().filter(|corner| height_m(corner) <= highest_m).collect();
    for (index, one) in corners.iter().enumerate() {
        for other in &corners[index + 1..] {
            let (one_m, other_m) = (height_m(one), height_m(other));
            if (one_m > highest_m) != (other_m > highest_m) {
                casting.push(one + (other - one) * ((highest_m - one_m) / (other_m - one_m)));
            }
        }
    }
    let node = |corner: &Point3<f64>| {
        let on_plane = lamp + (corner - lamp) * (lamp_m / (lamp_m - height_m(corner))) - panel.corner;
        let along =
            |side: &nalgebra::Vector3<f64>, count: usize| on_plane.dot(side) / side.norm_squared() * (count - 1) as f64;
        Point2::new(along(&panel.along, patch.count[0]), along(&panel.up, patch.count[1]))
    };
    let cast: Vec<Point2<f64>> = casting.iter().map(node).collect();
    rows(&cast, patch.count)
}

/// The nodes of a grid inside the convex hull of some points, row by row; the points are in distances between nodes.
fn rows(points: &[Point2<f64>], count: [usize; 2]) -> Vec<(usize, Range<usize>)> {
    let least = points.iter().map(|point| point.y).fold(f64::INFINITY, f64::min);
    let most = points.iter().map(|point| point.y).fold(f64::NEG_INFINITY, f64::max);
    let row = |row: usize| {
        // A row just beside the hull has the nodes that the hull's end has.
        let y = (row as f64).clamp(least, most);
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for (index, one) in points.iter().enumerate() {
            for other in &points[index..] {
                if (one.y - y) * (other.y - y) > 0.0 {
                    continue;
                }
                let share = if one.y == other.y { 0.0 } else { (y - one.y) / (other.y - one.y) };
                let xs = if one.y == other.y { [one.x, other.x] } else { [one.x + share * (other.x - one.x); 2] };
                ends = [ends[0].min(xs[0]).min(xs[1]), ends[1].max(xs[0]).max(xs[1])];
            }
        }
        (row, within(ends, count[0]))
    };
    within([least, most], count[1]).map(row).filter(|(_, nodes)| !nodes.is_empty()).collect()
}

/// The whole numbers below `count` between two numbers, or hardly beside them.
fn within([least, most]: [f64; 2], count: usize) -> Range<usize> {
    let first = (least - SLACK).ceil().max(0.0);
    let end = (most + SLACK).floor() + 1.0;
    // The conversion cuts off at 0 what is negative or no number.
    first.min(count as f64) as usize..end.min(count as f64) as usize
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3, vector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use crate::place::building::{Material, Part};

    use super::*;

    /// Whether the straight line between two points passes through a box (by slabs, Kay and Kajiya 1986).
    fn passes(around: &Around, from: Point3<f64>, to: Point3<f64>) -> bool {
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (start, way) = (from[axis], to[axis] - from[axis]);
            let [one, other] = [around.low[axis], around.high[axis]].map(|side| (side - start) / way);
            (enters, leaves) = (enters.max(one.min(other)), leaves.min(one.max(other)));
        }
        enters <= leaves
    }

    #[test]
    fn a_footprint_has_every_node_behind_a_box_and_few_others() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut n_behind, mut n_in) = (0, 0);
        for _ in 0..3000 {
            let mut draw = |low: f64, high: f64| rng.random_range(low..high);
            // A level, an upright or a slanting face; the lamp and the box stand anywhere around it, also behind it and in each other.
            let turn = UnitQuaternion::from_euler_angles(0.0, draw(-1.6, 1.6), draw(-3.2, 3.2));
            let panel = Panel {
                corner: Point3::new(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-0.5, 0.5)),
                along: turn * vector![draw(0.3, 4.0), 0.0, 0.0],
                up: turn * vector![0.0, draw(0.3, 4.0), 0.0],
                material: Material::matt(0.5),
                part: Part::Wall,
                room: 0,
                outline: None,
            };
            let patch = Patch { first: [0, 0], count: [2, 2].map(|least| least + draw(0.0, 20.0) as usize) };
            let middle = Point3::new(0.5, 0.5, 1.0) + Vector3::from_fn(|_, _| draw(-2.0, 2.0));
            let half = Vector3::from_fn(|_, _| draw(0.05, 0.8));
            let around = Around { low: middle - half, high: middle + half };
            let lamp = Point3::new(0.5, 0.5, 1.0) + Vector3::from_fn(|_, _| draw(-3.0, 3.0));
            let found = footprint(&panel, patch, lamp, &around);
            let is_in = |i: usize, j: usize| found.iter().any(|(row, nodes)| *row == j && nodes.contains(&i));
            let is_lit = panel.normal().dot(&(lamp - panel.corner)) > 0.0;
            for (i, j) in (0..patch.count[1]).flat_map(|j| (0..patch.count[0]).map(move |i| (i, j))) {
                let share = |index: usize, count: usize| index as f64 / (count - 1) as f64;
                let node = panel.place(share(i, patch.count[0]), share(j, patch.count[1]));
                let is_behind = is_lit && passes(&around, node, lamp);
                assert!(!is_behind || is_in(i, j), "node {i}, {j} of {panel:?} from {lamp} behind {}", around.low);
                n_behind += usize::from(is_behind);
                n_in += usize::from(is_in(i, j));
            }
        }
        assert!(n_behind > 10_000 && n_in < 2 * n_behind, "{n_in} nodes for {n_behind} behind boxes");
    }
}
