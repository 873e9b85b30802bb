//! What the sides of a way allow for beside the readings: each part alone, for readings that are made for it.

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

/// A robot whose wheels never change their speeds between two readings.
const STEADY: Reach = Reach { speed_m_per_s: 2.0, turn_rate_rad_per_s: 4.0, acceleration_m_per_s2: 0.0 };

/// The sides of a way of steps of 1 s, each given by its travel, its turn by the gyroscope, and the greatest error of that turn. Besides, the turn
/// between any two readings is off by at most `error_rad`.
fn sides(steps: &[(f64, f64, f64)], error_rad: f64, wheels: &WheelModel, reach: &Reach) -> Sides {
    let mut samples = vec![WheelSample { time_s: 0.0, ticks: [0.0; 2], ticks_error: 0.0 }];
    let mut heading_rad = vec![0.0];
    for (step, &(travel_m, turn_rad, _)) in steps.iter().enumerate() {
        let WheelSample { time_s, ticks: [left, right], .. } = samples[step];
        let ticks = [left + 1e6 * (travel_m - 0.2 * turn_rad), right + 1e6 * (travel_m + 0.2 * turn_rad)];
        samples.push(WheelSample { time_s: time_s + 1.0, ticks, ticks_error: 0.0 });
        heading_rad.push(heading_rad[step] + turn_rad);
    }
    let mut integral = WheelIntegral::new(samples[0]);
    samples[1..].iter().for_each(|sample| integral.advance(sample, KnownTurns::default(), wheels, reach));
    let profile = Profile {
        heading_rad,
        step_error_rad: steps.iter().map(|step| step.2).collect(),
        error_rad,
        most_error_rad: f64::INFINITY,
        bound: bounds::GYRO_NOISE,
    };
    Sides::along(&samples, &profile, &integral, wheels, reach)
}

#[test]
fn half_of_the_square_of_the_headings_error_shortens_a_way() {
    // On a straight way of 1 m the robot truly turns by 0.1 rad at once, and back at the end: 1 − cos 0.1 = 4.996 mm of at most 0.1²/2 = 5 mm.
    let shortening_m = sides(&[(1.0, 0.0, 0.0)], 0.1, &exact(), &STEADY).shortening_m;
    assert!(shortening_m.contains(1.0 - 0.1_f64.cos()) && shortening_m.hi() < 0.005_01, "{shortening_m}");
}

#[test]
fn an_error_of_the_turn_in_the_middle_of_a_way_shortens_it() {
    // Half a metre, a turn by 1 rad, and half a metre: on both sides of the mid heading by 0.5 rad. The turn is truly 1.02 rad, so that the way is
    // shorter by cos 0.5 − cos 0.51 = 4.84 mm: sin 0.5 times 0.01, and 0.01²/2 = 0.05 mm. The error is that of the turn's step, or that between any
    // two readings.
    for (step_rad, error_rad) in [(0.02, 0.0), (0.0, 0.01)] {
        let steps = [(0.5, 0.0, 0.0), (0.0, 1.0, step_rad), (0.5, 0.0, 0.0)];
        let shortening_m = sides(&steps, error_rad, &exact(), &STEADY).shortening_m;
        assert!(shortening_m.contains(1.0 - 0.51_f64.cos()), "{shortening_m}");
        assert!(shortening_m.hi() < 1.0 - 0.5_f64.cos() + 0.004_87, "{shortening_m}");
    }
}

#[test]
fn an_error_of_the_turn_at_the_begin_of_a_way_moves_it_aside() {
    // A way of 1 m before which the robot truly turns by 0.02 rad: by 0.01 rad beside the mid heading, which makes 10 mm.
    for (step_rad, error_rad) in [(0.02, 0.0), (0.0, 0.01)] {
        let lateral_m = sides(&[(0.0, 0.0, step_rad), (1.0, 0.0, 0.0)], error_rad, &exact(), &STEADY).lateral_m;
        assert!(lateral_m.contains(0.01_f64.sin()) && lateral_m.hi() < 0.010_06, "{lateral_m}");
    }
}

#[test]
fn turning_forth_and_back_within_a_step_moves_a_way_aside() {
    // In a step of 1 s and 1 m the turn rate falls from 0.06 to −0.06 rad/s, as an acceleration of 0.024 m/s² of the wheels 0.4 m apart allows: the
    // heading is 0.06·t·(1 − t), on average 0.01 rad, which makes 10 mm. At most 0.12/8 rad of 1.006 m are allowed for.
    let reach = Reach { acceleration_m_per_s2: 0.024, ..STEADY };
    let lateral_m = sides(&[(1.0, 0.0, 0.0)], 0.0, &exact(), &reach).lateral_m;
    assert!(lateral_m.contains(0.01) && lateral_m.hi() < 0.0151, "{lateral_m}");
}

#[test]
fn driving_back_and_forth_and_turning_forth_and_back_within_a_step_moves_a_way_aside() {
    // From t = −½ s to ½ s the speed goes evenly from −0.12 to 0.12 m/s, and the heading is 0.6·t·(½ + t) before 0 and 0.6·t·(½ − t) after it. The
    // wheels accelerate by at most 0.48 m/s² and come back to where they began, the robot 2 · ∫ 0.6·t·(½ − t) · 0.24·t dt from 0 to ½ = 1.5 mm to the
    // left of it.
    let reach = Reach { acceleration_m_per_s2: 0.48, ..STEADY };
    let lateral_m = sides(&[(0.0, 0.0, 0.0)], 0.0, &exact(), &reach).lateral_m;
    assert!(lateral_m.contains(0.0015), "{lateral_m}");
}

#[test]
fn the_chord_of_a_long_arc_is_within_the_sides() {
    // An arc of 1 m that turns by 1 rad: its chord is sin 0.5/0.5 = 0.958851 m, by the series up to the square 0.958333 m.
    let shortening_m = sides(&[(1.0, 1.0, 0.0)], 0.0, &exact(), &STEADY).shortening_m;
    assert!(shortening_m.contains(1.0 - 0.5_f64.sin() / 0.5) && shortening_m.width() < 0.0011, "{shortening_m}");
}

#[test]
fn an_error_of_the_turn_in_an_arc_of_a_single_step_shortens_it() {
    // An arc of 1 m that turns by 1 rad by the readings and truly by 1.02 rad: the chord is sin 0.51/0.51 = 0.957210 m, which is 1.64 mm shorter than
    // sin 0.5/0.5. Both ends of the arc have the same distance across the mid heading, and its middle is 0.12 m aside.
    for (step_rad, error_rad) in [(0.02, 0.0), (0.0, 0.02)] {
        let shortening_m = sides(&[(1.0, 1.0, step_rad)], error_rad, &exact(), &STEADY).shortening_m;
        assert!(shortening_m.contains(1.0 - 0.51_f64.sin() / 0.51), "{shortening_m}");
        assert!(shortening_m.hi() < 1.0 - 0.5_f64.sin() / 0.5 + 0.0065, "{shortening_m}");
    }
    // The same arc from 118.6° to 61.4° on the right of the mid heading, after which the robot turns by half a turn: it moves to the right by its
    // chord.
    let half_turn_rad = std::f64::consts::PI;
    for (step_rad, error_rad) in [(0.02, 0.0), (0.0, 0.02)] {
        let lateral_m =
            sides(&[(1.0, 1.0, step_rad), (0.0, half_turn_rad, 0.0)], error_rad, &exact(), &STEADY).lateral_m;
        assert!(lateral_m.contains(-0.51_f64.sin() / 0.51), "{lateral_m}");
    }
}

#[test]
fn slip_before_and_after_a_turn_moves_a_way_aside() {
    // Half a metre, a turn by 0.2 rad, and half a metre: on both sides of the mid heading by 0.1 rad. The robot slips back by 10 mm in the first
    // half and ahead by 10 mm in the second, so that 2 · 10 mm · sin 0.1 go to the left.
    let slipping = WheelModel { slip_floor_m: 0.01, ..exact() };
    let steps = [(0.5, 0.0, 0.0), (0.0, 0.2, 0.0), (0.5, 0.0, 0.0)];
    let lateral_m = sides(&steps, 0.0, &slipping, &STEADY).lateral_m;
    let aside_m = 0.02 * 0.1_f64.sin();
    assert!(lateral_m.contains(aside_m) && lateral_m.hi() < 1.6 * aside_m, "{lateral_m}");
}

#[test]
fn slip_beside_the_mid_heading_shortens_a_way() {
    // Three parts of a way, at −0.5 rad, 0 and 0.5 rad from the mid heading. The robot slips by 10 mm ahead in the first, back in the second, and
    // ahead again in the last one: of the 20 mm at ± 0.5 rad, 1 − cos 0.5 is lost. Slip to the other sides lengthens the way.
    let slipping = WheelModel { slip_floor_m: 0.01, ..exact() };
    let steps = [(0.3, 0.0, 0.0), (0.0, 0.5, 0.0), (0.4, 0.0, 0.0), (0.0, 0.5, 0.0), (0.3, 0.0, 0.0)];
    let shortening_m = sides(&steps, 0.0, &slipping, &STEADY).shortening_m;
    let share = 1.0 - 0.5_f64.cos();
    for slip_m in [0.02, -0.02] {
        assert!(shortening_m.contains((0.6 + slip_m) * share), "{shortening_m}");
    }
    // At most 10 mm times 1 − cos 0.5 and the turning, 1 rad.
    assert!(shortening_m.hi() < 0.6 * share + 0.01 * (share + 1.0) + 1e-5, "{shortening_m}");
}

#[test]
fn side_slip_before_and_after_a_turn_shortens_a_way() {
    // Half a metre, a turn by 1 rad, and half a metre: on both sides of the mid heading by 0.5 rad. The robot slips by 10 mm to the right in the
    // first half, and to the left in the second, so that 2 · 10 mm · sin 0.5 go back.
    let slipping = WheelModel { side_slip_floor_m: 0.01, ..exact() };
    let steps = [(0.5, 0.0, 0.0), (0.0, 1.0, 0.0), (0.5, 0.0, 0.0)];
    let shortening_m = sides(&steps, 0.0, &slipping, &STEADY).shortening_m;
    let back_m = 0.02 * 0.5_f64.sin();
    let straight_m = 1.0 - 0.5_f64.cos();
    assert!(shortening_m.contains(straight_m + back_m), "{shortening_m}");
    assert!(shortening_m.hi() < straight_m + 1.6 * back_m, "{shortening_m}");
}

#[test]
fn side_slip_that_changes_while_the_robot_turns_adds_up() {
    // The robot turns on the spot by 240°. It slips by 10 mm to its right at the begin, to its left at the mid heading, and to its right at the
    // end: seen from the mid heading 5 mm, 10 mm and 5 mm, all to the left.
    let slipping = WheelModel { side_slip_floor_m: 0.01, ..exact() };
    let turn_rad = 2.0 / 3.0 * std::f64::consts::PI;
    let steps = [(0.0, 0.0, 0.0), (0.0, turn_rad, 0.0), (0.0, 0.0, 0.0), (0.0, turn_rad, 0.0), (0.0, 0.0, 0.0)];
    let lateral_m = sides(&steps, 0.0, &slipping, &STEADY).lateral_m;
    assert!(lateral_m.contains(0.02) && lateral_m.hi() < 0.01 * (1.0 + 2.0 * turn_rad) + 1e-4, "{lateral_m}");
}
