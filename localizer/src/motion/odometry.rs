//! Wheel odometry alone as a point estimate without bounds, which drifts; the localizer is compared with it.

use crate::{Pose, robot::WheelModel};

/// Wheel odometry by Eq. (5) of Lv, Kang and Qin, *FVO: floor vision aided odometry*: nominal wheels, and the heading at the middle of each
/// step.
#[derive(Clone, Debug)]
pub struct PointOdometry {
    pose: Pose,
    ticks: Option<[i64; 2]>,
}

impl PointOdometry {
    /// Odometry that starts at the pose `start`.
    pub fn new(start: Pose) -> Self {
        PointOdometry { pose: start, ticks: None }
    }

    /// Carries the pose on to the next encoder reading.
    pub fn advance(&mut self, ticks: [i64; 2], wheels: &WheelModel) {
        if let Some(before) = self.ticks {
            let rolled_m =
                [0, 1].map(|wheel| (ticks[wheel] - before[wheel]) as f64 * wheels.metres_per_tick(wheel).mid());
            let (distance_m, turn_rad) =
                (0.5 * (rolled_m[0] + rolled_m[1]), (rolled_m[1] - rolled_m[0]) / wheels.track_m.mid());
            let (sin, cos) = (self.pose.heading_rad + 0.5 * turn_rad).sin_cos();
            self.pose.x_m += distance_m * cos;
            self.pose.y_m += distance_m * sin;
            self.pose.heading_rad += turn_rad;
        }
        self.ticks = Some(ticks);
    }

    /// The pose at the latest encoder reading.
    pub fn pose(&self) -> Pose {
        self.pose
    }
}
