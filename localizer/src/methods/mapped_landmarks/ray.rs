//! How a landmark's image point depends on the pose, the camera and the landmark, with every declared error as a parameter.
//!
//! Let P be the robot's position at the heave h, θ its heading, δ what the definition of the heading leaves open, a the optical centre in the robot
//! frame, T(b) the lean of the body, T(m) that of the mount, and N the nominal attitude of the camera before its yaw. For a landmark L with the
//! anchor A and (L − A)·ρ = d, the vector from the optical centre to L, times ρ, is in the frame of the camera
//!
//! ```text
//! x = Nᵀ T(−m) Rz(−yaw) [ T(−b) Rz(−θ − δ) (d + ρ·(A − P)) − ρ·a ]
//! ```
//!
//! and an image point (u, v) with an error of at most e says
//!
//! f·x₁ + (cᵤ − u)·x₃ = 0 ± e·x₃   and   f·x₂ + (cᵥ − v)·x₃ = 0 ± e·x₃.
//!
//! No depth is divided by, so that both hold for a landmark at infinite depth, too. Tilts are written as Cayley vectors ([`tilted`]).

use interval::{Dual, Interval};

use crate::{
    PoseBox,
    graph::{Constant, Variable},
    map::{Anchor, SpacePoint},
    reading::LandmarkId,
    robot::{BodyModel, cayley_radius},
};

use super::{
    super::{lean::heading_off_rad, tilt::tilted},
    camera::PointCameraModel,
};

/// Number of parameters of an image point's equations. The constants below are the indices of the parameters.
pub(super) const N_PARAMETERS: usize = 19;
pub(super) const POINT: [usize; 3] = [0, 1, 2];
const POSE: [usize; 3] = [3, 4, 5];
const BODY_TILT: [usize; 2] = [6, 7];
const MOUNT_TILT: [usize; 2] = [8, 9];
const YAW: usize = 10;
const FOCAL: usize = 11;
const CENTRE: [usize; 2] = [12, 13];
const POSITION: [usize; 2] = [14, 15];
const HEIGHT: usize = 16;
pub(super) const HEAVE: usize = 17;
pub(super) const TURN: usize = 18;

/// The parameter `index` with its interval as a number with derivatives by the first `K` parameters.
fn number<const K: usize>(parameters: &Parameters, index: usize) -> Dual<K> {
    if index < K { Dual::parameter(index, parameters[index]) } else { Dual::constant(parameters[index]) }
}

/// The intervals of all parameters of an image point's equations.
pub(super) type Parameters = [Interval; N_PARAMETERS];

/// Known values of the camera and the body.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    pub(super) camera: PointCameraModel,
    pub(super) body: BodyModel,
    /// Cosine and sine of the nominal upward tilt.
    up: [Interval; 2],
    /// The cameras and bodies of the drives that taught the map.
    pub(super) taught: Vec<Optics>,
}

/// Which picture shows an image point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Picture {
    /// That of the key frame with the given number.
    Own(usize),
    /// One of the drive that taught the map, by its index among those of the map, and by the index of that drive's camera.
    Taught(usize, usize),
}

/// The quantity of the graph that a parameter is; `None` for what is each reading's own.
pub(super) fn variable(parameter: usize, picture: Picture, landmark: LandmarkId) -> Option<Variable> {
    let frame = match picture {
        Picture::Own(frame) => frame,
        Picture::Taught(index, camera) => {
            let shared = match variable(parameter, Picture::Own(0), landmark)? {
                Variable::Pose(_, axis) => Variable::ViewPose(index, axis),
                // What matters little of the camera that taught is enclosed.
                Variable::Constant(one @ (Constant::PointYaw | Constant::PointTilt(_) | Constant::PointCentre(_))) => {
                    Variable::ViewConstant(camera, one)
                }
                point @ Variable::Point(..) => point,
                _ => return None,
            };
            return Some(shared);
        }
    };
    let at = |indices: &[usize]| indices.iter().position(|&index| index == parameter);
    let constant = Variable::Constant;
    None.or_else(|| at(&POINT).map(|k| Variable::Point(landmark, k)))
        .or_else(|| at(&POSE).map(|k| Variable::Pose(frame, k)))
        .or_else(|| at(&BODY_TILT).map(|k| Variable::BodyTilt(frame, k)))
        .or_else(|| at(&MOUNT_TILT).map(|k| constant(Constant::PointTilt(k))))
        .or_else(|| at(&CENTRE).map(|k| constant(Constant::PointCentre(k))))
        .or_else(|| at(&POSITION).map(|k| constant(Constant::PointPosition(k))))
        .or_else(|| at(&[YAW]).map(|_| constant(Constant::PointYaw)))
        .or_else(|| at(&[FOCAL]).map(|_| constant(Constant::PointFocal)))
        .or_else(|| at(&[HEIGHT]).map(|_| constant(Constant::PointHeight)))
}

impl Optics {
    pub(super) fn new(camera: PointCameraModel, body: BodyModel) -> Optics {
        let up = Interval::point(camera.tilt_up_rad);
        Optics { camera, body, up: [up.cos(), up.sin()], taught: Vec::new() }
    }

    /// The intervals that the camera and the body have, with those of a pose and of a landmark's α, β and ρ.
    pub(super) fn parameters(&self, pose: &PoseBox, point: [Interval; 3]) -> Parameters {
        let camera = &self.camera;
        let tilt = |angle_rad: f64| Interval::centred(0.0, cayley_radius(angle_rad));
        let mut parameters = [Interval::ZERO; N_PARAMETERS];
        for k in 0..3 {
            parameters[POINT[k]] = point[k];
            parameters[POSE[k]] = pose[k];
        }
        for k in 0..2 {
            parameters[BODY_TILT[k]] = tilt(self.body.tilt_rad);
            parameters[MOUNT_TILT[k]] = tilt(camera.tilt_rad);
            parameters[CENTRE[k]] = camera.centre_px[k];
            parameters[POSITION[k]] = camera.position_m[k];
        }
        parameters[YAW] = camera.yaw_rad;
        parameters[FOCAL] = camera.focal_px;
        parameters[HEIGHT] = camera.height_m;
        parameters[HEAVE] = Interval::centred(0.0, self.body.heave_m);
        parameters[TURN] = Interval::centred(0.0, heading_off_rad(self.body.tilt_rad));
        parameters
    }

    /// The vector x from the optical centre to a landmark, times ρ, in the frame of the camera: to the right, down and ahead; with derivatives by the
    /// first `K` parameters.
    pub(super) fn in_camera<const K: usize>(&self, parameters: &Parameters, anchor: &Anchor) -> [Dual<K>; 3] {
        let number = |index: usize| number::<K>(parameters, index);
        let exactly = |value: f64| Dual::constant(Interval::point(value));
        let rho = number(POINT[2]);
        let position = [number(POSE[0]), number(POSE[1]), number(HEAVE)];
        let [i, j] = anchor.sides();
        let mut ray = [exactly(anchor.sign()); 3];
        (ray[i], ray[j]) = (number(POINT[0]), number(POINT[1]));
        let from_robot = [0, 1, 2].map(|k| ray[k] + rho * (exactly(anchor.from_m[k]) - position[k]));
        let level = turned(from_robot, -(number(POSE[2]) + number(TURN)));
        let in_body = tilted(level, BODY_TILT.map(|index| -number(index)));
        let mount = [number(POSITION[0]), number(POSITION[1]), number(HEIGHT)];
        let from_camera = [0, 1, 2].map(|k| in_body[k] - rho * mount[k]);
        let [ahead, left, up] = tilted(turned(from_camera, -number(YAW)), MOUNT_TILT.map(|index| -number(index)));
        let [cos, sin] = self.up.map(Dual::constant);
        [-left, ahead * sin - up * cos, ahead * cos + up * sin]
    }

    /// Enclosure of the vector of [`in_camera`](Self::in_camera) over the boxes of a pose and of a landmark, as a mean value form: the terms by the
    /// anchor's place and by the mount's cancel each other, however little is known of ρ.
    pub(super) fn ray(&self, pose: &PoseBox, point: &SpacePoint) -> [Interval; 3] {
        let over_box = self.parameters(pose, point.value);
        let middle = over_box.map(|value| Interval::point(value.mid()));
        let deviations: Parameters = std::array::from_fn(|k| over_box[k] - middle[k]);
        let wide = self.in_camera::<N_PARAMETERS>(&over_box, &point.anchor);
        let exact = self.in_camera::<0>(&middle, &point.anchor);
        std::array::from_fn(|k| wide[k].around(exact[k].value, &deviations).value)
    }

    /// A wider enclosure of the same vector, at a small part of the cost.
    pub(super) fn wide_ray(&self, pose: &PoseBox, point: &SpacePoint) -> [Interval; 3] {
        self.in_camera::<0>(&self.parameters(pose, point.value), &point.anchor).map(|one| one.value)
    }

    /// The left sides of the equations of an image point along u and along v, and x₃, with derivatives by the first `K` parameters.
    pub(super) fn equations<const K: usize>(
        &self,
        parameters: &Parameters,
        anchor: &Anchor,
        at_px: [f64; 2],
    ) -> ([Dual<K>; 2], Dual<K>) {
        let number = |index: usize| number::<K>(parameters, index);
        let exactly = |value: f64| Dual::constant(Interval::point(value));
        let x = self.in_camera(parameters, anchor);
        let equation = |k: usize| number(FOCAL) * x[k] + (number(CENTRE[k]) - exactly(at_px[k])) * x[2];
        ([equation(0), equation(1)], x[2])
    }

    /// The landmark of which nothing is known but an image point, with its greatest error, at a pose within a box; `None` where the box is too wide
    /// to tell along which axis of the world the camera looks.
    pub(super) fn first_seen(&self, pose: &PoseBox, at_px: [f64; 2], error_px: [f64; 2]) -> Option<SpacePoint> {
        let parameters = self.parameters(pose, [Interval::ZERO; 3]);
        let constant = |index: usize| number::<0>(&parameters, index);
        // The direction in which the point is seen, with unit depth along the optical axis: first in the frame of the camera, then turned to the
        // world.
        let slope = |k: usize| {
            let seen_px = Interval::centred(at_px[k], error_px[k]);
            Dual::constant((seen_px - parameters[CENTRE[k]]) / parameters[FOCAL])
        };
        let [cos, sin] = self.up.map(Dual::constant);
        let (right, down) = (slope(0), slope(1));
        let nominal = [cos + down * sin, -right, sin - down * cos];
        let in_body = turned(tilted(nominal, MOUNT_TILT.map(constant)), constant(YAW));
        let body = BODY_TILT.map(constant);
        let to_world =
            |v: [Dual<0>; 3]| turned(tilted(v, body), constant(POSE[2]) + constant(TURN)).map(|one| one.value);
        let direction = to_world(in_body);
        let arm_m = to_world([constant(POSITION[0]), constant(POSITION[1]), constant(HEIGHT)]);
        let centre_m = [0, 1, 2].map(|k| arm_m[k] + parameters[[POSE[0], POSE[1], HEAVE][k]]);
        let from_m = centre_m.map(Interval::mid);
        let axis = (0..3).max_by(|&a, &b| direction[a].mid().abs().total_cmp(&direction[b].mid().abs()))?;
        let anchor = Anchor { from_m, axis, is_positive: direction[axis].mid() > 0.0 };
        // With s the depth along the optical axis, L − A = s·(direction + (centre − A)/s).
        let inverse = Interval::new(0.0, Interval::point(self.camera.least_depth_m).recip().hi());
        let scaled = [0, 1, 2].map(|k| direction[k] + inverse * (centre_m[k] - from_m[k]));
        let along = scaled[axis] * anchor.sign();
        let [i, j] = anchor.sides();
        let value = [scaled[i] / along, scaled[j] / along, inverse / along];
        let is_told = along.lo() > LEAST_ALONG && value.iter().all(|one| one.is_bounded());
        is_told.then_some(SpacePoint { anchor, value })
    }
}

/// Least part of a ray along its anchor's axis, for a unit depth along the optical axis.
const LEAST_ALONG: f64 = 0.2;

/// The vector turned about the vertical.
fn turned<const K: usize>([x, y, z]: [Dual<K>; 3], angle: Dual<K>) -> [Dual<K>; 3] {
    let (sin, cos) = (angle.value.sin(), angle.value.cos());
    let (sin_of, cos_of) = (angle.through(sin, cos), angle.through(cos, -sin));
    [x * cos_of - y * sin_of, x * sin_of + y * cos_of, z]
}
