//! Looks that one camera has taken, searched by cameras of other focal lengths from other distances. Pictures are rendered ray by ray from a formula.

use std::sync::OnceLock;

use image::{GrayImage, Luma};

use super::*;
use crate::{
    PoseUnion, Reading,
    graph::trial::{Draw, robot},
    map::Anchor,
    method::{Context, Memory, Method},
    methods::mapped_landmarks::{
        Learning, PointCameraModel,
        pictures::{Declared, KnownLandmarks, PicturedLandmarks},
    },
    reading::Camera,
    robot::ForwardCameraModel,
    vision::point_features::ImageBounds,
};

const SIZE_PX: [u32; 2] = [320, 240];
const CENTRE_PX: [f64; 2] = [159.5, 119.5];
/// World x of the wall.
const WALL_M: f64 = 3.0;
/// Focal length of the camera that takes the looks: a pixel is a centimetre of the wall.
const FOCAL_PX: f64 = 300.0;

/// Pseudo-random number in [0, 1) of a cell of a lattice (the finaliser of splitmix64).
fn hashed(column: i64, row: i64, which: u64) -> f64 {
    let mut z = (column as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (row as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    z ^= which.wrapping_mul(0x1656_67B1_9E37_79F9);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Grey level of the wall at a place along y and z: of cells of 4 mm, each of which is drawn once.
fn grey(place_m: [f64; 2]) -> f64 {
    const CELL_M: f64 = 0.004;
    const N_CELLS: i64 = 500;
    static CELLS: OnceLock<Vec<f32>> = OnceLock::new();
    let drawn = |column: i64, row: i64| painted([column, row].map(|at| (at as f64 + 0.5) * CELL_M));
    let [column, row] = place_m.map(|at_m| (at_m / CELL_M).floor() as i64);
    let cells = || (-N_CELLS..N_CELLS).flat_map(|row| (-N_CELLS..N_CELLS).map(move |column| [column, row]));
    let all = CELLS.get_or_init(|| cells().map(|[column, row]| drawn(column, row) as f32).collect());
    let idx = (row + N_CELLS) * 2 * N_CELLS + column + N_CELLS;
    let is_drawn = [column, row].iter().all(|at| (-N_CELLS..N_CELLS).contains(at));
    if is_drawn { f64::from(all[idx as usize]) } else { drawn(column, row) }
}

/// Grey level at a place along y and z: rectangles in three sizes and turns.
fn painted([y_m, z_m]: [f64; 2]) -> f64 {
    let rectangle = |pitch_m: f64, turn_rad: f64, which: u64| {
        let (sin, cos) = turn_rad.sin_cos();
        let (x, y) = ((y_m * cos + z_m * sin) / pitch_m, (z_m * cos - y_m * sin) / pitch_m);
        let draw = |more: u64| hashed(x.floor() as i64, y.floor() as i64, which + more);
        let is_in = |at: f64, low: f64, high: f64| at > 0.4 * low && at < 1.0 - 0.4 * high;
        let is_inside = is_in(x - x.floor(), draw(1), draw(2)) && is_in(y - y.floor(), draw(3), draw(4));
        (is_inside && draw(5) < 0.6).then(|| 30.0 + 180.0 * draw(6))
    };
    let shade =
        rectangle(0.13, -0.6, 100).or_else(|| rectangle(0.29, 0.35, 200)).or_else(|| rectangle(0.53, 0.05, 300));
    shade.unwrap_or(120.0)
}

/// The place whose grey level is seen at a place of the wall along y and z, once two pictures of 0.8 m by 0.9 m hang in each other's place, 1 m apart.
fn exchanged([y_m, z_m]: [f64; 2]) -> [f64; 2] {
    let is_on = |middle_m: f64| (y_m - middle_m).abs() <= 0.4 && (z_m - 0.3).abs() <= 0.45;
    let from_m = if is_on(EXCHANGED_M[0]) { EXCHANGED_M[1] - EXCHANGED_M[0] } else { 0.0 };
    let from_m = if is_on(EXCHANGED_M[1]) { EXCHANGED_M[0] - EXCHANGED_M[1] } else { from_m };
    [y_m + from_m, z_m]
}

/// The middles of the pictures, along y.
const EXCHANGED_M: [f64; 2] = [-0.5, 0.5];

/// A level pinhole camera before the wall as it was, or after two of its pictures were exchanged.
#[derive(Clone, Copy, Default)]
pub(in super::super) struct Eye {
    pub(in super::super) place_m: [f64; 3],
    pub(in super::super) heading_rad: f64,
    pub(in super::super) focal_px: f64,
    pub(in super::super) is_later: bool,
}

impl Eye {
    /// Place on the wall, along y and z, that is seen at a pixel.
    fn on_wall(&self, at_px: [f64; 2]) -> [f64; 2] {
        let [right, down] = [0, 1].map(|axis| (at_px[axis] - CENTRE_PX[axis]) / self.focal_px);
        let (sin, cos) = self.heading_rad.sin_cos();
        let ahead = (WALL_M - self.place_m[0]) / (cos + right * sin);
        [self.place_m[1] + ahead * (sin - right * cos), self.place_m[2] - ahead * down]
    }

    /// Pixel at which a place on the wall is seen.
    fn projected(&self, [y_m, z_m]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.heading_rad.sin_cos();
        let [x, y, z] = [WALL_M - self.place_m[0], y_m - self.place_m[1], z_m - self.place_m[2]];
        let ahead = cos * x + sin * y;
        [CENTRE_PX[0] + self.focal_px * (sin * x - cos * y) / ahead, CENTRE_PX[1] - self.focal_px * z / ahead]
    }

    /// The picture, blurred as by a good lens: points half a pixel apart, weighted by a Gaussian of 0.6 px.
    fn picture(&self) -> GrayImage {
        let steps = || (-2..=2).map(|step| 0.5 * f64::from(step));
        let weight = |off: f64| (-0.5 * (off / 0.6).powi(2)).exp();
        let sum: f64 = steps().map(weight).sum::<f64>().powi(2);
        GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |u, v| {
            let around = steps().flat_map(|du| steps().map(move |dv| [du, dv]));
            let part = |[du, dv]: [f64; 2]| {
                let at_m = self.on_wall([f64::from(u) + du, f64::from(v) + dv]);
                weight(du) * weight(dv) * grey(if self.is_later { exchanged(at_m) } else { at_m })
            };
            Luma([(around.map(part).sum::<f64>() / sum).round() as u8])
        })
    }

    fn bounds(&self) -> ImageBounds {
        ImageBounds { focal_px: self.focal_px, slant: 1.2, dark_noise_grey: 1.0, electrons_per_grey: 20.0 }
    }

    /// The camera as the localizer is given it.
    fn model(&self) -> ForwardCameraModel {
        ForwardCameraModel {
            focal_px: Interval::point(self.focal_px),
            principal_point_px: CENTRE_PX.map(Interval::point),
            distortion: [0.0; 5],
            distortion_px: 0.0,
            tilt_up_rad: 0.0,
            yaw_rad: Interval::ZERO,
            tilt_error_rad: 0.0,
            stamp_error_s: 0.0,
            position_m: [Interval::ZERO; 2],
            height_m: Interval::point(self.place_m[2]),
            height_px: SIZE_PX[1],
            row_time_s: 0.0,
        }
    }

    /// What searches landmarks in the pictures of the camera.
    pub(in super::super) fn finder(&self) -> Finder {
        let camera = self.model();
        let pinhole = PointCameraModel {
            focal_px: camera.focal_px,
            centre_px: camera.principal_point_px,
            tilt_up_rad: 0.0,
            yaw_rad: Interval::ZERO,
            tilt_rad: 0.0,
            position_m: camera.position_m,
            height_m: camera.height_m,
            error_px: 0.0,
            least_depth_m: 0.4,
            stamp_error_s: 0.0,
        };
        Finder::new(PictureLens::new(&camera), Arc::new(Optics::new(pinhole, robot().body)))
    }
}

/// Landmarks that a first camera has taken of the wall: their places on it, and what a map keeps of them.
pub(in super::super) struct Taken {
    places_m: Vec<[f64; 2]>,
    pub(in super::super) points: Vec<(LandmarkId, SpacePoint)>,
    pub(in super::super) looks: Vec<(LandmarkId, Landmark)>,
}

impl Taken {
    pub(in super::super) fn by_first_camera() -> Taken {
        let first = Eye { place_m: [0.0, 0.0, 0.3], focal_px: FOCAL_PX, ..Eye::default() };
        let taken = Frame::new(&first.picture(), &first.bounds()).landmarks(60);
        let places_m: Vec<[f64; 2]> = taken.iter().map(|look| first.on_wall(look.position_px())).collect();
        let point = |&[y_m, z_m]: &[f64; 2]| {
            let value = [y_m / WALL_M, (z_m - first.place_m[2]) / WALL_M, 1.0 / WALL_M];
            let anchor = Anchor { from_m: first.place_m, axis: 0, is_positive: true };
            SpacePoint { anchor, value: value.map(|at| Interval::centred(at, 1e-3)) }
        };
        let points = (0..).map(LandmarkId).zip(places_m.iter().map(point)).collect();
        Taken { places_m, points, looks: (0..).map(LandmarkId).zip(taken).collect() }
    }

    /// Numbers of landmarks that are wholly in view of another camera, and of those that it finds. None may be found where it is not.
    fn found_by(&self, second: Eye) -> [usize; 2] {
        let (picture, bounds) = (second.picture(), second.bounds());
        let pose = [second.place_m[0], second.place_m[1], second.heading_rad].map(|at| Interval::centred(at, 0.01));
        let mut searched = Searched::default();
        second.finder().search(
            &mut Album::of(&self.points, &self.looks, None),
            &mut Frame::new(&picture, &bounds),
            &PoseBox::from(pose),
            SIZE_PX.map(f64::from),
            &mut searched,
            true,
        );
        for claim in &searched.claims {
            let Claim::SpacePoint { landmark, at_px, half_width_px, .. } = claim else { panic!("{claim:?}") };
            let truly_px = second.projected(self.places_m[landmark.0 as usize]);
            let is_within = |axis: usize| (at_px[axis] - truly_px[axis]).abs() <= half_width_px[axis];
            assert!(is_within(0) && is_within(1), "{claim:?} {truly_px:?}");
        }
        let size = second.focal_px / FOCAL_PX * WALL_M / (WALL_M - second.place_m[0]);
        let margin_px = 3.0 + 15.0 * size.max(1.0);
        let is_in_view = |place_m: &&[f64; 2]| {
            let at_px = second.projected(**place_m);
            (0..2).all(|axis| (margin_px..f64::from(SIZE_PX[axis]) - 1.0 - margin_px).contains(&at_px[axis]))
        };
        [self.places_m.iter().filter(is_in_view).count(), searched.claims.len()]
    }
}

#[test]
fn a_look_is_found_by_a_camera_of_another_focal_length() {
    let taken = Taken::by_first_camera();
    // Focal length and distance from the wall, as multiples of those at which the looks were taken.
    for [focal, distance] in [[1.0, 1.0], [0.7, 1.0], [1.4, 1.0], [0.55, 1.0], [1.8, 1.0], [0.45, 0.45], [2.2, 2.2]] {
        let place_m = [WALL_M * (1.0 - distance), 0.05, 0.36];
        let [n_in_view, n_found] =
            taken.found_by(Eye { place_m, heading_rad: 0.03, focal_px: focal * FOCAL_PX, is_later: false });
        assert!(n_in_view >= 4 && 10 * n_found >= 8 * n_in_view, "{focal}, {distance}: {n_found} of {n_in_view}");
    }
}

#[test]
fn the_ray_to_a_landmark_is_within_the_one_that_is_told_at_a_small_part_of_the_cost() {
    let mut draw = Draw::new(20_261_215);
    let finder = Eye { place_m: [0.0, 0.0, 0.3], focal_px: FOCAL_PX, ..Eye::default() }.finder();
    for _ in 0..200 {
        let mut around =
            |middle: f64, half_m: f64| Interval::centred(draw.between(-middle, middle), draw.between(0.0, half_m));
        let pose = PoseBox::from([around(2.0, 0.2), around(2.0, 0.2), around(3.0, 0.1)]);
        let value = [around(1.0, 0.05), around(1.0, 0.05), around(0.1, 0.1) + Interval::point(0.3)];
        let point = SpacePoint { anchor: Anchor { from_m: [0.5, -0.2, 0.3], axis: 1, is_positive: true }, value };
        let (narrow, wide) = (finder.optics.ray(&pose, &point), finder.optics.wide_ray(&pose, &point));
        assert!((0..3).all(|k| !narrow[k].is_empty() && narrow[k].is_subset_of(wide[k])), "{narrow:?} {wide:?}");
    }
}

/// What is told of landmarks after so many pictures, from a way of some length along x and y, of the wall as it was or as it is later: for each landmark
/// that is gone, its place along y as the map has it and where it is now.
fn gone(is_later: bool, n_pictures: u32, shift_m: [f64; 2]) -> Vec<(f64, Option<f64>)> {
    let taken = Taken::by_first_camera();
    let eye = Eye { place_m: [0.0, 0.0, 0.3], focal_px: FOCAL_PX, is_later, ..Eye::default() };
    let known = KnownLandmarks { points: &taken.points, looks: &taken.looks, views: None };
    let mut method = PicturedLandmarks::new(eye.model(), &robot(), known, Learning::Never, Declared::default());
    for step in 0..n_pictures {
        let along = f64::from(step) / f64::from(n_pictures) - 0.5;
        let eye = Eye { place_m: [shift_m[0] * along, shift_m[1] * along, 0.3], heading_rad: -0.2 * along, ..eye };
        let pose = [eye.place_m[0], eye.place_m[1], eye.heading_rad].map(|at| Interval::centred(at, 0.02));
        let pose = PoseUnion::single(PoseBox::from(pose));
        let stamp_s = 0.2 * f64::from(step);
        let image = Arc::new(eye.picture());
        let reading = Reading::Camera {
            measured_s: stamp_s,
            arrived_s: stamp_s,
            camera: Camera::Forward,
            exposure_s: 0.0,
            image,
        };
        let constraint = method.constrain(&reading, &Context::at_rest(&pose));
        if let Some(shown) = constraint.and_then(|constraint| constraint.shown) {
            method.learn(&shown, Some(&pose));
        }
    }
    let place = |landmark: LandmarkId| taken.places_m[landmark.0 as usize][0];
    let seen = method.seen_again();
    assert!(seen.len() > 20, "{}", seen.len());
    let gone = seen.iter().filter(|one| one.is_gone());
    gone.map(|one| (place(one.landmark), one.now_m.map(|[_, y_m, _]| y_m))).collect()
}

#[test]
fn landmarks_of_exchanged_pictures_are_found_where_the_other_picture_was() {
    let told = gone(true, 32, [0.0, 1.6]);
    for side_m in EXCHANGED_M {
        // Landmarks whose whole patch is on the picture.
        let of_it = told.iter().filter(|(at_m, _)| (at_m - side_m).abs() < 0.25);
        let moved: Vec<(f64, f64)> = of_it.filter_map(|&(at_m, now_m)| Some((at_m, now_m?))).collect();
        let is_right = |(at_m, now_m): &(f64, f64)| (now_m - (at_m - 2.0 * side_m)).abs() < 0.06;
        assert!(moved.len() >= 2 && moved.iter().all(is_right), "{side_m}: {told:?}");
    }
    // Nothing is told of a wall that is as it was, nor are places told by pictures from one place.
    assert_eq!(gone(false, 10, [0.0, 1.6]), []);
    assert!(gone(true, 12, [0.0, 0.0]).iter().all(|(_, now_m)| now_m.is_none()));
}
