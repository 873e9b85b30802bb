//! Glints of lamps in rendered pictures: a long lamp in a glossy floor gives an unbroken glint that is as long as the lamp's mirror image, and a
//! bulb in a glossy box appears where a mirror would show it.

use image::GrayImage;
use nalgebra::{Isometry3, Translation3};
use sim::{
    optics::Lens,
    place::{
        building::{Building, Part},
        drawn::DrawnPlace,
    },
    render::View,
    scene::Scene,
    world::Drawn,
};

use crate::{
    light_of_lamps::black_room,
    render_room::{level, looking_ahead, quiet_view},
    render_studio::renderer,
};

const EYE_M: f64 = 1.5;
const LAMP_M: f64 = 2.0;
/// Horizontal distance from the eye to the lamp; `HALF_M` is half of the lamp's length.
const AHEAD_M: f64 = 4.0;
const HALF_M: f64 = 2.5;
const FOCAL_PX: f64 = 220.0;
const WIDTH_PX: u32 = 641;

/// A room with black tiles and a panel lamp of 5 m by 0.3 m that hangs across the view. `is_first` says whether the key `size_m` states the 5 m first
/// (the lamp is then turned by 90°) or second; both must look the same.
fn scene(is_first: bool) -> Scene {
    let (heading_deg, size_m) = if is_first { (90, [2.0 * HALF_M, 0.3]) } else { (0, [0.3, 2.0 * HALF_M]) };
    let text = format!(
        "[room]\nwidth_m = 7.0\ndepth_m = 8.0\n[building]\nwall_albedo = 0.0\nceiling_albedo = 0.0\nskirting_albedo = 0.0\n\
         [start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n\
         [floor.tiles]\npattern = \"plain\"\nedge_x_m = 5.0\nedge_y_m = 5.0\njoint_width_m = 0.001\ntile_albedo = 0.0\n\
         tile_albedo_spread = 0.0\njoint_albedo = 0.0\n\
         [[lamp]]\nkind = \"panel\"\nx_m = {:?}\ny_m = 4.0\nheight_m = {LAMP_M:?}\nheading_deg = {heading_deg}\nsize_m = {size_m:?}\nlumens = 600\n\
         spectrum = \"monochrome\"\n",
        1.0 + AHEAD_M
    );
    Scene::parse(&text, "glints.toml").unwrap()
}

/// Grey levels along the row through the glint's middle, for an eye that is `aside_m` to the left of the lamp's middle.
fn glint(world: &sim::render::RenderedWorld, renderer: &mut sim::render::Renderer, aside_m: f64) -> Vec<f64> {
    let pose = Isometry3::from_parts(Translation3::new(1.0, 4.0 + aside_m, EYE_M), looking_ahead().rotation);
    // The lamp's mirror image lies as far below the floor as the lamp is above it.
    let below_px = FOCAL_PX * (EYE_M + LAMP_M) / AHEAD_M;
    let lens = Lens { principal_point_px: [320.0, 8.0 - below_px], ..Lens::ideal([WIDTH_PX, 17], FOCAL_PX) };
    let view = View {
        illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
        ..quiet_view(lens, vec![pose], 60.0)
    };
    let image = renderer.draw(world, &[view]).unwrap().remove(0);
    (0..WIDTH_PX).map(|u| (5..12).map(|v| level(&image, u, v)).sum::<f64>() / 7.0).collect()
}

/// Share of light that tiles mirror, 0.03 at perpendicular incidence, for a place on the lamp that is `left_m` to the left of the eye (Schlick
/// 1994).
fn mirrored(left_m: f64) -> f64 {
    let cosine = (EYE_M + LAMP_M) / AHEAD_M.hypot(left_m).hypot(EYE_M + LAMP_M);
    0.03 + 0.97 * (1.0 - cosine).powi(5)
}

#[test]
fn the_glint_of_a_long_lamp_ends_where_its_image_ends_on_both_sides_and_has_no_steps() {
    for is_first in [true, false] {
        let scene = scene(is_first);
        let mut renderer = renderer();
        let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
        // The renderer cuts the floor into blocks half a metre wide. The end of a glint moves by 0.57 of the distance that the eye moves, so that the
        // eye positions of this loop put the glint's end everywhere within a block.
        for index in 0..36 {
            let aside_m = -0.4 + 0.024 * f64::from(index);
            let row = glint(&world, &mut renderer, aside_m);
            for side in [-1.0, 1.0] {
                // Image right is along −y, so that places to the left have smaller columns.
                let end_px = |half_m: f64| 320.0 - FOCAL_PX * (side * half_m - aside_m) / AHEAD_M;
                let at = |half_m: f64| row[end_px(half_m).round() as usize];
                // The glossy floor blurs what it mirrors by 0.035 rad, up to 0.12 m on the lamp. A place 1 m from the lamp's end is therefore as
                // bright as if the lamp did not end.
                let within = at(HALF_M - 1.0);
                assert!(within > 60.0, "{within}");
                let share = at(HALF_M)
                    / mirrored(side * HALF_M - aside_m)
                    / (within / mirrored(side * (HALF_M - 1.0) - aside_m));
                assert!((0.4..0.55).contains(&share), "{is_first} {aside_m} {side}: {share} at the end");
                assert!(at(HALF_M + 1.0) < 0.02 * within, "{}", at(HALF_M + 1.0));
                // The blur's kernel is √20 standard deviations wide, and lets the glint fall with a slope of at most 1.5 times its level per
                // kernel width. The test allows 1.3 times that.
                let pixel_m = AHEAD_M / FOCAL_PX;
                let from_floor_m =
                    LAMP_M / (EYE_M + LAMP_M) * AHEAD_M.hypot(side * HALF_M - aside_m).hypot(EYE_M + LAMP_M);
                let most = 1.3 * 1.5 * pixel_m / (20.0_f64.sqrt() * 0.035 * from_floor_m) * within;
                let [from, to] = [end_px(HALF_M - 1.0), end_px(HALF_M + 1.0)].map(|px| px.round() as usize);
                let step = row[from.min(to)..=from.max(to)]
                    .windows(2)
                    .map(|pair| (pair[1] - pair[0]).abs())
                    .fold(0.0, f64::max);
                assert!(step < most, "{is_first} {aside_m} {side}: a step of {step}, at most {most} of {within}");
            }
        }
    }
}

/// Picture of a black room, taken from (1, 1.3, 1.4) along world x, with a bulb behind the eye and a black box whose face is at x = 3.
fn picture_of_box(more_of_box: &str) -> GrayImage {
    let scene = black_room(&format!(
        "[[furniture]]\nx_m = 3.3\ny_m = 1.5\nsize_m = [0.6, 2.8]\nheight_m = 2.0\nalbedo = 0.0\n{more_of_box}\
         [[lamp]]\nkind = \"point\"\nx_m = 0.5\ny_m = 1.9\nheight_m = 1.1\nsize_m = [0.1, 0.1]\nlumens = 600\n\
         spectrum = \"monochrome\"\n"
    ));
    let mut renderer = renderer();
    let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let pose = Isometry3::from_parts(Translation3::new(1.0, 1.3, 1.4), looking_ahead().rotation);
    let view = View {
        illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
        ..quiet_view(Lens::ideal([321, 241], 300.0), vec![pose], 0.5)
    };
    renderer.draw(&world, &[view]).unwrap().remove(0)
}

#[test]
fn a_glossy_box_shows_a_bulb_where_a_mirror_would() {
    let matt = picture_of_box("");
    // In the image rows 60 to 159, which are searched for the bulb's reflection, only the black box is seen.
    let brightest = |image: &GrayImage| {
        (0..321).flat_map(|u| (60..160).map(move |v| (u, v))).map(|(u, v)| level(image, u, v)).fold(0.0, f64::max)
    };
    assert!(brightest(&matt) < 1.0, "{}", brightest(&matt));
    let image = picture_of_box("gloss = 0.1\nroughness_deg = 1.5\n");
    // The bulb's mirror image is as far behind x = 3 as the bulb is before it: at (5.5, 1.9, 1.1), which is 4.5 m ahead, 0.6 m to the left and
    // 0.3 m below the eye.
    let expected = [160.0 - 300.0 * 0.6 / 4.5, 120.0 + 300.0 * 0.3 / 4.5];
    let around = || (60..180).flat_map(|u| (80..200).map(move |v| (u, v)));
    let total: f64 = around().map(|(u, v)| level(&image, u, v)).sum();
    let mean = |coordinate: &dyn Fn((u32, u32)) -> f64| {
        around().map(|place| coordinate(place) * level(&image, place.0, place.1)).sum::<f64>() / total
    };
    let seen = [mean(&|place| f64::from(place.0)), mean(&|place| f64::from(place.1))];
    assert!((0..2).all(|axis| (seen[axis] - expected[axis]).abs() < 0.7), "{seen:?}, expected {expected:?}");
    assert!(brightest(&image) < 250.0, "{}", brightest(&image));
    // Sum of the whole glint by hand, however far it is blurred: the mirrored share (Schlick 1994), times the bulb's luminance I/(π·r²), times
    // the f²/z² · π·r² pixels of the bulb's disc over the cosine off the axis. The bulb's intensity I is Φ/4π.
    let cosine = 4.5 / 4.5_f64.hypot(0.6).hypot(0.3);
    let mirrored = 0.1 + 0.9 * (1.0 - cosine).powi(5);
    let by_hand = 0.5 * mirrored * 600.0 / (4.0 * std::f64::consts::PI) * (300.0 / 4.5_f64).powi(2) / cosine;
    assert!((total / by_hand - 1.0).abs() < 0.08, "{total}, expected {by_hand}");
}

#[test]
fn a_floor_glints_by_the_gloss_that_is_stated_and_as_its_covering_otherwise() {
    let share = |floor: &str| {
        let scene = black_room(floor);
        let building = Building::new(&scene, &DrawnPlace::draw(&scene, 0));
        let floor = building.panels.iter().find(|panel| panel.part == Part::Floor).unwrap();
        floor.material.mirrored
    };
    for (keys, expected) in [
        ("", 0.0),
        ("[floor]\ngloss = 0.07\n", 0.07),
        ("[floor]\ncovering = \"wood\"\n", 0.04),
        ("[floor]\ncovering = \"wood\"\ngloss = 0.0\n", 0.0),
        ("[floor.tiles]\n", 0.03),
        ("[floor]\ngloss = 0.2\n[floor.tiles]\n", 0.2),
    ] {
        assert_eq!(share(keys), expected, "{keys}");
    }
}
