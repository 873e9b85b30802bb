//! Every solver of the pose from landmarks, on random scenes with known landmarks: none ever loses the true pose, however wrong up to q of the
//! landmarks are.
//!
//! `WHEREIN_LANDMARK_TRIALS` sets the number of scenes for each solver and each q.

use interval::{Interval, contractor::Contractor};
use localizer::{
    PoseBox,
    methods::range_landmarks::{Freedom, PoseFromLandmarks, Sensor, Solver},
    rigid_motion::Landmark as Pair,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::range_landmarks_setup::{
    Confusion, REACH, TrueCamera, box_around, corner, landmarks_in_view, measured, random, robot,
};

fn n_trials() -> usize {
    std::env::var("WHEREIN_LANDMARK_TRIALS").ok().and_then(|text| text.parse().ok()).unwrap_or(2000)
}

#[test]
fn the_box_of_a_sighting_holds_its_landmark_and_not_much_more() {
    // Image columns are resolved so finely here that the width of a sighting's box comes from optics, mount and tilts alone. The stamp has no error,
    // so that the image was taken exactly at its stamp.
    const FINE_PX: [f64; 2] = [1e-3, 1e-4];
    let mut rng = random(10);
    let mut model = robot(0, 3);
    let optics = model.range_camera.as_mut().expect("a range camera");
    (optics.step_px, optics.stamp_error_s) = (FINE_PX, 0.0);
    let sensor = Sensor::new(&model).expect("a range camera");
    let (mut n, mut fullest) = (0, 0.0_f64);
    while n < 20_000 {
        let truth = [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0), rng.random_range(-7.0..7.0)];
        let camera = TrueCamera::drawn(&mut rng).with_steps(FINE_PX);
        for mark in landmarks_in_view(5, truth, &mut rng) {
            let Some(sighting) = camera.sight(truth, &mark, &mut rng) else { continue };
            let seen = sensor.seen(&sighting).in_robot_m;
            let (sin, cos) = f64::sin_cos(truth[2]);
            let [x_m, y_m] = [mark.xy()[0] - truth[0], mark.xy()[1] - truth[1]];
            let truly = [cos * x_m + sin * y_m, cos * y_m - sin * x_m];
            for axis in 0..2 {
                assert!(seen[axis].contains(truly[axis]), "{truly:?} is not in {seen:?}");
                fullest = fullest.max((truly[axis] - seen[axis].mid()).abs() / (0.5 * seen[axis].width()));
            }
            n += 1;
        }
    }
    // Among so many random sightings the worst error nearly reaches the edge of its box, so that no term of the bound is superfluous.
    println!("{n} boxes, filled to {:.1} %", 100.0 * fullest);
    assert!(fullest > 0.85, "{fullest}");
}

#[test]
fn the_box_of_a_sighting_holds_its_landmark_whatever_the_robot_did_since_the_stamp() {
    const FINE_PX: [f64; 2] = [1e-3, 1e-4];
    const LATE_S: f64 = 0.05;
    let mut rng = random(20);
    let mut model = robot(0, 3);
    let optics = model.range_camera.as_mut().expect("a range camera");
    (optics.step_px, optics.stamp_error_s) = (FINE_PX, LATE_S);
    let sensor = Sensor::new(&model).expect("a range camera");
    let mut fullest = 0.0_f64;
    for _ in 0..10_000 {
        let seen_from: [f64; 3] =
            [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0), rng.random_range(-7.0..7.0)];
        let camera = TrueCamera::drawn(&mut rng).with_steps(FINE_PX);
        let Some(mark) = landmarks_in_view(1, seen_from, &mut rng).pop() else { continue };
        let Some(sighting) = camera.sight(seen_from, &mark, &mut rng) else { continue };
        // The true pose at the stamp differs from the pose from which the landmark was seen: within the stamp's error the robot moved straight at up
        // to its full speed and turned at up to its full rate.
        let (share, turned, way) = (corner(&mut rng), corner(&mut rng), rng.random_range(0.0..std::f64::consts::TAU));
        let moved_m = REACH.speed_m_per_s * LATE_S * share;
        let heading = seen_from[2] + REACH.turn_rate_rad_per_s * LATE_S * turned;
        let (x_m, y_m) = (seen_from[0] + moved_m * way.cos(), seen_from[1] + moved_m * way.sin());
        let (sin, cos) = heading.sin_cos();
        let (across, along) = (mark.xy()[0] - x_m, mark.xy()[1] - y_m);
        let (truly, seen) =
            ([cos * across + sin * along, cos * along - sin * across], sensor.seen(&sighting).in_robot_m);
        for axis in 0..2 {
            assert!(seen[axis].contains(truly[axis]), "{truly:?} is not in {seen:?}");
            fullest = fullest.max((truly[axis] - seen[axis].mid()).abs() / (0.5 * seen[axis].width()));
        }
    }
    assert!(fullest > 0.9, "filled to {fullest} only");
}

#[test]
fn a_pitched_body_sees_a_landmark_nearer_than_it_is() {
    // Everything is exact but the tilt of the robot's body, which is declared to be up to 0.1 rad. When the body is pitched by 0.1 rad, a landmark 5
    // m ahead at the height of the lens is 5·cos 0.1 m away along the optical axis: 25 mm less, which no error of the landmark's height explains.
    let exact = Interval::point;
    let mut model = robot(0, 3);
    model.body.tilt_rad = 0.1;
    let optics = model.range_camera.as_mut().expect("a range camera");
    (optics.focal_px, optics.baseline_m, optics.yaw_rad) = (exact(580.0), exact(0.075), exact(0.0));
    (optics.position_m, optics.height_m, optics.height_span_m) = ([exact(0.0); 2], 0.0, 0.0);
    (optics.tilt_rad, optics.stamp_error_s, optics.step_px) = (0.0, 0.0, [1e-6; 2]);
    let right_px = 319.5 - 580.0 * 0.075 / (5.0 * 0.1_f64.cos());
    let sighting =
        localizer::reading::Sighting { landmark: localizer::reading::LandmarkId(0), left_px: 319.5, right_px };
    let [forward, left] = Sensor::new(&model).expect("a range camera").seen(&sighting).in_robot_m;
    assert!(forward.contains(5.0) && left.contains(0.0) && forward.width() < 0.12, "{forward:?}, {left:?}");
}

#[test]
fn one_landmark_seen_from_a_known_place_tells_the_heading() {
    // The robot's position (0, 0) is known, and a landmark at (3, 0) is seen at (3, 0), to within 3 mm across the line of sight: the heading is known
    // to 1 mrad to each side.
    let landmark = (
        [measured(3.0, 1e-6, &mut random(1)), measured(0.0, 1e-6, &mut random(2))],
        [Interval::centred(3.0, 0.01), Interval::centred(0.0, 0.003)],
    );
    let known = Interval::centred(0.0, 1e-6);
    let prior = PoseBox::from([known, known, Interval::centred(0.0, 0.5)]);
    for solver in [Solver::OneShot, Solver::Polar, Solver::TableIv] {
        let branches = PoseFromLandmarks::new(vec![landmark], 0, Freedom::Full, solver).branches(&prior);
        let hull = branches.iter().fold(PoseBox::EMPTY, |hull, branch| hull.hull(branch));
        assert!(hull[2].contains(0.0009) && hull[2].width() < 0.0025, "{solver:?}: {:?}", hull[2]);
    }
}

/// A random scene for a solver: true pose, prior, and each landmark's known place paired with its sighting.
struct Scene {
    truth: [f64; 3],
    prior: PoseBox,
    pairs: Vec<Pair>,
}

fn scene(q: usize, freedom: Freedom, rng: &mut ChaCha8Rng) -> Scene {
    let truth = [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0), rng.random_range(-7.0..7.0)];
    let camera = TrueCamera::drawn(rng);
    let sensor = Sensor::new(&robot(q, 3)).expect("a range camera");
    let marks = landmarks_in_view(rng.random_range(3..21), truth, rng);
    let mut sightings: Vec<_> = marks.iter().filter_map(|mark| camera.sight(truth, mark, rng)).collect();
    let codes: Vec<_> = marks.iter().map(|mark| mark.code).collect();
    Confusion::new(q, 0).confuse(&mut sightings, &codes, 0.5, rng);
    let radius_m = [0.1, 0.02, 0.003][rng.random_range(0..3)];
    let places: Vec<_> = marks.iter().map(|mark| mark.xy().map(|value| measured(value, radius_m, rng))).collect();
    let pairs = sightings
        .iter()
        .map(|sighting| sensor.seen(sighting))
        .map(|seen| (places[seen.landmark.0 as usize], seen.in_robot_m))
        .collect();
    // Some solvers take the heading from the prior box and do not solve for it. They need a prior with a narrow heading to be of any use, but not to
    // be right.
    let wide = if freedom == Freedom::Full { [3.0, 3.0, std::f64::consts::PI] } else { [3.0, 3.0, 0.1] };
    let prior = box_around(truth, [wide, [0.3, 0.3, 0.2], [0.03, 0.03, 0.02]][rng.random_range(0..3)], rng);
    Scene { truth, prior, pairs }
}

/// Solves many random scenes and asserts that none loses the truth; returns the mean ratio of the width in x after solving to the width before.
fn never_lost(freedom: Freedom, solver: Solver, q: usize, seed: u64) -> f64 {
    let mut rng = random(seed);
    let mut share = 0.0;
    for trial in 0..n_trials() {
        let Scene { truth, prior, pairs } = scene(q, freedom, &mut rng);
        let contractor = PoseFromLandmarks::new(pairs, q, freedom, solver);
        let branches = contractor.branches(&prior);
        assert!(
            branches.iter().any(|branch| branch.contains(&truth)),
            "{freedom:?}, {solver:?}, q = {q}, scene {trial}: {truth:?} lost, {branches:?} left of {prior:?}"
        );
        assert!(
            branches.iter().all(|branch| branch.is_subset_of(&prior)),
            "{freedom:?}, {solver:?}, scene {trial}: grew"
        );
        let hull = branches.iter().fold(PoseBox::EMPTY, |hull, branch| hull.hull(branch));
        share += hull.width(0) / prior.width(0) / n_trials() as f64;
    }
    println!("{freedom:?}, {solver:?}, q = {q}: 0 of {} truths lost, x narrowed to {share:.3} on average", n_trials());
    share
}

#[test]
fn one_shot_never_loses_the_truth() {
    assert!(never_lost(Freedom::Full, Solver::OneShot, 0, 11) < 0.4);
}

#[test]
fn one_shot_survives_wrong_correspondences() {
    for q in [1, 2] {
        assert!(never_lost(Freedom::Full, Solver::OneShot, q, 12) < 0.8);
    }
}

#[test]
fn polar_never_loses_the_truth() {
    assert!(never_lost(Freedom::Full, Solver::Polar, 0, 13) < 0.6);
}

#[test]
fn polar_survives_wrong_correspondences() {
    never_lost(Freedom::Full, Solver::Polar, 1, 14);
}

#[test]
fn the_corrected_table_never_loses_the_truth() {
    assert!(never_lost(Freedom::Full, Solver::TableIv, 0, 15) < 0.9);
}

#[test]
fn the_corrected_table_survives_wrong_correspondences() {
    never_lost(Freedom::Full, Solver::TableIv, 1, 16);
}

#[test]
fn bisection_never_loses_the_truth() {
    assert!(never_lost(Freedom::Full, Solver::Sivia { resolution: 0.3 }, 0, 17) < 0.5);
}

#[test]
fn bisection_survives_wrong_correspondences() {
    never_lost(Freedom::Full, Solver::Sivia { resolution: 1.0 }, 1, 18);
}

#[test]
fn tables_without_a_turn_hold_for_any_motion() {
    for freedom in [Freedom::Line, Freedom::Translation] {
        for q in [0, 1, 2] {
            assert!(never_lost(freedom, Solver::OneShot, q, 19) < 0.9);
        }
    }
}
