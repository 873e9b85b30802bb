//! Walls as blocks: what the physics puts into the way of a body.

use nalgebra::{Vector2, vector};

use super::{GroundPlan, Rooms, WALL_THICKNESS_M, Wall};
use crate::place::building::polygon::overlap;

/// Least thickness of a block. Where rooms meet at a sharp angle, or stand wall to wall without a wall's thickness between them, the block reaches into
/// the other room by this much at most.
const LEAST_THICKNESS_M: f64 = 0.004;

/// Margin, for rounding, by which a block is made smaller when it is compared with rooms that it may touch.
const TOUCH_M: f64 = 1e-6;

/// A rectangular block on the floor plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// Middle of the block, world frame.
    pub(crate) middle_m: [f64; 2],
    /// Half of the block's extents, along its heading and across it.
    pub(crate) half_m: [f64; 2],
    /// Heading of the block, counter-clockwise from world x.
    pub(crate) heading_rad: f64,
}

impl GroundPlan {
    /// The walls that reach the floor, as blocks whose surfaces are the faces of the walls.
    pub(crate) fn blocks(&self) -> Vec<Block> {
        match &self.rooms {
            None => self.around_one_room().into(),
            Some(rooms) => rooms.feet().filter(|wall| wall.room.is_some()).map(|wall| rooms.block(wall)).collect(),
        }
    }

    /// The four walls of a single room. The walls along x cover the corners.
    fn around_one_room(&self) -> [Block; 4] {
        let [half_x_m, half_y_m] = self.plan.size_m.map(|extent_m| 0.5 * extent_m);
        let half_thick_m = 0.5 * WALL_THICKNESS_M;
        let along_x = [-half_thick_m, 2.0 * half_y_m + half_thick_m]
            .map(|y_m| ([half_x_m, y_m], [half_x_m + WALL_THICKNESS_M, half_thick_m]));
        let along_y =
            [-half_thick_m, 2.0 * half_x_m + half_thick_m].map(|x_m| ([x_m, half_y_m], [half_thick_m, half_y_m]));
        [along_x[0], along_x[1], along_y[0], along_y[1]].map(|(stated_m, half_m)| Block {
            middle_m: self.plan.stands(stated_m),
            half_m,
            heading_rad: self.plan.turn_rad,
        })
    }
}

impl Rooms {
    /// A part of a wall as a block behind its face, as thick as what lies behind allows.
    fn block(&self, wall: &Wall) -> Block {
        let [from, to] = wall.ends_m;
        let along = to - from;
        let outward = vector![along.y, -along.x] / along.norm();
        let thick_m = self.thickness_m(wall, outward);
        let middle = (from + to + outward * thick_m) / 2.0;
        Block {
            middle_m: middle.into(),
            half_m: [along.norm() / 2.0, thick_m / 2.0],
            heading_rad: along.y.atan2(along.x),
        }
    }

    /// Greatest thickness of a wall that leaves rooms and open doors behind it free, found by halving.
    fn thickness_m(&self, wall: &Wall, outward: Vector2<f64>) -> f64 {
        let [from, to] = wall.ends_m;
        let inset = (to - from).normalize() * TOUCH_M;
        let floors: Vec<Vec<Vector2<f64>>> = self.floors().collect();
        let is_free = |thick_m: f64| {
            let (near, far) = (outward * TOUCH_M, outward * (thick_m - TOUCH_M));
            let block = [from + inset + near, to - inset + near, to - inset + far, from + inset + far];
            !floors.iter().any(|floor| overlap(&block, floor))
        };
        if is_free(WALL_THICKNESS_M) {
            return WALL_THICKNESS_M;
        }
        let (mut free_m, mut taken_m) = (LEAST_THICKNESS_M, WALL_THICKNESS_M);
        for _ in 0..30 {
            let middle_m = 0.5 * (free_m + taken_m);
            if is_free(middle_m) { free_m = middle_m } else { taken_m = middle_m }
        }
        free_m
    }
}
