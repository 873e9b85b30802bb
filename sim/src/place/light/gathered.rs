//! Reflected light over the faces of a building: gathered at coarse nodes, and interpolated between those that the place in question sees.

use nalgebra::{Point3, Vector3};

use super::{
    Illuminance,
    nodes::{Patch, inside, nodes_of},
    occlusion::Occluders,
    parallel::in_parallel,
    radiosity::Reflecting,
    reflector::BEFORE_M,
};
use crate::place::building::{Building, Panel};

/// Wanted distance between the points of a face at which the reflected light is gathered.
const DISTANCE_M: f64 = 0.25;
/// Greatest number of pairs of such a point and a reflector; more would take seconds. In a large building the points are farther apart.
const MAX_PAIRS: f64 = 5e6;
/// Length up to which a side of a face has a single row of such points, in its middle.
const SHORT_M: f64 = 0.12;
/// Distance in front of a face along which is looked whether a place sees a coarse node.
const LOOK_M: f64 = 0.01;

/// Light that reflectors of known exitance throw onto other surfaces.
pub(super) struct Thrown<'a> {
    pub(super) building: &'a Building,
    pub(super) occluders: &'a Occluders,
    pub(super) reflecting: &'a Reflecting<'a>,
    /// Exitance of each reflector.
    pub(super) exitances: &'a [Illuminance],
}

/// Reflected light at the coarse nodes of a face.
struct Coarse {
    count: [usize; 2],
    /// Light at each node, row by row; `None` inside furniture.
    nodes: Vec<Option<Illuminance>>,
}

impl Thrown<'_> {
    /// Reflected light at a point, a little before surfaces with the given normals.
    pub(super) fn onto<const N: usize>(
        &self,
        at: Point3<f64>,
        normals: &[Vector3<f64>; N],
        salt: usize,
    ) -> [Illuminance; N] {
        let mut sum = [Illuminance::default(); N];
        self.reflecting.each_before(at, normals, |index, between| {
            if let Some(factors) = self.reflecting.all[index].factors(at, normals, between, salt + index) {
                for (sum, factor) in sum.iter_mut().zip(factors) {
                    *sum = sum.plus(factor, self.exitances[index]);
                }
            }
        });
        sum
    }

    /// Reflected light at the light-map nodes of all faces of the building.
    pub(super) fn over_faces(&self, work: &[(&Panel, Patch)]) -> Vec<Vec<Illuminance>> {
        let counts = self.counts();
        let receivers: Vec<(usize, [usize; 2])> = counts
            .iter()
            .enumerate()
            .flat_map(|(panel, count)| (0..count[1]).flat_map(move |j| (0..count[0]).map(move |i| (panel, [i, j]))))
            .collect();
        let gathered = in_parallel(&receivers, |(panel, node)| {
            let at = self.place(*panel, coarse_share(*node, counts[*panel]));
            let normal = self.building.panels[*panel].normal();
            let before = at + normal * BEFORE_M;
            let salt = node[0] * 5 + node[1] * 3;
            (!self.occluders.contain(before)).then(|| self.onto(before, &[normal], salt)[0])
        });
        let mut gathered = gathered.into_iter();
        let coarse: Vec<Coarse> = counts
            .iter()
            .map(|count| Coarse { count: *count, nodes: gathered.by_ref().take(count[0] * count[1]).collect() })
            .collect();
        let faces: Vec<usize> = (0..work.len()).collect();
        in_parallel(&faces, |&face| {
            // What stands on the face or reaches into it.
            let near = self.building.panels[face]
                .corners()
                .map(|corner| [-LOOK_M, LOOK_M].map(|away_m| corner + work[face].0.normal() * away_m));
            let near = self.occluders.among(near.as_flattened());
            nodes_of(work[face].1).map(|shares| self.between(face, &coarse[face], &near, shares)).collect()
        })
    }

    /// Numbers of coarse nodes along the sides of each face.
    fn counts(&self) -> Vec<[usize; 2]> {
        let counts = |distance_m: f64| -> Vec<[usize; 2]> {
            let along = |side_m: f64| if side_m < SHORT_M { 1 } else { (side_m / distance_m).ceil() as usize + 1 };
            self.building.panels.iter().map(|panel| panel.size_m().map(along)).collect()
        };
        let pairs = |counts: &[[usize; 2]]| {
            counts.iter().map(|[columns, rows]| columns * rows).sum::<usize>() as f64 * self.reflecting.all.len() as f64
        };
        let mut distance_m = DISTANCE_M;
        while pairs(&counts(distance_m)) > MAX_PAIRS && distance_m < 20.0 {
            distance_m *= 1.1;
        }
        counts(distance_m)
    }

    fn place(&self, panel: usize, shares: [f64; 2]) -> Point3<f64> {
        let panel = &self.building.panels[panel];
        let [s, t] = inside(panel, shares);
        panel.place(s, t)
    }

    /// Light at a point of a face: bilinear between those of the four coarse nodes around it which it sees, so that no light seeps under furniture or
    /// through partitions.
    fn between(&self, face: usize, coarse: &Coarse, near: &Occluders, shares: [f64; 2]) -> Illuminance {
        let split = |share: f64, count: usize| {
            let place = share * count.saturating_sub(1) as f64;
            let low = (place as usize).min(count.saturating_sub(2));
            (low, place - low as f64)
        };
        let ((i, a), (j, b)) = (split(shares[0], coarse.count[0]), split(shares[1], coarse.count[1]));
        let around =
            [([0, 0], (1.0 - a) * (1.0 - b)), ([1, 0], a * (1.0 - b)), ([0, 1], (1.0 - a) * b), ([1, 1], a * b)];
        let normal = self.building.panels[face].normal();
        let at = self.place(face, shares) + normal * LOOK_M;
        let is_hidden = near.contain(at);
        let (mut sum, mut total) = (Illuminance::default(), 0.0);
        for ([right, up], weight) in around {
            let node = [(i + right).min(coarse.count[0] - 1), (j + up).min(coarse.count[1] - 1)];
            let Some(light) = coarse.nodes[node[1] * coarse.count[0] + node[0]] else { continue };
            let to = self.place(face, coarse_share(node, coarse.count)) + normal * LOOK_M;
            if weight > 0.0 && (is_hidden || !near.block(at, to)) {
                sum = sum.plus(weight, light);
                total += weight;
            }
        }
        if total > 0.0 {
            return sum.times(1.0 / total);
        }
        if is_hidden {
            return Illuminance::default();
        }
        self.onto(at + normal * (BEFORE_M - LOOK_M), &[normal], 0)[0]
    }
}

/// Position of a coarse node, as shares of the face's sides. A single node is in the middle.
fn coarse_share(node: [usize; 2], count: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|axis| if count[axis] == 1 { 0.5 } else { node[axis] as f64 / (count[axis] - 1) as f64 })
}
