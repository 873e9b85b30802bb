//! From an edge in the image to the direction, seen from the robot, of the level line that it would be.

use nalgebra::Vector3;

use crate::{Interval, robot::ForwardCameraModel, vision::forward::EdgeLine};

/// Steeper than this, a plane through camera and edge holds the vertical nearly as well: the edge may be a door post.
const LEAST_SLOPE: f64 = 0.12;
/// An edge whose direction is known no better says nothing.
const WIDEST_RAD: f64 = 0.1;
/// Rays that dip deeper meet the floor, whose texture, grazed, makes false level lines.
const DEEPEST: f64 = -0.07;

/// Direction of a level edge from robot forward, counter-clockwise and modulo half a turn; `None` where it would say nothing.
///
/// The plane through the optical centre and the edge has the normal n = (−dv, du, u·dv − v·du) in the camera's frame, with u and v
/// of one end and du, dv to the other, all over the focal length. A level line d in it has d·n = 0, hence its direction is
/// atan2(−n_forward, n_left). With both ends' offsets across the edge, n is bilinear: it stays in the hull of four corners.
pub(super) fn azimuth(line: &EdgeLine, camera: &ForwardCameraModel, body_tilt_rad: f64) -> Option<Interval> {
    let ends = [ideal(line.ends_px[0], camera)?, ideal(line.ends_px[1], camera)?];
    if ends.iter().any(|end| elevation(*end, camera) < DEEPEST) {
        return None;
    }
    let bound = (line.bound_px + camera.distortion_px) * largest_stretch(line, camera)?;
    let (du, dv) = (ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
    let length = du.hypot(dv);
    let across = [-dv / length, du / length];
    let principal = camera.principal_point_px.map(|at| at - Interval::point(at.mid()));
    let tilt_rad = camera.tilt_error_rad + body_tilt_rad;
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
    let direction = directions + camera.yaw_rad;
    (direction.width() <= WIDEST_RAD).then_some(direction)
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

/// Tangent of the elevation of a ray above the horizon, by nominal values.
fn elevation([u, v]: [f64; 2], camera: &ForwardCameraModel) -> f64 {
    let (sin, cos) = camera.tilt_up_rad.sin_cos();
    let focal_px = camera.focal_px.mid();
    (focal_px * sin - v * cos) / (focal_px * cos + v * sin).hypot(u)
}
