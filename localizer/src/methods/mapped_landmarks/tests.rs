//! Tests against a camera that is projected with rotation matrices of `nalgebra`, written for these tests alone.

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
};

use interval::{Interval, contractor::Contractor};
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::*;
use crate::{
    PoseBox,
    graph::{
        Constant, Domain, Relations, Variable,
        trial::{Draw, robot, rounds, tilt},
    },
    map::{Anchor, SpacePoint},
    method::Context,
    robot::BodyModel,
};

/// True values of a camera and a robot within the bounds of a model.
struct True {
    camera: PointCameraModel,
    body: BodyModel,
    constants: BTreeMap<Constant, f64>,
    mount_tilt: Rotation3<f64>,
}

/// A robot at an instant: pose, and the lean of its body with its Cayley vector in the frame of the posture's own heading.
struct At {
    pose: [f64; 3],
    heave_m: f64,
    world_from_body: Rotation3<f64>,
    lean: [f64; 2],
}

impl True {
    fn new(draw: &mut Draw, share: f64) -> True {
        let mut half = |value: f64| draw.or_zero(share * value);
        let camera = PointCameraModel {
            focal_px: Interval::centred(400.0, half(2.0)),
            centre_px: [319.5, 239.5].map(|at| Interval::centred(at, half(3.0))),
            tilt_up_rad: 0.2,
            yaw_rad: Interval::centred(0.4, half(0.01)),
            tilt_rad: half(0.01),
            position_m: [0.2, -0.1].map(|at| Interval::centred(at, half(0.005))),
            height_m: Interval::centred(0.5, half(0.005)),
            error_px: half(0.8) + 1e-9,
            least_depth_m: 0.4,
            stamp_error_s: 0.0,
        };
        let body = BodyModel { tilt_rad: half(0.01), heave_m: half(0.002), clearance_m: 0.2 };
        let (mount_tilt, cayley) = tilt(draw, camera.tilt_rad);
        let mut constants = BTreeMap::new();
        let mut put = |constant, value| constants.insert(constant, value);
        put(Constant::PointFocal, draw.within(camera.focal_px));
        put(Constant::PointYaw, draw.within(camera.yaw_rad));
        put(Constant::PointHeight, draw.within(camera.height_m));
        for (k, tilt) in cayley.into_iter().enumerate() {
            put(Constant::PointCentre(k), draw.within(camera.centre_px[k]));
            put(Constant::PointPosition(k), draw.within(camera.position_m[k]));
            put(Constant::PointTilt(k), tilt);
        }
        True { camera, body, constants, mount_tilt }
    }

    /// The robot at a place in any direction, with a lean and a heave at their bounds.
    fn at(&self, draw: &mut Draw, x_m: f64, y_m: f64) -> At {
        let turn_rad = draw.between(-PI, PI);
        self.turned(draw, [x_m, y_m], turn_rad)
    }

    /// The robot at a place, with its posture turned about the vertical, and a lean and a heave at their bounds.
    fn turned(&self, draw: &mut Draw, [x_m, y_m]: [f64; 2], turn_rad: f64) -> At {
        let (lean, cayley) = tilt(draw, self.body.tilt_rad);
        let world_from_body = Rotation3::from_axis_angle(&Vector3::z_axis(), turn_rad) * lean;
        let forward = world_from_body * Vector3::x();
        let pose = [x_m, y_m, forward.y.atan2(forward.x)];
        let heave_m = draw.within(Interval::centred(0.0, self.body.heave_m));
        At { pose, heave_m, world_from_body, lean: cayley }
    }

    /// The optical centre in the world, and the rotation from the frame of the camera (x right, y down, z ahead) to the world.
    fn camera_at(&self, at: &At) -> (Vector3<f64>, Rotation3<f64>) {
        let constant = |constant| self.constants[&constant];
        let mount = Vector3::new(
            constant(Constant::PointPosition(0)),
            constant(Constant::PointPosition(1)),
            constant(Constant::PointHeight),
        );
        let centre = Vector3::new(at.pose[0], at.pose[1], at.heave_m) + at.world_from_body * mount;
        // The columns are the camera's axes for a level camera: right is −y, down is −z, ahead is x.
        let level = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0));
        let up = Rotation3::from_axis_angle(&Vector3::y_axis(), -self.camera.tilt_up_rad);
        let yaw = Rotation3::from_axis_angle(&Vector3::z_axis(), constant(Constant::PointYaw));
        (centre, at.world_from_body * yaw * self.mount_tilt * up * level)
    }

    /// A point of the world in the camera: its pixel without error, and its depth.
    fn project(&self, at: &At, point: Vector3<f64>) -> ([f64; 2], f64) {
        let (centre, world_from_camera) = self.camera_at(at);
        let seen = world_from_camera.inverse() * (point - centre);
        let focal = self.constants[&Constant::PointFocal];
        let pixel = [0, 1].map(|k| self.constants[&Constant::PointCentre(k)] + focal * seen[k] / seen[2]);
        (pixel, seen[2])
    }

    fn with_error(&self, draw: &mut Draw, at_px: [f64; 2]) -> [f64; 2] {
        at_px.map(|at| at + draw.within(Interval::centred(0.0, self.camera.error_px)))
    }

    /// A point that the camera sees at a depth, within the picture.
    fn seen_point(&self, draw: &mut Draw, at: &At, depth_m: f64) -> Vector3<f64> {
        let (centre, world_from_camera) = self.camera_at(at);
        let in_camera = Vector3::new(draw.between(-0.7, 0.7), draw.between(-0.5, 0.5), 1.0) * depth_m;
        centre + world_from_camera * in_camera
    }
}

/// α, β and ρ of a point of the world.
fn homogeneous(anchor: &Anchor, point: Vector3<f64>) -> [f64; 3] {
    let from = [0, 1, 2].map(|k| point[k] - anchor.from_m[k]);
    let depth = from[anchor.axis] * anchor.sign();
    let [i, j] = anchor.sides();
    [from[i] / depth, from[j] / depth, 1.0 / depth]
}

fn around(draw: &mut Draw, at: f64, half: f64) -> Interval {
    let off = draw.within(Interval::centred(0.0, half));
    Interval::centred(at + off, half + 1e-12)
}

fn depth(draw: &mut Draw, least_m: f64) -> f64 {
    if draw.unit() < 0.2 { least_m } else { draw.size(least_m, 1e4) }
}

#[test]
fn the_truth_satisfies_the_rows_of_image_points_at_the_corners_of_all_bounds() {
    let mut draw = Draw::new(20_261_126);
    let mut nearest: f64 = 0.0;
    for round in 0..rounds(20_000) {
        let truth = True::new(&mut draw, 1.0);
        let at = truth.at(&mut draw, 3.0, -2.0);
        let depth_m = depth(&mut draw, 0.4);
        let landmark = truth.seen_point(&mut draw, &at, depth_m);
        let (exact_px, _) = truth.project(&at, landmark);
        let at_px = truth.with_error(&mut draw, exact_px);
        // An anchor near a pose from which the landmark was seen before, or near the present one.
        let centre = truth.camera_at(&at).0;
        let reach = 0.3 * depth_m.min(10.0);
        let from_m = [0, 1, 2].map(|k| centre[k] + draw.between(-reach, reach));
        let from = [0, 1, 2].map(|k| landmark[k] - from_m[k]);
        let axis = (0..3).max_by(|&a, &b| from[a].abs().total_cmp(&from[b].abs())).unwrap();
        let anchor = Anchor { from_m, axis, is_positive: from[axis] > 0.0 };
        let true_point = homogeneous(&anchor, landmark);
        let size = draw.size(1e-6, 0.05);
        let value = true_point.map(|one| around(&mut draw, one, size));
        let optics = Arc::new(Optics::new(truth.camera, truth.body));
        let id = LandmarkId(9);
        let points = Points { optics, seen: vec![(id, SpacePoint { anchor, value }, at_px)] };
        let mut values: BTreeMap<Variable, f64> =
            truth.constants.iter().map(|(&constant, &value)| (Variable::Constant(constant), value)).collect();
        let mut domain = Domain::default();
        for (variable, value) in points.quantities(4, &PoseBox::from([Interval::ZERO; 3])) {
            domain.put(variable, value);
        }
        for (k, truly) in true_point.into_iter().enumerate() {
            let half = draw.size(1e-6, if k == 2 { 0.1 } else { 0.3 });
            domain.put(Variable::Pose(4, k), around(&mut draw, at.pose[k], half));
            values.insert(Variable::Pose(4, k), at.pose[k]);
            values.insert(Variable::Point(id, k), truly);
        }
        (0..2).for_each(|k| {
            values.insert(Variable::BodyTilt(4, k), at.lean[k]);
        });
        for (variable, value) in domain.iter() {
            assert!(value.inflate(1e-12).contains(values[&variable]), "{variable:?}: {} {value}", values[&variable]);
        }
        let rows = points.rows(4, &domain);
        assert_eq!(rows.len(), 2);
        for row in rows {
            let value = row.value_at(|variable| values[&variable] - domain.reference(variable));
            assert!(row.sides.inflate(1e-9).contains(value), "round {round}: {value} {}", row.sides);
            nearest = nearest.max((value - row.sides.mid()).abs() / row.sides.radius());
        }
    }
    assert!(nearest > 0.98, "{nearest}");
}

#[test]
fn a_landmark_is_within_its_box_from_its_first_sighting_on() {
    let mut draw = Draw::new(20_261_127);
    let mut nearest: f64 = 0.0;
    for round in 0..rounds(20_000) {
        let truth = True::new(&mut draw, 1.0);
        let at = truth.at(&mut draw, 3.0, -2.0);
        let depth_m = depth(&mut draw, 0.4);
        let landmark = truth.seen_point(&mut draw, &at, depth_m);
        let (exact_px, _) = truth.project(&at, landmark);
        let at_px = truth.with_error(&mut draw, exact_px);
        let pose = PoseBox::from([0, 1, 2].map(|k| {
            let half = draw.size(1e-6, if k == 2 { 0.02 } else { 0.05 });
            around(&mut draw, at.pose[k], half)
        }));
        let point = Optics::new(truth.camera, truth.body).first_seen(&pose, at_px).unwrap();
        let expected = homogeneous(&point.anchor, landmark);
        for (k, (value, truly)) in point.value.into_iter().zip(expected).enumerate() {
            assert!(value.inflate(1e-12).contains(truly), "round {round}, {k}: {truly} {value}");
            nearest = nearest.max((truly - value.mid()).abs() / value.radius());
        }
    }
    assert!(nearest > 0.9, "{nearest}");
}

fn reading(stamp_s: f64, seen: &[SeenPoint]) -> Reading {
    let numbers = SeenPoint::numbers(seen);
    Reading::Other { measured_s: stamp_s, arrived_s: stamp_s, device: DEVICE.to_owned(), numbers }
}

/// What a robot sees of some landmarks.
fn look(truth: &True, draw: &mut Draw, at: &At, landmarks: &[Vector3<f64>]) -> Vec<SeenPoint> {
    let mut seen = Vec::new();
    for (number, &landmark) in (0..).zip(landmarks) {
        let (exact_px, depth_m) = truth.project(at, landmark);
        let is_inside = (0.0..640.0).contains(&exact_px[0]) && (0.0..480.0).contains(&exact_px[1]);
        if depth_m >= truth.camera.least_depth_m && is_inside {
            seen.push(SeenPoint { landmark: LandmarkId(number), at_px: truth.with_error(draw, exact_px) });
        }
    }
    seen
}

/// Landmarks on the walls of a room of 10 m × 10 m about the origin.
fn walls(draw: &mut Draw, n: usize) -> Vec<Vector3<f64>> {
    (0..n)
        .map(|_| {
            let turn = f64::from((draw.unit() * 4.0) as u32) * 0.25 * TAU;
            let along = Vector3::new(5.0, draw.between(-5.0, 5.0), draw.between(0.2, 2.5));
            Rotation3::from_axis_angle(&Vector3::z_axis(), turn) * along
        })
        .collect()
}

fn boxed(draw: &mut Draw, pose: [f64; 3], halves: [f64; 3]) -> PoseBox {
    PoseBox::from([0, 1, 2].map(|k| around(draw, pose[k], halves[k])))
}

#[test]
fn what_is_learnt_at_known_poses_contains_every_landmark_and_later_localizes() {
    let mut draw = Draw::new(20_261_128);
    let (mut volumes, mut widths) = (Vec::new(), Vec::new());
    for round in 0..rounds(1) {
        let truth = True::new(&mut draw, 0.2);
        let landmarks = walls(&mut draw, 60);
        let robot = RobotModel { body: truth.body, ..robot() };
        let mut method = MappedLandmarks::new(truth.camera, &robot, &[], Learning::Teaches);
        for step in 0..150 {
            let along = f64::from(step) * TAU / 150.0;
            let place_m = [2.0 * along.cos(), 2.0 * along.sin()];
            let at = truth.turned(&mut draw, place_m, along + 0.25 * TAU);
            let known = boxed(&mut draw, at.pose, [0.01, 0.01, 0.02]);
            let seen = look(&truth, &mut draw, &at, &landmarks);
            let known = PoseUnion::single(known);
            let mut posterior = known.branches[0];
            let constraint = method.constrain(&reading(f64::from(step), &seen), &Context::at_rest(&known)).unwrap();
            constraint.on_pose.contract(&mut posterior);
            assert!(is_within(at.pose, &posterior), "round {round}, step {step}: {posterior:?} {:?}", at.pose);
            method.learn(&PoseUnion::single(posterior), &|_, _| None);
            assert!(!method.take_contradiction(), "round {round}, step {step}");
            for (landmark, point) in method.atlas.points() {
                let expected = homogeneous(&point.anchor, landmarks[landmark.0 as usize]);
                for (value, truly) in point.value.into_iter().zip(expected) {
                    let holds = value.inflate(1e-12).contains(truly);
                    assert!(holds, "round {round}, step {step}: {landmark:?} {truly} {value}");
                }
            }
        }
        let taught = method.space_points();
        for (landmark, point) in &taught {
            let expected = homogeneous(&point.anchor, landmarks[landmark.0 as usize]);
            assert!((0..3).all(|k| point.value[k].inflate(1e-12).contains(expected[k])), "round {round}: {landmark:?}");
        }
        let places: Vec<_> = taught.iter().map(|(_, point)| point.place_m()).collect();
        assert!(places.len() > 40, "{}", places.len());
        volumes.extend(
            places.iter().map(|place| {
                place.map_or(f64::INFINITY, |sides| sides.iter().map(|side| side.width()).product::<f64>())
            }),
        );
        // Later, from other places, at poses that are hardly known.
        let mut later = MappedLandmarks::new(truth.camera, &robot, &taught, Learning::Never);
        for step in 0..40 {
            let at_m = [0; 2].map(|_| draw.between(-2.5, 2.5));
            let at = truth.at(&mut draw, at_m[0], at_m[1]);
            let seen = look(&truth, &mut draw, &at, &landmarks);
            let mut pose = boxed(&mut draw, at.pose, [0.15, 0.15, 0.05]);
            let before = PoseUnion::single(pose);
            let constraint = later.constrain(&reading(f64::from(step), &seen), &Context::at_rest(&before)).unwrap();
            constraint.on_pose.contract(&mut pose);
            assert!(is_within(at.pose, &pose), "round {round}, step {step}: {pose:?} {:?}", at.pose);
            if seen.len() >= 6 {
                widths.push(pose[0].width().max(pose[1].width()));
            }
        }
    }
    volumes.sort_by(f64::total_cmp);
    widths.sort_by(f64::total_cmp);
    let (volume, width) = (volumes[volumes.len() / 2], widths[widths.len() / 2]);
    assert!(volume < 0.02 && width < 0.25, "{volume} m³, {width} m of {}", widths.len());
}

/// Whether a pose is within a box, up to rounding.
fn is_within(truth: [f64; 3], pose: &PoseBox) -> bool {
    (0..3).all(|k| pose[k].inflate(1e-12).contains(truth[k]))
}

#[test]
fn what_was_learnt_since_a_failed_assumption_is_taken_back() {
    let mut draw = Draw::new(20_261_129);
    let truth = True::new(&mut draw, 0.2);
    let landmarks = walls(&mut draw, 40);
    let robot = RobotModel { body: truth.body, ..robot() };
    let mut method = MappedLandmarks::new(truth.camera, &robot, &[], Learning::Teaches);
    let mut at_five = Vec::new();
    for step in 0..30 {
        let at = truth.turned(&mut draw, [0.1 * f64::from(step), 0.0], 0.3);
        // From the sixth second on the pose is told 3 m wrong.
        let wrong_m = if step > 5 { 3.0 } else { 0.0 };
        let known = boxed(&mut draw, [at.pose[0], at.pose[1] + wrong_m, at.pose[2]], [0.01, 0.01, 0.005]);
        let seen = look(&truth, &mut draw, &at, &landmarks);
        let known = PoseUnion::single(known);
        method.constrain(&reading(f64::from(step), &seen), &Context::at_rest(&known));
        method.learn(&known, &|_, _| None);
        if step == 5 {
            at_five = method.atlas.points().collect::<Vec<_>>();
        }
    }
    method.forget_since(5.0);
    let left: Vec<_> = method.atlas.points().collect();
    assert!(!left.is_empty() && left.len() <= at_five.len(), "{} of {}", left.len(), at_five.len());
    for (landmark, point) in left {
        let expected = homogeneous(&point.anchor, landmarks[landmark.0 as usize]);
        assert!((0..3).all(|k| point.value[k].inflate(1e-12).contains(expected[k])), "{landmark:?} {point:?}");
    }
}
