//! Tests of the method with unmapped landmarks: which sightings must not be taken for consecutive, and which knowledge must not outlive a doubt.

use std::sync::Arc;

use interval::Interval;
use localizer::{
    Constraint, Localizer, Map, Method, PoseBox, PoseUnion, Reading, RobotModel, Status,
    method::{Context, Knowledge, Memory, OnPose, Shown},
    methods::range_landmarks::{Freedom, RangeLandmarks, Solver},
    reading::Sighting,
};
use nalgebra::Point3;

use crate::range_landmarks_setup::{HEIGHT_M, Landmark, Only, TrueCamera, random, robot, says};

/// A robot at rest in the origin. It sees one landmark (the right sighting), or sees a different landmark and reads its code as that of the first one
/// (the wrong sighting).
struct Stand {
    method: RangeLandmarks,
    right: Sighting,
    wrong: Sighting,
    truth: [f64; 2],
}

impl Stand {
    fn new(wrong_spacing: usize) -> Stand {
        Stand::with(&robot(1, wrong_spacing))
    }

    fn with(robot: &RobotModel) -> Stand {
        let mut rng = random(30);
        let camera = TrueCamera::drawn(&mut rng);
        let [own, other] = [[2.5, 1.2], [1.8, 0.2]]
            .map(|[x, y]| Landmark { code: localizer::reading::LandmarkId(4), place: Point3::new(x, y, HEIGHT_M) });
        let mut sight = |mark: &Landmark| camera.sight([0.0; 3], mark, &mut rng).expect("in view");
        Stand {
            right: sight(&own),
            wrong: sight(&other),
            truth: own.xy(),
            method: RangeLandmarks::new(robot, Freedom::Full, Solver::OneShot).expect("a camera"),
        }
    }

    fn read(&mut self, stamp_s: f64, sighting: Sighting, is_learnt: bool) {
        self.receive(stamp_s, stamp_s, sighting, is_learnt);
    }

    fn receive(&mut self, stamp_s: f64, arrived_s: f64, sighting: Sighting, is_learnt: bool) {
        let pose = PoseUnion::single(PoseBox::point(&[0.0; 3]));
        let reading = Reading::Range { measured_s: stamp_s, arrived_s, sightings: vec![sighting] };
        let constraint = self.method.constrain(&reading, &Context::at_rest(&pose)).unwrap();
        self.method.learn(&constraint.shown.unwrap(), is_learnt.then_some(&pose));
        for (_, [x, y]) in self.method.landmarks() {
            assert!(x.contains(self.truth[0]) && y.contains(self.truth[1]), "{x:?}, {y:?} after {stamp_s} s");
        }
    }
}

#[test]
fn a_use_that_is_not_learnt_from_ends_a_window() {
    let mut stand = Stand::new(1);
    let (right, wrong) = (stand.right, stand.wrong);
    stand.read(0.0, wrong, true);
    stand.read(0.2, right, false);
    stand.read(0.4, wrong, true);
    stand.read(0.6, right, true);
    stand.read(0.8, right, true);
    assert_eq!(stand.method.landmarks().len(), 1);
}

#[test]
fn what_is_unlearnt_ends_a_window() {
    let mut stand = Stand::new(2);
    let (right, wrong) = (stand.right, stand.wrong);
    stand.read(0.0, wrong, true);
    let knowledge = stand.method.knowledge().unwrap();
    stand.read(0.2, right, true);
    stand.method.go_back(&knowledge);
    for (stamp_s, sighting) in [(0.4, right), (0.6, wrong), (0.8, right), (1.0, right), (1.2, wrong), (1.4, right)] {
        stand.read(stamp_s, sighting, true);
    }
    assert_eq!(stand.method.landmarks().len(), 1);
}

#[test]
fn a_robot_that_is_put_elsewhere_ends_a_window() {
    let mut stand = Stand::new(1);
    let (right, wrong) = (stand.right, stand.wrong);
    stand.read(0.0, wrong, true);
    stand.method.clock_set_back();
    stand.read(0.0, wrong, true);
    stand.read(0.2, right, true);
}

#[test]
fn where_any_use_may_be_wrong_no_landmark_is_learnt() {
    let mut stand = Stand::new(0);
    for stamp in 0..20 {
        let sighting = [stand.right, stand.wrong][usize::from(stamp < 10)];
        stand.read(0.2 * f64::from(stamp), sighting, true);
    }
    assert!(stand.method.landmarks().is_empty());
}

/// Model of a robot whose range readings arrive up to half a second late.
fn late(wrong_spacing: usize) -> RobotModel {
    let mut robot = robot(1, wrong_spacing);
    let camera = robot.range_camera.as_mut().expect("a camera");
    camera.latency_s = Interval::new(0.0, 0.5);
    robot
}

#[test]
fn wrong_uses_that_arrive_one_after_the_other_lie_apart_as_they_were_measured() {
    let mut stand = Stand::with(&late(1));
    let (right, wrong) = (stand.right, stand.wrong);
    // A declared bound says how many right sightings of a code lie between two wrong ones. In the order of measuring, wrong and right sightings
    // alternate here; in the order of arrival there are two wrong ones, then two right ones.
    for round in 0..5 {
        let first_s = 0.4 * f64::from(round);
        for (after_s, late_s, sighting) in
            [(0.0, 0.21, wrong), (0.2, 0.02, wrong), (0.1, 0.13, right), (0.3, 0.01, right)]
        {
            stand.receive(first_s + after_s, first_s + after_s + late_s, sighting, true);
        }
    }
    assert_eq!(stand.method.landmarks().len(), 1, "nothing was learnt: the test says nothing");
}

#[test]
fn a_reading_later_than_any_should_be_is_not_learnt_from() {
    let mut stand = Stand::with(&late(1));
    let (right, wrong) = (stand.right, stand.wrong);
    stand.receive(0.0, 0.1, wrong, true);
    stand.receive(0.2, 0.8, right, true);
    // This wrong sighting was measured at 0.1 s, between two readings that the method has already used to learn the landmark's position. It arrives
    // later than the declared latency allows: it must teach nothing, and only ends the window of consecutive sightings of that code.
    stand.receive(0.1, 0.9, wrong, true);
    for (stamp_s, sighting) in [(1.0, wrong), (1.2, right), (1.4, right), (2.0, right)] {
        stand.receive(stamp_s, stamp_s, sighting, true);
    }
}

#[test]
fn where_stamps_do_not_tell_the_order_no_two_uses_are_consecutive() {
    let mut robot = late(1);
    robot.range_camera.as_mut().expect("a camera").stamp_error_s = 0.06;
    let mut stand = Stand::with(&robot);
    for stamp in 0..20 {
        let sighting = [stand.right, stand.wrong][usize::from(stamp < 10)];
        stand.read(0.2 * f64::from(stamp), sighting, true);
    }
    assert!(stand.method.landmarks().is_empty());
}

#[test]
fn a_landmark_found_elsewhere_is_a_contradiction_and_changes_nothing_known() {
    let mut stand = Stand::new(1);
    let (right, wrong) = (stand.right, stand.wrong);
    (0..4).for_each(|stamp| stand.read(0.2 * f64::from(stamp), right, true));
    let known = stand.method.landmarks();
    assert_eq!(known.len(), 1);
    // One wrong sighting among a few consecutive sightings of a code (a window) is within the declared bounds and is no contradiction.
    stand.read(0.8, wrong, true);
    stand.read(1.0, right, true);
    assert!(!stand.method.take_contradiction() && stand.method.landmarks() == known);
    // Two wrong sightings among a few consecutive sightings of a code (a window) exceed the declared bound: the landmark has moved, or its code hangs
    // at another place.
    stand.read(1.2, wrong, true);
    assert!(!stand.method.take_contradiction());
    stand.read(1.4, wrong, true);
    assert!(stand.method.take_contradiction() && stand.method.landmarks() == known);
    assert!(!stand.method.take_contradiction(), "told twice");
}

#[test]
fn a_landmark_that_was_moved_makes_the_localizer_doubt() {
    let mut rng = random(31);
    let camera = TrueCamera::drawn(&mut rng);
    let places = [[2.5, 1.2], [1.8, 0.2], [2.2, 0.7], [1.5, 0.9], [2.9, 0.4], [2.6, 0.1]];
    let mark = |code: usize, [x, y]: [f64; 2]| Landmark {
        code: localizer::reading::LandmarkId(code as u32),
        place: Point3::new(x, y, HEIGHT_M),
    };
    let map = Map {
        room_m: [Interval::new(-4.0, 6.0), Interval::new(-4.0, 6.0)],
        tiles: None,
        markers: None,
        wall_directions_rad: Vec::new(),
        walls: None,
    };
    let method = RangeLandmarks::new(&robot(1, 2), Freedom::Full, Solver::OneShot).expect("a camera");
    let mut localizer = Localizer::new(map, robot(1, 2), vec![Box::new(method)], PoseBox::point(&[0.0; 3]));
    let mut doubted_s = None;
    for step in 0..=800 {
        let time_s = f64::from(step) * 0.01;
        localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [0; 2] });
        if step % 10 != 0 || step == 0 {
            continue;
        }
        // At 4 s somebody moves landmark 0 half a metre to the side. One wrong landmark per reading is declared to be possible, so that the pose is
        // computed without it and stays right.
        let moved_m = if step > 400 { 0.5 } else { 0.0 };
        let seen =
            places.iter().enumerate().map(|(code, [x, y])| mark(code, [*x, y - if code == 0 { moved_m } else { 0.0 }]));
        let sightings = seen.filter_map(|mark| camera.sight([0.0; 3], &mark, &mut rng)).collect();
        localizer.observe(&Reading::Range { measured_s: time_s, arrived_s: time_s, sightings });
        let estimate = localizer.estimate();
        assert!(estimate.pose.contains(localizer::Pose::default()), "{:?} at {time_s} s", estimate.pose);
        if estimate.status == Status::Recovering {
            assert!(step > 400, "doubted at {time_s} s, when nothing had been moved");
            doubted_s = doubted_s.or(Some(time_s));
        }
    }
    // The bound on wrong sightings holds for any three consecutive sightings of a code, so that the localizer must notice the move of the landmark at
    // 4 s before 4.7 s.
    assert!(doubted_s.is_some_and(|doubted_s| doubted_s < 4.7), "{doubted_s:?}");
}

/// A stand-in for a method, whose claims depend on what it has learnt: it claims x = 0 at its first reading and x = 0.5 at later ones. After the
/// localizer has told it to forget, it makes its earlier claims anew as x = 0.5.
struct Believer {
    has_forgotten: bool,
    n_readings: usize,
}

impl Method for Believer {
    fn name(&self) -> &'static str {
        "believer"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Range { .. })
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        self.n_readings += 1;
        let x_m = if self.n_readings == 1 { 0.0 } else { 0.5 };
        Some(says(self.name(), reading, 0, Interval::centred(x_m, 0.01)).showing(()))
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

impl Memory for Believer {
    fn knowledge(&self) -> Option<Knowledge> {
        Some(Arc::new(()))
    }

    fn go_back(&mut self, _known: &Knowledge) {
        self.has_forgotten = true;
    }

    fn on_pose_again(&self, _shown: &Shown) -> Option<OnPose> {
        self.has_forgotten.then(|| Box::new(Only(0, Interval::centred(0.5, 0.01))) as OnPose)
    }
}

#[test]
fn constraints_that_stood_on_what_is_unlearnt_are_made_anew() {
    let start =
        PoseBox::from([Interval::centred(0.5, 0.6), Interval::centred(0.5, 0.01), Interval::centred(0.0, 0.01)]);
    let map = Map {
        room_m: [Interval::new(-1.0, 4.0), Interval::new(-1.0, 3.0)],
        tiles: None,
        markers: None,
        wall_directions_rad: Vec::new(),
        walls: None,
    };
    let mut localizer =
        Localizer::new(map, robot(0, 1), vec![Box::new(Believer { has_forgotten: false, n_readings: 0 })], start);
    let look = |time_s: f64| Reading::Range { measured_s: time_s, arrived_s: time_s, sightings: Vec::new() };
    for step in 0..=300 {
        let time_s = f64::from(step) * 0.01;
        localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [0; 2] });
        if step == 290 || step == 300 {
            localizer.observe(&look(time_s));
        }
    }
    // The method claimed x = 0 at 2.9 s and x = 0.5 at 3.0 s, which no robot can drive in between. The claim of 2.9 s was based on something that the
    // method has forgotten since, and the localizer must have the method make it anew.
    let hull = localizer.estimate().pose.hull();
    assert!(hull[0].contains(0.5) && hull[0].width() < 0.05, "{:?}", hull[0]);
}
