//! Tests of key frames: hundreds of seconds, and readings that are displaced.

use std::sync::Arc;

use interval::IntervalBox;

use super::*;
use crate::bounds::{self, Assumption};
use crate::graph::{
    Hull, Relations, Row,
    trial::{Draw, Drive, reach, robot, wheels},
};
use crate::motion::WheelHistory;

#[test]
fn a_key_frame_gives_way_only_to_one_that_shows_as_much() {
    let stamps_of = |pushed: &[(f64, &'static str)]| {
        let mut frames = KeyFrames::new(&robot());
        for &(stamp_s, source) in pushed {
            let reading = FrameReading::new(source, Arc::new(Displaced([0.0; 3])), OFF);
            let pose = IntervalBox::from([Interval::centred(0.0, 0.1); 3]);
            frames.push(stamp_s, pose, Some(reading).filter(|one| !one.source.is_empty()));
        }
        frames.frames.iter().map(|frame| frame.stamp_s).collect::<Vec<_>>()
    };
    assert_eq!(stamps_of(&[(0.0, "a"), (0.3, "a"), (0.6, "a"), (0.9, "a")]), [0.0, 0.6, 0.9]);
    // The reading of `b` in the second key frame is the only one near.
    assert_eq!(stamps_of(&[(0.0, "a"), (0.1, "b"), (0.3, "a"), (0.5, "b")]), [0.0, 0.1, 0.3, 0.5]);
    assert_eq!(stamps_of(&[(0.0, "a"), (1.0, ""), (1.1, "a"), (2.7, "")]), [0.0, 1.1, 2.7]);
    assert_eq!(stamps_of(&[(0.0, ""), (1.0, "a"), (2.0, "")]), [0.0, 1.0, 2.0]);
}

#[test]
fn a_key_frame_that_shows_the_map_alone_gives_way_for_two_seconds() {
    let stamps_of = |stamps_s: &[f64], is_of_the_map: bool| {
        let mut frames = KeyFrames::new(&robot());
        for &stamp_s in stamps_s {
            let relations: Arc<dyn Relations> =
                if is_of_the_map { Arc::new(OfTheMap(Displaced([0.0; 3]))) } else { Arc::new(Displaced([0.0; 3])) };
            let pose = IntervalBox::from([Interval::centred(0.0, 0.1); 3]);
            frames.push(stamp_s, pose, Some(FrameReading::new("a", relations, OFF)));
        }
        frames.frames.iter().map(|frame| frame.stamp_s).collect::<Vec<_>>()
    };
    let seconds = [0.0, 1.0, 2.0, 3.0, 4.0];
    assert_eq!(stamps_of(&seconds, false), seconds);
    assert_eq!(stamps_of(&seconds, true), [0.0, 2.0, 4.0]);
    // Of those that relate more, half as many are kept in a long drive, and the first and the latest one among them.
    let long: Vec<f64> = (0..300).map(f64::from).collect();
    let kept_s = stamps_of(&long, false);
    assert_eq!((kept_s.len(), kept_s[0], kept_s[kept_s.len() - 1]), (MOST / 2, 0.0, 299.0));
    assert_eq!(stamps_of(&long, true).len(), MOST);
}

#[test]
fn a_way_that_was_joined_over_boxes_which_are_taken_back_is_forgotten() {
    let mut draw = Draw::new(20_261_129);
    let drive = Drive::new(&mut draw, true, 4.0, 4);
    let history = drive.history(true);
    let mut frames = KeyFrames::new(&robot());
    for (&stamp_s, truth) in drive.stamps_s.iter().zip(&drive.poses) {
        frames.push_beside(stamp_s, IntervalBox::from([0, 1, 2].map(|axis| Interval::centred(truth[axis], 0.1))), None);
        let Unlinked { number, stamp_s: to_s, before, .. } = frames.unlinked().unwrap();
        let way = before.and_then(|(from_s, _)| history.way(from_s, to_s, &wheels(), &reach()));
        frames.link(number, way, None, &[]);
    }
    let links = |frames: &KeyFrames| frames.frames.iter().map(|frame| frame.link.is_some()).collect::<Vec<_>>();
    let (n_frames, latest_s) = (frames.n_frames(), frames.latest_s().unwrap());
    frames.drop_one();
    assert_eq!(frames.n_frames(), n_frames - 1);
    assert!(links(&frames)[1..].iter().all(|is_linked| *is_linked));
    // What was learnt by the time of the latest key frame stays, and what was learnt later is taken back.
    let mut kept = frames.clone();
    kept.forget_since(latest_s);
    assert_eq!(links(&kept), links(&frames));
    let at = frames.frames.iter().position(|frame| frame.way_known_s.is_some()).unwrap();
    frames.forget_since(latest_s - 1e-6);
    let left = links(&frames);
    assert!(at < left.len() && !left[at] && left[1..].iter().filter(|is_linked| !**is_linked).count() == 1, "{left:?}");
}

/// A drive with a flow sensor, and key frames at all of its stamps but the last but two, whose ways are known as soon as they are there.
struct WithLate {
    drive: Drive,
    frames: KeyFrames,
    /// Place of the stamp without a key frame among those of the drive.
    late: usize,
    history: WheelHistory,
}

impl WithLate {
    fn new(seed: u64) -> WithLate {
        let drive = Drive::new(&mut Draw::new(seed), true, 4.0, 4);
        let late = drive.stamps_s.len() - 3;
        let history = drive.history(true);
        let mut with_late = WithLate { drive, frames: KeyFrames::new(&robot()), late, history };
        for at in (0..late).chain(late + 1..with_late.drive.stamps_s.len()) {
            with_late.frames.push_beside(with_late.drive.stamps_s[at], with_late.pose(at), None);
            let Unlinked { number, stamp_s: to_s, before, .. } = with_late.frames.unlinked().unwrap();
            let ways = before.map_or((None, None), |(from_s, heading)| with_late.ways(from_s, to_s, heading));
            with_late.frames.link(number, ways.0, ways.1, &[]);
        }
        with_late
    }

    fn pose(&self, at: usize) -> PoseBox {
        IntervalBox::from([0, 1, 2].map(|axis| Interval::centred(self.drive.poses[at][axis], 0.1)))
    }

    fn ways(&self, from_s: f64, to_s: f64, heading: Interval) -> Ways {
        let way = self.history.way(from_s, to_s, &wheels(), &reach());
        (way, self.history.flow_way(from_s, to_s, heading, &wheels(), &reach()))
    }

    /// Adds the late key frame by ways that `change` may change. Returns whether it was added.
    fn insert(&mut self, change: &dyn Fn(&mut FlowWay)) -> bool {
        let stamps_s = [0, 1, 2].map(|at| self.drive.stamps_s[self.late - 1 + at]);
        let gap = self.frames.gap_for(stamps_s[1], "late", 0.1).unwrap();
        let mut ways = [0, 1].map(|at| self.ways(stamps_s[at], stamps_s[at + 1], gap.heading));
        ways.iter_mut().for_each(|(_, flow)| flow.iter_mut().for_each(change));
        let reading = FrameReading::new("late", Arc::new(Displaced(self.drive.poses[self.late])), OFF);
        self.frames.insert(&gap, stamps_s[1], self.pose(self.late), reading, ways)
    }

    fn links(&self) -> Vec<bool> {
        self.frames.frames.iter().map(|frame| frame.link.is_some()).collect()
    }

    /// Whether each way by the flow sensor begins with the error of the place at which the way before ends.
    fn shares_errors(&self) -> Vec<bool> {
        let read = |frame: &KeyFrame| frame.link.as_ref().and_then(Link::read).is_some_and(|read| read.shares_error);
        self.frames.frames.iter().skip(2).map(read).collect()
    }
}

#[test]
fn a_late_way_by_the_flow_sensor_is_forgotten_with_the_heading_that_it_was_computed_from() {
    let mut with_late = WithLate::new(20_261_130);
    let late = with_late.late;
    assert!(with_late.insert(&|_| ()));
    assert!(with_late.links()[1..].iter().all(|is_linked| *is_linked));
    // The latest key frame has told of the heading, perhaps. Without it both ways about the late reading are gone, and the others stay.
    let after_s = with_late.drive.stamps_s[late + 1];
    with_late.frames.forget_since(after_s);
    let mut expected = vec![true; late + 2];
    (expected[0], expected[late], expected[late + 1]) = (false, false, false);
    assert_eq!(with_late.links(), expected);
}

#[test]
fn a_late_key_frame_is_left_out_where_its_ways_are_by_other_counts() {
    let mut with_late = WithLate::new(20_261_131);
    assert!(!with_late.insert(&|flow| flow.end_readings_s[0][0] -= 0.01));
    assert!(!with_late.insert(&|flow| flow.end_error_m[1] += 1e-4));
    assert!(with_late.insert(&|_| ()) && with_late.shares_errors().iter().all(|shares| *shares));
}

#[test]
fn a_way_by_other_counts_shares_no_error_with_the_next_one() {
    let mut with_late = WithLate::new(20_261_132);
    assert!(with_late.shares_errors().iter().all(|shares| *shares));
    // A further reading at the second key frame has the way to it read anew, by a count that arrived late.
    let (number, stamp_s) = with_late.frames.stamps().nth(1).unwrap();
    let reading = FrameReading::new("more", Arc::new(Displaced(with_late.drive.poses[1])), OFF);
    assert!(with_late.frames.join(stamp_s, reading));
    let Unlinked { before, .. } = with_late.frames.unlinked().unwrap();
    let (from_s, heading) = before.unwrap();
    let (way, mut flow) = with_late.ways(from_s, stamp_s, heading);
    flow.iter_mut().for_each(|flow| flow.end_readings_s[1][0] += 0.001);
    with_late.frames.link(number, way, flow, &[OFF]);
    let shares = with_late.shares_errors();
    assert!(!shares[0] && shares[1..].iter().all(|shares| *shares), "{shares:?}");
}

/// A reading that shows things of the map.
struct OfTheMap(Displaced);

impl Relations for OfTheMap {
    fn quantities(&self, frame: usize, pose: &PoseBox) -> Vec<(Variable, Interval)> {
        self.0.quantities(frame, pose)
    }

    fn is_of_the_map(&self) -> bool {
        true
    }

    fn stamp_error_s(&self) -> f64 {
        self.0.stamp_error_s()
    }

    fn stamp_bound(&self) -> Assumption {
        self.0.stamp_bound()
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        self.0.shift_m(stray)
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        self.0.shift_parts(stray)
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        self.0.rows(frame, domain)
    }
}

#[test]
fn what_is_forgotten_takes_back_what_it_told_of_the_poses_before_it() {
    let mut frames = KeyFrames::new(&robot());
    let pose = IntervalBox::from([Interval::centred(0.0, 0.1); 3]);
    let heading = |frames: &KeyFrames, at: usize| frames.frames[at].pose[2];
    for stamp_s in [0.0, 3.0, 6.0, 9.0] {
        frames.push(stamp_s, pose, None);
        let half = 0.1 - 0.01 * (1.0 + stamp_s);
        // With each key frame the heading of the first one becomes known better, and with the last two that of the second one.
        let known_s = frames.latest_s().unwrap();
        frames.narrow(&[(Variable::Pose(0, 2), Interval::centred(0.0, half))], known_s);
        if stamp_s >= 6.0 {
            frames.narrow(&[(Variable::Pose(1, 2), Interval::centred(0.0, half))], known_s);
        }
    }
    frames.forget_since(8.9);
    assert_eq!(frames.stamps().map(|(_, stamp_s)| stamp_s).collect::<Vec<_>>(), [0.0, 3.0, 6.0]);
    let told_by_6_s = Interval::centred(0.0, 0.1 - 0.01 * 7.0);
    assert_eq!([heading(&frames, 0), heading(&frames, 1)], [told_by_6_s; 2]);
    frames.forget_since(3.0);
    assert_eq!([heading(&frames, 0), heading(&frames, 1)], [Interval::centred(0.0, 0.1 - 0.01 * 4.0), pose[2]]);
    frames.forget_since(-1.0);
    assert_eq!(frames.n_frames(), 0);
}

#[test]
fn hundreds_of_seconds_on_few_key_frames_keep_the_truth_and_are_narrower_than_what_adds_up() {
    for round in 0..6 {
        let mut draw = Draw::new(20_261_127 + round);
        let drive = Drive::new(&mut draw, true, 260.0, 120);
        let history = drive.history(true);
        let mut frames = KeyFrames::new(&robot());
        let around = |at: f64, half: f64, draw: &mut Draw| {
            let off = draw.within(Interval::centred(0.0, half));
            Interval::centred(at + off, half * (1.0 + 1e-9))
        };
        let mut widths_m = Vec::new();
        for (at, (&stamp_s, truth)) in drive.stamps_s.iter().zip(&drive.poses).enumerate() {
            // The heading is known to 10 mrad at each key frame, as by walls, the position to 1 mm at the first one and to 2 m at the others.
            let half_m = if at == 0 { 0.001 } else { 2.0 };
            let pose = [(0, half_m), (1, half_m), (2, 0.01)].map(|(axis, half)| around(truth[axis], half, &mut draw));
            frames.push(stamp_s, IntervalBox::from(pose), None);
            let Unlinked { number, stamp_s: to_s, before, .. } = frames.unlinked().unwrap();
            let (way, flow) = before.map_or((None, None), |(from_s, heading)| {
                let flow = history.flow_way(from_s, to_s, heading, &wheels(), &reach());
                let way = history.way(from_s, to_s, &wheels(), &reach());
                (way.filter(|_| round % 2 == 0), flow.filter(|_| round % 3 < 2))
            });
            frames.link(number, way, flow, &[]);
            assert!(frames.frames.len() <= MOST);
            let wanted = (0..3).map(|axis| Variable::Pose(number, axis)).collect();
            let mut hull = Hull::new(frames.related(&[]).unwrap(), wanted);
            while !hull.advance() {}
            let bounds = hull.bounds().unwrap();
            for (axis, bound) in bounds.iter().enumerate() {
                assert!(
                    bound.inflate(1e-6).contains(truth[axis]),
                    "round {round}, {stamp_s} s: {} not in {bound}",
                    truth[axis]
                );
            }
            let narrower: Vec<_> = (0..3).map(|axis| (Variable::Pose(number, axis), bounds[axis])).collect();
            frames.narrow(&narrower, stamp_s);
            widths_m.push(bounds[0].width().max(bounds[1].width()));
        }
        let last_m = widths_m[widths_m.len() - 1];
        // By the flow sensor: 0.4 % of a path of at most 0.5 m/s on either side, and a few millimetres for each way. Headings that are off by 10
        // mrad on every way, all to the same side, would add twice 1 % of the path.
        let path_m: f64 = drive.path_m;
        assert!(round % 3 == 2 || last_m < 2.0 * 0.0085 * path_m, "round {round}: {last_m} m after {path_m} m");
    }
}

/// The greatest displacement and turn between a pose that is read and the pose at its stamp.
pub(super) const OFF: Stray = Stray { metres: 0.01, radians: 0.005 };

/// A reading of the pose, displaced and turned.
pub(super) struct Displaced(pub(super) [f64; 3]);

impl Relations for Displaced {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        Vec::new()
    }

    fn stamp_error_s(&self) -> f64 {
        0.0
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::FLOOR_CAMERA_STAMP
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        vec![(bounds::BODY_TILT, stray.metres)]
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let row = |axis: usize| {
            let position = Variable::Pose(frame, axis);
            let sides = Interval::point(self.0[axis]) - domain.reference(position);
            Row::new(domain, &[(position, Interval::ONE)], sides.inflate(1e-4))
        };
        vec![row(0), row(1), row(2)]
    }
}

#[test]
fn what_displaces_a_reading_displaces_neither_the_pose_nor_the_way() {
    let mut draw = Draw::new(20_261_131);
    for round in 0..20 {
        let drive = Drive::new(&mut draw, true, 1.0, 2);
        let history = drive.history(true);
        let displaced = |truth: &[f64; 3], course: f64| {
            let [x, y] = [course.cos(), course.sin()].map(|part| OFF.metres * part);
            [truth[0] + x, truth[1] + y, truth[2] + OFF.radians * course.signum()]
        };
        let courses = [0, 1].map(|_| draw.between(-3.2, 3.2));
        // The bounds with readings of the pose at both key frames, and those by the way alone.
        let widths = [true, false].map(|is_read| {
            let mut frames = KeyFrames::new(&robot());
            for (at, (&stamp_s, truth)) in drive.stamps_s.iter().zip(&drive.poses).enumerate() {
                let read = Displaced(displaced(truth, courses[at]));
                // The first pose is known to 1 mm and 1 mrad, the second one to 0.1 m and 20 mrad.
                let (half_m, half_rad) = if at == 0 { (0.001, 0.001) } else { (0.1, 0.02) };
                let pose = [half_m, half_m, half_rad];
                let pose = IntervalBox::from([0, 1, 2].map(|axis| Interval::centred(truth[axis], pose[axis])));
                frames.push(stamp_s, pose, is_read.then(|| FrameReading::new("", Arc::new(read), OFF)));
                let Unlinked { number, stamp_s: to_s, before, .. } = frames.unlinked().unwrap();
                let flow =
                    before.and_then(|(from_s, heading)| history.flow_way(from_s, to_s, heading, &wheels(), &reach()));
                frames.link(number, None, flow, &[]);
            }
            let number = frames.latest_number();
            let wanted = (0..3).map(|axis| Variable::Pose(number, axis)).collect();
            let mut hull = Hull::new(frames.related(&[]).unwrap(), wanted);
            while !hull.advance() {}
            let bounds = hull.bounds().unwrap();
            for (bound, truth) in bounds.iter().zip(drive.poses[1]) {
                assert!(bound.inflate(1e-9).contains(truth), "round {round}: {truth} not in {bound}");
            }
            [bounds[0].width().max(bounds[1].width()), bounds[2].width()]
        });
        // The solver stops at a thousandth of half the width of the box before, at either end; that is 0.2 m and 40 mrad wide.
        const GAPS: [f64; 2] = [2e-4, 4e-5];
        let read = [2.0 * (OFF.metres + 1e-4), 2.0 * (OFF.radians + 1e-4)];
        for of in 0..2 {
            assert!(widths[0][of] <= widths[1][of].min(read[of]) + GAPS[of], "round {round}: {widths:?}");
        }
    }
}
