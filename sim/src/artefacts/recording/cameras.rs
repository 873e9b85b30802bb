//! The robot's cameras as recordings name and describe them.

use localizer::reading::Camera;
use nalgebra::{Isometry3, Translation3};

use crate::{
    devices::camera::DrawnCamera,
    optics::{Intrinsics, mounts::mount_from_looking_down},
    scene::Scene,
};

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
        let (mount, size_px) = match name {
            Camera::Floor => return NominalCamera::floor(scene),
            Camera::Forward => {
                let camera = scene.robot.forward_camera.as_ref()?;
                (DrawnCamera::forward(camera), [camera.width_px, camera.height_px])
            }
            Camera::Ceiling => {
                let camera = scene.robot.ceiling_camera.as_ref()?;
                (DrawnCamera::ceiling(camera), [camera.width_px, camera.height_px])
            }
        };
        let DrawnCamera { body_from_camera: robot_from_camera, focal_px, principal_point_px, distortion } = mount;
        Some(NominalCamera { name, size_px, focal_px, principal_point_px, distortion, robot_from_camera })
    }

    fn floor(scene: &Scene) -> Option<NominalCamera> {
        let camera = scene.robot.floor_camera.as_ref()?;
        let size_px = [camera.width_px, camera.height_px];
        let focal_px = f64::from(camera.width_px) / camera.footprint_width_m * camera.height_m;
        let place = Translation3::new(camera.forward_m, camera.left_m, camera.height_m);
        Some(NominalCamera {
            name: Camera::Floor,
            size_px,
            focal_px: [focal_px; 2],
            principal_point_px: Intrinsics::centred(size_px, focal_px).principal_point_px,
            distortion: camera.lens.distortion,
            robot_from_camera: Isometry3::from_parts(place, mount_from_looking_down()),
        })
    }
}
