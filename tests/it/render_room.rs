use std::f64::consts::PI;

use image::GrayImage;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3, vector};
use sim::{
    optics::{Lens, Photons},
    place::{
        building::{Building, Panel, UprightBody},
        drawn::DrawnPlace,
    },
    render::{NoiseKey, Shows, View},
    scene::{Band, Scene, SensorModel, SensorPreset, Spectrum},
    world::Drawn,
};

use crate::{light_of_lamps::black_room, render_studio::renderer};

/// A view of a room with an exposure of half a second and hardly any noise, in which 1 cd/m² is `levels` grey levels.
pub(crate) fn quiet_view(lens: Lens, poses: Vec<Isometry3<f64>>, levels: f64) -> View {
    let sensor = SensorModel {
        pixel_pitch_m: 5e-6,
        f_number: 2.0,
        quantum_efficiency: 0.5,
        read_noise_electrons: 0.0,
        full_well_electrons: 1e9,
        ..SensorPreset::GlobalShutter.model()
    };
    let exposure_s = 0.5;
    View {
        shows: Shows::Room,
        sensor,
        world_from_camera: poses,
        exposure_s,
        gain_levels_per_electron: levels / sensor.electrons_per_luminance(exposure_s),
        illuminance_at_floor_lux: 0.0,
        noise: NoiseKey { seed: 3, image: 0 },
        lens,
    }
}

/// Renders a view in the light that the scene states.
fn draw(scene: &Scene, view: View) -> GrayImage {
    let mut renderer = renderer();
    let world = renderer.upload_room(scene, &Drawn::draw(scene, 0)).unwrap();
    let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
    renderer.draw(&world, &[View { illuminance_at_floor_lux, ..view }]).unwrap().remove(0)
}

/// Pose of a camera that looks down from a place, with image up along world y.
pub(crate) fn looking_down(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

/// Pose of a camera that looks up from a place, with image down along world y, then turned by the rotation vector `turn`.
pub(crate) fn looking_up(x: f64, y: f64, z: f64, turn: Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_scaled_axis(turn))
}

pub(crate) fn level(image: &GrayImage, u: u32, v: u32) -> f64 {
    f64::from(image.get_pixel(u, v).0[0])
}

/// Brown and Conrady's distortion model, written as in OpenCV's documentation and not as in the simulator.
fn opencv(lens: &Lens, p: Point3<f64>) -> [f64; 2] {
    let (x, y) = (p.x / p.z, p.y / p.z);
    let [k1, k2, p1, p2, k3] = lens.distortion;
    let r = x.hypot(y);
    let factor = 1.0 + k1 * r.powi(2) + k2 * r.powi(4) + k3 * r.powi(6);
    let xd = x * factor + 2.0 * p1 * x * y + p2 * (r.powi(2) + 2.0 * x.powi(2));
    let yd = y * factor + p1 * (r.powi(2) + 2.0 * y.powi(2)) + 2.0 * p2 * x * y;
    [lens.focal_px[0] * xd + lens.principal_point_px[0], lens.focal_px[1] * yd + lens.principal_point_px[1]]
}

/// Scene of a dark room with retro-reflective dots on the ceiling, which a camera sees by the light of its ring.
fn dots(places: &[[f64; 2]], radius_m: f64) -> Scene {
    let keys: String = places
        .iter()
        .map(|[x, y]| format!("[[building.dot]]\nx_m = {x:?}\ny_m = {y:?}\nradius_m = {radius_m:?}\n"))
        .collect();
    black_room(&format!("[light]\nilluminance_at_floor_lux = 0.0\n{keys}"))
}

const DOT_HEIGHT_M: f64 = 2.6 - 0.001;

fn ring(lens: Lens) -> Lens {
    Lens { ring_candela: 10.0, ..lens }
}

/// Centre of a bright spot, and variance along u, weighted by grey level, within `reach` px of a place.
fn spot(image: &GrayImage, near: [f64; 2], reach: i32) -> ([f64; 2], f64) {
    let [u0, v0] = near.map(|coordinate| coordinate.round() as i32);
    let pixels = || (v0 - reach..=v0 + reach).flat_map(move |v| (u0 - reach..=u0 + reach).map(move |u| (u, v)));
    let weight = |(u, v): (i32, i32)| level(image, u as u32, v as u32);
    let total: f64 = pixels().map(weight).sum();
    let mean = |value: &dyn Fn((i32, i32)) -> f64| pixels().map(|p| weight(p) * value(p)).sum::<f64>() / total;
    let centre = [mean(&|p| f64::from(p.0)), mean(&|p| f64::from(p.1))];
    (centre, mean(&|p| (f64::from(p.0) - centre[0]).powi(2)))
}

/// Centre of a disc's image: points of the disc, weighted by the area that each takes up on the image.
fn disc_centre(project: &dyn Fn(Point3<f64>) -> [f64; 2], centre: [f64; 2], radius_m: f64) -> [f64; 2] {
    let at = |dx: f64, dy: f64| project(Point3::new(centre[0] + dx, centre[1] + dy, DOT_HEIGHT_M));
    let step = 1e-5;
    let mut sums = [0.0; 3];
    for (i, j) in (-20..=20).flat_map(|i| (-20..=20).map(move |j| (i, j))) {
        let (dx, dy) = (f64::from(i) / 20.0 * radius_m, f64::from(j) / 20.0 * radius_m);
        if dx.hypot(dy) > radius_m {
            continue;
        }
        let (here, right, up) = (at(dx, dy), at(dx + step, dy), at(dx, dy + step));
        let area = ((right[0] - here[0]) * (up[1] - here[1]) - (right[1] - here[1]) * (up[0] - here[0])).abs();
        sums = [sums[0] + area, sums[1] + area * here[0], sums[2] + area * here[1]];
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

#[test]
fn grey_levels_of_a_floor_are_its_luminance_by_hand() {
    // The bulb of 100 cd hangs 2 m above (1, 1.5), which gives 25 lx below it; the screed has albedo 0.4, so that L = 0.4·25/π.
    let scene = black_room(
        "[[lamp]]\nkind = \"point\"\nx_m = 1.0\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\n\
         spectrum = \"monochrome\"\n",
    );
    let view = quiet_view(Lens::ideal([64, 64], 200.0), vec![looking_down(1.0, 1.5, 1.0)], 50.0);
    let image = draw(&scene, view);
    let mean =
        (28..36).flat_map(|u| (28..36).map(move |v| (u, v))).map(|(u, v)| level(&image, u, v)).sum::<f64>() / 64.0;
    let expected = 50.0 * 0.4 * 25.0 / PI;
    assert!((mean / expected - 1.0).abs() < 0.01, "{mean}, expected {expected}");
}

#[test]
fn the_image_falls_off_by_the_fourth_power_of_the_cosine() {
    // Straight below a large even light, nothing but the lens's natural fall-off makes the corners of the image darker. The image is compared with
    // one of the same view without that fall-off.
    let scene = black_room("[light]\nilluminance_at_floor_lux = 100\n");
    let lens = Lens { vignetting: true, ..Lens::ideal([65, 65], 40.0) };
    let with = draw(&scene, quiet_view(lens, vec![looking_down(2.0, 1.5, 0.5)], 15.0));
    let without = draw(&scene, quiet_view(Lens::ideal([65, 65], 40.0), vec![looking_down(2.0, 1.5, 0.5)], 15.0));
    // Expected share of light at pixel (62, 32), which is 30 px off the axis at a focal length of 40 px: tan = 0.75, cos⁴ = 0.64².
    let mean = |image: &GrayImage| (28..37).map(|v| level(image, 62, v)).sum::<f64>();
    let ratio = mean(&with) / mean(&without);
    assert!((ratio / 0.4096 - 1.0).abs() < 0.02, "{ratio}");
}

#[test]
fn a_distorted_ray_comes_back_to_its_pixel() {
    for distortion in [[-0.28, 0.09, 0.001, -0.0008, -0.012], [0.1, -0.05, -0.002, 0.001, 0.01]] {
        let lens = Lens { distortion, ..Lens::ideal([640, 480], 417.0) };
        for (u, v) in [(0.0, 0.0), (639.0, 0.0), (0.0, 479.0), (320.5, 13.0), (639.0, 479.0)] {
            let [x, y] = lens.ray([u, v]).unwrap();
            let seen = opencv(&lens, Point3::new(x, y, 1.0));
            assert!((seen[0] - u).hypot(seen[1] - v) < 1e-3, "{seen:?}, expected {u}, {v}");
        }
    }
}

#[test]
fn discs_appear_where_an_independent_projection_puts_them() {
    let places = [[2.0, 1.5], [1.45, 1.0], [2.55, 1.9], [1.5, 2.0], [2.5, 1.05]];
    let (radius_m, turn) = (0.012, vector![0.05, -0.08, 0.4]);
    let scene = dots(&places, radius_m);
    for distortion in [[0.0; 5], [-0.25, 0.08, 0.001, -0.0015, -0.01]] {
        let lens = ring(Lens { distortion, ..Lens::ideal([640, 480], 560.0) });
        let pose = looking_up(2.02, 1.47, 0.3, turn);
        let image = draw(&scene, quiet_view(lens.clone(), vec![pose], 0.4));
        let project = |point: Point3<f64>| opencv(&lens, pose.inverse_transform_point(&point));
        for place in places {
            let expected = disc_centre(&project, place, radius_m);
            let (seen, _) = spot(&image, expected, 7);
            let error_px = (seen[0] - expected[0]).hypot(seen[1] - expected[1]);
            assert!(error_px < 0.05, "{distortion:?} {place:?}: {seen:?}, expected {expected:?}");
        }
    }
}

#[test]
fn rows_of_a_rolling_shutter_see_the_camera_where_it_then_is() {
    let places = [[1.8, 0.75], [2.0, 1.3], [2.5, 1.9], [2.1, 2.2]];
    let (radius_m, row_time_s, exposure_s) = (0.012, 40e-6, 0.0005);
    let scene = dots(&places, radius_m);
    let lens = ring(Lens { row_time_s, distortion: [-0.1, 0.02, 0.0, 0.0, 0.0], ..Lens::ideal([640, 480], 560.0) });
    // The camera turns at 1.5 rad/s and drives at 0.5 m/s while 480 rows are read out in 19 ms: some 16 px and 2.3 px.
    let total_s = exposure_s + 479.0 * row_time_s;
    let pose_at = |time_s: f64| looking_up(2.0 + 0.5 * time_s, 1.5, 0.3, vector![0.0, 0.0, 0.3 + 1.5 * time_s]);
    let poses = (0..=8).map(|index| pose_at(total_s * f64::from(index) / 8.0)).collect();
    let mut view = quiet_view(lens.clone(), poses, 0.4);
    let slower = view.exposure_s / exposure_s;
    view.exposure_s = exposure_s;
    view.gain_levels_per_electron *= slower;
    view.sensor.quantum_efficiency *= slower;
    view.gain_levels_per_electron /= slower;
    let image = draw(&scene, view);
    for place in places {
        // Time at which the dot's row is exposed, found by bisection on row(time) − row.
        let centre = Point3::new(place[0], place[1], DOT_HEIGHT_M);
        let row_at =
            |row: f64| opencv(&lens, pose_at(0.5 * exposure_s + row * row_time_s).inverse_transform_point(&centre));
        let (mut low, mut high) = (0.0, 479.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if row_at(middle)[1] > middle { low = middle } else { high = middle }
        }
        let expected = row_at(low);
        let (seen, _) = spot(&image, expected, 8);
        let error_px = (seen[0] - expected[0]).hypot(seen[1] - expected[1]);
        let still = opencv(&lens, pose_at(0.5 * total_s).inverse_transform_point(&centre));
        assert!(error_px < 0.1, "{place:?}: {seen:?}, expected {expected:?}, without rolling {still:?}");
    }
}

#[test]
fn blur_is_as_long_as_the_way_on_the_image() {
    let scene = dots(&[[2.0, 1.5]], 0.005);
    let lens = ring(Lens::ideal([256, 192], 560.0));
    // The renderer draws a moving view as several sub-frames, and chooses their number by how far things move in the image. So the dot is seen from a
    // metre away, and from so near that the same blur in pixels is a third of the distance driven.
    for height_m in [1.6, 2.25] {
        let depth_m = DOT_HEIGHT_M - height_m;
        let variance = |blur_px: f64| {
            let way_m = blur_px / 560.0 * depth_m;
            let poses = (0..=4)
                .map(|index| looking_up(2.0 + (f64::from(index) / 4.0 - 0.5) * way_m, 1.5, height_m, Vector3::zeros()))
                .collect();
            let image = draw(&scene, quiet_view(lens.clone(), poses, 0.07 * depth_m.powi(2)));
            spot(&image, [127.5, 95.5], 60).1
        };
        let still = variance(0.0);
        for blur_px in [4.0, 9.0, 20.0, 70.0] {
            // A steady motion smears the spot by a box of length b in pixels, which adds b²/12 to its variance.
            let measured_px = (12.0 * (variance(blur_px) - still)).sqrt();
            assert!(
                (measured_px / blur_px - 1.0).abs() < 0.02,
                "{measured_px} px, expected {blur_px}, {depth_m} m away"
            );
        }
    }
}

#[test]
fn defocus_spreads_a_point_over_its_disc() {
    let scene = dots(&[[2.0, 1.5]], 0.01);
    let variance = |defocus_px: f64| {
        let lens = ring(Lens { defocus_px, ..Lens::ideal([256, 192], 560.0) });
        let image = draw(&scene, quiet_view(lens, vec![looking_up(2.0, 1.5, 0.3, Vector3::zeros())], 0.4));
        spot(&image, [127.5, 95.5], 24).1
    };
    // A blur disc of diameter d px spreads a point with the variance d²/16 along any axis.
    let added = variance(8.0) - variance(0.0);
    assert!((added / 4.0 - 1.0).abs() < 0.05, "{added}, expected 4");
}

#[test]
fn a_retro_reflector_is_as_bright_as_its_coefficient_says() {
    let scene = dots(&[[2.0, 1.5]], 0.05);
    let lens = Lens { ring_candela: 3.0, ..Lens::ideal([64, 64], 200.0) };
    let image = draw(&scene, quiet_view(lens, vec![looking_up(2.0, 1.5, 0.6, Vector3::zeros())], 1.0));
    // By hand, the retro-reflective dot's luminance is R_A·E⊥: the coefficient of retroreflection R_A is 200 cd/lx/m², and the camera's ring lights
    // the dot with 3 cd from 1.999 m.
    let expected = 200.0 * 3.0 / (2.6_f64 - 0.001 - 0.6).powi(2);
    let mean =
        (30..34).flat_map(|u| (30..34).map(move |v| (u, v))).map(|(u, v)| level(&image, u, v)).sum::<f64>() / 16.0;
    assert!((mean / expected - 1.0).abs() < 0.01, "{mean}, expected {expected}");
}

#[test]
fn the_same_room_gives_the_same_bytes_and_no_camera_disturbs_another() {
    let scene = black_room(
        "[floor]\ncovering = \"wood\"\n[[lamp]]\nkind = \"window\"\nx_m = 2.0\ny_m = 0.0\nheading_deg = 90\n\
         [[floor.region]]\nname = \"wet\"\nx_m = [1.5, 2.5]\ny_m = [1.0, 2.0]\nfriction = 0.4\ncovering = \"wet\"\n",
    );
    let view = |distortion: [f64; 5]| {
        let lens = Lens { distortion, ..Lens::ideal([160, 120], 100.0) };
        quiet_view(lens, vec![looking_down(2.0, 1.5, 1.2)], 2.0)
    };
    let one = draw(&scene, view([0.0; 5]));
    let mut renderer = renderer();
    let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
    let views =
        [view([-0.1, 0.0, 0.0, 0.0, 0.0]), view([0.0; 5])].map(|view| View { illuminance_at_floor_lux, ..view });
    let both = renderer.draw(&world, &views).unwrap();
    assert!(both[1] == one, "beside another view, and from another upload");
    assert!(both[0] != one, "distortion shows");
}

#[test]
fn each_seed_has_a_pattern_of_its_own_whatever_was_drawn_before() {
    let scene = black_room("[light]\nilluminance_at_floor_lux = 100\n");
    let mut renderer = renderer();
    let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let mut look = |seed: u64, image: u32| {
        let mut view = quiet_view(Lens::ideal([64, 48], 60.0), vec![looking_down(2.0, 1.5, 1.2)], 6.0);
        view.sensor.prnu = 0.1;
        view.illuminance_at_floor_lux = 100.0;
        view.noise = NoiseKey { seed, image };
        renderer.draw(&world, &[view]).unwrap().remove(0)
    };
    let (first, other, again, next) = (look(5, 0), look(6, 0), look(5, 0), look(5, 1));
    assert!(again == first, "the first seed's pattern after another's");
    // The image has hardly any photon noise, so that the sensor's fixed pattern dominates: two images of the same seed differ little, and those of
    // two seeds by a tenth of their level.
    let apart = |one: &GrayImage, two: &GrayImage| {
        one.pixels()
            .zip(two.pixels())
            .map(|(a, b)| f64::from(a.0[0]).sqrt() - f64::from(b.0[0]).sqrt())
            .map(f64::abs)
            .sum::<f64>()
    };
    assert!(apart(&first, &other) > 10.0 * apart(&first, &next), "{} {}", apart(&first, &other), apart(&first, &next));
}

#[test]
fn rooms_that_share_a_wall_s_line_have_one_wall_there() {
    let scene = black_room("[[building.room]]\nx_m = 3.9\ny_m = 0.0\nwidth_m = 4.0\ndepth_m = 3.0\n");
    let building = Building::new(&scene, &DrawnPlace::draw(&scene, 0));
    for y_m in [0.0, 3.0] {
        let along =
            |panel: &&Panel| (panel.corner.y - y_m).abs() < 1e-9 && panel.along.y.abs() < 1e-9 && panel.corner.z > 0.0;
        let total_m: f64 = building.walls().filter(along).map(|panel| panel.along.norm()).sum();
        assert!((total_m - 7.9).abs() < 1e-6, "{total_m} m of wall above the skirting at y = {y_m}, expected 7.9");
    }
    // Rooms that stand back to back keep both of their walls.
    let scene = black_room("[[building.room]]\nx_m = 4.0\ny_m = 0.0\nwidth_m = 4.0\ndepth_m = 3.0\n");
    let building = Building::new(&scene, &DrawnPlace::draw(&scene, 0));
    let between =
        |panel: &&Panel| (panel.corner.x - 4.0).abs() < 1e-9 && panel.along.x.abs() < 1e-9 && panel.corner.z > 0.0;
    assert_eq!(building.walls().filter(between).count(), 2);
}

#[test]
fn a_floor_camera_under_lamps_sees_the_light_that_falls_there() {
    // The bulb hangs over x = 1: the floor has 25 lx below it, and 8.84 lx 2 m aside. The floor is screed, which has no texture, so that the image's
    // mean shows the light alone.
    let scene = black_room(
        "[[lamp]]\nkind = \"point\"\nx_m = 1.0\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\n\
         spectrum = \"monochrome\"\n",
    );
    let mut renderer = renderer();
    let world = renderer.upload(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let mut look = |x: f64| {
        let view = View {
            illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
            shows: Shows::Floor,
            ..quiet_view(Lens::ideal([64, 64], 64.0), vec![looking_down(x, 1.5, 0.25)], 50.0)
        };
        renderer.draw(&world, &[view]).unwrap().remove(0)
    };
    let mean = |image: &GrayImage, columns: std::ops::Range<u32>| {
        let places = columns.clone().flat_map(|u| (0..64).map(move |v| (u, v)));
        places.map(|(u, v)| level(image, u, v)).sum::<f64>() / (64.0 * f64::from(columns.end - columns.start))
    };
    for (x, lux) in [(1.0, 25.0), (3.0, 8.839)] {
        let (seen, expected) = (mean(&look(x), 0..64), 50.0 * 0.4 * lux / PI);
        assert!((seen / expected - 1.0).abs() < 0.01, "{seen}, expected {expected}");
    }
    // By hand, the light on the floor falls off at x = 3 with the slope d ln E/dx = −3·2/(4 + 2²) per metre; the middles of the picture's two halves
    // are 0.125 m apart.
    let image = look(3.0);
    let slope = (mean(&image, 32..64) / mean(&image, 0..32)).ln() / 0.125;
    assert!((slope / -0.75 - 1.0).abs() < 0.05, "{slope} per metre, expected -0.75");
}

#[test]
fn a_floor_camera_sees_the_edge_of_a_carpet() {
    let carpet = "[light]\nunevenness_ratio = 1.0\n[[floor.region]]\nname = \"carpet\"\nx_m = [1.0, 2.0]\n\
                  y_m = [1.0, 2.0]\nfriction = 0.7\ncovering = \"carpet\"\n";
    let scene = black_room(carpet);
    let mut renderer = renderer();
    let world = renderer.upload(&scene, &Drawn::draw(&scene, 0)).unwrap();
    // The picture is 0.2 m wide and high, with the carpet's edge at x = 2 in the middle.
    let lens = Lens::ideal([64, 64], 80.0);
    let view = View {
        illuminance_at_floor_lux: 100.0,
        shows: Shows::Floor,
        ..quiet_view(lens, vec![looking_down(2.0, 1.5, 0.25)], 15.0)
    };
    let image = renderer.draw(&world, &[view]).unwrap().remove(0);
    let row: Vec<f64> = (0..64).map(|u| level(&image, u, 32)).collect();
    // Screed has albedo 0.4, and the carpet 0.22.
    assert!((row[10] / row[53] - 0.22 / 0.4).abs() < 0.02, "{} to {}", row[10], row[53]);
    let edge = row.iter().position(|level| *level > (row[10] + row[53]) / 2.0).unwrap();
    assert!((31..=33).contains(&edge), "{edge}");
}

#[test]
fn books_stand_in_the_upright_faces_of_furniture_alone_and_each_number_shows_others() {
    let shelf = |books: &str| {
        let piece = "[[furniture]]\nx_m = 2.0\ny_m = 2.7\nsize_m = [1.6, 0.3]\nheight_m = 1.8\nalbedo = 0.4\n";
        black_room(&format!("{piece}{books}"))
    };
    let lens = || Lens::ideal([160, 120], 110.0);
    // From 1.4 m ahead of the front, 2 m of which are in view; and from above the top, which is 0.5 m below and wholly fills the picture's middle.
    let level_rad = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -0.5 * PI);
    let ahead = || quiet_view(lens(), vec![Isometry3::from_parts(Translation3::new(2.0, 1.15, 0.9), level_rad)], 3.0);
    let above = || quiet_view(lens(), vec![looking_down(2.0, 2.7, 2.3)], 3.0);
    // Mean and standard deviation within half of the picture's width and a quarter of its height.
    let statistics = |image: &GrayImage| {
        let levels = (40..120).flat_map(|u| (45..75).map(move |v| [u, v])).map(|[u, v]| level(image, u, v));
        let levels: Vec<f64> = levels.collect();
        let mean = levels.iter().sum::<f64>() / levels.len() as f64;
        (mean, (levels.iter().map(|level| (level - mean).powi(2)).sum::<f64>() / levels.len() as f64).sqrt())
    };
    let [plain, three, four] = ["", "books = 3\n", "books = 4\n"].map(|books| draw(&shelf(books), ahead()));
    let (plain_mean, plain_sd) = statistics(&plain);
    assert!(plain_mean > 15.0 && plain_sd < 0.1 * plain_mean, "{plain_mean} ± {plain_sd}");
    for image in [&three, &four] {
        let (mean, sd) = statistics(image);
        assert!((0.75..1.25).contains(&(mean / plain_mean)), "{mean} in place of {plain_mean}");
        assert!(sd > 0.3 * mean, "{mean} ± {sd}");
    }
    let off = three.iter().zip(four.iter()).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / three.len() as f64;
    assert!(off > 0.1 * plain_mean, "{off}");
    let tops = ["", "books = 3\n"].map(|books| statistics(&draw(&shelf(books), above())));
    assert!((tops[0].0 / tops[1].0 - 1.0).abs() < 0.02 && tops[1].1 < 0.1 * tops[1].0, "{tops:?}");
}

#[test]
fn both_renderers_see_the_edge_of_a_turned_carpet_where_it_lies() {
    // A carpet of 1 m by 0.6 m, turned by 30° about its middle: the middle of its far edge is at (2, 1.5), in the middle of the picture.
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let [x_m, y_m] = [2.0 - 0.5 * cos, 1.5 - 0.5 * sin];
    let carpet = format!(
        "[light]\nunevenness_ratio = 1.0\n[[floor.region]]\nname = \"carpet\"\nx_m = [{}, {}]\ny_m = [{}, {}]\n\
         rotation_deg = 30\nfriction = 0.7\ncovering = \"carpet\"\n",
        x_m - 0.5,
        x_m + 0.5,
        y_m - 0.3,
        y_m + 0.3
    );
    let scene = black_room(&carpet);
    let mut renderer = renderer();
    for shows in [Shows::Floor, Shows::Room] {
        let drawn = Drawn::draw(&scene, 0);
        let world = match shows {
            Shows::Floor => renderer.upload(&scene, &drawn).unwrap(),
            _ => renderer.upload_room(&scene, &drawn).unwrap(),
        };
        let view = View {
            illuminance_at_floor_lux: 100.0,
            shows,
            ..quiet_view(Lens::ideal([64, 64], 80.0), vec![looking_down(2.0, 1.5, 0.075)], 15.0)
        };
        let image = renderer.draw(&world, &[view]).unwrap().remove(0);
        // The picture is 0.06 m wide and high, and shows nothing of the carpet but its dark border. Blocks of 8 × 8 pixels beside the edge are carpet
        // or screed; a carpet's pile varies from pixel to pixel.
        let (mut carpet, mut screed) = (Vec::new(), Vec::new());
        for (u, v) in (0..64).step_by(8).flat_map(|u| (0..64).step_by(8).map(move |v| (u, v))) {
            let pixels = (0..64).map(|k| level(&image, u + k % 8, v + k / 8));
            let block = pixels.sum::<f64>() / 64.0;
            let beyond_px = (f64::from(u) - 28.0) * cos - (f64::from(v) - 28.0) * sin;
            // Corners of a block are up to 5.7 pixels from its middle.
            match beyond_px {
                beyond_px if beyond_px < -5.7 => carpet.push(block),
                beyond_px if beyond_px > 5.7 => screed.push(block),
                _ => {}
            }
        }
        let mean = |levels: &[f64]| levels.iter().sum::<f64>() / levels.len() as f64;
        let between = (mean(&carpet) + mean(&screed)) / 2.0;
        assert!(carpet.len() > 20 && screed.len() > 20);
        assert!(carpet.iter().all(|level| *level < between), "{shows:?}: {carpet:?}");
        assert!(screed.iter().all(|level| *level > between), "{shows:?}: {screed:?}");
        // The albedos are 0.22 and 0.4, and the border is darker than the carpet's mean.
        assert!(mean(&carpet) / mean(&screed) < 0.65, "{shows:?}: {} and {}", mean(&carpet), mean(&screed));
    }
}

#[test]
fn a_person_stands_before_the_wall_where_the_projection_puts_head_and_feet() {
    let scene = black_room("[light]\nilluminance_at_floor_lux = 200\n[floor.tiles]\n");
    let mut renderer = renderer();
    let mut world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let person = UprightBody {
        middle_m: [3.0, 1.5],
        heading_rad: PI,
        height_m: 1.75,
        radius_m: 0.23,
        stride: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    world.place_bodies(&[person]);
    // The camera looks along world x from (0.5, 1.5, 0.9), with image right along −y.
    let columns = nalgebra::Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let rotation = UnitQuaternion::from_matrix(&columns);
    let pose = Isometry3::from_parts(Translation3::new(0.5, 1.5, 0.9), rotation);
    let lens = Lens::ideal([320, 320], 300.0);
    let view = View { illuminance_at_floor_lux: 200.0, ..quiet_view(lens, vec![pose], 20.0) };
    let image = renderer.draw(&world, &[view]).unwrap().remove(0);
    // The walls are black, so that the topmost lit pixel of the image's middle column shows the crown of the person's head, 0.85 m above the camera's
    // axis at 2.5 m.
    let crown = (0..320).find(|v| level(&image, 159, *v) > 2.0).unwrap();
    let expected = 159.5 - 300.0 * 0.85 / 2.5;
    assert!((f64::from(crown) - expected).abs() < 3.0, "{crown}, expected {expected}");
    // In the row at the height of the shoulders only the body is lit.
    let row = 159 - (300.0 * (0.79 * 1.75 - 0.9) / 2.5) as u32;
    let lit = (0..320).filter(|u| level(&image, *u, row) > 2.0).count() as f64;
    assert!((lit / (300.0 * 0.46 / 2.5) - 1.0).abs() < 0.35, "{lit} px wide");
}

/// Pose of a camera at (0.5, 1.5, 1.6) that looks along world x, with image right along −y.
pub(crate) fn looking_ahead() -> Isometry3<f64> {
    let columns = nalgebra::Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    Isometry3::from_parts(Translation3::new(0.5, 1.5, 1.6), UnitQuaternion::from_matrix(&columns))
}

/// Mean and variance of places on a line, each given with its weight.
pub(crate) fn spread(places: impl Iterator<Item = (f64, f64)> + Clone) -> (f64, f64) {
    let sum: f64 = places.clone().map(|(_, weight)| weight).sum();
    let mean = places.clone().map(|(at, weight)| at * weight).sum::<f64>() / sum;
    (mean, places.map(|(at, weight)| (at - mean).powi(2) * weight).sum::<f64>() / sum)
}

#[test]
fn a_person_who_walks_is_smeared_by_the_way_over_the_ground_sampling_distance() {
    let scene = black_room("[light]\nilluminance_at_floor_lux = 200\n[floor.tiles]\n");
    let mut renderer = renderer();
    let mut world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    // The person walks across the camera's view. The test looks at the neck, which does not swing as legs and arms do.
    let walker = |from_middle_m: f64, speed_m_per_s: f64| UprightBody {
        middle_m: [3.0, 1.5 + from_middle_m],
        heading_rad: -PI / 2.0,
        height_m: 1.75,
        radius_m: 0.23,
        stride: 0.0,
        velocity_m_per_s: [0.0, -speed_m_per_s],
    };
    let lens = Lens::ideal([320, 320], 300.0);
    // Grey levels along the image row that shows the person's neck. No pixel may be saturated: the picture of a person at rest would then lack light
    // that motion spreads, and a smear of 12 px would be measured as 14 px.
    let mut along_row = |from_middle_m: f64, speed_m_per_s: f64| {
        world.place_bodies(&[walker(from_middle_m, speed_m_per_s)]);
        let view = View { illuminance_at_floor_lux: 200.0, ..quiet_view(lens.clone(), vec![looking_ahead()], 6.0) };
        let image = renderer.draw(&world, &[view]).unwrap().remove(0);
        let row = 159 + (300.0 * (1.6 - 0.86 * 1.75) / 2.5) as u32;
        let levels = (0..320).map(|u| (f64::from(u), level(&image, u, row)));
        assert!(levels.clone().all(|(_, level)| level < 250.0), "white");
        assert!(levels.clone().any(|(_, level)| level > 30.0), "dark");
        spread(levels)
    };
    let pixel_m = 2.5 / 300.0;
    let still = along_row(0.0, 0.0).0;
    // The neck's image of a person at rest is up to a tenth of a pixel wider or narrower, depending on where it lies between pixels. Hence the
    // variance at rest is the mean over four positions.
    let still_variance =
        [0.0, 0.25, 0.5, 0.75].map(|shift_px| along_row(shift_px * pixel_m, 0.0).1).iter().sum::<f64>() / 4.0;
    for speed_m_per_s in [0.2, 0.4] {
        let (middle, variance) = along_row(0.0, speed_m_per_s);
        // In half a second of exposure at 0.2 m/s the person walks 12 px, and at the end of the exposure is where a person at rest is seen.
        let way_px = 0.5 * speed_m_per_s / pixel_m;
        assert!((still - middle - way_px / 2.0).abs() < 0.02 * way_px, "{still} px, {middle} px");
        // A steady motion smears the neck by a box whose length is the way in pixels, which adds way²/12 to its variance.
        let measured_px = (12.0 * (variance - still_variance)).sqrt();
        assert!((measured_px / way_px - 1.0).abs() < 0.02, "{measured_px} px, expected {way_px}");
    }
}

#[test]
fn the_shadow_of_a_person_who_walks_is_smeared_as_the_person_is() {
    // The bulb is at (0.5, 1.5), and the person 1 m from it: on the floor 1.6 m from the bulb the shadow moves 1.6 times as far as the person.
    let scene = black_room(
        "[[lamp]]\nkind = \"point\"\nx_m = 0.5\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\nspectrum = \"monochrome\"\n",
    );
    let mut renderer = renderer();
    let mut world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let lens = Lens::ideal([320, 320], 240.0);
    // The camera looks straight down on the floor around (2.1, 1.5), with image right along world y; from 1.2 m a metre takes 200 px.
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), PI / 2.0) * down;
    let pose = Isometry3::from_parts(Translation3::new(2.1, 1.5, 1.2), turned);
    let mut darkness = |velocity_m_per_s: Option<f64>| {
        let walker = |speed: f64| UprightBody {
            middle_m: [1.5, 1.5],
            heading_rad: PI / 2.0,
            height_m: 1.75,
            radius_m: 0.15,
            stride: 0.0,
            velocity_m_per_s: [0.0, speed],
        };
        world.place_bodies(&velocity_m_per_s.map(walker).into_iter().collect::<Vec<_>>());
        let view = View {
            illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
            ..quiet_view(lens.clone(), vec![pose], 60.0)
        };
        let image = renderer.draw(&world, &[view]).unwrap().remove(0);
        (0..320).map(|u| (f64::from(u), (156..164).map(|v| level(&image, u, v)).sum::<f64>())).collect::<Vec<_>>()
    };
    let lit = darkness(None);
    let mut shadow = |speed: f64| {
        let levels = darkness(Some(speed));
        spread(lit.iter().zip(&levels).map(|((u, lit), (_, left))| (*u, 1.0 - left / lit)))
    };
    let (still, walking) = (shadow(0.0), shadow(0.5));
    // In half a second of exposure at 0.5 m/s the person walks 0.25 m, so that the shadow moves 0.4 m and ends where it is when the person stands
    // still.
    let way_px = 1.6 * 0.25 * 200.0;
    assert!((still.0 - walking.0 - way_px / 2.0).abs() < 0.03 * way_px, "{still:?}, {walking:?}");
    let measured_px = (12.0 * (walking.1 - still.1)).sqrt();
    assert!((measured_px / way_px - 1.0).abs() < 0.05, "{measured_px} px, expected {way_px}");
}

#[test]
fn a_slat_of_a_pixel_or_less_covers_its_share_of_every_row() {
    let slat = |width_m: f64, y_m: f64| {
        black_room(&format!(
            "[[lamp]]\nkind = \"panel\"\nx_m = 1.5\ny_m = 1.5\nlumens = 2000\n[[furniture]]\nname = \"slat\"\nx_m = 3.005\n\
             y_m = {y_m}\nsize_m = [0.01, {width_m}]\nheight_m = 2.2\nalbedo = 0.6\n"
        ))
    };
    // The picture's rows reach from 0.5 m above the camera's axis to 0.4 m below; with 75 px of focal length at 2.5 m, a metre takes 30 px.
    let lens = Lens::ideal([96, 64], 75.0);
    // The camera that looks at the upright slat is upright, and then rolled by 0.3 rad, so that the slat's edges run across columns.
    for roll_rad in [0.0_f64, 0.3] {
        let pose = looking_ahead() * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll_rad);
        let look = |scene: &Scene| draw(scene, quiet_view(lens.clone(), vec![pose], 6.0));
        let wide = look(&slat(0.4, 1.5));
        let shapes = [(0.3, 0.1), (0.3, 0.5), (0.8, 0.0), (1.2, 0.4), (1.6, 0.25), (1.9, 0.7), (2.3, 0.2), (3.0, 0.6)];
        for (width_px, aside_px) in shapes {
            let image = look(&slat(width_px / 30.0, 1.5 + aside_px / 30.0));
            for v in [18, 25, 32, 43] {
                let axis = 47.5 + (f64::from(v) - 31.5) * roll_rad.tan();
                let full = level(&wide, axis as u32, v);
                let seen_px = (0..96).map(|u| level(&image, u, v)).sum::<f64>() / full * roll_rad.cos();
                // Tolerance of the slat's measured width: rounding by half a level in each of four pixels, of 180 levels, and 1 % of the width.
                let most = 0.012 + 0.01 * width_px;
                assert!((seen_px - width_px).abs() < most, "{width_px} px, row {v}, roll {roll_rad}: {seen_px} px");
            }
        }
    }
}

#[test]
fn rows_of_a_rolling_shutter_see_walls_that_reach_beyond_the_picture_where_they_then_are() {
    // A chessboard of 8 by 8 squares of 0.16 m hangs on a wall that fills the picture; its lines are every 0.16 m to both sides of x = 2.
    let scene = black_room(
        "[[building.picture]]\nfrom_m = [2.8, 3.0]\nto_m = [1.2, 3.0]\nbottom_m = 0.5\nheight_m = 1.6\nchessboard = [8, 8]\n\
         [[lamp]]\nkind = \"panel\"\nx_m = 2.0\ny_m = 1.5\nlumens = 2000\n",
    );
    let (rate_rad_per_s, row_time_s, exposure_s, focal_px) = (1.5, 40e-6, 0.0005, 417.0);
    let total_s = exposure_s + 479.0 * row_time_s;
    let level_ahead =
        UnitQuaternion::from_matrix(&nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0));
    // The chessboard's face lies 2 cm before the wall.
    for (before_m, height_m) in [(0.48, 1.3), (0.48, 1.5), (0.98, 1.3)] {
        let pose_at = |time_s: f64| {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rate_rad_per_s * (time_s - total_s / 2.0));
            Isometry3::from_parts(Translation3::new(2.0, 2.98 - before_m, height_m), turn * level_ahead)
        };
        let poses = (0..=16).map(|index| pose_at(total_s * f64::from(index) / 16.0)).collect();
        let mut view = quiet_view(Lens { row_time_s, ..Lens::ideal([640, 480], focal_px) }, poses, 3.0);
        let slower = view.exposure_s / exposure_s;
        view.exposure_s = exposure_s;
        view.sensor.quantum_efficiency *= slower;
        let image = draw(&scene, view);
        let mut n_seen = 0;
        for line in -3..=3 {
            let bearing_rad = (0.16 * f64::from(line) / before_m).atan();
            let mut errors_px = Vec::new();
            for v in 2..478 {
                // The camera turns to the left while the rows are read out, so that what is ahead moves to the right in the image; by hand, the
                // column of a line of the chessboard in row v.
                let turned_rad = rate_rad_per_s * row_time_s * (f64::from(v) - 239.5);
                let expected = 319.5 + focal_px * (bearing_rad + turned_rad).tan();
                let depth_m = before_m / bearing_rad.cos() * (bearing_rad + turned_rad).cos();
                let squares = (height_m - (f64::from(v) - 239.5) * depth_m / focal_px - 0.5) / 0.16;
                // Rows are skipped in which squares of the chessboard meet at their corners, because no line between light and dark is seen there.
                if !(16.0..624.0).contains(&expected) || (squares - squares.round()).abs() < 0.05 {
                    continue;
                }
                let first = expected.round() as u32 - 9;
                let row: Vec<f64> = (first..first + 19).map(|u| level(&image, u, v)).collect();
                let [low, high] = [&row[..4], &row[15..]].map(|part| part.iter().sum::<f64>() / 4.0);
                // Pixels beyond the chessboard's last squares show no contrast between the two sides of the line, and are left out.
                if (high - low).abs() < 40.0 {
                    continue;
                }
                let before: f64 = row.iter().map(|seen| 1.0 - (seen - low) / (high - low)).sum();
                let seen = f64::from(first) - 0.5 + before;
                errors_px.push(seen - expected);
            }
            // Photon noise and rounding scatter the measured column of a line in a row by 0.02 px.
            for errors_px in errors_px.chunks(20) {
                let mean_px = errors_px.iter().sum::<f64>() / errors_px.len() as f64;
                assert!(mean_px.abs() < 0.1, "{before_m} m, line {line}: {mean_px} px off");
            }
            n_seen += errors_px.len();
        }
        assert!(n_seen > 800, "{n_seen}");
    }
}

#[test]
fn a_lamp_is_mirrored_where_its_image_below_the_floor_lies_unless_something_stands_between() {
    let tiles = "[floor.tiles]\npattern = \"plain\"\nedge_x_m = 5.0\nedge_y_m = 5.0\njoint_width_m = 0.001\n\
                 [[lamp]]\nkind = \"panel\"\nx_m = 3.0\ny_m = 1.5\nheight_m = 1.2\nsize_m = [0.1, 0.1]\nlumens = 300\n";
    let board =
        "[[furniture]]\nname = \"board\"\nx_m = 2.6\ny_m = 1.5\nsize_m = [0.1, 1.0]\nheight_m = 1.1\nalbedo = 0.0\n";
    let lens = Lens::ideal([321, 481], 300.0);
    // The eye is 0.6 m above the floor and 2.5 m before the lamp, whose mirror image lies 1.8 m below the eye.
    let pose = Isometry3::from_parts(Translation3::new(0.5, 1.5, 0.6), looking_ahead().rotation);
    let expected_v = 240.0 + 300.0 * 1.8 / 2.5;
    let look = |more: &str| {
        let scene = black_room(&format!("{tiles}{more}"));
        let image = draw(&scene, quiet_view(lens.clone(), vec![pose], 1.0));
        (400..480).map(|v| level(&image, 160, v)).collect::<Vec<f64>>()
    };
    let open = look("");
    let glint = open.iter().zip(400..).map(|(seen, v)| ((seen - 5.0).max(0.0), f64::from(v)));
    let (sum, moment) = glint.fold((0.0, 0.0), |(sum, moment), (seen, v)| (sum + seen, moment + seen * v));
    assert!(open.iter().copied().fold(0.0, f64::max) > 50.0, "{open:?}");
    assert!((moment / sum - expected_v).abs() < 2.0, "{}, expected {expected_v}", moment / sum);
    // The board hides the lamp's reflection: the ray from the floor to the lamp passes the board's place 0.91 m above the floor, and the board is 1.1
    // m high.
    let hidden = look(board);
    assert!(hidden.iter().all(|seen| *seen < 5.0), "{hidden:?}");
}

#[test]
fn a_floor_camera_sees_shadows_end_where_similar_triangles_put_them() {
    let lamp = "[[lamp]]\nkind = \"point\"\nx_m = 1.0\ny_m = 1.5\nheight_m = 2.0\nlumens = 1256.637\nspectrum = \"monochrome\"\n";
    let board =
        "[[furniture]]\nname = \"board\"\nx_m = 2.55\ny_m = 1.5\nsize_m = [0.1, 1.0]\nheight_m = 0.5\nalbedo = 0.0\n";
    let person = UprightBody {
        middle_m: [2.2, 1.5],
        heading_rad: 0.0,
        height_m: 1.0,
        radius_m: 0.2,
        stride: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    // The picture is 0.4 m wide, with 200 px to the metre. The lamp's ray past the board's far edge, 0.5 m high at x = 2.6, reaches the floor
    // 1.6·2/1.5 m from the lamp, which is 2 m high.
    let lens = Lens::ideal([80, 80], 50.0);
    let ends_m = 1.0 + 1.6 * 2.0 / 1.5;
    let look = |more: &str, bodies: &[UprightBody], x_m: f64| {
        let scene = black_room(&format!("{lamp}{more}"));
        let mut renderer = renderer();
        let mut world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
        world.place_bodies(bodies);
        let view = View {
            illuminance_at_floor_lux: world.illuminance_at_floor_lux().unwrap(),
            shows: Shows::Floor,
            ..quiet_view(lens.clone(), vec![looking_down(x_m, 1.5, 0.25)], 150.0)
        };
        let image = renderer.draw(&world, &[view]).unwrap().remove(0);
        (0..80).map(|u| level(&image, u, 40)).collect::<Vec<f64>>()
    };
    let (open, shaded) = (look("", &[], ends_m), look(board, &[], ends_m));
    let share: Vec<f64> = shaded.iter().zip(&open).map(|(shaded, open)| shaded / open).collect();
    assert!(
        share[..30].iter().all(|share| *share < 0.02) && share[52..].iter().all(|share| *share > 0.97),
        "{share:?}"
    );
    let dark_px: f64 = share.iter().map(|share| 1.0 - share).sum();
    assert!((dark_px - 40.0).abs() < 4.0, "{dark_px} px dark, expected 40 as the shadow ends in the middle");
    // The floor behind a person who stands between lamp and camera's view is dark too: a person 1 m high casts a shadow as far as x = 1 + 1.4·2/1 m.
    let behind = look("", &[person], ends_m);
    assert!(behind.iter().zip(&open).all(|(behind, open)| *behind < 0.1 * open), "{behind:?}");
}

#[test]
fn people_and_lamps_show_in_infrared_as_their_light_and_albedo_have_it() {
    let panel = |x_m: f64| {
        format!(
            "[[lamp]]\nkind = \"panel\"\nx_m = {x_m}\ny_m = 1.5\nsize_m = [0.6, 0.6]\nlumens = 500\nspectrum = \"incandescent\"\n"
        )
    };
    // One lamp panel is in the camera's view, and one behind the camera lights the person's front.
    let scene = black_room(&(panel(3.4) + &panel(0.5)));
    let mut renderer = renderer();
    let mut world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    world.place_bodies(&[UprightBody {
        middle_m: [2.5, 1.0],
        heading_rad: PI,
        height_m: 1.75,
        radius_m: 0.23,
        stride: 0.0,
        velocity_m_per_s: [0.0; 2],
    }]);
    let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
    // The tested pixels, for a focal length of 150 px: the person's shirt, 0.3 m below the eye, is 22 px below the middle of the picture, and the
    // lamp 51 px above it.
    let mut level_at = |band: Band, [u, v]: [u32; 2], levels: f64| {
        let lens = Lens { band, ..Lens::ideal([320, 320], 150.0) };
        let view = View { illuminance_at_floor_lux, ..quiet_view(lens, vec![looking_ahead()], levels) };
        let image = renderer.draw(&world, &[view]).unwrap().remove(0);
        let around = (0..25).map(|index| level(&image, u - 2 + index % 5, v - 2 + index / 5)).sum::<f64>() / 25.0;
        assert!((20.0..250.0).contains(&around), "{band:?} {u} {v}: {around} levels");
        around / levels
    };
    let mut ratio = |pixel: [u32; 2], levels: [f64; 2]| {
        level_at(Band::Infrared, pixel, levels[1]) / level_at(Band::Visible, pixel, levels[0])
    };
    let lamp = ratio([159, 105], [0.1, 0.05]);
    let shirt = ratio([197, 182], [8.0, 3.0]);
    let photons = Photons::of(Spectrum::Incandescent);
    let expected = photons.infrared / photons.visible;
    assert!((lamp / expected - 1.0).abs() < 0.03, "lamp {lamp}, expected {expected}");
    // The person's shirt reflects 0.35 of visible light and 0.55 of infrared. Walls that are black to the eye throw some infrared on it as well, so
    // that its level may be higher.
    let own = shirt / expected / (0.55 / 0.35);
    assert!((0.97..1.6).contains(&own), "shirt {shirt}, light {expected}");
}
