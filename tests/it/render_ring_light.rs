//! The ring of diodes around a lens in rendered pictures: illuminance I·cos α/r² across its rays, and Lambert's cosine on the faces that it
//! lights.

use std::f64::consts::PI;

use image::GrayImage;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use sim::{optics::Lens, place::building::UprightBody, render::View, scene::Scene, world::Drawn};

use crate::{
    light_of_lamps::black_room,
    render_room::{level, looking_ahead, looking_up, quiet_view},
    render_studio::renderer,
};

const RING_CANDELA: f64 = 10.0;
const DARK: &str = "[light]\nilluminance_at_floor_lux = 0.0\n";

fn look(scene: &Scene, bodies: &[UprightBody], (lens, pose): (Lens, Isometry3<f64>), levels: f64) -> GrayImage {
    let mut renderer = renderer();
    let mut world = renderer.upload_room(scene, &Drawn::draw(scene, 0)).unwrap();
    world.place_bodies(bodies);
    let lens = Lens { ring_candela: RING_CANDELA, ..lens };
    renderer
        .draw(&world, &[View { illuminance_at_floor_lux: 0.0, ..quiet_view(lens, vec![pose], levels) }])
        .unwrap()
        .remove(0)
}

/// Mean grey level of 3 × 3 pixels around a place.
fn around(image: &GrayImage, [u, v]: [f64; 2]) -> f64 {
    let (u, v) = (u.round() as u32, v.round() as u32);
    (0..9).map(|index| level(image, u - 1 + index % 3, v - 1 + index / 3)).sum::<f64>() / 9.0
}

/// Grey level of a matt face of this albedo in the ring's light, for the luminance albedo·E/π with E = I·cos α·cos β/r²; `cosines` is cos α off
/// the lens's axis times cos β of incidence.
fn expected(levels: f64, albedo: f64, cosines: f64, distance_m: f64) -> f64 {
    levels * albedo * RING_CANDELA * cosines / (PI * distance_m.powi(2))
}

/// Pose of a camera that looks along world x, with image right along −y, and is then turned to the left by an angle.
fn turned(x_m: f64, height_m: f64, left_rad: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), left_rad);
    Isometry3::from_parts(Translation3::new(x_m, 1.5, height_m), turn * looking_ahead().rotation)
}

#[test]
fn a_wall_s_luminance_falls_by_the_cosine_off_the_axis_and_by_that_of_incidence() {
    let text = "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[building]\nwall_albedo = 0.6\nceiling_albedo = 0.0\nskirting_albedo = 0.0\n\
        [start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n[light]\nilluminance_at_floor_lux = 0.0\n";
    let scene = Scene::parse(text, "ring.toml").unwrap();
    let (levels, left_rad) = (100.0, 0.5);
    let lens = Lens::ideal([321, 161], 150.0);
    let image = look(&scene, &[], (lens, turned(2.0, 1.3, left_rad)), levels);
    // The wall at x = 4 is 2 m ahead of the camera. The ray of each tested pixel is turned into the world frame, so that its cosine of incidence on
    // the wall can be computed by hand.
    for u in [20.0, 100.0, 160.0, 220.0, 300.0] {
        for v in [30.0, 80.0, 120.0] {
            let (right, down) = ((u - 160.0) / 150.0, (v - 80.0) / 150.0);
            let length = 1.0_f64.hypot(right).hypot(down);
            let (forward, left) = (left_rad.cos() + right * left_rad.sin(), left_rad.sin() - right * left_rad.cos());
            let (incidence, off_axis) = (forward / length, 1.0 / length);
            let distance_m = 2.0 / incidence;
            if (left / forward * 2.0).abs() > 1.4 {
                continue;
            }
            let (seen, expected) = (around(&image, [u, v]), expected(levels, 0.6, off_axis * incidence, distance_m));
            // The texture of plaster varies by 3.5 %.
            assert!((seen / expected - 1.0).abs() < 0.045, "{u}, {v}: {seen}, expected {expected}");
        }
    }
}

fn person(x_m: f64) -> UprightBody {
    UprightBody {
        middle_m: [x_m, 1.5],
        heading_rad: PI,
        height_m: 1.75,
        radius_m: 0.23,
        stride: 0.0,
        velocity_m_per_s: [0.0; 2],
    }
}

#[test]
fn a_person_s_luminance_falls_by_the_cosine_off_the_axis() {
    let scene = black_room(DARK);
    let levels = 150.0;
    // The camera looks at the person's chest, 0.7 of the height above the floor. The chest is half as deep as half the width over the shoulders,
    // and the shirt's albedo is 0.35.
    let distance_m = 2.0 - 0.5 * 0.23;
    for left_rad in [-0.7_f64, -0.35, 0.0, 0.35, 0.7] {
        let lens = Lens::ideal([321, 65], 150.0);
        let image = look(&scene, &[person(3.0)], (lens, turned(1.0, 0.7 * 1.75, left_rad)), levels);
        let seen = around(&image, [160.0 + 150.0 * left_rad.tan(), 32.0]);
        let expected = expected(levels, 0.35, left_rad.cos(), distance_m);
        assert!((seen / expected - 1.0).abs() < 0.03, "{left_rad} rad: {seen}, expected {expected}");
    }
}

#[test]
fn a_neck_is_as_bright_to_its_sides_as_the_cosine_on_an_ellipse_has_it() {
    let scene = black_room(DARK);
    // The neck is seen from its own height, 0.86 of the body's. It is of skin, and an ellipse: its half axes are 0.22 of half the width over the
    // shoulders across and 0.24 in depth.
    let (levels, focal_px) = (400.0, 1500.0);
    let (across_m, deep_m) = (0.22 * 0.23, 0.24 * 0.23);
    let lens = Lens::ideal([161, 17], focal_px);
    let image = look(&scene, &[person(2.5)], (lens, turned(1.0, 0.86 * 1.75, 0.0)), levels);
    // Grey level between two pixels of the row that shows the neck, by linear interpolation: the level falls by some hundredths from pixel to pixel.
    let between = |image: &GrayImage, u: f64| {
        let (left, share) = (u.floor() as u32, u - u.floor());
        (1.0 - share) * level(image, left, 8) + share * level(image, left + 1, 8)
    };
    for degrees in [-60.0_f64, -30.0, 0.0, 30.0, 60.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        // A place on the ellipse, relative to the eye, and the ellipse's normal (cos/b, sin/a) there.
        let at = Point3::new(1.5 - deep_m * cos, across_m * sin, 0.0);
        let normal = Vector3::new(-cos / deep_m, sin / across_m, 0.0).normalize();
        let incidence = -at.coords.normalize().dot(&normal);
        let (seen, expected) = (
            between(&image, 80.0 + focal_px * at.y / at.x),
            expected(levels, 0.35, incidence * at.x / at.coords.norm(), at.coords.norm()),
        );
        assert!((seen / expected - 1.0).abs() < 0.06, "{degrees}°: {seen}, expected {expected}");
    }
}

#[test]
fn a_lamp_that_is_off_shows_its_diffuser_in_the_ring_s_light() {
    let panel =
        "[[lamp]]\nkind = \"panel\"\nx_m = 2.0\ny_m = 1.5\nheight_m = 2.5\nsize_m = [2.4, 2.4]\nlumens = 1000\n";
    let scene = black_room(&format!("{DARK}{panel}"));
    let levels = 100.0;
    let image =
        look(&scene, &[], (Lens::ideal([161, 161], 100.0), looking_up(2.0, 1.5, 1.0, Vector3::zeros())), levels);
    for aside_px in [0.0, 30.0, 60.0, 75.0] {
        let cosine = 1.0 / 1.0_f64.hypot(aside_px / 100.0);
        // The diffuser's albedo is 0.7. Both cosines are that of the ray, which is 1.5 m/cos long.
        let expected = expected(levels, 0.7, cosine.powi(2), 1.5 / cosine);
        for at in [[80.0 + aside_px, 80.0], [80.0, 80.0 - aside_px]] {
            let seen = around(&image, at);
            assert!((seen / expected - 1.0).abs() < 0.03, "{at:?}: {seen}, expected {expected}");
        }
    }
}

#[test]
fn without_a_ring_a_dot_is_a_matt_disc_in_the_rooms_light() {
    // The dot is on the ceiling; the bulb of 100 cd is 0.6 m aside of the dot and 0.999 m below it: E = I·cos β/d². Light that the floor throws back
    // adds some lux.
    let scene = black_room(
        "[[building.dot]]\nx_m = 2.0\ny_m = 1.5\nradius_m = 0.05\n[[lamp]]\nkind = \"point\"\nx_m = 2.6\ny_m = 1.5\n\
         height_m = 1.6\nlumens = 1256.637\nspectrum = \"monochrome\"\n",
    );
    let mut renderer = renderer();
    let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let view = View {
        illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
        ..quiet_view(Lens::ideal([64, 64], 200.0), vec![looking_up(2.0, 1.5, 0.6, Vector3::zeros())], 20.0)
    };
    let image = renderer.draw(&world, &[view]).unwrap().remove(0);
    let square = 0.6_f64.powi(2) + 0.999_f64.powi(2);
    let direct_lux = 100.0 * 0.999 / square.powf(1.5);
    let (seen, expected) = (around(&image, [31.5, 31.5]), 20.0 * 0.3 * direct_lux / PI);
    assert!((1.0..1.08).contains(&(seen / expected)), "{seen}, expected {expected} and some more");
}

#[test]
fn an_infrared_forward_camera_sees_a_dark_room_by_its_ring() {
    let intensity_w_per_sr = 0.05;
    let scene = |band: &str| {
        let text = format!(
            "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[building]\nwall_albedo = 0.6\nceiling_albedo = 0.0\nskirting_albedo = 0.0\n\
             [start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n{DARK}\
             [robot.forward_camera]\nband = \"{band}\"\nring_intensity_w_per_sr = {intensity_w_per_sr:?}\nlens.vignetting = false\n"
        );
        Scene::parse(&text, "forward_ring.toml").unwrap_or_else(|error| panic!("failed to {error}"))
    };
    let seen = |band: &str, levels: f64| {
        let scene = scene(band);
        let drawn = Drawn::draw(&scene, 0);
        let lens = Lens::of(scene.robot.forward_camera.as_ref().unwrap(), &drawn.devices.forward_camera.unwrap());
        let mut renderer = renderer();
        let world = renderer.upload_room(&scene, &drawn).unwrap();
        let view = quiet_view(lens.clone(), vec![turned(2.0, 1.3, 0.0)], levels);
        let image = renderer.draw(&world, &[View { illuminance_at_floor_lux: 0.0, ..view }]).unwrap().remove(0);
        (image, lens)
    };
    let levels = 80.0;
    let (image, lens) = seen("infrared", levels);
    // A watt of 850 nm has as many photons as 683 · 850/555 lm of 555 nm. At 850 nm the wall's albedo is 0.25 + 0.65 · 0.6.
    let (candela, albedo) = (intensity_w_per_sr * 683.0 * 850.0 / 555.0, 0.64);
    for pixel in [[320.0, 240.0], [100.0, 240.0], [540.0, 300.0], [320.0, 80.0]] {
        let [right, down] = lens.ray(pixel).unwrap();
        // By hand, the wall's illuminance by the ring light: the wall is 2 m ahead and faces the camera, so that the cosine of a ray off the camera's
        // axis is also its cosine of incidence.
        let cosine = 1.0 / 1.0_f64.hypot(right).hypot(down);
        let lux = candela * cosine * cosine / (2.0 / cosine).powi(2);
        let (seen, expected) = (around(&image, pixel), levels * albedo * lux / PI);
        // The texture of plaster varies by 3.5 %.
        assert!((seen / expected - 1.0).abs() < 0.045, "{pixel:?}: {seen}, expected {expected}");
    }
    let (image, _) = seen("visible", levels);
    assert!(around(&image, [320.0, 240.0]) < 1.0, "diodes of 850 nm lit a visible picture");
}
