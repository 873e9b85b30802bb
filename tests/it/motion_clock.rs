//! Readings whose clock is off: what wheels and gyroscope tell between two stamps, against where the robot was in true time.

use localizer::{
    Interval,
    motion::WheelHistory,
    robot::{GyroModel, Reach, WheelModel},
};

const REACH: Reach = Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 2.0, acceleration_m_per_s2: 1.0 };
const STAMP_ERROR_S: f64 = 0.01;

/// Wheels without any error but that of their clock.
fn wheels(stamp_error_s: f64) -> WheelModel {
    WheelModel {
        radius_m: [Interval::point(0.1); 2],
        track_m: Interval::point(0.4),
        ticks_per_turn: 1e9,
        slip_ratio: 0.0,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 10.0,
        stamp_error_s,
    }
}

/// Path and turn of a robot that gathers speed from rest, on a circle of 1 m: at 0.8 m/s² for a second, and steadily after.
fn driven(time_s: f64) -> [f64; 2] {
    let gathering_s = time_s.clamp(0.0, 1.0);
    let path_m = 0.4 * gathering_s * gathering_s + 0.8 * (time_s - gathering_s).max(0.0);
    [path_m, path_m]
}

/// Where it is: on a circle of radius 1 m about (0, 1).
fn pose(time_s: f64) -> [f64; 3] {
    let turn_rad = driven(time_s)[1];
    [turn_rad.sin(), 1.0 - turn_rad.cos(), turn_rad]
}

/// Pose at the later time in the frame of the earlier one.
fn true_motion(from_s: f64, to_s: f64) -> [f64; 3] {
    let ([x0, y0, heading], [x1, y1, last]) = (pose(from_s), pose(to_s));
    let (sin, cos) = heading.sin_cos();
    [cos * (x1 - x0) + sin * (y1 - y0), cos * (y1 - y0) - sin * (x1 - x0), last - heading]
}

/// Readings of both sensors every 5 ms, whose stamps are all late by as much.
fn history(late_s: f64, stamp_error_s: f64) -> WheelHistory {
    let gyro = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::point(1.0),
        noise_rad_per_s: 0.0,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.005,
        stamps_turn_rad: 2.0 * REACH.turn_rate_rad_per_s * stamp_error_s,
    };
    let mut history = WheelHistory::new(10.0).with_gyro(gyro);
    for reading in -10..500 {
        let time_s = f64::from(reading) * 0.005;
        let ([path_m, turn_rad], [_, before_rad]) = (driven(time_s), driven(time_s - 0.005));
        let ticks = [-0.2, 0.2].map(|arm_m| ((path_m + arm_m * turn_rad) / 0.1 / std::f64::consts::TAU * 1e9) as i64);
        history.push_rate(time_s + late_s, (turn_rad - before_rad) / 0.005);
        history.push(time_s + late_s, ticks);
    }
    history
}

/// By how much the true motion is outside of what is told, at most of all axes.
fn outside(history: &WheelHistory, [from_s, to_s]: [f64; 2], stamp_error_s: f64) -> f64 {
    let told = history.motion(from_s, to_s, &wheels(stamp_error_s), &REACH).expect("inside the history");
    let truth = true_motion(from_s, to_s);
    (0..3).map(|axis| (told[axis].lo() - truth[axis]).max(truth[axis] - told[axis].hi())).fold(0.0, f64::max)
}

#[test]
fn a_clock_that_is_off_within_its_bound_keeps_the_true_motion() {
    for late_s in [-STAMP_ERROR_S, -0.003, 0.0, 0.007, STAMP_ERROR_S] {
        let history = history(late_s, STAMP_ERROR_S);
        for from in (0..200).step_by(7) {
            for to in (from + 1..220).step_by(13) {
                let span_s = [f64::from(from) * 0.01, f64::from(to) * 0.01];
                let off = outside(&history, span_s, STAMP_ERROR_S);
                assert!(off == 0.0, "{late_s} s late, {span_s:?}: outside by {off}");
            }
        }
    }
}

#[test]
fn a_clock_that_is_off_by_more_than_nothing_shows_when_it_is_told_to_be_exact() {
    // From rest to 0.8 m/s: a clock that is 10 ms late tells of 8 mm less.
    let off_m = outside(&history(STAMP_ERROR_S, 0.0), [0.0, 1.5], 0.0);
    assert!(off_m > 0.004, "{off_m}");
}

#[test]
fn readings_of_one_clock_are_off_by_no_more_than_reach_allows_in_its_error() {
    let [exact, off] = [0.0, STAMP_ERROR_S].map(|stamp_error_s| {
        history(0.0, stamp_error_s).motion(0.5, 1.0, &wheels(stamp_error_s), &REACH).expect("inside the history")
    });
    // 2·v·ε = 20 mm and ω·ε·|M| = 0.02 rad · 0.3 m to either side; 2·ω·ε = 0.04 rad.
    let wider = |axis: usize| off[axis].width() - exact[axis].width();
    assert!(wider(0) < 2.0 * 0.027 && wider(1) < 2.0 * 0.027, "{off:?}");
    assert!((wider(2) - 2.0 * 0.04).abs() < 1e-6, "{off:?}");
}
