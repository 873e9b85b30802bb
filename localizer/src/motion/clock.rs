//! Stamps of a clock that is off, by how much is not known.

use crate::{
    IntervalBox,
    robot::{Reach, WheelModel},
};

use super::Motion;

/// How far the robot gets, and turns, between a stamp and the instant that it stands for.
///
/// All stamps of wheels, gyroscope and flow sensor are off by one δ, |δ| ≤ ε. What they tell of the motion from a stamp s to a stamp t is the
/// true motion M from s − δ to t − δ, with all bounds on it. Before it goes a motion a from s to s − δ, after it a motion b from t − δ to
/// t, and reach bounds both by v·ε and ω·ε:
///
/// ```text
/// a ⊕ M ⊕ b = (a_xy + R(a_θ)·M_xy + R(a_θ + M_θ)·b_xy, M_θ + a_θ + b_θ)
/// |a_xy + R(a_θ)·M_xy + R(a_θ + M_θ)·b_xy − M_xy| ≤ 2·v·ε + ω·ε·|M_xy|
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    moved_m: f64,
    turned_rad: f64,
}

impl Clock {
    /// The clock of a robot's base.
    pub fn new(wheels: &WheelModel, reach: &Reach) -> Self {
        Clock {
            moved_m: reach.speed_m_per_s * wheels.stamp_error_s,
            turned_rad: reach.turn_rate_rad_per_s * wheels.stamp_error_s,
        }
    }

    /// The motion between two stamps in true time, from the motion as readings with those stamps tell it.
    pub fn between_stamps(&self, told: Motion) -> Motion {
        if self.turned_rad == 0.0 && self.moved_m == 0.0 {
            return told;
        }
        let far_m = told[0].magnitude().hypot(told[1].magnitude()) * ABOVE;
        let off_m = (2.0 * self.moved_m + self.turned_rad * far_m) * ABOVE;
        IntervalBox::from([
            told[0].inflate(off_m),
            told[1].inflate(off_m),
            told[2].inflate(2.0 * self.turned_rad * ABOVE),
        ])
    }
}

/// Makes up for the few roundings of a sum of positive terms.
const ABOVE: f64 = 1.0 + 1e-12;
