//! Tests of the whole experiment on a few drives, and of the rows on motions in all directions.
#![allow(clippy::unwrap_used)]

use interval::{Interval, contractor::Outcome};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::boxes::{Boxes, contract_all, contract_locally, contract_window};
use crate::drive::{Drive, LANDMARKS_M, Motion, Settings, Step, projected};
use crate::related::relate;
use crate::rows::{Row, Surroundings, quantities};
use crate::witness::hull_from_inside;
use crate::{holds_truth, mean_volume_m3, mean_widths_m};

/// Seeds of the drives in these tests; the settings were chosen by others.
const SEEDS: std::ops::Range<u64> = 0..4;

#[test]
fn no_method_excludes_the_truth_or_a_motion_that_agrees_with_the_data() {
    let (mut ours_m, mut inside_m) = ([0.0; 3], [0.0; 3]);
    let add = |sums_m: &mut [f64; 3], widths_m: [f64; 3]| {
        sums_m.iter_mut().zip(widths_m).for_each(|(sum_m, width_m)| *sum_m += width_m);
    };
    for seed in SEEDS {
        let drive = Drive::new(&Settings::OURS, seed);
        let related = relate(&drive).unwrap();
        let inside = hull_from_inside(&drive, &related.boxes).unwrap();
        let on_boxes = [1, 10, 50].map(|window| contract_window(&drive, window).unwrap().places_m());
        let local = contract_locally(&drive).unwrap().places_m();
        for places_m in on_boxes.into_iter().chain([local, related.places_m]) {
            assert!(holds_truth(&places_m), "seed {seed}");
            for (outer, inner) in places_m.iter().flatten().zip(inside.iter().flatten()) {
                assert!(inner.is_subset_of(*outer), "seed {seed}: {inner} is possible, and not in {outer}");
            }
        }
        add(&mut ours_m, mean_widths_m(&related.places_m));
        add(&mut inside_m, mean_widths_m(&inside));
    }
    // The exact hull is between the two: relations leave at most 5 % more than it has, in the mean.
    for (ours_m, inside_m) in ours_m.into_iter().zip(inside_m) {
        assert!(ours_m < 1.05 * inside_m, "{ours_m} m and {inside_m} m");
    }
}

#[test]
fn longer_windows_leave_smaller_boxes() {
    for seed in SEEDS {
        let drive = Drive::new(&Settings::OURS, seed);
        let local = contract_locally(&drive).unwrap().places_m();
        let [one, ten, fifty] = [1, 10, 50].map(|window| contract_window(&drive, window).unwrap().places_m());
        let shares = [12.0, 10.3, 8.3].map(|percent| 1.0 - percent / 100.0);
        for ((ten, local), share) in mean_widths_m(&ten).into_iter().zip(mean_widths_m(&local)).zip(shares) {
            assert!(ten < share * local, "seed {seed}: {ten} m and {local} m");
        }
        let volumes_m3 = [local, one, ten, fifty].map(|places_m| mean_volume_m3(&places_m));
        assert!(volumes_m3.is_sorted_by(|wider, narrower| wider > narrower), "seed {seed}: {volumes_m3:?}");
    }
}

/// A short drive with turns past landmarks that stay in view, and readings that are at an end of their intervals.
fn any_drive(random: &mut ChaCha8Rng) -> Drive {
    let truth = loop {
        let steps = (0..4).map(|_| [random.random_range(0.0..0.5), random.random_range(-0.6..0.6)]);
        let steps = steps.collect();
        let landmarks = LANDMARKS_M
            .map(|_| [random.random_range(-0.8..0.8), random.random_range(-0.8..0.8), random.random_range(0.01..0.4)]);
        let motion = Motion { steps, landmarks };
        let is_seen = |pose| landmarks.iter().all(|&ray| projected(pose, ray)[0].abs() < 1000.0);
        if motion.poses().into_iter().all(is_seen) {
            break motion;
        }
    };
    let mut end = |value: f64, width: f64| {
        let [below, above] = if random.random_bool(0.5) { [0.0, width] } else { [width, 0.0] };
        Interval::new(value - below, value + above).inflate(1e-12 * (1.0 + value.abs()))
    };
    let steps = truth
        .steps
        .iter()
        .map(|&[distance_m, turn_rad]| Step { distance_m: end(distance_m, 0.1), turn_rad: end(turn_rad, 0.1) });
    let steps = steps.collect();
    let poses = truth.poses().into_iter();
    let pixels = poses.map(|pose| truth.landmarks.map(|ray| projected(pose, ray).map(|at_px| end(at_px, 2.0))));
    Drive { pixels: pixels.collect(), steps, truth }
}

/// The rows of a drive around reference values from which some true quantities deviate, each with the value that it has at the truth.
fn rows_at_truth(random: &mut ChaCha8Rng, drive: &Drive, most: f64) -> Vec<(Row, f64)> {
    let truth = quantities(&drive.truth.poses(), &drive.truth.landmarks);
    // With only a few quantities that deviate, each term of a remainder has drives in which it stands alone.
    let share = random.random_range(0.05..1.0);
    let by: Vec<f64> = truth
        .iter()
        .map(|_| if random.random_bool(share) { most * [-1.0, 1.0, 0.3][random.random_range(0..3)] } else { 0.0 })
        .collect();
    let reference: Vec<f64> = truth.iter().zip(&by).map(|(truth, by)| truth - by).collect();
    let deviations = by.iter().map(|&by| Interval::ZERO.hull(Interval::point(by)).inflate(1e-15)).collect();
    let rows = Surroundings { reference, deviations }.rows(drive);
    let value = |row: &Row| row.terms.iter().map(|&(index, a)| a * by[index]).sum();
    rows.into_iter().map(|row| (row.clone(), value(&row))).collect()
}

#[test]
fn the_truth_satisfies_every_row_at_the_ends_of_all_readings() {
    let random = &mut ChaCha8Rng::seed_from_u64(4);
    for round in 0..20_000 {
        let drive = any_drive(random);
        let most = [1e-3, 0.1, 0.3][round % 3];
        for (row, value) in rows_at_truth(random, &drive, most) {
            let rounding = 1e-8 * (1.0 + row.terms.iter().map(|(_, a)| a.abs()).sum::<f64>());
            assert!(row.sides.inflate(rounding).contains(value), "round {round}: {value} in {row:?}");
        }
    }
}

#[test]
fn contractors_keep_the_truth_of_drives_with_turns() {
    let random = &mut ChaCha8Rng::seed_from_u64(6);
    let mut n_contracted = 0;
    for round in 0..2_000 {
        let drive = any_drive(random);
        let (poses, rays) = (drive.truth.poses(), drive.truth.landmarks);
        let mut around = |value: f64| {
            let [below, above] = [(); 2].map(|()| random.random_range(0.0..0.2));
            Interval::new(value - below, value + above)
        };
        let known = Boxes {
            poses: poses.iter().map(|pose| pose.map(&mut around)).collect(),
            rays: rays.map(|ray| ray.map(&mut around)),
        };
        let (left, outcome) = contract_all(&drive, &known).unwrap();
        assert_eq!(outcome, Outcome::Feasible, "round {round}");
        let sides = left.poses.iter().chain(&left.rays).flatten().zip(poses.iter().chain(&rays).flatten());
        for (side, &truth) in sides {
            assert!(side.inflate(1e-9).contains(truth), "round {round}: {truth} is not in {side}");
        }
        let widths = |boxes: &Boxes| boxes.rays.iter().flatten().map(|side| side.width()).sum::<f64>();
        n_contracted += usize::from(widths(&left) < 0.5 * widths(&known));
    }
    assert!(n_contracted > 500, "only {n_contracted} drives are contracted to half of their landmarks' widths");
}

#[test]
fn rows_that_nothing_deviates_in_are_as_narrow_as_their_readings() {
    let random = &mut ChaCha8Rng::seed_from_u64(5);
    for _ in 0..200 {
        let drive = any_drive(random);
        let n_odometry = 3 * drive.steps.len();
        let rows = rows_at_truth(random, &drive, 0.0);
        for (at, (row, _)) in rows[..n_odometry].iter().enumerate() {
            // Distance and turn are known to 0.1, of which the chord of an arc is shorter by at most 0.35²/6; nothing moves aside.
            let most = [0.1 + 0.6 * 0.0205, 1e-9, 0.1][at % 3];
            assert!(row.sides.width() < most + 1e-9, "{row:?}");
        }
        for pair in rows[n_odometry..].chunks_exact(2) {
            // The truth is at one end of a pixel, where one of two rows holds with nothing to spare.
            let spare = pair.iter().map(|(row, value)| (value - row.sides.lo()).min(row.sides.hi() - value));
            let least = spare.fold(f64::INFINITY, f64::min);
            assert!(least.abs() < 1e-6, "{least} of {pair:?}");
        }
    }
}
