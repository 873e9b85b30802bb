//! Rows of a rolling shutter: how the robot moved between the exposure of a row and the stamp of its image, which is that of the middle row.

use interval::{Interval, IntervalBox};

use crate::{
    method::MotionBetween,
    motion::{self, Motion},
    robot::Reach,
};

/// Exposure of the rows of one image, and how the robot moved meanwhile.
pub(super) struct Rows<'a> {
    row_time_s: f64,
    middle_row: f64,
    stamp_s: f64,
    reach: Reach,
    motion: MotionBetween<'a>,
}

impl<'a> Rows<'a> {
    /// The rows of an image of this height with the stamp `stamp_s`; `None` for a global shutter.
    pub(super) fn of(
        (row_time_s, height_px): (f64, u32),
        stamp_s: f64,
        reach: Reach,
        motion: MotionBetween<'a>,
    ) -> Option<Rows<'a>> {
        let middle_row = 0.5 * (f64::from(height_px) - 1.0);
        (row_time_s > 0.0).then_some(Rows { row_time_s, middle_row, stamp_s, reach, motion })
    }

    /// Time after the stamp at which a row is exposed; negative for the rows above the middle.
    pub(super) fn after_s(&self, row: f64) -> f64 {
        (row - self.middle_row) * self.row_time_s
    }

    /// Motion of the robot from one row to another that is known to within so many rows, forward, to the left and turned, in the robot frame at the
    /// first of them.
    pub(super) fn between(&self, from_row: f64, to_row: f64, within_rows: f64) -> [Interval; 3] {
        let [from_s, to_s] = [from_row, to_row].map(|row| self.after_s(row));
        let [begin_s, end_s] = [from_s.min(to_s), from_s.max(to_s)].map(|after_s| self.stamp_s + after_s);
        let known = (self.motion)(begin_s, end_s).filter(|motion| !motion.is_empty());
        let known = known.map(|motion| if from_s <= to_s { motion } else { backwards(motion) });
        let moved = known.unwrap_or_else(|| motion::reach_motion((to_s - from_s).abs(), &self.reach));
        let within = motion::reach_motion(within_rows * self.row_time_s, &self.reach);
        [0, 1, 2].map(|axis| moved[axis] + within[axis])
    }

    /// Motion of the robot from the stamp to a row that is known to within so many rows.
    pub(super) fn moved(&self, row: f64, within_rows: f64) -> [Interval; 3] {
        self.between(self.middle_row, row, within_rows)
    }
}

/// Where the robot was before a motion, as seen from where it is after it.
fn backwards(motion: Motion) -> Motion {
    let [ahead, left, turn] = [0, 1, 2].map(|axis| motion[axis]);
    let (cos, sin) = (turn.cos(), turn.sin());
    IntervalBox::from([-(ahead * cos + left * sin), ahead * sin - left * cos, -turn])
}
