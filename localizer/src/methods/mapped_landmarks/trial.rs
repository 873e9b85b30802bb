//! A camera that is projected with rotation matrices of `nalgebra`, written for tests alone.

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
};

use interval::Interval;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{DEVICE, PointCameraModel, SeenPoint};
use crate::{
    PoseBox, Reading,
    graph::{
        Constant,
        trial::{Draw, tilt},
    },
    map::Anchor,
    reading::LandmarkId,
    robot::BodyModel,
};

/// True values of a camera and a robot within the bounds of a model.
pub(crate) struct True {
    pub(crate) camera: PointCameraModel,
    pub(crate) body: BodyModel,
    pub(crate) constants: BTreeMap<Constant, f64>,
    pub(crate) mount_tilt: Rotation3<f64>,
}

/// A robot at an instant: pose, and the lean of its body with its Cayley vector in the frame of the posture's own heading.
pub(crate) struct At {
    pub(crate) pose: [f64; 3],
    pub(crate) heave_m: f64,
    pub(crate) world_from_body: Rotation3<f64>,
    pub(crate) lean: [f64; 2],
}

impl True {
    pub(crate) fn new(draw: &mut Draw, share: f64) -> True {
        let mut half = |value: f64| draw.or_zero(share * value);
        let camera = PointCameraModel {
            focal_px: Interval::centred(400.0, half(2.0)),
            centre_px: [319.5, 239.5].map(|at| Interval::centred(at, half(3.0))),
            tilt_up_rad: 0.2,
            yaw_rad: Interval::centred(0.4, half(0.01)),
            tilt_rad: half(0.01),
            position_m: [0.2, -0.1].map(|at| Interval::centred(at, half(0.005))),
            height_m: Interval::centred(0.5, half(0.005)),
            error_px: half(0.8) + 1e-9,
            least_depth_m: 0.4,
            stamp_error_s: 0.0,
        };
        let body = BodyModel { tilt_rad: half(0.01), heave_m: half(0.002), clearance_m: 0.2 };
        let (mount_tilt, cayley) = tilt(draw, camera.tilt_rad);
        let mut constants = BTreeMap::new();
        let mut put = |constant, value| constants.insert(constant, value);
        put(Constant::PointFocal, draw.within(camera.focal_px));
        put(Constant::PointYaw, draw.within(camera.yaw_rad));
        put(Constant::PointHeight, draw.within(camera.height_m));
        for (k, tilt) in cayley.into_iter().enumerate() {
            put(Constant::PointCentre(k), draw.within(camera.centre_px[k]));
            put(Constant::PointPosition(k), draw.within(camera.position_m[k]));
            put(Constant::PointTilt(k), tilt);
        }
        True { camera, body, constants, mount_tilt }
    }

    /// The robot at a place in any direction, with a lean and a heave at their bounds.
    pub(crate) fn at(&self, draw: &mut Draw, x_m: f64, y_m: f64) -> At {
        let turn_rad = draw.between(-PI, PI);
        self.turned(draw, [x_m, y_m], turn_rad)
    }

    /// The robot at a place, with its posture turned about the vertical, and a lean and a heave at their bounds.
    pub(crate) fn turned(&self, draw: &mut Draw, [x_m, y_m]: [f64; 2], turn_rad: f64) -> At {
        let (lean, cayley) = tilt(draw, self.body.tilt_rad);
        let world_from_body = Rotation3::from_axis_angle(&Vector3::z_axis(), turn_rad) * lean;
        let forward = world_from_body * Vector3::x();
        let pose = [x_m, y_m, forward.y.atan2(forward.x)];
        let heave_m = draw.within(Interval::centred(0.0, self.body.heave_m));
        At { pose, heave_m, world_from_body, lean: cayley }
    }

    /// The optical centre in the world, and the rotation from the frame of the camera (x right, y down, z ahead) to the world.
    pub(crate) fn camera_at(&self, at: &At) -> (Vector3<f64>, Rotation3<f64>) {
        let constant = |constant| self.constants[&constant];
        let mount = Vector3::new(
            constant(Constant::PointPosition(0)),
            constant(Constant::PointPosition(1)),
            constant(Constant::PointHeight),
        );
        let centre = Vector3::new(at.pose[0], at.pose[1], at.heave_m) + at.world_from_body * mount;
        // The columns are the camera's axes for a level camera: right is −y, down is −z, ahead is x.
        let level = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0));
        let up = Rotation3::from_axis_angle(&Vector3::y_axis(), -self.camera.tilt_up_rad);
        let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), constant(Constant::PointYaw));
        (centre, at.world_from_body * yaw * self.mount_tilt * up * level)
    }

    /// A point of the world in the camera: its pixel without error, and its depth.
    pub(crate) fn project(&self, at: &At, point: Vector3<f64>) -> ([f64; 2], f64) {
        let (centre, world_from_camera) = self.camera_at(at);
        let seen = world_from_camera.inverse() * (point - centre);
        let focal = self.constants[&Constant::PointFocal];
        let pixel = [0, 1].map(|k| self.constants[&Constant::PointCentre(k)] + focal * seen[k] / seen[2]);
        (pixel, seen[2])
    }

    pub(crate) fn with_error(&self, draw: &mut Draw, at_px: [f64; 2]) -> [f64; 2] {
        at_px.map(|at| at + draw.within(Interval::centred(0.0, self.camera.error_px)))
    }

    /// A point that the camera sees at a depth, within the picture.
    pub(crate) fn seen_point(&self, draw: &mut Draw, at: &At, depth_m: f64) -> Vector3<f64> {
        let (centre, world_from_camera) = self.camera_at(at);
        let in_camera = Vector3::new(draw.between(-0.7, 0.7), draw.between(-0.5, 0.5), 1.0) * depth_m;
        centre + world_from_camera * in_camera
    }
}

/// α, β and ρ of a point of the world.
pub(crate) fn homogeneous(anchor: &Anchor, point: Vector3<f64>) -> [f64; 3] {
    let from = [0, 1, 2].map(|k| point[k] - anchor.from_m[k]);
    let depth = from[anchor.axis] * anchor.sign();
    let [i, j] = anchor.sides();
    [from[i] / depth, from[j] / depth, 1.0 / depth]
}

pub(crate) fn around(draw: &mut Draw, at: f64, half: f64) -> Interval {
    let off = draw.within(Interval::centred(0.0, half));
    Interval::centred(at + off, half + 1e-12)
}

pub(crate) fn depth(draw: &mut Draw, least_m: f64) -> f64 {
    if draw.unit() < 0.2 { least_m } else { draw.size(least_m, 1e4) }
}

pub(crate) fn reading(stamp_s: f64, seen: &[SeenPoint]) -> Reading {
    let numbers = SeenPoint::numbers(seen);
    Reading::Other { measured_s: stamp_s, arrived_s: stamp_s, device: DEVICE.to_owned(), numbers }
}

/// What a robot sees of some landmarks.
pub(crate) fn look(truth: &True, draw: &mut Draw, at: &At, landmarks: &[Vector3<f64>]) -> Vec<SeenPoint> {
    let mut seen = Vec::new();
    for (number, &landmark) in (0..).zip(landmarks) {
        let (exact_px, depth_m) = truth.project(at, landmark);
        let is_inside = (0.0..640.0).contains(&exact_px[0]) && (0.0..480.0).contains(&exact_px[1]);
        if depth_m >= truth.camera.least_depth_m && is_inside {
            seen.push(SeenPoint { landmark: LandmarkId(number), at_px: truth.with_error(draw, exact_px) });
        }
    }
    seen
}

/// Landmarks on the walls of a room of 10 m × 10 m about the origin.
pub(crate) fn walls(draw: &mut Draw, n: usize) -> Vec<Vector3<f64>> {
    (0..n)
        .map(|_| {
            let turn = f64::from((draw.unit() * 4.0) as u32) * 0.25 * TAU;
            let along = Vector3::new(5.0, draw.between(-5.0, 5.0), draw.between(0.2, 2.5));
            Rotation3::from_axis_angle(&Vector3::z_axis(), turn) * along
        })
        .collect()
}

pub(crate) fn boxed(draw: &mut Draw, pose: [f64; 3], halves: [f64; 3]) -> PoseBox {
    PoseBox::from([0, 1, 2].map(|k| around(draw, pose[k], halves[k])))
}

/// Whether a pose is within a box, up to rounding.
pub(crate) fn is_within(truth: [f64; 3], pose: &PoseBox) -> bool {
    (0..3).all(|k| pose[k].inflate(1e-12).contains(truth[k]))
}
