//! Stamps of a base whose clock is off, by how much is not known.
//!
//! Stamps of wheels, gyroscope and flow sensor are all off by one δ, |δ| ≤ ε. The localizer reckons in that clock: what they tell of the
//! motion between two stamps is then exact, with every bound on it, however many stamps lie between. What is stamped by another clock, such as an image,
//! has a stamp that is off by ε more, as its model is to say; and an answer for an instant t is that for the base's t, which was at t − δ:
//! reach bounds what lies between, once.

use crate::{
    Localizer, PoseUnion, bounds,
    bounds::Assumption,
    motion::{moved_union, reach_motion},
};

/// The bound on δ.
pub(super) const BASE_STAMP: Assumption = bounds::BASE_STAMP;

impl Localizer {
    /// The same for a base whose stamps are off by up to this. The start is where the robot was at the base's 0.
    pub fn with_base_clock(mut self, stamp_error_s: f64) -> Self {
        self.base_stamp_error_s = stamp_error_s;
        self
    }

    /// What is known of an instant, from what is known of the same stamp of the base.
    pub(super) fn in_true_time(&self, union: &PoseUnion) -> PoseUnion {
        if self.base_stamp_error_s == 0.0 {
            return union.clone();
        }
        self.inside_room(moved_union(union, &reach_motion(self.base_stamp_error_s, &self.robot.reach)))
    }
}
