//! The true state of the world at an instant. It reaches the sensors, the check and the record, never the localizer.

use localizer::Pose;

/// True state of the robot.
///
/// `pose` is that of the body's origin, which lies under the middle of the axle at floor level when the body is at rest;
/// its heading is unwrapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Time since the start.
    pub time_s: f64,
    /// `world_from_robot` in the plane.
    pub pose: Pose,
    /// Forward speed, leftward speed and turn rate of the robot origin, robot frame.
    pub velocity: [f64; 3],
    /// Height of the robot origin above its height at rest.
    pub heave_m: f64,
    /// Rotation of the body about robot x (roll) and robot y (pitch) against the floor.
    pub tilt_rad: [f64; 2],
    /// Spin angle of the left and of the right wheel since the start.
    pub wheel_angle_rad: [f64; 2],
    /// True travel over the floor of the left and of the right wheel's contact point along the robot's x axis, accumulated.
    pub wheel_travel_m: [f64; 2],
    /// True travel of the robot origin along the robot's y axis, accumulated.
    pub lateral_travel_m: f64,
}
