//! What the motion by the wheels allows for within a step: each part alone, in a step of 1 s that is made for it.

use super::*;

/// Wheels 0.4 m apart that roll a micrometre in a tick, so that a count is nothing beside all else, and do not slip.
fn exact() -> WheelModel {
    WheelModel {
        radius_m: [Interval::point(0.05); 2],
        track_m: Interval::point(0.4),
        ticks_per_turn: 0.05e6 * std::f64::consts::TAU,
        slip_ratio: 0.0,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 100.0,
    }
}

/// The motion in a step in which the wheels roll by the same way and the robot is known not to turn on the whole, while each wheel accelerates by at
/// most `acceleration_m_per_s2`.
fn straight(travel_m: f64, acceleration_m_per_s2: f64, wheels: &WheelModel) -> Motion {
    let sample = |time_s: f64, ticks: f64| WheelSample { time_s, ticks: [ticks; 2], ticks_error: 0.0 };
    let mut integral = WheelIntegral::new(sample(0.0, 0.0));
    let known = KnownTurns { steered: None, since_start_rad: Some(Interval::ZERO), in_step_rad: Some(Interval::ZERO) };
    let reach = Reach { speed_m_per_s: 2.0, turn_rate_rad_per_s: 4.0, acceleration_m_per_s2 };
    integral.advance(&sample(1.0, 1e6 * travel_m), known, wheels, &reach);
    integral.motion(wheels)
}

#[test]
fn turning_forth_and_back_moves_the_robot_aside() {
    // Over 1 m the turn rate falls from 0.06 to −0.06 rad/s: the heading is 0.06·t·(1 − t), on average 0.01 rad, which makes 10 mm.
    let motion = straight(1.0, 0.024, &exact());
    assert!(motion[1].contains(0.01) && motion[1].hi() < 0.0151, "{}", motion[1]);
}

#[test]
fn a_robot_that_drives_back_and_forth_while_it_turns_forth_and_back_moves_aside() {
    // From t = −½ s to ½ s the speed goes evenly from −0.12 to 0.12 m/s, and the turn rate changes by 1.2 rad/s², first one way, then the other: the
    // heading is 0.6·t·(½ + t) before 0 and 0.6·t·(½ − t) after it. So each wheel accelerates by 0.24 m/s² ± 0.2 m · 1.2 rad/s², at most by 0.48. The
    // wheels come back to where they began, and the robot, too, but for 2 · ∫ 0.6·t·(½ − t) · 0.24·t dt from 0 to ½ = 1.5 mm to the left.
    let motion = straight(0.0, 0.48, &exact());
    assert!(motion[1].contains(0.0015), "{}", motion[1]);
    // At most 0.48/4 m of the path, and 2.4/8 rad by the greatest turn acceleration, which are not possible at once.
    assert!(motion[1].hi() < 0.0361, "{}", motion[1]);
}

#[test]
fn slip_while_the_robot_turns_forth_and_back_moves_it_aside() {
    // The wheels stand, and the robot slips evenly by 10 mm ahead or to the left, while it turns forth and back by 0.01 rad on average:
    // this makes 0.1 mm across.
    let ahead = straight(0.0, 0.024, &WheelModel { slip_floor_m: 0.01, ..exact() });
    assert!(ahead[1].contains(0.0001) && ahead[1].hi() < 0.0003, "{}", ahead[1]);
    let aside = straight(0.0, 0.024, &WheelModel { side_slip_floor_m: 0.01, ..exact() });
    assert!(aside[0].contains(-0.0001) && aside[0].lo() > -0.0003, "{}", aside[0]);
    // Slip in proportion to the way: 10 mm of 1 m, beside the 10 mm that turning moves the rolled way aside.
    let half_m = |wheels: &WheelModel| straight(1.0, 0.024, wheels)[1].radius();
    let least_m = half_m(&exact());
    assert!(half_m(&WheelModel { slip_ratio: 0.01, ..exact() }) > least_m + 0.0001);
    assert!(straight(1.0, 0.024, &WheelModel { side_slip_ratio: 0.01, ..exact() })[0].radius() > 0.01 * 0.01);
}

#[test]
fn slip_in_a_step_that_is_longer_than_a_window_turns_the_robot_in_each_window() {
    // Five windows of 0.2 s, in each of which the right wheel slips 1 mm ahead and the left one 1 mm back, 0.4 m apart: 10 mm make 25 mrad.
    let wheels = WheelModel { slip_floor_m: 0.001, slip_window_s: 0.2, ..exact() };
    let integral = WheelIntegral::new(WheelSample { time_s: 0.0, ticks: [0.0; 2], ticks_error: 0.0 });
    let turn_rad = integral.step_turn([0.0; 2], 0.0, 1.0, &wheels);
    assert!(turn_rad.contains(0.025) && turn_rad.hi() < 0.025_01, "{turn_rad}");
    // A step within a window slips once.
    assert!(integral.step_turn([0.0; 2], 0.0, 0.2, &wheels).hi() < 0.005_01);
}
