//! Tests of the laws of contractors on random problems with known solutions, often at a corner of the box: the result is a subset, no solution is
//! lost, and a fixpoint stays unchanged.

use interval::contractor::{
    Contractor, Distance, ForwardBackward, Outcome, Periodic, Pinhole, Polar, QRelaxed, Within,
};
use interval::{Interval, IntervalBox};
use localizer::rigid_motion::{Landmark, RelaxedPose, RigidPolar, RigidTable, Translated};
use proptest::prelude::*;

/// Relative allowance for the rounding of a solution that is computed in doubles.
const ROUNDING: f64 = 1e-12;

/// An interval of the given width around a value; `share` says where in the interval the value lies, from 0 at the lower end to 1 at the upper
/// end.
fn around(value: f64, width: f64, share: f64) -> Interval {
    let rounding = ROUNDING * (1.0 + value.abs());
    Interval::new(value - share * width - rounding, value + (1.0 - share) * width + rounding)
}

/// Random position of a value in its interval, as a share of the interval's width: often at either end.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..1.0]
}

/// Random widths of intervals, from 0 to more than the size of the problem.
fn width() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 0.0..0.01, 0.0..1.0, 0.0..30.0]
}

fn surroundings() -> impl Strategy<Value = (f64, f64)> {
    (width(), share())
}

fn check_laws<const N: usize>(contractor: &impl Contractor<N>, domain: IntervalBox<N>, solution: [f64; N]) {
    assert!(domain.contains(&solution), "the test itself is wrong");
    let mut contracted = domain;
    assert_eq!(contractor.contract(&mut contracted), Outcome::Feasible);
    assert!(contracted.is_subset_of(&domain), "{contracted:?} is not in {domain:?}");
    assert!(contracted.contains(&solution), "{solution:?} lost: {contracted:?} of {domain:?}");
    let branches = contractor.branches(&domain);
    assert!(branches.iter().any(|branch| branch.contains(&solution)), "{solution:?} is in no branch of {domain:?}");
    assert!(branches.iter().all(|branch| !branch.is_empty() && branch.is_subset_of(&domain)));
    // Contraction is repeated until the box no longer changes (a fixpoint); no pass may enlarge the box or lose the solution.
    let mut fixpoint = contracted;
    for _ in 0..5000 {
        let before = fixpoint;
        contractor.contract(&mut fixpoint);
        assert!(fixpoint.is_subset_of(&before) && fixpoint.contains(&solution));
        if fixpoint == before {
            return;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn distance_keeps_its_laws(
        x in -10.0..10.0f64, y in -10.0..10.0f64, a in -10.0..10.0f64, b in -10.0..10.0f64,
        s in proptest::collection::vec(surroundings(), 5),
    ) {
        let distance = ((x - a).powi(2) + (y - b).powi(2)).sqrt();
        let [x_box, y_box, a_box, b_box, d_box] =
            [(x, s[0]), (y, s[1]), (a, s[2]), (b, s[3]), (distance, s[4])].map(|(v, (w, share))| around(v, w, share));
        let contractor = Distance { centre: [a_box, b_box], distance: d_box };
        check_laws(&contractor, IntervalBox::new([x_box, y_box]), [x, y]);
    }

    #[test]
    fn polar_keeps_its_laws(
        range in prop_oneof![Just(0.0), 0.0..20.0f64], angle in -20.0..20.0f64,
        quarter in any::<bool>(), s in proptest::collection::vec(surroundings(), 4),
    ) {
        // The contractor treats each quadrant of a heading by itself. Quadrants meet at headings along the axes, so half of the test's angles are
        // multiples of a quarter turn.
        let angle = if quarter { (angle / 1.6).round() * std::f64::consts::FRAC_PI_2 } else { angle };
        let solution = [range * angle.cos(), range * angle.sin(), range, angle];
        let domain = IntervalBox::new(std::array::from_fn(|idx| around(solution[idx], s[idx].0, s[idx].1)));
        check_laws(&Polar, domain, solution);
    }

    #[test]
    fn periodic_keeps_its_laws(
        period in 0.01..2.0f64, offset in -5.0..5.0f64, index in -50..50i32, s in proptest::collection::vec(surroundings(), 2),
    ) {
        let contractor = Periodic { period: around(period, 0.001 * s[1].0.min(1.0), s[1].1), offset: around(offset, 0.01, s[0].1) };
        let solution = offset + f64::from(index) * period;
        check_laws(&contractor, IntervalBox::new([around(solution, s[0].0, s[0].1)]), [solution]);
    }

    #[test]
    fn pinhole_keeps_its_laws(
        x in -5.0..5.0f64, y in -5.0..5.0f64, z in 0.01..20.0f64, s in proptest::collection::vec(surroundings(), 6),
    ) {
        let focal = 320.0;
        let solution = [x, y, z, focal * x / z, focal * y / z];
        let domain = IntervalBox::new(std::array::from_fn(|idx| around(solution[idx], s[idx].0, s[idx].1)));
        check_laws(&Pinhole { focal_px: around(focal, s[5].0.min(5.0), s[5].1) }, domain, solution);
    }

    #[test]
    fn forward_backward_keeps_its_laws(
        x in -3.0..3.0f64, y in -3.0..3.0f64, formula in 0..10usize, s in proptest::collection::vec(surroundings(), 3),
    ) {
        let domain = IntervalBox::new([around(x, s[0].0, s[0].1), around(y, s[1].0, s[1].1)]);
        let unknown = Interval::ZERO;
        let (contractor, value) = match formula {
            0 => (ForwardBackward::new(|[x, y]| x * y + x, unknown), x * y + x),
            1 => (ForwardBackward::new(|[x, y]| x.sin() - y.cos(), unknown), x.sin() - y.cos()),
            2 => (ForwardBackward::new(|[x, y]| (x / (y + 3.5)).exp(), unknown), (x / (y + 3.5)).exp()),
            3 => (ForwardBackward::new(|[x, y]| x.hypot(y).sqrt(), unknown), x.hypot(y).sqrt()),
            4 => (ForwardBackward::new(|[x, y]| y.atan2(x), unknown), y.atan2(x)),
            5 => (ForwardBackward::new(|[x, y]| x.min(y) + x.max(2.0 * y), unknown), x.min(y) + x.max(2.0 * y)),
            6 => (ForwardBackward::new(|[x, y]| x.pown(3) - y.pown(4), unknown), x.powi(3) - y.powi(4)),
            7 => (ForwardBackward::new(|[x, y]| x.abs() - (y.sqr() + 1.0).log(), unknown), x.abs() - (y * y + 1.0).ln()),
            8 => (ForwardBackward::new(|[x, y]| (x / 3.0).asin() + (y / 3.0).acos(), unknown), (x / 3.0).asin() + (y / 3.0).acos()),
            _ => (ForwardBackward::new(|[x, y]| x.atan() * y.tan(), unknown), x.atan() * y.tan()),
        };
        prop_assume!(value.is_finite() && value.abs() < 1e6);
        check_laws(&contractor.with_range(around(value, s[2].0, s[2].1)), domain, [x, y]);
    }

    #[test]
    fn one_outlier_of_five_ranges_does_not_lose_the_place(
        x in -5.0..5.0f64, y in -5.0..5.0f64, outlier in 0..5usize, error in 1.0..5.0f64, s in proptest::collection::vec(surroundings(), 2),
    ) {
        let beacons = [[6.0, 0.0], [-6.0, 1.0], [0.0, 7.0], [1.0, -6.0], [6.0, 6.0]];
        let contractors = beacons.iter().enumerate().map(|(idx, [a, b])| {
            let distance = f64::hypot(x - a, y - b) + if idx == outlier { error } else { 0.0 };
            let centre = [Interval::point(*a), Interval::point(*b)];
            Box::new(Distance { centre, distance: around(distance, 0.1, 0.5) }) as Box<dyn Contractor<2> + Send + Sync>
        });
        let relaxed = QRelaxed { contractors: contractors.collect(), q: 1 };
        check_laws(&relaxed, IntervalBox::new([around(x, s[0].0, s[0].1), around(y, s[1].0, s[1].1)]), [x, y]);
    }

    #[test]
    fn membership_keeps_its_laws(x in -10.0..10.0f64, y in -10.0..10.0f64, s in proptest::collection::vec(surroundings(), 4)) {
        let boxed = |value: f64, (width, share): (f64, f64)| around(value, width, share);
        let within = Within(IntervalBox::new([boxed(x, s[0]), boxed(y, s[1])]));
        check_laws(&within, IntervalBox::new([boxed(x, s[2]), boxed(y, s[3])]), [x, y]);
    }
}

/// A random pose, random landmarks of which the last `n_wrong` are at wrong places, and a box of poses.
fn landmark_problem(n_wrong: usize) -> impl Strategy<Value = (Vec<Landmark>, IntervalBox<3>, [f64; 3])> {
    let landmark =
        ((-6.0..6.0f64, -6.0..6.0f64), proptest::collection::vec((prop_oneof![Just(0.0), 0.0..0.3], share()), 4));
    let pose = (-3.0..3.0f64, -3.0..3.0f64, -7.0..7.0f64);
    let landmarks = proptest::collection::vec(landmark, 2 + n_wrong..7 + n_wrong);
    (pose, landmarks, proptest::collection::vec(surroundings(), 3), 0..12).prop_map(
        move |((x, y, heading), landmarks, s, known)| {
            let (sin, cos) = heading.sin_cos();
            let n_right = landmarks.len() - n_wrong;
            let seen = landmarks.into_iter().enumerate().map(|(index, ((a, b), errors))| {
                let (across, along) = (a - x, b - y);
                let in_robot = [cos * across + sin * along, cos * along - sin * across];
                let interval = |value: f64, error: usize| around(value, errors[error].0, errors[error].1);
                let shift = if index < n_right { 0.0 } else { 4.0 };
                ([interval(a + shift, 0), interval(b, 1)], [interval(in_robot[0], 2), interval(in_robot[1], 3)])
            });
            // Besides narrow intervals, a heading that is entirely unknown and a heading that is bounded on one side only are tested.
            let known = match known {
                0 => Interval::ENTIRE,
                1 => Interval::new(heading, f64::INFINITY),
                2 => Interval::new(f64::NEG_INFINITY, heading),
                _ => around(heading, s[2].0, s[2].1),
            };
            let domain = IntervalBox::new([around(x, s[0].0, s[0].1), around(y, s[1].0, s[1].1), known]);
            (seen.collect(), domain, [x, y, heading])
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn solvers_for_landmarks_keep_their_laws((landmarks, domain, pose) in landmark_problem(0)) {
        check_laws(&RigidPolar::new(&landmarks), domain, pose);
        check_laws(&RigidTable::new(&landmarks), domain, pose);
        check_laws(&Translated::<1> { landmarks: landmarks.clone(), q: 0 }, domain, pose);
        check_laws(&Translated::<2> { landmarks: landmarks.clone(), q: 0 }, domain, pose);
        check_laws(&RelaxedPose { landmarks, q: 0 }, domain, pose);
    }

    #[test]
    fn solvers_that_allow_wrong_landmarks_keep_their_laws((landmarks, domain, pose) in landmark_problem(2)) {
        check_laws(&Translated::<2> { landmarks: landmarks.clone(), q: 2 }, domain, pose);
        check_laws(&RelaxedPose { landmarks, q: 2 }, domain, pose);
    }
}
