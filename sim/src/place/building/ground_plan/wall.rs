//! A part of a wall as a line on the floor plan: distances from it, and rays that meet it.

use nalgebra::{Point3, Vector2, vector};

use crate::place::building::walls::Side;

/// An upright part of a wall. The room that it belongs to is on the left of the way from its start to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    /// Ends of the part on the floor plan, world frame.
    pub(super) ends_m: [Vector2<f64>; 2],
    /// Heights of the lower and the upper edge above the floor.
    pub(super) between_m: [f64; 2],
    /// Index of the room that the wall belongs to; `None` for the wall's end inside an open door.
    pub(super) room: Option<usize>,
    /// How far the floor behind the wall's line is no floor of the room, beyond the wall's start and beyond its end. It is 0 at an end that is no
    /// corner of the room.
    pub(super) free_beyond_m: [f64; 2],
}

impl Wall {
    /// The part of a room's side between two shares of its length; `free_beyond_m` is of the whole side.
    pub(super) fn on(
        side: &Side,
        (room, free_beyond_m): (usize, [f64; 2]),
        shares: [f64; 2],
        between_m: [f64; 2],
    ) -> Wall {
        let is_corner = [shares[0] == 0.0, shares[1] == 1.0];
        let free_beyond_m = [0, 1].map(|end| if is_corner[end] { free_beyond_m[end] } else { 0.0 });
        Wall { ends_m: feet(side, shares), between_m, room: Some(room), free_beyond_m }
    }

    pub(super) fn distance_m(&self, at: Vector2<f64>) -> f64 {
        let [from, to] = self.ends_m;
        let along = to - from;
        let share = (at - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (at - from - along * share.clamp(0.0, 1.0)).norm()
    }

    /// Distance along a ray, given by its start and a unit vector, at which it meets the wall from either side; `None` if it does not.
    pub(super) fn met_at_m(&self, eye: Vector2<f64>, direction: Vector2<f64>) -> Option<f64> {
        let [from, to] = self.ends_m;
        let (along, to_start) = (to - from, from - eye);
        let facing = direction.perp(&along);
        let (distance_m, share) = (to_start.perp(&along) / facing, to_start.perp(&direction) / facing);
        // A ray along the wall meets it nowhere; one that meets the corner of two walls meets both, however its share is rounded.
        const ROUNDING: f64 = 1e-9;
        let is_met = (-ROUNDING..=1.0 + ROUNDING).contains(&share);
        (distance_m.is_finite() && distance_m >= 0.0 && is_met).then_some(distance_m)
    }

    /// Whether the wall stands on the line between two points, farther than `margin_m` from the second.
    pub(super) fn separates(&self, from: Point3<f64>, to: Point3<f64>, margin_m: f64) -> bool {
        let way = to - from;
        let (level_m, length_m) = (way.xy().norm(), way.norm());
        if level_m == 0.0 {
            return false;
        }
        let Some(met_at_m) = self.met_at_m(from.xy().coords, way.xy() / level_m) else { return false };
        let share = met_at_m / level_m;
        let height_m = from.z + way.z * share;
        share * length_m <= length_m - margin_m && (self.between_m[0]..=self.between_m[1]).contains(&height_m)
    }

    /// Distance of the wall's foot from a square with sides along the axes.
    pub(super) fn distance_from_square_m(&self, centre: Vector2<f64>, half_m: f64) -> f64 {
        if half_m > 0.0 && self.crosses_box(centre, Vector2::repeat(half_m)) {
            return 0.0;
        }
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let from_corners = corners.map(|[x, y]| self.distance_m(centre + vector![x, y] * half_m));
        let from_ends = self.ends_m.map(|end| (end - centre).abs().add_scalar(-half_m).sup(&Vector2::zeros()).norm());
        from_corners.into_iter().chain(from_ends).fold(f64::INFINITY, f64::min)
    }

    /// Whether the foot of the wall passes through a box with sides along the axes, given by half of its extents (Liang and Barsky's clipping).
    pub(super) fn crosses_box(&self, centre: Vector2<f64>, half: Vector2<f64>) -> bool {
        let [from, to] = self.ends_m.map(|end| end - centre);
        let way = to - from;
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            if way[axis] == 0.0 {
                if from[axis].abs() >= half[axis] {
                    return false;
                }
                continue;
            }
            let (one, other) = ((-half[axis] - from[axis]) / way[axis], (half[axis] - from[axis]) / way[axis]);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        enter < leave
    }

    /// The position that is as far behind the line of the wall as the given one is before it.
    pub(super) fn mirrored(&self, at: Vector2<f64>) -> Vector2<f64> {
        let [from, to] = self.ends_m;
        let along = to - from;
        let across = vector![-along.y, along.x];
        at - across * (2.0 * across.dot(&(at - from)) / along.norm_squared().max(f64::MIN_POSITIVE))
    }
}

/// The two points between which a part of a room's side stands on the floor, given as shares of the side's length.
pub(super) fn feet(side: &Side, shares: [f64; 2]) -> [Vector2<f64>; 2] {
    shares.map(|share| (side.from + (side.to - side.from) * share).xy().coords)
}
