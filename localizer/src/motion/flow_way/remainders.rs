//! What a way by the flow sensor allows for beside its counts: each part alone, in a step of 1 s that is made for it.

use super::*;
use crate::{
    graph::trial::{gyro, wheels},
    robot::GyroModel,
};

/// A flow sensor at the robot's origin that counts millimetres, of which nothing is lost by whole counts.
fn exact() -> FlowModel {
    FlowModel {
        position_m: [Interval::ZERO; 2],
        metres_per_count: Interval::point(1e-3),
        scale_change: 0.0,
        yaw_rad: Interval::ZERO,
        quantisation_counts: 0.0,
        back_and_forth_m: 0.0,
        period_s: 1.0,
    }
}

/// The sums before the first step of a way of 1 s, along world x, that turns by an angle, of a robot that never changes its velocities.
fn begin(model: &FlowModel, turn_rad: f64) -> Sum<'_> {
    Sum {
        model,
        change_rad_per_s2: 0.0,
        acceleration_m_per_s2: 0.0,
        lasts_s: 1.0,
        turn_rad,
        about_rad: 0.0,
        margin_rad: 0.0,
        end: node(1.0, turn_rad),
        way: FlowWay {
            span_s: 1.0,
            gyro: GyroTurn { by_reading_rad: Interval::ZERO, summed_rad: Interval::ZERO, bend_rad: 0.0 },
            middle_scale: 1.0,
            turn_rad,
            counts: [0.0; 2],
            late_counts: [0.0; 2],
            turned_counts: [0.0; 2],
            bulge_rad: 0.0,
            heading_error_rad: 0.0,
            path_m: 0.0,
            error_m: [0.0; 2],
            scale_error_m: [0.0; 2],
            noise_error_m: [0.0; 2],
            end_error_m: [0.0; 2],
            end_readings_s: [[0.0; 2], [1.0; 2]],
        },
    }
}

/// A turn by the gyroscope up to a stamp, without errors.
fn node(lasts_s: f64, turn_rad: f64) -> ProfileStep {
    ProfileStep { lasts_s, turn_rad, ..ProfileStep::default() }
}

/// The way of one step with the given counts, after which the sums end.
fn way_of(mut sum: Sum, counts: [f64; 2], nodes: &[ProfileStep]) -> FlowWay {
    let step = FlowStep {
        from_s: 0.0,
        until_s: 1.0,
        from: [0.0; 2],
        to: counts,
        readings_s: [0.0, 1.0],
        cut_m: [0.0; 2],
        excess_m: 0.0,
    };
    sum.add(&step, nodes);
    sum.way
}

/// Checks that a vector is within the errors of a way, but for rounding.
fn assert_within(off_m: [f64; 2], way: &FlowWay) {
    (0..2).for_each(|axis| assert!(off_m[axis].abs() <= way.error_m[axis] + 1e-12, "{off_m:?}: {way:?}"));
}

#[test]
fn turning_within_a_step_in_which_the_speed_changes_moves_the_place_aside() {
    // In a step of 1 s the heading goes evenly from 0 to 0.2 rad, and the speed from 0 to 1.2 m/s. About the mean heading 0.1 rad, with h = 0.1, ∫
    // (0.6 + 1.2 τ)·(cos 2hτ, sin 2hτ) dτ from −1/2 to 1/2 is (0.6·sin h/h, 1.2·(sin h − h·cos h)/(2h²)) = (599 mm, 20 mm), for 600 counts of 1 mm.
    let model = exact();
    let sum = Sum { acceleration_m_per_s2: 1.2, ..begin(&model, 0.2) };
    let way = way_of(sum, [600.0, 0.0], &[node(0.0, 0.0), node(0.5, 0.1), node(1.0, 0.2)]);
    let (sin, cos) = 0.1_f64.sin_cos();
    let off_m = [0.6 * sin / 0.1 - 0.6, 1.2 * (sin - 0.1 * cos) / 0.02];
    assert_within([cos * off_m[0] - sin * off_m[1], sin * off_m[0] + cos * off_m[1]], &way);
    // At most ½·1.2 m/s²·1 s² times the mean 0.05 rad, and half of 0.1² of the path.
    assert!(way.error_m[1] < 0.6 * 0.05 + 0.003 + 1e-6, "{way:?}");
}

#[test]
fn a_heading_that_departs_from_the_chord_between_two_stamps_moves_the_place_aside() {
    // The turn rate falls from 0.06 to −0.06 rad/s within 1 s: the heading is 0.06·t·(1 − t), on average 0.01 rad, which makes 10 mm of 1 m. Along
    // the way half of the mean square is lost, 0.06²/30/2 = 0.06 mm. At most 0.12/8 = 0.015 rad are allowed for.
    let model = exact();
    let sum = Sum { change_rad_per_s2: 0.12, ..begin(&model, 0.0) };
    let way = way_of(sum, [1000.0, 0.0], &[node(0.0, 0.0), node(1.0, 0.0)]);
    assert_within([0.06 * 0.06 / 60.0, 0.01], &way);
    assert!(way.error_m[1] < 0.015 * 1.02, "{way:?}");
    assert!(way.heading_error_rad >= 0.015, "{way:?}");
}

#[test]
fn a_scale_that_varies_lengthens_the_way() {
    // 1000 counts are 1 m/(1 − 0.01) at one end of the scale, and are taken for 1 m/(1 − 0.01²).
    let model = FlowModel { scale_change: 0.01, ..exact() };
    let way = way_of(begin(&model, 0.0), [1000.0, 0.0], &[node(0.0, 0.0), node(1.0, 0.0)]);
    let taken_m = 1.0 / (1.0 - 0.01 * 0.01);
    assert_within([1.0 / 0.99 - taken_m, 0.0], &way);
    assert_within([1.0 / 1.01 - taken_m, 0.0], &way);
    assert!(way.error_m[0] < 0.010_01 && way.error_m[1] < 1e-12, "{way:?}");
}

#[test]
fn an_error_of_the_heading_moves_the_place_aside() {
    // All along 1 m the heading is off by 10 mrad, which is bounded at every instant.
    let model = exact();
    let floor = |node: ProfileStep| ProfileStep { floor_rad: 0.01, ..node };
    let sum = Sum { end: floor(node(1.0, 0.0)), ..begin(&model, 0.0) };
    let way = way_of(sum, [1000.0, 0.0], &[floor(node(0.0, 0.0)), floor(node(1.0, 0.0))]);
    // What is lost along the way, half of the square, is left to the rows, which are told of the error.
    assert_within([0.0, 0.01_f64.sin()], &way);
    assert!(way.heading_error_rad >= 0.01 && way.error_m[1] < 0.010_01, "{way:?}");
}

#[test]
fn an_error_of_the_heading_that_grows_is_greatest_in_the_middle_between_two_known_headings() {
    // The error grows by 10 mrad in the first half of a way of 1 m, and falls by as much in the second: on average it is 5 mrad.
    let model = exact();
    let grown = |node: ProfileStep| ProfileStep { grows_rad: 0.02 * node.lasts_s, ..node };
    let sum = Sum { end: grown(node(1.0, 0.0)), ..begin(&model, 0.0) };
    let way = way_of(sum, [1000.0, 0.0], &[0.0, 0.5, 1.0].map(|lasts_s| grown(node(lasts_s, 0.0))));
    assert_within([0.0, 0.005], &way);
    assert!((way.heading_error_rad - 0.01).abs() < 1e-12, "{way:?}");
}

#[test]
fn errors_along_and_across_the_way_turn_with_a_heading_that_is_not_known() {
    // The robot truly drives 1 m at 0.1 rad from world x, of which the heading is known to 0 ± 0.1 rad. A scale that varies by 1 % lengthens its
    // way along that direction, and errors of the heading of 10 mrad move the place across it.
    let ahead = [0.1_f64.cos(), 0.1_f64.sin()];
    let model = FlowModel { scale_change: 0.01, ..exact() };
    let sum = Sum { margin_rad: 0.1, ..begin(&model, 0.0) };
    let way = way_of(sum, [1000.0, 0.0], &[node(0.0, 0.0), node(1.0, 0.0)]);
    let longer_m = 1.0 / 0.99 - 1.0 / (1.0 - 0.01 * 0.01);
    assert_within(ahead.map(|side| longer_m * side), &way);

    let model = exact();
    let floor = |node: ProfileStep| ProfileStep { floor_rad: 0.01, ..node };
    let sum = Sum { margin_rad: 0.1, end: floor(node(1.0, 0.0)), ..begin(&model, 0.0) };
    let way = way_of(sum, [1000.0, 0.0], &[floor(node(0.0, 0.0)), floor(node(1.0, 0.0))]);
    assert_within([-0.01_f64.sin() * ahead[1], 0.01_f64.sin() * ahead[0]], &way);
}

#[test]
fn an_error_of_the_heading_while_the_robot_turns_within_a_step_moves_the_place_along_its_way() {
    // In a step of 1 m at an even speed the heading goes from −10 to 10 mrad. It is off by −50 mrad in the first half and by 50 mrad in the second:
    // at ∓5 mrad on average this moves the place back by 50 mrad · 5 mrad · 1 m = 0.25 mm, besides half of the squares of both angles.
    let model = exact();
    let floor = |node: ProfileStep| ProfileStep { floor_rad: 0.05, ..node };
    let sum = Sum { about_rad: -0.01, end: floor(node(1.0, 0.02)), ..begin(&model, 0.02) };
    let way = way_of(sum, [1000.0, 0.0], &[floor(node(0.0, 0.0)), floor(node(1.0, 0.02))]);
    assert_within([-0.00025, 0.0], &way);
    assert!(way.error_m[0] < 0.0006, "{way:?}");
}

#[test]
fn what_whole_counts_lose_turns_with_the_robot() {
    // The robot turns on the spot by 1 rad, half a count of 1 mm behind what is read, forward and to the left. In the world this error turns from
    // (0.5, 0.5) mm to 0.5 mm · (cos 1 − sin 1, sin 1 + cos 1) = (−0.15, 0.69) mm, though nothing is counted.
    let model = FlowModel { quantisation_counts: 1.0, ..exact() };
    let way = way_of(begin(&model, 1.0), [0.0; 2], &[node(0.0, 0.0), node(1.0, 1.0)]);
    let (sin, cos) = 1.0_f64.sin_cos();
    assert_within([0.0005 * (cos - sin - 1.0), 0.0005 * (sin + cos - 1.0)], &way);
    assert!(way.error_m[0] < 0.0009, "{way:?}");
}

#[test]
fn whole_counts_of_both_axes_add_up_at_45_degrees() {
    // Counts of 0.1 mm. Forward the robot goes 100.99 counts, of which 100 are read; to the right, 100.99, too, from −0.01 to −101 of a count, of
    // which 100 are read. Seen from a direction of 45°, 0.99·√2 = 1.4 counts are missing, of 1/√2 at most at either end.
    let model = FlowModel { metres_per_count: Interval::point(1e-4), quantisation_counts: 1.0, ..exact() };
    let mut flow = FlowHistory::new(model, 60.0);
    flow.push(0.0, [0, -1], 0);
    flow.push(1.0, [100, -101], 0);
    let still = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::ONE,
        noise_rad_per_s: 0.0,
        period_s: 1.0,
        ..gyro(false)
    };
    let mut turns = GyroHistory::new(still, 60.0);
    turns.push(1.0, 0.0);
    let reach = Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 1.0, acceleration_m_per_s2: 0.0 };
    let heading = Interval::point(std::f64::consts::FRAC_PI_4);
    let way = flow.way([0.0, 1.0], heading, &turns, &wheels(), &reach).unwrap();
    let missing_m = 0.99 * 1e-4 * std::f64::consts::SQRT_2;
    let allowed_m = way.end_error_m[0] + way.end_error_m[1] + way.error_m[0];
    assert!((missing_m..1.02 * missing_m).contains(&allowed_m), "{allowed_m} for {missing_m}: {way:?}");
}
