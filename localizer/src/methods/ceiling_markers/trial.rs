//! The paper's two experiments with ceiling markers, on synthetic pictures: angle test and position test (Tables 2 and 3). The interval
//! method and the paper's own method are run on the same pictures.

use std::time::Instant;

use nalgebra::{Rotation3, Vector3};

use super::{CeilingMarkers, paper};
use interval::Interval;

use crate::{
    Map, Method, PoseBox, PoseUnion, Reading, RobotModel,
    map::{MarkerMap, PlacedMarker},
    markers::{Coding, MarkerId},
    method::Context,
    reading::Camera,
    robot::{BodyModel, CeilingCameraModel, Reach, WheelModel},
    vision::{
        ceiling::{
            synthetic::{Ceiling, Eye, Pasted},
            trial::{frames, seed},
        },
        synthetic::Random,
    },
};

const TILT_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Height of the camera above the floor: 0.2 m, which is 2.6 m below the ceiling.
const CAMERA_M: f64 = 0.2;
pub(super) const CEILING_M: f64 = 2.8;
/// Electrons that a pixel at mid grey collects.
const ELECTRONS: f64 = 8000.0;

/// Model of a robot on a test bench: the camera's mount has no offset, focal lengths are known to 0.1 px and heights to 1 mm.
///
/// An error of the picture's centre looks like a tilt of the mount: a calibration that knows the mount's tilt to 0.05° leaves next to
/// nothing of it.
pub(super) fn bench() -> RobotModel {
    let radius = Interval::point(0.1);
    RobotModel {
        wheels: WheelModel {
            radius_m: [radius, radius],
            track_m: Interval::point(0.33),
            ticks_per_turn: 1000.0,
            slip_ratio: 0.0,
            slip_floor_m: 0.0,
            side_slip_ratio: 0.0,
            side_slip_floor_m: 0.0,
            slip_window_s: 0.2,
        },
        reach: Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 2.0 },
        body: BodyModel { tilt_rad: TILT_RAD, heave_m: 0.0, clearance_m: 0.0 },
        floor_camera: None,
        forward_camera: None,
        gyro: None,
        flow: None,
        ceiling_camera: Some(CeilingCameraModel {
            width_px: 640,
            height_px: 480,
            focal_px: [Interval::centred(755.139, 0.1), Interval::centred(753.926, 0.1)],
            centre_px: [Interval::centred(320.252, 0.02), Interval::centred(239.661, 0.02)],
            distortion: [0.0; 5],
            distortion_px: 0.0,
            height_m: Interval::centred(CAMERA_M, 0.001),
            position_m: [Interval::centred(0.0, 0.0001); 2],
            yaw_rad: Interval::centred(0.0, TILT_RAD),
            lean_rad: [0.0; 2],
            tilt_rad: TILT_RAD,
            stamp_error_s: 0.0,
            electrons_per_grey: ELECTRONS / 128.0,
            row_time_s: 0.0,
            q_items: 0,
        }),
        range_camera: None,
        steering: None,
    }
}

/// Map with a single marker, whose dot O is the world's origin. The marker defines the world frame, so its placement has no error.
fn paper_map() -> MarkerMap {
    MarkerMap {
        coding: Coding::Hexads,
        markers: vec![PlacedMarker {
            id: MarkerId(Coding::Hexads.identities()[40].0),
            centre_m: [0.06, 0.06],
            rotation_rad: 0.0,
            height_m: Interval::centred(CEILING_M, 0.001),
        }],
        placement_m: 0.0,
        rotation_tolerance_rad: 0.0,
        print_m: 0.00003,
    }
}

/// Rotation by a tilt that is drawn uniformly from the disc of its bound.
fn tilt(random: &mut Random) -> Rotation3<f64> {
    let (course, size) = (random.between(0.0, std::f64::consts::TAU), TILT_RAD * random.unit().sqrt());
    Rotation3::new(Vector3::new(course.cos(), course.sin(), 0.0) * size)
}

/// True ceiling camera of a robot at a given pose, with every error of the test bench drawn at random.
fn eye(pose: [f64; 3], random: &mut Random) -> Eye {
    let mut eye = Eye::upright(0.0);
    let body = Rotation3::from_axis_angle(&Vector3::z_axis(), pose[2]) * tilt(random);
    let mount = Rotation3::from_axis_angle(&Vector3::z_axis(), random.between(-TILT_RAD, TILT_RAD)) * tilt(random);
    eye.world_from_camera = body * mount * eye.world_from_camera;
    let offset = Vector3::new(
        random.between(-0.0001, 0.0001),
        random.between(-0.0001, 0.0001),
        CAMERA_M + random.between(-0.001, 0.001),
    );
    eye.place_m = Vector3::new(pose[0], pose[1], 0.0) + body * offset;
    for axis in 0..2 {
        eye.focal_px[axis] += random.between(-0.1, 0.1);
        eye.centre_px[axis] += random.between(-0.02, 0.02);
    }
    eye
}

/// Sums of errors, box widths and computing times over the poses of one test.
#[derive(Default)]
struct Table {
    poses: f64,
    lost: usize,
    horizontal_m: f64,
    heading_rad: f64,
    width_m: f64,
    width_rad: f64,
    milliseconds: Vec<f64>,
    paper_read: usize,
    paper_horizontal_m: f64,
    paper_spatial_m: f64,
    paper_heading_rad: f64,
}

impl Table {
    fn add(&mut self, pose: [f64; 3], random: &mut Random) {
        let (map, robot, eye) = (paper_map(), bench(), eye(pose, random));
        let mut pasted = Pasted::new(map.markers[0].id, [0.06, 0.06], 0.0, CEILING_M + random.between(-0.001, 0.001));
        pasted.level = 225.0;
        let image = Ceiling { electrons: ELECTRONS, ..Ceiling::new(vec![pasted]) }.picture(&eye, random);
        let fix = paper::locate(&image, &map, &robot);
        let room = Interval::new(-20.0, 20.0);
        let all =
            Map { room_m: [room, room], tiles: None, markers: Some(map), wall_directions_rad: Vec::new(), walls: None };
        let mut method = CeilingMarkers::new(&all, &robot).expect("a camera and a marker");
        let (camera, image) = (Camera::Ceiling, image.into());
        let reading = Reading::Camera { measured_s: 0.0, arrived_s: 0.0, camera, exposure_s: 0.002, image };
        let prior = PoseBox::new([room, room, Interval::centred(pose[2], 3.2)]);
        let start = Instant::now();
        let constraint = method.constrain(&reading, &Context::at_rest(&PoseUnion::single(prior))).expect("a marker");
        let found = PoseUnion { branches: constraint.on_pose.branches(&prior) };
        self.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        let hull = found.hull();
        let middle = hull.midpoint();
        self.poses += 1.0;
        self.lost += usize::from(!found.branches.iter().any(|branch| branch.contains(&pose)));
        self.horizontal_m += (middle[0] - pose[0]).hypot(middle[1] - pose[1]);
        self.heading_rad += (middle[2] - pose[2]).abs();
        self.width_m += 0.5 * (hull.width(0) + hull.width(1));
        self.width_rad += hull.width(2);
        if let Some(fix) = fix {
            let off = [fix.camera_m[0] - pose[0], fix.camera_m[1] - pose[1], fix.camera_m[2] - CAMERA_M];
            self.paper_read += 1;
            self.paper_horizontal_m += off[0].hypot(off[1]);
            self.paper_spatial_m += off[0].hypot(off[1]).hypot(off[2]);
            let turn = (fix.pose.heading_rad - pose[2]).rem_euclid(std::f64::consts::TAU);
            self.paper_heading_rad += turn.min(std::f64::consts::TAU - turn);
        }
    }

    fn print(&mut self, name: &str) {
        self.milliseconds.sort_by(f64::total_cmp);
        let (n, read) = (self.poses, self.paper_read.max(1) as f64);
        println!(
            "{name}: {n} poses, {} lost; error {:.2} mm {:.3} deg, width {:.2} mm {:.3} deg, median {:.2} ms | paper's way: {} read, {:.1} mm horizontal, {:.1} mm in space, {:.2} deg",
            self.lost,
            1e3 * self.horizontal_m / n,
            (self.heading_rad / n).to_degrees(),
            1e3 * self.width_m / n,
            (self.width_rad / n).to_degrees(),
            self.milliseconds[self.milliseconds.len() / 2],
            self.paper_read,
            1e3 * self.paper_horizontal_m / read,
            1e3 * self.paper_spatial_m / read,
            (self.paper_heading_rad / read).to_degrees(),
        );
    }
}

#[test]
fn the_papers_two_tests_come_out_within_3_mm_and_a_tenth_of_a_degree() {
    let mut random = Random::new(seed(31));
    let (mut angles, mut positions) = (Table::default(), Table::default());
    for _ in 0..frames(4) {
        for step in 0..13 {
            angles.add([-0.1, 0.15, f64::from(step) * 30f64.to_radians()], &mut random);
        }
        for step in 0..11 {
            positions.add([-0.5, -0.5 + 0.1 * f64::from(step), 0.0], &mut random);
        }
    }
    angles.print("angle test");
    positions.print("position test");
    for table in [&angles, &positions] {
        assert_eq!(table.lost, 0);
        assert!(table.horizontal_m / table.poses <= 0.003);
        assert!((table.heading_rad / table.poses).to_degrees() <= 0.1);
        assert!(table.milliseconds[0] <= 5.0, "{:?}", table.milliseconds);
    }
    assert!((angles.width_m + positions.width_m) / (angles.poses + positions.poses) <= 0.012);
    // The paper's method reads a marker in all of the same pictures. It is worse by an order of magnitude, because a pose with free tilt is
    // ill-conditioned at 2.6 m (erratum I5).
    assert!(angles.paper_read + positions.paper_read == (angles.poses + positions.poses) as usize);
}

#[test]
fn an_error_before_the_lean_turns_by_no_more_than_the_heading_allows_for() {
    let mut random = Random::new(seed(32));
    let mut nearest: f64 = 0.0;
    for _ in 0..2000 {
        let (course, lean, tilt_rad) =
            (random.between(-3.2, 3.2), random.between(0.1, 0.6), random.between(0.0005, 0.03));
        let mut robot = bench();
        robot.ceiling_camera = robot.ceiling_camera.map(|camera| CeilingCameraModel {
            yaw_rad: Interval::ZERO,
            lean_rad: [lean * course.cos(), lean * course.sin()],
            tilt_rad,
            ..camera
        });
        let room = Interval::new(-20.0, 20.0);
        let map = Map {
            room_m: [room, room],
            tiles: None,
            markers: Some(paper_map()),
            wall_directions_rad: Vec::new(),
            walls: None,
        };
        let allowed = CeilingMarkers::new(&map, &robot).expect("a camera and a marker").yaw_error();
        let about = random.between(-3.2, 3.2);
        let error = Rotation3::new(Vector3::new(about.cos(), about.sin(), 0.0) * tilt_rad);
        let leaning = Rotation3::new(Vector3::new(-course.sin(), course.cos(), 0.0) * lean);
        // A tilt error that acts before the known lean equals the lean, then a tilt, then a turn about the vertical. The turn's angle is
        // read from the vertical component of the quaternion.
        let turned = nalgebra::UnitQuaternion::from_rotation_matrix(&(leaning * error * leaning.inverse()));
        let turn_rad = 2.0 * turned.k.atan2(turned.w);
        assert!(allowed.contains(turn_rad), "{turn_rad} {allowed:?}");
        nearest = nearest.max(turn_rad.abs() / allowed.hi());
    }
    assert!(nearest > 0.8, "{nearest}");
}
