//! What stands beside our boxes: least squares, closest points, and Table IV as it is printed.

use localizer::{
    Contractor, Interval, Pose, PoseBox,
    baselines::{SOLVERS, closest_points, least_squares, printed_table_iv, solve},
    contractor::{Landmark, RigidPlanar},
};
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
