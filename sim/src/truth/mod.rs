//! The true state of the simulated world at an instant. The sensors, the check of estimates and the record of the run use it; the localizer never
//! gets it.

pub mod randomness;

use localizer::Pose;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Length of a time step of the physics. Steps of 2.5 ms and more make the springs on which a light robot stands unstable.
pub const STEP_S: f64 = 0.001;

/// True state of the robot at an instant.
///
/// `pose` is that of the body's origin, which lies under the middle of the axle at floor level when the body is at rest; its heading counts whole
/// turns and is not wrapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Time since the start of the run.
    pub time_s: f64,
    /// True pose of the robot in the plane, `world_from_robot`.
    pub pose: Pose,
    /// Forward speed, leftward speed and turn rate of the robot's origin, robot frame.
    pub velocity: [f64; 3],
    /// Height of the robot's origin above where it is when the robot is at rest on level floor.
    pub heave_m: f64,
    /// Rotation of the body about robot x (roll) and robot y (pitch) against the floor.
    pub tilt_rad: [f64; 2],
    /// Spin angle of the left and of the right wheel since the start.
    pub wheel_angle_rad: [f64; 2],
    /// Steering angle of a car, that of a wheel in the middle of its front axle, positive to the left; 0 where nothing is steered.
    pub steering_rad: f64,
    /// True travel over the floor of the left and of the right wheel's contact point, measured along the robot's x axis and added up since the start.
    pub wheel_travel_m: [f64; 2],
    /// True travel of the robot's origin to its left, along the robot's y axis, added up since the start.
    pub lateral_travel_m: f64,
}

impl Truth {
    /// Pose of the body in the world: Rz(heading)·Ry(pitch)·Rx(roll) at (x, y, heave).
    pub fn world_from_body(&self) -> Isometry3<f64> {
        let [roll_rad, pitch_rad] = self.tilt_rad;
        Isometry3::from_parts(
            Translation3::new(self.pose.x_m, self.pose.y_m, self.heave_m),
            // nalgebra's Euler angles mean exactly the product Rz(yaw)·Ry(pitch)·Rx(roll).
            UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, self.pose.heading_rad),
        )
    }

    /// The state with its pose moved on by a short time, forwards or backwards, at constant velocity.
    pub fn moved_on(&self, after_s: f64) -> Truth {
        let [forward_m_per_s, left_m_per_s, turn_rad_per_s] = self.velocity;
        // During a short time the robot is taken to move in the direction that it has halfway through that time.
        let (sin, cos) = (self.pose.heading_rad + 0.5 * turn_rad_per_s * after_s).sin_cos();
        let pose = Pose {
            x_m: self.pose.x_m + after_s * (cos * forward_m_per_s - sin * left_m_per_s),
            y_m: self.pose.y_m + after_s * (sin * forward_m_per_s + cos * left_m_per_s),
            heading_rad: self.pose.heading_rad + turn_rad_per_s * after_s,
        };
        Truth { pose, ..*self }
    }

    /// The state at `time_s` by linear interpolation between this state and a later one.
    pub fn interpolated(&self, later: &Truth, time_s: f64) -> Truth {
        let span_s = later.time_s - self.time_s;
        let share = if span_s > 0.0 { (time_s - self.time_s) / span_s } else { 0.0 };
        let mix = |from: f64, to: f64| from + share * (to - from);
        let mix2 = |from: [f64; 2], to: [f64; 2]| [mix(from[0], to[0]), mix(from[1], to[1])];
        Truth {
            time_s,
            pose: Pose {
                x_m: mix(self.pose.x_m, later.pose.x_m),
                y_m: mix(self.pose.y_m, later.pose.y_m),
                heading_rad: mix(self.pose.heading_rad, later.pose.heading_rad),
            },
            velocity: [0, 1, 2].map(|axis| mix(self.velocity[axis], later.velocity[axis])),
            heave_m: mix(self.heave_m, later.heave_m),
            tilt_rad: mix2(self.tilt_rad, later.tilt_rad),
            wheel_angle_rad: mix2(self.wheel_angle_rad, later.wheel_angle_rad),
            steering_rad: mix(self.steering_rad, later.steering_rad),
            wheel_travel_m: mix2(self.wheel_travel_m, later.wheel_travel_m),
            lateral_travel_m: mix(self.lateral_travel_m, later.lateral_travel_m),
        }
    }
}
