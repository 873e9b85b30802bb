//! How far the robot can have gone within the error of a reading's stamp.

use crate::{PoseBox, robot::Reach};

/// How far the robot can have moved and turned between the stamp of a reading and the instant at which the reading was truly taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stray {
    /// Greatest distance between the robot's positions at the two instants.
    pub metres: f64,
    /// Greatest turn between the two instants.
    pub radians: f64,
}

impl Stray {
    /// The greatest change of a component of the pose: x (0), y (1) or heading (2).
    pub fn of_axis(&self, axis: usize) -> f64 {
        if axis < 2 { self.metres } else { self.radians }
    }

    /// Every pose that is no farther than this from one in a box.
    pub fn around(&self, pose: &PoseBox) -> PoseBox {
        PoseBox::from([0, 1, 2].map(|axis| pose[axis].inflate(self.of_axis(axis))))
    }

    /// What the robot's limits of speed and turn rate allow within a stamp's error.
    pub fn by_reach(stamp_error_s: f64, reach: &Reach) -> Stray {
        Stray { metres: stamp_error_s * reach.speed_m_per_s, radians: stamp_error_s * reach.turn_rate_rad_per_s }
    }
}
