//! Image points and test images worked out by hand.

use super::*;

const SIZE_PX: [u32; 2] = [641, 481];

fn lens(distortion: [f64; 5]) -> Straightening {
    Straightening::new(SIZE_PX, 400.0, distortion, RowMotion::default()).unwrap_or_else(|| panic!("a lens that bends"))
}

fn close(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9
}

#[test]
fn a_barrel_shows_a_place_nearer_to_the_middle() {
    // By hand, at (x, y) = (0.5, −0.4), r² = 0.41: the lens coefficient k1 = −0.2 leaves 1 − 0.082 = 0.918 of the distance from the middle.
    assert!(close(
        lens([-0.2, 0.0, 0.0, 0.0, 0.0]).raw_px([520.0, 80.0]),
        [320.0 + 200.0 * 0.918, 240.0 - 160.0 * 0.918]
    ));
    // The lens coefficients k2 = 0.1 and k3 = 0.1 add a share of 0.1·(0.1681 + 0.068921) = 0.0237021 to the distance from the middle.
    assert!(close(
        lens([0.0, 0.1, 0.0, 0.0, 0.1]).raw_px([520.0, 80.0]),
        [320.0 + 200.0 * 1.0237021, 240.0 - 160.0 * 1.0237021]
    ));
    // The lens coefficient p1 = 0.01 moves u by 400·0.02·0.5·(−0.4) = −1.6 and v by 400·0.01·(0.41 + 2·0.16) = 2.92; p2
    // = 0.01 moves u by 400·0.01·(0.41 + 0.5) = 3.64.
    assert!(close(lens([0.0, 0.0, 0.01, 0.0, 0.0]).raw_px([520.0, 80.0]), [518.4, 82.92]));
    assert!(close(lens([0.0, 0.0, 0.0, 0.01, 0.0]).raw_px([520.0, 80.0]), [523.64, 78.4]));
}

#[test]
fn a_straightened_picture_shows_what_the_raw_one_shows_at_its_source() {
    // In a raw image whose grey level rises along one axis, the grey level of a pixel of the straightened image shows which raw pixel it was taken
    // from.
    for (axis, per_px) in [(0, 0.3), (1, 0.5)] {
        let ramp = GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |u, v| {
            image::Luma([(5.0 + per_px * f64::from([u, v][axis])).round() as u8])
        });
        let lens = lens([-0.25, 0.06, 0.001, -0.001, 0.0]);
        let straight = lens.straight(&ramp);
        assert_eq!(straight.dimensions(), (641, 481), "a barrel fills the whole picture");
        for (u, v, grey) in straight.enumerate_pixels() {
            let expected = 5.0 + per_px * lens.raw_px([f64::from(u), f64::from(v)])[axis];
            assert!((f64::from(grey[0]) - expected).abs() < 1.01, "{u} {v} {grey:?} {expected}");
        }
    }
}

#[test]
fn a_pincushion_leaves_out_what_the_raw_picture_does_not_show() {
    let lens = lens([0.12, 0.0, 0.0, 0.0, 0.0]);
    let straight = lens.straight(&GrayImage::from_pixel(641, 481, image::Luma([100])));
    let inset = lens.inset_px;
    assert_eq!([straight.width(), straight.height()], [641 - 2 * inset[0], 481 - 2 * inset[1]]);
    // By hand: with k1 = 0.12, image points (0.8, 0.6)·s on the diagonal are cut off where s·(1 + 0.12·s²) = 1, at s =
    // 0.9041; the last pixel before that is kept.
    let kept = [0, 1].map(|axis| 1.0 - f64::from(inset[axis]) / [320.5, 240.5][axis]);
    assert!(kept.iter().all(|kept| (kept - 0.9041).abs() < 0.01), "{kept:?}");
    assert!(lens.pixels().all(|pixel| lens.is_shown(&lens.node(pixel), 0.0)));
    let point = FloorLines {
        lines: vec![crate::vision::FloorLine { points_px: vec![[1.0, 2.0, 0.3]], share_wrong: 0.0, family: 0 }],
        rejected_px: vec![[0.0, 0.0, 5.0, 6.0]],
    };
    let [left, above] = inset.map(f64::from);
    let moved = lens.in_pinhole(point);
    assert_eq!(moved.lines[0].points_px, [[1.0 + left, 2.0 + above, 0.3]]);
    assert_eq!(moved.rejected_px, [[left, above, 5.0 + left, 6.0 + above]]);
}

#[test]
fn a_lens_that_folds_back_is_cut_before_it_does() {
    // For k1 = −0.6, the lens's slope along the radius is D' = 1 − 1.8·r². It is 0.2 at r = 2/3 or 267 px: a third of the distance to the corner is
    // cut off.
    let lens = lens([-0.6, 0.0, 0.0, 0.0, 0.0]);
    assert!(lens.pixels().all(|[u, v]| (u - 320.0).hypot(v - 240.0) <= 267.0));
    assert!(lens.pixels().count() > 400 * 300);
    // Given an image of another size than it was prepared for, the straightening returns an empty image. An image of a single pixel can be prepared
    // for; without distortion and motion there is nothing to straighten.
    assert_eq!(lens.straight(&GrayImage::new(640, 480)).dimensions(), (0, 0));
    assert!(Straightening::new([1, 1], 400.0, [0.1; 5], RowMotion::default()).is_some());
    assert!(Straightening::new(SIZE_PX, 400.0, [0.0; 5], RowMotion::default()).is_none());
}

#[test]
fn a_place_is_where_the_motion_has_brought_it_by_the_time_of_its_row() {
    // By hand, without a lens: 100 rows below the middle and 50 px to its right, a turn of the robot of 0.1 mrad per row moves the image down by
    // 0.005 px and left by 0.01 px per row. A shift of (0.02, 0.01) per row is added. Because the point also moves to a later row, v is 100/(1 −
    // 0.015) below the middle.
    let rows = RowMotion { shift_px: [0.02, 0.01], turn_rad: 1e-4 };
    let moving = Straightening::new(SIZE_PX, 400.0, [0.0; 5], rows).unwrap_or_else(|| panic!("a picture that moves"));
    let row = 100.0 / (1.0 - 0.015);
    let at = moving.at_row([370.0, 340.0]);
    assert!((at[1] - 240.0 - row).abs() < 1e-3 && (at[0] - 370.0 - 0.01 * row).abs() < 1e-3, "{at:?}");
    // An image with too much motion from row to row is not corrected for it, and one without motion needs no correction.
    for rows in [RowMotion { shift_px: [0.0, 0.2], turn_rad: 0.0 }, RowMotion::default()] {
        assert!(Straightening::new(SIZE_PX, 400.0, [0.0; 5], rows).is_none());
    }
}

/// What the pixels of a picture of a rolling shutter are taken from.
fn sources(moving: &Straightening) -> Vec<Source> {
    let Sources::Between(grid) = &moving.sources else { panic!("a picture that moves") };
    let ([columns, rows], mut sources) = (moving.kept_px(), Vec::new());
    for v in rows {
        let mut seen = vec![[0; 2]; columns.len()];
        grid.places(v, columns.start, &mut seen);
        for (u, parts) in columns.clone().zip(&seen) {
            let raw_px = grid.node([u, v]).raw_px;
            let off = [0, 1].map(|axis| (parts[axis] as f64 / 2.0_f64.powi(32) - raw_px[axis]).abs());
            assert!(off[0].max(off[1]) < 1e-6, "column {u} of row {v}: {off:?}");
        }
        sources.extend(seen.into_iter().map(|parts| moving.source(parts.map(rounded_parts))));
    }
    sources
}

#[test]
fn a_moving_picture_is_taken_from_where_each_pixel_is_worked_out_to_be() {
    let lenses = [[0.0; 5], [-0.2, 0.0, 0.0, 0.0, 0.0], [0.12, 0.0, 0.001, -0.001, 0.0], [-0.6, 0.0, 0.0, 0.0, 0.0]];
    let motions = [([0.02, 0.01], 3e-5), ([-0.01, 0.05], -2e-5), ([0.0, -0.03], 1.5e-4), ([0.001, 0.0], 0.0)];
    for (distortion, (shift_px, turn_rad)) in lenses.into_iter().flat_map(|lens| motions.map(|motion| (lens, motion))) {
        let rows = RowMotion { shift_px, turn_rad };
        let moving =
            Straightening::new(SIZE_PX, 400.0, distortion, rows).unwrap_or_else(|| panic!("a picture that moves"));
        assert_eq!(moving.rows, rows, "so little motion is corrected");
        let (mut farthest_px, mut n_outside) = (0.0_f64, 0);
        let sources = sources(&moving);
        for (pixel, source) in moving.pixels().zip(&sources) {
            let exact = moving.node(pixel);
            let corner = [source.corner % SIZE_PX[0], source.corner / SIZE_PX[0]];
            let told = [0, 1].map(|axis| f64::from(corner[axis]) + f64::from(source.towards[axis]) / 256.0);
            let off_px = (0..2).map(|axis| (told[axis] - exact.raw_px[axis]).abs()).fold(0.0, f64::max);
            farthest_px = farthest_px.max(off_px);
            n_outside += usize::from(!moving.is_shown(&exact, 0.0));
        }
        // Half a 256th of rounding, and twice the error that is allowed at the middles of some cells.
        assert!(farthest_px < 2.5 / 256.0, "{distortion:?} {rows:?}: {farthest_px} px");
        assert_eq!(sources.len(), moving.pixels().count());
        assert!(n_outside < 20, "{distortion:?} {rows:?}: {n_outside} pixels that the raw picture does not show");
        // What is cut off is what a pixel by pixel search cuts off, but for a pixel at the edge.
        let whole = Straightening { inset_px: [0, 0], ..moving.clone() };
        let exact = moving.inset(whole.pixels().filter(|&pixel| !moving.is_shown(&moving.node(pixel), 0.0)));
        assert!((0..2).all(|axis| moving.inset_px[axis].abs_diff(exact[axis]) <= 1), "{:?} {exact:?}", moving.inset_px);
    }
}

#[test]
fn slopes_tell_how_far_apart_two_lines_are_whose_images_are_a_pixel_apart() {
    let lens = lens([-0.25, 0.06, 0.001, -0.002, 0.01]);
    for (at, angle_rad) in
        [([100.0, 50.0], 0.3_f64), ([600.0, 300.0], 1.2), ([320.0, 240.0], 2.0), ([30.0, 470.0], -0.7)]
    {
        let normal: [f64; 2] = [angle_rad.cos(), angle_rad.sin()];
        // Raw images, through the lens, of a straight line through the point `at` and of a line a hundredth of a pixel beside it. The distance
        // between the raw images is the least one between points on both.
        let image = |across: f64, along: f64| {
            lens.raw_px([
                at[0] + across * normal[0] - along * normal[1],
                at[1] + across * normal[1] + along * normal[0],
            ])
        };
        let nearest = (-4000..4000).map(|step| {
            let [here, there] = [image(0.0, 0.0), image(0.01, f64::from(step) * 1e-5)];
            (there[0] - here[0]).hypot(there[1] - here[1])
        });
        let apart_px = nearest.fold(f64::MAX, f64::min);
        // How much the inverse lens distortion stretches a distance along the line's normal n: |J⁻¹n|, by hand for the symmetric matrix J of the
        // lens's slopes.
        let [a, mixed, b] = lens.slopes_over(at.map(Interval::point)).expect("the lens maps it").map(Interval::mid);
        let [x, y] = [b * normal[0] - mixed * normal[1], a * normal[1] - mixed * normal[0]];
        let stretch = x.hypot(y) / (a * b - mixed * mixed);
        assert!((0.01 / apart_px / stretch - 1.0).abs() < 1e-3, "{at:?}: {} {stretch}", 0.01 / apart_px);
    }
}
