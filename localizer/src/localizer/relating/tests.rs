//! Tests of what the localizer tells the key frames.

use interval::Interval;

use super::*;
use crate::{
    Map, PoseBox, RobotModel,
    bounds::{self, Assumption},
    graph::{
        Domain, Row, Variable,
        trial::{gyro, robot},
    },
    robot::GyroModel,
};

/// Greatest error of the stamp of a compass.
const STAMP_ERROR_S: f64 = 0.01;

/// A reading of the heading.
struct Compass;

impl Relations for Compass {
    fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        Vec::new()
    }

    fn stamp_error_s(&self) -> f64 {
        STAMP_ERROR_S
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::GNSS_STAMP
    }

    fn shift_parts(&self, _stray: &Stray) -> Vec<(Assumption, f64)> {
        Vec::new()
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn rows(&self, frame: usize, _domain: &Domain) -> Vec<Row> {
        let terms = vec![(Variable::Pose(frame, 2), 1.0)];
        vec![Row { terms, sides: Interval::centred(0.0, 0.001), parts: Vec::new(), devices: vec!["compass"] }]
    }
}

#[test]
fn a_reading_at_a_key_frame_may_be_turned_by_what_the_gyroscope_reads_within_its_stamps_error() {
    // The robot turns at 1 rad/s, and the gyroscope errs by nothing: within 10 ms of the stamp it turns by 10 mrad. By its greatest turn rate alone
    // it might be 40 mrad.
    let still = GyroModel { bias_rad_per_s: Interval::ZERO, scale: Interval::ONE, noise_rad_per_s: 0.0, ..gyro(false) };
    let mut robot = RobotModel { gyro: Some(still), flow: None, ..robot() };
    robot.reach.acceleration_m_per_s2 = 0.0;
    let pose = PoseBox::from([Interval::centred(0.0, 0.1); 3]);
    let map = Map::of_room([Interval::new(-5.0, 5.0); 2]);
    let mut localizer = Localizer::new(map, robot, Vec::new(), pose);
    for step in 1..=100_u32 {
        localizer.wheels.push_rate(0.01 * f64::from(step), 1.0);
    }
    let stray = Stray::by_reach(STAMP_ERROR_S, &localizer.robot.reach);
    localizer.graph.frames.push(0.505, pose, Some(FrameReading::new("compass", Arc::new(Compass), stray)));
    localizer.learn_ways();
    let number = localizer.graph.frames.latest_number();
    let turned = localizer.graph.frames.related(&[]).unwrap().domain.value(Variable::Shift(number, 2));
    assert!(turned.contains(0.01) && turned.contains(-0.01) && turned.hi() < 0.0101, "{turned}");
}

/// A localizer of a robot that has rested for a second, with key frames at 0.1, 0.4 and 0.7 s whose ways are not known yet.
fn at_rest() -> Localizer {
    let robot = RobotModel { gyro: Some(gyro(false)), flow: None, ..robot() };
    let pose = PoseBox::from([Interval::centred(0.0, 0.1); 3]);
    let map = Map::of_room([Interval::new(-5.0, 5.0); 2]);
    let mut localizer = Localizer::new(map, robot, Vec::new(), pose);
    for step in 0..=100_u32 {
        let time_s = 0.01 * f64::from(step);
        localizer.wheels.push(time_s, [0; 2]);
        localizer.wheels.push_rate(time_s, 0.0);
    }
    for (stamp_s, source) in [(0.1, "first"), (0.4, "second"), (0.7, "third")] {
        let reading = FrameReading::new(source, Arc::new(Compass), Stray::default());
        localizer.graph.frames.push(stamp_s, pose, Some(reading));
        localizer.graph.await_readings();
    }
    localizer
}

/// Numbers of rows of the ways between the three key frames.
fn n_rows_of_ways(localizer: &mut Localizer) -> [usize; 2] {
    let related = localizer.branches().next_program().unwrap();
    assert!(localizer.graph.frames.unlinked().is_none());
    [[0.1, 0.4], [0.4, 0.7]].map(|span_s: [f64; 2]| {
        related.rows.iter().filter(|row| row.readings.iter().any(|readings| readings.span_s == span_s)).count()
    })
}

#[test]
fn key_frames_that_are_made_while_another_is_worked_on_are_related_by_their_ways_too() {
    let [first, second] = n_rows_of_ways(&mut at_rest());
    assert!(first > 0 && second > 0);
}

#[test]
fn no_way_leads_across_the_end_of_a_doubt() {
    let mut localizer = at_rest();
    localizer.doubts.ended_s = 0.2;
    let [first, second] = n_rows_of_ways(&mut localizer);
    assert!(first == 0 && second > 0, "{first}, {second}");
}

#[test]
fn no_way_is_by_wheels_that_are_known_to_have_slipped() {
    let mut localizer = at_rest();
    // Slip is noted from a second before it was seen to half a second after.
    localizer.slip.certify([1.3, 1.4]);
    let heading = Interval::ZERO;
    assert!(localizer.ways([0.1, 0.25], heading).0.is_some());
    assert!(localizer.ways([0.1, 0.4], heading).0.is_none() && localizer.ways([0.4, 0.7], heading).0.is_none());
}

#[test]
fn a_doubt_forgets_the_key_frames_of_the_last_seconds() {
    let mut localizer = at_rest();
    localizer.now_s = 3.3;
    localizer.begin_doubt(None);
    assert_eq!(localizer.graph.frames.stamps().map(|(_, stamp_s)| stamp_s).collect::<Vec<_>>(), [0.1]);
}
