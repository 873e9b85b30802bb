//! Tests of what the program of all key frames allows for beside the readings: each part alone.

use std::sync::Arc;

use interval::IntervalBox;

use super::{
    super::{
        super::Hull,
        tests::{Displaced, OFF},
    },
    *,
};
use crate::{
    RobotModel,
    graph::trial::{flow, gyro, reach, robot, wheels},
    motion::WheelHistory,
    robot::{FlowModel, GyroModel, Reach},
};

/// A robot with wheels, a gyroscope that is read once in a second and whose accumulated angle error is at most `angle_rad`, and a flow sensor that
/// counts 0.1 mm, all without other errors.
fn exact(angle_rad: f64) -> RobotModel {
    let gyro = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::ONE,
        noise_rad_per_s: 0.0,
        angle_floor_rad: angle_rad,
        angle_rad_per_s: 0.0,
        period_s: 1.0,
        ..gyro(true)
    };
    let flow = FlowModel {
        position_m: [Interval::ZERO; 2],
        metres_per_count: Interval::point(1e-4),
        scale_change: 0.0,
        yaw_rad: Interval::ZERO,
        period_s: 1.0,
        ..flow()
    };
    RobotModel { gyro: Some(gyro), flow: Some(flow), ..robot() }
}

/// The bounds of the pose at the latest key frame.
fn bounds_at_latest(frames: &KeyFrames) -> Vec<Interval> {
    let number = frames.latest_number();
    let mut hull = Hull::new(frames.related(&[]).unwrap(), (0..3).map(|axis| Variable::Pose(number, axis)).collect());
    while !hull.advance() {}
    hull.bounds().unwrap()
}

/// The bounds of the pose after a way of 1 s by the gyroscope's turn and the flow sensor's counts. It began at the origin with the given heading,
/// and `end` is known to 10 mm and 1 mrad.
fn bounds_after(
    heading_rad: f64,
    turn_rad: f64,
    counts: [[i64; 2]; 2],
    end: [f64; 3],
    robot: &RobotModel,
) -> Vec<Interval> {
    let reach = Reach { acceleration_m_per_s2: 0.0, ..reach() };
    let mut history = WheelHistory::new(60.0).with_gyro(robot.gyro.unwrap()).with_flow(robot.flow.unwrap());
    history.push_flow(0.0, counts[0], 0);
    history.push_flow(1.0, counts[1], 0);
    history.push_rate(1.0, turn_rad);
    let mut frames = KeyFrames::new(robot);
    let begin = IntervalBox::from([0.0, 0.0, heading_rad].map(Interval::point));
    frames.push_beside(0.0, begin, None);
    let half = [0.01, 0.01, 0.001];
    let end = IntervalBox::from([0, 1, 2].map(|axis| Interval::centred(end[axis], half[axis])));
    frames.push_beside(1.0, end, None);
    let way = history.flow_way(0.0, 1.0, Interval::point(heading_rad), &wheels(), &reach);
    assert!(way.is_some());
    frames.link(frames.latest_number(), None, way, &[]);
    bounds_at_latest(&frames)
}

#[test]
fn the_counts_that_are_lost_at_both_ends_of_a_way_leave_the_truth_in_the_bounds() {
    // Heading 45°. Forward the robot goes 100.99 counts, of which 100 are read; to the right, 100.99, too, from −0.01 to −101 of a count, of which
    // 100 are read. Along x it goes 100.99·√2 counts of 0.1 mm: 1.4 counts more than are read.
    let heading_rad = std::f64::consts::FRAC_PI_4;
    let end = [100.99e-4 * std::f64::consts::SQRT_2, 0.0, heading_rad];
    let bounds = bounds_after(heading_rad, 0.0, [[0, -1], [100, -101]], end, &exact(f64::INFINITY));
    assert!(bounds[0].contains(end[0]) && bounds[0].width() < 2.9e-4, "{}", bounds[0]);
}

#[test]
fn an_accumulated_angle_error_from_one_end_of_its_bound_to_the_other_leaves_the_truth_in_the_bounds() {
    // The turn of 0.1 rad is read as 0.1004 rad, as much as the accumulated angle error may change.
    let bounds = bounds_after(0.0, 0.1004, [[0, 0], [0, 0]], [0.0, 0.0, 0.1], &exact(0.0004));
    assert!(bounds[2].inflate(1e-9).contains(0.1) && bounds[2].width() < 0.0009, "{}", bounds[2]);
}

#[test]
fn a_reading_that_is_displaced_as_far_as_may_be_leaves_the_truth_in_the_bounds() {
    // The robot is at the origin. A single reading, whose own error is at most 0.1 mm and 0.1 mrad, shows it 10 mm ahead and turned by 5 mrad.
    let mut frames = KeyFrames::new(&robot());
    let pose = IntervalBox::from([Interval::centred(0.0, 0.1); 3]);
    frames.push(0.0, pose, Some(FrameReading::new("", Arc::new(Displaced([OFF.metres, 0.0, OFF.radians])), OFF)));
    let bounds = bounds_at_latest(&frames);
    for (axis, bound) in bounds.iter().enumerate() {
        assert!(bound.contains(0.0) && bound.width() < 2.0 * OFF.of_axis(axis) + 0.0003, "axis {axis}: {bound}");
    }
}

#[test]
fn two_readings_at_one_key_frame_are_displaced_each_by_its_own_error() {
    // One reading shows the robot, which is at the origin, as far ahead and turned as may be, the other as far behind and turned back.
    let reading = |sign: f64, source: &'static str| {
        let shown = Displaced([sign * OFF.metres, 0.0, sign * OFF.radians]);
        FrameReading::new(source, Arc::new(shown), OFF)
    };
    let mut frames = KeyFrames::new(&robot());
    frames.push(0.0, IntervalBox::from([Interval::centred(0.0, 0.1); 3]), Some(reading(1.0, "first")));
    assert!(!frames.join(0.0, reading(-1.0, "first")) && !frames.join(0.1, reading(-1.0, "second")));
    assert!(frames.join(0.0, reading(-1.0, "second")));
    let bounds = bounds_at_latest(&frames);
    for axis in [0, 2] {
        assert!(bounds[axis].contains(0.0) && bounds[axis].width() < 0.0005, "axis {axis}: {}", bounds[axis]);
    }
}

#[test]
fn every_pair_within_a_disc_satisfies_its_rows_and_the_corners_of_its_square_do_not() {
    let pair = [0, 1].map(|axis| Variable::Constant(Constant::FloorTilt(axis)));
    let mut frames = KeyFrames::new(&robot());
    frames.discs = vec![(pair, 0.01)];
    let mut domain = Domain::default();
    // The reference values are beside the middle of the disc.
    domain.put(pair[0], Interval::new(-0.01, 0.01));
    domain.put(pair[1], Interval::new(-0.002, 0.01));
    let rows = frames.disc_rows(&pair.into_iter().collect(), &domain);
    assert_eq!(rows.len(), 2);
    let hold = |at: [f64; 2]| {
        let value =
            |row: &Row| row.value_at(|variable| at[usize::from(variable == pair[1])] - domain.reference(variable));
        rows.iter().all(|row| row.sides.inflate(1e-15).contains(value(row)))
    };
    let most = 0.01 * std::f64::consts::FRAC_1_SQRT_2;
    for [a, b] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        assert!(hold([a * most, b * most]) && !hold([1.01 * a * most, 1.01 * b * most]), "{rows:?}");
    }
}

#[test]
fn a_bias_that_drifts_steadily_satisfies_the_row_of_two_ways_and_a_faster_one_does_not() {
    // Ways of 2 s and of 4 s, whose middles are 3 s apart: at 10⁻⁴ rad/s² the mean bias changes by 3·10⁻⁴ rad/s.
    let drifting = GyroModel { bias_wander_rad_per_s2: 1e-4, ..gyro(false) };
    let mut frames = KeyFrames::new(&RobotModel { gyro: Some(drifting), ..robot() });
    let mut history = WheelHistory::new(60.0);
    [0.0, 2.0, 6.0].iter().for_each(|&time_s| assert!(history.push(time_s, [0, 0])));
    for (at, stamp_s) in [0.0, 2.0, 6.0].into_iter().enumerate() {
        frames.push_beside(stamp_s, IntervalBox::from([Interval::ZERO; 3]), None);
        let from_s = [0.0, 0.0, 2.0][at];
        frames.link(frames.latest_number(), history.way(from_s, stamp_s, &wheels(), &reach()), None, &[]);
    }
    let domain = frames.domain(&[]);
    let [before, after] = [1, 2].map(Variable::GyroBias);
    let row = frames.drift_row(&frames.frames[1], &frames.frames[2], &domain).unwrap();
    for sign in [1.0, -1.0] {
        let holds = |change: f64| {
            let biases = [-0.5 * sign * change, 0.5 * sign * change];
            let value = row.value_at(|variable| biases[usize::from(variable == after)]);
            row.sides.inflate(1e-15).contains(value)
        };
        assert!(row.coefficient(before) != 0.0 && holds(3e-4) && !holds(3.01e-4), "{row:?}");
    }
}
