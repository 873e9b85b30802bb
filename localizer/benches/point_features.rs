//! Benchmark of the front end of paper 4 on one core: an image of 640 × 480 pixels is prepared, and landmarks of another image are searched in
//! it. `make bench` prints the times.

use std::hint::black_box;
use std::time::Instant;

use image::{GrayImage, Luma};
use interval::Interval;
use localizer::vision::point_features::{Frame, ImageBounds, Landmark, Search};

const SIZE_PX: [u32; 2] = [640, 480];
const BOUNDS: ImageBounds = ImageBounds { focal_px: 500.0, slant: 1.0, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };

/// Pseudo-random number in [0, 1) that belongs to a cell of a lattice (the finaliser of splitmix64).
fn hashed(column: i64, row: i64, seed: u64) -> f64 {
    let mut z = (column as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (row as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    z ^= seed.wrapping_mul(0x1656_67B1_9E37_79F9);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Grey level of a poster of rectangles in three sizes and turns.
fn grey(x: f64, y: f64) -> f64 {
    let rectangle = |pitch: f64, turn_rad: f64, seed: u64| {
        let (sin, cos) = turn_rad.sin_cos();
        let (x, y) = ((x * cos + y * sin) / pitch, (y * cos - x * sin) / pitch);
        let draw = |which: u64| hashed(x.floor() as i64, y.floor() as i64, seed + which);
        let is_in = |at: f64, low: f64, high: f64| at > 0.4 * low && at < 1.0 - 0.4 * high;
        let is_inside = is_in(x - x.floor(), draw(1), draw(2)) && is_in(y - y.floor(), draw(3), draw(4));
        (is_inside && draw(5) < 0.6).then(|| 20.0 + 200.0 * draw(6))
    };
    let shade =
        rectangle(13.0, -0.6, 100).or_else(|| rectangle(29.0, 0.35, 200)).or_else(|| rectangle(53.0, 0.05, 300));
    shade.unwrap_or(120.0)
}

/// Where the second camera sees what the first one sees at a position: turned by 0.08 rad, enlarged by 1.1 and shifted.
fn second([u, v]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = 0.08f64.sin_cos();
    let (u, v) = (u - 320.0, v - 240.0);
    [1.1 * (u * cos - v * sin) + 326.0, 1.1 * (u * sin + v * cos) + 237.0]
}

fn first([u, v]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = 0.08f64.sin_cos();
    let (u, v) = ((u - 326.0) / 1.1, (v - 237.0) / 1.1);
    [u * cos + v * sin + 320.0, v * cos - u * sin + 240.0]
}

/// An image whose pixels are means of 4 × 4 points, with noise that is nearly normal.
fn picture(place: impl Fn([f64; 2]) -> [f64; 2], seed: u64) -> GrayImage {
    GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |u, v| {
        let parts = || (0..4).map(|part| (f64::from(part) - 1.5) / 4.0);
        let points = parts().flat_map(|dv| parts().map(move |du| [f64::from(u) + du, f64::from(v) + dv]));
        let mean = points.map(&place).map(|[x, y]| grey(x, y)).sum::<f64>() / 16.0;
        let draw = |which: u64| hashed(i64::from(u), i64::from(v), seed + which) - 0.5;
        let noise = (draw(1) + draw(2) + draw(3)) * 2.0 * (1.0 + mean / 20.0).sqrt();
        Luma([(mean + noise).round().clamp(0.0, 255.0) as u8])
    })
}

/// Milliseconds that something takes: the least of many rounds, because other work on the machine only ever adds time.
fn milliseconds<T>(mut of: impl FnMut() -> T) -> f64 {
    let mut round = || {
        let start = Instant::now();
        black_box(of());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..60).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn search(landmark: &Landmark) -> Search {
    let [u, v] = second(landmark.position_px());
    let region = [Interval::centred(u + 4.0, 12.0), Interval::centred(v - 3.0, 12.0)];
    Search::in_box(region, Interval::new(1.0, 1.2), Interval::new(0.0, 0.15))
}

fn main() {
    let pictures = [picture(|at| at, 1), picture(first, 2)];
    let landmarks: Vec<Landmark> = {
        let all = Frame::new(&pictures[0], &BOUNDS).landmarks(400);
        let is_in_view = |landmark: &&Landmark| {
            let [u, v] = second(landmark.position_px());
            (30.0..610.0).contains(&u) && (30.0..450.0).contains(&v)
        };
        all.iter().filter(is_in_view).take(100).cloned().collect()
    };
    let mut n_found = 0;
    let prepared = milliseconds(|| Frame::new(black_box(&pictures[1]), &BOUNDS).keypoints().len());
    let searched = milliseconds(|| {
        let mut frame = Frame::new(black_box(&pictures[1]), &BOUNDS);
        n_found = landmarks.iter().filter(|landmark| frame.find(landmark, &search(landmark)).is_ok()).count();
    });
    let taught = milliseconds(|| Frame::new(black_box(&pictures[0]), &BOUNDS).landmarks(100).len());
    println!("{:<44} {prepared:6.2} ms", "an image prepared, with its keypoints");
    let what = format!("{n_found} of {} landmarks found, image included", landmarks.len());
    println!("{what:<44} {searched:6.2} ms (goal: at most 12 ms)");
    println!("{:<44} {taught:6.2} ms", "100 landmarks created, image included");
}
