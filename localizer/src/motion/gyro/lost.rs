//! Tests of turns over readings that were lost, by a robot that rests, whose gyroscope's errors add up to the constant part of `gyro.angle` before the
//! gap and once more after it. In the gap they took as much back.

use super::*;

/// Constant part of the bound `gyro.angle`.
const FLOOR_RAD: f64 = 0.003;
const NOISE_RAD_PER_S: f64 = 0.1;
const PERIOD_S: f64 = 0.001;
/// The turn rate hardly changes.
const CHANGE_RAD_PER_S2: f64 = 1e-9;

/// The gyroscope after readings of 0.03 s with the greatest error, a gap of 0.03 s, and as many readings with that error again.
fn with_lost_readings() -> GyroHistory {
    let model = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::point(1.0),
        noise_rad_per_s: NOISE_RAD_PER_S,
        angle_floor_rad: FLOOR_RAD,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: 0.0,
        period_s: PERIOD_S,
    };
    let mut history = GyroHistory::new(model, 10.0);
    for step in (1..=30).chain(61..=90) {
        history.push(PERIOD_S * f64::from(step), NOISE_RAD_PER_S);
    }
    history
}

/// The part of the readings' sum that errors u, bounded at every instant, may have to explain: of a robot that has not turned.
fn summed_rad(history: &GyroHistory, [from_s, to_s]: [f64; 2]) -> Interval {
    history.turn_read(from_s, to_s, CHANGE_RAD_PER_S2).unwrap().summed_rad
}

#[test]
fn what_lost_readings_took_back_may_come_again_after_them() {
    let history = with_lost_readings();
    // By hand: both stretches of readings add up 3 mrad, and the gap as much by the rate of the reading beside it. The errors at both ends of the span
    // differ by 3 mrad at most, so that the rest has to be allowed for.
    let summed = summed_rad(&history, [0.0, 0.09]);
    assert!((summed.mid() - 0.009).abs() < 1e-6 && summed.lo() <= FLOOR_RAD, "{summed}");
    // The errors of each stretch by itself are within the bound.
    let first = summed_rad(&history, [0.0, 0.03]);
    assert!(first.contains(FLOOR_RAD) && first.radius() < 0.3e-3, "{first}");
}

#[test]
fn a_stamp_among_lost_readings_parts_no_errors_that_may_be() {
    let history = with_lost_readings();
    for stamp_s in [0.0305, 0.035, 0.045, 0.055, 0.0595] {
        // The errors at the stamp are in both sums, with either sign.
        let summed = summed_rad(&history, [0.0, stamp_s]) + summed_rad(&history, [stamp_s, 0.09]);
        assert!(summed.lo() <= FLOOR_RAD, "{stamp_s} s: {summed}");
    }
}
