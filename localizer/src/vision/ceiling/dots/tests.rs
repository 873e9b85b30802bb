use image::{GrayImage, Luma};

use crate::vision::synthetic::Random;

use super::{super::CeilingView, super::PictureMotion, detect};

/// Number of points along either side of a pixel at which a disc is sampled.
const SAMPLES: usize = 40;

/// A sharp disc of an even grey level on an even background, without noise: each pixel has the mean over its square, rounded.
fn disc(centre_px: [f64; 2], radius_px: f64, background: f64, level: f64) -> GrayImage {
    let covered = |u: u32, v: u32| {
        // Only pixels at the edge are covered in part.
        let beyond_px = (f64::from(u) - centre_px[0]).hypot(f64::from(v) - centre_px[1]) - radius_px;
        if beyond_px.abs() > 1.0 {
            return if beyond_px < 0.0 { 1.0 } else { 0.0 };
        }
        let at = |pixel: u32, sample: usize| f64::from(pixel) - 0.5 + (sample as f64 + 0.5) / SAMPLES as f64;
        let is_in = |i: usize, j: usize| (at(u, i) - centre_px[0]).hypot(at(v, j) - centre_px[1]) <= radius_px;
        let within = (0..SAMPLES * SAMPLES).filter(|sample| is_in(sample % SAMPLES, sample / SAMPLES)).count();
        within as f64 / (SAMPLES * SAMPLES) as f64
    };
    GrayImage::from_fn(32, 32, |u, v| Luma([(background + level * covered(u, v)).round() as u8]))
}

#[test]
fn sharp_small_dots_without_noise_lie_within_their_bounds_and_use_most_of_them() {
    let mut random = Random::new(77);
    let still = PictureMotion { shift_px: [0.0; 2], turn_rad: 0.0, about_px: [16.0; 2] };
    let (mut n_found, mut most) = (0, 0.0_f64);
    for _ in 0..1500 {
        let radius_px = random.between(1.2, 2.0);
        let centre_px = [random.between(15.0, 17.0), random.between(15.0, 17.0)];
        let picture = disc(centre_px, radius_px, random.between(20.0, 60.0), random.between(60.0, 180.0));
        // The localizer knows the radius exactly, looks straight up, and light has next to no shot noise.
        let view = CeilingView {
            dot_radius_px: [radius_px; 2],
            focal_px: 1e9,
            lean: 0.0,
            electrons_per_grey: 1e9,
            lens: None,
        };
        for dot in detect(&picture, &view, &still) {
            let off_px = (dot.centre_px[0] - centre_px[0]).hypot(dot.centre_px[1] - centre_px[1]);
            assert!(off_px <= dot.bound_px, "{off_px} px for {} px at radius {radius_px} px", dot.bound_px);
            n_found += 1;
            most = most.max(off_px / dot.bound_px);
        }
    }
    assert!(n_found > 1400 && most > 0.6, "{n_found} found, {most} of the bound");
}
