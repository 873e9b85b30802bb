//! People who walk while a picture is taken: where each row of a rolling shutter sees them, who is left out, and their shadows.

use std::f64::consts::PI;

use image::GrayImage;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use sim::{optics::Lens, place::building::UprightBody, render::View, scene::Scene, world::Drawn};

use crate::{
    light_of_lamps::black_room,
    render_room::{level, looking_ahead, quiet_view, spread},
    render_studio::renderer,
};

/// Grey levels for 1 cd/m² at which everything that is lit is white, so that a row shows how much of each pixel is covered.
const WHITE: f64 = 3000.0;

fn person(middle_m: [f64; 2], heading_rad: f64, speed_m_per_s: f64) -> UprightBody {
    UprightBody {
        middle_m,
        heading_rad,
        height_m: 1.75,
        radius_m: 0.23,
        stride: 0.0,
        velocity_m_per_s: [speed_m_per_s * heading_rad.cos(), speed_m_per_s * heading_rad.sin()],
    }
}

/// Picture of people by a camera that exposes for half a second, or for `exposure_s` with as many photons.
fn look(scene: &Scene, bodies: &[UprightBody], view: View, exposure_s: f64) -> GrayImage {
    let mut renderer = renderer();
    let mut world = renderer.upload_room(scene, &Drawn::draw(scene, 0)).unwrap();
    world.place_bodies(bodies);
    let mut view = View { illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(), ..view };
    view.sensor.quantum_efficiency *= view.exposure_s / exposure_s;
    view.exposure_s = exposure_s;
    renderer.draw(&world, &[view]).unwrap().remove(0)
}

/// Pose of a camera at this place that looks along world x, with image right along −y.
fn ahead_from(x_m: f64, y_m: f64, z_m: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x_m, y_m, z_m), looking_ahead().rotation)
}

/// A lit room with black walls and ceiling: where the camera does not see the floor, only people are lit.
fn lit_room() -> Scene {
    black_room("[light]\nilluminance_at_floor_lux = 200\n")
}

#[test]
fn rows_of_a_rolling_shutter_see_people_where_they_then_are() {
    let (row_time_s, exposure_s, focal_px, before_m) = (100e-6, 0.0005, 600.0, 2.0);
    let total_s = exposure_s + 479.0 * row_time_s;
    let lens = Lens { row_time_s, ..Lens::ideal([320, 480], focal_px) };
    let scene = lit_room();
    // The camera looks at the person's head, whose middle is 0.91 of the height above the floor, and which appears on one row after another. The
    // head is symmetric, so that its centre is where its axis is.
    let head_m = 0.91 * 1.75;
    for speed_m_per_s in [1.2, -1.2] {
        for row in [40.0, 140.0, 239.5, 340.0, 440.0] {
            let eye_m = head_m + (row - 239.5) * before_m / focal_px;
            let view = quiet_view(lens.clone(), vec![ahead_from(1.0, 1.5, eye_m)], WHITE);
            // The person faces and walks along −y, to the right of the image, and is at y = 1.5 when the last row's exposure ends.
            let walker = person([1.0 + before_m, 1.5], -PI / 2.0, speed_m_per_s);
            let image = look(&scene, &[walker], view, exposure_s);
            for v in row as u32 - 3..row as u32 + 3 {
                let before_end_s = total_s - 0.5 * exposure_s - f64::from(v) * row_time_s;
                let expected = 159.5 - focal_px / before_m * speed_m_per_s * before_end_s;
                let (seen, _) = spread((0..320).map(|u| (f64::from(u), level(&image, u, v))));
                // The pixels at the edges of the head's image are either white or black, so that each may add a whole pixel of error to the head's
                // centre.
                assert!((seen - expected).abs() < 0.6, "{speed_m_per_s} m/s, row {v}: {seen}, expected {expected}");
            }
        }
    }
}

#[test]
fn of_somebody_beside_the_picture_the_arm_is_seen_that_reaches_into_it() {
    let (focal_px, before_m) = (300.0, 1.0);
    let scene = lit_room();
    let view = || quiet_view(Lens::ideal([160, 240], focal_px), vec![ahead_from(0.5, 1.5, 1.2)], WHITE);
    // By the renderer's model of a person, the arms reach 0.9 + 0.2 times half the body's width from the axis, at 0.8 of the height.
    let (reach_px, row) = (focal_px * 1.1 * 0.23 / before_m, 119.5 - focal_px * (0.8 * 1.75 - 1.2) / before_m);
    for side in [-1.0, 1.0] {
        // The person stands beside the picture: the body's axis is 40 px beyond the picture's border, but an arm reaches into the picture.
        let axis_px = 79.5 + side * 120.0;
        let standing = person([0.5 + before_m, 1.5 - side * 120.0 * before_m / focal_px], PI, 0.0);
        let image = look(&scene, &[standing], view(), 0.5);
        let lit: f64 = (0..160).map(|u| level(&image, u, row.round() as u32) / 255.0).sum();
        let border_px = 79.5 + side * 80.0;
        let expected = reach_px - (axis_px - border_px).abs();
        assert!((lit - expected).abs() < 3.0, "{side}: {lit} px, expected {expected}");
    }
}

#[test]
fn somebody_who_runs_out_of_the_picture_has_been_in_it() {
    let (focal_px, before_m) = (300.0, 3.0);
    let scene = lit_room();
    let view = |levels| quiet_view(Lens::ideal([160, 120], focal_px), vec![ahead_from(0.5, 0.6, 1.2)], levels);
    let row = (59.5 - focal_px * (0.7 * 1.75 - 1.2) / before_m).round() as u32;
    let column_of = |y_m: f64| (79.5 - focal_px * (y_m - 0.6) / before_m).round() as u32;
    let levels = 12.0;
    let still = look(&scene, &[person([3.5, 1.25], PI / 2.0, 0.0)], view(levels), 0.5);
    let full = level(&still, column_of(1.25), row);
    // In half a second the person runs from y = 1 to y = 2.5, far out of the picture, which ends at y = 1.4.
    let image = look(&scene, &[person([3.5, 2.5], PI / 2.0, 3.0)], view(8.0 * levels), 0.5);
    // A person's trunk is half as deep as half its width, so that it covers a given place for 0.23 m of the 1.5 m run, which is the expected share of
    // the light. The sub-frames of which the renderer composes the exposure resolve that to a fifth, and people are lit in all of them as they are at
    // their last place.
    let share = level(&image, column_of(1.25), row) / full / 8.0;
    assert!((0.5..1.5).contains(&(share / (0.23 / 1.5))), "{share} of {full}, expected {}", 0.23 / 1.5);
}

#[test]
fn a_camera_that_goes_with_a_shadow_sees_it_sharp() {
    // The bulb is at (0.5, 1.5), and the person 1 m from it: on the floor 1.6 m from the bulb the shadow moves 1.6 times as far.
    let scene = black_room(
        "[[lamp]]\nkind = \"point\"\nx_m = 0.5\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\nspectrum = \"monochrome\"\n",
    );
    let lens = Lens::ideal([320, 64], 240.0);
    // The camera looks straight down on the floor 1.6 m from the lamp, with image right along world y; from 1.2 m a metre takes 200 px.
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI / 2.0) * down;
    let pose = |y_m: f64| Isometry3::from_parts(Translation3::new(2.1, y_m, 1.2), turned);
    let walker = |speed: f64| UprightBody { radius_m: 0.15, ..person([1.5, 1.5], PI / 2.0, speed) };
    // The camera moves with the person's shadow on the floor; at the end of the exposure both are at y = 1.5.
    let along = |bodies: &[UprightBody], speed_m_per_s: f64| {
        let poses = (0..=4).map(|index| pose(1.5 - 1.6 * speed_m_per_s * 0.5 * (1.0 - f64::from(index) / 4.0)));
        let image = look(&scene, bodies, quiet_view(lens.clone(), poses.collect(), 60.0), 0.5);
        (0..320).map(|u| (28..36).map(|v| level(&image, u, v)).sum::<f64>()).collect::<Vec<f64>>()
    };
    let shadow = |speed_m_per_s: f64| {
        let (lit, shaded) = (along(&[], speed_m_per_s), along(&[walker(speed_m_per_s)], speed_m_per_s));
        spread((0..320).map(|u| (u as f64, 1.0 - shaded[u] / lit[u])).collect::<Vec<_>>().into_iter())
    };
    let (still, walking) = (shadow(0.0), shadow(0.5));
    assert!((still.0 - walking.0).abs() < 3.0, "{still:?}, {walking:?}");
    // The renderer updates the shadow every 0.05 m of the person's way while the camera moves on. That smears the shadow's edge by a box of 16 px,
    // whose variance is 16²/12. A shadow that stood still would be smeared over 80 px.
    let added = walking.1 - still.1;
    assert!((-10.0..60.0).contains(&added), "{added} px², {still:?}, {walking:?}");
}
