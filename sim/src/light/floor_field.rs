//! Light over the floor of the robot's room, in the terms of a view from close above.

use nalgebra::{Vector2, vector};

use super::{Illuminance, LightMap, Patch};
use crate::building::{Building, Part};

/// Equivalent visible lux over a rectangular floor with a corner at the world origin, for each lux of its mean.
#[derive(Clone, Debug)]
pub struct FloorField {
    count: [usize; 2],
    distance_m: [f64; 2],
    /// Row by row along x.
    share: Vec<f64>,
}

impl FloorField {
    /// The first room's floor of a light map.
    pub fn new(building: &Building, map: &LightMap) -> Option<FloorField> {
        let index = building.panels.iter().position(|panel| panel.part == Part::Floor)?;
        let (Patch { first, count }, size_m) = (map.patches[index], building.panels[index].size_m());
        let Illuminance { lux: mean_lux, .. } = map.mean_at_floor;
        let node = |i: usize, j: usize| f64::from(map.nodes[(first[1] + j) * map.size[0] + first[0] + i][0]);
        let share = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| (i, j)));
        Some(FloorField {
            count,
            distance_m: [0, 1].map(|axis| size_m[axis] / (count[axis] - 1) as f64),
            share: share.map(|(i, j)| if mean_lux > 0.0 { node(i, j) / mean_lux } else { 0.0 }).collect(),
        })
    }

    /// The field near a place as `factor·exp(gradient·(p − place))`: factor and gradient (1/m), world frame.
    ///
    /// Differences over a tenth of a metre, the width of what a floor camera sees.
    pub fn near(&self, place_m: Vector2<f64>) -> (f64, Vector2<f64>) {
        const REACH_M: f64 = 0.1;
        // Where no light is at all, the logarithm of a millionth of the mean will do.
        let at = |x: f64, y: f64| self.at(place_m + vector![x, y]).max(1e-6);
        let slope = |less: f64, more: f64| (more / less).ln() / (2.0 * REACH_M);
        let gradient = vector![slope(at(-REACH_M, 0.0), at(REACH_M, 0.0)), slope(at(0.0, -REACH_M), at(0.0, REACH_M))];
        (at(0.0, 0.0), gradient)
    }

    fn at(&self, place_m: Vector2<f64>) -> f64 {
        let split = |axis: usize| {
            let last = (self.count[axis] - 1) as f64;
            let node = (place_m[axis] / self.distance_m[axis]).clamp(0.0, last);
            let low = (node as usize).min(self.count[axis] - 2);
            (low, node - low as f64)
        };
        let ((i, a), (j, b)) = (split(0), split(1));
        let row = |j: usize| {
            let node = |i: usize| self.share[j * self.count[0] + i];
            node(i) * (1.0 - a) + node(i + 1) * a
        };
        row(j) * (1.0 - b) + row(j + 1) * b
    }
}
