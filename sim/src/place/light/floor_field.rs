//! Distribution of light over the floor of the robot's room.

use nalgebra::Vector2;

use super::{Illuminance, LightMap, Patch};
use crate::place::building::{Building, Part};

/// Distribution of light over a rectangular floor: equivalent lux in the visible band (photons counted as lux at 555 nm), per lux of the floor's
/// mean illuminance.
#[derive(Clone, Debug)]
pub struct FloorField {
    /// World position of the first node of the grid of points at which the light on the floor is known, and the directions along a row of nodes
    /// and across the rows.
    corner_m: Vector2<f64>,
    axes: [Vector2<f64>; 2],
    count: [usize; 2],
    distance_m: [f64; 2],
    /// Relative illuminance at the nodes of the floor's grid, row by row along x.
    share: Vec<f64>,
}

impl FloorField {
    /// The distribution of light over the floor of the first room of a light map, which is the robot's. `nodes` are the values at the map's
    /// nodes, either the map's own or those with the shadows of people; `None` if the building has no floor.
    pub fn new(building: &Building, map: &LightMap, nodes: &[[f32; 2]]) -> Option<FloorField> {
        let index = building.panels.iter().position(|panel| panel.part == Part::Floor)?;
        let panel = &building.panels[index];
        let (Patch { first, count }, size_m) = (map.patches[index], panel.size_m());
        let Illuminance { lux: mean_lux, .. } = map.mean_at_floor;
        let node = |i: usize, j: usize| f64::from(nodes[(first[1] + j) * map.size[0] + first[0] + i][0]);
        let share = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| (i, j)));
        Some(FloorField {
            corner_m: panel.corner.coords.xy(),
            axes: [panel.along, panel.up].map(|side| side.xy().normalize()),
            count,
            distance_m: [0, 1].map(|axis| size_m[axis] / (count[axis] - 1) as f64),
            share: share.map(|(i, j)| if mean_lux > 0.0 { node(i, j) / mean_lux } else { 0.0 }).collect(),
        })
    }

    /// The illuminance at a point of the floor (world frame) relative to the floor's mean, bilinear between the nodes of the floor's grid.
    pub fn at(&self, place_m: Vector2<f64>) -> f64 {
        let split = |axis: usize| {
            let last = (self.count[axis] - 1) as f64;
            let node = ((place_m - self.corner_m).dot(&self.axes[axis]) / self.distance_m[axis]).clamp(0.0, last);
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
