//! From an edge in the image to the plane that it spans with the optical centre, and to the direction of the level line that it would be.

use nalgebra::Vector3;

use crate::{Interval, robot::ForwardCameraModel, vision::forward::EdgeLine};

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
/// Above the rounding of a few dozen operations on numbers near one.
const ABOVE: f64 = 1.0 + 1e-9;

/// The plane through an edge and the optical centre, for a robot and a camera that stand as they should.
#[derive(Clone, Copy, Debug)]
pub(super) struct SightPlane {
    /// Unit normal in the robot's frame: forward, left, up.
    pub(super) normal: Vector3<f64>,
    /// What may be added to it, each times any number from −1 to 1: both ends' bounds, the principal point along u and v, and the
    /// focal length.
    pub(super) moves: [Vector3<f64>; 5],
    /// Greatest length of what is added besides, products of these.
    pub(super) rest: f64,
}

impl SightPlane {
    /// The plane through an edge; `None` where the lens model folds back.
    pub(super) fn of(line: &EdgeLine, camera: &ForwardCameraModel) -> Option<Self> {
        let focal_px = camera.focal_px.mid();
        let ends = [ideal(line.ends_px[0], camera)?, ideal(line.ends_px[1], camera)?];
        let [a, b] = ends.map(|[u, v]| Vector3::new(u / focal_px, v / focal_px, 1.0));
        let along = (b - a).normalize();
        let bound = (line.bound_px + camera.distortion_px) * largest_stretch(line, camera)? / focal_px;
        let across = Vector3::new(-along.y, along.x, 0.0) * bound;
        let [shift_u, shift_v] = camera.principal_point_px.map(|at| at.radius() / focal_px);
        let normal = a.cross(&b);
        let focal_share = camera.focal_px.radius() / camera.focal_px.lo();
        let moves = [
            across.cross(&b),
            a.cross(&across),
            (shift_u * Vector3::x()).cross(&(b - a)),
            (shift_v * Vector3::y()).cross(&(b - a)),
            // Both ends are told in pixels: with another focal length only the part along the axis changes, by as great a share.
            Vector3::new(0.0, 0.0, focal_share * normal.z),
        ];
        let total: f64 = moves.iter().map(Vector3::norm).sum();
        let rest = bound * bound + 2.0 * bound * shift_u.hypot(shift_v) + focal_share * total;
        let length = normal.norm();
        let robot_from_camera = |part: Vector3<f64>| in_robot(part, camera.tilt_up_rad) / length;
        Some(SightPlane {
            normal: robot_from_camera(normal),
            moves: moves.map(|part| robot_from_camera(part) * ABOVE),
            rest: rest / length * ABOVE,
        })
    }

    /// Greatest component along a unit vector of what may be added.
    pub(super) fn reach(&self, along: &Vector3<f64>) -> f64 {
        self.moves.iter().map(|part| part.dot(along).abs()).sum::<f64>() + self.rest
    }

    /// Whether the edge may be upright when robot and camera together lean by up to `tilt_rad`.
    pub(super) fn may_be_upright(&self, tilt_rad: f64) -> bool {
        self.normal.z.abs() <= self.reach(&Vector3::z()) + tilt_rad
    }
}

/// A vector of the camera's frame (right, down, ahead) in the robot's: the axis is (cos τ, 0, sin τ) forward, left and up, image down
/// (sin τ, 0, −cos τ), image right (0, −1, 0).
fn in_robot(part: Vector3<f64>, tilt_up_rad: f64) -> Vector3<f64> {
    let (sin, cos) = tilt_up_rad.sin_cos();
    Vector3::new(part.z * cos + part.y * sin, -part.x, part.z * sin - part.y * cos)
}

/// Direction of a level edge from robot forward, counter-clockwise and modulo half a turn; `None` where it would say nothing.
///
/// The plane through the optical centre and the edge has the normal n = (−dv, du, u·dv − v·du) in the camera's frame, with u and v
/// of one end and du, dv to the other, all over the focal length. A level line d in it has d·n = 0, hence its direction is
/// atan2(−n_forward, n_left). With both ends' offsets across the edge, n is bilinear: it stays in the hull of four corners.
pub(super) fn azimuth(
    line: &EdgeLine,
    camera: &ForwardCameraModel,
    body_tilt_rad: f64,
    widest_rad: f64,
) -> Option<Interval> {
    direction(line, camera, 0.0).filter(|direction| direction.width() <= widest_rad)?;
    direction(line, camera, camera.tilt_error_rad + body_tilt_rad)
        .filter(|direction| direction.width() <= MOST_TURNED_RAD)
}

/// The same whatever its width, for leans of robot and camera within `tilt_rad`.
fn direction(line: &EdgeLine, camera: &ForwardCameraModel, tilt_rad: f64) -> Option<Interval> {
    let ends = [ideal(line.ends_px[0], camera)?, ideal(line.ends_px[1], camera)?];
    let bound = (line.bound_px + camera.distortion_px) * largest_stretch(line, camera)?;
    let (du, dv) = (ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
    let length = du.hypot(dv);
    let across = [-dv / length, du / length];
    let principal = camera.principal_point_px.map(|at| at - Interval::point(at.mid()));
    let mut directions = Interval::EMPTY;
    let mut reference: Option<f64> = None;
    for (first, last) in [(-bound, -bound), (-bound, bound), (bound, -bound), (bound, bound)] {
        let start =
            [0, 1].map(|axis| (principal[axis] * -1.0 + (ends[0][axis] + first * across[axis])) / camera.focal_px);
        let step = [0, 1].map(|axis| [du, dv][axis] + (last - first) * across[axis]);
        let normal = [Interval::point(-step[1]), Interval::point(step[0]), start[0] * step[1] - start[1] * step[0]];
        let corner = of_plane(normal, camera.tilt_up_rad, tilt_rad)?;
        // All corners are told near the first one, so that none is half a turn away from the others.
        let near = *reference.get_or_insert(corner.mid());
        let halves = ((near - corner.mid()) / std::f64::consts::PI).round();
        directions = directions.hull(corner + Interval::PI * halves);
    }
    Some(directions + camera.yaw_rad)
}

/// Direction of the level line in a plane whose normal is given in the camera's frame, for a camera tilted up and any further tilt of
/// its or the body's within `tilt_rad`.
fn of_plane(normal: [Interval; 3], tilt_up_rad: f64, tilt_rad: f64) -> Option<Interval> {
    let (sin, cos) = (Interval::point(tilt_up_rad).sin(), Interval::point(tilt_up_rad).cos());
    let [x, y, z] = normal;
    // The optical axis is (cos τ, 0, sin τ) forward, left and up; image down is (sin τ, 0, −cos τ), image right (0, −1, 0).
    let (forward, left, up) = (z * cos + y * sin, x * -1.0, z * sin - y * cos);
    let level = forward.hypot(left).mignitude();
    let size = up.hypot(forward.hypot(left)).magnitude();
    if level < LEAST_SLOPE * size || up.mignitude() < LEAST_SLOPE * size {
        return None;
    }
    // A tilt ε about any level axis moves the level part of n by at most sin ε·|n_up| + (1 − cos ε)·|n|.
    let moved = tilt_rad * up.magnitude() + 0.5 * tilt_rad * tilt_rad * size;
    let (forward, left) = (forward.inflate(moved), left.inflate(moved));
    let directions = left.atan2(forward) + Interval::PI * 0.5;
    if directions.width() < 3.0 {
        return Some(directions);
    }
    // The cut of atan2 lies within: turned by half a turn, it does not.
    let directions = (left * -1.0).atan2(forward * -1.0) - Interval::PI * 0.5;
    (directions.width() < 3.0).then_some(directions)
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

/// Greatest factor by which taking distortion away lengthens a step across the edge at either end.
fn largest_stretch(line: &EdgeLine, camera: &ForwardCameraModel) -> Option<f64> {
    let [a, b] = line.ends_px;
    let (du, dv) = (b[0] - a[0], b[1] - a[1]);
    let length = du.hypot(dv);
    let across = [-dv / length, du / length];
    let mut largest = 1.0_f64;
    for end in [a, b] {
        let beside = ideal([end[0] + across[0], end[1] + across[1]], camera)?;
        let at = ideal(end, camera)?;
        largest = largest.max((beside[0] - at[0]).hypot(beside[1] - at[1]));
    }
    // The factor changes by less than a hundredth over the few pixels of a bound.
    Some(if largest > 1.0 { largest * 1.01 } else { 1.0 })
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
