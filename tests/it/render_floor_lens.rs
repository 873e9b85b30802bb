//! The floor camera's lens and shutter in rendered pictures, compared with formulas written out here.

use image::GrayImage;
use localizer::Claim;
use nalgebra::{Isometry3, Translation3};
use sim::{devices::camera::world_from_camera, judge::is_true, render::View, truth::Truth};

use crate::{
    render_projection::{dark_centroid, marks},
    render_studio::{Studio, standing},
};

/// Brown and Conrady's k1, k2, p1, p2, k3 of a cheap wide-angle lens, which shifts the picture's corners inwards by 30 px.
const BENT: [f64; 5] = [-0.16, 0.03, 0.001, -0.0006, 0.0];

/// OpenCV's distortion model: the pixel at which a lens shows what a pinhole camera of the same focal length shows at `pinhole_px`.
fn distorted(pinhole_px: [f64; 2], focal_px: f64, [k1, k2, p1, p2, k3]: [f64; 5]) -> [f64; 2] {
    let (x, y) = ((pinhole_px[0] - 319.5) / focal_px, (pinhole_px[1] - 239.5) / focal_px);
    let r = x.hypot(y);
    let factor = 1.0 + k1 * r.powi(2) + k2 * r.powi(4) + k3 * r.powi(6);
    let xd = x * factor + 2.0 * p1 * x * y + p2 * (r.powi(2) + 2.0 * x.powi(2));
    let yd = y * factor + p1 * (r.powi(2) + 2.0 * y.powi(2)) + 2.0 * p2 * x * y;
    [319.5 + focal_px * xd, 239.5 + focal_px * yd]
}

/// Places of the floor marks under the camera of a robot that stands in the middle of a room of 4 m.
fn marked_places() -> Vec<[f64; 2]> {
    let offsets = [[0.0, 0.0], [0.12, 0.13], [-0.13, 0.17], [0.11, -0.16], [-0.12, -0.13], [0.02, 0.19]];
    offsets.iter().map(|[forward, left]| [2.0 - 0.15 + forward, 2.0 + left]).collect()
}

/// Centroid of a mark of 13 mm on the image, by the image of its points; each point is weighted by the image area of its surroundings.
fn mark_centroid([x, y]: [f64; 2], image_of: &dyn Fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
    const STEP_M: f64 = 0.013 / 8.0;
    let mut sums = [0.0; 3];
    for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
        let [dx, dy] = [i, j].map(|index| (f64::from(index) - 3.5) * STEP_M);
        let corner = |sx: f64, sy: f64| image_of([x + dx + sx * STEP_M / 2.0, y + dy + sy * STEP_M / 2.0]);
        let diagonals = [(corner(-1.0, -1.0), corner(1.0, 1.0)), (corner(-1.0, 1.0), corner(1.0, -1.0))];
        let [a, b] = diagonals.map(|(from, to)| [to[0] - from[0], to[1] - from[1]]);
        let area = (a[0] * b[1] - a[1] * b[0]).abs() / 2.0;
        let [u, v] = image_of([x + dx, y + dy]);
        sums = [sums[0] + area, sums[1] + area * u, sums[2] + area * v];
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

fn level(image: &GrayImage, u: u32, v: u32) -> f64 {
    f64::from(image.get_pixel(u, v).0[0])
}

#[test]
fn a_bent_lens_shows_floor_points_where_brown_and_conrady_put_them() {
    let places = marked_places();
    let studio = Studio::new(4.0, &marks(&places));
    let truth = standing(2.0, 2.0, 0.0);
    let mut view = studio.quiet_view(&[truth]);
    view.lens.distortion = BENT;
    let image = studio.draw(view);
    for place in places {
        let pinhole = studio.project(&truth, place);
        let image_of = |place| distorted(studio.project(&truth, place), studio.mount.focal_px, BENT);
        let expected = mark_centroid(place, &image_of);
        let seen = dark_centroid(&image, expected);
        let error_px = f64::hypot(seen[0] - expected[0], seen[1] - expected[1]);
        assert!(error_px < 0.05, "{place:?}: {seen:?}, expected {expected:?}, without the lens {pinhole:?}");
    }
}

#[test]
fn what_a_bent_lens_bends_is_what_the_scene_declares() {
    let studio = Studio::new(
        4.0,
        "[robot.floor_camera]\nscale_tolerance = 0.0\nlens.distortion = [-0.16, 0.03, 0.001, -0.0006, 0.0]\n\
         lens.vignetting = true\nlens.defocus_px = 3.0\nlens.row_time_s = 20e-6\n",
    );
    let lens = sim::optics::Lens::of(
        studio.scene.robot.floor_camera.as_ref().unwrap(),
        &studio.drawn.devices.floor_camera.unwrap(),
    );
    assert_eq!((lens.distortion, lens.vignetting), (BENT, true));
    assert_eq!((lens.defocus_px, lens.row_time_s), (3.0, 20e-6));
}

#[test]
fn the_floor_falls_off_by_the_fourth_power_of_the_cosine() {
    // A single tile without a pattern fills the view.
    let tile = "[floor.tiles]\nedge_x_m = 5.0\nedge_y_m = 5.0\nphase_x_m = 0.0\nphase_y_m = 0.0\npattern = \"plain\"\n";
    let studio = Studio::new(5.0, tile);
    let mut view = studio.quiet_view(&[standing(2.5, 2.5, 0.0)]);
    view.lens.vignetting = true;
    let image = studio.draw(view);
    let mean = |u0: u32, v0: u32| {
        let block = (v0 - 4..v0 + 4).flat_map(|v| (u0 - 4..u0 + 4).map(move |u| (u, v)));
        block.map(|(u, v)| level(&image, u, v)).sum::<f64>() / 64.0
    };
    let middle = mean(320, 240);
    for (u, v) in [(600, 240), (320, 440), (40, 40), (560, 420)] {
        // The pixels that `mean` averages lie around a corner between pixels, half a pixel up and left of the centre of pixel (u, v).
        let tangent = f64::hypot(f64::from(u) - 0.5 - 319.5, f64::from(v) - 0.5 - 239.5) / studio.mount.focal_px;
        let expected = tangent.atan().cos().powi(4);
        let seen = mean(u, v) / middle;
        assert!((seen / expected - 1.0).abs() < 0.01, "({u}, {v}): {seen}, expected {expected}");
    }
}

#[test]
fn a_shadow_on_the_floor_bends_with_the_lens_and_leans_with_the_shutter() {
    // A bulb hangs 2 m high, and a board 1 m high stands across the room in front of it. Seen from the bulb, the board's shadow on the floor ends,
    // and light begins again, 2.42 m from the point below the bulb.
    let lit = "[building]\nwall_albedo = 0.0\nceiling_albedo = 0.0\n[light]\n[[lamp]]\nkind = \"point\"\nx_m = 1.2\ny_m = 2.0\nheight_m = 2.0\nlumens = 2000\n\
               [[furniture]]\nname = \"board\"\nx_m = 2.4\ny_m = 2.0\nsize_m = [0.02, 3.0]\nheight_m = 1.0\n";
    let studio = Studio::new(4.0, lit);
    // The robot stands so that its floor camera, 0.15 m behind the axle, is over x = 3.47. Image up is world x, and the shadow ends 0.15 m further
    // on.
    let still = || studio.quiet_view(&[standing(3.62, 2.0, 0.0)]);
    let column = |mut view: View| {
        view.illuminance_at_floor_lux = 60.0 / view.exposure_s;
        view.gain_levels_per_electron *= 4.0;
        let image = studio.draw(view);
        (0..480).map(|v| (300..340).map(|u| level(&image, u, v)).sum::<f64>() / 40.0).collect::<Vec<f64>>()
    };
    let mut bent = still();
    bent.lens.distortion = BENT;
    let mut rolling = still();
    (rolling.exposure_s, rolling.lens.row_time_s) = (SHORT.exposure_s, SHORT.row_time_s);
    let speed_m_per_s = 0.8;
    let ahead_m = [-0.5, 0.5].map(|share| share * (SHORT.exposure_s + 479.0 * SHORT.row_time_s) * speed_m_per_s);
    let pose = still().world_from_camera[0];
    rolling.world_from_camera = ahead_m.map(|ahead_m| Translation3::new(ahead_m, 0.0, 0.0) * pose).to_vec();

    let straight = column(still());
    let (least, most) = straight.iter().fold((f64::MAX, 0.0_f64), |(low, high), at| (low.min(*at), high.max(*at)));
    let half = (least + most) / 2.0;
    let crossing = |levels: &[f64]| {
        let v = (1..480).rev().find(|v| levels[v - 1] > half && levels[*v] <= half).unwrap();
        v as f64 - (half - levels[v]) / (levels[v - 1] - levels[v])
    };
    let (plain_px, bent_px, rolling_px) = (crossing(&straight), crossing(&column(bent)), crossing(&column(rolling)));
    let expected_px = distorted([319.5, plain_px], studio.mount.focal_px, BENT)[1];
    assert!((plain_px - expected_px).abs() > 2.0, "the edge at {plain_px} is too near to the axis");
    assert!((bent_px - expected_px).abs() < 0.7, "{bent_px}, expected {expected_px}, without the lens {plain_px}");
    // Expected row v of the shadow's edge under a rolling shutter, if it is `plain` without one: v = plain + speed·(v − 239.5)·row time·scale, with
    // 1333 px to the metre.
    let per_row = speed_m_per_s * SHORT.row_time_s * 640.0 / 0.48;
    let expected_px = (plain_px - 239.5 * per_row) / (1.0 - per_row);
    assert!((plain_px - expected_px).abs() > 4.0, "{expected_px}");
    assert!((rolling_px - expected_px).abs() < 0.7, "{rolling_px}, expected {expected_px}, at rest {plain_px}");
}

#[test]
fn defocus_spreads_a_tape_by_a_discs_variance() {
    // A tape of 20 mm lies across the picture, seen from straight above; its image is 26.7 px wide.
    let tape = "[[floor.stray]]\nfrom_m = [1.0, 2.0]\nto_m = [3.0, 2.0]\nwidth_m = 0.02\nalbedo = 0.0\n";
    let studio = Studio::new(4.0, tape);
    let variance = |defocus_px: f64| {
        let mut view = studio.quiet_view(&[standing(2.0, 2.0, 0.0)]);
        view.lens.defocus_px = defocus_px;
        let image = studio.draw(view);
        // The mean over rows removes noise; the tape runs down the middle of the picture.
        let column = |u: u32| (100..380).map(|v| level(&image, u, v)).sum::<f64>() / 280.0;
        let open = column(250);
        let dark: Vec<(f64, f64)> = (280..360).map(|u| (f64::from(u) - 319.5, (open - column(u)) / open)).collect();
        let sum: f64 = dark.iter().map(|(_, dark)| dark).sum();
        dark.iter().map(|(at, dark)| dark * at * at).sum::<f64>() / sum
    };
    let sharp = variance(0.0);
    assert!((sharp - (26.667_f64.powi(2) + 1.0) / 12.0).abs() < 0.3, "{sharp}");
    for diameter_px in [6.0, 12.0] {
        // Expected variance of the tape's blur: a blur disc of radius r adds r²/4 along an axis; interpolation between pixels adds up to a quarter of
        // a square pixel.
        let (added, expected) = (variance(diameter_px) - sharp, (diameter_px / 2.0_f64).powi(2) / 4.0);
        assert!((-0.1..0.3).contains(&(added - expected)), "{diameter_px} px: {added}, expected {expected}");
    }
}

/// Motion of a robot that drives and turns while a rolling shutter reads out.
struct Drive {
    speed_m_per_s: f64,
    turn_rad_per_s: f64,
}

impl Drive {
    /// State of the robot on its circle; at time 0 it is in the middle of the room.
    fn at(&self, time_s: f64) -> Truth {
        let turned = self.turn_rad_per_s * time_s;
        let radius_m = self.speed_m_per_s / self.turn_rad_per_s;
        standing(2.0 + radius_m * turned.sin(), 2.0 + radius_m * (1.0 - turned.cos()), turned)
    }

    /// Five poses of the camera from `-total_s/2` to `total_s/2`, in the form that a rendered view takes.
    fn poses(&self, studio: &Studio, total_s: f64) -> Vec<Isometry3<f64>> {
        let at = |step: i32| self.at(total_s * (f64::from(step) / 4.0 - 0.5));
        (0..=4).map(|step| world_from_camera(&at(step), &studio.mount.camera())).collect()
    }
}

const DRIVE: Drive = Drive { speed_m_per_s: 0.6, turn_rad_per_s: 1.5 };

/// A rolling shutter: the time from the start of one row's exposure to the start of the next row's, and the duration of each exposure.
#[derive(Clone, Copy, Debug)]
struct Shutter {
    row_time_s: f64,
    exposure_s: f64,
}

const SHORT: Shutter = Shutter { row_time_s: 40e-6, exposure_s: 0.0004 };

/// View that is read out row by row while the robot drives.
fn rolling(studio: &Studio, distortion: [f64; 5], shutter: Shutter) -> View {
    let mut view = studio.quiet_view(&[standing(2.0, 2.0, 0.0)]);
    let longer = view.exposure_s / shutter.exposure_s;
    view.exposure_s = shutter.exposure_s;
    // The rows are exposed for a shorter time; more light makes up for that, so that noise stays low.
    view.illuminance_at_floor_lux *= longer;
    view.lens.row_time_s = shutter.row_time_s;
    view.lens.distortion = distortion;
    view.world_from_camera = DRIVE.poses(studio, shutter.exposure_s + 479.0 * shutter.row_time_s);
    view
}

#[test]
fn a_rolling_shutter_skews_the_floor_by_each_rows_time() {
    let places = marked_places();
    let studio = Studio::new(4.0, &marks(&places));
    let mut most_px: f64 = 0.0;
    for distortion in [[0.0; 5], BENT] {
        let image = studio.draw(rolling(&studio, distortion, SHORT));
        let image_at =
            |place, time_s| distorted(studio.project(&DRIVE.at(time_s), place), studio.mount.focal_px, distortion);
        for place in &places {
            // The time of exposure decides on which row a mark appears, and the row decides the time: this loop finds the row at which both
            // agree.
            let on_its_row = |place: [f64; 2]| {
                let first = image_at(place, 0.0);
                (0..20).fold(first, |seen, _| image_at(place, (seen[1] - 239.5) * SHORT.row_time_s))
            };
            let expected = mark_centroid(*place, &on_its_row);
            let seen = dark_centroid(&image, expected);
            let error_px = f64::hypot(seen[0] - expected[0], seen[1] - expected[1]);
            assert!(error_px < 0.1, "{place:?}: {seen:?}, expected {expected:?}");
            let unskewed = image_at(*place, 0.0);
            most_px = most_px.max(f64::hypot(seen[0] - unskewed[0], seen[1] - unskewed[1]));
        }
    }
    // The test is meaningful only if the rolling shutter shifts the marks clearly, by more than 4 px.
    assert!(most_px > 4.0, "{most_px}");
}

#[test]
fn a_floor_fills_a_rolling_picture_to_its_corners() {
    for floor in ["", "[floor.tiles]\nedge_x_m = 0.3\nedge_y_m = 0.3\n"] {
        let studio = Studio::new(4.0, floor);
        for row_time_s in [SHORT.row_time_s, 10.0 * SHORT.row_time_s] {
            let view = rolling(&studio, BENT, Shutter { row_time_s, ..SHORT });
            let image = studio.draw(view);
            let darkest = image.pixels().map(|pixel| pixel.0[0]).min().unwrap();
            assert!(darkest > 30, "{floor:?}, rows of {row_time_s} s: {darkest}");
        }
    }
}

#[test]
fn each_row_of_a_rolling_picture_is_that_of_a_global_shutter_at_the_rows_time() {
    // The floor in view has one of every kind of thing that a floor can show: marble, tiles of very different albedo, joints, a wire and a carpet's
    // edge.
    let floor = "[floor.tiles]\nedge_x_m = 0.2\nedge_y_m = 0.15\npattern = \"marble\"\ntile_albedo_spread = 0.3\n\
                 [[floor.stray]]\nfrom_m = [1.7, 1.8]\nto_m = [2.0, 2.1]\nwidth_m = 0.008\nalbedo = 0.05\n\
                 [[floor.region]]\nname = \"rug\"\nx_m = [1.0, 1.78]\ny_m = [1.0, 3.0]\nfriction = 0.7\ncovering = \"carpet\"\n";
    let studio = Studio::new(4.0, floor);
    // Two rolling shutters are tried: one with a short exposure of each row, and a slower one whose long exposure blurs by 5 px.
    let mut widest: f64 = 0.0;
    for shutter in [SHORT, Shutter { row_time_s: 100e-6, exposure_s: 0.006 }] {
        let whole = studio.draw(rolling(&studio, BENT, shutter));
        for v in [3_u32, 60, 150, 239, 300, 400, 476] {
            let middle_s = (f64::from(v) - 239.5) * shutter.row_time_s;
            let mut view = rolling(&studio, BENT, shutter);
            view.lens.row_time_s = 0.0;
            let at = |share: f64| DRIVE.at(middle_s + share * shutter.exposure_s);
            let shares = [-0.5, -0.25, 0.0, 0.25, 0.5];
            view.world_from_camera = shares.map(|share| world_from_camera(&at(share), &studio.mount.camera())).to_vec();
            let row = studio.draw(view);
            let difference = |u: u32| (level(&whole, u, v) - level(&row, u, v)).abs();
            let mut differences: Vec<f64> = (0..640).map(difference).collect();
            differences.sort_by(f64::total_cmp);
            // Both pictures, the rolling one and the one without rolling, carry the same noise, so that the row may be compared level by level; the
            // checks below make sure that its levels vary enough for the comparison to mean something.
            let mean = differences.iter().sum::<f64>() / 640.0;
            let off = differences[633];
            assert!(mean < 0.2 && off < 2.0, "{shutter:?}, row {v}: mean {mean}, 99 % within {off}");
            let levels: Vec<f64> = (0..640).map(|u| level(&whole, u, v)).collect();
            let (least, most) =
                levels.iter().fold((f64::MAX, 0.0_f64), |(least, most), at| (least.min(*at), most.max(*at)));
            assert!(most < 255.0, "row {v}: levels from {least} to {most}");
            widest = widest.max(most - least);
        }
    }
    assert!(widest > 40.0, "{widest}");
}

#[test]
fn a_claimed_joint_is_judged_through_the_lens_and_at_the_time_of_each_points_row() {
    // The joints lie at their nominal places: every 0.3 m, with one joint of each family through (1.8, 2.1).
    let keys = format!(
        "[floor.tiles]\nlaying_tolerance_m = 0.0\n[robot.floor_camera]\nlens.distortion = {BENT:?}\nlens.row_time_s = {}\n",
        SHORT.row_time_s
    );
    let mut studio = Studio::new(4.0, &keys);
    studio.drawn.devices.floor_camera = Some(studio.mount.camera());
    let truth = Truth { velocity: [DRIVE.speed_m_per_s, 0.0, DRIVE.turn_rad_per_s], ..DRIVE.at(0.0) };
    // Pixel at which the picture shows a place of the floor: the time of exposure decides the row, and the row decides the time.
    let shown = |place: [f64; 2]| {
        let at = |time_s: f64| distorted(studio.project(&DRIVE.at(time_s), place), studio.mount.focal_px, BENT);
        (0..20).fold(at(0.0), |seen, _| at((seen[1] - 239.5) * SHORT.row_time_s))
    };
    let along_x: Vec<[f64; 2]> = (0..9).map(|step| [1.72 + 0.03 * f64::from(step), 2.1]).collect();
    let along_y: Vec<[f64; 2]> = (0..9).map(|step| [1.8, 1.85 + 0.03 * f64::from(step)]).collect();
    for places in [along_x, along_y] {
        let claimed = |off_px: f64, bound_px: f64| {
            let ends = [shown(places[0]), shown(places[8])];
            let (du, dv) = (ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
            let across = [-dv / du.hypot(dv) * off_px, du / du.hypot(dv) * off_px];
            let point = |place: &[f64; 2]| {
                let [u, v] = shown(*place);
                [u + across[0], v + across[1], bound_px]
            };
            let points_px = places.iter().map(point).collect();
            is_true(&Claim::FloorJoint { points_px, share_wrong: 0.0 }, &studio.scene, &studio.drawn, &truth)
        };
        // A claim that a joint runs through points 0.05 px beside its true image is true with a bound of 0.1 px on the points, but not with one of
        // 0.03 px; if the points are 2 px off, it is true with a bound of 2.1 px, but not with one of 1.9 px.
        assert!(claimed(0.05, 0.1) && !claimed(0.05, 0.03), "{places:?}");
        assert!(claimed(2.0, 2.1) && !claimed(2.0, 1.9), "{places:?}");
    }
}
