//! What cameras have in common: true mount and lens, how these are drawn at random, and how far they differ from the nominal ones.

mod lenses;

use localizer::bounds::Assumption;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::{
    optics::{Lens, mounts},
    scene::{Calibration, CeilingCamera, Distribution, ForwardCamera},
    truth::randomness::{draw_tilt, draw_within},
};

use super::{ToldKey, farthest};

pub use lenses::{world_from_camera, world_from_floor_camera};

/// True mount and lens of the floor camera.
#[derive(Clone, Copy, Debug)]
pub struct DrawnFloorCamera {
    /// Position of the camera's optical centre in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Height of the camera's optical centre above the floor with the body at rest.
    pub height_m: f64,
    /// Focal length in pixels; `focal_px / height_m` is the true scale of the image at rest.
    pub focal_px: f64,
    /// Rotation of the image about the body's vertical, counter-clockwise seen from above.
    pub yaw_rad: f64,
    /// Rotation vector by which the optical axis deviates from the body's vertical, about robot x and robot y; its norm is within the tolerance.
    pub tilt_rad: [f64; 2],
    /// Distortion coefficients k1, k2, p1, p2, k3 of Brown and Conrady's model.
    pub distortion: [f64; 5],
}

/// True mount and lens of a camera that looks ahead or up.
#[derive(Clone, Copy, Debug)]
pub struct DrawnCamera {
    /// Pose of the camera in the robot frame.
    pub body_from_camera: Isometry3<f64>,
    /// Focal lengths of the camera along u and v.
    pub focal_px: [f64; 2],
    /// Point at which the optical axis meets the image.
    pub principal_point_px: [f64; 2],
    /// Distortion coefficients k1, k2, p1, p2, k3 of Brown and Conrady's model.
    pub distortion: [f64; 5],
}

impl DrawnCamera {
    /// The forward camera without any error.
    pub fn forward(camera: &ForwardCamera) -> DrawnCamera {
        let size_px = [camera.width_px, camera.height_px].map(f64::from);
        DrawnCamera {
            body_from_camera: mounts::body_from_forward_camera(camera),
            focal_px: [mounts::forward_focal_px(camera); 2],
            principal_point_px: size_px.map(|size| (size - 1.0) / 2.0),
            distortion: camera.lens.distortion,
        }
    }

    /// The ceiling camera without any error.
    pub fn ceiling(camera: &CeilingCamera) -> DrawnCamera {
        DrawnCamera {
            body_from_camera: mounts::body_from_ceiling_camera(camera),
            focal_px: camera.focal_px,
            principal_point_px: camera.principal_point_px,
            distortion: camera.lens.distortion,
        }
    }

    /// This nominal camera with errors of mount and lens drawn within their tolerances; its distortion stays.
    pub(super) fn misplaced(
        self,
        calibration: &Calibration,
        errors: Distribution,
        rng: &mut ChaCha8Rng,
    ) -> DrawnCamera {
        let shift_m = [0; 3].map(|_| draw_within(calibration.position_tolerance_m, errors, rng));
        let tilt_rad = draw_tilt(calibration.angle_tolerance_deg, errors, rng);
        let yaw_rad = draw_within(calibration.angle_tolerance_deg.to_radians(), errors, rng);
        let scale = 1.0 + draw_within(calibration.focal_tolerance, errors, rng);
        let tolerance_px = calibration.principal_point_tolerance_px;
        DrawnCamera {
            body_from_camera: mounts::misplaced(self.body_from_camera, tilt_rad, yaw_rad, shift_m),
            focal_px: self.focal_px.map(|focal_px| focal_px * scale),
            principal_point_px: self.principal_point_px.map(|at_px| at_px + draw_within(tolerance_px, errors, rng)),
            ..self
        }
    }
}

/// How far a camera's true mount and lens differ from their nominal values.
pub(super) struct Off {
    /// Distances of the camera from its nominal position on the body: first the greater of those forward and left, then the distance up.
    pub(super) place_m: [f64; 2],
    pub(super) tilt_rad: f64,
    pub(super) yaw_rad: f64,
    /// Error of the focal length as a share of it, along the axis where it is greater.
    pub(super) focal: f64,
    pub(super) principal_point_px: f64,
}

impl Off {
    pub(super) fn of(drawn: &DrawnCamera, nominal: &DrawnCamera) -> Off {
        let shift_m = drawn.body_from_camera.translation.vector - nominal.body_from_camera.translation.vector;
        let turn = drawn.body_from_camera.rotation * nominal.body_from_camera.rotation.inverse();
        let (tilt_rad, yaw_rad) = tilt_and_yaw(turn);
        Off {
            place_m: [shift_m.x.abs().max(shift_m.y.abs()), shift_m.z.abs()],
            tilt_rad,
            yaw_rad: yaw_rad.abs(),
            focal: farthest([0, 1].map(|axis| drawn.focal_px[axis] / nominal.focal_px[axis]), [1.0; 2]),
            principal_point_px: farthest(drawn.principal_point_px, nominal.principal_point_px),
        }
    }
}

/// The two parts of a small rotation: the angle by which it tilts the vertical, and the angle by which it turns about the vertical.
fn tilt_and_yaw(turn: UnitQuaternion<f64>) -> (f64, f64) {
    let yaw_rad = 2.0 * turn.k.atan2(turn.w);
    ((turn * Vector3::z()).xy().norm().asin(), yaw_rad)
}

/// Greatest distance in pixels, along u or v, between the image points of one ray with the true and with the declared distortion
/// coefficients. It occurs at a corner of the image, as the error grows with the third power of the distance from the middle.
pub(super) fn bent_px(lens: &Lens, declared: [f64; 5]) -> f64 {
    let declared = Lens { distortion: declared, ..lens.clone() };
    let off_px = lens.corners().into_iter().flat_map(|ray| {
        let (seen, stated) = (lens.pixel(ray), declared.pixel(ray));
        [0, 1].map(|axis| (seen[axis] - stated[axis]).abs())
    });
    off_px.fold(0.0, f64::max)
}

/// Names of the bounds on the calibration of the forward or the ceiling camera, grouped by the key of the scene that states them.
pub(super) struct CalibrationBounds {
    pub(super) position: &'static [Assumption],
    pub(super) angles: &'static [Assumption],
    pub(super) focal: &'static [Assumption],
    pub(super) principal_point: &'static [Assumption],
    pub(super) distortion: &'static [Assumption],
}

impl CalibrationBounds {
    /// The keys of a camera's calibration that state the bounds named in this table, without keys whose bound has no name.
    pub(super) fn told_keys<'a>(&self, calibration: &'a mut Calibration) -> Vec<ToldKey<'a>> {
        let keys = [
            ToldKey::is(self.position, &mut calibration.position_tolerance_m),
            ToldKey::is_in_deg(self.angles, &mut calibration.angle_tolerance_deg),
            ToldKey::is(self.focal, &mut calibration.focal_tolerance),
            ToldKey::is(self.principal_point, &mut calibration.principal_point_tolerance_px),
            ToldKey::is(self.distortion, &mut calibration.distortion_tolerance_px),
        ];
        keys.into_iter().filter(|key| !key.bounds.is_empty()).collect()
    }
}
