//! What lens and shutter put between the image as taken and the picture that a pinhole would take at one instant.

use image::GrayImage;

use crate::{
    Interval,
    robot::FloorCameraModel,
    vision::{
        FloorLines,
        straighten::{RowMotion, Straightening},
    },
};

use super::{
    Geometry,
    joint::{POINT_SLACK_M, body_shift_m},
};

/// The way from the image as taken to the pinhole's picture, where lines are looked for and fitted, and back.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    size_px: [u32; 2],
    focal_px: f64,
    distortion: [f64; 5],
    /// `None` for a lens that does not bend.
    straightening: Option<Straightening>,
}

/// The stretch changes by less than this share within the way of one bound, which is sampled at its ends, and so is a bound that is
/// told across a line whose normal is known to a hundredth.
const ABOVE: f64 = 1.01;
/// Two ends of a line 90 px long, each 2 px off, turn its normal by less than this.
const NORMAL_ERROR_RAD: f64 = 0.05;

impl Optics {
    pub(super) fn of(camera: &FloorCameraModel) -> Self {
        let focal_px = camera.pixels_per_m.mid() * camera.height_m;
        let size_px = [camera.width_px, camera.height_px];
        let straightening = Straightening::new(size_px, focal_px, camera.distortion, RowMotion::default());
        Optics { size_px, focal_px, distortion: camera.distortion, straightening }
    }

    /// Lines found in an image, in the pixels of the pinhole's picture at the time of each point's row.
    ///
    /// They are looked for in the picture that the motion from row to row, as the wheels tell it, would leave straight. Were it another, joints
    /// would be bent and fewer of them found, but a point found is always told where its row shows it.
    pub(super) fn look(
        &self,
        image: &GrayImage,
        rows: RowMotion,
        find: impl Fn(&GrayImage) -> FloorLines,
    ) -> FloorLines {
        let of_rows = (rows != RowMotion::default())
            .then(|| Straightening::new(self.size_px, self.focal_px, self.distortion, rows))
            .flatten();
        match of_rows.as_ref().or(self.straightening.as_ref()) {
            Some(lens) => lens.in_pinhole(find(&lens.straight(image))),
            None => find(image),
        }
    }

    /// By how much lens and shutter may have put each point of a line, `[u, v, bound]` in the pinhole's picture, off across it.
    ///
    /// The lens: its calibration's error, stretched as the straightening stretches, and what another focal length of the declared scale
    /// would have bent otherwise. The shutter: what the floor may have moved between the row's exposure and the stamp, and the body's
    /// posture, which may be another in each row.
    pub(super) fn left_open_px(&self, points_px: &[[f64; 3]], geometry: &Geometry) -> Vec<f64> {
        let normal = normal(points_px);
        let open_px = |point: &[f64; 3]| self.lens_px(point, normal, geometry) + self.rows_px(point, normal, geometry);
        points_px.iter().map(open_px).collect()
    }

    fn lens_px(&self, &[u, v, _]: &[f64; 3], normal: [f64; 2], geometry: &Geometry) -> f64 {
        let camera = &geometry.camera;
        let Some(lens) = &self.straightening else { return camera.distortion_px };
        // A raw error is longer in the pinhole's picture: sampled as far away as it may reach.
        let here = lens.stretch_across([u, v], normal);
        let stretch = stretches(lens, [u, v], normal, camera.distortion_px * here).fold(here, f64::max);
        let focal_share = camera.pixels_per_m.radius() / camera.pixels_per_m.lo();
        let shift = lens.focal_shift_px([u, v]);
        let across = (normal[0] * shift[0] + normal[1] * shift[1]).abs() + NORMAL_ERROR_RAD * shift[0].hypot(shift[1]);
        ABOVE * (camera.distortion_px * stretch + focal_share * across)
    }

    /// A point at q in the robot frame at its row's instant is at R q + t at the stamp, |t| ≤ speed·Δt and |R q − q| ≤ turn rate·Δt·|q|.
    fn rows_px(&self, &[u, v, bound_px]: &[f64; 3], normal: [f64; 2], geometry: &Geometry) -> f64 {
        let (camera, reach) = (&geometry.camera, &geometry.robot.reach);
        if camera.row_time_s <= 0.0 {
            return 0.0;
        }
        let row_px = self.straightening.as_ref().map_or(v, |lens| lens.raw_px([u, v])[1]);
        let rows = (row_px - (f64::from(camera.height_px) - 1.0) / 2.0).abs() + bound_px;
        let [forward_px, left_px] = geometry.in_camera_px([u, v]);
        let place_m = [0, 1]
            .map(|axis| camera.position_m[axis] + Interval::point([forward_px, left_px][axis]) / camera.pixels_per_m);
        let arm_m = place_m[0].magnitude().hypot(place_m[1].magnitude()) + POINT_SLACK_M;
        let moved_m = rows * camera.row_time_s * (reach.speed_m_per_s + reach.turn_rate_rad_per_s * arm_m);
        // n·p with n = (cos, sin) in (u, v), which are minus left and minus forward; bounds hold for either sign.
        let distance_px =
            (normal[0] * left_px + normal[1] * forward_px).abs() + NORMAL_ERROR_RAD * forward_px.hypot(left_px);
        let posture_m = body_shift_m(distance_px / camera.pixels_per_m.lo(), arm_m, geometry);
        (moved_m + posture_m) * camera.pixels_per_m.hi()
    }

    /// Points of a line where the image as taken shows them, with bounds that hold of the joint's image there.
    pub(super) fn as_taken(&self, points_px: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        let Some(lens) = &self.straightening else { return points_px };
        let normal = normal(&points_px);
        let told = |&[u, v, bound_px]: &[f64; 3]| {
            let least = stretches(lens, [u, v], normal, bound_px).fold(lens.stretch_across([u, v], normal), f64::min);
            let [raw_u, raw_v] = lens.raw_px([u, v]);
            [raw_u, raw_v, ABOVE * bound_px / least]
        };
        points_px.iter().map(told).collect()
    }

    /// The ends of a segment where the image as taken shows them.
    pub(super) fn segment_as_taken(&self, segment: [f64; 4]) -> [f64; 4] {
        let Some(lens) = &self.straightening else { return segment };
        let [from, to] = [[segment[0], segment[1]], [segment[2], segment[3]]].map(|end| lens.raw_px(end));
        [from[0], from[1], to[0], to[1]]
    }
}

/// Stretch across a line at a distance to either side of a point.
fn stretches(lens: &Straightening, [u, v]: [f64; 2], normal: [f64; 2], off_px: f64) -> impl Iterator<Item = f64> {
    let sides = [-off_px, off_px].map(|off_px| [u + off_px * normal[0], v + off_px * normal[1]]);
    sides.map(|side| lens.stretch_across(side, normal)).into_iter()
}

/// Unit normal of the line through the first and the last point; any where there is no such line.
fn normal(points_px: &[[f64; 3]]) -> [f64; 2] {
    let (Some(first), Some(last)) = (points_px.first(), points_px.last()) else { return [1.0, 0.0] };
    let (du, dv) = (last[0] - first[0], last[1] - first[1]);
    let length_px = du.hypot(dv);
    if length_px > 0.0 { [-dv / length_px, du / length_px] } else { [1.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::super::{
        Chain, FloorTiles,
        trial::{HEIGHT_M, SCALE, known_robot, method},
    };

    /// The middle of the picture, and a place 0.6 focal lengths right of it.
    const MIDDLE_PX: [f64; 2] = [319.5, 239.5];
    const ASIDE_PX: f64 = MIDDLE_PX[0] + 0.6 * SCALE * HEIGHT_M;
    const BARREL: [f64; 5] = [-0.25, 0.0, 0.0, 0.0, 0.0];

    fn without_errors(distortion: [f64; 5], distortion_px: f64, row_time_s: f64) -> FloorTiles {
        method(&known_robot(0.0, distortion, distortion_px, row_time_s), Chain::Direct)
    }

    /// A line's points about a place, along u or along v.
    fn line(along: [f64; 2], [u, v]: [f64; 2]) -> Vec<[f64; 3]> {
        (-2..=2).map(|step| [u + 2.0 * f64::from(step) * along[0], v + 2.0 * f64::from(step) * along[1], 0.3]).collect()
    }

    #[test]
    fn bounds_shrink_across_a_line_as_its_image_does_and_errors_grow_as_much() {
        // By hand, at x = 0.6 and y = 0: ∂u/∂x = 1 + 3·k1·x² = 0.73, ∂v/∂y = 1 + k1·x² = 0.91.
        let method = without_errors(BARREL, 0.5, 0.0);
        for (along, slope) in [([0.0, 1.0], 0.73), ([1.0, 0.0], 0.91)] {
            let points_px = line(along, [ASIDE_PX, MIDDLE_PX[1]]);
            let told = method.optics.as_taken(points_px.clone())[2];
            let raw_u = MIDDLE_PX[0] + 0.6 * (1.0 - 0.25 * 0.36) * SCALE * HEIGHT_M;
            assert!((told[0] - raw_u).abs() < 1e-9 && (told[1] - MIDDLE_PX[1]).abs() < 1e-9, "{told:?}");
            assert!((1.0..1.02).contains(&(told[2] / (0.3 * slope))), "{told:?}");
            let open_px = method.optics.left_open_px(&points_px, &method.geometry)[2];
            assert!((1.0..1.02).contains(&(open_px / (0.5 / slope))), "{open_px}");
        }
        let segment = method.optics.segment_as_taken([MIDDLE_PX[0], MIDDLE_PX[1], ASIDE_PX, MIDDLE_PX[1]]);
        assert!((segment[2] - MIDDLE_PX[0] - 0.546 * SCALE * HEIGHT_M).abs() < 1e-9 && segment[0] == MIDDLE_PX[0]);
    }

    #[test]
    fn another_focal_length_of_the_declared_scale_is_left_open() {
        // Nothing is open across a line through the middle. Across u at x = 0.6: x − D/D' = 0.6 − 0.546/0.73 focal lengths a share.
        let robot = known_robot(1.0, BARREL, 0.0, 0.0);
        let method = method(&robot, Chain::Direct);
        let open_px = method.optics.left_open_px(&line([0.0, 1.0], [ASIDE_PX, MIDDLE_PX[1]]), &method.geometry)[2];
        let expected_px = 0.001 * (0.6_f64 - 0.546 / 0.73).abs() * SCALE * HEIGHT_M;
        assert!((1.0..1.07).contains(&(open_px / expected_px)), "{open_px} {expected_px}");
        let open_px = method.optics.left_open_px(&line([1.0, 0.0], [ASIDE_PX, MIDDLE_PX[1]]), &method.geometry)[2];
        assert!(open_px < 0.07 * expected_px);
    }

    #[test]
    fn a_row_leaves_open_what_the_floor_may_move_until_the_stamp() {
        // By hand: 100.3 rows of 30 µs below the middle, at 0.7 m/s and 1.6 rad/s about the origin, from which the point is
        // (−0.15 − 100/SCALE, 0.03) = (−0.225, 0.03), 0.2270 m and the slack of 0.01 m away: 3.009 ms · 1.0792 m/s = 3.247 mm.
        let method = without_errors([0.0; 5], 0.0, 30e-6);
        let points_px = line([1.0, 0.0], [MIDDLE_PX[0], MIDDLE_PX[1] + 100.0]);
        let open_px = method.optics.left_open_px(&points_px, &method.geometry)[2];
        assert!((open_px - 3.247e-3 * SCALE).abs() < 2e-3, "{open_px}");
        // Behind a barrel the same point is in a row nearer to the middle: 0.3·(1 − 0.25·0.09) of the focal length.
        let method = without_errors(BARREL, 0.0, 30e-6);
        let bent_px = method.optics.left_open_px(&points_px, &method.geometry)[2];
        assert!((bent_px / open_px - 98.05 / 100.3).abs() < 1e-4, "{bent_px} {open_px}");
    }

    #[test]
    fn a_row_leaves_open_the_posture_of_its_own() {
        // By hand: 0.075 m from the point below the camera, 0.3 of the height, the slope of the sight: times the arm and the tilt.
        let [rolling, rolling_level] =
            [1.0, 0.0].map(|factor| method(&known_robot(factor, [0.0; 5], 0.0, 1e-9), Chain::Direct));
        let points_px = line([1.0, 0.0], [MIDDLE_PX[0], MIDDLE_PX[1] + 100.0]);
        let [tilted_px, level_px] =
            [&rolling, &rolling_level].map(|method| method.optics.left_open_px(&points_px, &method.geometry)[2]);
        let expected_px = 0.3 * (0.237 * 0.1_f64.to_radians() + 0.0001) * SCALE;
        assert!((1.0..1.1).contains(&((tilted_px - level_px) / expected_px)), "{tilted_px} {level_px} {expected_px}");
    }
}
