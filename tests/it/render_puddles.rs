//! Wet patches of the floor in rendered pictures: which thing a mirrored ray meets first, lamps and what hides them, and how water changes the
//! floor below it.

use std::f64::consts::PI;

use image::GrayImage;
use nalgebra::{Isometry3, Translation3};
use sim::{optics::Lens, render::View, scene::Scene, world::Drawn};

use crate::{
    light_of_lamps::black_room,
    render_room::{level, looking_ahead, looking_down, quiet_view},
    render_studio::renderer,
};

/// Text of a scene file that lays a puddle on black tiles, so that all light that comes from the floor is mirrored by the water.
const BLACK_PUDDLE: &str = "[floor.tiles]\npattern = \"plain\"\nedge_x_m = 5.0\nedge_y_m = 5.0\njoint_width_m = 0.001\n\
     tile_albedo = 0.0\ntile_albedo_spread = 0.0\njoint_albedo = 0.0\n[[floor.region]]\nname = \"puddle\"\n\
     x_m = [0.6, 3.0]\ny_m = [0.3, 2.7]\nfriction = 0.4\ncovering = \"wet\"\n";

/// Width and height of the picture, and focal length, of a camera that looks along world x from (0.5, 1.5).
const LENS_PX: [u32; 2] = [321, 601];
const FOCAL_PX: f64 = 300.0;

fn look_ahead(scene: &Scene, height_m: f64, levels: f64) -> GrayImage {
    let pose = Isometry3::from_parts(Translation3::new(0.5, 1.5, height_m), looking_ahead().rotation);
    draw(scene, quiet_view(Lens::ideal(LENS_PX, FOCAL_PX), vec![pose], levels))
}

fn draw(scene: &Scene, view: View) -> GrayImage {
    let mut renderer = renderer();
    let world = renderer.upload_room(scene, &Drawn::draw(scene, 0)).unwrap();
    let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
    renderer.draw(&world, &[View { illuminance_at_floor_lux, ..view }]).unwrap().remove(0)
}

/// Share of light that tiles mirror at this cosine of incidence, 0.03 at perpendicular incidence (Schlick 1994).
fn mirrored(cosine: f64) -> f64 {
    0.03 + 0.97 * (1.0 - cosine).powi(5)
}

fn furniture(name: &str, front_m: f64, height_m: f64, albedo: f64) -> String {
    let x_m = front_m + 0.05;
    format!(
        "[[furniture]]\nname = \"{name}\"\nx_m = {x_m:?}\ny_m = 1.5\nsize_m = [0.1, 1.0]\nheight_m = {height_m:?}\nalbedo = {albedo:?}\n"
    )
}

#[test]
fn a_puddle_mirrors_the_nearest_of_the_things_that_stand_behind_one_another() {
    // A bulb of 100 cd hangs 2 m high at x = 1.5; it lights a low dark box at x = 2.6 and a high bright one at x = 3.6.
    let bulb = "[[lamp]]\nkind = \"point\"\nx_m = 1.5\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\nspectrum = \"monochrome\"\n";
    let (near, far) = (furniture("near", 2.6, 0.2, 0.2), furniture("far", 3.6, 1.0, 0.8));
    let (eye_m, levels) = (0.5, 300.0);
    let row_of = |floor_x_m: f64| 300.0 + FOCAL_PX * eye_m / (floor_x_m - 0.5);
    // Slope of a ray that the water mirrors at `floor_x_m`: it rises from the water as steeply as it fell on it from the eye.
    let slope = |floor_x_m: f64| eye_m / (floor_x_m - 0.5);
    let expected = |floor_x_m: f64, front_m: f64, albedo: f64| {
        let height_m = slope(floor_x_m) * (front_m - floor_x_m);
        let ahead_m = front_m - 1.5;
        let lux = 100.0 * ahead_m / (ahead_m.powi(2) + (2.0 - height_m).powi(2)).powf(1.5);
        let cosine = slope(floor_x_m) / slope(floor_x_m).hypot(1.0);
        levels * mirrored(cosine) * albedo * lux / PI
    };
    // The order in which the boxes are built must not matter.
    for boxes in [format!("{near}{far}"), format!("{far}{near}")] {
        let image = look_ahead(&black_room(&format!("{BLACK_PUDDLE}{bulb}{boxes}")), eye_m, levels);
        let seen = |floor_x_m: f64| {
            let row = row_of(floor_x_m).round() as u32;
            (158..=162).map(|u| level(&image, u, row)).sum::<f64>() / 5.0
        };
        for (floor_x_m, front_m, albedo) in [(2.3, 2.6, 0.2), (2.15, 2.6, 0.2), (1.8, 3.6, 0.8), (1.7, 3.6, 0.8)] {
            let (seen, expected) = (seen(floor_x_m), expected(floor_x_m, front_m, albedo));
            assert!((seen / expected - 1.0).abs() < 0.05, "at {floor_x_m} m {seen}, expected {expected}");
        }
        // The low box, 0.2 m high, must hide the high one up to the mirrored ray that just passes its top, which is the ray mirrored at x = 2.
        let [low, high] = [2.08, 1.9].map(seen);
        let rows = row_of(2.08) as u32..row_of(1.9) as u32;
        let edge = rows.clone().find(|row| level(&image, 160, *row) > (low + high) / 2.0).unwrap();
        assert!((f64::from(edge) - row_of(2.0)).abs() < 1.5, "row {edge}, expected {}", row_of(2.0));
    }
}

/// Text of a scene file for a panel of 0.3 m by 0.3 m at x = 2.9, 1.2 m high: for an eye 0.6 m above the floor and 2.4 m before the panel, the
/// panel's mirror image lies 1.8 m below the eye.
const LOW_PANEL: &str = "[[lamp]]\nkind = \"panel\"\nx_m = 2.9\ny_m = 1.5\nheight_m = 1.2\nsize_m = [0.3, 0.3]\nlumens = 20\n\
                         spectrum = \"monochrome\"\n";

/// First and last row in which the picture's middle column is lighter than half of the level `full`.
fn light_rows(image: &GrayImage, full: f64) -> [f64; 2] {
    // Only rows below the image of the floor 1.8 m straight ahead are searched, because they show nothing but the puddle.
    let light: Vec<u32> = (480..600).filter(|v| level(image, 160, *v) > full / 2.0).collect();
    [light[0], light[light.len() - 1]].map(f64::from)
}

#[test]
fn a_lamp_shows_in_a_puddle_where_and_as_large_as_its_image_below_the_water() {
    let image = look_ahead(&black_room(&format!("{BLACK_PUDDLE}{LOW_PANEL}")), 0.6, 50.0);
    // Expected level of the lamp's reflection in the puddle: the panel's luminance is Φ/(π·A), and the water mirrors the share that belongs to a ray
    // that falls by 1.8 m over 2.4 m.
    let full = 50.0 * mirrored(0.6) * 20.0 / (PI * 0.09);
    let middle = level(&image, 160, 525);
    assert!((middle / full - 1.0).abs() < 0.03, "{middle}, expected {full}");
    let [top, bottom] = light_rows(&image, full);
    let [expected_top, expected_bottom] = [3.05, 2.75].map(|x_m| 300.0 + FOCAL_PX * 1.8 / (x_m - 0.5));
    assert!(
        (top - 0.5 - expected_top).abs() < 1.0 && (bottom + 0.5 - expected_bottom).abs() < 1.0,
        "{top} to {bottom}"
    );
    let across = (0..321).filter(|u| level(&image, *u, 525) > full / 2.0).count() as f64;
    assert!((across - 2.0 * FOCAL_PX * 0.15 / 2.4).abs() < 2.0, "{across} px wide");
}

#[test]
fn a_lamp_in_a_puddle_ends_where_a_thing_before_it_begins() {
    // The box begins at x = 2.3 and is 0.75 m high. The ray past its top comes from the place a of the lamp at which 0.75/(2.3 − f) = 1.2/(a −
    // f), with the place f = 0.5 + (a − 0.5)/3 where the water mirrors it.
    let board = furniture("board", 2.3, 0.75, 0.0);
    let scene = black_room(&format!("{BLACK_PUDDLE}{LOW_PANEL}{board}"));
    let image = look_ahead(&scene, 0.6, 50.0);
    let lifted = |a_m: f64| {
        let f_m = 0.5 + (a_m - 0.5) / 3.0;
        1.2 * (2.3 - f_m) / (a_m - f_m)
    };
    let (mut near_m, mut far_m) = (2.75, 3.05);
    for _ in 0..50 {
        let middle_m = (near_m + far_m) / 2.0;
        if lifted(middle_m) > 0.75 { near_m = middle_m } else { far_m = middle_m }
    }
    let full = 50.0 * mirrored(0.6) * 20.0 / (PI * 0.09);
    let [top, bottom] = light_rows(&image, full);
    let [expected_top, expected_bottom] = [near_m, 2.75].map(|x_m| 300.0 + FOCAL_PX * 1.8 / (x_m - 0.5));
    assert!(
        (top - 0.5 - expected_top).abs() < 1.5 && (bottom + 0.5 - expected_bottom).abs() < 1.0,
        "{top} to {bottom}, expected {expected_top} to {expected_bottom}"
    );
}

/// Picture of the floor from 1 m above (2, 1.5), where water mirrors nothing but the black ceiling: the bulb is mirrored at x = 1.67, outside of
/// the picture.
fn floor_below(floor: &str) -> GrayImage {
    let bulb = "[[lamp]]\nkind = \"point\"\nx_m = 1.0\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\nspectrum = \"monochrome\"\n";
    let scene = black_room(&format!("{floor}{bulb}"));
    draw(&scene, quiet_view(Lens::ideal([128, 128], 400.0), vec![looking_down(2.0, 1.5, 1.0)], 70.0))
}

const PUDDLE: &str =
    "[[floor.region]]\nname = \"puddle\"\nx_m = [0.8, 3.2]\ny_m = [0.3, 2.7]\nfriction = 0.4\ncovering = \"wet\"\n";

#[test]
fn a_wet_floor_is_as_much_darker_as_light_is_kept_in_by_the_water() {
    // Ångström (1925): water of refractive index n lets the share 1 − r of light in and (1 − r)/n² of the floor's radiance out, and throws back
    // on the floor the share 1 − (1 − 0.066)/n² of the light that comes from below at all angles.
    let (n, r, albedo) = (1.33_f64, 0.02_f64, 0.4);
    let expected = ((1.0 - r) / n).powi(2) / (1.0 - albedo * (1.0 - (1.0 - 0.066) / n.powi(2)));
    let [dry, wet] = ["", PUDDLE].map(floor_below);
    let mean = |image: &GrayImage| image.pixels().map(|pixel| f64::from(pixel.0[0])).sum::<f64>() / 128.0 / 128.0;
    let share = mean(&wet) / mean(&dry);
    assert!((share / expected - 1.0).abs() < 0.08, "{share}, expected {expected}");
}

#[test]
fn what_lies_below_water_is_what_lies_beside_it() {
    let tiles = "[floor.tiles]\npattern = \"speckle\"\nedge_x_m = 0.1\nedge_y_m = 0.1\n";
    let floors =
        ["screed", "concrete", "wood", "carpet"].map(|covering| format!("[floor]\ncovering = \"{covering}\"\n"));
    for floor in floors.iter().map(String::as_str).chain([tiles]) {
        let (dry, wet) = (floor_below(floor), floor_below(&format!("{floor}{PUDDLE}")));
        let pairs = dry.pixels().zip(wet.pixels()).map(|(dry, wet)| [dry, wet].map(|pixel| f64::from(pixel.0[0])));
        let shares: Vec<f64> = pairs.filter(|[dry, _]| *dry > 20.0).map(|[dry, wet]| wet / dry).collect();
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        let deviation = (shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / shares.len() as f64).sqrt();
        assert!(shares.len() > 8000, "{floor}: {}", shares.len());
        assert!(deviation < 0.03 * mean, "{floor}: {mean} ± {deviation}");
    }
}
