//! Benchmark of the pose of a camera from three points, on one core. `make bench` prints the times.
//!
//! Two kinds of problems: triangles of random points anywhere in front of the camera, as in the paper of Persson and Nordberg, and markers, whose
//! three direction dots span 0.1 to 0.3 m at a distance of 2 to 3 m, seen exactly and with an error of a tenth of a pixel.

use std::hint::black_box;
use std::time::Instant;

use localizer::vision::p3p;
use nalgebra::{Rotation3, Vector3};

/// Rays in the camera frame, and points in the world frame.
type Problem = ([Vector3<f64>; 3], [Vector3<f64>; 3]);

const PROBLEMS: usize = 4096;
/// A tenth of a pixel of a camera with a focal length of 750 px.
const TENTH_PX: f64 = 0.1 / 750.0;

/// Marsaglia's 64-bit xorshift, uniform between two numbers.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn turn(&mut self, most_rad: f64) -> Rotation3<f64> {
        let mut part = || self.between(-most_rad, most_rad);
        Rotation3::new(Vector3::new(part(), part(), part()))
    }
}

/// Points that are anywhere in front of the camera.
fn scattered(random: &mut Random) -> Problem {
    let turn = random.turn(3.0);
    let rays = [0, 1, 2].map(|_| Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 1.0));
    (rays, rays.map(|ray| turn * (ray * random.between(0.1, 10.0))))
}

/// The direction dots X, O and Y of a marker on the ceiling above a camera that leans by up to 0.3 rad about either axis.
fn marker(random: &mut Random, error: f64) -> Problem {
    let side_m = random.between(0.1, 0.3);
    let points_m = [Vector3::new(side_m, 0.0, 0.0), Vector3::zeros(), Vector3::new(0.0, side_m, 0.0)];
    let turn = random.turn(0.3) * Rotation3::from_axis_angle(&Vector3::z_axis(), random.between(-3.1, 3.1));
    let distance_m = random.between(2.0, 3.0);
    let place_m = Vector3::new(random.between(-0.5, 0.5), random.between(-0.4, 0.4), 1.0) * distance_m;
    let rays = points_m.map(|point| {
        let seen = turn * point + place_m;
        let mut off = || random.between(-error, error);
        seen / seen.z + Vector3::new(off(), off(), 0.0)
    });
    (rays, points_m)
}

/// Prints the time that one problem takes: the least over many rounds, because other work on the machine only ever adds time.
fn time(name: &str, problems: &[Problem]) {
    let mut n_solutions = 0;
    let mut round = || {
        let start = Instant::now();
        n_solutions = 0;
        for (rays, points_m) in problems {
            n_solutions += p3p::solve(black_box(rays), black_box(points_m)).len();
        }
        start.elapsed().as_secs_f64() / problems.len() as f64
    };
    let best_s = (0..100).map(|_| round()).fold(f64::INFINITY, f64::min);
    let each = n_solutions as f64 / problems.len() as f64;
    println!("{name:32} {:6.3} µs, {each:.2} solutions (goal: at most 0.6 µs)", best_s * 1e6);
}

fn main() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut some =
        |of: &dyn Fn(&mut Random) -> Problem| -> Vec<Problem> { (0..PROBLEMS).map(|_| of(&mut random)).collect() };
    time("P3P, random points", &some(&scattered));
    time("P3P, markers", &some(&|random| marker(random, 0.0)));
    time("P3P, markers, error of 0.1 px", &some(&|random| marker(random, TENTH_PX)));
}
