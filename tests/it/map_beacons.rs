use std::fs;

use image::{Rgb, RgbImage};

use crate::command::{folder, outcome, wherein};

/// A room with ceiling markers and landmarks, through which a robot drives to a goal by its wheels and its range camera.
const BEACONS: &str = "duration_s = 6.0\n[room]\nwidth_m = 6.0\ndepth_m = 4.0\n[robot]\nfloor_camera = false\nrange_camera = true\n\
    [localizer]\nmethods = [\"range_landmarks\"]\n[start]\nx_m = 1.0\ny_m = 2.0\n[[errand]]\nx_m = 2.0\ny_m = 2.0\n\
    [[landmark]]\nx_m = 4.0\ny_m = 2.6\n[[landmark]]\nx_m = 4.4\ny_m = 1.5\n[markers]\n\
    [[markers.marker]]\nid = 125\nx_m = 1.5\ny_m = 3.0\n[[markers.marker]]\nid = 183\nx_m = 5.0\ny_m = 3.0\npasted = false\n\
    [[markers.marker]]\nid = 207\nx_m = 5.0\ny_m = 1.0\non_map = false\n";

// Colours of ceiling markers on the localizer's map, of a landmark's true place, and of free floor.
const MARKER: Rgb<u8> = Rgb([108, 72, 168]);
const LANDMARK: Rgb<u8> = Rgb([0, 128, 92]);
const FLOOR: Rgb<u8> = Rgb([255, 255, 255]);

#[test]
fn figures_and_maps_show_markers_and_landmarks() {
    let folder = folder("beacons");
    fs::write(folder.join("scene.toml"), BEACONS).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--frames", "every=5"]));
    assert_eq!(code, 0, "{stderr}");
    let run = folder.join("renders/scene/0");
    let map = image::open(run.join("errands.png")).unwrap().into_rgb8();
    // The map is 1200 px wide with a margin of 14 px to either side of the room of 6 m. Its panel begins 44 px below the top and is as high as the
    // room, drawn 1200 px wide, and 40 px more; the room's middle is 17 px above the panel's.
    let pixels_per_m = (1200.0 - 28.0) / 6.0;
    let at =
        |x_m: f64, y_m: f64| [600.0 + (x_m - 3.0) * pixels_per_m, 44.0 + 420.0 - 17.0 - (y_m - 2.0) * pixels_per_m];
    // 8 px beside the middle, clear of the stroke that shows the marker's direction; its film reaches 16 px to either side.
    let inside = |x_m: f64, y_m: f64| pixel(&map, at(x_m, y_m), [-8.0, -8.0]);
    let tinted = inside(1.5, 3.0);
    assert!(tinted.0[2] > tinted.0[1] + 20 && tinted.0[0] > tinted.0[1], "pasted: {tinted:?}");
    assert_eq!(inside(5.0, 3.0), FLOOR, "fallen off");
    assert!(near(&map, at(5.0, 3.0), MARKER), "its outline");
    let grey = inside(5.0, 1.0);
    assert!(grey != FLOOR && grey.0[2].abs_diff(grey.0[0]) < 8, "on no map: {grey:?}");
    for [x_m, y_m] in [[4.0, 2.6], [4.4, 1.5]] {
        assert_eq!(pixel(&map, at(x_m, y_m), [0.0; 2]), LANDMARK);
        let learnt = pixel(&map, at(x_m, y_m), [5.0, 0.0]);
        assert!(learnt.0[2] > learnt.0[0] + 20, "the box in which it was learnt: {learnt:?}");
    }
    let figure = image::open(run.join("figure_00005.png")).unwrap().into_rgb8();
    let count = |colour: Rgb<u8>| figure.pixels().filter(|pixel| **pixel == colour).count();
    assert!(count(MARKER) > 20 && count(LANDMARK) > 20, "{} and {}", count(MARKER), count(LANDMARK));
}

fn pixel(image: &RgbImage, at: [f64; 2], beside: [f64; 2]) -> Rgb<u8> {
    *image.get_pixel((at[0] + beside[0]).round() as u32, (at[1] + beside[1]).round() as u32)
}

/// Whether a pixel within 20 px to either side has this colour.
fn near(image: &RgbImage, at: [f64; 2], colour: Rgb<u8>) -> bool {
    let offsets = (-20..=20).flat_map(|u| (-20..=20).map(move |v| [f64::from(u), f64::from(v)]));
    offsets.into_iter().any(|beside| pixel(image, at, beside) == colour)
}
