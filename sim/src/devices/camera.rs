//! A camera as it truly is: its mount and lens, how these are drawn at random, and how far they differ from the nominal ones.

mod lenses;

use localizer::{bounds::Assumption, reading::Camera};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::{
    optics::{Lens, mounts},
    scene::{Calibration, CameraKeys, Distribution},
    truth::randomness::{draw_tilt, draw_within, stream},
};

use super::{DrawnDevices, ToldKey, farthest};

pub use lenses::world_from_camera;

/// True mount and lens of a camera.
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
    /// A camera without any error.
    pub fn nominal(camera: &dyn CameraKeys) -> DrawnCamera {
        DrawnCamera {
            body_from_camera: mounts::body_from_camera(camera),
            focal_px: camera.focal_px(),
            principal_point_px: camera.principal_point_px(),
            distortion: camera.shared().lens.distortion,
        }
    }

    /// A camera with errors of mount and lens that are drawn within the tolerances of its calibration.
    pub(super) fn draw(
        camera: &dyn CameraKeys,
        calibration: &Calibration,
        errors: Distribution,
        seed: u64,
    ) -> DrawnCamera {
        let rng = &mut stream(seed, &format!("{}_camera.mount", camera.name().as_str()));
        let drawn = DrawnCamera::nominal(camera).misplaced(calibration, errors, rng);
        drawn.bent(camera, calibration.distortion_tolerance_px, errors, seed)
    }

    /// This nominal camera with errors of mount and lens drawn within their tolerances; its distortion stays.
    fn misplaced(self, calibration: &Calibration, errors: Distribution, rng: &mut ChaCha8Rng) -> DrawnCamera {
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

    /// This camera with an error of its distortion that moves no pixel by more than the tolerance.
    pub(super) fn bent(
        self,
        camera: &dyn CameraKeys,
        tolerance_px: f64,
        errors: Distribution,
        seed: u64,
    ) -> DrawnCamera {
        let rng = &mut stream(seed, &format!("{}_camera.distortion", camera.name().as_str()));
        let off_px = draw_within(tolerance_px, errors, rng);
        DrawnCamera { distortion: Lens::of(camera, &self).bent_further(off_px), ..self }
    }
}

impl DrawnDevices {
    /// True mount and lens of the camera of this name; `None` if the robot does not have it.
    pub fn camera(&self, name: Camera) -> Option<DrawnCamera> {
        match name {
            Camera::Floor => self.floor_camera,
            Camera::Forward => self.forward_camera,
            Camera::Ceiling => self.ceiling_camera,
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
    /// Greatest distance along u or v, anywhere in the image, between where the true distortion and the stated one put a pixel.
    pub(super) bent_px: f64,
}

impl Off {
    pub(super) fn of(drawn: &DrawnCamera, camera: &dyn CameraKeys) -> Off {
        let nominal = DrawnCamera::nominal(camera);
        let shift_m = drawn.body_from_camera.translation.vector - nominal.body_from_camera.translation.vector;
        let turn = drawn.body_from_camera.rotation * nominal.body_from_camera.rotation.inverse();
        let (tilt_rad, yaw_rad) = tilt_and_yaw(turn);
        Off {
            place_m: [shift_m.x.abs().max(shift_m.y.abs()), shift_m.z.abs()],
            tilt_rad,
            yaw_rad: yaw_rad.abs(),
            focal: farthest([0, 1].map(|axis| drawn.focal_px[axis] / nominal.focal_px[axis]), [1.0; 2]),
            principal_point_px: farthest(drawn.principal_point_px, nominal.principal_point_px),
            bent_px: bent_px(&Lens::of(camera, drawn), nominal.distortion),
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
fn bent_px(lens: &Lens, declared: [f64; 5]) -> f64 {
    let declared = Lens { distortion: declared, ..lens.clone() };
    let off_px = lens.corners().into_iter().flat_map(|ray| {
        let (seen, stated) = (lens.pixel(ray), declared.pixel(ray));
        [0, 1].map(|axis| (seen[axis] - stated[axis]).abs())
    });
    off_px.fold(0.0, f64::max)
}

/// Names of the bounds on the calibration of a camera, grouped by the key of the scene that states them.
pub(super) struct CalibrationBounds {
    /// Bounds on the position forward and left, and on the height.
    pub(super) position: &'static [Assumption],
    /// Bounds on yaw and on tilt.
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

    /// The bounds named in this table, each with the declared value and the true one.
    pub(super) fn constants(
        &self,
        calibration: &Calibration,
        camera: &dyn CameraKeys,
        drawn: &DrawnCamera,
    ) -> Vec<(Assumption, f64, f64)> {
        let off = Off::of(drawn, camera);
        let groups: [(&[Assumption], f64, &[f64]); 5] = [
            (self.position, calibration.position_tolerance_m, &off.place_m),
            (self.angles, calibration.angle_tolerance_deg.to_radians(), &[off.yaw_rad, off.tilt_rad]),
            (self.focal, calibration.focal_tolerance, &[off.focal]),
            (self.principal_point, calibration.principal_point_tolerance_px, &[off.principal_point_px]),
            (self.distortion, calibration.distortion_tolerance_px, &[off.bent_px]),
        ];
        let of_group = |(names, declared, off): (&[Assumption], f64, &[f64])| {
            names.iter().zip(off).map(|(name, off)| (*name, declared, *off)).collect::<Vec<_>>()
        };
        groups.into_iter().flat_map(of_group).collect()
    }
}
