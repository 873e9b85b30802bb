//! Tests of calibration from rendered images: intrinsics from a chessboard, and the position of a camera from spins under a marker.

use std::{
    f64::consts::{PI, TAU},
    fs,
};

use image::GrayImage;
use localizer::{
    Pose,
    baselines::least_squares,
    calibration::{
        chessboard::{self, Bend, Corner, corners},
        mount_offset,
    },
    markers::dot_in_marker_m,
    reading::Camera,
    vision::ceiling::{self, CeilingView, PictureMotion},
};
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};
use sim::{
    loading::SceneFile,
    optics::{Exposure, Lens},
    render::{NoiseKey, Shows, View},
    scene::{Scene, SensorPreset},
    world::Drawn,
};

use crate::{
    command::{folder, outcome, wherein},
    render_studio::{exposed, renderer},
};

const FOCAL_PX: [f64; 2] = [755.139, 753.926];
const CENTRE_PX: [f64; 2] = [320.252, 239.661];
const DISTORTION: [f64; 2] = [-0.12, 0.05];
/// A chessboard of 12 × 9 squares of 25 mm within a margin of one square.
const BOARD: corners::Board = corners::Board { columns: 12, rows: 9, square_m: 0.025 };
const BOARD_MIDDLE_M: [f64; 3] = [2.0, 2.98, 1.2];

/// A lit room with the chessboard on the wall at y = 3 as a picture that stands out by 2 cm.
fn room_with_board() -> Scene {
    let text = "[room]\nwidth_m = 4.0\ndepth_m = 3.0\n[start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n\
                [light]\nilluminance_at_floor_lux = 300\n[[building.picture]]\nfrom_m = [1.825, 3.0]\nto_m = [2.175, 3.0]\n\
                bottom_m = 1.0625\nheight_m = 0.275\nchessboard = [12, 9]\n";
    Scene::parse(text, "board.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

/// Pose of the camera for one view of the board. In the camera frame the board's middle lies slightly aside, slightly below and at some depth; the
/// board is rolled, and leans by `lean_rad` about an axis of the image plane.
fn before_board(index: usize) -> Isometry3<f64> {
    let share = index as f64 / 20.0;
    let (course, roll) =
        (TAU * share * 3.0, 0.5 * (TAU * share * 7.0).sin() + if index % 5 == 4 { PI / 2.0 } else { 0.0 });
    let lean_rad = 0.35 + 0.25 * (index % 3) as f64;
    let lean = Rotation3::new(vector![course.cos(), course.sin(), 0.0] * lean_rad);
    let camera_from_board = lean * Rotation3::from_axis_angle(&Vector3::z_axis(), roll);
    let depth = 0.62 + 0.04 * (index % 4) as f64;
    let place = vector![0.04 * (TAU * share * 2.0).cos(), 0.02 * (TAU * share * 5.0).sin(), depth];
    let camera_from_board =
        Isometry3::from_parts(place.into(), UnitQuaternion::from_rotation_matrix(&camera_from_board));
    // Frame of the chessboard on the wall: x is world x, from left to right for a viewer in the room, y is down, and z points into the wall, towards
    // greater world y.
    let columns = nalgebra::Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
    let world_from_board =
        Isometry3::from_parts(Translation3::from(Vector3::from(BOARD_MIDDLE_M)), UnitQuaternion::from_matrix(&columns));
    world_from_board * camera_from_board.inverse()
}

/// Images of the board with a sensor's noise.
fn board_pictures(n_views: usize) -> Vec<GrayImage> {
    let scene = room_with_board();
    let [k1, k2] = DISTORTION;
    let lens = Lens {
        focal_px: FOCAL_PX,
        principal_point_px: CENTRE_PX,
        distortion: [k1, k2, 0.0, 0.0, 0.0],
        vignetting: true,
        ..Lens::ideal([640, 480], 1.0)
    };
    let sensor = SensorPreset::GlobalShutter.model();
    let mut renderer = renderer();
    let world = renderer.upload_room(&scene, &Drawn::draw(&scene, 0)).unwrap();
    let illuminance_at_floor_lux = world.illuminance_at_floor_lux().unwrap();
    let view = |index: usize| View {
        shows: Shows::Room,
        sensor,
        world_from_camera: vec![before_board(index)],
        exposure_s: 0.0,
        gain_levels_per_electron: 0.0,
        illuminance_at_floor_lux,
        noise: NoiseKey { seed: 11, image: index as u32 },
        lens: lens.clone(),
    };
    // White paper of albedo 0.85 is exposed to some 200 grey levels, under the 300 lx that light the walls here.
    let exposure_s = 0.01;
    let gain = 200.0 / (0.85 * 300.0 / PI * sensor.electrons_per_luminance(exposure_s));
    let exposure = Exposure { exposure_s, gain_levels_per_electron: gain };
    let views: Vec<View> = (0..n_views).map(|index| exposed(view(index), exposure)).collect();
    renderer.draw(&world, &views).unwrap()
}

#[test]
fn twenty_rendered_views_of_a_chessboard_give_the_intrinsics_within_a_thousandth() {
    let pictures = board_pictures(20);
    let saturated = pictures.iter().flat_map(|picture| picture.as_raw()).filter(|level| **level == 255).count();
    assert!(saturated < 1000, "{saturated} pixels are white beyond measure");
    let found: Vec<Option<Vec<Corner>>> = pictures.iter().map(|picture| corners::find(picture, &BOARD)).collect();
    let missed: Vec<usize> = (0..20).filter(|index| found[*index].is_none()).collect();
    assert!(missed.is_empty(), "no board in pictures {missed:?}");
    let views: Vec<Vec<Corner>> = found.into_iter().flatten().collect();
    let calibration = chessboard::calibrate(&views, Bend::Radial).unwrap();
    println!("{calibration:?}");
    let intrinsics = calibration.intrinsics;
    for axis in 0..2 {
        let (focal_px, centre_px) = (intrinsics.focal_px[axis], intrinsics.centre_px[axis]);
        assert!((focal_px / FOCAL_PX[axis] - 1.0).abs() < 0.001, "focal length {focal_px}, {calibration:?}");
        assert!((centre_px - CENTRE_PX[axis]).abs() < 0.001 * FOCAL_PX[axis], "centre {centre_px}, {calibration:?}");
        let coefficient = intrinsics.distortion[axis];
        assert!((coefficient - DISTORTION[axis]).abs() < 0.06, "k {coefficient}, {calibration:?}");
    }
    assert!(calibration.rms_px < 0.1, "{calibration:?}");
}

#[test]
fn the_command_declares_a_camera_that_pictures_of_a_board_show() {
    let place = folder("board");
    let names: Vec<String> = (0..20).map(|index| format!("{index}.png")).collect();
    for (picture, name) in board_pictures(20).iter().zip(&names) {
        picture.save(place.join(name)).unwrap();
    }
    let robot = "room = { width_m = 5.0, depth_m = 5.0 }\nstart = { x_m = 2.0, y_m = 2.0, heading_deg = 0.0 }\n[localizer]\nmethods = []\n\
                 [[route.waypoint]]\nx_m = 3.0\ny_m = 2.0\n";
    std::fs::write(place.join("robot.toml"), robot).unwrap();
    let board = ["calibrate", "board", "--board", "12x9", "--square-m", "0.025"];
    let pictures: Vec<&str> = names.iter().map(String::as_str).collect();
    let out = ["--robot", "robot.toml", "--out", "camera.toml"];
    let (code, told, errors) = outcome(&mut wherein(&place, &[&board, &pictures[..], &out].concat()));
    assert_eq!(code, 0, "{errors}");
    assert!(told.starts_with("20 views of the board in pictures of 640 × 480 px"), "{told}");
    let declared = Scene::load(&place.join("camera.toml")).unwrap().robot.ceiling_camera.unwrap();
    let calibration = &declared.calibration;
    for axis in 0..2 {
        let off = (declared.focal_px[axis] / FOCAL_PX[axis] - 1.0).abs();
        assert!(off < calibration.focal_tolerance && calibration.focal_tolerance < 0.004, "{told}");
        let off_px = (declared.principal_point_px[axis] - CENTRE_PX[axis]).abs();
        let within_px = calibration.principal_point_tolerance_px;
        assert!(off_px < within_px && within_px < 3.0, "{told}");
    }
    // What the coefficients say of a pixel in a corner of the image, by Brown's model for a radius r: f·r·(k₁r² + k₂r⁴).
    let radius = (320.0_f64 / 755.0).hypot(240.0 / 754.0);
    let bend_px = |k: [f64; 2]| 755.0 * radius * (k[0] * radius.powi(2) + k[1] * radius.powi(4));
    let [k1, k2, p1, p2, k3] = declared.lens.distortion;
    assert_eq!([p1, p2, k3], [0.0; 3]);
    let off_px = (bend_px([k1, k2]) - bend_px(DISTORTION)).abs();
    assert!(off_px < calibration.distortion_tolerance_px + 0.3, "{off_px} px, {told}");
    // What calibrates nothing is refused, and nothing is written.
    let few = [&board, &pictures[..3], &["--robot", "robot.toml", "--out", "few.toml"][..]].concat();
    let (code, _, errors) = outcome(&mut wherein(&place, &few));
    assert!(code == 2 && errors.contains("3 show all 12×9 squares, expected at least 6"), "{errors}");
    assert!(!place.join("few.toml").exists());
    let other = ["calibrate", "board", "--board", "11x8", "--square-m", "0.025", "0.png"];
    let (code, _, errors) = outcome(&mut wherein(&place, &other));
    assert!(code == 2 && errors.contains("expected at least 6; not in 0.png"), "{errors}");
}

/// Depth of the marker above the camera as declared: 2.599 m less 0.3 m.
const DEPTH_M: f64 = 2.299;

/// A room with a marker over (2, 1.5), and with a camera beside the axle whose position is uncertain by a centimetre.
///
/// The camera's tilt and principal point are known exactly. Under a level ceiling an error of either shifts the marker's image as an error of
/// position does, by 4 mm for 0.1° and 3 mm for 1 px, and turns with the robot as position does, so that no spin can separate them.
const SPINS: &str = "[room]\nwidth_m = 5.0\ndepth_m = 4.0\n[start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n\
                [light]\nilluminance_at_floor_lux = 20\n[robot]\nfloor_camera = false\n[robot.ceiling_camera]\n\
                forward_m = 0.08\nleft_m = 0.03\n[robot.ceiling_camera.sensor]\nexposure_s = 0.0003\n\
                [robot.ceiling_camera.calibration]\nposition_tolerance_m = 0.01\nangle_tolerance_deg = 0\n\
                focal_tolerance = 0\nprincipal_point_tolerance_px = 0\n\
                [markers]\nplacement_tolerance_m = 0\nrotation_tolerance_deg = 0\nprint_tolerance_m = 0\n\
                height_tolerance_m = 0\n[[markers.marker]]\nid = 125\nx_m = 2.0\ny_m = 1.5\nrotation_deg = 0\n";

fn room_with_marker() -> Scene {
    Scene::parse(SPINS, "spins.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

/// Position and heading of an upright ceiling camera, computed from the dots of a marker in its image.
fn stop_read(scene: &Scene, picture: &GrayImage) -> mount_offset::Stop {
    let (camera, map) = (scene.robot_model().ceiling_camera.unwrap(), scene.map().markers.unwrap());
    let view = CeilingView::new(755.0, [2.28, 2.31], 0.005, camera.electrons_per_grey);
    let seen = ceiling::detect(picture, &view, &map.coding.table(), &PictureMotion::default()).markers;
    assert_eq!(seen.len(), 1, "one marker hangs there");
    // Image down is robot forward, and image right is robot right.
    let pairs: Vec<([f64; 2], [f64; 2])> = seen[0]
        .dots
        .iter()
        .map(|(place, dot)| {
            let [x, y] = dot_in_marker_m(*place);
            let [u, v] = [0, 1].map(|axis| DEPTH_M * (dot.centre_px[axis] - CENTRE_PX[axis]) / FOCAL_PX[axis]);
            ([2.0 + x, 1.5 + y], [v, -u])
        })
        .collect();
    let Pose { x_m, y_m, heading_rad } = least_squares(&pairs).unwrap();
    [x_m, y_m, heading_rad]
}

#[test]
fn pictures_of_spins_declare_the_mount_that_took_them() {
    let place = folder("calibrated_mount");
    let scene = room_with_marker();
    fs::write(place.join("robot.toml"), SPINS).unwrap();
    let drawn = Drawn::draw(&scene, 3);
    let truth = drawn.devices.ceiling_camera.as_ref().unwrap().body_from_camera.translation;
    for spin in 0..2_u32 {
        fs::create_dir(place.join(format!("spin{spin}"))).unwrap();
        for stop in 0..8_u32 {
            let heading_rad = 0.4 * f64::from(spin) + TAU * f64::from(stop) / 8.0;
            let pose = Pose { x_m: 2.0 + 0.02 * f64::from(spin), y_m: 1.49, heading_rad };
            let views =
                sim::run::sensors::still::views_at(&scene, &drawn, pose, 20.0, &[Camera::Ceiling], u64::from(stop));
            let mut renderer = renderer();
            let world = renderer.upload_room(&scene, &drawn).unwrap();
            renderer.draw(&world, &views).unwrap()[0].save(place.join(format!("spin{spin}/{stop}.png"))).unwrap();
        }
    }
    let command = ["calibrate", "mount", "spin0", "spin1", "--robot", "robot.toml", "--out", "mount.toml"];
    let (code, told, errors) = outcome(&mut wherein(&place, &command));
    assert_eq!(code, 0, "{told}{errors}");
    let found = SceneFile::load(&place.join("mount.toml")).unwrap().scene.robot.ceiling_camera.unwrap();
    let within_m = found.calibration.position_tolerance_m;
    // The true position is more than 1 mm from the declared one. Tilts add 1.4 mm: a body of 0.035° under a ceiling 2.3 m above the camera.
    let off_m = (found.forward_m - truth.x).abs().max((found.left_m - truth.y).abs());
    assert!(off_m < within_m && within_m < 0.005 && off_m < 0.001, "{off_m} m of {within_m} m: {told}");
    assert!((truth.x - 0.08).hypot(truth.y - 0.03) > 0.001, "{truth:?}");
    for (arguments, expected) in [
        (&["spin0", "--robot", "blind.toml"][..], "it has no `robot.ceiling_camera`"),
        (&["nowhere", "--robot", "robot.toml"], "read the spin nowhere"),
        (&["empty", "--robot", "robot.toml"], "in 0 a marker of the map is read, expected 8 at least"),
        (&["spin0", "--robot", "robot.toml", "--out", "robot.toml"], "it is the scene of the robot itself"),
    ] {
        fs::create_dir_all(place.join("empty")).unwrap();
        fs::write(place.join("blind.toml"), crate::command::blind_scene(1.0, "")).unwrap();
        let (code, _, errors) = outcome(&mut wherein(&place, &[&["calibrate", "mount"][..], arguments].concat()));
        assert!(code == 2 && errors.contains(expected), "{arguments:?}: {errors}");
    }
}

#[test]
fn five_rendered_spins_give_the_mount_to_half_a_millimetre_and_a_fifth_of_a_degree() {
    const N_STOPS: usize = 12;
    let scene = room_with_marker();
    for seed in [1, 2] {
        let drawn = Drawn::draw(&scene, seed);
        let pose = |stop: usize| {
            // For each of several spins the robot turns on the spot at another point and begins with another heading.
            let spin = (stop / N_STOPS) as f64;
            let (sin, cos) = (1.3 * spin).sin_cos();
            let heading_rad = 0.37 * spin + TAU * (stop % N_STOPS) as f64 / N_STOPS as f64;
            Pose { x_m: 2.0 + 0.02 * cos, y_m: 1.5 + 0.015 * sin, heading_rad }
        };
        let views: Vec<View> = (0..5 * N_STOPS)
            .flat_map(|stop| {
                sim::run::sensors::still::views_at(&scene, &drawn, pose(stop), 20.0, &[Camera::Ceiling], stop as u64)
            })
            .collect();
        let pictures = {
            let mut renderer = renderer();
            let world = renderer.upload_room(&scene, &drawn).unwrap();
            renderer.draw(&world, &views).unwrap()
        };
        let stops: Vec<mount_offset::Stop> = pictures.iter().map(|picture| stop_read(&scene, picture)).collect();
        let spins: Vec<Vec<mount_offset::Stop>> = stops.chunks(N_STOPS).map(<[_]>::to_vec).collect();
        let found = mount_offset::solve(&spins).unwrap();
        let truth = drawn.devices.ceiling_camera.as_ref().unwrap().body_from_camera.translation;
        let (radius_m, direction_rad) = (truth.x.hypot(truth.y), truth.y.atan2(truth.x));
        let off_m = found.radius_m() - radius_m;
        let off_deg = ((found.direction_rad() - direction_rad + PI).rem_euclid(TAU) - PI).to_degrees();
        println!("seed {seed}: radius {radius_m} m off by {off_m:e} m, direction by {off_deg}°, rms {} m", found.rms_m);
        assert!(off_m.abs() < 0.0005, "seed {seed}: {found:?}, truth {truth:?}");
        assert!(off_deg.abs() < 0.2, "seed {seed}: {off_deg}°, {found:?}, truth {truth:?}");
        // The camera's true position was drawn at random and is more than 1 mm from the declared one, so that a calibration that only returned the
        // declared position would fail this test.
        assert!((truth.x - 0.08).hypot(truth.y - 0.03) > 0.001, "seed {seed}: {truth:?}");
    }
}
