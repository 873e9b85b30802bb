//! From an edge in the image to the plane that it spans with the optical centre, and to the direction of the level line that it would be.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::super::lean::{heading_off_rad, twist_of_two_rad};
use interval::{Dual, Interval};

use crate::{
    robot::ForwardCameraModel,
    vision::{distortion, forward::EdgeLine},
};

/// Steeper than this, a plane through camera and edge holds the vertical nearly as well: the edge may be a door post.
const LEAST_SLOPE: f64 = 0.12;
/// An edge whose direction is known no better says nothing.
pub(super) const WIDEST_RAD: f64 = 0.1;
/// Nor, where the lean is solved for and edges are refitted, does one whose direction would be known no better were the lean known:
/// edges so short, or so near the horizon, are wrong seven times as often as the others.
pub(super) const WIDEST_REFITTED_RAD: f64 = 0.035;
/// Nor does one that any lean turns by so much.
const MOST_TURNED_RAD: f64 = 0.4;
/// Rays that dip deeper meet the floor, whose texture, grazed, makes false level lines,
const DEEPEST: f64 = -0.07;
/// but none so long: those are skirtings, foots of walls, borders of carpets, and joints of tiles.
const LONG_PX: f64 = 100.0;
/// Above the rounding of a few dozen operations on numbers near one, as a share and as an angle.
const ROUNDING: f64 = 1e-12;

/// What is unknown of an edge's plane: where its ends are across the edge and along it, the principal point along u and v, and the focal
/// length.
const N_PARAMETERS: usize = 7;
const ACROSS: [usize; 2] = [0, 1];
const ALONG: [usize; 2] = [2, 3];
const CENTRE: [usize; 2] = [4, 5];
const FOCAL: usize = 6;
/// Those that move the normal to first order: what moves an end along its own edge does not, but for what the lens bends.
const MOVING: [usize; 5] = [ACROSS[0], ACROSS[1], CENTRE[0], CENTRE[1], FOCAL];

type Number = Dual<N_PARAMETERS>;

/// The plane through an edge and the optical centre, for a robot and a camera that stand as they should.
#[derive(Clone, Copy, Debug)]
pub(super) struct SightPlane {
    /// Unit normal in the robot's frame: forward, left, up.
    pub(super) normal: Vector3<f64>,
    /// What may be added to it, each times any number from −1 to 1: by both ends' bounds, the principal point along u and v, and the focal length.
    pub(super) moves: [Vector3<f64>; MOVING.len()],
    /// Greatest length of what is added besides.
    pub(super) rest: f64,
}

impl SightPlane {
    /// The plane through an edge; `None` where the lens model folds back.
    ///
    /// The true image of an end is at p + s·n + t·l, n across the edge and l along it, s within the claim's bound and the
    /// calibration's error, t within that error; it shows the ray (x, y, 1) with (x, y) = D⁻¹((p + s·n + t·l − c)/f). The plane's normal is
    /// the product of both rays, enclosed by the mean value form over the box of s, t, c and f: the slopes at the middle move it, what they
    /// differ by over the box is left over. What only lengthens the normal says nothing of the plane, and is taken out.
    pub(super) fn of(line: &EdgeLine, camera: &ForwardCameraModel) -> Option<Self> {
        let parameters = parameters(line, camera);
        let middles = parameters.map(|parameter| Interval::point(parameter.mid()));
        let mut deviations = [Interval::ZERO; N_PARAMETERS];
        for (deviation, (parameter, middle)) in deviations.iter_mut().zip(parameters.iter().zip(&middles)) {
            *deviation = *parameter - *middle;
        }
        let at_middle = normal(line, camera, &middles, None)?;
        let over_box = normal(line, camera, &parameters, Some((step(line, camera, &middles)?, &deviations)))?;
        let component = |of: &dyn Fn(usize) -> f64| Vector3::new(of(0), of(1), of(2));
        let middle = component(&|axis| at_middle[axis].value.mid());
        let length = middle.norm();
        let unit = middle / length;
        let (mut left, mut lengthened) = (Interval::ZERO, Interval::ZERO);
        let mut moved = |k: usize| {
            let half_width = deviations[k].magnitude();
            let part = component(&|axis| over_box[axis].slopes[k].mid() * half_width);
            let over = component(&|axis| over_box[axis].slopes[k].radius() * half_width);
            lengthened += part.dot(&unit).abs();
            left += over.norm();
            part - unit * part.dot(&unit)
        };
        let moves = MOVING.map(&mut moved);
        let along: f64 = ALONG.map(moved).iter().map(Vector3::norm).sum();
        left += component(&|axis| at_middle[axis].value.radius()).norm() + along;
        // (1 + e)·n + Δ is, but for its length, n + Δ/(1 + e).
        let shortest = Interval::point(length) - lengthened;
        if shortest.is_empty() || shortest.lo() <= 0.0 {
            return None;
        }
        let scale = (1.0 + ROUNDING) / shortest.lo();
        Some(SightPlane {
            normal: in_robot(unit, camera.tilt_up_rad),
            moves: moves.map(|part| in_robot(part, camera.tilt_up_rad) * scale),
            rest: left.hi() * scale + ROUNDING,
        })
    }

    /// Greatest component along a unit vector of what may be added.
    pub(super) fn reach(&self, along: &Vector3<f64>) -> f64 {
        self.moves.iter().map(|part| part.dot(along).abs()).sum::<f64>() + self.rest
    }

    /// Greatest length of what may be added.
    fn total(&self) -> f64 {
        self.moves.iter().map(Vector3::norm).sum::<f64>() + self.rest
    }

    /// Whether the edge may be upright when robot and camera together lean by up to `tilt_rad`.
    pub(super) fn may_be_upright(&self, tilt_rad: f64) -> bool {
        self.normal.z.abs() <= self.reach(&Vector3::z()) + tilt_rad
    }

    /// Whether the plane is far enough from holding the vertical, and from being level.
    fn is_slanting(&self) -> bool {
        let level = self.normal.x.hypot(self.normal.y);
        let across = Vector3::new(self.normal.x, self.normal.y, 0.0) / level;
        level - self.reach(&across) >= LEAST_SLOPE && self.normal.z.abs() - self.reach(&Vector3::z()) >= LEAST_SLOPE
    }
}

/// Boxes of what is unknown, around the pixels as told and nominal values.
fn parameters(line: &EdgeLine, camera: &ForwardCameraModel) -> [Interval; N_PARAMETERS] {
    let mut parameters = [Interval::ZERO; N_PARAMETERS];
    for end in 0..2 {
        parameters[ACROSS[end]] = Interval::ZERO.inflate(line.bound_px).inflate(camera.distortion_px);
        parameters[ALONG[end]] = Interval::ZERO.inflate(camera.distortion_px);
        parameters[CENTRE[end]] = camera.principal_point_px[end];
    }
    parameters[FOCAL] = camera.focal_px;
    parameters
}

/// (x, y) of both ends' rays (x, y, 1).
fn rays(
    line: &EdgeLine,
    camera: &ForwardCameraModel,
    parameters: &[Interval; N_PARAMETERS],
) -> Option<[[Number; 2]; 2]> {
    let number = |index: usize| Number::parameter(index, parameters[index]);
    let [[u0, v0], [u1, v1]] = line.ends_px;
    let length_px = length_px(line);
    let along = [(u1 - u0) / length_px, (v1 - v0) / length_px];
    let across = [-along[1], along[0]];
    let ray = |end: usize| {
        let seen = [0, 1].map(|axis| {
            let constant = |value: f64| Number::constant(Interval::point(value));
            let off = number(ACROSS[end]) * constant(across[axis]) + number(ALONG[end]) * constant(along[axis]);
            (constant(line.ends_px[end][axis]) + off - number(CENTRE[axis])) / number(FOCAL)
        });
        distortion::unbent_models(camera.distortion, seen)
    };
    Some([ray(0)?, ray(1)?])
}

/// From the first ray to the second, times f/f₀: without a lens that bends, no focal length and no principal point changes it.
fn step(line: &EdgeLine, camera: &ForwardCameraModel, parameters: &[Interval; N_PARAMETERS]) -> Option<[Number; 2]> {
    let [a, b] = rays(line, camera, parameters)?;
    Some(stepped(a, b, camera, parameters))
}

fn stepped(
    a: [Number; 2],
    b: [Number; 2],
    camera: &ForwardCameraModel,
    parameters: &[Interval; N_PARAMETERS],
) -> [Number; 2] {
    let nominal_px = Number::constant(Interval::point(camera.focal_px.mid()));
    let scale = Number::parameter(FOCAL, parameters[FOCAL]) / nominal_px;
    [0, 1].map(|axis| (b[axis] - a[axis]) * scale)
}

/// The plane's normal in the camera's frame, times f/f₀: with the step s from one ray to the other, (x, y, 1) × (s_x, s_y, 0) = (−s_y, s_x,
/// x·s_y − y·s_x). `middle` is the step at the middle of the box, with the parameters' deviations from there.
fn normal(
    line: &EdgeLine,
    camera: &ForwardCameraModel,
    parameters: &[Interval; N_PARAMETERS],
    middle: Option<([Number; 2], &[Interval; N_PARAMETERS])>,
) -> Option<[Number; 3]> {
    let [a, b] = rays(line, camera, parameters)?;
    let mut step = stepped(a, b, camera, parameters);
    if let Some((middle, deviations)) = middle {
        step = [0, 1].map(|axis| step[axis].around(middle[axis].value, deviations));
    }
    Some([-step[1], step[0], a[0] * step[1] - a[1] * step[0]])
}

/// A vector of the camera's frame (right, down, ahead) in the robot's: the axis is (cos τ, 0, sin τ) forward, left and up, image down
/// (sin τ, 0, −cos τ), image right (0, −1, 0).
fn in_robot(part: Vector3<f64>, tilt_up_rad: f64) -> Vector3<f64> {
    let (sin, cos) = tilt_up_rad.sin_cos();
    Vector3::new(part.z * cos + part.y * sin, -part.x, part.z * sin - part.y * cos)
}

/// Direction of a level edge from robot forward, counter-clockwise and modulo half a turn, at any lean of robot and camera; `None` where it
/// would say nothing.
pub(super) fn azimuth(
    line: &EdgeLine,
    camera: &ForwardCameraModel,
    body_tilt_rad: f64,
    widest_rad: f64,
) -> Option<Interval> {
    let plane = SightPlane::of(line, camera).filter(SightPlane::is_slanting)?;
    let within = |lean: Lean| {
        let reach = |along: &Vector3<f64>| {
            // A turn about any level axis moves a normal by its part across the axis: seen from above, by its height alone.
            let level = plane.normal.z.abs() * along.xy().norm() + plane.normal.xy().norm() * along.z.abs();
            plane.reach(along) + lean.angle_rad * level + lean.rest(&plane)
        };
        Some(level_direction(&plane.normal, reach)?.inflate(lean.twist_rad) + camera.yaw_rad)
    };
    // What the calibration leaves open, all edges share: it says nothing of whether this one is worth a claim.
    let by_ends = |along: &Vector3<f64>| plane.moves[..2].iter().map(|part| part.dot(along).abs()).sum();
    level_direction(&plane.normal, by_ends).filter(|direction| direction.width() <= widest_rad)?;
    within(Lean::of(camera.tilt_error_rad + body_tilt_rad)).filter(|direction| direction.width() <= MOST_TURNED_RAD)
}

/// Direction, counter-clockwise from robot forward, of the level line in a plane whose normal is this one and what `reach` allows to be added;
/// `None` when it may be any.
///
/// With n of level length m and Δ what may be added, a direction turned by γ from the middle one is in the plane when
/// m·sin γ = |d·Δ| ≤ cos γ·|d₀·Δ| + sin γ·|n̂·Δ|, hence tan γ ≤ |d₀·Δ| / (m − |n̂·Δ|).
pub(super) fn level_direction(normal: &Vector3<f64>, reach: impl Fn(&Vector3<f64>) -> f64) -> Option<Interval> {
    let level = normal.x.hypot(normal.y);
    let across = Vector3::new(normal.x, normal.y, 0.0) / level;
    let along = Vector3::new(-across.y, across.x, 0.0);
    let room = Interval::point(level) - reach(&across) - ROUNDING;
    if room.is_empty() || room.lo() <= 0.0 {
        return None;
    }
    let turn_rad = (Interval::point(reach(&along)) / room).atan().hi() + ROUNDING;
    Some(Interval::centred(across.y.atan2(across.x) + FRAC_PI_2, turn_rad))
}

/// What robot and camera may lean together, about any level axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lean {
    /// Greatest turn about a level axis.
    pub(super) angle_rad: f64,
    /// What such a turn departs from what is linear in it, of a vector of length one: |exp(iλ) − 1 − iλ| ≤ λ²/2.
    bent: f64,
    /// How far both, one after the other, turn about the vertical, and how far the heading, told by the forward axis, is off what is left.
    pub(super) twist_rad: f64,
}

impl Lean {
    pub(super) fn of(angle_rad: f64) -> Self {
        let bent = (Interval::point(angle_rad).sqr() * 0.5).hi();
        Lean { angle_rad, bent, twist_rad: twist_of_two_rad(angle_rad) + heading_off_rad(angle_rad) }
    }

    /// Greatest departure of a turned normal from n + λ × n + Δ, with what may be added to the plane's untouched: it is turned as well.
    pub(super) fn rest(&self, plane: &SightPlane) -> f64 {
        (self.bent + self.angle_rad * plane.total()) * (1.0 + ROUNDING)
    }
}

/// Where a pixel would be without distortion, in pixels from the nominal principal point: Newton's method on Brown and Conrady's
/// model; `None` where it folds back.
pub(super) fn ideal(pixel: [f64; 2], camera: &ForwardCameraModel) -> Option<[f64; 2]> {
    let focal_px = camera.focal_px.mid();
    let seen = [0, 1].map(|axis| (pixel[axis] - camera.principal_point_px[axis].mid()) / focal_px);
    let [k1, k2, p1, p2, k3] = camera.distortion;
    let mut at = seen;
    for _ in 0..50 {
        let [x, y] = at;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        if radial <= 0.2 {
            return None;
        }
        let next = [
            (seen[0] - 2.0 * p1 * x * y - p2 * (r2 + 2.0 * x * x)) / radial,
            (seen[1] - p1 * (r2 + 2.0 * y * y) - 2.0 * p2 * x * y) / radial,
        ];
        let moved = (next[0] - x).hypot(next[1] - y);
        at = next;
        if moved < 1e-10 {
            return Some(at.map(|value| value * focal_px));
        }
    }
    None
}

/// Direction in the camera's frame in which a pixel looks, by nominal values; straight ahead where the lens model folds back.
pub fn ray(pixel: [f64; 2], camera: &ForwardCameraModel) -> Vector3<f64> {
    let [u, v] = ideal(pixel, camera).unwrap_or_default();
    Vector3::new(u, v, camera.focal_px.mid())
}

/// Distance of an edge's ends.
pub(super) fn length_px(line: &EdgeLine) -> f64 {
    let [[u0, v0], [u1, v1]] = line.ends_px;
    (u1 - u0).hypot(v1 - v0)
}

/// Whether an edge lies on the floor, and whether it is too short to be more than texture there.
pub(super) fn on_floor(line: &EdgeLine, camera: &ForwardCameraModel) -> (bool, bool) {
    let is_deep = |end: [f64; 2]| ideal(end, camera).is_none_or(|end| elevation(end, camera) < DEEPEST);
    (line.ends_px.into_iter().any(is_deep), length_px(line) < LONG_PX)
}

/// Whether an edge goes from below the horizon to above it, whatever the lean: no level line does, not even one that runs straight
/// ahead and looks upright.
pub(super) fn crosses_horizon(line: &EdgeLine, camera: &ForwardCameraModel, tilt_rad: f64) -> bool {
    let elevation = |end: [f64; 2]| ideal(end, camera).map(|end| elevation(end, camera));
    match line.ends_px.map(elevation) {
        [Some(a), Some(b)] => a.min(b) < -tilt_rad && a.max(b) > tilt_rad,
        _ => false,
    }
}

/// Tangent of the elevation of a ray above the horizon, by nominal values.
fn elevation([u, v]: [f64; 2], camera: &ForwardCameraModel) -> f64 {
    let (sin, cos) = camera.tilt_up_rad.sin_cos();
    let focal_px = camera.focal_px.mid();
    (focal_px * sin - v * cos) / (focal_px * cos + v * sin).hypot(u)
}
