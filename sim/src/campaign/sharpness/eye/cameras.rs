//! The cameras whose images are checked: how each looks from the robot, and which of its constants are declared with which bounds.

use interval::Interval;
use localizer::{RobotModel, bounds, reading::Camera};

use crate::devices::camera::DrawnCamera;

use super::{super::history::CameraPart, Eye, Input};

/// The floor camera: calibrated by the scale of its image on the floor, at its nominal height.
pub(super) fn floor(robot: &RobotModel, drawn: &DrawnCamera, stamp_error_s: f64) -> Option<Eye> {
    let model = robot.floor_camera.as_ref()?;
    let tilts_rad = Interval::new(-model.tilt_rad, model.tilt_rad);
    let [cu, cv] = drawn.principal_point_px.map(Input::Known);
    let of = |part| Input::Quantity(part, 1.0);
    let focal = Input::Quantity(CameraPart::Focal(0), model.height_m);
    Some(Eye {
        camera: Camera::Floor,
        // Image right is robot right, image down is robot backward.
        axes: [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
        lean_rad: [0.0; 2],
        tilts_last: true,
        distortion: drawn.distortion,
        constants: [
            of(CameraPart::Position(0)),
            of(CameraPart::Position(1)),
            Input::Known(model.height_m),
            of(CameraPart::Yaw),
            of(CameraPart::Tilt(0)),
            of(CameraPart::Tilt(1)),
            focal,
            focal,
            cu,
            cv,
        ],
        declared: vec![
            (CameraPart::Position(0), model.position_m[0], bounds::FLOOR_CAMERA_POSITION),
            (CameraPart::Position(1), model.position_m[1], bounds::FLOOR_CAMERA_POSITION),
            (CameraPart::Yaw, model.yaw_rad, bounds::FLOOR_CAMERA_YAW),
            (CameraPart::Tilt(0), tilts_rad, bounds::FLOOR_CAMERA_TILT),
            (CameraPart::Tilt(1), tilts_rad, bounds::FLOOR_CAMERA_TILT),
            (CameraPart::Focal(0), model.pixels_per_m, bounds::FLOOR_CAMERA_SCALE),
        ],
        tilt: (model.tilt_rad, bounds::FLOOR_CAMERA_TILT),
        stamp: (stamp_error_s, bounds::FLOOR_CAMERA_STAMP),
    })
}

/// The ceiling camera.
pub(super) fn ceiling(robot: &RobotModel, drawn: &DrawnCamera, stamp_error_s: f64) -> Option<Eye> {
    let model = robot.ceiling_camera.as_ref()?;
    let tilts_rad = Interval::new(-model.tilt_rad, model.tilt_rad);
    let turned_rad = model.yaw_rad - model.yaw_rad.mid();
    let [forward, left] = model.lean_rad.map(|lean_rad| -lean_rad);
    let parts = [
        (CameraPart::Position(0), model.position_m[0], bounds::CEILING_CAMERA_POSITION),
        (CameraPart::Position(1), model.position_m[1], bounds::CEILING_CAMERA_POSITION),
        (CameraPart::Position(2), model.height_m, bounds::CEILING_CAMERA_HEIGHT),
        (CameraPart::Yaw, turned_rad, bounds::CEILING_CAMERA_YAW),
        (CameraPart::Tilt(0), tilts_rad, bounds::CEILING_CAMERA_TILT),
        (CameraPart::Tilt(1), tilts_rad, bounds::CEILING_CAMERA_TILT),
        (CameraPart::Focal(0), model.focal_px[0], bounds::CEILING_CAMERA_FOCAL),
        (CameraPart::Focal(1), model.focal_px[1], bounds::CEILING_CAMERA_FOCAL),
        (CameraPart::Centre(0), model.centre_px[0], bounds::CEILING_CAMERA_CENTRE),
        (CameraPart::Centre(1), model.centre_px[1], bounds::CEILING_CAMERA_CENTRE),
    ];
    Some(Eye {
        camera: Camera::Ceiling,
        // Image right is robot right, image down is robot forward.
        axes: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        lean_rad: [-left, forward],
        tilts_last: false,
        distortion: drawn.distortion,
        constants: parts.map(|(part, ..)| Input::Quantity(part, 1.0)),
        declared: parts.to_vec(),
        tilt: (model.tilt_rad, bounds::CEILING_CAMERA_TILT),
        stamp: (stamp_error_s, bounds::CEILING_CAMERA_STAMP),
    })
}

/// The forward camera. Directions are all that its images are used for, so that the witness keeps its position.
pub(super) fn forward(robot: &RobotModel, drawn: &DrawnCamera, stamp_error_s: f64) -> Option<Eye> {
    let model = robot.forward_camera.as_ref()?;
    let tilts_rad = Interval::new(-model.tilt_error_rad, model.tilt_error_rad);
    let (sin, cos) = model.yaw_rad.mid().sin_cos();
    let of = |part| Input::Quantity(part, 1.0);
    let place = |axis: usize| Input::Known(drawn.body_from_camera.translation.vector[axis]);
    Some(Eye {
        camera: Camera::Forward,
        // Image right is robot right, image down is robot down, once the nominal yaw is undone.
        axes: [[sin, -cos, 0.0], [0.0, 0.0, -1.0], [cos, sin, 0.0]],
        // The nominal tilt raises what is ahead, about the image's right.
        lean_rad: [model.tilt_up_rad * sin, -model.tilt_up_rad * cos],
        tilts_last: false,
        distortion: drawn.distortion,
        constants: [
            place(0),
            place(1),
            place(2),
            of(CameraPart::Yaw),
            of(CameraPart::Tilt(0)),
            of(CameraPart::Tilt(1)),
            of(CameraPart::Focal(0)),
            of(CameraPart::Focal(0)),
            of(CameraPart::Centre(0)),
            of(CameraPart::Centre(1)),
        ],
        declared: vec![
            (CameraPart::Yaw, model.yaw_rad - model.yaw_rad.mid(), bounds::FORWARD_CAMERA_YAW),
            (CameraPart::Tilt(0), tilts_rad, bounds::FORWARD_CAMERA_TILT),
            (CameraPart::Tilt(1), tilts_rad, bounds::FORWARD_CAMERA_TILT),
            (CameraPart::Focal(0), model.focal_px, bounds::FORWARD_CAMERA_FOCAL),
            (CameraPart::Centre(0), model.principal_point_px[0], bounds::FORWARD_CAMERA_PRINCIPAL_POINT),
            (CameraPart::Centre(1), model.principal_point_px[1], bounds::FORWARD_CAMERA_PRINCIPAL_POINT),
        ],
        tilt: (model.tilt_error_rad, bounds::FORWARD_CAMERA_TILT),
        stamp: (stamp_error_s, bounds::FORWARD_CAMERA_STAMP),
    })
}
