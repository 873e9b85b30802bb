//! Errors that are drawn once and stay the same throughout a run: they stay inside their tolerance, they fill it or lie at its ends, and each is
//! drawn from its own stream of random numbers.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, UnitQuaternion, Vector3};
use sim::{
    devices::camera::DrawnCamera,
    optics::Lens,
    place::building::Building,
    scene::{Calibration, Scene},
    world::Drawn,
};

use crate::world_setup::scene;

/// Names of all kinds of distributions from which errors are drawn.
const KINDS: [&str; 4] = ["uniform", "truncated_gaussian", "corner", "drift"];

fn scene_with(errors: &str, yaw_tolerance_deg: f64) -> Scene {
    let calibration = serde_json::json!({ "distortion_tolerance_px": 0.4 });
    let robot = serde_json::json!({
        "errors": errors,
        "floor_camera": { "yaw_tolerance_deg": yaw_tolerance_deg, "distortion_tolerance_px": 0.4 },
        "forward_camera": { "calibration": calibration },
        "ceiling_camera": { "calibration": calibration },
        "range_camera": {}, "gyro": {}, "flow": {},
    });
    let start = serde_json::json!({ "x_m": 2.0, "y_m": 3.0, "tolerance_m": 0.25, "tolerance_deg": 2.0 });
    let marker = serde_json::json!([{ "id": 63, "x_m": 3.0, "y_m": 2.0 }, { "id": 207, "x_m": 5.0, "y_m": 4.0 }]);
    let cupboard = |x_m: f64| serde_json::json!({ "x_m": x_m, "y_m": 5.0, "size_m": [1.0, 0.5], "rotation_deg": 30.0 });
    scene(serde_json::json!({
        "robot": robot, "start": start, "markers": { "marker": marker }, "floor": { "tiles": {} },
        "furniture": [cupboard(4.0), cupboard(6.0)], "building": { "furniture_tolerance_deg": 2.0 },
        "localizer": { "methods": ["wall_directions"], "wall_directions": { "tolerance_deg": 0.3 } },
    }))
}

/// A drawn error divided by its tolerance. The quotient is never negative where the tolerance bounds a distance or an angle regardless of its
/// direction.
struct Share {
    error: String,
    value: f64,
    is_norm: bool,
}

fn share(error: &str, value: f64) -> Share {
    Share { error: error.to_owned(), value, is_norm: false }
}

fn norm(error: &str, value: f64) -> Share {
    Share { error: error.to_owned(), value, is_norm: true }
}

/// Every drawn error divided by its tolerance; all of them are in [−1, 1] when the draws keep their bounds.
fn shares(scene: &Scene, drawn: &Drawn) -> Vec<Share> {
    let floor = drawn.devices.floor_camera.unwrap();
    let floor_keys = scene.robot.floor_camera.as_ref().unwrap();
    let at_m = floor.body_from_camera.translation.vector;
    let px_per_m = floor.focal_px[0] / 0.25;
    let [tilt_rad, yaw_rad] = tilt_and_yaw(&DrawnCamera::nominal(floor_keys), &floor);
    let mut shares = vec![
        share("left wheel", (drawn.base.wheel_radius_m[0] / 0.0975 - 1.0) / 0.002),
        share("right wheel", (drawn.base.wheel_radius_m[1] / 0.0975 - 1.0) / 0.002),
        share("track", (drawn.base.track_m / 0.33 - 1.0) / 0.003),
        share("start x", (drawn.start.x_m - 2.0) / 0.25),
        share("start y", (drawn.start.y_m - 3.0) / 0.25),
        share("start heading", drawn.start.heading_rad.to_degrees() / 2.0),
        share("floor camera forward", (at_m.x + 0.15) / 0.0005),
        share("floor camera left", at_m.y / 0.0005),
        share("floor camera scale", (px_per_m / (640.0 / 0.48) - 1.0) / 0.001),
        share("floor camera yaw", yaw_rad.to_degrees() / 0.1),
        norm("floor camera tilt", tilt_rad.to_degrees() / 0.1),
    ];
    shares.push(bend("floor camera", &Lens::of(floor_keys, &floor)));
    let (forward, ceiling) =
        (scene.robot.forward_camera.as_ref().unwrap(), scene.robot.ceiling_camera.as_ref().unwrap());
    let (drawn_forward, drawn_ceiling) = (drawn.devices.forward_camera.unwrap(), drawn.devices.ceiling_camera.unwrap());
    shares.extend(calibrated("forward camera", &DrawnCamera::nominal(forward), &drawn_forward, &forward.calibration));
    shares.extend(calibrated("ceiling camera", &DrawnCamera::nominal(ceiling), &drawn_ceiling, &ceiling.calibration));
    shares.push(bend("forward camera", &Lens::of(forward, &drawn_forward)));
    shares.push(bend("ceiling camera", &Lens::of(ceiling, &drawn_ceiling)));
    shares.extend(other_devices(drawn));
    shares.extend(places(drawn));
    shares
}

/// Shift of an image corner by the distortion k1 that was drawn where 0 is declared, divided by the tolerance of 0.4 px.
fn bend(camera: &str, lens: &Lens) -> Share {
    let straight = Lens { distortion: [0.0; 5], ..lens.clone() };
    let far_px = lens.corners().into_iter().map(|ray| {
        let ([u, v], [straight_u, straight_v]) = (lens.pixel(ray), straight.pixel(ray));
        (u - straight_u).hypot(v - straight_v)
    });
    share(&format!("{camera} distortion"), far_px.fold(0.0, f64::max).copysign(lens.distortion[0]) / 0.4)
}

/// Angles by which a camera is tilted and turned about the vertical, against its nominal attitude.
fn tilt_and_yaw(nominal: &DrawnCamera, drawn: &DrawnCamera) -> [f64; 2] {
    let turn: UnitQuaternion<f64> = drawn.body_from_camera.rotation * nominal.body_from_camera.rotation.inverse();
    [(turn * Vector3::z()).xy().norm().asin(), 2.0 * turn.k.atan2(turn.w)]
}

fn calibrated(camera: &str, nominal: &DrawnCamera, drawn: &DrawnCamera, tolerance: &Calibration) -> Vec<Share> {
    let shift_m = drawn.body_from_camera.translation.vector - nominal.body_from_camera.translation.vector;
    let [tilt_rad, yaw_rad] = tilt_and_yaw(nominal, drawn);
    let mut shares = vec![
        norm(&format!("{camera} tilt"), tilt_rad.to_degrees() / tolerance.angle_tolerance_deg),
        share(&format!("{camera} yaw"), yaw_rad.to_degrees() / tolerance.angle_tolerance_deg),
    ];
    for axis in 0..3 {
        shares.push(share(&format!("{camera} axis {axis}"), shift_m[axis] / tolerance.position_tolerance_m));
    }
    for axis in 0..2 {
        let focal = drawn.focal_px[axis] / nominal.focal_px[axis] - 1.0;
        let off_px = drawn.principal_point_px[axis] - nominal.principal_point_px[axis];
        shares.push(share(&format!("{camera} focal length {axis}"), focal / tolerance.focal_tolerance));
        let off = off_px / tolerance.principal_point_tolerance_px;
        shares.push(share(&format!("{camera} principal point {axis}"), off));
    }
    shares
}

fn other_devices(drawn: &Drawn) -> Vec<Share> {
    let (range, gyro, flow) =
        (drawn.devices.range_camera.unwrap(), drawn.devices.gyro.unwrap(), drawn.devices.flow.unwrap());
    vec![
        share("range camera forward", (range.position_m[0] - 0.10) / 0.002),
        share("range camera left", (range.position_m[1] - 0.0375) / 0.002),
        share("range camera yaw", range.yaw_rad.to_degrees() / 0.2),
        norm("range camera tilt", range.tilt_rad[0].hypot(range.tilt_rad[1]).to_degrees() / 0.2),
        share("range camera focal length", (range.focal_px / 580.0 - 1.0) / 0.002),
        share("range camera baseline", (range.baseline_m / 0.075 - 1.0) / 0.002),
        share("gyroscope bias", gyro.bias_rad_per_s.to_degrees() / 0.02),
        share("gyroscope scale", (gyro.scale - 1.0) / 0.002),
        share("flow sensor forward", (flow.position_m[0] + 0.06) / 0.0005),
        share("flow sensor left", flow.position_m[1] / 0.0005),
        share("flow sensor yaw", flow.yaw_rad.to_degrees() / 0.1),
        share("flow sensor scale", (flow.scale - 1.0) / 0.001),
    ]
}

fn places(drawn: &Drawn) -> Vec<Share> {
    let mut shares = vec![share("walls", drawn.place.walls_turn_deg / 0.3)];
    for (marker, [x_m, y_m]) in drawn.place.markers.iter().zip([[3.0, 2.0], [5.0, 4.0]]) {
        let name = |what: &str| format!("marker {} {what}", marker.id.0);
        let off_m = (marker.centre_m[0] - x_m).hypot(marker.centre_m[1] - y_m);
        shares.push(norm(&name("place"), off_m / 0.002));
        shares.push(share(&name("rotation"), marker.rotation_rad.to_degrees() / 0.2));
        // The test expects a nominal height of 2.594 m: at the top of its tolerance of 5 mm a marker still hangs 1 mm below the ceiling of 2.6 m.
        shares.push(share(&name("height"), (marker.height_m - (2.6 - 0.001 - 0.005)) / 0.005));
        let (sin, cos) = marker.rotation_rad.sin_cos();
        let misprint_m = |dot: &sim::place::drawn::DrawnDot| {
            let [along_m, across_m] = dot.place.map(|index| 0.04 * (f64::from(index) - 1.5));
            let at_m = [cos * along_m - sin * across_m, sin * along_m + cos * across_m];
            (dot.centre_in_world.x - marker.centre_m[0] - at_m[0])
                .hypot(dot.centre_in_world.y - marker.centre_m[1] - at_m[1])
        };
        shares.push(norm(&name("print"), misprint_m(&marker.dots[0]) / 0.0003));
    }
    for (piece, turn_deg) in drawn.place.furniture_turn_deg.iter().enumerate() {
        shares.push(share(&format!("furniture {piece}"), turn_deg / 2.0));
    }
    shares
}

#[test]
fn drawn_errors_fill_their_tolerance_and_never_leave_it() {
    for errors in KINDS {
        let scene = scene_with(errors, 0.1);
        let draws: Vec<Vec<Share>> = (0..200).map(|seed| shares(&scene, &Drawn::draw(&scene, seed))).collect();
        for index in 0..draws[0].len() {
            let (error, is_norm) = (&draws[0][index].error, draws[0][index].is_norm);
            let drawn: Vec<f64> = draws.iter().map(|draw| draw[index].value).collect();
            // The shares may exceed 1 by rounding only: the angle by which a rotation vector tips an axis is recovered to a few millionths of itself.
            assert!(drawn.iter().all(|share| share.abs() <= 1.0 + 1e-5), "{errors}: {error} leaves its tolerance");
            assert!(drawn.iter().any(|share| *share > 0.8), "{errors}: {error} never comes near its tolerance");
            assert!(is_norm || drawn.iter().any(|share| *share < -0.8), "{errors}: {error} is one-sided");
            let is_at_end = ["corner", "drift"].contains(&errors);
            assert!(!is_at_end || drawn.iter().all(|share| share.abs() > 0.9999), "{errors}: {error} off its corner");
        }
    }
}

#[test]
fn in_a_drift_everything_of_a_kind_is_off_alike() {
    for seed in 0..20 {
        let drawn = Drawn::draw(&scene_with("drift", 0.1), seed);
        let [one, other] = [&drawn.place.markers[0], &drawn.place.markers[1]];
        assert!((one.rotation_rad - other.rotation_rad).abs() < 1e-12);
        assert!((one.centre_m[0] - 3.0 - (other.centre_m[0] - 5.0)).abs() < 1e-12);
        assert!((one.height_m - other.height_m).abs() < 1e-12);
        assert_eq!(drawn.place.furniture_turn_deg[0], drawn.place.furniture_turn_deg[1]);
        // Where the drawn errors of floor tiles drift to one side, the tile corners at the room's ends are off by the same distance for all joints of
        // a direction.
        let laid = drawn.place.tiles.unwrap();
        for axis in 0..2 {
            let first_m = laid.corner_offset_m[0][axis];
            for across in 0..laid.count[axis] {
                let corner = if axis == 0 { across * laid.count[1] } else { across };
                assert!((laid.corner_offset_m[corner][axis] - first_m).abs() < 1e-6, "seed {seed}, axis {axis}");
            }
        }
    }
}

#[test]
fn furniture_is_felt_and_seen_as_it_stands_and_mapped_as_stated() {
    let scene = scene_with("corner", 0.1);
    let drawn = Drawn::draw(&scene, 3);
    let built = scene.as_built(&drawn.place);
    for (stated, stands) in scene.furniture.iter().zip(&built.furniture) {
        assert_eq!(stated.rotation_deg, 30.0);
        assert!([28.0, 32.0].contains(&stands.rotation_deg), "{}", stands.rotation_deg);
    }
}

/// A room whose walls have directions known to a tolerance, with a forward camera and with these localization methods; `setup` are the keys of the
/// method `wall_directions`.
fn walls(methods: &[&str], setup: serde_json::Value) -> Scene {
    let door = serde_json::json!([{ "from_m": [0.0, 1.0], "to_m": [0.0, 2.0] }]);
    scene(serde_json::json!({
        "robot": { "errors": "corner", "forward_camera": {} }, "building": { "door": door },
        "localizer": { "methods": methods, "wall_directions": setup },
    }))
}

#[test]
fn walls_turn_together_about_the_middle_of_the_room_and_furniture_stays() {
    let scene = Scene {
        furniture: scene_with("corner", 0.1).furniture,
        ..walls(&["wall_directions"], serde_json::json!({ "tolerance_deg": 1.0 }))
    };
    for seed in 0..4 {
        let drawn = Drawn::draw(&scene, seed);
        assert_eq!(drawn.place.walls_turn_deg.abs(), 1.0, "seed {seed}");
        let built = scene.as_built(&drawn.place);
        assert_eq!(
            built.furniture[0].rotation_deg,
            scene.furniture[0].rotation_deg + drawn.place.furniture_turn_deg[0]
        );
        let building = Building::new(&built, &drawn.place);
        // In a room of 8 m by 6 m, each wall is turned and keeps its distance from the middle of the room.
        let off_rad = drawn.place.walls_turn_deg.to_radians();
        for wall in building.walls() {
            let quarters = (wall.along.y.atan2(wall.along.x) - off_rad) / FRAC_PI_2;
            assert!((quarters - quarters.round()).abs() < 1e-12, "seed {seed}: {:?}", wall.along);
            let from_middle = wall.corner - Point3::new(4.0, 3.0, wall.corner.z);
            let away_m = from_middle.cross(&wall.along.normalize()).norm();
            let expected_m = if quarters.round() as i32 % 2 == 0 { 3.0 } else { 4.0 };
            assert!((away_m - expected_m).abs() < 1e-12, "seed {seed}: {away_m} m from the middle");
        }
        // By hand, to first order: the door is 2 m below and 4 m to the left of the room's middle in the plan; a turn of the walls to the left moves
        // it to the right and down.
        let [x_m, y_m] = built.building.doors[0].from_m;
        assert!((x_m - 2.0 * off_rad).abs() < 1e-3 && (y_m - (1.0 - 4.0 * off_rad)).abs() < 1e-3, "{x_m}, {y_m}");
        // The map that the localizer is given must not depend on the turn of the walls that was drawn: it has the wall directions that the scene
        // states, and its outline contains the room at every turn that the tolerance allows.
        let map = scene.map();
        assert!(map.wall_directions_rad[0].mid().abs() < 1e-12);
        let corners = [[0.0, 0.0], [8.0, 0.0], [0.0, 6.0], [8.0, 6.0]];
        for turn_deg in [-1.0, -0.3, 0.0, 0.7, 1.0_f64] {
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            for [x_m, y_m] in corners.map(|[x_m, y_m]: [f64; 2]| [x_m - 4.0, y_m - 3.0]) {
                let turned_m = [4.0 + cos * x_m - sin * y_m, 3.0 + sin * x_m + cos * y_m];
                assert!((0..2).all(|axis| map.room_m[axis].inflate(1e-12).contains(turned_m[axis])), "{turned_m:?}");
            }
        }
        assert!(map.room_m[0].hi() < 8.0 + 3.0 * 0.01746, "{:?}", map.room_m);
    }
}

#[test]
fn walls_stand_as_stated_where_nobody_reads_them_or_their_map_is_already_off() {
    let turn_deg = |scene: &Scene| Drawn::draw(scene, 3).place.walls_turn_deg.abs();
    let with = |setup: serde_json::Value| walls(&["wall_directions"], setup);
    assert_eq!(turn_deg(&walls(&[], serde_json::json!({ "tolerance_deg": 1.0 }))), 0.0);
    assert_eq!(walls(&[], serde_json::json!({ "tolerance_deg": 1.0 })).map().room_m[0].hi(), 8.0);
    assert_eq!(turn_deg(&with(serde_json::json!({ "tolerance_deg": 0.0 }))), 0.0);
    assert_eq!(turn_deg(&with(serde_json::json!({ "tolerance_deg": 1.0, "mapped_deg": [1.5] }))), 0.0);
    let half = turn_deg(&with(serde_json::json!({ "tolerance_deg": 1.0, "mapped_deg": [0.5] })));
    assert!((half - 0.5).abs() < 1e-12, "{half}");
}

#[test]
fn walls_leave_the_robot_the_place_that_the_scene_gives_it() {
    // By hand: 2 m beside the room's middle, a wall that is turned by 1° comes 2 m · sin 1° = 35 mm nearer to the robot's start, where only 20 mm are
    // free. The start must be moved so that the robot still fits.
    let mut scene = walls(&["wall_directions"], serde_json::json!({ "tolerance_deg": 1.0 }));
    (scene.start.x_m, scene.start.y_m) = (scene.robot.body_radius_m + 0.02, 0.5 * scene.room.depth_m + 2.0);
    for seed in 0..6 {
        let drawn = Drawn::draw(&scene, seed);
        let (sin, cos) = drawn.place.walls_turn_deg.to_radians().sin_cos();
        // True distance of the robot's start from the turned wall that is nominally at x = 0: it has the normal (cos, sin) and is 4 m from the room's
        // middle.
        let to_wall_m = 4.0 + cos * (drawn.start.x_m - 4.0) + sin * (drawn.start.y_m - 3.0);
        assert!(to_wall_m >= scene.robot.body_radius_m - 1e-9, "seed {seed}: {to_wall_m} m");
        assert!(drawn.place.walls_turn_deg != 0.0, "seed {seed}: not turned at all");
    }
}

#[test]
fn a_cameras_tolerance_moves_no_wheel() {
    for seed in 0..5 {
        let [loose, tight] =
            [10.0, 0.0].map(|yaw_tolerance_deg| Drawn::draw(&scene_with("uniform", yaw_tolerance_deg), seed));
        assert_eq!(loose.base.wheel_radius_m, tight.base.wheel_radius_m);
        assert_eq!(loose.start, tight.start);
        assert_ne!(
            loose.devices.floor_camera.unwrap().body_from_camera,
            tight.devices.floor_camera.unwrap().body_from_camera
        );
    }
}
