//! The P3P solver on random problems of two kinds: triangles anywhere in front of the camera, and small ones far away.

use nalgebra::{Rotation3, Unit};

use super::*;
use crate::vision::synthetic::Random;

/// A problem whose true solution is known: rays, points in the world, and the camera's pose.
type Problem = ([Vector3<f64>; 3], [Vector3<f64>; 3], CameraPose);

/// A random camera pose with three random points in front of the camera, drawn at random from the ranges that Persson and Nordberg use in their
/// paper on P3P.
fn scattered(random: &mut Random) -> Problem {
    let mut normal = || Vector3::new(random.normal(), random.normal(), random.normal());
    let axis = Unit::new_normalize(normal());
    let translation_m = normal();
    let rotation = Rotation3::from_axis_angle(&axis, random.between(-3.1, 3.1)).into_inner();
    let mut ray = || Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 1.0);
    let rays = [ray(), ray(), ray()];
    let seen = rays.map(|ray| ray * random.between(0.1, 10.0));
    let points_m = seen.map(|point| rotation.transpose() * (point - translation_m));
    (rays, points_m, CameraPose { rotation, translation_m })
}

/// A small triangle far from the camera: sides of 0.1 to 0.3 m, 2 to 3 m away, and turned by up to half a radian from facing the camera. Every
/// other triangle is right-angled with two equal sides, like the three direction dots of a marker.
fn marker(random: &mut Random) -> Problem {
    let sides_m = [random.between(0.1, 0.3), random.between(0.1, 0.3)];
    let (sides_m, angle_rad) = match random.chance(0.5) {
        true => ([sides_m[0]; 2], std::f64::consts::FRAC_PI_2),
        false => (sides_m, random.between(0.5, 2.6)),
    };
    let along = Vector3::new(angle_rad.cos(), angle_rad.sin(), 0.0);
    let points_m = [Vector3::x() * sides_m[0], Vector3::zeros(), along * sides_m[1]];
    let lean = Vector3::new(random.between(-0.35, 0.35), random.between(-0.35, 0.35), 0.0);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), random.between(-3.1, 3.1));
    let rotation = (Rotation3::new(lean) * turn).into_inner();
    let place = Vector3::new(random.between(-0.5, 0.5), random.between(-0.4, 0.4), 1.0);
    let translation_m = place * random.between(2.0, 3.0);
    let rays = points_m.map(|point| rotation * point + translation_m).map(|seen| seen / seen.z);
    (rays, points_m, CameraPose { rotation, translation_m })
}

/// What came out of many problems of one kind.
#[derive(Debug, Default)]
struct Tally {
    /// Problems without a solution near the true pose.
    missed: usize,
    /// Solutions from which the points are not seen along their rays, or whose motion is not rigid.
    wrong: usize,
    /// Solutions that are the same as another one of the same problem.
    repeated: usize,
    /// Numbers of problems with 0, 1, 2, 3 and 4 solutions.
    solutions: [usize; 5],
    /// Distance of the nearest solution from the true pose that half of the problems stay below, and that 99 % of them do.
    errors: [f64; 2],
}

fn tally(problem: fn(&mut Random) -> Problem, rounds: usize, seed: u64) -> Tally {
    let mut random = Random::new(seed);
    let mut tally = Tally::default();
    let mut errors = Vec::with_capacity(rounds);
    let distance = |a: &CameraPose, b: &CameraPose| {
        (a.rotation - b.rotation).abs().sum() + (a.translation_m - b.translation_m).abs().sum()
    };
    for _ in 0..rounds {
        let (rays, points_m, truth) = problem(&mut random);
        let poses = solve(&rays, &points_m);
        errors.push(poses.iter().map(|pose| distance(pose, &truth)).fold(f64::INFINITY, f64::min));
        tally.missed += usize::from(errors.last().is_none_or(|error| *error >= 1e-6));
        tally.solutions[poses.len().min(4)] += 1;
        for (idx, pose) in poses.iter().enumerate() {
            let is_right = (0..3).all(|k| {
                let seen = pose.rotation * points_m[k] + pose.translation_m;
                seen.z > 0.0 && (seen / seen.z - rays[k]).norm() < 1e-6
            });
            let is_rigid = (pose.rotation.transpose() * pose.rotation - Matrix3::identity()).norm() < 1e-6
                && pose.rotation.determinant() > 0.0;
            tally.wrong += usize::from(!is_right || !is_rigid);
            tally.repeated += usize::from(poses[..idx].iter().any(|other| distance(other, pose) < 1e-6));
        }
    }
    errors.sort_by(f64::total_cmp);
    tally.errors = [0.5, 0.99].map(|share| errors[(share * (rounds - 1) as f64) as usize]);
    println!("{rounds} problems: {tally:?}");
    tally
}

/// Number of problems of each kind: `$WHEREIN_P3P_PROBLEMS`, or as many as take a moment.
fn rounds() -> usize {
    std::env::var("WHEREIN_P3P_PROBLEMS").ok().and_then(|text| text.parse().ok()).unwrap_or(1_000_000)
}

/// Greatest number of problems that may be missed: 1.5 in a million, all of them near double roots; of fewer than some millions a few.
fn most_missed() -> usize {
    ((1.5e-6 * rounds() as f64) as usize).max(4)
}

#[test]
fn the_true_pose_is_found_and_every_solution_is_one() {
    let tally = tally(scattered, rounds(), 5);
    assert_eq!(tally.wrong, 0);
    assert!(tally.missed <= most_missed(), "{tally:?}");
}

#[test]
fn small_triangles_far_away_are_solved_as_surely_and_as_exactly_as_doubles_allow() {
    let tally = tally(marker, rounds(), 7);
    assert_eq!(tally.wrong, 0);
    assert!(tally.missed <= most_missed(), "{tally:?}");
    // By hand: rays are rounded by 1.1e-16. From a triangle of 0.2 m at 2.5 m a depth errs by 2.5²/0.2 times that, 3e-15 m, and a turn by 1e-15;
    // cosines of the angles, rounded where they are almost 1, would make both 50 times as great.
    assert!(tally.errors[0] < 1e-13 && tally.errors[1] < 2e-12, "{tally:?}");
}

#[test]
fn solving_takes_less_than_two_microseconds() {
    for problem in [scattered, marker] {
        let mut random = Random::new(6);
        let problems: Vec<_> = (0..2000).map(|_| problem(&mut random)).collect();
        let mut micros: Vec<f64> = problems
            .chunks(20)
            .map(|chunk| {
                let start = std::time::Instant::now();
                let count: usize = chunk.iter().map(|(rays, points_m, _)| solve(rays, points_m).len()).sum();
                let micros = start.elapsed().as_secs_f64() * 1e6 / chunk.len() as f64;
                if count == 0 { f64::INFINITY } else { micros }
            })
            .collect();
        micros.sort_by(f64::total_cmp);
        println!("median {:.2} µs, best {:.2} µs", micros[micros.len() / 2], micros[0]);
        // The best time is tested, because the machine may be busy; the limit is some three times what a quiet machine takes. With Newton steps that
        // go on to a residual below the rounding error, which far small triangles never reach, it took 2.7 µs.
        assert!(micros[0] < 2.0, "{} µs", micros[0]);
    }
}

#[test]
fn points_in_a_line_have_no_pose() {
    let point = |x: f64| Vector3::new(x, 0.0, 0.0);
    let ray = |x: f64| Vector3::new(x, 0.0, 1.0);
    assert!(solve(&[ray(0.0), ray(0.1), ray(0.2)], &[point(0.0), point(1.0), point(2.0)]).is_empty());
}
