//! Tests against a camera that is projected with rotation matrices of `nalgebra`, written for these tests alone, and against figures worked out by
//! hand.

use image::GrayImage;
use interval::Interval;
use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};

use super::{
    resection::{LevelCamera, Sight, count},
    *,
};
use crate::{
    graph::trial::{Draw, robot},
    map::Anchor,
    robot::ForwardCameraModel,
    vision::distortion::bend,
};

/// A camera with every nominal value other than zero.
fn model() -> ForwardCameraModel {
    ForwardCameraModel {
        focal_px: Interval::point(417.0),
        principal_point_px: [318.0, 241.0].map(Interval::point),
        distortion: [-0.12, 0.02, 0.0005, -0.0003, 0.0],
        distortion_px: 0.1,
        tilt_up_rad: 0.15,
        yaw_rad: Interval::point(0.1),
        tilt_error_rad: 0.001,
        stamp_error_s: 0.0,
        position_m: [0.12, -0.05].map(Interval::point),
        height_m: Interval::point(0.4),
        height_px: 480,
        row_time_s: 0.0,
    }
}

/// Where a camera on a level floor shows a point of the world, as a pinhole and through its lens.
fn projected(model: &ForwardCameraModel, pose: Pose, place_m: Vector3<f64>) -> [[f64; 2]; 2] {
    let about = |axis: Vector3<f64>, angle_rad: f64| Rotation3::new(axis * angle_rad);
    let world_from_robot = about(Vector3::z(), pose.heading_rad);
    let [forward, left] = model.position_m.map(Interval::mid);
    let eye =
        Vector3::new(pose.x_m, pose.y_m, 0.0) + world_from_robot * Vector3::new(forward, left, model.height_m.mid());
    // The columns are the axes of a level camera that looks ahead: its right is −y, its down is −z, and what is ahead is x.
    let level = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0));
    let up = about(Vector3::y(), -model.tilt_up_rad);
    let seen = (world_from_robot * about(Vector3::z(), model.yaw_rad.mid()) * up * level).inverse() * (place_m - eye);
    let at = [seen.x / seen.z, seen.y / seen.z];
    let bent = bend(model.distortion, at);
    let pixel =
        |at: [f64; 2]| [0, 1].map(|axis| model.principal_point_px[axis].mid() + model.focal_px.mid() * at[axis]);
    [pixel(at), pixel([at[0] + bent[0], at[1] + bent[1]])]
}

/// A landmark at a place that was first seen from near (0, 0), with half widths of its slopes and of its inverse depth.
fn landmark(place_m: Vector3<f64>, half: [f64; 3]) -> SpacePoint {
    let from_m = [0.1, -0.2, 0.5];
    let from = place_m - Vector3::from(from_m);
    let axis = from.iamax();
    let anchor = Anchor { from_m, axis, is_positive: from[axis] > 0.0 };
    let [i, j] = anchor.sides();
    let depth_m = from[axis].abs();
    let middle = [from[i] / depth_m, from[j] / depth_m, 1.0 / depth_m];
    SpacePoint { anchor, value: std::array::from_fn(|k| Interval::centred(middle[k], half[k])) }
}

/// Places on the walls of a room of 6 m × 6 m that a robot near the origin sees which heads along x or y.
fn places(draw: &mut Draw, n: usize, heading_rad: f64) -> Vec<Vector3<f64>> {
    let at = |draw: &mut Draw| Vector3::new(draw.between(1.5, 3.0), draw.between(-1.0, 1.0), draw.between(0.1, 1.6));
    (0..n).map(|_| Rotation3::new(Vector3::z() * heading_rad) * at(draw)).collect()
}

const EXACT: [f64; 3] = [1e-4, 1e-4, 1e-4];

#[test]
fn a_landmark_is_shown_where_hand_and_rotation_matrices_put_it() {
    // A level camera at the robot's origin, 0.4 m high, at (1, 2) and heading along y: (0, 4, 0.9) is 2 m ahead, 1 m to the left and 0.5 m above it.
    let level =
        ForwardCameraModel { tilt_up_rad: 0.0, yaw_rad: Interval::ZERO, position_m: [Interval::ZERO; 2], ..model() };
    let quarter = Pose { x_m: 1.0, y_m: 2.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    let place_m = Vector3::new(0.0, 4.0, 0.9);
    let by_hand = Vector2::new(318.0 - 417.0 / 2.0, 241.0 - 417.0 / 4.0);
    let camera = LevelCamera::new(&level, &robot().body);
    assert!((camera.shown(quarter, &landmark(place_m, EXACT)).unwrap().at_px - by_hand).norm() < 1e-9);
    assert!((Vector2::from(projected(&level, quarter, place_m)[0]) - by_hand).norm() < 1e-9);
    // Behind the camera.
    assert!(camera.shown(quarter, &landmark(Vector3::new(0.0, 1.0, 0.9), EXACT)).is_none());

    let (mut draw, camera) = (Draw::new(11), LevelCamera::new(&model(), &robot().body));
    for heading_rad in [0.0, 1.6, -3.0] {
        for place_m in places(&mut draw, 50, heading_rad) {
            let pose = Pose { x_m: 0.2, y_m: -0.3, heading_rad: heading_rad + draw.between(-0.2, 0.2) };
            let [pinhole_px, raw_px] = projected(&model(), pose, place_m).map(Vector2::from);
            let shown = camera.shown(pose, &landmark(place_m, EXACT)).unwrap();
            assert!((shown.at_px - pinhole_px).norm() < 1e-7, "{pinhole_px} {}", shown.at_px);
            assert!((camera.straightened(raw_px.into()).unwrap() - pinhole_px).norm() < 1e-7);
        }
    }
}

#[test]
fn derivatives_of_where_a_landmark_is_shown_are_those_of_rotation_matrices() {
    const STEP: f64 = 1e-6;
    let (mut draw, camera) = (Draw::new(12), LevelCamera::new(&model(), &robot().body));
    for heading_rad in [0.0, 1.6, -3.0] {
        for place_m in places(&mut draw, 20, heading_rad) {
            let pose = Pose { x_m: 0.2, y_m: -0.3, heading_rad: heading_rad + draw.between(-0.2, 0.2) };
            let point = landmark(place_m, EXACT);
            let shown = camera.shown(pose, &point).unwrap();
            let off_px = |pose: Pose, place_m: Vector3<f64>| Vector2::from(projected(&model(), pose, place_m)[0]);
            for axis in 0..3 {
                let moved = |step: f64| {
                    let mut at = pose.to_array();
                    at[axis] += step;
                    off_px(Pose { x_m: at[0], y_m: at[1], heading_rad: at[2] }, place_m)
                };
                let quotient = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                let slope: Vector2<f64> = shown.by_pose.column(axis).into();
                assert!((slope - quotient).norm() < 1e-4 * (1.0 + quotient.norm()), "pose {axis}: {slope} {quotient}");
                let moved = |step: f64| {
                    let [i, j] = point.anchor.sides();
                    let mut value = point.value.map(Interval::mid);
                    value[axis] += step;
                    let depth_m = 1.0 / value[2];
                    let mut place_m = Vector3::from(point.anchor.from_m);
                    place_m[point.anchor.axis] += point.anchor.sign() * depth_m;
                    place_m[i] += value[0] * depth_m;
                    place_m[j] += value[1] * depth_m;
                    off_px(pose, place_m)
                };
                let quotient = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                let slope: Vector2<f64> = shown.by_point.column(axis).into();
                assert!((slope - quotient).norm() < 1e-4 * (1.0 + quotient.norm()), "point {axis}: {slope} {quotient}");
            }
        }
    }
}

#[test]
fn three_wrong_matches_in_ten_leave_the_pose_exact_to_a_millimetre() {
    let camera = LevelCamera::new(&model(), &robot().body);
    for seed in 0..10 {
        let mut draw = Draw::new(100 + seed);
        let truth = Pose { x_m: 0.25, y_m: -0.15, heading_rad: 1.55 };
        let start = Pose { x_m: 0.15, y_m: -0.05, heading_rad: 1.6 };
        let predicted = WeightedPose::of_bounds(start, [0.15, 0.15, 0.1]);
        let places = places(&mut draw, 30, truth.heading_rad);
        let is_wrong = |index: usize| index % 10 < 3;
        let sight = |(index, place_m): (usize, &Vector3<f64>)| {
            let [pinhole_px, _] = projected(&model(), truth, *place_m).map(Vector2::from);
            let off_px = Vector2::new(draw.between(25.0, 200.0), draw.between(-150.0, 150.0));
            let at_px = if is_wrong(index) { pinhole_px + off_px } else { pinhole_px };
            Sight { point: landmark(*place_m, EXACT), at_px }
        };
        let sights: Vec<Sight> = places.iter().enumerate().map(sight).collect();
        let (pose, agree) = camera.ransac(&sights, &predicted).unwrap();
        let expected: Vec<bool> = (0..30).map(|index| !is_wrong(index)).collect();
        assert_eq!((count(&agree), &agree), (21, &expected), "seed {seed}");
        let off = [0, 1, 2].map(|axis| (pose.pose.to_array()[axis] - truth.to_array()[axis]).abs());
        assert!(off.iter().all(|off| *off < 1e-6), "seed {seed}: {off:?}");
        // What the prediction excludes is no pose, however many points agree with it.
        let elsewhere = WeightedPose::of_bounds(Pose { x_m: 0.6, ..start }, [0.02, 0.02, 0.02]);
        let told = camera.ransac(&sights, &elsewhere);
        assert!(told.is_none_or(|(_, agree)| count(&agree) < 21), "seed {seed}");
    }
}

#[test]
fn a_landmark_of_unknown_depth_counts_for_its_direction_alone() {
    let mut draw = Draw::new(5);
    let camera = LevelCamera::new(&model(), &robot().body);
    let truth = Pose { x_m: 0.4, y_m: -0.1, heading_rad: 0.05 };
    let fitted = |draw: &mut Draw, half: f64| {
        let sight = |(index, place_m): (usize, Vector3<f64>)| {
            let mut point = landmark(place_m, EXACT);
            if index % 2 == 0 {
                // The depth that the box has in its middle is a third too great.
                point.value[2] = Interval::centred(0.75 * point.value[2].mid(), half);
            }
            Sight { point, at_px: projected(&model(), truth, place_m)[0].into() }
        };
        let sights: Vec<Sight> = places(draw, 24, 0.0).into_iter().enumerate().map(sight).collect();
        let pose = camera.fit(&sights.iter().collect::<Vec<_>>(), Pose::default()).unwrap().pose;
        (pose.x_m - truth.x_m).hypot(pose.y_m - truth.y_m)
    };
    let [declared_m, believed_m] = [0.3, 1e-4].map(|half| fitted(&mut draw, half));
    assert!(declared_m < 0.01 && believed_m > 3.0 * declared_m, "{declared_m} {believed_m}");
}

#[test]
fn two_poses_are_averaged_by_their_covariances() {
    // Variances of 3 and 1 weigh as 1 and 3: the mean of 0 and 4 is 3, with the variance 3/4.
    let pose = |x_m: f64, variance: f64| WeightedPose {
        pose: Pose { x_m, y_m: 1.0, heading_rad: 7.0 },
        covariance: Matrix3::identity() * variance,
    };
    let mean = pose(0.0, 3.0).with(&pose(4.0, 1.0));
    assert!((mean.pose.x_m - 3.0).abs() < 1e-12 && mean.pose.y_m == 1.0 && mean.pose.heading_rad == 7.0);
    assert!((mean.covariance - Matrix3::identity() * 0.75).norm() < 1e-12);
}

#[test]
fn odometry_carries_on_from_the_pose_of_the_last_picture_that_told_one() {
    let robot = RobotModel { forward_camera: Some(model()), ..robot() };
    let looks = vec![(LandmarkId(3), Landmark::from_bytes(&vec![0; N_BYTES]).unwrap())];
    let points = vec![(LandmarkId(3), landmark(Vector3::new(2.0, 0.0, 0.5), EXACT))];
    let known = KnownLandmarks { points: &points, looks: &looks, views: None };
    let start = PoseBox::from([Interval::centred(1.0, 0.1), Interval::centred(2.0, 0.1), Interval::centred(0.0, 0.1)]);
    assert!(PointMatching::new(&robot, KnownLandmarks { points: &points, looks: &[], views: None }, &start).is_none());
    assert!(PointMatching::new(&RobotModel { gyro: None, ..robot.clone() }, known, &start).is_none());
    let mut matching = PointMatching::new(&robot, known, &start).unwrap();
    // Ten steps of 30 ticks with wheels of 0.05 m and 1024 ticks a turn.
    let step_m = 30.0 * std::f64::consts::TAU * 0.05 / 1024.0;
    for step in 0..=10 {
        matching.roll(0.1 * f64::from(step), [30 * i64::from(step); 2]);
    }
    // A picture without anything tells nothing.
    let told = matching.see(0.55, &GrayImage::new(640, 480));
    assert!(told.matches.is_empty() && !told.is_localized);
    let pose = matching.pose();
    assert!((pose.x_m - 1.0 - 10.0 * step_m).abs() < 1e-9 && (pose.y_m - 2.0).abs() < 1e-9, "{pose:?}");
    let between = matching.reckoned_at(0.55);
    assert!((between.x_m - 1.0 - 5.5 * step_m).abs() < 1e-9, "{between:?}");
    // The picture of 0.55 s showed the robot at (3, 0) and heading along y.
    let fixed = Pose { x_m: 3.0, y_m: 0.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    (matching.fixed, matching.fixed_at) = (WeightedPose::of_bounds(fixed, [0.01; 3]), between);
    let pose = matching.pose();
    assert!((pose.x_m - 3.0).abs() < 1e-9 && (pose.y_m - 4.5 * step_m).abs() < 1e-9, "{pose:?}");
}

#[test]
fn a_landmark_is_matched_at_the_sizes_that_both_focal_lengths_give_it() {
    let robot = RobotModel { forward_camera: Some(model()), ..robot() };
    // A look of a camera of unknown focal length, and one of a camera of half the focal length of this one.
    let unknown = Landmark::from_bytes(&[0; N_BYTES]).unwrap();
    let half = Landmark::from_bytes(&[&[0; N_BYTES][..], &208.5f64.to_le_bytes()].concat()).unwrap();
    // First seen from 1.9 m away, and seen now from 3, 1.8 and 0.8 times as far, by a camera 0.12 m ahead of the robot.
    let point = landmark(Vector3::new(2.0, -0.2, 0.5), EXACT);
    let looks = vec![(LandmarkId(3), half.clone())];
    let points = vec![(LandmarkId(3), point)];
    let matching = PointMatching::new(
        &robot,
        KnownLandmarks { points: &points, looks: &looks, views: None },
        &PoseBox::from([Interval::ZERO; 3]),
    )
    .unwrap();
    let seen = [3.0, 1.8, 0.8].map(|times| {
        let pose = Pose { x_m: 2.0 - 0.12 - times * 1.9, y_m: -0.15, heading_rad: 0.0 };
        [&half, &unknown].map(|look| matching.may_be_seen(pose, &point, look, [640.0, 480.0]))
    });
    assert_eq!(seen, [[true, false], [true, true], [false, true]]);
}

/// Length of a landmark's look as bytes: three numbers, two descriptors of 32 bytes, and a patch of 37 × 37 grey levels.
const N_BYTES: usize = 3 * 8 + 2 * 32 + 37 * 37;
