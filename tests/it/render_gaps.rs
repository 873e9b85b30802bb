//! Rendered pictures have no gaps: neither between faces that meet, nor at the picture's border when what lies beyond it is blurred into it.

use std::f64::consts::PI;

use image::GrayImage;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3, vector};
use sim::{optics::Lens, render::View, scene::Scene, world::Drawn};

use crate::{
    light_of_lamps::black_room,
    render_room::{level, looking_ahead, looking_up, quiet_view},
    render_studio::renderer,
};

fn draw(scene: &Scene, views: Vec<View>) -> Vec<GrayImage> {
    let mut renderer = renderer();
    let world = renderer.upload_room(scene, &Drawn::draw(scene, 0)).unwrap();
    let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
    views
        .into_iter()
        .map(|view| renderer.draw(&world, &[View { illuminance_at_floor_lux, ..view }]).unwrap().remove(0))
        .collect()
}

/// Pixels that are darker by two fifths than both of their neighbours along the row or along the column.
fn chinks(image: &GrayImage) -> Vec<[u32; 2]> {
    let (width, height) = image.dimensions();
    let inner = (1..height - 1).flat_map(|v| (1..width - 1).map(move |u| [u, v]));
    let is_dark = |[u, v]: &[u32; 2]| {
        let (u, v) = (*u, *v);
        let darker = |one: f64, other: f64| level(image, u, v) < 0.6 * one.min(other);
        darker(level(image, u - 1, v), level(image, u + 1, v)) || darker(level(image, u, v - 1), level(image, u, v + 1))
    };
    inner.filter(is_dark).collect()
}

#[test]
fn no_chink_opens_between_faces_however_a_camera_turns_while_it_reads_out() {
    has_no_chinks("x_m = 3.9\ny_m = 0.43\nwidth_m = 2.03\ndepth_m = 2.11");
}

#[test]
fn no_chink_opens_at_the_slanted_walls_of_a_polygonal_room_nor_between_its_parts() {
    has_no_chinks(
        "corners_m = [[3.9, 0.43], [5.4, 0.21], [6.31, 0.9], [5.83, 1.97], [4.91, 1.62], [4.6, 2.57], [3.9, 2.54]]",
    );
}

/// Asserts that pictures of a room of 4 m by 3 m, which is open to a further room at its far end, have no chinks.
fn has_no_chinks(further_room: &str) {
    // The tested view shows where a further room adjoins the first one. There corners of walls lie in the middle of the edges of floor and ceiling,
    // and the cells into which the faces are divided do not line up: gaps would show here.
    let text = "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[building]\nwall_albedo = 0.8\nceiling_albedo = 0.8\nskirting_albedo = 0.8\n\
        [[building.room]]\nFURTHER\n\
        [start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n[light]\nilluminance_at_floor_lux = 200\n\
        [[lamp]]\nkind = \"panel\"\nx_m = 1.3\ny_m = 1.5\n[[lamp]]\nkind = \"panel\"\nx_m = 2.7\ny_m = 1.5\n\
        [[lamp]]\nkind = \"panel\"\nx_m = 5.0\ny_m = 1.4\n";
    let scene = Scene::parse(&text.replace("FURTHER", further_room), "chinks.toml").unwrap();
    let row_time_s = 200e-6;
    let total_s = 0.0005 + 239.0 * row_time_s;
    let poses = (0..24).map(|index| {
        let angle = f64::from(index);
        let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.4 * angle.sin());
        let tilt =
            UnitQuaternion::from_scaled_axis(vector![0.25 * (2.3 * angle).sin(), 0.0, 0.4 * (1.7 * angle).cos()]);
        let at = |time_s: f64| {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 2.0 * (time_s - total_s / 2.0));
            let place = Translation3::new(3.0 + 0.3 * angle.cos(), 1.5 + 0.6 * angle.sin(), 0.9);
            Isometry3::from_parts(place, turn * heading * looking_ahead().rotation * tilt)
        };
        (0..=8).map(|step| at(total_s * f64::from(step) / 8.0)).collect::<Vec<_>>()
    });
    let views = poses.map(|poses| {
        let lens = Lens { row_time_s, ..Lens::ideal([320, 240], 200.0) };
        let mut view = quiet_view(lens, poses, 3.0);
        view.sensor.quantum_efficiency *= view.exposure_s / 0.0005;
        view.exposure_s = 0.0005;
        view
    });
    for (index, image) in draw(&scene, views.collect()).iter().enumerate() {
        let found = chinks(image);
        assert!(found.is_empty(), "view {index}: {} chinks, such as {:?}", found.len(), &found[..found.len().min(5)]);
    }
}

/// Share of a disc's area that lies beyond a straight line at a distance of `off` radii from the disc's centre.
fn segment(off: f64) -> f64 {
    let off = off.clamp(-1.0, 1.0);
    (off.acos() - off * (1.0 - off * off).sqrt()) / PI
}

#[test]
fn defocus_at_the_border_spreads_in_what_lies_beyond_it() {
    // The view shows a panel of 1 m by 1 m under a black ceiling. The panel's edge lies 2 px beyond each border of the picture in turn, and the
    // lens blurs over 16 px.
    let panel = "[[lamp]]\nkind = \"panel\"\nx_m = 2.0\ny_m = 1.5\nheight_m = 2.5\nsize_m = [1.0, 1.0]\nlumens = 1000\n\
                 spectrum = \"monochrome\"\n";
    let scene = black_room(panel);
    let (focal_px, beyond_px, radius_px) = (100.0, 2.0, 8.0);
    let lens = Lens { defocus_px: 2.0 * radius_px, ..Lens::ideal([64, 64], focal_px) };
    let full = 200.0;
    // The panel's luminance is 1000 lm over π · 1 m². The camera looks up from 0.5 m, where a metre of the panel takes 50 px; image right is x
    // and image down is y.
    let levels = full / (1000.0 / PI);
    let aside_m = 0.5 + (32.0 + beyond_px) * 2.0 / focal_px;
    let poses = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    let view = |[x, y]: [f64; 2]| {
        let pose = looking_up(2.0 + x * aside_m, 1.5 + y * aside_m, 0.5, Vector3::zeros());
        quiet_view(lens.clone(), vec![pose], levels)
    };
    for ([x, y], image) in poses.into_iter().zip(draw(&scene, poses.map(view).to_vec())) {
        for inwards in 0..8 {
            let at = |towards: f64| {
                if towards == 0.0 {
                    32
                } else if towards < 0.0 {
                    63 - inwards
                } else {
                    inwards
                }
            };
            let seen = level(&image, at(x), at(y));
            // Distance in pixels from the middle of the tested pixel to the image of the lamp panel's edge, which is beyond the picture's border.
            let off_px = f64::from(inwards) + 0.5 + beyond_px;
            let expected = full * segment(off_px / radius_px);
            assert!(
                (seen - expected).abs() < 0.06 * full,
                "{x}, {y}, {inwards} px inwards: {seen}, expected {expected}"
            );
        }
    }
}
