//! What the rows of a way by the flow sensor lose because they are linear: each part alone, in a way that is made for it.

use super::*;
use crate::motion::GyroTurn;

/// A way of 1 m straight ahead, of whose readings nothing is lost: 1000 counts of 1 mm, all of them at half of the time.
fn straight() -> FlowWay {
    FlowWay {
        span_s: 1.0,
        gyro: GyroTurn { by_reading_rad: Interval::ZERO, summed_rad: Interval::ZERO, bend_rad: 0.0 },
        middle_scale: 1.0,
        turn_rad: 0.0,
        counts: [1000.0, 0.0],
        late_counts: [500.0, 0.0],
        turned_counts: [0.0; 2],
        bulge_rad: 0.0,
        heading_error_rad: 0.0,
        path_m: 1.0,
        error_m: [0.0; 2],
        scale_error_m: [0.0; 2],
        noise_error_m: [0.0; 2],
        end_error_m: [0.0; 2],
        end_readings_s: [[0.0; 2], [1.0; 2]],
    }
}

/// The quantities of a way from the origin, heading along x, to a place: all of them exactly known, those that are given up to some half width, by
/// which their true values are above their reference values.
fn domain_to(end_m: [f64; 2], off: &[(Variable, f64)]) -> Domain {
    let mut domain = Domain::default();
    let constants = [
        (Constant::GyroScale, 1.0),
        (Constant::FlowMetresPerCount, 1e-3),
        (Constant::FlowYaw, 0.0),
        (Constant::FlowPosition(0), 0.0),
        (Constant::FlowPosition(1), 0.0),
    ];
    constants.iter().for_each(|&(one, at)| domain.put(Variable::Constant(one), Interval::point(at)));
    for (frame, pose) in [[0.0; 3], [end_m[0], end_m[1], 0.0]].into_iter().enumerate() {
        (0..3).for_each(|axis| domain.put(Variable::Pose(frame, axis), Interval::point(pose[axis])));
        (0..2).for_each(|axis| domain.put(Variable::FlowPlace(frame, axis), Interval::ZERO));
    }
    for &(variable, half) in off {
        let reference = if domain.value(variable).is_empty() { 0.0 } else { domain.reference(variable) };
        domain.put(variable, Interval::centred(reference, half.abs()));
    }
    domain
}

/// Checks that both rows of a way to a place hold, and that what is lost is not much greater than it must be.
fn assert_holds(way: &FlowWay, end_m: [f64; 2], off: &[(Variable, f64)], most_m: f64) {
    let domain = domain_to(end_m, off);
    for (axis, row) in flow_rows(way, [0, 1], true, 0.0, &domain).iter().enumerate() {
        let of = |variable| off.iter().find(|(other, _)| *other == variable).map_or(0.0, |(_, off)| *off);
        let value = row.value_at(of);
        assert!(row.sides.inflate(1e-12).contains(value), "{off:?}, axis {axis}: {value} {}", row.sides);
        assert!(row.sides.radius() <= most_m, "{off:?}, axis {axis}: {}", row.sides);
    }
}

#[test]
fn half_of_the_square_of_all_that_may_turn_a_way_is_in_the_sides() {
    // Whatever turns the way of 1 m by 0.1 rad shortens it along x by 1 − cos 0.1 = 4.996 mm, where 0.1²/2 are 5 mm.
    let (sin, cos) = 0.1_f64.sin_cos();
    let headings = [0, 1].map(|frame| (Variable::Pose(frame, 2), 0.1));
    let angles = [0, 1].map(|frame| (Variable::GyroAngle(frame), 0.1));
    let yaw = [(Variable::Constant(Constant::FlowYaw), 0.1)];
    for off in [&headings[..], &angles[..], &yaw[..]] {
        assert_holds(&straight(), [cos, sin], off, 0.005_01);
    }
    // Noise of the gyroscope that turns the way: what it displaces across the way, 0.1 m, is among the errors of the way.
    let noisy = FlowWay { heading_error_rad: 0.1, error_m: [0.0, 0.1], ..straight() };
    assert_holds(&noisy, [cos, sin], &[], 0.105_01);
}

#[test]
fn what_the_quotient_by_the_gyroscopes_scale_is_not_linear_is_in_the_sides() {
    // The gyroscope, whose scale is 1 ± 0.2, tells at half of the time a heading that is 20 mrad beyond a uniform turn. The true scale is 0.8, and
    // the heading truly 20/0.8 = 25 mrad, while the row takes 1 − (0.8 − 1) = 1.2 times 20 mrad: 1 mrad is lost, which makes 1 mm. The square of
    // all turns makes 13 µm.
    let (sin, cos) = 0.02_f64.sin_cos();
    let turned = FlowWay {
        counts: [1000.0 * cos, 1000.0 * sin],
        late_counts: [500.0 * cos, 500.0 * sin],
        turned_counts: [20.0 * cos, 20.0 * sin],
        bulge_rad: 0.02,
        ..straight()
    };
    let end_m = [0.025_f64.cos(), 0.025_f64.sin()];
    assert_holds(&turned, end_m, &[(Variable::Constant(Constant::GyroScale), -0.2)], 0.001_02);
}

#[test]
fn the_product_of_an_accumulated_angle_error_with_the_gyroscopes_scale_is_in_the_sides() {
    // At both key frames the accumulated angle error is 10 mrad, and the scale 0.8 of 1 ± 0.2: the heading by the gyroscope is off by 12.5 mrad,
    // and by the row by 10 mrad, so that 2.5 mrad are lost, which make 2.5 mm. The square of all turns makes 0.08 mm. What is added is the sum of
    // what either angle error may lose, though only a weighted mean of both can come.
    let angles = [0, 1].map(|frame| (Variable::GyroAngle(frame), 0.01));
    let off = [angles[0], angles[1], (Variable::Constant(Constant::GyroScale), -0.2)];
    assert_holds(&straight(), [0.0125_f64.cos(), 0.0125_f64.sin()], &off, 0.006_4);
}

#[test]
fn the_errors_of_a_way_and_that_of_a_place_which_no_other_way_shares_are_in_the_sides() {
    let way = FlowWay { error_m: [0.01, 0.02], ..straight() };
    assert_holds(&way, [1.01, -0.02], &[], 0.020_01);
    // The place at the first key frame is 3 mm behind by the counts, along x and along y, and in no other row.
    let way = FlowWay { end_error_m: [0.003, 0.0], ..straight() };
    let domain = domain_to([1.003, 0.003], &[]);
    for row in flow_rows(&way, [0, 1], false, 0.0, &domain) {
        assert!(row.sides.inflate(1e-12).contains(0.0) && row.sides.radius() < 0.003_01, "{}", row.sides);
    }
}
