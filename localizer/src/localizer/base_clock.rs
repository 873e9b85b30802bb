//! Stamps of a mobile base whose clock has an unknown offset.
//!
//! The stamps of wheels, gyroscope and flow sensor are all off by the same δ, |δ| ≤ ε. The localizer reckons in that clock: the motion that these
//! sensors give between two of their stamps is then exact, with every bound on it, however many stamps lie between. A reading stamped by another
//! clock, such as an image, has a stamp that is off by ε more, which its sensor's model has to include. An estimate for an instant t is computed
//! for the base's stamp t, which was taken at t − δ: the robot's limits of speed and turn rate bound the motion between these two instants, once.

use crate::{
    Localizer, PoseUnion, bounds,
    bounds::Assumption,
    motion::{moved_union, reach_motion},
};

/// Name of the bound on the offset of the mobile base's clock.
pub(super) const BASE_STAMP: Assumption = bounds::BASE_STAMP;

impl Localizer {
    /// The localizer, for a mobile base whose stamps are off by up to `stamp_error_s`. The start is the robot's pose at time 0 of the base's
    /// clock.
    pub fn with_base_clock(mut self, stamp_error_s: f64) -> Self {
        self.base_stamp_error_s = stamp_error_s;
        self
    }

    /// The pose union at a true instant, from the pose union at the same stamp of the mobile base's clock.
    pub(super) fn in_true_time(&self, union: &PoseUnion) -> PoseUnion {
        if self.base_stamp_error_s == 0.0 {
            return union.clone();
        }
        self.inside_room(moved_union(union, &reach_motion(self.base_stamp_error_s, &self.robot.reach)))
    }
}
