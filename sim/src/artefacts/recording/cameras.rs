//! The robot's cameras as recordings name and describe them.

use localizer::reading::Camera;
use nalgebra::Isometry3;

use crate::{devices::camera::DrawnCamera, scene::Scene};

/// Names of a camera's coordinate frame and of its topics.
pub(crate) struct Topics {
    pub(crate) frame: &'static str,
    pub(crate) image: &'static str,
    pub(super) camera_info: &'static str,
}

/// A camera with nominal calibration: each value in the middle of the bounds that the localizer is given.
pub(super) struct NominalCamera {
    pub(super) name: Camera,
    pub(super) size_px: [u32; 2],
    pub(super) focal_px: [f64; 2],
    pub(super) principal_point_px: [f64; 2],
    /// Distortion coefficients k1, k2, p1, p2, k3.
    pub(super) distortion: [f64; 5],
    pub(super) robot_from_camera: Isometry3<f64>,
}

pub(crate) const fn topics(camera: Camera) -> Topics {
    match camera {
        Camera::Floor => {
            Topics { frame: "floor_camera", image: "/floor_camera/image", camera_info: "/floor_camera/camera_info" }
        }
        Camera::Forward => Topics {
            frame: "forward_camera",
            image: "/forward_camera/image",
            camera_info: "/forward_camera/camera_info",
        },
        Camera::Ceiling => Topics {
            frame: "ceiling_camera",
            image: "/ceiling_camera/image",
            camera_info: "/ceiling_camera/camera_info",
        },
    }
}

impl NominalCamera {
    /// The nominal cameras of the scene's robot.
    pub(super) fn all(scene: &Scene) -> Vec<NominalCamera> {
        Camera::ALL.into_iter().filter_map(|name| NominalCamera::of(scene, name)).collect()
    }

    fn of(scene: &Scene, name: Camera) -> Option<NominalCamera> {
        let camera = scene.robot.camera(name)?;
        let DrawnCamera { body_from_camera, focal_px, principal_point_px, distortion } = DrawnCamera::nominal(camera);
        let size_px = camera.shared().size_px;
        Some(NominalCamera {
            name,
            size_px,
            focal_px,
            principal_point_px,
            distortion,
            robot_from_camera: body_from_camera,
        })
    }
}
