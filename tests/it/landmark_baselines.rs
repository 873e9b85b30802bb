//! What stands beside our boxes: least squares and closest points, bare and as one would field them, and Table IV as it is printed.

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

/// Paper 3's landmarks.
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

/// A point that is known alike in all directions.
fn round([x_m, y_m]: [f64; 2], variance_m2: f64) -> WeightedPoint {
    WeightedPoint { at_m: Vector2::new(x_m, y_m), covariance_m2: Matrix2::identity() * variance_m2 }
}

fn exactly(pose: Pose) -> WeightedPose {
    WeightedPose { pose, covariance: Matrix3::zeros() }
}

/// Landmarks with errors of up to ±0.1 m in both frames.
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
    // Seen mirrored, the best rotation is still a rotation: three points nearly on a line, one of them on the wrong side.
    let pairs = [([0.0, 0.0], [0.0, 0.0]), ([1.0, 0.1], [1.0, -0.1]), ([2.0, 0.0], [2.0, 0.0])];
    assert_near(least_squares(&pairs).unwrap(), Pose { x_m: 0.0, y_m: 0.2 / 3.0, heading_rad: 0.0 }, 1e-12);
}

#[test]
fn closest_points_find_the_pose_from_nearby_only() {
    let truth = Pose { x_m: 0.4, y_m: -0.3, heading_rad: 0.2 };
    let view: Vec<_> = PLACES.iter().rev().map(|place| in_robot(truth, *place)).collect();
    assert_near(closest_points(&PLACES, &view, Pose::default()), truth, 1e-9);
    // From half a turn away each point is nearest to the wrong one: without codes there is no telling.
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
    // Quarters from −180°. Arcsine and arccosine together say 0 to 90°.
    for (quarter, [kept, all]) in kept_by_quarter.into_iter().enumerate() {
        let share = kept as f64 / all as f64;
        assert!(if quarter == 2 { share > 0.9 } else { share == 0.0 }, "quarter {quarter}: {share}");
    }
}

#[test]
fn in_the_papers_own_problem_the_printed_table_is_wider_than_one_shot() {
    // Errors as in the paper's Fig. 5 problem, shares of 0.1 m.
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
    // One pass of the rigid contractor is already sound, and wider.
    let mut once = prior;
    RigidPlanar::new(&landmarks).contract(&mut once);
    assert!((0..3).all(|axis| ours[0].width(axis) <= once.width(axis)));
}

#[test]
fn a_stereo_sight_errs_along_its_ray_by_range_over_baseline_more_than_across() {
    // 4 m ahead, in a box of ±3 cm by ±4 cm: half its diagonal is 5 cm, of which 0.12 m in 4 m is 1.5 mm across.
    let in_robot_m = [Interval::centred(4.0, 0.03), Interval::centred(0.0, 0.04)];
    let seen = WeightedPoint::of_stereo(in_robot_m, 0.12);
    let expected = Matrix2::new(0.05_f64.powi(2) / 3.0, 0.0, 0.0, 0.0015_f64.powi(2) / 3.0);
    assert!((seen.covariance_m2 - expected).amax() < 1e-12, "{seen:?}");
    // On the diagonal of the frame both axes have half of the two variances.
    let askew = WeightedPoint::of_stereo([Interval::centred(3.0, 0.04), Interval::centred(3.0, 0.03)], 0.0);
    assert!((askew.covariance_m2 - Matrix2::repeat(0.5 * 0.0025 / 3.0)).amax() < 1e-12, "{askew:?}");
}

#[test]
fn a_weighted_fit_is_the_weighted_mean_where_that_is_all_there_is() {
    // Both on the x axis, so that a turn moves neither along it: one asks for 3 cm with variance 1, the other for none with variance 2.
    let matches =
        [(round([1.03, 0.0], 0.0), round([1.0, 0.0], 1.0)), (round([-1.0, 0.0], 0.0), round([-1.0, 0.0], 2.0))];
    let fit = weighted_fit(&matches, None).unwrap();
    assert_near(fit.pose, Pose { x_m: 0.02, y_m: 0.0, heading_rad: 0.0 }, 1e-9);
    // The mean's variance: 1 / (1 + 1/2).
    assert!((fit.covariance[(0, 0)] - 2.0 / 3.0).abs() < 1e-9, "{fit:?}");
    assert!(weighted_fit(&matches[..1], None).is_none());
}

#[test]
fn a_landmark_is_the_weighted_mean_of_its_sights() {
    let here = exactly(Pose::default());
    let mut learnt = LearntPoint::new(&round([1.0, 0.0], 1e-4), &here).unwrap();
    learnt.learn(&round([1.02, 0.0], 3e-4), Pose::default());
    let place = learnt.place();
    // (3·1.00 + 1·1.02)/4, and 1/(1 + 1/3) of the first variance.
    assert!((place.at_m - Vector2::new(1.005, 0.0)).norm() < 1e-12, "{place:?}");
    assert!((place.covariance_m2 - Matrix2::identity() * 0.75e-4).amax() < 1e-12, "{place:?}");
    // First seen from a heading with a variance of 1e-4, it inherits that times its distance squared, across, for good.
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
    // Straight on by 1 m, heading known to a variance of 1e-4: 3 cm of slip in either wheel, and 2·3 cm/0.5 m of turn.
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
    // Two are taken for each other.
    (matches[0].1, matches[4].1) = (matches[4].1, matches[0].1);
    let (pose, agree) = ransac(&matches).unwrap();
    assert_near(pose.pose, truth, 1e-9);
    assert_eq!(agree, [false, true, true, true, false]);
    // Of three of which two are exchanged no three agree.
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
    // The last code is first seen where nothing is.
    let mut wrong = view(Pose::default(), 5);
    wrong[4].1 = round([1.0, 1.0], 1e-4);
    assert_near(map.fix(&wrong, start).pose, Pose::default(), 1e-12);
    let moved = Pose { x_m: 0.2, y_m: 0.1, heading_rad: 0.3 };
    (0..2).for_each(|_| assert_near(map.fix(&view(moved, 5), start).pose, moved, 1e-9));
    // Three agree only if the last code's place is the right one by now; otherwise this would be the prediction.
    let by_last: Vec<_> = view(moved, 5).into_iter().skip(2).collect();
    let predicted = WeightedPose::of_bounds(Pose { x_m: 0.25, ..moved }, [0.1; 3]);
    assert_near(map.fix(&by_last, predicted).pose, moved, 1e-9);
    // Three may agree by chance, so that they do not move a robot that odometry knows to be elsewhere; five do.
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
    // Predicted 5 cm and 0.03 rad off, in another order, with a fifth that is new.
    let truth = Pose { x_m: 0.5, y_m: 0.2, heading_rad: 0.1 };
    let mut places: Vec<[f64; 2]> = PLACES.iter().rev().copied().collect();
    places.push([0.0, 4.0]);
    let predicted = about(Pose { x_m: 0.55, y_m: 0.2, heading_rad: 0.13 });
    assert_near(map.fix(&view(truth, &places), predicted).pose, truth, 1e-9);
    assert_eq!(map.n_landmarks(), 5);
    // A second sight 2 cm beside one landmark's own: the nearer is of it, the other is neither of another nor new.
    places.push([3.0, 2.02]);
    assert_near(map.fix(&view(truth, &places), about(truth)).pose, truth, 1e-9);
    assert_eq!(map.n_landmarks(), 5);
    // Put a metre away: nothing is within the gate, so that odometry stands.
    let away = Pose { x_m: truth.x_m + 1.0, ..truth };
    let kept = map.fix(&view(away, &PLACES), exactly(truth));
    assert_near(kept.pose, truth, 1e-12);
}
