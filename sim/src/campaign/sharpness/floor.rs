//! A tiled floor as a history has it: where each joint runs.
//!
//! A joint runs near a straight line, which is given by how far its two ends are off their nominal places. Between two crossings its distance from
//! the line changes linearly.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{Map, map::TileGrid};

use crate::place::drawn::LaidTiles;

use super::{
    history::{History, Quantity},
    number::{Number, Vector},
};

/// A joint: the grid axis that it crosses at right angles, and its index along that axis.
pub(super) type Joint = (usize, i32);

/// The tile grid with the places at which the joints cross each other.
pub(super) struct Floor {
    pub(super) grid: TileGrid,
    /// Ranges of world x and y outside of which there is no floor to see.
    pub(super) room_m: [Interval; 2],
    /// Least and greatest coordinate of the room along each axis of the grid.
    pub(super) extents_m: [[f64; 2]; 2],
    /// For each joint that is seen the coordinates along it of its crossings, by the index of the joint that it crosses; none where joints are straight.
    pub(super) crossings_m: BTreeMap<Joint, BTreeMap<i32, f64>>,
}

impl Floor {
    pub(super) fn of(map: &Map, grid: &TileGrid) -> Floor {
        let (sin, cos) = grid.rotation_rad.sin_cos();
        let [x, y] = map.room_m;
        let extents_m = [x * cos + y * sin, y * cos - x * sin].map(|extent| [extent.lo(), extent.hi()]);
        Floor { grid: grid.clone(), room_m: map.room_m, extents_m, crossings_m: BTreeMap::new() }
    }

    /// Learns where a joint truly crosses others, if joints bend. The witness keeps these places.
    pub(super) fn add(&mut self, laid: &LaidTiles, joint: Joint) {
        let axis = joint.0;
        if self.grid.straightness_m <= 0.0 {
            return;
        }
        let first = laid.first[1 - axis];
        let along_m = |crossing: i32| {
            let nominal_m = self.grid.edge_m[1 - axis] * f64::from(crossing) + self.grid.phase_m[1 - axis];
            nominal_m + corner_off_m(laid, joint, crossing)[1 - axis]
        };
        let crossings = (first..first + laid.count[1 - axis] as i32).map(|crossing| (crossing, along_m(crossing)));
        self.crossings_m.insert(joint, crossings.collect());
    }

    /// True displacement of a joint's end.
    pub(super) fn true_end_m(&self, laid: &LaidTiles, (axis, index): Joint, end: usize) -> f64 {
        let [shift_m, slope] = laid.lines[axis][(index - laid.first[axis]) as usize];
        shift_m + slope * self.extents_m[1 - axis][end]
    }

    /// True distance of a joint from its straight line at a crossing.
    pub(super) fn true_bend_m(&self, laid: &LaidTiles, joint: Joint, crossing: i32) -> f64 {
        let (axis, index) = joint;
        let [shift_m, slope] = laid.lines[axis][(index - laid.first[axis]) as usize];
        let along_m = self.crossings_m.get(&joint).and_then(|all| all.get(&crossing)).copied().unwrap_or(f64::NAN);
        corner_off_m(laid, joint, crossing)[axis] - shift_m - slope * along_m
    }

    /// The quantities on which a joint's displacement at a place along it depends, each with its factor there.
    pub(super) fn shares(&self, joint: Joint, along_m: f64) -> Vec<(Quantity, f64)> {
        let (axis, index) = joint;
        let [first_m, last_m] = self.extents_m[1 - axis];
        let to_last = (along_m - first_m) / (last_m - first_m);
        let mut shares =
            vec![(Quantity::JointEnd(axis, index, 0), 1.0 - to_last), (Quantity::JointEnd(axis, index, 1), to_last)];
        let crossings: Vec<(i32, f64)> =
            self.crossings_m.get(&joint).into_iter().flatten().map(|(crossing, at_m)| (*crossing, *at_m)).collect();
        if let Some(pair) = crossings.windows(2).find(|pair| pair[0].1 <= along_m && along_m < pair[1].1) {
            let to_next = (along_m - pair[0].1) / (pair[1].1 - pair[0].1);
            shares.push((Quantity::JointBend(axis, index, pair[0].0), 1.0 - to_next));
            shares.push((Quantity::JointBend(axis, index, pair[1].0), to_next));
        }
        shares
    }

    /// Where a joint runs in a history.
    pub(super) fn course<T: Number>(&self, history: &History, joint: Joint) -> Course<T> {
        let (axis, index) = joint;
        let turn_rad = T::of(self.grid.rotation_rad);
        let value = |quantity: Quantity| T::of(history.value(quantity));
        let crossings = self.crossings_m.get(&joint).into_iter().flatten();
        let bends = crossings.map(|(&crossing, &at_m)| (at_m, value(Quantity::JointBend(axis, index, crossing))));
        Course {
            axis,
            nominal_m: T::of(self.grid.edge_m[axis]) * T::of(f64::from(index)) + T::of(self.grid.phase_m[axis]),
            ends: [0, 1].map(|end| (self.extents_m[1 - axis][end], value(Quantity::JointEnd(axis, index, end)))),
            bends: bends.collect(),
            turn: [turn_rad.cos(), turn_rad.sin()],
        }
    }

    /// Direction of the world along an axis of the grid.
    pub(super) fn normal(&self, axis: usize) -> [f64; 2] {
        let (sin, cos) = self.grid.rotation_rad.sin_cos();
        if axis == 0 { [cos, sin] } else { [-sin, cos] }
    }
}

/// Displacement of the corner at which a joint crosses another, along both axes of the grid.
fn corner_off_m(laid: &LaidTiles, (axis, index): Joint, crossing: i32) -> [f64; 2] {
    let [i, j] = if axis == 0 { [index, crossing] } else { [crossing, index] };
    let [i, j] = [i - laid.first[0], j - laid.first[1]].map(|at| at as usize);
    laid.corner_offset_m[i * laid.count[1] + j]
}

/// Where a joint runs.
pub(super) struct Course<T> {
    axis: usize,
    /// Grid coordinate of the nominal line.
    nominal_m: T,
    /// Places along the joint and displacements of its straight line's ends.
    ends: [(f64, T); 2],
    /// Places along the joint and distances from its straight line there, in ascending order.
    bends: Vec<(f64, T)>,
    /// Cosine and sine of the grid's angle.
    turn: [T; 2],
}

impl<T: Number> Course<T> {
    /// World coordinates of the joint's point with this coordinate along it.
    pub(super) fn point_m(&self, along_m: f64) -> Vector<T> {
        let between = |from: (f64, T), to: (f64, T)| {
            let share = (T::of(along_m) - T::of(from.0)).over(T::of(to.0) - T::of(from.0));
            from.1 + share * (to.1 - from.1)
        };
        let mut across_m = self.nominal_m + between(self.ends[0], self.ends[1]);
        let after = self.bends.partition_point(|bend| bend.0 <= along_m);
        if after > 0 && after < self.bends.len() {
            across_m = across_m + between(self.bends[after - 1], self.bends[after]);
        }
        let along_m = T::of(along_m);
        let [gx, gy] = if self.axis == 0 { [across_m, along_m] } else { [along_m, across_m] };
        let [cos, sin] = self.turn;
        [cos * gx - sin * gy, sin * gx + cos * gy, T::of(0.0)]
    }
}

impl Course<f64> {
    /// Coordinate along the joint of a point of the world.
    pub(super) fn along_m(&self, [x, y, _]: Vector<f64>) -> f64 {
        let [cos, sin] = self.turn;
        if self.axis == 0 { cos * y - sin * x } else { cos * x + sin * y }
    }
}
