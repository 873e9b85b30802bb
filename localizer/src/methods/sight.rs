//! Geometry of an edge in the image: the plane that the edge spans with the optical centre, and the direction of the level line that it
//! would be.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::lean::{heading_off_rad, twist_of_two_rad};
use interval::{Dual, Interval};

use crate::{
    robot::ForwardCameraModel,
    vision::{distortion, forward::EdgeLine},
};

/// Least level part and least height of a plane's unit normal for the plane's edge to be used as level: in a steeper plane the edge may as
/// well be upright, such as a door post.
const LEAST_SLOPE: f64 = 0.12;
/// Greatest width of the direction of an image edge with which the edge is used.
pub(super) const WIDEST_RAD: f64 = 0.1;
/// Greatest width of the direction of an image edge for a known lean, where the lean is solved for and edges are refitted: edges that are
/// less accurate, because they are short or near the horizon, are wrong seven times as often as the others.
pub(super) const WIDEST_REFITTED_RAD: f64 = 0.035;
/// Greatest width of the direction of an image edge over all leans: an edge whose direction leans turn by more is not used.
const MOST_TURNED_RAD: f64 = 0.4;
/// Elevation, as a tangent, below which rays meet the floor, whose texture makes false level lines when it is seen at a grazing angle.
const DEEPEST: f64 = -0.07;
/// Length in pixels from which an edge on the floor is not mere texture, but a skirting, the foot of a wall, the border of a carpet, or a
/// joint of tiles.
const LONG_PX: f64 = 100.0;
/// Margin above the rounding of a few dozen operations on numbers near one, as a share and as an angle.
const ROUNDING: f64 = 1e-12;

/// Number of unknowns of an edge's plane: the places of the edge's ends across and along the edge, the principal point along u and v, and
/// the focal length.
const N_PARAMETERS: usize = 7;
const ACROSS: [usize; 2] = [0, 1];
const ALONG: [usize; 2] = [2, 3];
const CENTRE: [usize; 2] = [4, 5];
const FOCAL: usize = 6;
/// Error parameters that move the normal of an edge's plane to first order. A shift of an end along its own edge does not, apart from the
/// effect of the lens distortion.
const MOVING: [usize; 5] = [ACROSS[0], ACROSS[1], CENTRE[0], CENTRE[1], FOCAL];

type Number = Dual<N_PARAMETERS>;

/// Plane through an edge and the optical centre, for a robot and a camera in their nominal posture.
#[derive(Clone, Copy, Debug)]
pub(super) struct SightPlane {
    /// Unit normal of the plane in the robot's frame: forward, left, up.
    pub(super) normal: Vector3<f64>,
    /// Vectors that may be added to the normal, each times any number from −1 to 1: by both ends' bounds, the principal point along u and
    /// v, and the focal length.
    pub(super) moves: [Vector3<f64>; MOVING.len()],
    /// Greatest length of the part of the normal's error that `moves` does not contain.
    pub(super) rest: f64,
}

impl SightPlane {
    /// Plane through an edge of the image; `None` where the lens model folds back.
    ///
    /// The true image of an end is at p + s·n + t·l, with n across the edge and l along it, s within the claim's bound and the
    /// calibration's error, and t within that error. It shows the ray (x, y, 1) with (x, y) = D⁻¹((p + s·n + t·l − c)/f). The plane's
    /// normal is the product of the rays of both ends, enclosed by the mean value form over the box of s, t, c and f: the slopes at the
    /// middle move the normal, and their variation over the box goes into the remaining error of the normal. A change of the normal's
    /// length alone says nothing about the plane and is taken out.
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
        // The vector (1 + e)·n + Δ has the direction of n + Δ/(1 + e).
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

    /// Greatest component, along a unit vector, of the errors that may be added to the plane's normal.
    pub(super) fn reach(&self, along: &Vector3<f64>) -> f64 {
        self.moves.iter().map(|part| part.dot(along).abs()).sum::<f64>() + self.rest
    }

    /// Greatest length of the errors that may be added to the plane's normal.
    fn total(&self) -> f64 {
        self.moves.iter().map(Vector3::norm).sum::<f64>() + self.rest
    }

    /// Whether the edge may be upright when robot and camera together lean by up to `tilt_rad`.
    pub(super) fn may_be_upright(&self, tilt_rad: f64) -> bool {
        self.normal.z.abs() <= self.reach(&Vector3::z()) + tilt_rad
    }

    /// Direction of the level line in the plane, from robot forward by the nominal mount, at any lean of robot and camera; `None` when it may be any.
    pub(super) fn level_direction(&self, lean: Lean) -> Option<Interval> {
        let reach = |along: &Vector3<f64>| {
            // A turn about any level axis moves the normal by the normal's part across that axis: seen from above, by its height alone.
            let level = self.normal.z.abs() * along.xy().norm() + self.normal.xy().norm() * along.z.abs();
            self.reach(along) + lean.angle_rad * level + lean.rest(self)
        };
        Some(level_direction(&self.normal, reach)?.inflate(lean.twist_rad))
    }

    /// Whether an edge's plane is far enough from containing the vertical, and from being level.
    fn is_slanting(&self) -> bool {
        let level = self.normal.x.hypot(self.normal.y);
        let across = Vector3::new(self.normal.x, self.normal.y, 0.0) / level;
        level - self.reach(&across) >= LEAST_SLOPE && self.normal.z.abs() - self.reach(&Vector3::z()) >= LEAST_SLOPE
    }
}

/// Boxes of the unknowns of an edge's plane, around the pixels as found and the camera's nominal values.
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

/// Rays (x, y, 1) of both ends of an edge, each as (x, y).
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

/// Difference of the second end's ray and the first end's, times f/f₀: without lens distortion it depends on no focal length and no
/// principal point.
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

/// Normal of the edge's plane in the camera's frame, times f/f₀: with the step s from one ray to the other, (x, y, 1) × (s_x, s_y, 0) =
/// (−s_y, s_x, x·s_y − y·s_x). `middle` is the step at the middle of the box of parameters, with the parameters' deviations from the
/// middle.
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

/// Vector of the camera's frame (right, down, ahead) expressed in the robot's frame: the optical axis is (cos τ, 0, sin τ) forward, left
/// and up, image down is (sin τ, 0, −cos τ), and image right is (0, −1, 0).
pub(super) fn in_robot(part: Vector3<f64>, tilt_up_rad: f64) -> Vector3<f64> {
    let (sin, cos) = tilt_up_rad.sin_cos();
    Vector3::new(part.z * cos + part.y * sin, -part.x, part.z * sin - part.y * cos)
}

/// Direction of a level edge from robot forward, counter-clockwise and modulo half a turn, at any lean of robot and camera; `None` where
/// the edge would say nothing useful.
pub(super) fn azimuth(
    line: &EdgeLine,
    camera: &ForwardCameraModel,
    body_tilt_rad: f64,
    widest_rad: f64,
) -> Option<Interval> {
    let plane = SightPlane::of(line, camera).filter(SightPlane::is_slanting)?;
    // Calibration errors are shared by all edges, so they say nothing about whether this edge is worth a claim; only the ends' errors are
    // counted.
    let by_ends = |along: &Vector3<f64>| plane.moves[..2].iter().map(|part| part.dot(along).abs()).sum();
    level_direction(&plane.normal, by_ends).filter(|direction| direction.width() <= widest_rad)?;
    let direction = plane.level_direction(Lean::of(camera.tilt_error_rad + body_tilt_rad))? + camera.yaw_rad;
    (direction.width() <= MOST_TURNED_RAD).then_some(direction)
}

/// Direction, counter-clockwise from robot forward, of the level line in a plane with the given normal, to which errors within `reach` may
/// be added; `None` when it may be any direction.
///
/// Let the normal n have the level length m, and let Δ be the error. A direction d turned by γ from the middle one d₀ is in the plane when
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

/// Bounds on the lean of robot and camera together, about any level axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lean {
    /// Greatest turn of robot and camera together about a level axis.
    pub(super) angle_rad: f64,
    /// Greatest difference, for a vector of length one, between a turn by the lean and its linear approximation: |exp(iλ) − 1 − iλ| ≤ λ²/2.
    bent: f64,
    /// Greatest turn about the vertical that both leans, one after the other, can cause, plus the greatest difference between the heading
    /// as the direction of the forward axis and the turn about the vertical.
    pub(super) twist_rad: f64,
}

impl Lean {
    pub(super) fn of(angle_rad: f64) -> Self {
        let bent = (Interval::point(angle_rad).sqr() * 0.5).hi();
        Lean { angle_rad, bent, twist_rad: twist_of_two_rad(angle_rad) + heading_off_rad(angle_rad) }
    }

    /// Greatest difference of a turned normal from n + λ × n + Δ, with the plane's error Δ left as it is, although the lean turns it as
    /// well.
    pub(super) fn rest(&self, plane: &SightPlane) -> f64 {
        (self.bent + self.angle_rad * plane.total()) * (1.0 + ROUNDING)
    }
}

/// Place of a pixel without distortion, in pixels from the nominal principal point, by fixed-point iteration on Brown and Conrady's model;
/// `None` where the model folds back.
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

/// Direction of a pixel's ray in the camera's frame, by nominal values; straight ahead where the lens model folds back.
pub fn ray(pixel: [f64; 2], camera: &ForwardCameraModel) -> Vector3<f64> {
    let [u, v] = ideal(pixel, camera).unwrap_or_default();
    Vector3::new(u, v, camera.focal_px.mid())
}

/// Distance between an edge's ends.
pub(super) fn length_px(line: &EdgeLine) -> f64 {
    let [[u0, v0], [u1, v1]] = line.ends_px;
    (u1 - u0).hypot(v1 - v0)
}

/// Whether an edge lies on the floor, and whether it is too short to be more than texture there.
pub(super) fn on_floor(line: &EdgeLine, camera: &ForwardCameraModel) -> (bool, bool) {
    let is_deep = |end: [f64; 2]| ideal(end, camera).is_none_or(|end| elevation(end, camera) < DEEPEST);
    (line.ends_px.into_iter().any(is_deep), length_px(line) < LONG_PX)
}

/// Whether an edge goes from below the horizon to above it, at every lean. No level line does, not even one that runs straight ahead and
/// looks upright.
pub(super) fn crosses_horizon(line: &EdgeLine, camera: &ForwardCameraModel, tilt_rad: f64) -> bool {
    match line.ends_px.map(|end| elevation_of(end, camera)) {
        [Some(a), Some(b)] => a.min(b) < -tilt_rad && a.max(b) > tilt_rad,
        _ => false,
    }
}

/// Tangent of the elevation above the horizon at which a pixel looks, by nominal values; `None` where the lens model folds back.
pub(super) fn elevation_of(pixel: [f64; 2], camera: &ForwardCameraModel) -> Option<f64> {
    ideal(pixel, camera).map(|at| elevation(at, camera))
}

/// Tangent of the elevation of a ray above the horizon, by nominal values.
fn elevation([u, v]: [f64; 2], camera: &ForwardCameraModel) -> f64 {
    let (sin, cos) = camera.tilt_up_rad.sin_cos();
    let focal_px = camera.focal_px.mid();
    (focal_px * sin - v * cos) / (focal_px * cos + v * sin).hypot(u)
}
