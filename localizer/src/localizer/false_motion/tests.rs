//! Tests of the spans of motion that a doubt sets aside, by a robot that stands among equal rows and is pushed from one row to another.
//!
//! Ten times a second a reading tells how far the robot is from some row, which is what tiles on a floor tell. Within a tenth of a second the robot
//! cannot get to the next row, so that it is there only if it was pushed while no reading came, or while readings told nothing.

#![allow(clippy::unwrap_used)]

use interval::{
    Interval,
    contractor::{Contractor, Outcome},
};

use super::*;
use crate::{
    Constraint, Map, Method, Pose, PoseBox, Reading, RobotModel, Status, graph::trial::robot,
    localizer::hypothesis::Failed, method::Context, robot::Reach,
};

/// Distance from one row to the next.
const ROW_M: f64 = 0.3;
/// Greatest speed of the robot, at which it goes from one row to the next in 0.43 s.
const SPEED_M_PER_S: f64 = 0.7;
/// The time at which a reading tells for the first time in which row the robot is.
const TOLD_S: f64 = 10.3;

/// Method that reads the distance from some row, and at the times in `told` the row.
struct Rows {
    told: Vec<(f64, f64)>,
    gaps_s: Vec<[f64; 2]>,
    vague_s: [f64; 2],
}

impl Method for Rows {
    fn name(&self) -> &'static str {
        "rows"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Range { .. })
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        let stamp_s = reading.measured_s();
        let told = self.told.iter().find(|(at_s, _)| (stamp_s - at_s).abs() < 1e-6);
        let is_within = |gap_s: &[f64; 2]| gap_s[0] + 1e-6 < stamp_s && stamp_s < gap_s[1] - 1e-6;
        let rows = match told {
            Some((_, y_m)) => vec![Interval::centred(*y_m, 0.05)],
            None if self.gaps_s.iter().any(is_within) => return None,
            None if is_within(&self.vague_s) => vec![Interval::centred(0.0, 2.0)],
            None => (-5..=5).map(|row| Interval::centred(f64::from(row) * ROW_M, 0.01)).collect(),
        };
        Some(Constraint::new(self.name(), stamp_s, InRows(rows)))
    }
}

/// Contractor that keeps y in one of several intervals.
struct InRows(Vec<Interval>);

impl Contractor<3> for InRows {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        *domain = PoseUnion { branches: self.branches(domain) }.hull();
        if domain.is_empty() { Outcome::Empty("in no row") } else { Outcome::Feasible }
    }

    fn branches(&self, domain: &PoseBox) -> Vec<PoseBox> {
        let rows = self.0.iter().map(|row| PoseBox::from([domain[0], domain[1].intersect(*row), domain[2]]));
        rows.filter(|row| !row.is_empty()).collect()
    }
}

/// A localizer after `until_s` of a robot that stands at the origin by its wheels. Readings are missing within the given times, and tell the row at the
/// given times.
fn localizer(gaps_s: &[[f64; 2]], told: &[(f64, f64)], until_s: f64) -> Localizer {
    let rows = Rows { told: told.to_vec(), gaps_s: gaps_s.to_vec(), vague_s: [0.0; 2] };
    localizer_by(rows, SPEED_M_PER_S, until_s)
}

/// A localizer after `until_s` of a robot that stands at the origin by its wheels, and is not faster than given.
fn localizer_by(rows: Rows, speed_m_per_s: f64, until_s: f64) -> Localizer {
    let reach = Reach { speed_m_per_s, turn_rate_rad_per_s: 0.1, acceleration_m_per_s2: 2.0 };
    let robot = RobotModel { reach, gyro: None, flow: None, ..robot() };
    let methods: Vec<Box<dyn Method>> = vec![Box::new(rows)];
    let map = Map::of_room([Interval::new(-5.0, 5.0); 2]);
    let mut localizer = Localizer::new(map, robot, methods, PoseBox::from([Interval::ZERO; 3]));
    go_on(&mut localizer, [0.0, until_s]);
    localizer
}

fn go_on(localizer: &mut Localizer, [from_s, until_s]: [f64; 2]) {
    for step in (from_s * 100.0).round() as u32 + 1..=(until_s * 100.0).round() as u32 {
        let time_s = 0.01 * f64::from(step);
        localizer.observe(&Reading::Wheels { measured_s: time_s, arrived_s: time_s, ticks: [0; 2] });
        if step.is_multiple_of(10) {
            localizer.observe(&Reading::Range { measured_s: time_s, arrived_s: time_s, sightings: Vec::new() });
        }
    }
}

fn at(y_m: f64) -> Pose {
    Pose { x_m: 0.0, y_m, heading_rad: 0.0 }
}

fn followed(localizer: &Localizer, failed: Failed) -> Option<usize> {
    localizer.hypotheses.iter().position(|hypothesis| hypothesis.failed == failed)
}

#[test]
fn a_push_two_seconds_before_it_shows_is_explained_by_its_own_span_of_motion() {
    let mut localizer = localizer(&[[7.8, 8.4]], &[(TOLD_S, ROW_M), (10.6, ROW_M)], 10.2);
    assert!(localizer.estimate().status == Status::Sound && !localizer.estimate().pose.contains(at(ROW_M)));
    go_on(&mut localizer, [10.2, TOLD_S]);
    assert!(localizer.estimate().status == Status::Recovering && localizer.estimate().pose.contains(at(ROW_M)));
    // Within the last half second readings came ten times a second, so that the robot cannot have been pushed to another row then.
    assert_eq!(followed(&localizer, Failed::Motion), None);
    assert_eq!(localizer.doubts.span_s, SPAN_S);
    // That the reading is false is possible as well, until a second one says the same.
    assert!(localizer.estimate().pose.contains(at(0.0)));
    go_on(&mut localizer, [TOLD_S, 10.6]);
    let estimate = localizer.estimate();
    assert!(estimate.status == Status::Sound && estimate.pose.contains(at(ROW_M)), "{estimate:?}");
    assert!(estimate.pose.hull()[1].width() < 0.03, "{estimate:?}");
}

#[test]
fn a_push_is_explained_whenever_it_began() {
    // At 1.1 m/s the next row is 0.27 s away. The push lasts 0.3 s, in which two readings tell nothing, and each of them is a stored slot at which a
    // span may begin or end.
    for tenths in 0..20 {
        let from_s = 7.7 + 0.1 * f64::from(tenths);
        let rows = Rows { told: vec![(TOLD_S, ROW_M)], gaps_s: Vec::new(), vague_s: [from_s, from_s + 0.3] };
        let localizer = localizer_by(rows, 1.1, TOLD_S);
        assert!(followed(&localizer, Failed::EarlierMotion).is_some(), "pushed at {from_s} s");
        assert!(localizer.estimate().pose.contains(at(ROW_M)), "pushed at {from_s} s");
        assert_eq!(localizer.doubts.span_s, SPAN_S);
    }
}

#[test]
fn the_wheels_are_believed_before_and_after_the_span_that_is_set_aside() {
    let mut localizer = localizer(&[[7.8, 8.4]], &[(TOLD_S, ROW_M)], TOLD_S);
    go_on(&mut localizer, [TOLD_S, TOLD_S + 0.09]);
    let earlier = followed(&localizer, Failed::EarlierMotion).unwrap();
    let carried = localizer.carried_of(earlier, localizer.ring.last().unwrap(), localizer.now_s).unwrap();
    // By reach alone y would be 2 · 0.7 m/s · 0.09 s = 0.126 m wider.
    assert!(carried.contains(at(ROW_M)) && carried.hull()[1].width() < 0.03, "{carried:?}");
    // By hand: of a second, 0.3 s by reach make 2 · 0.7 m/s · 0.3 s = 0.42 m.
    let width_m = |by_reach_s: [f64; 2]| {
        let start = PoseUnion::single(PoseBox::from([Interval::ZERO; 3]));
        localizer.carried_past(&start, [9.0, 10.0], by_reach_s).unwrap().hull()[1].width()
    };
    assert!((0.42..0.45).contains(&width_m([9.2, 9.5])), "{}", width_m([9.2, 9.5]));
    assert!((0.42..0.45).contains(&width_m([8.0, 9.3])), "{}", width_m([8.0, 9.3]));
    assert!((1.4..1.41).contains(&width_m([f64::NEG_INFINITY, f64::INFINITY])));
    assert!(width_m([f64::NEG_INFINITY; 2]) < 0.03 && width_m([10.5, 11.0]) < 0.03);
}

#[test]
fn the_answer_is_the_union_over_all_spans_that_explain_the_readings() {
    // The robot can have been pushed in either of two gaps, so that between them it was in the one row or in the other.
    let both = localizer(&[[7.8, 8.4], [9.0, 9.6]], &[(TOLD_S, ROW_M)], TOLD_S);
    let earlier = followed(&both, Failed::EarlierMotion).unwrap();
    let between = |localizer: &Localizer, hypothesis: usize| {
        localizer.ring.before(8.8).map(|slot| slot.unions[hypothesis].clone()).unwrap()
    };
    assert!(between(&both, earlier).contains(at(0.0)) && between(&both, earlier).contains(at(ROW_M)));
    assert!(both.estimate().pose.contains(at(ROW_M)));
    // Where readings came in the second gap, the first one alone explains them.
    let first = localizer(&[[7.8, 8.4]], &[(TOLD_S, ROW_M)], TOLD_S);
    let earlier = followed(&first, Failed::EarlierMotion).unwrap();
    assert!(between(&first, earlier).contains(at(ROW_M)));
}

#[test]
fn no_longer_span_is_set_aside_than_explains_the_readings() {
    // A push by one row, of which the next reading tells, is within reach of the last half second.
    let by_one = localizer(&[[9.7, 10.3]], &[(TOLD_S, ROW_M)], TOLD_S);
    assert!(followed(&by_one, Failed::Motion).is_some() && by_one.estimate().pose.contains(at(ROW_M)));
    assert_eq!((followed(&by_one, Failed::EarlierMotion), by_one.doubts.span_s), (None, SPAN_S));
    // To be pushed by three rows takes 1.3 s.
    let by_three = localizer(&[[8.9, 10.3]], &[(TOLD_S, 3.0 * ROW_M)], TOLD_S);
    assert_eq!(by_three.doubts.span_s, 2.0 * SPAN_S);
    assert!(followed(&by_three, Failed::Motion).is_some() && by_three.estimate().pose.contains(at(3.0 * ROW_M)));
    // No push leads there, and all that is remembered was asked: only the reading, or all that was known, can be false.
    let by_ten = localizer(&[[8.9, 10.3]], &[(TOLD_S, 10.0 * ROW_M)], TOLD_S);
    assert_eq!((by_ten.doubts.span_s, by_ten.estimate().pose.contains(at(0.0))), (REMEMBER_S, true));
}

#[test]
fn a_doubt_soon_after_another_one_sets_aside_spans_twice_as_long() {
    let told = [(TOLD_S, ROW_M), (10.6, ROW_M), (11.5, 0.0)];
    let mut again = localizer(&[[7.8, 8.4], [10.8, 11.4]], &told, 11.4);
    assert_eq!(again.estimate().status, Status::Sound);
    go_on(&mut again, [11.4, 11.5]);
    assert_eq!((again.estimate().status, again.doubts.span_s), (Status::Recovering, 2.0 * SPAN_S));
    assert!(again.estimate().pose.contains(at(0.0)));
}

#[test]
fn a_span_that_is_over_stays_as_it_is_and_one_that_is_not_ends_when_readings_agree() {
    let witness = |stamp_s: f64| [crate::localizer::hypothesis::Witness::Reading(stamp_s)];
    for (span_s, agreed_s, disagreed_s) in
        [([7.8, 8.4], [7.8, 8.4], [7.8, 8.4]), ([9.7, f64::INFINITY], [9.7, 10.2], [9.7, f64::INFINITY])]
    {
        let mut hypothesis = Hypothesis::of_motion(span_s);
        hypothesis.agree(&witness(8.0), 8.0);
        assert_eq!(hypothesis.by_reach_s(), span_s);
        hypothesis.agree(&witness(10.2), 10.2);
        assert_eq!(hypothesis.by_reach_s(), agreed_s);
        hypothesis.disagree();
        assert_eq!(hypothesis.by_reach_s(), disagreed_s);
    }
}
