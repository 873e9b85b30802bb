//! Benchmark of the front end of paper 4, and of the method that uses it, on one core: a camera of 640 × 480 pixels sees a poster from one place,
//! landmarks are made of its picture, and they are searched in the picture from another place. `make bench` prints the times.

use std::{hint::black_box, sync::Arc, time::Instant};

use image::{GrayImage, Luma};
use interval::Interval;
use localizer::{
    PoseBox, PoseUnion, Reading, RobotModel,
    map::{Anchor, SpacePoint},
    method::{Constraint, Context, Method},
    methods::mapped_landmarks::{
        Learning,
        pictures::{Declared, KnownLandmarks, PicturedLandmarks},
    },
    reading::{Camera, LandmarkId},
    robot::{ErrorLaw, ForwardCameraModel, Reach, WheelModel},
    vision::point_features::{Frame, ImageBounds, Landmark, Search},
};

const SIZE_PX: [u32; 2] = [640, 480];
const CENTRE_PX: [f64; 2] = [319.5, 239.5];
const FOCAL_PX: f64 = 417.0;
const BOUNDS: ImageBounds =
    ImageBounds { focal_px: FOCAL_PX, slant: 1.2, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };
/// World x of the wall with the poster, and the height of the camera.
const WALL_M: f64 = 2.0;
const HEIGHT_M: f64 = 0.25;
/// Number of landmarks that are known, which is also the greatest number that the method searches in a picture.
const N_KNOWN: usize = 60;

/// Pseudo-random number in [0, 1) that belongs to a cell of a lattice (the finaliser of splitmix64).
fn hashed(column: i64, row: i64, seed: u64) -> f64 {
    let mut z = (column as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (row as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    z ^= seed.wrapping_mul(0x1656_67B1_9E37_79F9);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Grey level of the poster at a place along y and z: rectangles in three sizes and turns.
fn grey([y_m, z_m]: [f64; 2]) -> f64 {
    let rectangle = |pitch_m: f64, turn_rad: f64, seed: u64| {
        let (sin, cos) = turn_rad.sin_cos();
        let (x, y) = ((y_m * cos + z_m * sin) / pitch_m, (z_m * cos - y_m * sin) / pitch_m);
        let draw = |which: u64| hashed(x.floor() as i64, y.floor() as i64, seed + which);
        let is_in = |at: f64, low: f64, high: f64| at > 0.4 * low && at < 1.0 - 0.4 * high;
        let is_inside = is_in(x - x.floor(), draw(1), draw(2)) && is_in(y - y.floor(), draw(3), draw(4));
        (is_inside && draw(5) < 0.6).then(|| 20.0 + 200.0 * draw(6))
    };
    let shade =
        rectangle(0.063, -0.6, 100).or_else(|| rectangle(0.14, 0.35, 200)).or_else(|| rectangle(0.25, 0.05, 300));
    shade.unwrap_or(120.0)
}

/// A level pinhole camera: world x and y, and heading.
#[derive(Clone, Copy)]
struct Eye([f64; 3]);

/// Where the landmarks are made, and two places from which they are searched one after the other.
const EYES: [Eye; 3] = [Eye([0.0, 0.0, 0.0]), Eye([0.08, 0.05, 0.03]), Eye([0.10, 0.06, 0.04])];

impl Eye {
    /// Place on the wall, along y and z, that is seen at a pixel.
    fn on_wall(self, at_px: [f64; 2]) -> [f64; 2] {
        let Eye([x_m, y_m, heading_rad]) = self;
        let [right, down] = [0, 1].map(|axis| (at_px[axis] - CENTRE_PX[axis]) / FOCAL_PX);
        let (sin, cos) = heading_rad.sin_cos();
        let ahead = (WALL_M - x_m) / (cos + right * sin);
        [y_m + ahead * (sin - right * cos), HEIGHT_M - ahead * down]
    }

    /// Pixel at which a place on the wall is seen.
    fn projected(self, [y_m, z_m]: [f64; 2]) -> [f64; 2] {
        let Eye([own_x_m, own_y_m, heading_rad]) = self;
        let (sin, cos) = heading_rad.sin_cos();
        let [x, y, z] = [WALL_M - own_x_m, y_m - own_y_m, z_m - HEIGHT_M];
        let ahead = cos * x + sin * y;
        [CENTRE_PX[0] + FOCAL_PX * (sin * x - cos * y) / ahead, CENTRE_PX[1] - FOCAL_PX * z / ahead]
    }

    /// A picture whose pixels are means of 4 × 4 points, with noise that is nearly normal.
    fn picture(self, seed: u64) -> GrayImage {
        GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |u, v| {
            let parts = || (0..4).map(|part| (f64::from(part) - 1.5) / 4.0);
            let points = parts().flat_map(|dv| parts().map(move |du| [f64::from(u) + du, f64::from(v) + dv]));
            let mean = points.map(|at_px| grey(self.on_wall(at_px))).sum::<f64>() / 16.0;
            let draw = |which: u64| hashed(i64::from(u), i64::from(v), seed + which) - 0.5;
            let noise = (draw(1) + draw(2) + draw(3)) * 2.0 * (1.0 + mean / 20.0).sqrt();
            Luma([(mean + noise).round().clamp(0.0, 255.0) as u8])
        })
    }

    /// A box of the pose as wide as those of the furnished room of `scenes/landmarks` are between two pictures.
    fn boxed(self) -> PoseBox {
        let [x_m, y_m, heading_rad] = self.0;
        let halves = [(x_m, 0.07), (y_m, 0.07), (heading_rad, 0.02)];
        PoseBox::from(halves.map(|(at, half)| Interval::centred(at + 0.3 * half, half)))
    }
}

/// Landmarks that the first camera has made of its picture, as a map has them.
struct Known {
    points: Vec<(LandmarkId, SpacePoint)>,
    looks: Vec<(LandmarkId, Landmark)>,
}

impl Known {
    fn of(picture: &GrayImage) -> Known {
        let is_in_view = |look: &Landmark| {
            let [u, v] = EYES[2].projected(EYES[0].on_wall(look.position_px()));
            (30.0..610.0).contains(&u) && (30.0..450.0).contains(&v)
        };
        let mut looks = Frame::new(picture, &BOUNDS).landmarks(400);
        looks.retain(is_in_view);
        looks.truncate(N_KNOWN);
        let point = |look: &Landmark| {
            let [y_m, z_m] = EYES[0].on_wall(look.position_px());
            // Slopes of the ray and inverse depth, with the widths that they have at the median of a map of the furnished room.
            let value = [(y_m / WALL_M, 0.008), ((z_m - HEIGHT_M) / WALL_M, 0.008), (1.0 / WALL_M, 0.03)];
            let anchor = Anchor { from_m: [0.0, 0.0, HEIGHT_M], axis: 0, is_positive: true };
            SpacePoint { anchor, value: value.map(|(at, half)| Interval::centred(at, half)) }
        };
        let points = (0..).map(LandmarkId).zip(looks.iter().map(point)).collect();
        Known { points, looks: (0..).map(LandmarkId).zip(looks).collect() }
    }

    /// The method for a robot whose camera is above its axle, with the bounds of a good calibration.
    fn method(&self) -> PicturedLandmarks {
        let none = ErrorLaw { floor_m: 0.0, share: 0.0, m_per_s: 0.0 };
        let reach = Reach { speed_m_per_s: 0.6, turn_rate_rad_per_s: 2.0, acceleration_m_per_s2: 2.0 };
        let robot = RobotModel::new(WheelModel::of_odometry(Interval::point(0.3), none, none), reach);
        let camera = ForwardCameraModel {
            focal_px: Interval::centred(FOCAL_PX, 0.0005 * FOCAL_PX),
            principal_point_px: CENTRE_PX.map(|at_px| Interval::centred(at_px, 0.2)),
            distortion: [0.0; 5],
            distortion_px: 0.0,
            tilt_up_rad: 0.0,
            yaw_rad: Interval::centred(0.0, 0.001),
            tilt_error_rad: 0.001,
            stamp_error_s: 1e-4,
            position_m: [Interval::centred(0.0, 0.0005); 2],
            height_m: Interval::centred(HEIGHT_M, 0.0005),
            height_px: SIZE_PX[1],
            row_time_s: 0.0,
        };
        let known = KnownLandmarks { points: &self.points, looks: &self.looks, views: None };
        PicturedLandmarks::new(camera, &robot, known, Learning::Never, Declared::default())
    }
}

/// What a method says of a picture from a place of which the box is known.
fn constrained(method: &mut PicturedLandmarks, picture: &Arc<GrayImage>, eye: Eye) -> Option<Constraint> {
    let (measured_s, arrived_s, exposure_s) = (0.0, 0.0, 0.005);
    let image = Arc::clone(picture);
    let reading = Reading::Camera { measured_s, arrived_s, camera: Camera::Forward, exposure_s, image };
    method.constrain(&reading, &Context::at_rest(&PoseUnion::single(eye.boxed())))
}

/// Milliseconds that something takes after what prepares it: the least of many rounds, because other work on the machine only ever adds time.
fn milliseconds<P, T>(prepare: impl Fn() -> P, mut of: impl FnMut(&mut P) -> T) -> f64 {
    let mut round = || {
        let mut prepared = prepare();
        let start = Instant::now();
        black_box(of(black_box(&mut prepared)));
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..60).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn main() {
    let pictures = [0, 1, 2].map(|at| Arc::new(EYES[at].picture(at as u64)));
    let known = Known::of(&pictures[0]);
    let frame = || Frame::new(&pictures[2], &BOUNDS);
    let search = |look: &Landmark| {
        let [u, v] = EYES[2].projected(EYES[0].on_wall(look.position_px()));
        let region = [Interval::centred(u + 4.0, 25.0), Interval::centred(v - 3.0, 15.0)];
        Search::in_box(region, Interval::new(0.9, 1.25), Interval::centred(0.0, 0.15))
    };
    let (mut n_found, mut n_new, mut n_used) = (0, 0, 0);
    let prepared = milliseconds(|| (), |()| Frame::new(&pictures[2], &BOUNDS).keypoints().len());
    let searched = milliseconds(frame, |frame| {
        n_found = known.looks.iter().filter(|(_, look)| frame.find(look, &search(look)).is_ok()).count();
    });
    let taught = milliseconds(frame, |frame| n_new = frame.landmarks(N_KNOWN).len());
    // The templates of a picture's landmarks are mostly made when an earlier one is searched.
    let method = || {
        let mut method = known.method();
        constrained(&mut method, &pictures[1], EYES[1]);
        method
    };
    let seen = milliseconds(method, |method| constrained(method, &pictures[2], EYES[2]).is_some());
    let constraint = || constrained(&mut method(), &pictures[2], EYES[2]);
    let contracted = milliseconds(constraint, |constraint| {
        let Some(constraint) = constraint else { return };
        n_used = constraint.claims.len();
        constraint.on_pose.contract(&mut EYES[2].boxed());
    });
    println!("{:<60} {prepared:6.2} ms", "a picture prepared, with its keypoints");
    println!("{:<60} {searched:6.2} ms", format!("{n_found} of {} landmarks found, with claims", known.looks.len()));
    println!("{:<60} {taught:6.2} ms", format!("{n_new} landmarks made of a picture"));
    println!("{:<60} {seen:6.2} ms", "all of a picture, with a first contraction for its search");
    println!("{:<60} {contracted:6.2} ms", format!("the pose contracted by {n_used} sightings"));
}
