//! Checks of what a scene states about a log that another program recorded.

use super::Contradiction;
use crate::scene::{MethodName, Scene};

/// Adds all contradictions of the table `[log]` with itself and with the rest of the scene.
pub(super) fn contradictions(scene: &Scene, found: &mut Vec<Contradiction>) {
    let Some(log) = &scene.log else { return };
    let mut refuse = |key: &str, expected: &str| {
        found.push(Contradiction { key: format!("log.{key}"), expected: expected.to_owned() });
    };
    if log.topics.odometry.is_some() && log.topics.joints.is_some() {
        refuse(
            "topics.joints",
            "stands beside `odometry`, expected one of the two, from which the wheels' ways are taken",
        );
    }
    if log.joints.left == log.joints.right {
        refuse("joints.right", "is the joint of the left wheel too, expected two different ones");
    }
    if let Some(truth) = &log.truth {
        match (&truth.topic, &truth.tum) {
            (Some(_), Some(_)) => refuse("truth.tum", "stands beside `topic`, expected one of the two"),
            (None, None) => refuse("truth", "states no source, expected `topic` or `tum`"),
            _ => {}
        }
    }
    let fitted = [
        ("imu", log.topics.imu.is_some(), scene.robot.gyro.is_some(), "gyro"),
        ("floor_camera", log.topics.floor_camera.is_some(), scene.robot.floor_camera.is_some(), "floor_camera"),
        ("forward_camera", log.topics.forward_camera.is_some(), scene.robot.forward_camera.is_some(), "forward_camera"),
        ("ceiling_camera", log.topics.ceiling_camera.is_some(), scene.robot.ceiling_camera.is_some(), "ceiling_camera"),
        ("gnss", log.topics.gnss.is_some(), scene.robot.gnss.is_some(), "gnss"),
    ];
    for (topic, is_named, is_fitted, device) in fitted {
        if is_named && !is_fitted {
            refuse(
                &format!("topics.{topic}"),
                &format!("the robot has no such device, expected a table `[robot.{device}]`"),
            );
        }
    }
    if scene.localizer.methods.contains(&MethodName::GnssPositions) && log.gnss.is_none() {
        refuse(
            "gnss",
            "missing, expected latitude and longitude of the world's origin, as a method reads satellite positions",
        );
    }
    if scene.robot.flow.is_some() {
        refuse("topics", "no type of message is read as a flow sensor, expected `robot.flow = false`");
    }
    if scene.robot.steering_encoder.is_some() {
        refuse("topics", "no type of message is read as a steering encoder, expected `robot.steering_encoder = false`");
    }
    if scene.robot.range_camera.is_some() {
        refuse("topics", "no type of message is read as a range camera, expected `robot.range_camera = false`");
    }
}
