//! A segment of a joint between two tile corners, and the parts of it that lie in a room or in a disc.

use nalgebra::{Rotation2, Vector2};

/// A segment of a joint between two neighbouring tile corners, grid frame.
pub(super) struct Segment {
    pub(super) axis: usize,
    /// Index of the floor joint within its family of parallel joints.
    pub(super) index: i32,
    pub(super) from: Vector2<f64>,
    pub(super) to: Vector2<f64>,
    /// Displacement of the joint from its nominal line, across the joint, at both ends of the segment.
    pub(super) offset_m: [f64; 2],
    /// Distance of the joint from the straight line that it was laid along, at both ends of the segment.
    pub(super) bend_m: [f64; 2],
    /// Slope of the straight line that the joint was laid along against the joint's nominal line.
    pub(super) slope: f64,
}

impl Segment {
    pub(super) fn distance_m(&self, place: Vector2<f64>) -> f64 {
        let reach = self.to - self.from;
        let share = ((place - self.from).dot(&reach) / reach.norm_squared()).clamp(0.0, 1.0);
        (place - self.from - reach * share).norm()
    }

    /// The part of a joint segment that lies on a floor, given by its least and its greatest coordinates in the world frame, as a range of shares of
    /// its length (Liang and Barsky's clipping).
    pub(super) fn within(&self, grid_from_world: &Rotation2<f64>, floor_m: [[f64; 2]; 2]) -> Option<[f64; 2]> {
        let from = grid_from_world.inverse() * self.from;
        let reach = grid_from_world.inverse() * (self.to - self.from);
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let [least_m, most_m] = floor_m.map(|corner| corner[axis]);
            if reach[axis].abs() < 1e-12 {
                if !(least_m..=most_m).contains(&from[axis]) {
                    return None;
                }
                continue;
            }
            let ends = [(least_m - from[axis]) / reach[axis], (most_m - from[axis]) / reach[axis]];
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
        (low <= high).then_some([low, high])
    }

    /// The part of a joint segment that lies in a disc and within `range`; `range` and the result are shares of the segment's length. `None` if
    /// there is no such part.
    pub(super) fn in_disc(&self, centre: Vector2<f64>, radius_m: f64, range: [f64; 2]) -> Option<[f64; 2]> {
        // The segment's line, with the vector `reach` from end to end, meets the circle where |from + s·reach − centre|² = radius². This is a
        // quadratic in the share s.
        let reach = self.to - self.from;
        let start = self.from - centre;
        let (a, half_b) = (reach.norm_squared(), start.dot(&reach));
        let root = half_b * half_b - a * (start.norm_squared() - radius_m * radius_m);
        if root < 0.0 {
            return None;
        }
        let low = ((-half_b - root.sqrt()) / a).max(range[0]);
        let high = ((-half_b + root.sqrt()) / a).min(range[1]);
        (low <= high).then_some([low, high])
    }
}
