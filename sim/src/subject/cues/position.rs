//! Positions of an antenna by satellite navigation.

use localizer::{
    Reading, RobotModel,
    methods::gnss_positions::{DEVICE, Position},
    motion::Twist,
};

use crate::scene::Scene;

use super::{Mount, SIGMAS_OF_BOUND, Seen, stray};

/// A receiver by its declared values.
pub(crate) struct Receiver {
    antenna_m: [f64; 2],
    antenna_within_m: f64,
    fixed_m: f64,
    floating_m: f64,
    /// Greatest shift of the antenna by the lean of the body.
    leant_m: f64,
    stamp_error_s: f64,
}

impl Receiver {
    pub(crate) fn new(scene: &Scene, robot: &RobotModel) -> Option<Receiver> {
        let keys = scene.robot.gnss.as_ref()?;
        Some(Receiver {
            antenna_m: [keys.forward_m, keys.left_m],
            antenna_within_m: keys.position_tolerance_m,
            fixed_m: keys.fixed_tolerance_m,
            floating_m: keys.floating_tolerance_m,
            leant_m: keys.height_m * robot.body.tilt_rad,
            stamp_error_s: keys.stamp_tolerance_s + scene.robot.delivery.stamp_tolerance_s,
        })
    }

    /// Position of the antenna.
    pub(crate) fn mount(&self) -> Mount {
        let sigma_m = SIGMAS_OF_BOUND * self.antenna_within_m;
        Mount { sigma: [sigma_m, sigma_m, 0.0] }
    }

    pub(crate) fn look(&self, reading: &Reading, twist: &Twist) -> Option<Seen> {
        let Reading::Other { device, numbers, .. } = reading else { return None };
        let position = Position::of(numbers).filter(|_| device == DEVICE)?;
        let within_m = if position.is_fixed { self.fixed_m } else { self.floating_m };
        let [stray_m, stray_rad] = stray(twist, self.stamp_error_s);
        let arm_m = self.antenna_m[0].hypot(self.antenna_m[1]);
        let sigma_m = (SIGMAS_OF_BOUND * within_m.hypot(self.leant_m)).hypot(stray_m).hypot(stray_rad * arm_m);
        Some(Seen::Position { in_robot_m: self.antenna_m, in_world_m: position.at_m, sigma_m })
    }
}
