use interval::Interval;
use localizer::{Claim, Estimate, Pose, PoseBox, PoseUnion, Status, quota::Quota, reading::Camera};
use sim::{
    campaign::{
        falsify::{Wish, hits, witness_outside},
        sharpness::{Instant, Sharpness},
    },
    judge::{Judgement, judge},
    run::{ImageRecord, RunRecord},
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use crate::command::blind_scene;

fn scene() -> Scene {
    Scene::parse(&blind_scene(4.0, "[localizer]\nmethods = []\n"), "scene.toml").unwrap()
}

/// A record of a robot that rests for four seconds; each estimate is a box of half width `half_m` whose middle is off along x by `off_m(time_s)`.
fn record(scene: &Scene, half_m: f64, off_m: impl Fn(f64) -> f64) -> RunRecord {
    let mut record = RunRecord::new(1, None, Drawn::draw(scene, 1));
    for step in 0..=400 {
        let time_s = f64::from(step) * 0.01;
        let pose = Pose { x_m: 0.6, y_m: 0.6, heading_rad: 0.0 };
        record.truths.push(Truth { time_s, pose, ..Truth::default() });
        let about = [0.6 + off_m(time_s), 0.6, 0.0].map(|value| Interval::centred(value, half_m));
        let pose_box = PoseUnion::single(PoseBox::from(about));
        record.estimates.push(Estimate {
            time_s,
            pose: pose_box,
            status: Status::Sound,
            relies_on: vec!["wheels.slip"],
            contradicting: None,
        });
        record.odometry.push(pose);
    }
    record
}

fn wishes(scene: &Scene, record: &RunRecord) -> Vec<Wish> {
    // In every replay that the judge requests, in which a broken bound is kept, the boxes contain the true pose.
    let verdict = judge(scene, record, &mut |_| Ok(self::record(scene, 0.01, |_| 0.0))).unwrap();
    hits(scene, record, &verdict).into_iter().map(|hit| hit.wish).collect()
}

#[test]
fn a_truth_inside_grants_no_wish() {
    let scene = scene();
    assert_eq!(wishes(&scene, &record(&scene, 0.01, |_| 0.0)), []);
}

#[test]
fn outside_for_half_a_second_is_unsound_and_for_longer_than_one_it_is_sound_but_outside_too() {
    let scene = scene();
    let outside_until = |end_s: f64| move |time_s: f64| if (1.0..end_s).contains(&time_s) { 0.05 } else { 0.0 };
    assert_eq!(wishes(&scene, &record(&scene, 0.01, outside_until(1.5))), [Wish::Unsound]);
    assert_eq!(wishes(&scene, &record(&scene, 0.01, outside_until(2.5))), [Wish::Unsound, Wish::SoundButOutside]);
}

/// Sharpness at one instant, with a witness a step outside the box along x, or none outside.
fn sharpness(time_s: f64, in_box: bool) -> Sharpness {
    let instant = Instant {
        time_s,
        width: [0.02; 3],
        witnesses: [Interval::new(0.6, if in_box { 0.605 } else { 0.615 }); 3],
        power: [Some(1.5), None, None],
        in_box,
        broken: None,
        dominant: [const { None }; 3],
    };
    Sharpness { instants: vec![instant] }
}

#[test]
fn a_witness_outside_counts_where_the_localizer_says_that_it_is_sound() {
    let scene = scene();
    let mut record = record(&scene, 0.01, |_| 0.0);
    let wish = |record: &RunRecord, found: &Sharpness| witness_outside(&scene, record, found).map(|hit| hit.wish);
    assert_eq!(wish(&record, &sharpness(2.0, true)), None);
    assert_eq!(wish(&record, &sharpness(2.0, false)), Some(Wish::WitnessOutside));
    record.estimates[200].status = Status::Recovering;
    assert_eq!(wish(&record, &sharpness(2.0, false)), None);
    assert_eq!(wish(&record, &sharpness(2.01, false)), Some(Wish::WitnessOutside));
}

#[test]
fn a_localizer_that_says_that_it_recovers_is_not_sound_but_outside() {
    let scene = scene();
    let mut record = record(&scene, 0.01, |time_s| if time_s > 1.0 { 0.05 } else { 0.0 });
    record.estimates.iter_mut().for_each(|estimate| estimate.status = Status::Recovering);
    assert_eq!(wishes(&scene, &record), [Wish::Unsound]);
}

#[test]
fn a_bound_excuses_only_where_an_estimate_relies_on_it() {
    let scene = scene();
    let mut record = record(&scene, 0.01, |time_s| if time_s > 1.0 { 0.05 } else { 0.0 });
    // From 0.5 s on the left wheel spins by far more than its bound.
    for truth in &mut record.truths {
        truth.wheel_angle_rad[0] += 10.0 * ((truth.time_s - 0.5) / 0.1).clamp(0.0, 1.0);
    }
    assert_eq!(wishes(&scene, &record), []);
    record.estimates.iter_mut().for_each(|estimate| estimate.relies_on.clear());
    assert_eq!(wishes(&scene, &record), [Wish::Unsound, Wish::SoundButOutside]);
}

#[test]
fn a_box_wider_than_the_walls_leave_to_the_robot_is_one_only_while_sound() {
    let scene = scene();
    // The room is 2 m deep. The robot's middle cannot come nearer than 0.25 m to either wall, its body's radius, less a millimetre by which contact
    // may compress either side: it can be anywhere within 1.502 m, and a box wider than that is a finding.
    assert_eq!(wishes(&scene, &record(&scene, 0.7505, |_| 0.0)), []);
    let mut wide = record(&scene, 0.7515, |_| 0.0);
    assert_eq!(wishes(&scene, &wide), [Wish::WiderThanRoom]);
    wide.estimates.iter_mut().for_each(|estimate| estimate.status = Status::Recovering);
    assert_eq!(wishes(&scene, &wide), []);
}

#[test]
fn a_box_of_no_pose_is_empty_whatever_the_status() {
    let scene = scene();
    let mut record = record(&scene, 0.01, |_| 0.0);
    record.estimates[300].pose = PoseUnion { branches: Vec::new() };
    record.estimates[300].status = Status::Recovering;
    assert!(wishes(&scene, &record).contains(&Wish::EmptyBox));
}

/// An image taken at `measured_s` that claims a joint where the floor has none, from a method that declares up to `q_items` wrong claims.
fn misread(record: &RunRecord, measured_s: f64, q_items: usize) -> ImageRecord {
    let at = (measured_s / 0.01).round() as usize;
    ImageRecord {
        number: 0,
        measured_s,
        arrived_s: measured_s + 0.03,
        truth: record.truths[at],
        camera: Some(Camera::Floor),
        method: "floor_tiles",
        claims: vec![Claim::FloorJoint { points_px: vec![[100.0, 100.0, 1.0]; 20], share_wrong: 0.2 }],
        quota: Quota::of_each(q_items),
        alone: None,
        is_held: false,
        rejected_px: Vec::new(),
        constrained: true,
        emptied: false,
        prior: record.estimates[at].pose.hull(),
        posterior: record.estimates[at].pose.clone(),
        landmarks: Vec::new(),
        codes: Vec::new(),
        reading: None,
    }
}

#[test]
fn what_the_judge_makes_of_a_step_outside_does_not_excuse_it() {
    let scene = scene();
    let record = record(&scene, 0.01, |time_s| if time_s > 1.0 { 0.05 } else { 0.0 });
    let mut verdict = judge(&scene, &record, &mut |asked| panic!("asked for {asked:?}")).unwrap();
    for lenient in [Judgement::Perception, Judgement::BoundBroken, Judgement::Contained] {
        verdict.judgements[101..].fill(lenient);
        let found: Vec<Wish> = hits(&scene, &record, &verdict).into_iter().map(|hit| hit.wish).collect();
        assert!(found.contains(&Wish::SoundButOutside), "{lenient:?}: {found:?}");
    }
}

#[test]
fn more_false_claims_than_declared_excuse_what_comes_after_them_and_no_others_do() {
    let scene = scene();
    let lost = || record(&scene, 0.01, |time_s| if time_s > 1.0 { 0.05 } else { 0.0 });
    // Three cases: the false claim comes before the failure and exceeds the declared number of false claims; it comes before the failure but is
    // within that number; it comes only after the true pose has been outside of the boxes for more than a second. Only the first case excuses the
    // failure.
    for (measured_s, q_items, is_excused) in [(0.5, 0, true), (0.5, 1, false), (2.5, 0, false)] {
        let mut record = lost();
        record.images.push(misread(&record, measured_s, q_items));
        // In every replay that the judge requests, the boxes miss the true pose as they do in the record, so that the judge finds no excuse. Whether
        // the search reports that the true pose was outside of sound boxes must not depend on the judge.
        let verdict = judge(&scene, &record, &mut |_| Ok(lost())).unwrap();
        let found: Vec<Wish> = hits(&scene, &record, &verdict).into_iter().map(|hit| hit.wish).collect();
        assert_eq!(found.contains(&Wish::SoundButOutside), !is_excused, "{measured_s} {q_items}: {found:?}");
        assert!(found.contains(&Wish::Unsound), "{found:?}");
    }
}
