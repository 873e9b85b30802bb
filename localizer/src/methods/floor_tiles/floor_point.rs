//! The point of the floor that a pixel of the floor camera shows, as a function of the constants of the camera and the lean of the body.

use interval::{Dual, Interval};

use crate::{
    bounds,
    graph::{Constant, SeenPlace, Variable},
    reading::Camera,
    robot::{FloorCameraModel, cayley_radius},
    vision::line_fit::LineSet,
};

use super::{
    super::{lean::heading_off_rad, tilt::tilted},
    Geometry,
};

/// Number of parameters of a floor point: its pixel, the image scale, the tilts of mount and body, the position of the camera, and the body's heave.
const N_PARAMETERS: usize = 10;
const PIXEL: [usize; 2] = [0, 1];
const SCALE: usize = 2;
const MOUNT_TILT: [usize; 2] = [3, 4];
const BODY_TILT: [usize; 2] = [5, 6];
const POSITION: [usize; 2] = [7, 8];
const HEAVE: usize = 9;

type Number = Dual<N_PARAMETERS>;

/// Bound on rounding errors of places in the picture, whose coordinates are below 10⁵ px.
const ROUNDING_PX: f64 = 1e-9;

/// The floor point at which the lines that fit cross a normal of the line, as a function of the constants of the camera and the lean of the body. `None`
/// where the camera may see the horizon.
pub(super) fn floor_place(set: &LineSet, along_px: f64, geometry: &Geometry) -> Option<SeenPlace> {
    let (camera, body) = (&geometry.camera, &geometry.robot.body);
    let crossing = set.crossing(along_px);
    let [forward_px, left_px] = geometry.in_camera_px(crossing.at_px);
    // Forward is up and left is left in the picture, whose axes point right and down.
    let normal = [-crossing.normal[1], -crossing.normal[0]];
    let pixel = [forward_px, left_px].map(Interval::point);
    let pixel = [0, 1].map(|axis| pixel[axis] + Interval::point(normal[axis]) * crossing.across_px);
    let error = camera.yaw_rad - Interval::point(camera.yaw_rad.mid());
    let (cos, sin) = (error.cos(), error.sin());
    let [forward, left] = camera.position_m;
    let is_rolling = camera.row_time_s > 0.0;
    let (body_radius, heave_m) = (body_radius(geometry), if is_rolling { 0.0 } else { body.heave_m });
    let mut parameters = [Interval::ZERO; N_PARAMETERS];
    for axis in 0..2 {
        parameters[PIXEL[axis]] = pixel[axis];
        parameters[MOUNT_TILT[axis]] = Interval::centred(0.0, cayley_radius(camera.tilt_rad));
        parameters[BODY_TILT[axis]] = Interval::centred(0.0, body_radius);
    }
    parameters[SCALE] = camera.pixels_per_m;
    parameters[POSITION[0]] = forward * cos + left * sin;
    parameters[POSITION[1]] = left * cos - forward * sin;
    parameters[HEAVE] = Interval::centred(0.0, heave_m);
    let middles = parameters.map(|parameter| Interval::point(parameter.mid()));
    let slopes = floor_point(&parameters, camera)?.map(|number| number.slopes);
    let column = |parameter: usize| [0, 1].map(|axis| slopes[axis][parameter]);
    let across = [0, 1].map(|axis| {
        let by_pixel = PIXEL.map(|parameter| slopes[axis][parameter]);
        by_pixel[0] * normal[0] + by_pixel[1] * normal[1]
    });
    let across_mid = crossing.across_px.mid();
    let mut place = SeenPlace {
        device: Camera::Floor.device(),
        yaw: Some((Constant::FloorYaw, camera.yaw_rad.mid())),
        middle_m: floor_point(&middles, camera)?.map(|number| number.value),
        terms: Vec::new(),
        noise_m: vec![
            (across, crossing.across_px - across_mid, None),
            (column(HEAVE), parameters[HEAVE], Some(bounds::BODY_HEAVE)),
            // What rounding moves the middle of the pixel off the line's point.
            (column(PIXEL[0]), Interval::centred(0.0, ROUNDING_PX), None),
            (column(PIXEL[1]), Interval::centred(0.0, ROUNDING_PX), None),
        ],
        turn_rad: heading_off_rad(body_radius_rad(geometry)),
    };
    let mut depends = |parameter: usize, variable: Variable| {
        place.terms.push((variable, parameters[parameter].mid(), column(parameter)));
    };
    depends(SCALE, Variable::Constant(Constant::FloorScale));
    for axis in 0..2 {
        depends(MOUNT_TILT[axis], Variable::Constant(Constant::FloorTilt(axis)));
        depends(BODY_TILT[axis], Variable::BodyTilt(0, axis));
    }
    let at_m = POSITION.map(|parameter| parameters[parameter].mid());
    let position = [0, 1].map(Constant::FloorPosition);
    place.mounted(position, camera.position_m, camera.yaw_rad, (at_m, POSITION.map(column)));
    Some(place)
}

/// Lean of the body within its bound. Under a rolling shutter each row has a posture of its own, for which the bounds of the points account.
pub(super) fn body_radius(geometry: &Geometry) -> f64 {
    if geometry.camera.row_time_s > 0.0 { 0.0 } else { cayley_radius(geometry.robot.body.tilt_rad) }
}

/// Greatest lean of the body for which the bounds of the points do not account.
fn body_radius_rad(geometry: &Geometry) -> f64 {
    if geometry.camera.row_time_s > 0.0 { 0.0 } else { geometry.robot.body.tilt_rad }
}

/// Floor point that a pixel shows: c + d·(c_up + heave)/(−d_up), with c = T(body)·m′ the optical centre and d = T(body)·Rz(yaw)·T(mount)·(q/f, −1) the
/// ray of the pixel q, given forward and left.
fn floor_point(parameters: &[Interval; N_PARAMETERS], camera: &FloorCameraModel) -> Option<[Number; 2]> {
    let number = |index: usize| Number::parameter(index, parameters[index]);
    let height = Number::constant(Interval::point(camera.height_m));
    let focal = number(SCALE) * height;
    let ray = [number(PIXEL[0]) / focal, number(PIXEL[1]) / focal, Number::constant(-Interval::ONE)];
    let mounted = tilted(ray, MOUNT_TILT.map(number));
    let yaw = Interval::point(camera.yaw_rad.mid());
    let [cos, sin] = [yaw.cos(), yaw.sin()].map(Number::constant);
    let turned = [mounted[0] * cos - mounted[1] * sin, mounted[0] * sin + mounted[1] * cos, mounted[2]];
    let body = BODY_TILT.map(number);
    let ray = tilted(turned, body);
    let centre = tilted([number(POSITION[0]), number(POSITION[1]), height], body);
    if ray[2].value.hi() > -0.05 {
        return None;
    }
    let length = (centre[2] + number(HEAVE)) / -ray[2];
    Some([centre[0] + ray[0] * length, centre[1] + ray[1] * length])
}
