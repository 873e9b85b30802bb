//! Effects of lens and shutter: the difference between the floor image as taken and the picture that a pinhole would take at one instant.

use image::GrayImage;

use interval::Interval;

use crate::{
    robot::FloorCameraModel,
    vision::{
        FloorLines,
        distortion::{self, Unbent},
        straighten::{RowMotion, Straightening},
    },
};

use super::{
    Geometry,
    joint::{FloorPoint, body_shift_m},
    normals::Normals,
};

/// Map from the image as taken to the pinhole's picture, in which lines are looked for and fitted, and back.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    size_px: [u32; 2],
    focal_px: f64,
    distortion: [f64; 5],
    /// Map that takes the lens distortion out; `None` for a lens without distortion.
    straightening: Option<Straightening>,
}

impl Optics {
    pub(super) fn of(camera: &FloorCameraModel) -> Self {
        let focal_px = camera.pixels_per_m.mid() * camera.height_m;
        let size_px = [camera.width_px, camera.height_px];
        let straightening = Straightening::new(size_px, focal_px, camera.distortion, RowMotion::default());
        Optics { size_px, focal_px, distortion: camera.distortion, straightening }
    }

    /// Lines found in an image of the floor, in pixels of the pinhole's picture at the exposure of each point's row.
    ///
    /// Lines are looked for in a picture that is straightened with the motion from row to row that the wheels report. If the true motion is
    /// another, joints are bent and fewer of them are found, but a point that is found is always given where its own row shows it.
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

    /// Greatest error that lens and shutter may leave at each point of a line, across the line. The points are `[u, v, bound]` in the
    /// pinhole's picture, and a share of them may belong to no joint; `None` where declared errors may put a point anywhere.
    ///
    /// The lens contributes its calibration's error, stretched as the straightening stretches the image, and the difference in distortion
    /// that another focal length within the declared scale makes. The shutter contributes what the floor may have moved between the row's
    /// exposure and the stamp, and the body's posture, which may differ from row to row. Across means across the true line: at first its
    /// direction may be any, and then only the directions are allowed that remain with the wide bounds of that first step.
    pub(super) fn left_open_px(
        &self,
        points_px: &[[f64; 3]],
        share_wrong: f64,
        geometry: &Geometry,
    ) -> Option<Vec<f64>> {
        let open_px = |normals: &Normals| -> Option<Vec<f64>> {
            let open = |point: &[f64; 3]| {
                Some(self.lens_px(point, normals, geometry)? + self.rows_px(point, normals, geometry)?)
            };
            points_px.iter().map(open).collect()
        };
        if self.straightening.is_none() && geometry.camera.row_time_s <= 0.0 {
            return Some(vec![geometry.camera.distortion_px; points_px.len()]);
        }
        let anyhow_px = open_px(&Normals::any())?;
        let straightness_px = geometry.grid.straightness_m * geometry.camera.pixels_per_m.hi();
        let told = points_px.iter().zip(&anyhow_px);
        let wide_px: Vec<[f64; 3]> =
            told.map(|(&[u, v, bound], open)| [u, v, bound + open + straightness_px]).collect();
        open_px(&Normals::of(&wide_px, share_wrong))
    }

    /// Greatest error that the lens leaves at a point, across any line whose normal is one of the given normals.
    ///
    /// With the true f and D(x) the lens's distortion, the image is at raw = f·D(x) + d, with |d| within the calibration's error, and the
    /// pinhole of the declared scale shows f·x = f·D⁻¹((raw − d)/f). By the mean value theorem that differs from f₀·D⁻¹(raw/f₀) by at most
    /// |n·J⁻¹|·|d| + |f − f₀|·|n·(x − J⁻¹·D(x))| across a line of normal n, for x and J = ∂D(x) over the box of all values that x may have.
    fn lens_px(&self, &[u, v, _]: &[f64; 3], normals: &Normals, geometry: &Geometry) -> Option<f64> {
        let camera = &geometry.camera;
        let Some(lens) = &self.straightening else { return Some(camera.distortion_px) };
        let focal_px = camera.pixels_per_m * camera.height_m;
        let middle_px = lens.raw_px(geometry.principal_point_px());
        let raw_px = lens.raw_px([u, v]);
        let seen =
            [0, 1].map(|axis| Interval::centred(raw_px[axis] - middle_px[axis], camera.distortion_px) / focal_px);
        let Unbent { at, slopes: [a, mixed, b] } = distortion::unbent(self.distortion, seen)?;
        let shift = [at[0] - (a * seen[0] + mixed * seen[1]), at[1] - (mixed * seen[0] + b * seen[1])];
        let off_px = (focal_px - self.focal_px).magnitude();
        let by_lens_px = Interval::point(normals.longest([a, mixed, b])) * camera.distortion_px;
        Some((by_lens_px + Interval::point(normals.farthest(shift)) * off_px).hi())
    }

    /// Greatest error that the row-by-row exposure leaves at a point, across any line whose normal is one of the given normals. A point at
    /// q in the robot frame at its row's exposure is at R q + t at the stamp, with |t| ≤ speed·Δt and |R q − q| ≤ turn rate·Δt·|q|.
    fn rows_px(&self, &[u, v, bound_px]: &[f64; 3], normals: &Normals, geometry: &Geometry) -> Option<f64> {
        let (camera, reach) = (&geometry.camera, &geometry.robot.reach);
        if camera.row_time_s <= 0.0 {
            return Some(0.0);
        }
        let row_px = self.straightening.as_ref().map_or(v, |lens| lens.raw_px([u, v])[1]);
        let rows = (row_px - (f64::from(camera.height_px) - 1.0) / 2.0).abs() + bound_px;
        let [forward_px, left_px] = geometry.in_camera_px([u, v]);
        let point = FloorPoint::of([forward_px, left_px], bound_px, geometry)?;
        let moved_m = rows * camera.row_time_s * (reach.speed_m_per_s + reach.turn_rate_rad_per_s * point.arm_m);
        // The product n·p has n = (cos, sin) in (u, v), whose axes are minus left and minus forward; the bounds hold for either sign.
        let along_px = normals.farthest([left_px, forward_px].map(Interval::point)) + bound_px;
        let posture_m = body_shift_m(along_px / camera.pixels_per_m.lo(), &point, geometry);
        Some((moved_m + posture_m) * camera.pixels_per_m.hi())
    }

    /// Points of a line, moved to where the image as taken shows them; a share of the points may belong to no joint. Each point gets a
    /// bound such that a joint whose image as taken is within it is within the point's own bound in the pinhole's picture. `None` where the
    /// lens may fold.
    ///
    /// A step e in the raw image is the step J⁻¹e in the pinhole's picture, and n·J⁻¹e ≤ |J⁻¹n|·|e| across a line of normal n. Because a
    /// line is only known to pass such points within e, all lines are first allowed that pass the points within any |J⁻¹|·|e|.
    pub(super) fn as_taken(&self, points_px: Vec<[f64; 3]>, share_wrong: f64) -> Option<Vec<[f64; 3]>> {
        let Some(lens) = &self.straightening else { return Some(points_px) };
        let slopes = |&[u, v, bound_px]: &[f64; 3]| lens.slopes_over([u, v].map(|at| Interval::centred(at, bound_px)));
        let slopes: Vec<[Interval; 3]> = points_px.iter().map(slopes).collect::<Option<_>>()?;
        let wide = points_px.iter().zip(&slopes).map(|(&[u, v, bound_px], &[a, mixed, b])| {
            let most = a.hypot(mixed).hypot(mixed.hypot(b)).hi() * Normals::any().longest(inverse([a, mixed, b]));
            [u, v, bound_px * most.max(1.0)]
        });
        let normals = Normals::of(&wide.collect::<Vec<_>>(), share_wrong);
        let told = points_px.iter().zip(slopes).map(|(&[u, v, bound_px], slopes)| {
            let [raw_u, raw_v] = lens.raw_px([u, v]);
            [raw_u, raw_v, bound_px / normals.longest(inverse(slopes))]
        });
        Some(told.collect())
    }

    /// Segment with its ends moved to where the image as taken shows them.
    pub(super) fn segment_as_taken(&self, segment: [f64; 4]) -> [f64; 4] {
        let Some(lens) = &self.straightening else { return segment };
        let [from, to] = [[segment[0], segment[1]], [segment[2], segment[3]]].map(|end| lens.raw_px(end));
        [from[0], from[1], to[0], to[1]]
    }
}

/// Inverse of a symmetric matrix `[a, mixed, b]`, in the same form.
fn inverse([a, mixed, b]: [Interval; 3]) -> [Interval; 3] {
    let determinant = a * b - mixed.sqr();
    [b / determinant, -mixed / determinant, a / determinant]
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::super::{
        Chain, FloorTiles,
        trial::{Eye, HEIGHT_M, SCALE, known_robot, method},
    };
    use crate::vision::synthetic::Random;

    /// Middle of the picture, and the u coordinate of a place 0.6 focal lengths to the right of the middle.
    const MIDDLE_PX: [f64; 2] = [319.5, 239.5];
    const ASIDE_PX: f64 = MIDDLE_PX[0] + 0.6 * SCALE * HEIGHT_M;
    const BARREL: [f64; 5] = [-0.25, 0.0, 0.0, 0.0, 0.0];

    fn without_errors(distortion: [f64; 5], distortion_px: f64, row_time_s: f64) -> FloorTiles {
        method(&known_robot(0.0, distortion, distortion_px, row_time_s), Chain::Direct)
    }

    /// Points of a line through a given place, up to 60 px to either side of it along u or along v; the point in the middle is the place
    /// itself.
    fn line(along: [f64; 2], [u, v]: [f64; 2]) -> Vec<[f64; 3]> {
        let at = |step: i32| 20.0 * f64::from(step);
        (-3..=3).map(|step| [u + at(step) * along[0], v + at(step) * along[1], 0.3]).collect()
    }

    /// Error left open at the middle point of a line when all of the line's points are right.
    fn opened_px(method: &FloorTiles, points_px: &[[f64; 3]]) -> f64 {
        method.optics.left_open_px(points_px, 0.0, &method.geometry).expect("in the picture")[points_px.len() / 2]
    }

    #[test]
    fn bounds_shrink_across_a_line_as_its_image_does_and_errors_grow_as_much() {
        // Slopes of the lens by hand, at x = 0.6 and y = 0: ∂u/∂x = 1 + 3·k1·x² = 0.73, ∂v/∂y = 1 + k1·x² = 0.91.
        let method = without_errors(BARREL, 0.5, 0.0);
        for (along, slope) in [([0.0, 1.0], 0.73), ([1.0, 0.0], 0.91)] {
            let points_px = line(along, [ASIDE_PX, MIDDLE_PX[1]]);
            let told = method.optics.as_taken(points_px.clone(), 0.0).expect("in the picture")[3];
            let raw_u = MIDDLE_PX[0] + 0.6 * (1.0 - 0.25 * 0.36) * SCALE * HEIGHT_M;
            assert!((told[0] - raw_u).abs() < 1e-9 && (told[1] - MIDDLE_PX[1]).abs() < 1e-9, "{told:?}");
            // The bound in the raw image is no more than bound times slope: a joint near enough to a point as taken is near enough in the
            // pinhole's picture.
            assert!((0.97..=1.0).contains(&(told[2] / (0.3 * slope))), "{told:?}");
            let open_px = opened_px(&method, &points_px);
            // The error left open is slightly larger than the lens error: the line may be turned by as much as its points are off, towards
            // directions in which the lens stretches more.
            assert!((1.0..1.05).contains(&(open_px / (0.5 / slope))), "{open_px}");
        }
        let segment = method.optics.segment_as_taken([MIDDLE_PX[0], MIDDLE_PX[1], ASIDE_PX, MIDDLE_PX[1]]);
        assert!((segment[2] - MIDDLE_PX[0] - 0.546 * SCALE * HEIGHT_M).abs() < 1e-9 && segment[0] == MIDDLE_PX[0]);
    }

    #[test]
    fn another_focal_length_of_the_declared_scale_is_left_open() {
        // By hand: a wrong focal length leaves nothing open across a line through the middle. Across u at x = 0.6 the error, as a multiple
        // of the focal length's error, is x − D/D' = 0.6 − 0.546/0.73.
        let robot = known_robot(1.0, BARREL, 0.0, 0.0);
        let method = method(&robot, Chain::Direct);
        let open_px = opened_px(&method, &line([0.0, 1.0], [ASIDE_PX, MIDDLE_PX[1]]));
        let expected_px = 0.001 * (0.6_f64 - 0.546 / 0.73).abs() * SCALE * HEIGHT_M;
        assert!((1.0..1.07).contains(&(open_px / expected_px)), "{open_px} {expected_px}");
        let open_px = opened_px(&method, &line([1.0, 0.0], [ASIDE_PX, MIDDLE_PX[1]]));
        assert!(open_px < 0.07 * expected_px);
    }

    #[test]
    fn no_error_of_lens_and_focal_length_puts_a_point_farther_off_its_line_than_is_left_open() {
        let mut random = Random::new(101);
        let corner = |random: &mut Random| [-1.0, 1.0][usize::from(random.chance(0.5))];
        let lenses = [BARREL, [-0.25, 0.06, 0.001, -0.002, 0.0], [0.12, -0.02, -0.001, 0.001, 0.0]];
        let errors = [[0.0, 1.0], [0.3, 1.0], [3.0, 0.0], [0.3, 10.0]];
        let known = lenses.into_iter().flat_map(|lens| {
            errors
                .map(|[off_px, factor]| (lens, off_px, method(&known_robot(factor, lens, off_px, 0.0), Chain::Direct)))
        });
        let known: Vec<([f64; 5], f64, FloorTiles)> = known.collect();
        let mut nearest = 0.0_f64;
        for draw in 0..10_000 {
            let (lens, off_px, method) = &known[draw % known.len()];
            let (lens, off_px) = (*lens, *off_px);
            let believed = Eye::exact(lens);
            let scale = method.geometry.camera.pixels_per_m;
            let focal_px = HEIGHT_M * if random.chance(0.5) { scale.lo() } else { scale.hi() };
            let at = [random.between(-0.5, 0.5), random.between(-0.4, 0.4)];
            let (sin, cos) = random.between(-3.2, 3.2).sin_cos();
            let course = random.between(-3.2, 3.2) * corner(&mut random);
            // Places of a line's points in the pinhole's picture, and in the picture that is straightened with the lens as believed.
            let shown = (-3..=3).map(|step| {
                let ray = [at[0] - 0.06 * f64::from(step) * sin, at[1] + 0.06 * f64::from(step) * cos];
                let bent = believed.bent(ray[0], ray[1]);
                let raw = [0, 1].map(|axis| MIDDLE_PX[axis] + focal_px * bent[axis]);
                let told = believed.ray([raw[0] + off_px * course.cos(), raw[1] + off_px * course.sin()]);
                [0, 1].map(|axis| (focal_px * ray[axis], believed.focal_px * told[axis]))
            });
            let shown: Vec<[(f64, f64); 2]> = shown.collect();
            let points: Vec<[f64; 3]> =
                shown.iter().map(|[u, v]| [MIDDLE_PX[0] + u.1, MIDDLE_PX[1] + v.1, 1e-6]).collect();
            let Some(open_px) = method.optics.left_open_px(&points, 0.0, &method.geometry) else { continue };
            for ([u, v], open_px) in shown.iter().zip(open_px) {
                let across_px = ((u.1 - u.0) * cos + (v.1 - v.0) * sin).abs();
                assert!(across_px <= open_px + 1e-6, "{across_px} px, {open_px} px left open at {at:?} by {lens:?}");
                nearest = nearest.max(across_px / (open_px + 1e-3));
            }
        }
        assert!(nearest > 0.9, "{nearest}");
    }

    #[test]
    fn a_row_leaves_open_what_the_floor_may_move_until_the_stamp() {
        // By hand: the point is 100.3 rows of 30 µs below the middle. The robot moves at 0.7 m/s and turns at 1.6 rad/s about its origin,
        // from which the point at (−0.15 − 100/SCALE, 0.03) = (−0.225, 0.03) is 0.2270 m and 0.3 px, 0.2 mm, away: 3.009 ms · 1.0636 m/s =
        // 3.200 mm.
        let method = without_errors([0.0; 5], 0.0, 30e-6);
        let points_px = line([1.0, 0.0], [MIDDLE_PX[0], MIDDLE_PX[1] + 100.0]);
        let open_px = opened_px(&method, &points_px);
        assert!((open_px - 3.200e-3 * SCALE).abs() < 2e-3, "{open_px}");
        // Behind a barrel lens the same point is in a row nearer to the middle: at 0.3·(1 − 0.25·0.09) of the focal length.
        let method = without_errors(BARREL, 0.0, 30e-6);
        let bent_px = opened_px(&method, &points_px);
        assert!((bent_px / open_px - 98.05 / 100.3).abs() < 1e-4, "{bent_px} {open_px}");
    }

    #[test]
    fn a_row_leaves_open_the_posture_of_its_own() {
        // By hand: the point is 0.075 m from the point below the camera, 0.3 of the camera's height. This slope of the ray multiplies the
        // rise of the point, which is arm times tilt plus heave.
        let [rolling, rolling_level] =
            [1.0, 0.0].map(|factor| method(&known_robot(factor, [0.0; 5], 0.0, 1e-9), Chain::Direct));
        let points_px = line([1.0, 0.0], [MIDDLE_PX[0], MIDDLE_PX[1] + 100.0]);
        let [tilted_px, level_px] = [&rolling, &rolling_level].map(|method| opened_px(method, &points_px));
        let expected_px = 0.3 * (0.228 * 0.1_f64.to_radians() + 0.0001) * SCALE;
        assert!((1.0..1.1).contains(&((tilted_px - level_px) / expected_px)), "{tilted_px} {level_px} {expected_px}");
    }
}
