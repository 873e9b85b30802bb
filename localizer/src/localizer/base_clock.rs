//! Stamps of a mobile base (wheels, gyroscope, flow sensor and steering encoder) whose clock has an unknown offset.
//!
//! All stamps of the base are off by the same δ, |δ| ≤ ε. The localizer computes in the base's clock: between two of its stamps the offset cancels
//! out, so that the motion which the base's sensors give, with their declared bounds, holds however many stamps lie between. A reading stamped by
//! another clock, such as an image, is off by up to ε more against the base's clock, which the declared stamp error of its sensor has to include. An
//! estimate for a true instant t is computed for the base's stamp t, which was taken at the instant t − δ. The robot's limits of speed and turn rate
//! bound the motion between these two instants; they widen each estimate once.

use crate::{
    Localizer, PoseUnion, bounds,
    bounds::Assumption,
    motion::{moved_union, reach_motion},
};

/// Name of the bound on the offset of the mobile base's clock.
pub(super) const BASE_STAMP: Assumption = bounds::BASE_STAMP;

impl Localizer {
    /// The same localizer, for a mobile base whose stamps are off by up to `stamp_error_s`. The start that the localizer was given is then the
    /// robot's pose at time 0 of the base's clock.
    pub fn with_base_clock(mut self, stamp_error_s: f64) -> Self {
        self.base_stamp_error_s = stamp_error_s;
        self
    }

    /// The pose union at a true instant, from the pose union at the same stamp of the mobile base's clock: widened by the motion that is possible
    /// within the clock's greatest offset.
    pub(super) fn in_true_time(&self, union: &PoseUnion) -> PoseUnion {
        if self.base_stamp_error_s == 0.0 {
            return union.clone();
        }
        self.inside_room(moved_union(union, &reach_motion(self.base_stamp_error_s, &self.robot.reach)))
    }
}
