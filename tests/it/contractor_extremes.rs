//! Tests of contractors on extreme boxes, which no problem states but which recovery and bisection produce: unbounded, huge, far away, empty.
//! Every contractor has to return promptly, enlarge no box and lose no solution.

use std::{sync::mpsc, thread, time::Duration};

use interval::contractor::{
    Contractor, Distance, ForwardBackward, Inverse, Periodic, Pinhole, Polar, QRelaxed, Within,
};
use interval::{Interval, IntervalBox};
use localizer::methods::range_landmarks::{Freedom, PoseFromLandmarks, Solver};
use localizer::rigid_motion::{Landmark, LinearPose, RelaxedPose, RigidPlanar, RigidPolar, RigidTable, Translated};

/// Time after which a contractor counts as one that never returns: a thousand times what the slowest of them takes.
const PATIENCE: Duration = Duration::from_secs(120);

/// Extreme intervals of all kinds. The first ones contain the number `solution`, which is one component of a solution of the problem under test.
fn extremes(solution: f64) -> Vec<Interval> {
    vec![
        Interval::ENTIRE,
        Interval::new(solution, f64::INFINITY),
        Interval::new(f64::NEG_INFINITY, solution),
        Interval::new(-1e300, 1e300),
        Interval::new(f64::MIN, f64::MAX),
        Interval::new(solution - 300.0, solution + 300.0),
        Interval::new(solution - 0.1, solution + 0.1),
        Interval::new(1e300, f64::MAX),
        // At 1e17 neighbouring doubles are 16 apart.
        Interval::new(1e17, 1e17 + 64.0),
        Interval::new(f64::NEG_INFINITY, -1e300),
        Interval::EMPTY,
    ]
}

/// Boxes for the tests of contractors, whose sides are the intervals of `extremes`: all combinations for up to three variables. For more variables
/// only boxes with one extreme side among bounded ones, and boxes whose sides are of the same kind.
fn boxes<const N: usize>(solution: [f64; N]) -> Vec<IntervalBox<N>> {
    let sides = solution.map(extremes);
    let n_kinds = sides[0].len();
    let mut boxes: Vec<IntervalBox<N>> = Vec::new();
    if N <= 3 {
        for mut number in 0..n_kinds.pow(N as u32) {
            boxes.push(IntervalBox::new(std::array::from_fn(|axis| {
                let side = sides[axis][number % n_kinds];
                number /= n_kinds;
                side
            })));
        }
        return boxes;
    }
    for kind in 0..n_kinds {
        boxes.push(IntervalBox::new(std::array::from_fn(|axis| sides[axis][kind])));
        for single in 0..N {
            let side = |axis: usize| sides[axis][if axis == single { kind } else { 6 }];
            boxes.push(IntervalBox::new(std::array::from_fn(side)));
        }
    }
    boxes
}

/// Applies a contractor to a box, both as a single contraction and as one that returns a union of boxes (branches). Fails if the solution is lost or
/// if a result is not inside the given box.
fn answer<const N: usize>(name: &str, contractor: &dyn Contractor<N>, domain: IntervalBox<N>, solution: [f64; N]) {
    let mut contracted = domain;
    contractor.contract(&mut contracted);
    assert!(contracted.is_subset_of(&domain), "{name}: {contracted:?} is not in {domain:?}");
    let branches = contractor.branches(&domain);
    assert!(branches.iter().all(|branch| branch.is_subset_of(&domain)), "{name}: a branch of {domain:?} has grown");
    if domain.contains(&solution) {
        assert!(contracted.contains(&solution), "{name} lost {solution:?} of {domain:?}: {contracted:?}");
        let is_kept = branches.iter().any(|branch| branch.contains(&solution));
        assert!(is_kept, "{name}: {solution:?} is in no branch of {domain:?}");
    }
}

/// Tests a contractor on every `every`-th box, in a thread that is abandoned if the contractor does not return.
fn answers<const N: usize>(
    name: &'static str,
    contractor: impl Contractor<N> + Send + 'static,
    solution: [f64; N],
    every: usize,
) {
    let (sender, receiver) = mpsc::channel();
    let work = thread::spawn(move || {
        for domain in boxes(solution).into_iter().step_by(every) {
            // The box is sent before it is contracted, so that a contractor that never returns is reported with its box.
            let _ = sender.send(domain);
            answer(name, &contractor, domain, solution);
        }
    });
    let (mut latest, deadline) = (None, std::time::Instant::now() + PATIENCE);
    loop {
        match receiver.recv_timeout(deadline.saturating_duration_since(std::time::Instant::now())) {
            Ok(domain) => latest = Some(domain),
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("{name} never answers {latest:?}"),
        }
    }
    if let Err(cause) = work.join() {
        std::panic::resume_unwind(cause);
    }
}

const POSE: [f64; 3] = [0.7, -0.4, 1.9];

/// Landmarks seen from [`POSE`], known to centimetres in both frames, and one more that may be anywhere.
fn landmarks() -> Vec<Landmark> {
    let (sin, cos) = POSE[2].sin_cos();
    let near = |value: f64| Interval::centred(value, 0.01);
    let seen = |[x, y]: [f64; 2]| {
        let place = [POSE[0] + cos * x - sin * y, POSE[1] + sin * x + cos * y];
        (place.map(near), [x, y].map(near))
    };
    let mut landmarks: Vec<Landmark> =
        [[1.0, 0.5], [2.0, -1.0], [0.5, -2.0], [3.0, 1.5], [1.5, 2.5]].map(seen).to_vec();
    landmarks.push(([Interval::ENTIRE; 2], [near(1.0), near(1.0)]));
    landmarks
}

#[test]
fn contractors_of_a_pose_answer_unbounded_huge_and_empty_boxes_promptly() {
    let bounded = || landmarks()[..5].to_vec();
    for few in [1, 2, 5] {
        let some = bounded()[..few].to_vec();
        answers("RigidPlanar", RigidPlanar::new(&some), POSE, 1);
        answers("LinearPose", LinearPose { motion: RigidPlanar::new(&some), n_slices: 4 }, POSE, 1);
        answers("RigidPolar", RigidPolar::new(&some), POSE, 3);
        answers("RigidTable", RigidTable::new(&some), POSE, 3);
        answers("RelaxedPose", RelaxedPose { landmarks: some.clone(), q: 0 }, POSE, 7);
        answers("Translated", Translated::<2> { landmarks: some, q: 0 }, POSE, 1);
    }
    answers("RelaxedPose", RelaxedPose { landmarks: bounded(), q: 1 }, POSE, 7);
    answers("RigidPlanar", RigidPlanar::new(&landmarks()), POSE, 1);
    answers("RigidPlanar", RigidPlanar::new(&[]), POSE, 1);
}

#[test]
fn every_solver_of_landmarks_answers_unbounded_huge_and_empty_boxes_promptly() {
    let bounded = landmarks()[..5].to_vec();
    for q in [0, 1] {
        for solver in [Solver::OneShot, Solver::Polar, Solver::TableIv] {
            let pose = PoseFromLandmarks::new(bounded.clone(), q, Freedom::Full, solver);
            answers("PoseFromLandmarks", pose, POSE, 7);
        }
        let sivia = Solver::Sivia { resolution: 0.05 };
        answers("Sivia", PoseFromLandmarks::new(bounded.clone(), q, Freedom::Full, sivia), POSE, 101);
    }
    for freedom in [Freedom::Line, Freedom::Translation] {
        answers("PoseFromLandmarks", PoseFromLandmarks::new(bounded.clone(), 1, freedom, Solver::OneShot), POSE, 1);
    }
}

#[test]
fn contractors_of_formulas_answer_unbounded_huge_and_empty_boxes_promptly() {
    let near = |value: f64| Interval::centred(value, 0.01);
    answers("Distance", Distance { centre: [near(1.0), near(2.0)], distance: near(5.0) }, [4.0, 6.0], 1);
    answers("Periodic", Periodic { period: near(0.3), offset: near(0.1) }, [3.1], 1);
    answers("Periodic", Periodic { period: Interval::new(0.0, 0.3), offset: near(0.1) }, [3.1], 1);
    answers("Pinhole", Pinhole { focal_px: near(500.0) }, [1.0, 2.0, 4.0, 125.0, 250.0], 1);
    // The tested solution is a vector along x, because few vectors with coordinates in doubles have a length that is exactly a double.
    answers("Polar", Polar, [2.0, 0.0, 2.0, 0.0], 1);
    let ring = ForwardBackward::new(|[x, y]| x.sqr() + y.sqr(), near(25.0));
    answers("ForwardBackward", ring.fixpoint(0.01), [3.0, 4.0], 1);
    answers("ForwardBackward", ForwardBackward::new(|[x]| x.sin(), near(0.0)).fixpoint(0.01), [0.0], 1);
    answers("Inverse", Inverse::new(|[x, y]| [x * y, x.cos()], Within(IntervalBox::ENTIRE)), [1.0, 2.0], 1);
    answers("Within", Within(IntervalBox::new([near(1.0); 3])), [1.0; 3], 1);
    let each = |value: f64| -> Box<dyn Contractor<2> + Send + Sync> {
        Box::new(Within(IntervalBox::new([near(value), near(value)])))
    };
    answers("QRelaxed", QRelaxed { contractors: vec![each(1.0), each(1.001), each(7.0)], q: 1 }, [1.0; 2], 1);
}

#[test]
fn reverses_of_periodic_functions_keep_angles_far_from_zero() {
    for angle_rad in [0.9e12, 1.1e12, 2.0e12, 3.3e15, 7.0e100_f64] {
        for angle_rad in [angle_rad, -angle_rad] {
            // The intervals that must contain the angle's sine, cosine and tangent have room for the rounding of the standard library, some 1e-15,
            // and for tangents far greater than 1.
            let near = |value: f64| Interval::new(value - 1e-12, value + 1e-12);
            let tangent = angle_rad.tan();
            let known = [
                Interval::new(angle_rad - 1.0, angle_rad + 1.0),
                Interval::new(angle_rad, f64::INFINITY),
                Interval::new(f64::NEG_INFINITY, angle_rad),
                Interval::new(-angle_rad.abs(), angle_rad.abs()),
            ];
            for known in known {
                assert!(near(angle_rad.sin()).sin_rev(known).contains(angle_rad), "sine, {angle_rad} in {known}");
                assert!(near(angle_rad.cos()).cos_rev(known).contains(angle_rad), "cosine, {angle_rad} in {known}");
                let tangents = Interval::new(tangent - 1e-9 * tangent.abs(), tangent + 1e-9 * tangent.abs());
                assert!(tangents.tan_rev(known).contains(angle_rad), "tangent, {angle_rad} in {known}");
            }
        }
    }
}
