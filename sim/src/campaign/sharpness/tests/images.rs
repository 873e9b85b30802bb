//! Images of floor and ceiling: claims that are computed by the formulas of school geometry, for a level camera without errors.

use std::{collections::BTreeMap, path::Path};

use localizer::{
    Map, Pose, bounds,
    bounds::Assumption,
    markers::{GridPlace, dot_in_marker_m},
    reading::Camera,
    robot::RobotModel,
};
use nalgebra::Point3;

use super::super::{
    dots::{self, Dots, FALSE_MARKERS, Seen},
    eye::Eye,
    floor::Floor,
    history::{CameraPart, History, Looker, Quantity},
    joints::{self, FALSE_LINES, Joints, Line},
    kind::{Declared, Kind, demand},
};
use super::HAIR;
use crate::{
    devices::camera::world_from_camera,
    optics::Lens,
    place::drawn::LaidTiles,
    scene::{Distribution, Scene},
    truth::Truth,
    world::Drawn,
};
use interval::Interval;

pub(super) const STEP_S: f64 = 0.01;
const SPEED_M_PER_S: f64 = 0.2;
/// Stamp of the look, at which the robot is at (1.1, 0.9) with heading 0.
pub(super) const LOOK: usize = 50;
pub(super) const PLACE_M: [f64; 2] = [1.1, 0.9];
pub(super) const BOUND_PX: f64 = 0.5;

pub(super) struct Bench {
    pub(super) scene: Scene,
    pub(super) robot: RobotModel,
    map: Map,
    drawn: Drawn,
}

impl Bench {
    pub(super) fn of(scene: &str) -> Bench {
        let path = format!("{}/../scenes/papers/{scene}.toml", env!("CARGO_MANIFEST_DIR"));
        let scene = Scene::load(Path::new(&path)).unwrap();
        Bench { robot: scene.robot_model(), map: scene.map(), drawn: Drawn::draw(&scene, 1), scene }
    }

    pub(super) fn eye(&self, camera: Camera) -> Eye {
        Eye::of(camera, &self.scene, &self.robot, &self.drawn).unwrap()
    }

    /// A second of a straight drive, with the middle of every interval that a kind declares.
    pub(super) fn history(&self, camera: Camera, kind: &dyn Kind) -> History {
        let stamps_s: Vec<f64> = (0..=100).map(|step| f64::from(step) * STEP_S).collect();
        let poses = stamps_s.iter().map(|time_s| Pose {
            x_m: PLACE_M[0] + SPEED_M_PER_S * (time_s - LOOK as f64 * STEP_S),
            y_m: PLACE_M[1],
            heading_rad: 0.0,
        });
        let quantities = [Quantity::BodyTilt(LOOK, 0), Quantity::BodyTilt(LOOK, 1), Quantity::Heave(LOOK)];
        let mut history = History {
            poses: poses.collect(),
            wheel_angle_rad: vec![[0.0; 2]; stamps_s.len()],
            counted: Vec::new(),
            quantities: BTreeMap::from(quantities.map(|quantity| (quantity, 0.0))),
            stamps_s,
        };
        for Declared { quantity, interval, .. } in kind.declared(&history) {
            history.quantities.insert(quantity, interval.mid());
        }
        history.quantities.insert(Quantity::Instant(Looker::Camera(camera), LOOK), history.stamps_s[LOOK]);
        history
    }
}

/// The bound of a kind that a changed history breaks.
pub(super) fn broken_by(kind: &dyn Kind, history: &History, change: impl Fn(&mut History)) -> Option<Assumption> {
    let mut changed = history.clone();
    change(&mut changed);
    for Declared { quantity, interval, bound } in kind.declared(&changed) {
        if demand(0.0, bound, 0.0, Interval::point(changed.value(quantity)), interval).is_err() {
            return Some(bound);
        }
    }
    kind.check(&changed, 0.0).err().map(|broken| broken.bound)
}

/// Sets a quantity of a history.
pub(super) fn put(quantity: Quantity, value: f64) -> impl Fn(&mut History) {
    move |history| {
        history.quantities.insert(quantity, value);
    }
}

/// Moves the whole history by a distance along x and along y, and turns it about the robot at the look.
pub(super) fn moved(x_m: f64, y_m: f64, turn_rad: f64) -> impl Fn(&mut History) {
    move |history| {
        for pose in &mut history.poses {
            (pose.x_m, pose.y_m, pose.heading_rad) = (pose.x_m + x_m, pose.y_m + y_m, pose.heading_rad + turn_rad);
        }
    }
}

/// Demands that each quantity breaks its bound a hair beyond it, and does not a hair within it.
pub(super) fn demand_all_bounds(kind: &dyn Kind, history: &History, quantities: &[(Quantity, Assumption)]) {
    let declared = kind.declared(history);
    for (quantity, bound) in quantities {
        let interval = declared.iter().find(|declared| declared.quantity == *quantity).unwrap().interval;
        let hair = HAIR * interval.width();
        for (beyond, within) in
            [(interval.hi() + hair, interval.hi() - hair), (interval.lo() - hair, interval.lo() + hair)]
        {
            assert_eq!(broken_by(kind, history, put(*quantity, beyond)), Some(*bound), "{quantity:?}");
            assert_ne!(broken_by(kind, history, put(*quantity, within)), Some(*bound), "{quantity:?}");
        }
    }
}

/// Both joints below the camera, which is 0.15 m behind the robot: one 0.05 m behind it, at x = 0.9, and one straight below it, at y = 0.9.
fn joints(bench: &Bench) -> Joints {
    let model = bench.robot.floor_camera.clone().unwrap();
    let camera_m = [PLACE_M[0] + model.position_m[0].mid(), PLACE_M[1] + model.position_m[1].mid()];
    let pixel = |[x_m, y_m]: [f64; 2]| {
        let middle_px = [model.width_px, model.height_px].map(|size| 0.5 * (f64::from(size) - 1.0));
        let per_m = model.pixels_per_m.mid();
        [middle_px[0] - per_m * (y_m - camera_m[1]), middle_px[1] - per_m * (x_m - camera_m[0]), BOUND_PX]
    };
    let places_m = [-0.15, -0.1, -0.05, 0.0, 0.05, 0.1, 0.15];
    let line = |joint: (usize, i32), points_px: Vec<[f64; 3]>| Line { joint, n_needed: points_px.len(), points_px };
    let lines = vec![
        line((0, 3), places_m.map(|at_m| pixel([0.9, camera_m[1] + at_m])).to_vec()),
        line((1, 3), places_m.map(|at_m| pixel([camera_m[0] + at_m, 0.9])).to_vec()),
    ];
    let look = joints::Look { stamp: LOOK, measured_s: LOOK as f64 * STEP_S, lines, n_false: 0 };
    let floor = Floor::of(&bench.map, bench.map.tiles.as_ref().unwrap());
    Joints { eye: bench.eye(Camera::Floor), floor, looks: vec![look] }
}

#[test]
fn a_floor_image_is_refused_a_hair_beyond_each_of_its_bounds() {
    let bench = Bench::of("floor_vision_odometry");
    let joints = joints(&bench);
    let history = bench.history(Camera::Floor, &joints);
    assert_eq!(broken_by(&joints, &history, |_| {}), None);
    let of = |part| Quantity::Camera(Camera::Floor, part);
    let quantities = [
        (of(CameraPart::Position(0)), bounds::FLOOR_CAMERA_POSITION),
        (of(CameraPart::Position(1)), bounds::FLOOR_CAMERA_POSITION),
        (of(CameraPart::Yaw), bounds::FLOOR_CAMERA_YAW),
        (of(CameraPart::Tilt(0)), bounds::FLOOR_CAMERA_TILT),
        (of(CameraPart::Focal(0)), bounds::FLOOR_CAMERA_SCALE),
        (Quantity::JointEnd(0, 3, 0), bounds::FLOOR_TILES_LAYING),
        (Quantity::JointEnd(1, 3, 1), bounds::FLOOR_TILES_LAYING),
        (Quantity::Instant(Looker::Camera(Camera::Floor), LOOK), bounds::FLOOR_CAMERA_STAMP),
    ];
    demand_all_bounds(&joints, &history, &quantities);
    // Both components of a tilt are within the bound, and their vector is not.
    let most_rad = bench.robot.floor_camera.as_ref().unwrap().tilt_rad;
    let tilted = broken_by(&joints, &history, |history| {
        (0..2).for_each(|axis| put(of(CameraPart::Tilt(axis)), 0.8 * most_rad)(history));
    });
    assert_eq!(tilted, Some(bounds::FLOOR_CAMERA_TILT));
}

#[test]
fn claimed_joints_are_refused_a_hair_beyond_their_bounds_on_points() {
    let bench = Bench::of("floor_vision_odometry");
    let mut joints = joints(&bench);
    let history = bench.history(Camera::Floor, &joints);
    let most_m = BOUND_PX / bench.robot.floor_camera.as_ref().unwrap().pixels_per_m.mid();
    // The joint at x = 0.9 stops a motion along x, the joint at y = 0.9 one along y. A turn about the robot moves points by their distance from it, 0.15 m
    // to its side and at most 0.3 m behind it, to first order.
    for sign in [-1.0, 1.0] {
        let cases = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0 / 0.3]];
        for [x, y, turn] in cases.map(|by| by.map(|by| sign * most_m * by)) {
            let at = |share: f64| broken_by(&joints, &history, moved(share * x, share * y, share * turn));
            assert_eq!((at(1.002), at(0.998)), (Some(FALSE_LINES), None), "{x} {y} {turn}");
        }
    }
    // What the stamp's error allows is so little of it.
    let instant_s = history.stamps_s[LOOK] + 5e-5;
    let late = put(Quantity::Instant(Looker::Camera(Camera::Floor), LOOK), instant_s);
    let at = |x_m: f64| {
        broken_by(&joints, &history, |history| {
            late(history);
            moved(x_m, 0.0, 0.0)(history);
        })
    };
    let least_m = most_m - 5e-5 * SPEED_M_PER_S;
    assert_eq!((at(least_m * 1.0002), at(least_m * 0.9998)), (Some(FALSE_LINES), None));

    // Points that may be wrong, and lines that may be.
    let spoil = |joints: &mut Joints, point: usize| joints.looks[0].lines[0].points_px[point][1] += 3.0;
    spoil(&mut joints, 2);
    assert_eq!(broken_by(&joints, &history, |_| {}), Some(FALSE_LINES));
    joints.looks[0].lines[0].n_needed -= 1;
    assert_eq!(broken_by(&joints, &history, |_| {}), None);
    spoil(&mut joints, 4);
    assert_eq!(broken_by(&joints, &history, |_| {}), Some(FALSE_LINES));
    joints.looks[0].n_false = 1;
    assert_eq!(broken_by(&joints, &history, |_| {}), None);
    joints.floor.room_m[0] = Interval::new(1.0, 3.6);
    assert_eq!(broken_by(&joints, &history, |_| {}), Some(FALSE_LINES));
}

#[test]
fn joints_that_lie_a_hair_beyond_their_bounds_are_refused() {
    let bench = Bench::of("floor_vision_odometry");
    let mut joints = joints(&bench);
    let mut tiles = bench.scene.floor.tiles.clone().unwrap();
    tiles.corner_tolerance_m = 0.001;
    joints.floor.grid.straightness_m = 0.001;
    let laid = LaidTiles::draw(&tiles, [[0.0, 0.0], [3.6, 2.4]], Distribution::Corner, 1);
    joints.floor.add(&laid, (0, 3));
    let history = bench.history(Camera::Floor, &joints);
    // The corner at (0.9, 0.9) is in the middle of the image, and those beside it are 0.3 m away.
    let bend = Quantity::JointBend(0, 3, 3);
    demand_all_bounds(&joints, &history, &[(bend, bounds::FLOOR_TILES_STRAIGHTNESS)]);
    let bent = |by_m: f64| broken_by(&joints, &history, put(bend, by_m));
    assert_eq!((bent(0.0006), bent(0.0002)), (Some(FALSE_LINES), None));
    // Ends that are off by 0.5 mm either way turn a joint of 2.4 m by 0.42 mrad.
    let turned = |joints: &Joints| {
        broken_by(joints, &history, |history| {
            put(Quantity::JointEnd(0, 3, 0), -0.0005)(history);
            put(Quantity::JointEnd(0, 3, 1), 0.0005)(history);
        })
    };
    joints.floor.grid.laying_angle_rad = 0.001 / 2.4 * 1.0001;
    assert_eq!(turned(&joints), None);
    joints.floor.grid.laying_angle_rad = 0.001 / 2.4 * 0.9999;
    assert_eq!(turned(&joints), Some(bounds::FLOOR_TILES_LAYING_ANGLE));
}

/// A marker of nine dots, 0.3 m ahead of the robot and 0.2 m to its left.
fn dots(bench: &Bench) -> Dots {
    let map = bench.map.markers.clone().unwrap();
    let mut marker = map.markers[0];
    marker.centre_m = [PLACE_M[0] + 0.3, PLACE_M[1] + 0.2];
    let camera = bench.robot.ceiling_camera.clone().unwrap();
    let up_m = marker.height_m.mid() - camera.height_m.mid();
    let pixel = |place: GridPlace| {
        let [x, y] = dot_in_marker_m(place);
        let [ahead_m, left_m] = [0.3 + x, 0.2 + y];
        // Image right is robot right, image down is robot forward.
        let [u, v] = [(0, -left_m), (1, ahead_m)].map(|(axis, along_m): (usize, f64)| {
            camera.centre_px[axis].mid() + camera.focal_px[axis].mid() * along_m / up_m
        });
        (place, [u, v, BOUND_PX])
    };
    let places = [[0, 0], [3, 0], [0, 3], [1, 1], [1, 2], [2, 1], [2, 2], [0, 1], [3, 2]];
    let seen = Seen { marker, dots_px: places.map(pixel).to_vec() };
    let look = dots::Look { stamp: LOOK, measured_s: LOOK as f64 * STEP_S, markers: vec![seen], n_false: 0 };
    Dots { eye: bench.eye(Camera::Ceiling), map, looks: vec![look] }
}

#[test]
fn a_ceiling_image_is_refused_a_hair_beyond_each_of_its_bounds() {
    let bench = Bench::of("ir_markers_lab");
    let mut dots = dots(&bench);
    let history = bench.history(Camera::Ceiling, &dots);
    assert_eq!(broken_by(&dots, &history, |_| {}), None);
    let of = |part| Quantity::Camera(Camera::Ceiling, part);
    let id = dots.looks[0].markers[0].marker.id.0;
    let quantities = [
        (of(CameraPart::Position(0)), bounds::CEILING_CAMERA_POSITION),
        (of(CameraPart::Position(2)), bounds::CEILING_CAMERA_HEIGHT),
        (of(CameraPart::Yaw), bounds::CEILING_CAMERA_YAW),
        (of(CameraPart::Tilt(1)), bounds::CEILING_CAMERA_TILT),
        (of(CameraPart::Focal(0)), bounds::CEILING_CAMERA_FOCAL),
        (of(CameraPart::Focal(1)), bounds::CEILING_CAMERA_FOCAL),
        (of(CameraPart::Centre(1)), bounds::CEILING_CAMERA_CENTRE),
        (Quantity::Marker(id, 0), bounds::MARKERS_PLACEMENT),
        (Quantity::MarkerTurn(id), bounds::MARKERS_ROTATION),
        (Quantity::MarkerHeight(id), bounds::MARKERS_HEIGHT),
        (Quantity::Dot(id, [3, 0], 1), bounds::MARKERS_PRINT),
        (Quantity::Instant(Looker::Camera(Camera::Ceiling), LOOK), bounds::CEILING_CAMERA_STAMP),
    ];
    demand_all_bounds(&dots, &history, &quantities);
    // Components that are within a bound, as a vector that is not.
    let both = |pair: [Quantity; 2], by: f64| {
        broken_by(&dots, &history, |history| pair.into_iter().for_each(|quantity| put(quantity, by)(history)))
    };
    assert_eq!(
        both([0, 1].map(|axis| Quantity::Marker(id, axis)), 0.8 * dots.map.placement_m),
        Some(bounds::MARKERS_PLACEMENT)
    );
    assert_eq!(
        both([0, 1].map(|axis| Quantity::Dot(id, [0, 0], axis)), 0.8 * dots.map.print_m),
        Some(bounds::MARKERS_PRINT)
    );
    // Half a pixel of 480 is so much at 2.29 m, along the robot and across it.
    let camera = bench.robot.ceiling_camera.clone().unwrap();
    let up_m = dots.looks[0].markers[0].marker.height_m.mid() - camera.height_m.mid();
    let most_m = BOUND_PX / camera.focal_px[0].mid() * up_m;
    for [x, y] in [[most_m, 0.0], [-most_m, 0.0], [0.0, most_m], [0.0, -most_m]] {
        let at = |share: f64| broken_by(&dots, &history, moved(share * x, share * y, 0.0));
        assert_eq!((at(1.001), at(0.999)), (Some(FALSE_MARKERS), None), "{x} {y}");
    }
    // A dot that is printed elsewhere, and a marker that may be false.
    dots.looks[0].markers[0].dots_px[4].1[0] += 2.0 * BOUND_PX;
    assert_eq!(broken_by(&dots, &history, |_| {}), Some(FALSE_MARKERS));
    dots.looks[0].n_false = 1;
    assert_eq!(broken_by(&dots, &history, |_| {}), None);
}

/// The lenses and mounts of the simulator are an outside source.
#[test]
fn cameras_with_errors_show_points_where_the_simulator_has_them() {
    for (scene, camera, point_m) in [
        ("floor_vision_odometry", Camera::Floor, [0.9, 1.0, 0.0]),
        ("ir_markers_lab", Camera::Ceiling, [1.4, 1.1, 2.5]),
        ("dark_carpet", Camera::Forward, [3.1, 1.4, 0.7]),
    ] {
        let mut bench = Bench::of(scene);
        bench.scene.robot.errors = Distribution::Corner;
        let keys = bench.scene.robot.floor_camera.as_mut().map(|camera| &mut camera.lens.distortion);
        if let Some(distortion) = keys {
            *distortion = [-0.1, 0.02, 0.001, -0.002, 0.0];
        }
        bench.drawn = Drawn::draw(&bench.scene, 5);
        let truth = Truth {
            pose: Pose { x_m: 1.1, y_m: 0.9, heading_rad: 0.3 },
            tilt_rad: [0.004, -0.003],
            heave_m: 0.002,
            ..Truth::default()
        };
        let (keys, drawn) = (bench.scene.robot.camera(camera).unwrap(), bench.drawn.devices.camera(camera).unwrap());
        let in_camera = world_from_camera(&truth, &drawn).inverse() * Point3::from(point_m);
        let expected = Lens::of(keys, &drawn).pixel([in_camera.x / in_camera.z, in_camera.y / in_camera.z]);

        let eye = bench.eye(camera);
        let parts = [0, 1, 2].map(CameraPart::Position).into_iter().chain([CameraPart::Yaw]);
        let parts = parts.chain(
            [0, 1]
                .into_iter()
                .flat_map(|axis| [CameraPart::Tilt(axis), CameraPart::Focal(axis), CameraPart::Centre(axis)]),
        );
        let constants = parts.map(|part| (Quantity::Camera(camera, part), Eye::true_value(part, keys, &drawn)));
        let posture = [
            (Quantity::BodyTilt(0, 0), truth.tilt_rad[0]),
            (Quantity::BodyTilt(0, 1), truth.tilt_rad[1]),
            (Quantity::Heave(0), truth.heave_m),
            (Quantity::Instant(Looker::Camera(camera), 0), 0.0),
        ];
        let history = History {
            stamps_s: vec![0.0, 1.0],
            poses: vec![truth.pose; 2],
            wheel_angle_rad: vec![[0.0; 2]; 2],
            counted: Vec::new(),
            quantities: constants.chain(posture).collect(),
        };
        let (number, depth_m) = eye.sight::<f64>(&history, 0).pixel(point_m);
        let (enclosed, _) = eye.sight::<Interval>(&history, 0).pixel(point_m.map(Interval::point));
        assert!((depth_m - in_camera.z).abs() < 1e-12, "{camera:?}");
        for axis in 0..2 {
            assert!((number[axis] - expected[axis]).abs() < 1e-9, "{camera:?}: {number:?} instead of {expected:?}");
            assert!(enclosed[axis].inflate(1e-9).contains(expected[axis]) && enclosed[axis].width() < 1e-9);
        }
        // Every drawn error is at an end of its tolerance, so that the truth is at the end of its bounds, and within them.
        for Declared { quantity, interval, .. } in eye.declared(&history, [(0, 0.0)].into_iter()) {
            let value = history.value(quantity);
            assert!(interval.inflate(1e-9 * interval.width()).contains(value), "{quantity:?}: {value} in {interval}");
        }
    }
}
