//! Tests of contractors, separators and pavings on problems solved by hand; a contractor that does nothing fails them.

use interval::contractor::{
    Contractor, Distance, ForwardBackward, Inverse, Outcome, Periodic, Pinhole, Polar, QRelaxed, q_intersection,
};
use interval::paving::{self, Paving};
use interval::{Interval, IntervalBox, separator::Separator};
use localizer::rigid_motion::{Landmark, LinearPose, RigidPlanar};

/// Asserts that an interval is equal to [lo, hi] up to rounding on both sides: not wider, and nothing lost.
fn assert_close(actual: Interval, lo: f64, hi: f64) {
    let is_close = (actual.lo() - lo).abs() < 1e-9 && (actual.hi() - hi).abs() < 1e-9;
    assert!(is_close, "{actual} is not [{lo}, {hi}]");
}

#[test]
fn distance_is_optimal_on_a_circle() {
    // A circle of radius 5 about the origin: above y = 3 it extends to x = ±4, and right of x = 0 it extends to y = 5 at most.
    let circle = Distance { centre: [Interval::ZERO; 2], distance: Interval::point(5.0) };
    let mut domain = IntervalBox::new([Interval::new(0.0, 10.0), Interval::new(3.0, 10.0)]);
    circle.contract(&mut domain);
    assert_close(domain[0], 0.0, 4.0);
    assert_close(domain[1], 3.0, 5.0);
    let mut outside = IntervalBox::new([Interval::new(4.0, 10.0), Interval::new(4.0, 10.0)]);
    assert!(matches!(circle.contract(&mut outside), Outcome::Empty(_)));
    assert!(outside.is_empty());
}

#[test]
fn polar_is_optimal_within_and_across_quadrants() {
    let pi = std::f64::consts::PI;
    let whole = Interval::new(-9.0, 9.0);
    // For a polar sector within the first quadrant, the corners of the sector determine the bounds of x and y.
    let mut sector = IntervalBox::new([whole, whole, Interval::new(1.0, 2.0), Interval::new(pi / 6.0, pi / 3.0)]);
    Polar.contract(&mut sector);
    assert_close(sector[0], 0.5, 3f64.sqrt());
    assert_close(sector[1], 0.5, 3f64.sqrt());
    // For a polar sector across the y axis, the top of the arc determines the bound: y reaches 2 at π/2, and its minimum is 1 · sin 60°.
    let mut top = IntervalBox::new([whole, whole, Interval::new(1.0, 2.0), Interval::new(pi / 3.0, 2.0 * pi / 3.0)]);
    Polar.contract(&mut top);
    assert_close(top[0], -1.0, 1.0);
    assert_close(top[1], 0.75f64.sqrt(), 2.0);
    // The vector points into the third quadrant, and its heading is found on the right one of several whole turns: atan2(−1, −1) + 2π · 3.
    let mut heading =
        IntervalBox::new([Interval::point(-1.0), Interval::point(-1.0), whole, Interval::new(18.0, 24.0)]);
    Polar.contract(&mut heading);
    assert_close(heading[3], 6.0 * pi + 1.25 * pi, 6.0 * pi + 1.25 * pi);
    assert_close(heading[2], 2f64.sqrt(), 2f64.sqrt());
}

#[test]
fn tile_joints_stay_apart() {
    let joints = Periodic { period: Interval::point(0.5), offset: Interval::new(0.24, 0.26) };
    let branches = joints.branches(&IntervalBox::new([Interval::new(0.5, 1.5)]));
    assert_eq!(branches.len(), 2);
    assert_close(branches[0][0], 0.74, 0.76);
    assert_close(branches[1][0], 1.24, 1.26);
    let mut between = IntervalBox::new([Interval::new(0.3, 0.7)]);
    assert!(matches!(joints.contract(&mut between), Outcome::Empty(_)));
}

#[test]
fn pinhole_needs_no_division_by_a_depth_that_may_be_zero() {
    let camera = Pinhole { focal_px: Interval::point(320.0) };
    let anywhere = Interval::new(-100.0, 100.0);
    let depth = Interval::new(-1.0, 8.0);
    // With the focal length of 320 px, the image column u = 80 means x / z = 1/4: from x = z / 4 ≥ 1 follows z ≥ 4, and from z ≤ 8 follows x ≤ 2.
    let mut point = IntervalBox::new([Interval::new(1.0, 9.0), anywhere, depth, Interval::point(80.0), Interval::ZERO]);
    camera.contract(&mut point);
    assert_close(point[0], 1.0, 2.0);
    assert_close(point[1], 0.0, 0.0);
    assert_close(point[2], 4.0, 8.0);
    let mut behind = point;
    behind[2] = Interval::new(-5.0, 0.0);
    assert!(matches!(camera.contract(&mut behind), Outcome::Empty(_)));
}

#[test]
fn two_of_three_intervals_outvote_the_third() {
    let boxes = [(0.0, 2.0), (1.0, 3.0), (10.0, 12.0)].map(|(lo, hi)| IntervalBox::new([Interval::new(lo, hi)]));
    assert_eq!(q_intersection(&boxes, 1)[0], Interval::new(1.0, 2.0));
    assert!(q_intersection(&boxes, 0).is_empty());
    assert_eq!(q_intersection(&boxes, 2)[0], Interval::new(0.0, 12.0));
}

#[test]
fn two_errors_of_the_same_size_are_two_errors() {
    // The product e₁ · e₂ of two errors in [−1, 1] can be −1; the square of one error cannot.
    let error = Interval::new(-1.0, 1.0);
    let product = ForwardBackward::new(|[x]| x.constant(error) * x.constant(error) + 0.0 * x, Interval::ENTIRE);
    assert!(product.evaluate(&IntervalBox::new([Interval::ONE])).contains(-1.0));
}

#[test]
fn an_inverse_image_contracts_through_its_formulas() {
    // The constraint is that points lie at distance 5 from the origin of a frame that is moved by 1 along y and turned by a quarter turn: in that
    // frame, (x, y) is (y − 1, −x).
    let moved =
        Inverse::new(|[x, y]| [y - 1.0, -x], Distance { centre: [Interval::ZERO; 2], distance: Interval::point(5.0) });
    let mut domain = IntervalBox::new([Interval::new(4.0, 9.0), Interval::new(1.0, 9.0)]);
    moved.contract(&mut domain);
    assert_close(domain[0], 4.0, 5.0);
    assert_close(domain[1], 1.0, 4.0);
}

#[test]
fn a_paving_brackets_the_area_of_a_ring() {
    let ring = ForwardBackward::new(|[x, y]| x.sqr() + y.sqr(), Interval::new(1.0, 4.0));
    let domain = IntervalBox::new([Interval::new(-3.0, 3.0); 2]);
    let paving = Paving::new(&ring, domain, &[0, 1], 0.02);
    let area = |boxes: &[IntervalBox<2>]| boxes.iter().map(|one| one.width(0) * one.width(1)).sum::<f64>();
    let (inner, boundary) = (area(&paving.inner), area(&paving.boundary));
    let exact = 3.0 * std::f64::consts::PI;
    assert!(inner < exact && exact < inner + boundary, "{exact} is not between {inner} and {}", inner + boundary);
    assert!(boundary < 0.2, "the boundary covers {boundary}");
    assert!((inner + boundary + area(&paving.outer) - 36.0).abs() < 1e-6, "the paving does not cover the domain once");
    let radius = |point: [f64; 2]| f64::hypot(point[0], point[1]);
    assert!(paving.inner.iter().all(|one| (1.0..=2.0).contains(&radius(one.midpoint()))));
    assert!(paving.outer.iter().all(|one| !(1.0..=2.0).contains(&radius(one.midpoint()))));
}

#[test]
fn sets_combine_by_and_or_and_complement() {
    let disc = |x0: f64| ForwardBackward::new(move |[x, y]| (x - x0).sqr() + y.sqr(), Interval::new(0.0, 1.0));
    let lens = disc(0.0).and(disc(1.0));
    let moon = disc(0.0).and(disc(1.0).complement());
    let both = disc(0.0).or(disc(1.0));
    let domain = IntervalBox::new([Interval::new(-3.0, 3.0); 2]);
    let inner_area = |set: &dyn Fn() -> Paving<2>| {
        let paving = set();
        let area = |boxes: &[IntervalBox<2>]| boxes.iter().map(|one| one.width(0) * one.width(1)).sum::<f64>();
        (area(&paving.inner), area(&paving.inner) + area(&paving.boundary))
    };
    // Two unit discs with centres 1 apart overlap in the area 2π/3 − √3/2.
    let overlap = 2.0 * std::f64::consts::FRAC_PI_3 - 0.75f64.sqrt();
    let pi = std::f64::consts::PI;
    for ((least, most), exact) in [
        (inner_area(&|| Paving::new(&lens, domain, &[0, 1], 0.03)), overlap),
        (inner_area(&|| Paving::new(&moon, domain, &[0, 1], 0.03)), pi - overlap),
        (inner_area(&|| Paving::new(&both, domain, &[0, 1], 0.03)), 2.0 * pi - overlap),
    ] {
        assert!(least < exact && exact < most && most - least < 0.5, "{exact} is not tightly in [{least}, {most}]");
    }
}

#[test]
fn only_the_chosen_axes_are_bisected() {
    // The constraint makes y a function of x (y = x²), so that contraction narrows y when only x is bisected.
    let line = ForwardBackward::new(|[x, y]| y - x.sqr(), Interval::ZERO);
    let domain = IntervalBox::new([Interval::new(0.0, 1.0), Interval::new(-5.0, 5.0)]);
    let cover = paving::cover(&line, domain, &[0], 0.26);
    assert_eq!(cover.len(), 4);
    assert!(cover.iter().all(|one| one.width(0) < 0.26 && one.width(1) < 0.45));
}

#[test]
fn a_heading_known_but_for_whole_turns_stays_a_union() {
    let turned = |x: f64, y: f64| [Interval::centred(-y, 0.01), Interval::centred(x, 0.01)];
    let seen = |x: f64, y: f64| [Interval::centred(x, 0.01), Interval::centred(y, 0.01)];
    let landmarks = [(2.0, 1.0), (-1.0, 3.0), (1.0, -2.0)].map(|(x, y)| (turned(x, y), seen(x, y)));
    let motion = RigidPlanar::new(&landmarks);
    let domain = IntervalBox::new([Interval::new(-1.0, 1.0), Interval::new(-1.0, 1.0), Interval::new(-10.0, 10.0)]);
    let branches = motion.branches(&domain);
    // The true heading is a quarter turn plus any number of whole turns. Within the given domain of ±10 rad that is −3π/2, π/2 or 5π/2; −7π/2 lies
    // outside.
    assert_eq!(branches.len(), 3);
    for (branch, quarter_turns) in branches.iter().zip([-3.0, 1.0, 5.0]) {
        assert!(branch[2].contains(quarter_turns * std::f64::consts::FRAC_PI_2) && branch[2].width() < 0.1);
        assert!(branch[0].contains(0.0) && branch[0].width() < 0.1);
    }
}

/// The pose problem whose time the benchmark measures: four landmarks, known to ±0.1 m in both frames.
fn four_landmarks() -> (Vec<Landmark>, [f64; 3]) {
    let (x, y, heading) = (1.0, 0.5, 0.4f64);
    let places = [[3.0, 2.0], [-2.0, 3.0], [-3.0, -2.5], [2.5, -3.0]];
    let errors = [[0.5, -0.3, -0.2, 0.4], [-0.7, 0.2, 0.6, -0.6], [0.1, 0.6, 0.3, 0.1], [-0.4, -0.5, -0.5, 0.7]];
    let landmarks = places.iter().zip(&errors).map(|([a_x, a_y], error)| {
        let (across, along) = (a_x - x, a_y - y);
        let b_x = heading.cos() * across + heading.sin() * along;
        let b_y = heading.cos() * along - heading.sin() * across;
        let around = |value: f64, error: f64| Interval::centred(value + 0.1 * error, 0.1);
        ([around(*a_x, error[0]), around(*a_y, error[1])], [around(b_x, error[2]), around(b_y, error[3])])
    });
    (landmarks.collect(), [x, y, heading])
}

#[test]
fn one_shot_pose_is_as_tight_as_bisection_within_a_tenth() {
    let (landmarks, truth) = four_landmarks();
    let prior = IntervalBox::new([Interval::new(-3.0, 3.0); 3]);
    let motion = RigidPlanar::new(&landmarks);
    // The reference, with which the fast solver's box is compared, is found by bisection with a plain forward-backward contractor for each
    // coordinate, without linearisation.
    let mut plain: Vec<ForwardBackward<3>> = Vec::new();
    for (a, b) in &landmarks {
        let ([a_x, a_y], [b_x, b_y]) = (*a, *b);
        plain.push(ForwardBackward::new(|[x, _, h]| x + h.cos() * b_x - h.sin() * b_y - a_x, Interval::ZERO));
        plain.push(ForwardBackward::new(|[_, y, h]| y + h.sin() * b_x + h.cos() * b_y - a_y, Interval::ZERO));
        plain.push(ForwardBackward::new(|[x, y, h]| h.cos() * (a_x - x) + h.sin() * (a_y - y) - b_x, Interval::ZERO));
        plain.push(ForwardBackward::new(|[x, y, h]| h.cos() * (a_y - y) - h.sin() * (a_x - x) - b_y, Interval::ZERO));
    }
    let all = QRelaxed { contractors: plain.into_iter().map(|one| Box::new(one) as _).collect(), q: 0 };
    let reference = paving::hull(&paving::cover(&all, prior, &[0, 1, 2], 0.0125));
    let mut pose = prior;
    LinearPose { motion: motion.clone(), n_slices: 8 }.contract(&mut pose);
    assert!(pose.contains(&truth) && reference.contains(&truth));
    for axis in 0..3 {
        let ratio = pose.width(axis) / reference.width(axis);
        assert!(ratio < 1.1, "axis {axis} is {ratio} times as wide as by bisection");
    }
    // The solver `LinearPose` first eliminates variables linearly and then divides the heading into slices. The box after the elimination alone (no
    // slices) is already close to the reference.
    let mut eliminated = prior;
    LinearPose { motion, n_slices: 0 }.contract(&mut eliminated);
    assert!((0..3).all(|axis| eliminated.width(axis) < 1.25 * reference.width(axis)));
    assert!(pose.is_subset_of(&eliminated));
}

#[test]
fn outliers_are_named_by_the_constraints_that_exclude_what_the_others_leave() {
    // Distances from six beacons to the point (1, 2), of which the second and the fifth are a metre too long.
    let beacons = [[0.0, 0.0], [4.0, 0.0], [0.0, 5.0], [4.0, 5.0], [-3.0, 2.0], [1.0, -4.0]];
    let constraint = |index: usize| {
        let [a, b]: [f64; 2] = beacons[index];
        let off_m = if [1, 4].contains(&index) { 1.0 } else { 0.0 };
        let range = Interval::centred((1.0 - a).hypot(2.0 - b) + off_m, 0.05);
        Box::new(ForwardBackward::<2>::new(move |[x, y]| (x - a).hypot(y - b), range)) as Box<_>
    };
    let relaxed = QRelaxed { contractors: (0..6).map(constraint).collect(), q: 2 };
    let room = IntervalBox::new([Interval::new(-5.0, 5.0); 2]);
    // Every constraint agrees with some point of the room.
    assert!(relaxed.excluding(&room).is_empty());
    let left = paving::hull(&paving::cover(&relaxed, room, &[0, 1], 0.01));
    assert!(left.contains(&[1.0, 2.0]) && left.width(0) < 0.3 && left.width(1) < 0.3, "{left:?}");
    assert_eq!(relaxed.excluding(&left), [1, 4]);
    assert_eq!(relaxed.excluding(&IntervalBox::EMPTY), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn a_landmark_that_is_anywhere_changes_nothing_and_one_that_is_nowhere_leaves_no_pose() {
    let (mut landmarks, truth) = four_landmarks();
    let prior = IntervalBox::new([Interval::new(-3.0, 3.0); 3]);
    let contracted = |landmarks: &[Landmark]| {
        let mut pose = prior;
        LinearPose { motion: RigidPlanar::new(landmarks), n_slices: 2 }.contract(&mut pose);
        pose
    };
    let known = contracted(&landmarks);
    landmarks.push(([Interval::ENTIRE, Interval::new(0.4, f64::INFINITY)], [Interval::ENTIRE; 2]));
    assert_eq!(contracted(&landmarks), known);
    assert!(known.contains(&truth));
    landmarks.push(([Interval::EMPTY, Interval::ZERO], [Interval::ZERO; 2]));
    assert!(contracted(&landmarks).is_empty());
}
