//! Tests of post-localization on drives whose poses are known.

use std::{
    f64::consts::TAU,
    sync::{Arc, Mutex},
};

use interval::{IntervalBox, contractor::Contractor};

use super::*;
use crate::{
    Constraint, PoseBox, PoseUnion, Reading, RobotModel,
    bounds::{self, Assumption},
    graph::{
        Domain, FrameReading, Relations, Row, Stray,
        trial::{Draw, Drive, robot, rounds},
    },
    map::Map,
    method::{Context, Memory, Method, Shown},
    methods::mapped_landmarks::{
        Learning, MappedLandmarks,
        trial::{True, boxed, homogeneous, is_within, look, reading, walls},
    },
};

/// Greatest error of a position that [`Fix`] tells.
const FIX_M: f64 = 0.01;

/// A reading that shows a position without a displacement.
struct Fix([f64; 2]);

impl Relations for Fix {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        Vec::new()
    }

    fn stamp_error_s(&self) -> f64 {
        0.0
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::GNSS_STAMP
    }

    fn shift_m(&self, _stray: &Stray) -> f64 {
        0.0
    }

    fn shift_parts(&self, _stray: &Stray) -> Vec<(Assumption, f64)> {
        Vec::new()
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let row = |axis: usize| {
            let variable = Variable::Pose(frame, axis);
            let sides = Interval::centred(self.0[axis], FIX_M) - Interval::point(domain.reference(variable));
            Row::new(domain, &[(variable, Interval::ONE)], sides)
        };
        vec![row(0), row(1)]
    }
}

/// A method that keeps the whole drive, knows every position again, and counts the bounds that it is told.
#[derive(Clone, Default)]
struct Keeper {
    n_told: Arc<Mutex<usize>>,
}

impl Method for Keeper {
    fn name(&self) -> &'static str {
        "keeper"
    }

    fn reads(&self, _reading: &Reading) -> bool {
        false
    }

    fn constrain(&mut self, _reading: &Reading, _context: &Context) -> Option<Constraint> {
        None
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

impl Memory for Keeper {
    fn keeps_drive(&self) -> bool {
        true
    }

    fn relations_again(&self, shown: &Shown) -> Option<Arc<dyn Relations>> {
        Some(Arc::new(Fix(*shown.downcast_ref()?)))
    }

    fn narrow(&mut self, bounds: &[(Variable, Interval)]) {
        *self.n_told.lock().unwrap() += bounds.len();
    }
}

/// The localizer after a drive with a key frame at each of 60 stamps, at which the pose is known to 5 cm and 50 mrad, and with a position at each that
/// is displaced by `off_m` from a position that would be told without that.
fn after(draw: &mut Draw, off_m: f64) -> (Localizer, Keeper, Vec<[f64; 3]>) {
    let drive = Drive::new(draw, true, 60.0, 60);
    let fix = |truth: &[f64; 3], draw: &mut Draw| {
        [0, 1].map(|axis| truth[axis] + off_m + draw.within(Interval::centred(0.0, FIX_M)))
    };
    let fixes: Vec<[f64; 2]> = drive.poses.iter().map(|truth| fix(truth, draw)).collect();
    let keeper = Keeper::default();
    let (map, start) = (Map::of_room([Interval::new(-99.0, 99.0); 2]), PoseBox::from([Interval::ZERO; 3]));
    let mut localizer = Localizer::new(map, robot(), vec![Box::new(keeper.clone())], start);
    localizer.wheels = drive.history(true);
    for ((&stamp_s, truth), at_m) in drive.stamps_s.iter().zip(&drive.poses).zip(fixes) {
        let half = [0.05, 0.05, 0.05];
        let pose = [0, 1, 2].map(|axis| {
            let off = draw.within(Interval::centred(0.0, half[axis]));
            Interval::centred(truth[axis] + off, half[axis] * (1.0 + 1e-9))
        });
        // What the reading told when it was read says nothing any more: it is made anew.
        let reading = FrameReading::new("keeper", Arc::new(Fix([f64::NAN; 2])), Stray::default());
        let reading = reading.showing(Some(Arc::new(at_m)));
        localizer.graph.frames.push(stamp_s, IntervalBox::from(pose), Some(reading));
    }
    (localizer, keeper, drive.poses)
}

#[test]
fn the_poses_of_a_whole_drive_are_bounded_by_what_came_after_them_and_hold_the_truth() {
    let mut draw = Draw::new(20_261_126);
    for round in 0..4 {
        let (mut localizer, keeper, truth) = after(&mut draw, 0.0);
        // No key frame was dropped, although they are near each other and many.
        assert_eq!(localizer.graph.frames.n_frames(), 60);
        localizer.space_points();
        let poses: Vec<PoseBox> = localizer.graph.frames.poses().map(|(_, pose)| pose).collect();
        for (at, (pose, truth)) in poses.iter().zip(&truth).enumerate() {
            for axis in 0..3 {
                let holds = pose[axis].inflate(1e-9).contains(truth[axis]);
                assert!(holds, "round {round}, key frame {at}, axis {axis}: {} {}", truth[axis], pose[axis]);
            }
            assert!(
                pose[0].width() < 2.001 * FIX_M && pose[1].width() < 2.001 * FIX_M,
                "round {round}, {at}: {pose:?}"
            );
        }
        // Two positions a second apart tell the direction between them to 2 cm in half a metre; those of the window tell it far better.
        let widest = poses.iter().map(|pose| pose[2].width()).fold(0.0, f64::max);
        assert!(widest < 0.05, "round {round}: {widest}");
        assert!(*keeper.n_told.lock().unwrap() >= 2 * 3 * 60);
    }
}

/// A method that sees landmarks of which learning alone makes use, in one part.
struct Learner {
    seen: MappedLandmarks,
    /// What it saw, by stamp.
    shown: Vec<(f64, Shown)>,
}

impl Method for Learner {
    fn name(&self) -> &'static str {
        "mapped_landmarks"
    }

    fn reads(&self, _reading: &Reading) -> bool {
        false
    }

    fn constrain(&mut self, _reading: &Reading, _context: &Context) -> Option<Constraint> {
        None
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

impl Memory for Learner {
    fn keeps_drive(&self) -> bool {
        true
    }

    fn learns_of_together(&self, shown: &[(f64, PoseBox)]) -> Vec<Vec<(f64, Arc<dyn Relations>)>> {
        let relations = |(stamp_s, _): &(f64, PoseBox)| {
            let (_, shown) = self.shown.iter().find(|(shown_s, _)| shown_s == stamp_s)?;
            Some((*stamp_s, self.seen.relations_again(shown)?))
        };
        vec![shown.iter().filter_map(relations).collect()]
    }

    fn narrow(&mut self, bounds: &[(Variable, Interval)]) {
        self.seen.narrow(bounds);
    }

    fn space_points(&self) -> Vec<(LandmarkId, SpacePoint)> {
        self.seen.space_points()
    }
}

#[test]
fn a_drive_whose_readings_contradict_each_other_leaves_no_landmarks() {
    let mut draw = Draw::new(20_261_127);
    let (mut localizer, _, _) = after(&mut draw, 0.2);
    assert!(!localizer.post_localize(WINDOW));
}

#[test]
fn a_drive_is_told_once_more_with_what_came_later_if_that_was_asked_for() {
    let mut draw = Draw::new(20_261_129);
    let (mut localizer, _, truth) = after(&mut draw, 0.0);
    assert_eq!(localizer.post_localized(), None);
    let before: Vec<(f64, PoseBox)> = localizer.graph.frames.poses().collect();
    let mut localizer = localizer.post_localizing(20);
    let told = localizer.post_localized().unwrap();
    let poses = told.poses.unwrap();
    assert_eq!((told.window, poses.len()), (20, 60));
    for (at, ((stamp_s, pose), truth)) in poses.iter().zip(&truth).enumerate() {
        assert_eq!(*stamp_s, before[at].0);
        assert!((0..3).all(|axis| pose[axis].inflate(1e-9).contains(truth[axis])), "{at}: {truth:?} {pose:?}");
        // Not even the last one is as vague as it was: all others tell something of its heading.
        assert!((0..3).all(|axis| pose[axis].width() < 0.5 * before[at].1[axis].width()), "{at}: {pose:?}");
    }
    // A clock that may be off by a second leaves open where the robot has gone within it.
    let (localizer, ..) = after(&mut draw, 0.0);
    let told = localizer.with_base_clock(1.0).post_localizing(20).post_localized().unwrap();
    assert!(told.poses.unwrap().iter().all(|(_, pose)| pose[0].width() > 0.5));
    let (localizer, ..) = after(&mut draw, 0.2);
    assert_eq!(localizer.post_localizing(20).post_localized().unwrap().poses, None);
}

#[test]
fn a_drive_at_known_poses_teaches_a_map_that_holds_every_landmark_and_later_localizes() {
    let mut draw = Draw::new(20_261_128);
    let (mut volumes, mut widths) = (Vec::new(), Vec::new());
    for round in 0..rounds(1) {
        let truth = True::new(&mut draw, 0.2);
        let landmarks = walls(&mut draw, 60);
        let robot = RobotModel { body: truth.body, ..robot() };
        let mut method = MappedLandmarks::new(truth.camera, &robot, &[], Learning::Teaches);
        let mut frames = Vec::new();
        for step in 0..150 {
            let along = f64::from(step) * TAU / 150.0;
            let place_m = [2.0 * along.cos(), 2.0 * along.sin()];
            let at = truth.turned(&mut draw, place_m, along + 0.25 * TAU);
            let known = boxed(&mut draw, at.pose, [0.01, 0.01, 0.02]);
            let seen = look(&truth, &mut draw, &at, &landmarks);
            let known = PoseUnion::single(known);
            let mut posterior = known.branches[0];
            let constraint = method.constrain(&reading(f64::from(step), &seen), &Context::at_rest(&known)).unwrap();
            constraint.on_pose.contract(&mut posterior);
            assert!(is_within(at.pose, &posterior), "round {round}, step {step}: {posterior:?} {:?}", at.pose);
            let shown = constraint.shown.unwrap();
            method.learn(&shown, Some(&PoseUnion::single(posterior)));
            assert!(!method.take_contradiction(), "round {round}, step {step}");
            if let Some(relations) = constraint.relations.filter(|_| step % 7 == 0) {
                frames.push((f64::from(step), posterior, relations, shown));
            }
        }
        let room = Map::of_room([Interval::new(-5.0, 5.0); 2]);
        let mut localizer = Localizer::new(room, robot.clone(), vec![Box::new(method)], frames[0].1);
        for (stamp_s, pose, relations, shown) in frames {
            let reading = FrameReading::new("mapped_landmarks", relations, Stray::default());
            let reading = reading.showing(Some(shown));
            localizer.graph.frames.push(stamp_s, pose, Some(reading));
        }
        let taught = localizer.space_points();
        for (landmark, point) in &taught {
            let expected = homogeneous(&point.anchor, landmarks[landmark.0 as usize]);
            assert!((0..3).all(|k| point.value[k].inflate(1e-12).contains(expected[k])), "round {round}: {landmark:?}");
        }
        let places: Vec<_> = taught.iter().map(|(_, point)| point.place_m()).collect();
        assert!(places.len() > 40, "{}", places.len());
        volumes.extend(
            places.iter().map(|place| {
                place.map_or(f64::INFINITY, |sides| sides.iter().map(|side| side.width()).product::<f64>())
            }),
        );
        // Later, from other places, at poses that are hardly known.
        let mut later = MappedLandmarks::new(truth.camera, &robot, &taught, Learning::Never);
        for step in 0..40 {
            let at_m = [0; 2].map(|_| draw.between(-2.5, 2.5));
            let at = truth.at(&mut draw, at_m[0], at_m[1]);
            let seen = look(&truth, &mut draw, &at, &landmarks);
            let mut pose = boxed(&mut draw, at.pose, [0.15, 0.15, 0.05]);
            let before = PoseUnion::single(pose);
            let constraint = later.constrain(&reading(f64::from(step), &seen), &Context::at_rest(&before)).unwrap();
            constraint.on_pose.contract(&mut pose);
            assert!(is_within(at.pose, &pose), "round {round}, step {step}: {pose:?} {:?}", at.pose);
            if seen.len() >= 6 {
                widths.push(pose[0].width().max(pose[1].width()));
            }
        }
    }
    volumes.sort_by(f64::total_cmp);
    widths.sort_by(f64::total_cmp);
    let (volume, width) = (volumes[volumes.len() / 2], widths[widths.len() / 2]);
    assert!(volume < 0.01 && width < 0.25, "{volume} m³, {width} m of {}", widths.len());
}

#[test]
fn what_a_whole_drive_shows_narrows_landmarks_and_teaches_nothing_where_it_contradicts_the_poses() {
    let mut draw = Draw::new(20_261_130);
    for off_m in [0.0, 0.5] {
        let truth = True::new(&mut draw, 0.2);
        let landmarks = walls(&mut draw, 40);
        let robot = RobotModel { body: truth.body, ..robot() };
        let mut seen = MappedLandmarks::new(truth.camera, &robot, &[], Learning::Teaches);
        let (mut poses, mut shown) = (Vec::new(), Vec::new());
        for step in 0..12_u8 {
            let stamp_s = f64::from(step);
            let along = stamp_s * TAU / 60.0;
            let at = truth.turned(&mut draw, [2.0 * along.cos(), 2.0 * along.sin()], along + 0.25 * TAU);
            let known = boxed(&mut draw, at.pose, [0.01, 0.01, 0.01]);
            let reading = reading(stamp_s, &look(&truth, &mut draw, &at, &landmarks));
            let constraint = seen.constrain(&reading, &Context::at_rest(&PoseUnion::single(known))).unwrap();
            shown.push((stamp_s, constraint.shown.unwrap()));
            seen.learn(&shown[usize::from(step)].1, Some(&PoseUnion::single(known)));
            let off_m = if step % 2 == 0 { off_m } else { -off_m };
            poses.push((stamp_s, PoseBox::from([known[0] + Interval::point(off_m), known[1], known[2]])));
        }
        let before = seen.space_points();
        let room = Map::of_room([Interval::new(-5.0, 5.0); 2]);
        let mut localizer = Localizer::new(room, robot, vec![Box::new(Learner { seen, shown })], poses[0].1);
        for (stamp_s, pose) in poses {
            let fix = Fix([pose[0].mid(), pose[1].mid()]);
            let reading = FrameReading::new("mapped_landmarks", Arc::new(fix), Stray::default());
            localizer.graph.frames.push(stamp_s, pose, Some(reading));
        }
        let after = localizer.space_points();
        let depths = |all: &[(LandmarkId, SpacePoint)]| all.iter().map(|(_, one)| one.value[2].width()).sum::<f64>();
        if off_m == 0.0 {
            for (landmark, point) in &after {
                let expected = homogeneous(&point.anchor, landmarks[landmark.0 as usize]);
                assert!((0..3).all(|k| point.value[k].inflate(1e-12).contains(expected[k])), "{landmark:?}");
            }
            assert!(depths(&after) < 0.7 * depths(&before), "{} {}", depths(&after), depths(&before));
        } else {
            assert_eq!(after, before);
        }
    }
}
