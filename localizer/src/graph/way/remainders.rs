//! What the rows of a way by the wheels and the gyroscope lose because they are linear: each part alone, in a way that is made for it.

use super::*;

/// A way with the given components along and across the mid heading, by wheels that roll 1 mm in a tick and do not slip. There is no gyroscope.
fn way(along_m: f64, lateral_m: f64) -> Way {
    Way {
        span_s: 1.0,
        ticks: [1000.0 * along_m; 2],
        travel_error_m: [0.0; 2],
        slip_m: [0.0; 2],
        shortening_parts_m: Vec::new(),
        lateral_parts_m: Vec::new(),
        along_m: Interval::point(along_m),
        shortening_m: Interval::ZERO,
        lateral_m: Interval::point(lateral_m),
        gyro: None,
    }
}

/// The quantities of a way from the origin to a place, with headings and wheels whose reference values are 0 and 1 mm for each tick, 0.4 m apart:
/// all of them exactly known, those that are given up to some half width, by which their true values are beside their reference values.
fn domain_to(end_m: [f64; 2], off: &[(Variable, f64)]) -> Domain {
    let mut domain = Domain::default();
    let constants = [
        (Constant::MetresPerTick(0), 1e-3),
        (Constant::MetresPerTick(1), 1e-3),
        (Constant::Track, 0.4),
        (Constant::GyroScale, 1.0),
        (Constant::GyroBias, 0.0),
    ];
    constants.iter().for_each(|&(one, at)| domain.put(Variable::Constant(one), Interval::point(at)));
    for (frame, pose) in [[0.0; 3], [end_m[0], end_m[1], 0.0]].into_iter().enumerate() {
        (0..3).for_each(|axis| domain.put(Variable::Pose(frame, axis), Interval::point(pose[axis])));
    }
    for &(variable, off) in off {
        domain.put(variable, Interval::centred(domain.reference(variable), off.abs()));
    }
    domain
}

/// Checks that all rows of a way to a place hold.
fn assert_holds(way: &Way, end_m: [f64; 2], off: &[(Variable, f64)]) {
    let domain = domain_to(end_m, off);
    for (idx, row) in way_rows(way, 0, 1, &domain).iter().enumerate() {
        let of = |variable| off.iter().find(|(other, _)| *other == variable).map_or(0.0, |(_, off)| *off);
        let value = row.value_at(of);
        assert!(row.sides.inflate(1e-12).contains(value), "row {idx}: {value} {}", row.sides);
    }
}

/// Both headings, off by the same angle.
fn headings(off: f64) -> [(Variable, f64); 2] {
    [0, 1].map(|frame| (Variable::Pose(frame, 2), off))
}

/// Displacement of a way whose mid heading is turned by an angle.
fn turned(along_m: f64, lateral_m: f64, angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [along_m * cos - lateral_m * sin, along_m * sin + lateral_m * cos]
}

#[test]
fn what_a_turn_of_the_mid_heading_shortens_is_in_the_sides() {
    // Turned by 0.1 rad, a displacement is shorter along its former direction by 1 − cos 0.1 = 0.004996 of its length, of which 0.1²/2 = 0.005 is
    // in the sides: in the rows of the wheels of 1 m along the way, in the row across the way of 0.5 m across it.
    assert_holds(&way(1.0, 0.0), turned(1.0, 0.0, 0.1), &headings(0.1));
    assert_holds(&way(0.0, 0.5), turned(0.0, 0.5, 0.1), &headings(0.1));
}

#[test]
fn what_the_sine_of_a_turn_departs_from_the_turn_is_in_the_sides() {
    // Turned by 0.3 rad, a displacement of 0.5 m moves across its former direction by 0.5 m · sin 0.3, which is 2.24 mm less than 0.5 m · 0.3; and
    // 0.5 m · 0.3³/6 are 2.25 mm. The displacement is along the way in the row across it, and across the way in the rows of the wheels.
    assert_holds(&way(0.5, 0.0), turned(0.5, 0.0, 0.3), &headings(0.3));
    assert_holds(&way(0.0, 0.5), turned(0.0, 0.5, 0.3), &headings(0.3));
}

#[test]
fn what_a_turn_moves_of_a_displacement_that_is_not_known_is_in_the_sides() {
    // A component of 0 ± 0.1 m, truly 0.1 m, moves across by 0.1 m · sin 0.1, while the row takes that of the middle, which is nothing.
    let unknown = Interval::centred(0.0, 0.1);
    assert_holds(&Way { lateral_m: unknown, ..way(0.0, 0.0) }, turned(0.0, 0.1, 0.1), &headings(0.1));
    assert_holds(&Way { along_m: unknown, ..way(0.1, 0.0) }, turned(0.1, 0.0, 0.1), &headings(0.1));
}

#[test]
fn the_product_of_the_deviations_of_turn_and_track_is_in_the_sides_of_the_wheels_rows() {
    // The robot turns on the spot by 0.2 rad about the reference 0, on a track of 0.5 m of 0.4 ± 0.1: each wheel rolls 0.5 m · 0.2/2 = 50 mm, of
    // which the row takes 0.4 m · 0.2/2 = 40 mm.
    let off = [(Variable::Pose(0, 2), -0.1), (Variable::Pose(1, 2), 0.1), (Variable::Constant(Constant::Track), 0.1)];
    assert_holds(&Way { ticks: [-50.0, 50.0], ..way(0.0, 0.0) }, [0.0; 2], &off);
}

#[test]
fn the_product_of_the_deviations_of_turn_and_scale_is_in_the_sides_of_the_gyroscopes_row() {
    // A turn of 0.2 rad about the reference 0 by a gyroscope of scale 1.1 of 1 ± 0.1 is read as 0.22 rad, of which the row takes 0.2 rad.
    let off =
        [(Variable::Pose(0, 2), -0.1), (Variable::Pose(1, 2), 0.1), (Variable::Constant(Constant::GyroScale), 0.1)];
    let read_rad = Interval::point(1.1 * 0.2);
    let gyro = GyroTurn { by_reading_rad: read_rad, summed_rad: read_rad, bend_rad: 0.0 };
    // The wheels, on a track of 0.4 m, roll 0.4 m · 0.2/2 = 40 mm.
    assert_holds(&Way { ticks: [-40.0, 40.0], gyro: Some(gyro), ..way(0.0, 0.0) }, [0.0; 2], &off);
}

#[test]
fn the_error_of_the_travel_and_the_shortening_are_in_the_sides_of_the_wheels_rows() {
    // 1 m by the ticks, truly 1.001 m or 0.999 m.
    for along_m in [1.001, 0.999] {
        let slipped = Way { ticks: [1000.0; 2], travel_error_m: [0.001; 2], ..way(along_m, 0.0) };
        assert_holds(&slipped, [along_m, 0.0], &[]);
    }
    // A path of 1 m that brings the robot 0.998 m ahead.
    let bent = Way { ticks: [1000.0; 2], shortening_m: Interval::new(0.0, 0.002), ..way(0.998, 0.0) };
    assert_holds(&bent, [0.998, 0.0], &[]);
}
