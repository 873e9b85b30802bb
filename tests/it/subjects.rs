//! Localizers that a user writes, run in the simulator: what they are given and how they are judged.

use std::cell::Cell;

use interval::Interval;
use localizer::{Pose, PoseBox, PoseUnion, Reading, Status, bounds, robot::WheelModel};
use serde_json::Value;
use sim::{
    judge::Verdict,
    run::{Change, Counterfactual, RunOptions, RunRecord, run, run_otherwise},
    scene::{Bounds, Scene},
    subject::{Answer, IntervalLocalizer, Subject, SubjectOf},
};

use crate::{command::blind_scene, judging::verdict_of_subject};

/// A localizer that adds up what the wheels rolled, from the middle of the start box on.
struct DeadReckoning {
    wheels: WheelModel,
    pose: Pose,
    ticks: Option<[i64; 2]>,
    starts: usize,
}

impl Subject for DeadReckoning {
    fn start(&mut self, start: &PoseBox) {
        self.pose = Pose { x_m: start[0].mid(), y_m: start[1].mid(), heading_rad: start[2].mid() };
        (self.ticks, self.starts) = (None, self.starts + 1);
    }

    fn observe(&mut self, reading: &Reading) {
        let Reading::Wheels { ticks, .. } = reading else { return };
        let before = self.ticks.replace(*ticks).unwrap_or(*ticks);
        let [left_m, right_m] =
            [0, 1].map(|wheel| (ticks[wheel] - before[wheel]) as f64 * self.wheels.metres_per_tick(wheel).mid());
        let (ahead_m, turn_rad) = ((left_m + right_m) / 2.0, (right_m - left_m) / self.wheels.track_m.mid());
        let direction_rad = self.pose.heading_rad + turn_rad / 2.0;
        self.pose.x_m += ahead_m * direction_rad.cos();
        self.pose.y_m += ahead_m * direction_rad.sin();
        self.pose.heading_rad += turn_rad;
    }

    fn estimate_at(&self, _time_s: f64) -> Answer {
        Answer::Point(self.pose)
    }
}

fn dead_reckoning(scene: &Scene) -> DeadReckoning {
    let origin = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
    DeadReckoning { wheels: scene.robot_model().wheels, pose: origin, ticks: None, starts: 0 }
}

fn scene(more: &str) -> Scene {
    Scene::parse(&blind_scene(6.0, more), "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

fn driven(scene: &Scene, subject: &mut dyn Subject, subject_of: &SubjectOf<'_>) -> (RunRecord, Verdict) {
    let record = run(scene, 5, subject, None, &RunOptions::default(), &mut |_| {}).unwrap();
    let verdict = verdict_of_subject(scene, &record, subject_of);
    (record, verdict)
}

#[test]
fn a_point_is_judged_by_its_error_and_by_nothing_that_is_of_boxes() {
    let scene = scene("");
    let (record, verdict) = driven(&scene, &mut dead_reckoning(&scene), &|told| Box::new(dead_reckoning(told)));
    assert!(record.truths.last().unwrap().wheel_travel_m[0] > 0.3, "the robot has to drive");
    let summary = serde_json::to_value(&verdict).unwrap();
    for of_boxes in ["containment", "width", "power", "availability"] {
        assert_eq!(summary[of_boxes], Value::Null, "{of_boxes}");
    }
    assert!(verdict.judgements.is_empty() && !verdict.metrics.contains_key("recovering_share"));
    // For comparison: the odometry that every run computes as a baseline begins at the middle of the same start box. It is other code that adds up
    // the same wheel readings.
    let odometry = verdict.baselines["odometry"].error.as_ref().unwrap();
    for (ours, theirs) in [
        (verdict.error.position_m.max, odometry.position_m.max),
        (verdict.error.heading_rad.max, odometry.heading_rad.max),
    ] {
        assert!(ours > 0.0 && (ours - theirs).abs() < 1e-9, "{ours} where odometry alone has {theirs}");
    }
}

#[test]
fn an_expectation_of_boxes_does_not_apply_to_points_but_others_do() {
    let scene = scene("[expect]\nunsound = 0\nerror.x_m.max_max = 1e-9\n");
    let (_, verdict) = driven(&scene, &mut dead_reckoning(&scene), &|told| Box::new(dead_reckoning(told)));
    assert_eq!(verdict.verdict.not_applicable, ["unsound = 0"]);
    assert!(
        !verdict.verdict.passed && verdict.verdict.failed[0].contains("error.x_m.max"),
        "{:?}",
        verdict.verdict.failed
    );
}

/// Answers boxes of a localizer, and at one step the middle of the box alone.
struct Evasive(IntervalLocalizer, f64);

impl Subject for Evasive {
    fn start(&mut self, start: &PoseBox) {
        self.0.start(start);
    }

    fn observe(&mut self, reading: &Reading) {
        self.0.observe(reading);
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        match self.0.estimate_at(time_s) {
            Answer::Boxes(estimate) if (time_s - self.1).abs() < 0.001 => {
                let [x_m, y_m, heading_rad] = estimate.pose.hull().midpoint();
                Answer::Point(Pose { x_m, y_m, heading_rad })
            }
            answer => answer,
        }
    }
}

#[test]
fn a_localizer_that_states_no_box_where_it_likes_fails_and_its_boxes_are_judged_all_the_same() {
    let scene = scene("[expect]\nunsound = 0\n");
    let evasive = |told: &Scene| Evasive(IntervalLocalizer::of(told), 1.0);
    let (record, verdict) = driven(&scene, &mut evasive(&scene), &|told| Box::new(evasive(told)));
    let failure = record.subject_failure.as_ref().unwrap();
    assert!((failure.time_s - 1.0).abs() < 0.001, "{failure}");
    assert!(
        failure.to_string().contains("a pose without bounds after boxes, expected one kind of answers"),
        "{failure}"
    );
    assert!(!verdict.verdict.passed && verdict.verdict.not_applicable.is_empty(), "{:?}", verdict.verdict);
    assert!(verdict.containment.unwrap().checks > 90);
}

#[test]
fn a_subject_is_started_once_a_station() {
    let scene = Scene::parse(
        "duration_s = 0.5\n[room]\nwidth_m = 3.0\ndepth_m = 2.0\n[robot]\nfloor_camera = false\n\
         [start]\nx_m = 1.5\ny_m = 1.0\n\
         [[station]]\nx_m = 0.6\ny_m = 0.6\nheading_deg = 0\n[[station]]\nx_m = 1.2\ny_m = 0.6\nheading_deg = 90\n",
        "scene.toml",
    )
    .unwrap_or_else(|error| panic!("failed to {error}"));
    let mut subject = dead_reckoning(&scene);
    let record = run(&scene, 1, &mut subject, None, &RunOptions::default(), &mut |_| {}).unwrap();
    assert_eq!((subject.starts, record.restarts.len()), (2, 2));
}

#[test]
fn a_run_again_with_a_bound_told_wider_starts_in_the_box_that_follows_from_it() {
    /// A localizer that keeps the width of the start box that it was given.
    struct Starts<'a>(DeadReckoning, &'a Cell<f64>);
    impl Subject for Starts<'_> {
        fn start(&mut self, start: &PoseBox) {
            self.1.set(start[0].width());
        }
        fn observe(&mut self, _reading: &Reading) {}
        fn estimate_at(&self, _time_s: f64) -> Answer {
            Answer::Point(self.0.pose)
        }
    }
    // The stamps of the mobile base's clock may be off by ε = 20 ms, in which the robot gathers speed with up to the declared acceleration a: the
    // start position is known to its tolerance and a·ε²/2.
    let scene = Scene {
        bounds: Bounds { reach_acceleration_m_per_s2: 1.0, ..Bounds::default() },
        ..scene("[robot.delivery]\nstamp_tolerance_s = 0.02\n")
    };
    let widths_m: &'static Cell<f64> = Box::leak(Box::new(Cell::new(0.0)));
    let subject_of = |told: &Scene| Box::new(Starts(dead_reckoning(told), widths_m)) as Box<dyn Subject>;
    let record = run(&scene, 5, &mut *subject_of(&scene), None, &RunOptions::default(), &mut |_| {}).unwrap();
    let declared_m = widths_m.get();
    let told = Change::Told {
        bound: bounds::REACH_ACCELERATION.to_owned(),
        declared: 1.0,
        true_value: 3.0,
        exceeded: Vec::new(),
    };
    let asked = Counterfactual { changes: vec![told], until_s: Some(0.1), ..Counterfactual::default() };
    run_otherwise(&scene, &record, &asked, &subject_of, None, &mut |_| {}).unwrap();
    // In the replay the localizer is given an acceleration limit of 3 m/s² in place of 1 m/s², so that its start box is wider by twice ½·(3 − 1)
    // m/s²·(0.02 s)².
    assert!((widths_m.get() - declared_m - 0.0008).abs() < 1e-6, "{} after {declared_m}", widths_m.get());
}

/// A localizer that claims that the robot is in one small box, which is at a wrong place.
struct Elsewhere(IntervalLocalizer);

impl Subject for Elsewhere {
    fn start(&mut self, start: &PoseBox) {
        self.0.start(start);
    }

    fn observe(&mut self, reading: &Reading) {
        self.0.observe(reading);
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        let Answer::Boxes(mut estimate) = self.0.estimate_at(time_s) else { unreachable!() };
        let hull = estimate.pose.hull();
        let x_m = Interval::point(hull[0].hi() + 0.01);
        estimate.pose = PoseUnion::single(PoseBox::from([x_m, hull[1], hull[2]]));
        estimate.status = Status::Sound;
        Answer::Boxes(estimate)
    }
}

#[test]
fn boxes_of_another_subject_that_lose_the_truth_are_unsound() {
    let scene = scene("");
    let subject_of = |told: &Scene| Box::new(Elsewhere(IntervalLocalizer::of(told))) as Box<dyn Subject>;
    let (record, verdict) = driven(&scene, &mut *subject_of(&scene), &subject_of);
    let containment = verdict.containment.unwrap();
    assert_eq!(containment.unsound, record.truths.len(), "{containment:?}");
}
