//! Who is at fault when the truth is outside: on records made by hand, one cause at a time.

use localizer::{Claim, Estimate, Interval, Pose, PoseBox, PoseUnion, Status};
use sim::{
    check::{Verdict, check},
    drawn::Drawn,
    run::{ImageRecord, RunRecord},
    scene::{Scene, SceneFile, WallDirectionsSetup},
    truth::Truth,
};

use crate::command::root;

fn scene() -> Scene {
    SceneFile::load_all(&[root().join("scenes/tiles.toml")]).unwrap().remove(0).scene
}

/// A robot that rolls along x at 0.2 m/s for a second, in a box of ±1 cm about where it is.
fn record(scene: &Scene) -> RunRecord {
    let drawn = Drawn::draw(scene, 1);
    let radius_m = drawn.wheel_radius_m;
    let mut record = RunRecord::new(1, None, drawn);
    for step in 0..=100 {
        let time_s = f64::from(step) * 0.01;
        let pose = Pose { x_m: 1.0 + 0.2 * time_s, y_m: 1.0, heading_rad: 0.0 };
        record.truths.push(Truth {
            time_s,
            pose,
            velocity: [0.2, 0.0, 0.0],
            wheel_angle_rad: radius_m.map(|radius| 0.2 * time_s / radius),
            wheel_travel_m: [0.2 * time_s; 2],
            ..Truth::default()
        });
        record.estimates.push(estimate(time_s, pose));
        record.odometry.push(pose);
    }
    record
}

fn estimate(time_s: f64, about: Pose) -> Estimate {
    let pose = PoseBox::from(about.to_array().map(|value| Interval::centred(value, 0.01)));
    let relies_on = vec!["wheels.slip", "wheels.side_slip"];
    Estimate { time_s, pose: PoseUnion::single(pose), status: Status::Sound, relies_on }
}

/// Moves the boxes of the last half second off the truth.
fn lose_the_truth(record: &mut RunRecord) {
    for estimate in &mut record.estimates[50..] {
        let hull = estimate.pose.hull();
        let moved = [hull[0] + 0.05, hull[1], hull[2]];
        estimate.pose = PoseUnion::single(PoseBox::from(moved));
    }
}

fn counts(verdict: &Verdict) -> [usize; 4] {
    let containment = &verdict.containment;
    [containment.contained, containment.bound_broken, containment.perception, containment.unsound]
}

#[test]
fn a_truth_inside_needs_no_cause() {
    let scene = scene();
    let verdict = check(&scene, &record(&scene));
    assert_eq!(counts(&verdict), [101, 0, 0, 0]);
    assert!(verdict.violations.is_empty(), "{:?}", verdict.violations);
}

#[test]
fn a_truth_outside_without_a_cause_is_our_own_fault() {
    let scene = scene();
    let mut record = record(&scene);
    lose_the_truth(&mut record);
    let verdict = check(&scene, &record);
    assert_eq!(counts(&verdict), [50, 0, 0, 51]);
    let first = verdict.containment.first_failure.unwrap();
    assert_eq!((first.time_s, first.axis), (0.5, "x_m"));
    assert!((first.margin - 0.04).abs() < 1e-9, "{first:?}");
}

#[test]
fn slip_beyond_its_bound_takes_the_blame_and_is_measured() {
    let scene = scene();
    let mut record = record(&scene);
    // From 0.30 s to 0.40 s the left wheel spins 10 mm further than the robot goes.
    let extra_rad = 0.01 / record.drawn.wheel_radius_m[0];
    for truth in &mut record.truths {
        truth.wheel_angle_rad[0] += extra_rad * ((truth.time_s - 0.3) / 0.1).clamp(0.0, 1.0);
    }
    lose_the_truth(&mut record);
    let verdict = check(&scene, &record);
    assert_eq!(counts(&verdict), [50, 51, 0, 0]);
    assert_eq!(verdict.containment.first_failure.unwrap().blame, "wheels.slip");
    let slip = &verdict.violations[0];
    assert_eq!((verdict.violations.len(), slip.bound.as_str()), (1, "wheels.slip"));
    assert!((slip.from_s - 0.3).abs() < 0.011 && (slip.to_s - 0.4).abs() < 0.011, "{slip:?}");
    assert!((slip.true_value - 0.01).abs() < 1e-9, "{slip:?}");
}

#[test]
fn a_gyroscope_learnt_from_a_false_heading_misleads_by_the_same_cause_later() {
    let mut scene = scene();
    for (learns_gyro, expected) in [(false, [80, 11, 0, 10]), (true, [80, 21, 0, 0])] {
        scene.localizer.learns_gyro = learns_gyro;
        let mut record = record(&scene);
        // Ten times as slow: the cause may lie 3 s before.
        record.truths.iter_mut().for_each(|truth| truth.time_s *= 10.0);
        record.estimates.iter_mut().for_each(|estimate| estimate.time_s *= 10.0);
        for truth in &mut record.truths[10..] {
            truth.lateral_travel_m += 0.03;
        }
        // Outside by the slip about 1 s, inside again, and outside from 9.1 s on.
        let lost = (10..21).chain(91..101);
        for step in lost {
            let hull = record.estimates[step].pose.hull();
            record.estimates[step].pose = PoseUnion::single(PoseBox::from([hull[0], hull[1], hull[2] + 0.05]));
        }
        assert_eq!(counts(&check(&scene, &record)), expected, "learns_gyro = {learns_gyro}");
    }
}

#[test]
fn a_violation_that_leaves_the_truth_inside_is_listed_all_the_same() {
    let scene = scene();
    let mut record = record(&scene);
    for truth in &mut record.truths[40..] {
        truth.lateral_travel_m += 0.03;
    }
    let verdict = check(&scene, &record);
    assert_eq!(counts(&verdict), [101, 0, 0, 0]);
    assert_eq!(verdict.violations[0].bound, "wheels.side_slip");
    assert!((verdict.violations[0].true_value - 0.03).abs() < 1e-9);
}

#[test]
fn a_violated_bound_that_the_estimate_does_not_rely_on_is_no_excuse() {
    let scene = scene();
    let mut record = record(&scene);
    for truth in &mut record.truths {
        truth.tilt_rad[0] = 0.1;
    }
    lose_the_truth(&mut record);
    let verdict = check(&scene, &record);
    assert_eq!(verdict.violations[0].bound, "body.tilt");
    assert_eq!(counts(&verdict), [50, 0, 0, 51]);
}

/// An image at 0.40 s that claims a joint where `points_px` are.
fn image(record: &RunRecord, points_px: Vec<[f64; 3]>) -> ImageRecord {
    ImageRecord {
        number: 0,
        measured_s: 0.4,
        arrived_s: 0.43,
        truth: record.truths[40],
        method: "floor_tiles",
        claims: vec![Claim::FloorJoint { points_px, share_wrong: 0.2 }],
        q_items: 0,
        n_held: 1,
        alone_heading_rad: None,
        rejected_px: Vec::new(),
        constrained: true,
        emptied: false,
        prior: record.estimates[40].pose.hull(),
        posterior: record.estimates[40].pose.clone(),
        landmarks: Vec::new(),
        codes: Vec::new(),
        reading: None,
    }
}

#[test]
fn what_a_method_halves_is_counted_at_its_readings() {
    let scene = scene();
    let mut record = record(&scene);
    let wide = |x_m: f64, y_m: f64, heading_rad: f64| {
        PoseBox::from([x_m, y_m, heading_rad].map(|r| Interval::centred(0.0, r)))
    };
    let seen = |constrained: bool, prior: PoseBox, posterior: PoseBox| ImageRecord {
        constrained,
        prior,
        posterior: PoseUnion::single(posterior),
        ..image(&record, Vec::new())
    };
    let fix = seen(true, wide(0.4, 0.4, f64::INFINITY), wide(0.1, 0.2, 0.01));
    let none = seen(false, wide(0.4, 0.4, 0.4), wide(0.1, 0.1, 0.1));
    let emptied =
        ImageRecord { posterior: PoseUnion::default(), ..seen(true, wide(1.0, 1.0, 1.0), wide(1.0, 1.0, 1.0)) };
    record.images = vec![fix, none, emptied];
    let halved = &check(&scene, &record).methods["floor_tiles"].halved;
    assert!((halved.x_m - 2.0).abs() < 1e-9 && (halved.y_m - 1.0).abs() < 1e-9, "{halved:?}");
    assert_eq!(halved.heading_rad, 0.0, "what was unbounded is not counted");
}

#[test]
fn a_claim_of_a_joint_where_there_is_none_is_perceptions_fault() {
    let scene = scene();
    let mut record = record(&scene);
    // A line at 45 degrees is no joint of a grid along x and y.
    let slanted =
        (0..20).map(|index| [200.0 + 10.0 * f64::from(index), 100.0 + 10.0 * f64::from(index), 1.0]).collect();
    record.images.push(image(&record, slanted));
    lose_the_truth(&mut record);
    let verdict = check(&scene, &record);
    assert_eq!(verdict.methods["floor_tiles"].false_claims, 1);
    assert_eq!(counts(&verdict), [50, 0, 51, 0]);
}

#[test]
fn a_claim_of_a_true_joint_is_true_and_excuses_nothing() {
    let scene = scene();
    let mut record = record(&scene);
    // At x = 1.08 m the camera, 0.15 m behind the axle, is 0.03 m ahead of the joint at 0.90 m: its image lies 40 px below the
    // centre, give or take what mount, laying and scale drew (a few pixels).
    let below = (0..40).map(|index| [50.0 + 12.0 * f64::from(index), 239.5 + 40.0, 6.0]).collect();
    record.images.push(image(&record, below));
    lose_the_truth(&mut record);
    let verdict = check(&scene, &record);
    assert_eq!(verdict.methods["floor_tiles"].false_claims, 0);
    assert_eq!(counts(&verdict), [50, 0, 0, 51]);
}

fn with_wall(record: &mut RunRecord, claims: Vec<Claim>, q_items: usize) {
    let image = image(record, Vec::new());
    let n_held = record.images.len() + 1;
    let alone_heading_rad = Some(Interval::ZERO);
    record.images.push(ImageRecord { method: "wall_directions", claims, q_items, n_held, alone_heading_rad, ..image });
}

/// Without a forward camera no claim of it is true.
fn false_edge() -> Claim {
    Claim::WallLine { ends_px: [[100.0, 100.0], [300.0, 120.0]], bound_px: 0.3 }
}

#[test]
fn two_misread_images_of_walls_are_declared_and_a_third_is_perceptions_fault() {
    let scene = scene();
    for (n_misread, blamed) in [(2, [50, 0, 0, 51]), (3, [50, 0, 51, 0])] {
        let mut record = record(&scene);
        (0..n_misread).for_each(|_| with_wall(&mut record, vec![false_edge()], 0));
        lose_the_truth(&mut record);
        assert_eq!(counts(&check(&scene, &record)), blamed, "{n_misread} misread images");
    }
}

#[test]
fn where_the_lean_is_solved_for_a_sixth_of_the_edges_and_five_may_be_misread() {
    let mut scene = scene();
    scene.localizer.wall_directions = Some(WallDirectionsSetup { solves_lean: true, ..WallDirectionsSetup::default() });
    let upright = Claim::UprightLine { ends_px: [[100.0, 100.0], [110.0, 300.0]], bound_px: 0.3 };
    // By hand: of six edges 6/6 + 5 = 6 may be wrong, of seven as many; with a wrong upright edge beside them no edge of an image is right.
    for (claims, blamed) in [
        (vec![false_edge(); 6], [50, 0, 0, 51]),
        (vec![false_edge(); 7], [50, 0, 51, 0]),
        ([vec![false_edge(); 6], vec![upright]].concat(), [50, 0, 0, 51]),
    ] {
        let mut record = record(&scene);
        with_wall(&mut record, claims, 5);
        lose_the_truth(&mut record);
        assert_eq!(counts(&check(&scene, &record)), blamed);
    }
}
