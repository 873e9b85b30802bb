//! Distribution of light over the floors of a building.

use std::sync::Arc;

use nalgebra::{Vector2, vector};

use super::{Illuminance, LightMap, Patch};
use crate::place::building::{Building, Panel, Part, Polygon};

/// Distribution of light over the floors of a building's rooms: equivalent lux in the visible band (photons counted as lux at 555 nm), per lux of the
/// mean illuminance of the robot's room.
#[derive(Clone, Debug)]
pub struct FloorField {
    /// Fields of the rooms, the robot's own room first.
    rooms: Vec<RoomField>,
}

/// Distribution of light over the floor of one room, in the rectangle around it.
#[derive(Clone, Debug)]
struct RoomField {
    /// Outline of a floor that is not that rectangle, by distances along `axes` from the first node.
    outline: Option<Arc<Polygon>>,
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
    /// The distribution of light over the floors of a light map. `nodes` are the values at the map's nodes, either the map's own or those with the
    /// shadows of people; `None` if the building has no floor.
    pub fn new(building: &Building, map: &LightMap, nodes: &[[f32; 2]]) -> Option<FloorField> {
        let of_room = |room: usize| {
            let is_floor = |panel: &Panel| panel.part == Part::Floor && panel.room == room;
            let index = building.panels.iter().position(is_floor)?;
            Some(RoomField::new(&building.panels[index], map, (map.patches[index], nodes)))
        };
        let rooms: Vec<RoomField> = (0..building.rooms.len()).filter_map(of_room).collect();
        (!rooms.is_empty()).then_some(FloorField { rooms })
    }

    /// The illuminance at a point of the floor (world frame) relative to the mean over the robot's room, bilinear between the nodes of a floor's grid. A
    /// point in no room has the light of the nearest place of the robot's room, or of the nearest place of all rooms if one of these is a polygon.
    pub fn at(&self, place_m: Vector2<f64>) -> f64 {
        if let Some(room) = self.rooms.iter().find(|room| room.contains(place_m)) {
            return room.at(place_m);
        }
        if self.rooms.iter().all(|room| room.outline.is_none()) {
            return self.rooms[0].at(place_m);
        }
        let nearest = self.rooms.iter().map(|room| (room, room.nearest_m(place_m)));
        let away_m = |nearest_m: &Vector2<f64>| (nearest_m - place_m).norm();
        let nearest = nearest.min_by(|(_, one), (_, other)| away_m(one).total_cmp(&away_m(other)));
        nearest.map_or(0.0, |(room, nearest_m)| room.at(nearest_m))
    }
}

impl RoomField {
    fn new(panel: &Panel, map: &LightMap, (Patch { first, count }, nodes): (Patch, &[[f32; 2]])) -> RoomField {
        let size_m = panel.size_m();
        let Illuminance { lux: mean_lux, .. } = map.mean_at_floor;
        let node = |i: usize, j: usize| f64::from(nodes[(first[1] + j) * map.size[0] + first[0] + i][0]);
        let share = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| (i, j)));
        RoomField {
            outline: panel.outline.clone(),
            corner_m: panel.corner.coords.xy(),
            axes: [panel.along, panel.up].map(|side| side.xy().normalize()),
            count,
            distance_m: [0, 1].map(|axis| size_m[axis] / (count[axis] - 1) as f64),
            share: share.map(|(i, j)| if mean_lux > 0.0 { node(i, j) / mean_lux } else { 0.0 }).collect(),
        }
    }

    /// Position along a side of the floor, in distances between nodes.
    fn node(&self, place_m: Vector2<f64>, axis: usize) -> f64 {
        (place_m - self.corner_m).dot(&self.axes[axis]) / self.distance_m[axis]
    }

    fn contains(&self, place_m: Vector2<f64>) -> bool {
        let within = |outline: &Arc<Polygon>| {
            let from_corner = place_m - self.corner_m;
            outline.contains(vector![from_corner.dot(&self.axes[0]), from_corner.dot(&self.axes[1])])
        };
        (0..2).all(|axis| (0.0..=(self.count[axis] - 1) as f64).contains(&self.node(place_m, axis)))
            && self.outline.as_ref().is_none_or(within)
    }

    /// The place of the room's floor that is nearest to a place outside of it.
    fn nearest_m(&self, place_m: Vector2<f64>) -> Vector2<f64> {
        let from_corner = place_m - self.corner_m;
        let along = [0, 1].map(|axis| from_corner.dot(&self.axes[axis]));
        let most = [0, 1].map(|axis| self.distance_m[axis] * (self.count[axis] - 1) as f64);
        let within = match &self.outline {
            Some(outline) => outline.nearest_within(along.into(), 0.0),
            None => vector![along[0].clamp(0.0, most[0]), along[1].clamp(0.0, most[1])],
        };
        self.corner_m + self.axes[0] * within.x + self.axes[1] * within.y
    }

    fn at(&self, place_m: Vector2<f64>) -> f64 {
        let split = |axis: usize| {
            let last = (self.count[axis] - 1) as f64;
            let node = self.node(place_m, axis).clamp(0.0, last);
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
