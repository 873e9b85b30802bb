//! Rendered points of the floor, compared with a projection derived by hand.

use image::GrayImage;
use localizer::Pose;
use sim::truth::Truth;

use crate::render_studio::{Studio, standing};

/// Text of a scene file with dark squares of 13 mm on a plain floor. They are strips as the key `floor.stray` lays them, too wide to be taken for
/// wires, which would cast a shadow.
pub(crate) fn marks(places: &[[f64; 2]]) -> String {
    places
        .iter()
        .map(|[x, y]| {
            format!(
                "[[floor.stray]]\nfrom_m = [{:?}, {y:?}]\nto_m = [{:?}, {y:?}]\nwidth_m = 0.013\nalbedo = 0.0\n",
                x - 0.0065,
                x + 0.0065
            )
        })
        .collect()
}

/// Centroid of the pixels that are darker than their surroundings, within 16 px of a place.
pub(crate) fn dark_centroid(image: &GrayImage, near: [f64; 2]) -> [f64; 2] {
    let [u0, v0] = near.map(|coordinate| coordinate.round() as i32);
    let level = |u: i32, v: i32| f64::from(image.get_pixel(u as u32, v as u32).0[0]);
    let ring = (level(u0 - 16, v0) + level(u0 + 16, v0) + level(u0, v0 - 16) + level(u0, v0 + 16)) / 4.0;
    let mut sums = [0.0; 3];
    for v in v0 - 16..=v0 + 16 {
        for u in u0 - 16..=u0 + 16 {
            let dark = ring - level(u, v);
            // A pixel counts as part of the dark mark if it is darker than its surroundings by a tenth; noise and quantisation are far below that.
            if dark > 0.1 * ring {
                sums = [sums[0] + dark, sums[1] + dark * f64::from(u), sums[2] + dark * f64::from(v)];
            }
        }
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

#[test]
fn floor_points_appear_where_a_projection_derived_by_hand_puts_them() {
    // The marks lie far from the world origin, at 18 m in a large hall, where computing with world coordinates in single precision would visibly
    // shift them.
    let (x, y) = (18.3, 17.9);
    let places =
        [[0.0, 0.0], [0.12, 0.05], [-0.1, 0.08], [0.09, -0.11], [-0.12, -0.06]].map(|[dx, dy]| [x + dx, y + dy]);
    let mut studio = Studio::new(20.0, &marks(&places));
    for (heading, tilt, heave, yaw, mount_tilt) in [
        (0.0, [0.0, 0.0], 0.0, 0.0, [0.0, 0.0]),
        (0.7, [0.02, -0.03], 0.004, 0.0, [0.0, 0.0]),
        (-2.1, [0.0, 0.0], 0.0, 0.05, [0.03, 0.02]),
        (3.0, [-0.03, 0.02], -0.003, -0.04, [-0.02, 0.03]),
    ] {
        studio.mount.yaw_rad = yaw;
        studio.mount.tilt_rad = mount_tilt;
        // The robot stands so that its floor camera, 0.15 m behind the axle, is over the marks on the floor.
        let pose = Pose { x_m: x + 0.15 * f64::cos(heading), y_m: y + 0.15 * f64::sin(heading), heading_rad: heading };
        let truth = Truth { pose, tilt_rad: tilt, heave_m: heave, ..Truth::default() };
        let image = studio.draw(studio.quiet_view(&[truth]));
        for place in places {
            let expected = studio.project(&truth, place);
            let seen = dark_centroid(&image, expected);
            let error_px = f64::hypot(seen[0] - expected[0], seen[1] - expected[1]);
            assert!(error_px < 0.1, "heading {heading}, mark {place:?}: {seen:?}, expected {expected:?}");
        }
    }
}

#[test]
fn image_up_is_forward_and_image_right_is_right() {
    // The robot stands at (1, 1) and faces world y, so that +y is forward of its floor camera and +x is to the camera's right.
    let studio = Studio::new(2.0, &marks(&[[1.0, 0.95], [1.1, 0.85]]));
    let image = studio.draw(studio.quiet_view(&[standing(1.0, 1.0, std::f64::consts::FRAC_PI_2)]));
    // In this image of the floor, 0.1 m is 133.3 px long.
    let ahead = dark_centroid(&image, [319.5, 106.2]);
    let right = dark_centroid(&image, [452.8, 239.5]);
    assert!((ahead[0] - 319.5).abs() < 0.1 && (ahead[1] - (239.5 - 133.33)).abs() < 0.1, "{ahead:?}");
    assert!((right[0] - (319.5 + 133.33)).abs() < 0.1 && (right[1] - 239.5).abs() < 0.1, "{right:?}");
}

/// Centre of a dark line's profile along u at row v, weighted by darkness, within 18 px of a place.
fn profile_centre(image: &GrayImage, near_u: f64, v: u32) -> f64 {
    let u0 = near_u.round() as i32;
    let level = |u: i32| f64::from(image.get_pixel(u as u32, v).0[0]);
    let ground = (-24..-18).chain(19..25).map(|du| level(u0 + du)).sum::<f64>() / 12.0;
    let mut sums = [0.0; 2];
    for u in u0 - 18..=u0 + 18 {
        let dark = ground - level(u);
        sums = [sums[0] + dark, sums[1] + dark * f64::from(u)];
    }
    sums[1] / sums[0]
}

const PLAIN_TILES: &str = "[floor.tiles]\npattern = \"plain\"\ntile_albedo_spread = 0.0\n";

#[test]
fn the_centre_of_a_laid_joint_is_unbiased_at_any_angle() {
    // The grid of floor tiles is rotated by 17° and seen at several headings, so that joints cross the pixels at many angles.
    let studio = Studio::new(3.0, &format!("{PLAIN_TILES}rotation_deg = 17.0\n"));
    let laid = studio.drawn.place.tiles.as_ref().unwrap();
    let corner_in_world = |i: i32, j: i32| {
        let index = (i - laid.first[0]) as usize * laid.count[1] + (j - laid.first[1]) as usize;
        let offset = laid.corner_offset_m[index];
        let (x, y) = (f64::from(i) * 0.3 + offset[0], f64::from(j) * 0.3 + offset[1]);
        let (sin, cos) = 17_f64.to_radians().sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    };
    for heading in [0.0, 0.2, 0.5] {
        // The floor camera is put over the middle of the joint from tile corner (5, 3) to (5, 4), which runs within 29° of image v at these headings.
        let ends = [corner_in_world(5, 3), corner_in_world(5, 4)];
        let middle = [0, 1].map(|axis| (ends[0][axis] + ends[1][axis]) / 2.0);
        let heading = heading + 107_f64.to_radians();
        let truth = standing(middle[0] + 0.15 * heading.cos(), middle[1] + 0.15 * heading.sin(), heading);
        let image = studio.draw(studio.quiet_view(&[truth]));
        let [from, to] = ends.map(|end| studio.project(&truth, end));
        let errors: Vec<f64> = (140..340)
            .map(|v| {
                let expected = from[0] + (to[0] - from[0]) * (f64::from(v) - from[1]) / (to[1] - from[1]);
                profile_centre(&image, expected, v) - expected
            })
            .collect();
        let bias = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(bias.abs() < 0.02, "heading {heading}: {bias} px");
    }
}

#[test]
fn blur_is_as_long_as_the_way_during_the_exposure() {
    // A black tape lies across the floor camera's view; its far edge, x = 1.5, is below the camera in the middle of the exposure.
    let tape = "[[floor.stray]]\nfrom_m = [1.45, 0.5]\nto_m = [1.45, 2.5]\nwidth_m = 0.1\nalbedo = 0.0\n";
    let studio = Studio::new(3.0, tape);
    for blur_px in [3.5, 7.0, 14.0] {
        // The robot drives along world x. Image up is robot forward, and one pixel of the floor image is 0.75 mm.
        let way_m = blur_px * 0.00075;
        let truths: Vec<Truth> =
            (0..=10).map(|k| standing(1.65 + (f64::from(k) / 10.0 - 0.5) * way_m, 1.5, 0.0)).collect();
        let mut view = studio.view(&truths, 0);
        // The noise is reduced to half a grey level, so that the mean of a row of pixels resolves fractions of a level.
        view.sensor.full_well_electrons = 1e5;
        view.exposure_s *= 10.0;
        view.gain_levels_per_electron /= 10.0;
        let image = studio.draw(view);
        let row = |v: u32| (20..620).map(|u| f64::from(image.get_pixel(u, v).0[0])).sum::<f64>() / 600.0;
        // Steps from row to row are samples of motion ⊗ pixel ⊗ pixel, three boxes, whose variances b²/12 add up.
        let reach = (blur_px / 2.0) as u32 + 4;
        let steps: Vec<(f64, f64)> =
            (239 - reach..=239 + reach).map(|v| (f64::from(v) + 0.5, row(v) - row(v + 1))).collect();
        let total: f64 = steps.iter().map(|(_, step)| step).sum();
        let centre = steps.iter().map(|(v, step)| v * step).sum::<f64>() / total;
        let variance = steps.iter().map(|(v, step)| (v - centre).powi(2) * step).sum::<f64>() / total;
        let measured_px = (12.0 * variance - 2.0).sqrt();
        assert!((centre - 239.5).abs() < 0.02, "centre {centre}");
        assert!((measured_px / blur_px - 1.0).abs() < 0.02, "{measured_px} px, expected {blur_px}");
    }
}
