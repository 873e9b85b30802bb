//! Direction in which an upright edge of the image is seen from the camera.

use interval::Interval;

use super::super::sight::{Lean, SightPlane, in_robot, ray};
use crate::{robot::ForwardCameraModel, vision::forward::EdgeLine};

/// Greatest width of a bearing, in radians, with which an edge is used: one of which less is known matches nearly any edge of the map.
const WIDEST_RAD: f64 = 0.03;

/// Direction from the camera to an upright edge of the building, counter-clockwise from robot forward, if the image edge `line` is an image of it;
/// `None` where it can be none at any declared lean of robot and camera, or where too little would be known of its direction.
///
/// The edge is somewhere in the plane through the optical centre and its image. An upright plane stays upright when the lean is taken off, and the
/// level line in it, which leads to the edge, keeps its direction but for terms of second order: where along the edge the image shows it, and how
/// far above the horizon, does not matter.
pub(super) fn bearing(line: &EdgeLine, camera: &ForwardCameraModel, body_tilt_rad: f64) -> Option<Interval> {
    let tilt_rad = camera.tilt_error_rad + body_tilt_rad;
    let plane = SightPlane::of(line, camera).filter(|plane| plane.may_be_upright(tilt_rad))?;
    let level = plane.level_direction(Lean::of(tilt_rad))?;
    // The level line of the plane leads both ways; the edge is where the image shows it.
    let [[u0, v0], [u1, v1]] = line.ends_px;
    let seen = in_robot(ray([0.5 * (u0 + u1), 0.5 * (v0 + v1)], camera), camera.tilt_up_rad);
    let (sin, cos) = level.mid().sin_cos();
    let ahead = if cos * seen.x + sin * seen.y >= 0.0 { level } else { level - Interval::PI };
    let bearing = ahead + camera.yaw_rad;
    (bearing.width() <= WIDEST_RAD).then_some(bearing)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::{
        graph::trial::{self, Draw, rounds},
        vision::forward::{self, Picture},
    };

    const FOCAL_PX: f64 = 417.0;
    const SIZE_PX: [usize; 2] = [640, 480];
    const TILT_UP_RAD: f64 = 0.15;

    fn camera(tilt_error_rad: f64) -> ForwardCameraModel {
        ForwardCameraModel {
            focal_px: Interval::point(FOCAL_PX),
            principal_point_px: SIZE_PX.map(|side| Interval::point(0.5 * (side as f64 - 1.0))),
            distortion: [0.0; 5],
            distortion_px: 0.0,
            tilt_up_rad: TILT_UP_RAD,
            yaw_rad: Interval::ZERO,
            tilt_error_rad,
            stamp_error_s: 0.0,
            position_m: [Interval::ZERO; 2],
            height_m: Interval::point(0.25),
            height_px: SIZE_PX[1] as u32,
            row_time_s: 0.0,
        }
    }

    /// A picture of two surfaces that meet at an upright edge in the direction `bearing_rad` from robot forward, blurred and with noise, from a
    /// camera that leans.
    fn picture(draw: &mut Draw, bearing_rad: f64, lean: Rotation3<f64>) -> Picture {
        let middle_px = SIZE_PX.map(|side| 0.5 * (side as f64 - 1.0));
        // The plane through the camera and the edge, in the frame of the leaning robot.
        let normal = lean.inverse() * Vector3::new(-bearing_rad.sin(), bearing_rad.cos(), 0.0);
        let mut values = Vec::with_capacity(SIZE_PX[0] * SIZE_PX[1]);
        for v in 0..SIZE_PX[1] {
            for u in 0..SIZE_PX[0] {
                let (x, y) = ((u as f64 - middle_px[0]) / FOCAL_PX, (v as f64 - middle_px[1]) / FOCAL_PX);
                let (sin, cos) = TILT_UP_RAD.sin_cos();
                let ray = Vector3::new(cos + y * sin, -x, sin - y * cos);
                // Distance of the pixel from the edge's image, by the change of the product for one pixel to the right.
                let off_px = normal.dot(&ray) * FOCAL_PX / normal.y.hypot(normal.x * sin - normal.z * cos);
                let noise: f64 = (0..4).map(|_| draw.between(-2.0, 2.0)).sum();
                values.push((90.0 + 60.0 / (1.0 + (-1.7 * off_px).exp()) + noise) as f32);
            }
        }
        Picture { width: SIZE_PX[0], height: SIZE_PX[1], values }
    }

    #[test]
    fn the_bearing_of_an_upright_edge_in_a_picture_is_enclosed_whatever_the_lean() {
        let mut draw = Draw::new(7);
        let mut n_found = 0;
        for round in 0..rounds(12) {
            let tilt_rad = [0.001, 0.01, 0.03][round % 3];
            let bearing_rad = draw.between(-0.5, 0.5);
            let (lean, _) = trial::tilt(&mut draw, tilt_rad);
            // A lean about a level axis, with the turn of the forward axis taken off.
            let forward = lean * Vector3::x();
            let lean = Rotation3::from_axis_angle(&Vector3::z_axis(), -forward.y.atan2(forward.x)) * lean;
            let lines = forward::detect(&picture(&mut draw, bearing_rad, lean));
            let found: Vec<Interval> = lines.iter().filter_map(|line| bearing(line, &camera(0.0), tilt_rad)).collect();
            n_found += found.len();
            for bearing in found {
                assert!(bearing.contains(bearing_rad), "round {round}: {bearing_rad} is not in {bearing}");
                assert!(bearing.width() < 0.004, "round {round}: {}", bearing.width());
            }
        }
        assert!(n_found >= rounds(12), "{n_found} edges found");
    }

    #[test]
    fn a_lean_bends_the_bearing_by_no_more_than_is_counted_in() {
        let (mut draw, mut farthest_rad) = (Draw::new(11), 0.0_f64);
        let tilt_rad = 0.06;
        for round in 0..rounds(500) {
            let bearing_rad = draw.between(-0.5, 0.5);
            let (lean, _) = trial::tilt(&mut draw, tilt_rad);
            let forward = lean * Vector3::x();
            let lean = Rotation3::from_axis_angle(&Vector3::z_axis(), -forward.y.atan2(forward.x)) * lean;
            // The pixels of two points of the edge, 0.1 m below and 0.6 m above the camera and 2 m away, without any error.
            let pixel = |up_m: f64| {
                let at = lean.inverse() * Vector3::new(2.0 * bearing_rad.cos(), 2.0 * bearing_rad.sin(), up_m);
                let (sin, cos) = TILT_UP_RAD.sin_cos();
                let [right, down, ahead] = [-at.y, at.x * sin - at.z * cos, at.x * cos + at.z * sin];
                [319.5 + FOCAL_PX * right / ahead, 239.5 + FOCAL_PX * down / ahead]
            };
            let line = EdgeLine { ends_px: [pixel(-0.1), pixel(0.6)], bound_px: 1e-6 };
            let Some(found) = bearing(&line, &camera(0.0), tilt_rad) else { panic!("round {round}: {line:?}") };
            assert!(found.contains(bearing_rad), "round {round}: {bearing_rad} is not in {found}");
            farthest_rad = farthest_rad.max((found.mid() - bearing_rad).abs());
        }
        // A quarter of the square of the lean is 0.9 mrad: some leans bend the bearing by about as much.
        assert!(farthest_rad > 0.0005 && farthest_rad < 0.002, "{farthest_rad}");
    }

    #[test]
    fn a_slanting_edge_is_upright_only_where_the_lean_may_be_as_great() {
        // An edge from (315, 400) to (325, 100) departs by 1.9°, 0.033 rad, from the image's vertical.
        let slanting = EdgeLine { ends_px: [[315.0, 400.0], [325.0, 100.0]], bound_px: 0.3 };
        assert_eq!(bearing(&slanting, &camera(0.0), 0.01), None);
        assert!(bearing(&slanting, &camera(0.02), 0.02).is_some());
        // The plane through the image's middle column looks straight ahead.
        let ahead = EdgeLine { ends_px: [[319.5, 400.0], [319.5, 100.0]], bound_px: 0.3 };
        let Some(found) = bearing(&ahead, &camera(0.0), 0.001) else { panic!("{ahead:?}") };
        assert!(found.contains(0.0) && found.width() < 0.003, "{found}");
        // Both ends 200 px to the left, at the horizon and above it: a plane that slants more than any declared lean.
        let aside = EdgeLine { ends_px: [[119.5, 302.0], [119.5, 20.0]], bound_px: 0.3 };
        assert_eq!(bearing(&aside, &camera(0.0), 0.001), None);
    }
}
