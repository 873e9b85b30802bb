use super::super::{
    CeilingView,
    synthetic::{Ceiling, Eye, Pasted},
    trial::{Tally, declared_view, frames, random_ceiling, random_clutter, random_eye, seed},
};
use super::*;
use crate::{
    markers::{Coding, MarkerId},
    vision::synthetic::Random,
};

/// Lenses by coefficients k1, k2, p1, p2 and focal length in pixels: barrel and pincushion behind the paper's camera, a decentred one, and a wide
/// angle of 67 degrees over the width of 640 pixels.
const BARREL: ([f64; 4], f64) = ([-0.2, 0.0, 0.0, 0.0], 755.0);
const PINCUSHION: ([f64; 4], f64) = ([0.2, 0.05, 0.0, 0.0], 755.0);
const DECENTRED: ([f64; 4], f64) = ([-0.1, 0.02, 0.004, -0.006], 755.0);
const WIDE: ([f64; 4], f64) = ([-0.28, 0.07, 0.001, 0.0], 483.0);

fn behind(view: CeilingView, eye: &Eye) -> CeilingView {
    let [k1, k2, p1, p2] = eye.distortion;
    let lens = Lens { distortion: [k1, k2, p1, p2, 0.0], focal_px: eye.focal_px, centre_px: eye.centre_px };
    CeilingView { focal_px: eye.focal_px[0], ..view }.behind(lens)
}

/// One to five markers anywhere in the view of a camera, to its corners.
fn markers_anywhere(eye: &Eye, words: &[MarkerId], random: &mut Random) -> Vec<Pasted> {
    let half = [320.0, 240.0].map(|px| 1.15 * px / eye.focal_px[0]);
    let mut markers: Vec<Pasted> = Vec::new();
    for _ in 0..5 {
        let (x, y) = (random.between(-half[0], half[0]), random.between(-half[1], half[1]));
        let ray = eye.world_from_camera * nalgebra::Vector3::new(x, y, 1.0);
        let place = eye.place_m + ray * ((3.0 - eye.place_m.z) / ray.z);
        let id = words[(random.unit() * words.len() as f64) as usize];
        let centre_m = [place.x, place.y];
        let is_free = |other: &Pasted| {
            (other.centre_m[0] - centre_m[0]).hypot(other.centre_m[1] - centre_m[1]) > 0.3 && other.id != id
        };
        if markers.iter().all(is_free) {
            markers.push(Pasted::new(id, centre_m, random.between(-4.0, 4.0), 3.0));
        }
    }
    markers
}

/// Reads pictures of markers among lamps and windows behind a lens. `told` is what the method is told of the lens.
fn read_behind(
    (distortion, focal_px): ([f64; 4], f64),
    seed: u64,
    told: impl Fn(CeilingView, &Eye) -> CeilingView,
) -> Tally {
    let (mut random, mut tally) = (Random::new(seed), Tally::default());
    let (table, words) = (Coding::Hexads.table(), Coding::Hexads.identities());
    for _ in 0..frames(40) {
        // Dots have radii of at least 2.4 px in a pinhole's picture, which leaves more than 1.5 px wherever these lenses shrink them.
        let distance_m = random.between(1.4, 2.0) * focal_px / 755.0;
        let mut eye = random_eye(distance_m, 0.005, &mut random);
        eye.focal_px = [focal_px; 2];
        eye.distortion = distortion;
        let mut ceiling = random_ceiling(&eye, Coding::Hexads, &mut random);
        ceiling = Ceiling { markers: markers_anywhere(&eye, &words, &mut random), ..ceiling };
        ceiling.clutter = random_clutter(&ceiling, &eye, &mut random);
        let size_px = declared_view(distance_m, 0.005, &ceiling).dot_radius_px.map(|px| px * focal_px / 755.0);
        let view = CeilingView { dot_radius_px: size_px, ..declared_view(distance_m, 0.005, &ceiling) };
        tally.add(&ceiling, &eye, &told(view, &eye), &table, &mut random);
    }
    tally
}

#[test]
fn markers_behind_bent_lenses_are_read_up_to_the_corners_and_their_dots_lie_within_their_bounds() {
    for (name, lens, number) in
        [("barrel", BARREL, 301), ("pincushion", PINCUSHION, 302), ("decentred", DECENTRED, 303), ("wide", WIDE, 304)]
    {
        let tally = read_behind(lens, seed(number), behind);
        tally.print(name);
        assert_eq!((tally.misread, tally.false_dots), (0, 0), "{name}");
        assert!(
            tally.in_view > 60 && tally.read as f64 >= 0.99 * tally.in_view as f64,
            "{name}: {} of {}",
            tally.read,
            tally.in_view
        );
    }
    // Taken for a pinhole's, most of the pictures behind the wide angle are not read.
    let untold = read_behind(WIDE, seed(304), |view, eye| CeilingView { focal_px: eye.focal_px[0], ..view });
    assert!(untold.misread == 0 && untold.read < untold.in_view / 2, "{} of {}", untold.read, untold.in_view);
}

#[test]
fn the_centroid_of_a_disc_is_shifted_as_a_sum_over_its_area_says() {
    let lens = Lens { distortion: [-0.28, 0.07, 0.002, -0.003, 0.0], focal_px: [483.0; 2], centre_px: [320.0, 240.0] };
    for (centre_px, radius_px) in [([560.0, 400.0], 6.0), ([330.0, 250.0], 4.0), ([80.0, 240.0], 10.0)] {
        // Squares of a two hundredth of a radius in the picture as taken, of which those count that a pinhole shows within the disc.
        let middle_px = lens.bent_px(centre_px);
        let (side_px, mut sum, mut n_squares) = (radius_px / 200.0, [0.0; 2], 0.0);
        for index in 0..601 * 601 {
            let off = [index % 601, index / 601].map(|at| (f64::from(at) - 300.0) * side_px);
            let at_px = [middle_px[0] + off[0], middle_px[1] + off[1]];
            let pinhole_px = lens.about(at_px).map_or([f64::NAN; 2], |bend| bend.pinhole_px);
            if (pinhole_px[0] - centre_px[0]).hypot(pinhole_px[1] - centre_px[1]) < radius_px {
                (0..2).for_each(|axis| sum[axis] += off[axis]);
                n_squares += 1.0;
            }
        }
        let by_sum_px = (sum[0] / n_squares).hypot(sum[1] / n_squares);
        let shift_px = lens.centroid_shift_px(centre_px, radius_px);
        assert!(
            (shift_px - by_sum_px).abs() < 0.02 * by_sum_px + 0.001,
            "{shift_px} and {by_sum_px} px at {centre_px:?}"
        );
    }
}

#[test]
fn large_sharp_discs_without_noise_lie_within_bounds_that_are_narrower_than_what_the_lens_shifts_them() {
    let lens = Lens { distortion: [-0.28, 0.07, 0.001, 0.0, 0.0], focal_px: [483.0; 2], centre_px: [320.0, 240.0] };
    let (mut random, mut n_found) = (Random::new(305), 0);
    for _ in 0..40 {
        let radius_px = random.between(8.0, 12.0);
        let centre_px = [random.between(540.0, 580.0), random.between(380.0, 420.0)];
        // Eight by eight samples a pixel.
        let share = |u: u32, v: u32| {
            let samples = (0..64).filter(|sample| {
                let at_px = [f64::from(u) + f64::from(sample % 8) / 8.0, f64::from(v) + f64::from(sample / 8) / 8.0];
                let seen = lens.about(at_px.map(|at| at - 7.0 / 16.0)).map_or([f64::NAN; 2], |bend| bend.pinhole_px);
                (seen[0] - centre_px[0]).hypot(seen[1] - centre_px[1]) < radius_px
            });
            samples.count() as f64 / 64.0
        };
        let middle_px = lens.bent_px(centre_px);
        let is_near = |u: u32, v: u32| (f64::from(u) - middle_px[0]).hypot(f64::from(v) - middle_px[1]) < 20.0;
        let grey = |u, v| image::Luma([if is_near(u, v) { (40.0 + 160.0 * share(u, v)) as u8 } else { 40 }]);
        let picture = image::GrayImage::from_fn(640, 480, grey);
        // The localizer knows the radius exactly, looks straight up, and light has next to no shot noise.
        let (focal_px, electrons_per_grey) = (1e9, 1e9);
        let pinhole =
            CeilingView { dot_radius_px: [radius_px; 2], focal_px, lean: 0.0, electrons_per_grey, lens: None };
        for dot in super::super::dots::detect(&picture, &pinhole.behind(lens), &Default::default()) {
            let off_px = (dot.centre_px[0] - middle_px[0]).hypot(dot.centre_px[1] - middle_px[1]);
            let shift_px = lens.centroid_shift_px(centre_px, radius_px);
            assert!(off_px <= dot.bound_px, "{off_px} px for {} px at radius {radius_px} px", dot.bound_px);
            assert!(dot.bound_px < 2.0 * shift_px, "{} px where the lens shifts by {shift_px} px", dot.bound_px);
            n_found += 1;
        }
    }
    assert_eq!(n_found, 40);
}
