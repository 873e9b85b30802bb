//! Tests of the rows of ways by the flow sensor: drives at the corners of all bounds, and ways whose readings are known.

use std::collections::BTreeMap;

use super::*;
use crate::graph::trial::{DOMAINS_OF_A_WAY, Draw, Drive, domains, flow, reach, rounds, wheels};
use crate::motion::WheelHistory;

#[test]
fn the_true_way_satisfies_the_rows_with_one_error_of_the_place_between_two_ways() {
    let mut draw = Draw::new(20_261_125);
    for round in 0..rounds(600) {
        let drive = Drive::short(&mut draw, round % 2 == 0);
        let history = drive.history(true);
        let mut ways = Vec::new();
        for nth in 0..domains() {
            let (mut domain, truth) = drive.domain(&mut draw);
            if nth % DOMAINS_OF_A_WAY == 0 {
                ways = both_ways(&drive, &history, &domain);
            }
            assert_satisfied(&ways, &mut domain, &truth);
        }
    }
}

/// The ways between the three key frames of a drive, by the flow sensor.
fn both_ways(drive: &Drive, history: &WheelHistory, domain: &Domain) -> Vec<FlowWay> {
    let way = |at: usize| {
        let heading = domain.value(Variable::Pose(at, 2));
        history.flow_way(drive.stamps_s[at], drive.stamps_s[at + 1], heading, &wheels(), &reach()).unwrap()
    };
    vec![way(0), way(1)]
}

/// Checks that some errors of the place at the three key frames satisfy the rows of both ways, together with the true values of all else.
fn assert_satisfied(ways: &[FlowWay], domain: &mut Domain, truth: &BTreeMap<Variable, f64>) {
    assert_eq!(ways[0].end_readings_s[1], ways[1].end_readings_s[0]);
    let errors_m = [ways[0].end_error_m[0], ways[0].end_error_m[1], ways[1].end_error_m[1]].map(|error_m| {
        // The true drive is integrated in steps, whose errors are far less than this.
        Interval::centred(0.0, error_m + 1e-7)
    });
    for (frame, &error_m) in errors_m.iter().enumerate() {
        (0..2).for_each(|axis| domain.put(Variable::FlowPlace(frame, axis), error_m));
    }
    let rows = [0, 1].map(|at| flow_rows(&ways[at], [at, at + 1], true, flow().scale_change, domain));
    for row in rows.iter().flatten() {
        assert!(row.named_half() <= row.sides.radius() * (1.0 + 1e-9), "{row:?}");
    }
    for axis in [0, 1] {
        // What is left for E_b − E_a in the first way and for E_c − E_b in the second one.
        let left = [0, 1].map(|at| {
            let row: &Row = &rows[at][axis];
            row.sides
                - Interval::point(row.value_at(|variable| match variable {
                    Variable::FlowPlace(..) => 0.0,
                    _ => truth[&variable] - domain.reference(variable),
                }))
        });
        let middle = errors_m[1].intersect(left[0] + errors_m[0]).intersect(errors_m[2] - left[1]);
        assert!(!middle.is_empty(), "axis {axis}: {left:?}, {errors_m:?}");
    }
}

/// A flow sensor of which all but its counts is known exactly.
fn exactly(metres_per_count: f64) -> crate::robot::FlowModel {
    crate::robot::FlowModel {
        position_m: [Interval::ZERO; 2],
        metres_per_count: Interval::point(metres_per_count),
        yaw_rad: Interval::ZERO,
        scale_change: 0.0,
        ..flow()
    }
}

/// A drive of 2 s at a speed, straight in the first second, and turning at up to 1.5 rad/s in the next: its readings without errors, by a
/// gyroscope of the given scale, and the pose at its end.
fn straight_then_turning(mut history: WheelHistory, speed_m_per_s: f64, true_scale: f64) -> (WheelHistory, [f64; 3]) {
    let (mut pose, mut counts, mut turned_rad) = ([0.0_f64; 3], 0.0, 0.0);
    history.push_flow(0.0, [0, 0], 0);
    for fine in 1..=20_000_u32 {
        let turn_rad = if fine <= 10_000 { 0.0 } else { 1.5e-4 * (f64::from(fine - 10_000) / 2000.0).min(1.0) };
        let (middle_rad, way_m) = (pose[2] + 0.5 * turn_rad, 1e-4 * speed_m_per_s);
        pose = [pose[0] + way_m * middle_rad.cos(), pose[1] + way_m * middle_rad.sin(), pose[2] + turn_rad];
        counts += 1e6 * way_m;
        turned_rad += turn_rad;
        if fine % 100 == 0 {
            let time_s = 1e-4 * f64::from(fine);
            history.push_flow(time_s, [(counts + 1e-6) as i64, 0], 0);
            history.push_rate(time_s, true_scale * turned_rad / 0.01);
            turned_rad = 0.0;
        }
    }
    (history, pose)
}

/// Adds the poses of two key frames to a domain, exactly, and hardly any error of the flow sensor's place there.
fn put_poses(domain: &mut Domain, poses: [[f64; 3]; 2]) {
    for (frame, pose) in poses.into_iter().enumerate() {
        (0..3).for_each(|axis| domain.put(Variable::Pose(frame, axis), Interval::point(pose[axis])));
        (0..2).for_each(|axis| domain.put(Variable::FlowPlace(frame, axis), Interval::centred(0.0, 1e-6)));
    }
}

#[test]
fn a_way_that_was_computed_before_the_gyroscopes_scale_was_known_holds_the_truth() {
    // All is exact but the gyroscope's scale, of which 1 ± 0.003 is declared.
    for (true_scale, known) in [0.9971, 1.0, 1.0029].map(|scale| (scale, 1e-9)).into_iter().chain([(1.002, 1e-3)]) {
        let model = crate::robot::GyroModel { scale: Interval::centred(1.0, 0.003), ..still() };
        let history = WheelHistory::new(60.0).with_gyro(model).with_flow(exactly(1e-6));
        let (history, end) = straight_then_turning(history, 0.5, true_scale);
        let way = history.flow_way(0.0, 2.0, Interval::ZERO, &wheels(), &reach()).unwrap();
        let mut domain = exact_constants(1e-6);
        let scale = Variable::Constant(Constant::GyroScale);
        // The reference is beside the true value, as far as the scale is known.
        domain.put(scale, Interval::centred(true_scale + known, known * (1.0 + 1e-9)));
        put_poses(&mut domain, [[0.0; 3], end]);
        for row in flow_rows(&way, [0, 1], true, 0.0, &domain) {
            let value = row.value_at(|variable| if variable == scale { -known } else { 0.0 });
            // By turning within steps of 10 ms and by quantisation the sides are wider than nothing, though not by much.
            assert!(row.sides.inflate(4e-6).contains(value), "scale {true_scale}: {value} {}", row.sides);
            assert!(row.sides.radius() < 1e-3, "{}", row.sides);
        }
    }
}

#[test]
fn what_rows_lose_because_they_are_linear_is_in_their_sides() {
    let heading = |half: f64| [0, 1].map(|frame| (Variable::Pose(frame, 2), half));
    let metres = (Variable::Constant(Constant::FlowMetresPerCount), 2e-7);
    let scale = (Variable::Constant(Constant::GyroScale), 0.2);
    let [first, last] = heading(0.02);
    // What is not exact, by its half width. Metres and headings lose their product, a scale the square of its deviation.
    for vague in [heading(0.1).to_vec(), vec![metres, first, last], vec![scale]] {
        for corner in 0..1_u32 << vague.len() {
            let history = WheelHistory::new(60.0).with_gyro(still()).with_flow(exactly(1e-6));
            let (history, end) = straight_then_turning(history, 0.5, 1.0);
            let way = history.flow_way(0.0, 2.0, Interval::ZERO, &wheels(), &reach()).unwrap();
            let mut domain = exact_constants(1e-6);
            put_poses(&mut domain, [[0.0; 3], end]);
            let mut deviations = BTreeMap::new();
            for (nth, &(variable, half)) in vague.iter().enumerate() {
                let off = if corner >> nth & 1 == 1 { half } else { -half };
                domain.put(variable, Interval::centred(domain.reference(variable) + off, half * (1.0 + 1e-9)));
                deviations.insert(variable, -off);
            }
            for row in flow_rows(&way, [0, 1], true, 0.0, &domain) {
                let value = row.value_at(|variable| deviations.get(&variable).copied().unwrap_or(0.0));
                assert!(row.sides.inflate(4e-6).contains(value), "{vague:?}, {corner}: {value} {}", row.sides);
            }
        }
    }
}

#[test]
fn what_a_lever_arm_loses_because_its_row_is_linear_is_in_its_sides() {
    // The robot drives an arc about the flow sensor, 0.3 m to its left, which stays where it is and counts nothing. Both headings are known to
    // ± 0.2 rad, and true at their ends: to take an arc for its tangent makes 0.3 m · 0.2²/2 = 6 mm.
    let model = crate::robot::FlowModel { position_m: [0.0, 0.3].map(Interval::point), ..exactly(1e-6) };
    let mut history = WheelHistory::new(60.0).with_gyro(still()).with_flow(model);
    history.push_flow(0.0, [0, 0], 0);
    for step in 1..=100_u32 {
        history.push_flow(0.01 * f64::from(step), [0, 0], 0);
        history.push_rate(0.01 * f64::from(step), 1.0);
    }
    let at = |heading_rad: f64| [0.3 * heading_rad.sin(), -0.3 * heading_rad.cos(), heading_rad];
    let way = history.flow_way(0.0, 1.0, Interval::centred(0.0, 0.4), &wheels(), &reach()).unwrap();
    for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let mut domain = exact_constants(1e-6);
        domain.put(Variable::Constant(Constant::FlowPosition(1)), Interval::point(0.3));
        put_poses(&mut domain, [at(0.0), at(1.0)]);
        let off = signs.map(|sign: f64| 0.2 * sign);
        for (frame, off) in off.into_iter().enumerate() {
            let heading = frame as f64 + off;
            domain.put(Variable::Pose(frame, 2), Interval::centred(heading, 0.2 * (1.0 + 1e-9)));
        }
        for row in flow_rows(&way, [0, 1], true, 0.0, &domain) {
            let value = row.value_at(|variable| match variable {
                Variable::Pose(frame, 2) => -off[frame],
                _ => 0.0,
            });
            assert!(row.sides.inflate(4e-6).contains(value), "{signs:?}: {value} {}", row.sides);
            assert!(row.sides.radius() < 0.03, "{}", row.sides);
        }
    }
}

/// A gyroscope without errors.
fn still() -> crate::robot::GyroModel {
    crate::robot::GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::ONE,
        noise_rad_per_s: 0.0,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: f64::INFINITY,
        ..crate::graph::trial::gyro(true)
    }
}

/// A domain with the constants of that flow sensor, and with a gyroscope of scale 1.
fn exact_constants(metres_per_count: f64) -> Domain {
    let mut domain = Domain::default();
    let constants = [
        (Constant::GyroScale, 1.0),
        (Constant::FlowMetresPerCount, metres_per_count),
        (Constant::FlowYaw, 0.0),
        (Constant::FlowPosition(0), 0.0),
        (Constant::FlowPosition(1), 0.0),
    ];
    constants.iter().for_each(|&(one, at)| domain.put(Variable::Constant(one), Interval::point(at)));
    domain
}

#[test]
fn an_error_of_the_place_that_lengthens_one_way_shortens_the_next() {
    // All is exact but the counts of 0.1 mm. The robot drives 100.9 counts along x in 0.1 s, of which 100 are counted, and 99.1 in the next 0.1
    // s, by whose end 200 are counted.
    let still = crate::robot::GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::ONE,
        noise_rad_per_s: 0.0,
        angle_floor_rad: 0.0,
        angle_rad_per_s: 0.0,
        ..crate::graph::trial::gyro(true)
    };
    let mut history = crate::motion::WheelHistory::new(60.0).with_gyro(still).with_flow(exactly(1e-4));
    for step in 0..=20_u32 {
        let counts = if step <= 10 { 10.09 * f64::from(step) } else { 100.9 + 9.91 * f64::from(step - 10) };
        history.push_flow(0.01 * f64::from(step), [(counts + 1e-9).floor() as i64, 0], 0);
        history.push_rate(0.01 * f64::from(step), 0.0);
    }
    let mut domain = exact_constants(1e-4);
    for (frame, x_m) in [0.0, 0.010_09, 0.02].into_iter().enumerate() {
        [x_m, 0.0, 0.0].into_iter().enumerate().for_each(|(axis, at)| {
            domain.put(Variable::Pose(frame, axis), Interval::point(at));
        });
        domain.put(Variable::GyroAngle(frame), Interval::ZERO);
        (0..2).for_each(|axis| domain.put(Variable::FlowPlace(frame, axis), Interval::centred(0.0, 1e-4)));
    }
    for at in 0..2 {
        let span_s = [0.1 * at as f64, 0.1 * (at + 1) as f64];
        let way = history.flow_way(span_s[0], span_s[1], Interval::ZERO, &wheels(), &reach()).unwrap();
        let [along, _] = flow_rows(&way, [at, at + 1], true, 0.0, &domain);
        // The counts at the middle key frame lack 0.9 counts, those at the others none: as errors about the middle of a count, −0.45 and 0.45.
        let value = |middle_counts: f64| {
            along.value_at(|variable| match variable {
                Variable::FlowPlace(1, 0) => 1e-4 * middle_counts,
                Variable::FlowPlace(_, 0) => 0.45e-4,
                _ => 0.0,
            })
        };
        assert!(along.sides.contains(value(-0.45)) && !along.sides.contains(value(0.45)), "{along:?}");
        assert!(along.sides.width() < 1e-5, "{along:?}");
    }
}

#[test]
fn a_bias_of_the_gyroscope_cancels_between_two_known_headings() {
    // An arc of 1 m that turns by 0.1 rad in 2 s, with counts of a micrometre and all else exact but the gyroscope's bias, which is at the end of
    // its interval: the turn that is read is 0.12 rad.
    let biased = crate::robot::GyroModel {
        bias_rad_per_s: Interval::new(-0.01, 0.01),
        scale: Interval::ONE,
        noise_rad_per_s: 0.0,
        angle_floor_rad: f64::INFINITY,
        ..crate::graph::trial::gyro(true)
    };
    let mut history = crate::motion::WheelHistory::new(60.0).with_gyro(biased).with_flow(exactly(1e-6));
    for step in 0..=200_u32 {
        history.push_flow(0.01 * f64::from(step), [5000 * i64::from(step), 0], 0);
        history.push_rate(0.01 * f64::from(step), 0.05 + 0.01);
    }
    let mut domain = exact_constants(1e-6);
    let end = [10.0 * 0.1_f64.sin(), 10.0 * (1.0 - 0.1_f64.cos()), 0.1];
    for (frame, pose) in [[0.0; 3], end].into_iter().enumerate() {
        (0..3).for_each(|axis| domain.put(Variable::Pose(frame, axis), Interval::point(pose[axis])));
        (0..2).for_each(|axis| domain.put(Variable::FlowPlace(frame, axis), Interval::centred(0.0, 1e-6)));
    }
    let way = history.flow_way(0.0, 2.0, Interval::ZERO, &wheels(), &reach()).unwrap();
    for row in flow_rows(&way, [0, 1], true, 0.0, &domain) {
        // Half of the square of 0.02 rad, and what the heading may bend between readings, times 1 m on either side.
        assert!(row.sides.contains(0.0) && row.sides.width() < 0.0012, "{row:?}");
    }
}

#[test]
fn a_straight_way_is_known_to_its_scale_and_two_counts() {
    // 2 s at 0.2 m/s along world x with counts of 0.1 mm: apart from the varying scale, 0.4 % of 0.4 m, and from the error of the place at both
    // ends, less than 0.1 mm is left along the way.
    let mut history = crate::motion::WheelHistory::new(60.0)
        .with_gyro(crate::graph::trial::gyro(true))
        .with_flow(crate::robot::FlowModel { yaw_rad: Interval::ZERO, ..flow() });
    for step in 0..=200_u32 {
        let time_s = 0.01 * f64::from(step);
        history.push_flow(time_s, [(2000.0 * time_s).round() as i64, 0], 0);
        history.push_rate(time_s, 0.001);
    }
    let way = history.flow_way(0.0, 2.0, Interval::ZERO, &wheels(), &reach()).unwrap();
    let scale_m = 0.004 * (0.4 + 200.0 * 1e-4) * 1.01;
    assert!((scale_m - 0.0001..scale_m + 0.0001).contains(&way.error_m[0]), "{way:?}");
    assert!(way.error_m[1] < 0.0004, "{way:?}");
    assert!((way.counts[0] - 4000.0).abs() < 1e-3 && (way.late_counts[0] - 2000.0).abs() < 1e-3, "{way:?}");
}
