//! Standard ROS 2 messages: poses, transforms, images, calibration, joints, log.

use std::f64::consts::TAU;

use image::GrayImage;
use localizer::{Pose, methods::wall_ranges::Scan};
use nalgebra::Isometry3;

use super::{
    cameras::{NominalCamera, topics},
    cdr::Message,
};
use crate::{scene::Scanner, truth::Truth};

pub(super) const WORLD: &str = "world";
pub(super) const ROBOT: &str = "robot";
pub(super) const TRUE_ROBOT: &str = "true_robot";
pub(super) const SCANNER: &str = "scanner";

/// Severity of a `rcl_interfaces/Log` message.
#[derive(Clone, Copy)]
pub(super) enum Level {
    Info = 20,
    Warn = 30,
    Error = 40,
}

/// A `geometry_msgs/PoseStamped` in the frame `world`.
pub(super) fn pose_stamped(time_s: f64, pose: Pose) -> Vec<u8> {
    Message::new().header(time_s, WORLD).with(|message| planar_pose(message, pose, 0.0)).finish()
}

/// A `nav_msgs/Odometry` with the true pose, and with the true velocity in the robot's frame. The body's small tilt is left out.
pub(super) fn true_odometry(time_s: f64, truth: &Truth) -> Vec<u8> {
    let [forward_m_per_s, left_m_per_s, turn_rad_per_s] = truth.velocity;
    Message::new()
        .header(time_s, WORLD)
        .text(TRUE_ROBOT)
        .with(|message| planar_pose(message, truth.pose, truth.heave_m))
        .f64s(&[0.0; 36])
        .f64s(&[forward_m_per_s, left_m_per_s, 0.0, 0.0, 0.0, turn_rad_per_s])
        .f64s(&[0.0; 36])
        .finish()
}

/// A `tf2_msgs/TFMessage` with the poses of bodies in the frame `world`.
pub(super) fn world_from_bodies(time_s: f64, bodies: &[(&str, Pose)]) -> Vec<u8> {
    let transform = |message: Message, &(body, pose): &(&str, Pose)| {
        message.header(time_s, WORLD).text(body).with(|message| planar_pose(message, pose, 0.0))
    };
    bodies.iter().fold(Message::new().length(bodies.len()), transform).finish()
}

/// A `tf2_msgs/TFMessage` with the nominal mounts of devices in the frame `robot`: the frame of each device and its pose.
pub(super) fn robot_from_devices(mounts: &[(&str, Isometry3<f64>)]) -> Vec<u8> {
    let transform = |message: Message, (frame, pose): &(&str, Isometry3<f64>)| {
        let (place, turn) = (pose.translation.vector, pose.rotation.coords);
        message
            .header(0.0, ROBOT)
            .text(frame)
            .f64s(&[place.x, place.y, place.z])
            .f64s(&[turn.x, turn.y, turn.z, turn.w])
    };
    mounts.iter().fold(Message::new().length(mounts.len()), transform).finish()
}

/// A `sensor_msgs/Image` in grey levels.
pub(super) fn image(time_s: f64, frame: &str, image: &GrayImage) -> Vec<u8> {
    Message::new()
        .header(time_s, frame)
        .u32(image.height())
        .u32(image.width())
        .text("mono8")
        .u8(0)
        .u32(image.width())
        .bytes(image.as_raw())
        .finish()
}

/// A `sensor_msgs/CameraInfo` with nominal calibration: each value in the middle of the bounds that the localizer is given.
pub(super) fn camera_info(time_s: f64, camera: &NominalCamera) -> Vec<u8> {
    let ([fu, fv], [cu, cv]) = (camera.focal_px, camera.principal_point_px);
    Message::new()
        .header(time_s, topics(camera.name).frame)
        .u32(camera.size_px[1])
        .u32(camera.size_px[0])
        .text("plumb_bob")
        .f64_sequence(&camera.distortion)
        .f64s(&[fu, 0.0, cu, 0.0, fv, cv, 0.0, 0.0, 1.0])
        .f64s(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
        .f64s(&[fu, 0.0, cu, 0.0, 0.0, fv, cv, 0.0, 0.0, 0.0, 1.0, 0.0])
        // The camera info states no binning; a region of interest of zeros stands for the whole image.
        .u32(0)
        .u32(0)
        .u32(0)
        .u32(0)
        .u32(0)
        .u32(0)
        .bool(false)
        .finish()
}

/// A `sensor_msgs/JointState` with the angles of both wheels as their encoders measure them.
pub(super) fn wheel_angles(time_s: f64, ticks: [i64; 2], ticks_per_turn: f64) -> Vec<u8> {
    Message::new()
        .header(time_s, "")
        .length(2)
        .text("left_wheel")
        .text("right_wheel")
        .f64_sequence(&ticks.map(|count| count as f64 / ticks_per_turn * TAU))
        .f64_sequence(&[])
        .f64_sequence(&[])
        .finish()
}

/// A `sensor_msgs/JointState` with a car's steering angle as its encoder measures it.
pub(super) fn steering_angle(time_s: f64, angle_rad: f64) -> Vec<u8> {
    Message::new()
        .header(time_s, "")
        .length(1)
        .text("steering")
        .f64_sequence(&[angle_rad])
        .f64_sequence(&[])
        .f64_sequence(&[])
        .finish()
}

/// A `sensor_msgs/Imu` with the rate of a gyroscope about the vertical; −1 as the first covariance says that the quantity is not measured.
pub(super) fn turn_rate(time_s: f64, rate_rad_per_s: f64) -> Vec<u8> {
    let unmeasured = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    Message::new()
        .header(time_s, ROBOT)
        .f64s(&[0.0, 0.0, 0.0, 1.0])
        .f64s(&unmeasured)
        .f64s(&[0.0, 0.0, rate_rad_per_s])
        .f64s(&[0.0; 9])
        .f64s(&[0.0; 3])
        .f64s(&unmeasured)
        .finish()
}

/// A `sensor_msgs/LaserScan` of a range scanner with the given keys. By the definition of the message, a beam that met nothing has an infinite
/// distance.
pub(super) fn laser_scan(time_s: f64, scan: &Scan, scanner: &Scanner) -> Vec<u8> {
    let n_beams = scan.distances_m.len();
    let last_rad = scan.first_rad + scan.step_rad * n_beams.saturating_sub(1) as f64;
    let numbers =
        [scan.first_rad, last_rad, scan.step_rad, 0.0, scanner.period_s, 0.0, scanner.range_m + scanner.tolerance_m];
    let distances = scan.distances_m.iter().map(|distance_m| distance_m.unwrap_or(f64::INFINITY));
    let single = |message: Message, number: f64| message.f32(number as f32);
    let message = numbers.into_iter().fold(Message::new().header(time_s, SCANNER), single).length(n_beams);
    distances.fold(message, single).length(0).finish()
}

/// A `rcl_interfaces/Log` message.
pub(super) fn log(time_s: f64, level: Level, name: &str, text: &str) -> Vec<u8> {
    Message::new().time(time_s).u8(level as u8).text(name).text(text).text("").text("").u32(0).finish()
}

/// Adds a position in the plane and an attitude to a message; a rotation by ψ about z is the quaternion (0, 0, sin ψ/2, cos ψ/2).
pub(super) fn planar_pose(message: Message, pose: Pose, z_m: f64) -> Message {
    let (sin, cos) = (pose.heading_rad / 2.0).sin_cos();
    message.f64s(&[pose.x_m, pose.y_m, z_m, 0.0, 0.0, sin, cos])
}
