//! Tests of the point methods with which the interval boxes for landmarks without a map (paper 3) are compared: least squares and iterative closest
//! points, plain and with gates and weights as in practice. Also tests of the interval contractor of that paper's Table IV, exactly as printed.

use interval::{Interval, contractor::Contractor};
use localizer::{
    Pose, PoseBox,
    baselines::{
        GatedIcp, LearntPoint, RansacMap, SOLVERS, WeightedPoint, WeightedPose, closest_points, least_squares,
        printed_table_iv, ransac, solve, weighted_fit,
    },
    reading::LandmarkId,
    rigid_motion::{Landmark, RigidPlanar},
    robot::WheelModel,
};
use nalgebra::{Matrix2, Matrix3, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Positions of four landmarks in the example of paper 3 (landmarks without a map).
const PLACES: [[f64; 2]; 4] = [[3.0, 2.0], [-2.0, 3.0], [-3.0, -2.5], [2.5, -3.0]];

fn in_robot(pose: Pose, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sin_cos();
    let (x_m, y_m) = (x_m - pose.x_m, y_m - pose.y_m);
    [cos * x_m + sin * y_m, cos * y_m - sin * x_m]
}

fn assert_near(found: Pose, expected: Pose, within: f64) {
    let gap = [found.x_m - expected.x_m, found.y_m - expected.y_m, found.heading_rad - expected.heading_rad];
    assert!(gap.iter().all(|gap| gap.abs() < within), "{found:?}, expected {expected:?}");
}

/// A point whose position has the given variance in every direction, and no correlation between x and y.
fn round([x_m, y_m]: [f64; 2], variance_m2: f64) -> WeightedPoint {
    WeightedPoint { at_m: Vector2::new(x_m, y_m), covariance_m2: Matrix2::identity() * variance_m2 }
}

fn exactly(pose: Pose) -> WeightedPose {
    WeightedPose { pose, covariance: Matrix3::zeros() }
}

/// Boxes of the landmarks as they are known in the world frame and seen in the robot frame: of ±0.1 m, around values with errors of up to 0.1 m.
fn measured(pose: Pose, rng: &mut ChaCha8Rng) -> Vec<Landmark> {
    let boxed = |place: [f64; 2], rng: &mut ChaCha8Rng| {
        place.map(|value| Interval::centred(value + 0.1 * rng.random_range(-1.0..1.0), 0.1))
    };
    PLACES.iter().map(|place| (boxed(*place, rng), boxed(in_robot(pose, *place), rng))).collect()
}

#[test]
fn least_squares_recovers_an_exact_motion_at_every_heading() {
    for degree in -179..=180 {
        let truth = Pose { x_m: 1.0, y_m: -0.5, heading_rad: f64::from(degree).to_radians() };
        let pairs: Vec<_> = PLACES.iter().map(|place| (*place, in_robot(truth, *place))).collect();
        assert_near(least_squares(&pairs).unwrap(), truth, 1e-12);
    }
    assert!(least_squares(&[([1.0, 2.0], [0.0, 0.0])]).is_none());
}

#[test]
fn least_squares_never_mirrors() {
    // Three points nearly on a line are seen with one of them on the wrong side, as in a mirror. A mirroring would fit best, but the least-squares
    // pose must still be a rotation.
    let pairs = [([0.0, 0.0], [0.0, 0.0]), ([1.0, 0.1], [1.0, -0.1]), ([2.0, 0.0], [2.0, 0.0])];
    assert_near(least_squares(&pairs).unwrap(), Pose { x_m: 0.0, y_m: 0.2 / 3.0, heading_rad: 0.0 }, 1e-12);
}

#[test]
fn closest_points_find_the_pose_from_nearby_only() {
    let truth = Pose { x_m: 0.4, y_m: -0.3, heading_rad: 0.2 };
    let view: Vec<_> = PLACES.iter().rev().map(|place| in_robot(truth, *place)).collect();
    assert_near(closest_points(&PLACES, &view, Pose::default()), truth, 1e-9);
    // If the search for closest points starts half a turn away from the true heading, each point is matched with a wrong landmark; points without
    // codes cannot reveal that.
    let astray = closest_points(&PLACES, &view, Pose { heading_rad: 3.3, ..truth });
    assert!((astray.heading_rad - 0.2).abs() > 1.0, "{astray:?}");
}

#[test]
fn the_printed_table_keeps_one_quarter_of_headings_and_ours_keep_all() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut kept_by_quarter = [[0; 2]; 4];
    for _ in 0..800 {
        let heading_rad: f64 = rng.random_range(-std::f64::consts::PI..std::f64::consts::PI);
        let truth = Pose { x_m: rng.random_range(-0.5..0.5), y_m: rng.random_range(-0.5..0.5), heading_rad };
        let landmarks = measured(truth, &mut rng);
        let prior = PoseBox::from([
            Interval::new(-3.0, 3.0),
            Interval::new(-3.0, 3.0),
            Interval::new(-std::f64::consts::PI, std::f64::consts::PI),
        ]);
        let quarter = (heading_rad / std::f64::consts::FRAC_PI_2).floor() as i32 + 2;
        let [kept, all] = &mut kept_by_quarter[quarter as usize];
        *kept += usize::from(printed_table_iv(&landmarks, &prior).contains(&truth.to_array()));
        *all += 1;
        for (name, solver) in SOLVERS {
            let boxes = solve(solver, &landmarks, &prior);
            assert!(boxes.iter().any(|one| one.contains(&truth.to_array())), "{name} lost {truth:?}");
        }
    }
    // Headings are divided into four quarters, counted from −180°. The printed table has an arcsine and an arccosine, which together allow headings
    // from 0 to 90° only, the quarter with index 2.
    for (quarter, [kept, all]) in kept_by_quarter.into_iter().enumerate() {
        let share = kept as f64 / all as f64;
        assert!(if quarter == 2 { share > 0.9 } else { share == 0.0 }, "quarter {quarter}: {share}");
    }
}

#[test]
fn in_the_papers_own_problem_the_printed_table_is_wider_than_one_shot() {
    // Errors of the four landmarks in the problem of paper 3's Fig. 5 (landmarks without a map), as shares of the bound of 0.1 m.
    let errors =
        [[[0.5, -0.3], [-0.2, 0.4]], [[-0.7, 0.2], [0.6, -0.6]], [[0.1, 0.6], [0.3, 0.1]], [[-0.4, -0.5], [-0.5, 0.7]]];
    let truth = Pose { x_m: 1.0, y_m: 0.5, heading_rad: 0.4 };
    let landmarks: Vec<Landmark> = PLACES
        .iter()
        .zip(errors)
        .map(|(place, [in_world, seen])| {
            let boxed = |place: [f64; 2], error: [f64; 2]| {
                std::array::from_fn(|axis| Interval::centred(place[axis] + 0.1 * error[axis], 0.1))
            };
            (boxed(*place, in_world), boxed(in_robot(truth, *place), seen))
        })
        .collect();
    let prior = PoseBox::from([
        Interval::new(-3.0, 3.0),
        Interval::new(-3.0, 3.0),
        Interval::centred(0.0, std::f64::consts::PI),
    ]);
    let printed = printed_table_iv(&landmarks, &prior);
    let ours = solve(SOLVERS[2].1, &landmarks, &prior);
    assert_eq!((SOLVERS[2].0, ours.len()), ("one_shot", 1));
    assert!(printed.contains(&truth.to_array()) && ours[0].contains(&truth.to_array()));
    assert!((0..3).all(|axis| ours[0].width(axis) < 0.8 * printed.width(axis)), "{ours:?} beside {printed:?}");
    // A single pass of the contractor for rigid motions also contains the true pose, but gives a box at least as wide as that of the solver in one
    // go.
    let mut once = prior;
    RigidPlanar::new(&landmarks).contract(&mut once);
    assert!((0..3).all(|axis| ours[0].width(axis) <= once.width(axis)));
}

#[test]
fn a_stereo_sight_errs_along_its_ray_by_range_over_baseline_more_than_across() {
    // By hand: the landmark is 4 m ahead, known to within ±3 cm by ±4 cm. Half of this box's diagonal, 5 cm, is the error along the ray from the
    // camera; across the ray it is smaller by baseline over distance, 0.12 m in 4 m: 1.5 mm.
    let in_robot_m = [Interval::centred(4.0, 0.03), Interval::centred(0.0, 0.04)];
    let seen = WeightedPoint::of_stereo(in_robot_m, 0.12);
    let expected = Matrix2::new(0.05_f64.powi(2) / 3.0, 0.0, 0.0, 0.0015_f64.powi(2) / 3.0);
    assert!((seen.covariance_m2 - expected).amax() < 1e-12, "{seen:?}");
    // The landmark is seen at 45°, so that each axis of the robot frame gets half of the sum of the variances along and across the ray.
    let askew = WeightedPoint::of_stereo([Interval::centred(3.0, 0.04), Interval::centred(3.0, 0.03)], 0.0);
    assert!((askew.covariance_m2 - Matrix2::repeat(0.5 * 0.0025 / 3.0)).amax() < 1e-12, "{askew:?}");
}

#[test]
fn a_weighted_fit_is_the_weighted_mean_where_that_is_all_there_is() {
    // Two matched pairs of points on the x axis, along which a turn of the robot moves neither of them: one pair demands a shift of 3 cm with
    // variance 1, the other one no shift with variance 2.
    let matches =
        [(round([1.03, 0.0], 0.0), round([1.0, 0.0], 1.0)), (round([-1.0, 0.0], 0.0), round([-1.0, 0.0], 2.0))];
    let fit = weighted_fit(&matches, None).unwrap();
    assert_near(fit.pose, Pose { x_m: 0.02, y_m: 0.0, heading_rad: 0.0 }, 1e-9);
    // The variance of the weighted mean of two shifts with variances 1 and 2 is 1 / (1 + 1/2).
    assert!((fit.covariance[(0, 0)] - 2.0 / 3.0).abs() < 1e-9, "{fit:?}");
    assert!(weighted_fit(&matches[..1], None).is_none());
}

#[test]
fn a_landmark_is_the_weighted_mean_of_its_sights() {
    let here = exactly(Pose::default());
    let mut learnt = LearntPoint::new(&round([1.0, 0.0], 1e-4), &here).unwrap();
    learnt.learn(&round([1.02, 0.0], 3e-4), Pose::default());
    let place = learnt.place();
    // A landmark is seen at 1.00 and then, with three times the variance, at 1.02: the weighted mean is (3·1.00 + 1·1.02)/4, and its variance is 1/(1
    // + 1/3) of that of the first sighting.
    assert!((place.at_m - Vector2::new(1.005, 0.0)).norm() < 1e-12, "{place:?}");
    assert!((place.covariance_m2 - Matrix2::identity() * 0.75e-4).amax() < 1e-12, "{place:?}");
    // A landmark first seen from a heading with a variance of 1e-4 inherits that variance times its distance squared, across the ray, for
    // good.
    let mut unsure = here;
    unsure.covariance[(2, 2)] = 1e-4;
    let inherits = LearntPoint::new(&round([2.0, 0.0], 1e-6), &unsure).unwrap().place();
    assert!((inherits.covariance_m2 - Matrix2::new(1e-6, 0.0, 0.0, 1e-6 + 4e-4)).amax() < 1e-12, "{inherits:?}");
}

#[test]
fn what_odometry_leaves_open_grows_with_the_way() {
    let wheels = WheelModel {
        radius_m: [Interval::point(0.1); 2],
        track_m: Interval::point(0.5),
        ticks_per_turn: 1000.0,
        slip_ratio: 0.03,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 0.2,
    };
    // The robot drives straight on by 1 m, with its heading known to a variance of 1e-4. Each wheel may slip by 3 cm, so that the heading may be off
    // by 2·3 cm over the track of 0.5 m.
    let mut before = exactly(Pose { x_m: 5.0, y_m: 0.0, heading_rad: 0.0 });
    before.covariance[(2, 2)] = 1e-4;
    let (from, to) = (Pose::default(), Pose { x_m: 1.0, ..Pose::default() });
    let after = before.carried_on(from, to, &wheels);
    assert_near(after.pose, Pose { x_m: 6.0, y_m: 0.0, heading_rad: 0.0 }, 1e-12);
    let expected = [9e-4 / 3.0, 9e-4 / 3.0 + 1e-4, 0.12_f64.powi(2) / 3.0 + 1e-4];
    assert!((0..3).all(|axis| (after.covariance[(axis, axis)] - expected[axis]).abs() < 1e-12), "{after:?}");
}

#[test]
fn correspondences_that_contradict_the_others_are_left_out() {
    let truth = Pose { x_m: 0.4, y_m: -0.3, heading_rad: 2.0 };
    let places = [PLACES[0], PLACES[1], PLACES[2], PLACES[3], [0.0, 4.0]];
    let seen = |place| round(in_robot(truth, place), 1e-4);
    let mut matches: Vec<_> = places.iter().map(|place| (round(*place, 1e-4), seen(*place))).collect();
    // Two of the correspondences between landmarks and points seen are exchanged with each other.
    (matches[0].1, matches[4].1) = (matches[4].1, matches[0].1);
    let (pose, agree) = ransac(&matches).unwrap();
    assert_near(pose.pose, truth, 1e-9);
    assert_eq!(agree, [false, true, true, true, false]);
    // Two of these three correspondences are the exchanged ones, so that no three of them agree on a pose.
    assert!(ransac(&[matches[0], matches[1], matches[4]]).is_none());
}

#[test]
fn a_landmark_first_taken_for_another_is_put_right() {
    let codes: Vec<LandmarkId> = (0..5).map(LandmarkId).collect();
    let places = [PLACES[0], PLACES[1], PLACES[2], PLACES[3], [0.0, 4.0]];
    let view = |pose: Pose, n: usize| -> Vec<(LandmarkId, WeightedPoint)> {
        (0..n).map(|index| (codes[index], round(in_robot(pose, places[index]), 1e-4))).collect()
    };
    let mut map = RansacMap::default();
    let start = exactly(Pose::default());
    // The first view sees the code of the last landmark at a place where there is no landmark, so that its position is learnt wrongly.
    let mut wrong = view(Pose::default(), 5);
    wrong[4].1 = round([1.0, 1.0], 1e-4);
    assert_near(map.fix(&wrong, start).pose, Pose::default(), 1e-12);
    let moved = Pose { x_m: 0.2, y_m: 0.1, heading_rad: 0.3 };
    (0..2).for_each(|_| assert_near(map.fix(&view(moved, 5), start).pose, moved, 1e-9));
    // Of these three sightings one is of the last landmark. They agree on a pose only if the position learnt for that landmark has been corrected;
    // otherwise the map would return the predicted pose.
    let by_last: Vec<_> = view(moved, 5).into_iter().skip(2).collect();
    let predicted = WeightedPose::of_bounds(Pose { x_m: 0.25, ..moved }, [0.1; 3]);
    assert_near(map.fix(&by_last, predicted).pose, moved, 1e-9);
    // Three sightings may agree on a wrong pose by chance. So they must not move a robot whose pose is exactly known from odometry; five sightings
    // must move it.
    assert_near(map.fix(&by_last, start).pose, Pose::default(), 1e-12);
    assert_near(map.fix(&view(moved, 5), start).pose, moved, 1e-9);
}

#[test]
fn gated_closest_points_match_one_to_one_learn_what_is_new_and_refuse_what_odometry_excludes() {
    let view = |pose: Pose, places: &[[f64; 2]]| -> Vec<WeightedPoint> {
        places.iter().map(|place| round(in_robot(pose, *place), 1e-4)).collect()
    };
    let about = |pose: Pose| WeightedPose::of_bounds(pose, [0.2, 0.2, 0.1]);
    let mut map = GatedIcp::default();
    map.fix(&view(Pose::default(), &PLACES), about(Pose::default()));
    assert_eq!(map.n_landmarks(), 4);
    // The predicted pose is 5 cm and 0.03 rad off. The four landmarks are seen in another order, together with a fifth one that is new.
    let truth = Pose { x_m: 0.5, y_m: 0.2, heading_rad: 0.1 };
    let mut places: Vec<[f64; 2]> = PLACES.iter().rev().copied().collect();
    places.push([0.0, 4.0]);
    let predicted = about(Pose { x_m: 0.55, y_m: 0.2, heading_rad: 0.13 });
    assert_near(map.fix(&view(truth, &places), predicted).pose, truth, 1e-9);
    assert_eq!(map.n_landmarks(), 5);
    // A second point is seen 2 cm beside a landmark: the nearer of the two points is matched with the landmark, and the other is neither
    // matched with another landmark nor taken for a new one.
    places.push([3.0, 2.02]);
    assert_near(map.fix(&view(truth, &places), about(truth)).pose, truth, 1e-9);
    assert_eq!(map.n_landmarks(), 5);
    // If the robot is moved by a metre while odometry claims to know its pose exactly, no seen point is near enough to a landmark to be matched
    // (within the gate), so that the pose by odometry is kept.
    let away = Pose { x_m: truth.x_m + 1.0, ..truth };
    let kept = map.fix(&view(away, &PLACES), exactly(truth));
    assert_near(kept.pose, truth, 1e-12);
}
