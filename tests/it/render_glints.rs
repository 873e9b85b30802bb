//! Glints of long lamps in a glossy floor: as long as the lamp's image below it, and whole.

use nalgebra::{Isometry3, Translation3};
use sim::{drawn::Drawn, render::View, scene::Scene, sensors::lens::Lens};

use crate::{
    render_room::{level, looking_ahead, quiet_view},
    render_studio::renderer,
};

const EYE_M: f64 = 1.5;
const LAMP_M: f64 = 2.0;
/// From the eye to the lamp on the floor, and half of the lamp's length.
const AHEAD_M: f64 = 4.0;
const HALF_M: f64 = 2.5;
const FOCAL_PX: f64 = 220.0;
const WIDTH_PX: u32 = 641;

/// A room with black tiles, and a lamp of 5 m by 0.3 m across the view; its length is its first side or its second.
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

/// The row of the glint's middle, as the eye sees it that far to the side of the lamp's middle.
fn glint(world: &sim::render::RenderedWorld, renderer: &mut sim::render::Renderer, aside_m: f64) -> Vec<f64> {
    let pose = Isometry3::from_parts(Translation3::new(1.0, 4.0 + aside_m, EYE_M), looking_ahead().rotation);
    // The lamp's image lies as far below the floor as the lamp above it.
    let below_px = FOCAL_PX * (EYE_M + LAMP_M) / AHEAD_M;
    let lens = Lens { principal_point_px: [320.0, 8.0 - below_px], ..Lens::ideal([WIDTH_PX, 17], FOCAL_PX) };
    let view = View {
        illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
        ..quiet_view(lens, vec![pose], 60.0)
    };
    let image = renderer.draw(world, &[view]).unwrap().remove(0);
    (0..WIDTH_PX).map(|u| (5..12).map(|v| level(&image, u, v)).sum::<f64>() / 7.0).collect()
}

/// Share that tiles mirror, 0.03 at right incidence, of a place so far to the left (Schlick 1994).
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
        // Blocks of the floor are half a metre wide, and a glint's end moves by 0.57 of what the eye moves: these are all its places in a block.
        for index in 0..36 {
            let aside_m = -0.4 + 0.024 * f64::from(index);
            let row = glint(&world, &mut renderer, aside_m);
            for side in [-1.0, 1.0] {
                // Image right is along −y.
                let end_px = |half_m: f64| 320.0 - FOCAL_PX * (side * half_m - aside_m) / AHEAD_M;
                let at = |half_m: f64| row[end_px(half_m).round() as usize];
                // A blur of 0.035 rad is up to 0.12 m wide on the lamp: 1 m within its end nothing of the end is seen.
                let within = at(HALF_M - 1.0);
                assert!(within > 60.0, "{within}");
                let share = at(HALF_M)
                    / mirrored(side * HALF_M - aside_m)
                    / (within / mirrored(side * (HALF_M - 1.0) - aside_m));
                assert!((0.4..0.55).contains(&share), "{is_first} {aside_m} {side}: {share} at the end");
                assert!(at(HALF_M + 1.0) < 0.02 * within, "{}", at(HALF_M + 1.0));
                // The steepest that the blur's bump lets the glint fall is 1.5 in its width of √20 deviations.
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
