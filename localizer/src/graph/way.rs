//! Rows of the robot's way from one key frame to the next.
//!
//! With the mid heading β = (θₐ + θ_b)/2, β = β₀ + δ, and the displacement M = P_b − Pₐ,
//!
//! e₀·M = along·cos δ − lateral·sin δ,   l₀·M = lateral·cos δ + along·sin δ,
//!
//! with e₀ and l₀ the unit vectors along β₀ and to the left of it. A wheel's travel T is that of the axle's middle plus or minus half the track times
//! the turn, and the travel of the middle is along + shortening ([`Way`]).

use interval::Interval;

use crate::{
    bounds,
    motion::{GyroTurn, Way},
};

use super::{
    Constant, Domain, Row, Variable,
    row::{axes, cosine_rest, dot, sine_rest},
};

/// The rows of the way from key frame number `from` to number `to`: one for each wheel, one across the way, and those of the gyroscope.
pub fn way_rows(way: &Way, from: usize, to: usize, domain: &Domain) -> Vec<Row> {
    let mut rows = vec![wheel_row(way, 0, [from, to], domain), wheel_row(way, 1, [from, to], domain)];
    rows.push(lateral_row(way, [from, to], domain));
    if let Some(read) = &way.gyro {
        rows.extend(gyro_rows(read, way.span_s, [from, to], domain));
    }
    rows
}

/// The rows of the displacement along world x and y, in values: the mean of both wheels' rows and the row across the way, turned.
pub(super) fn displacement_rows(way: &Way, frames: [usize; 2], domain: &Domain) -> [Row; 2] {
    let wheels = [0, 1].map(|wheel| wheel_row(way, wheel, frames, domain).in_values(domain));
    let lateral = lateral_row(way, frames, domain).in_values(domain);
    let moved = Displacement::new(frames, domain);
    [0, 1].map(|axis| {
        let (along, left) = (moved.along[axis].mid(), moved.left[axis].mid());
        Row::sum(&[(0.5 * along, &wheels[0]), (0.5 * along, &wheels[1]), (left, &lateral)], |_| false, domain)
    })
}

/// What the rows of a displacement have in common.
struct Displacement {
    /// Unit vectors along the reference of the mid heading, and to the left of it.
    along: [Interval; 2],
    left: [Interval; 2],
    /// Displacement between the reference positions.
    at_reference: [Interval; 2],
    /// Possible deviation of the mid heading.
    delta: Interval,
}

impl Displacement {
    fn new([from, to]: [usize; 2], domain: &Domain) -> Displacement {
        let reference = |frame, axis| Interval::point(domain.reference(Variable::Pose(frame, axis)));
        let deviation = |frame| domain.deviation(Variable::Pose(frame, 2));
        let [along, left] = axes((reference(from, 2) + reference(to, 2)) * 0.5);
        Displacement {
            along,
            left,
            at_reference: [0, 1].map(|axis| reference(to, axis) - reference(from, axis)),
            delta: (deviation(from) + deviation(to)) * 0.5,
        }
    }
}

/// Terms of direction·M and of `by_delta` times the deviation of the mid heading.
fn displacement_terms(
    [from, to]: [usize; 2],
    direction: [Interval; 2],
    by_delta: Interval,
) -> Vec<(Variable, Interval)> {
    let mut terms = Vec::new();
    for (axis, side) in direction.into_iter().enumerate() {
        terms.push((Variable::Pose(to, axis), side));
        terms.push((Variable::Pose(from, axis), -side));
    }
    terms.push((Variable::Pose(to, 2), by_delta * 0.5));
    terms.push((Variable::Pose(from, 2), by_delta * 0.5));
    terms
}

/// along ± W·turn/2 − T = −shortening, for the right (+) or the left (−) wheel.
fn wheel_row(way: &Way, wheel: usize, frames: [usize; 2], domain: &Domain) -> Row {
    let moved = Displacement::new(frames, domain);
    let [from, to] = frames;
    let lateral_0 = Interval::point(way.lateral_m.mid());
    let mut terms = displacement_terms(frames, moved.along, lateral_0);
    // along = e₀·M + along·(1 − cos δ) + lateral·sin δ, where all but e₀·M + lateral₀·δ goes to the sides.
    let mut sides = -dot(moved.along, moved.at_reference);
    sides -= way.along_m * cosine_rest(moved.delta);
    sides -= (way.lateral_m - lateral_0) * moved.delta.sin() + lateral_0 * sine_rest(moved.delta);
    sides -= way.shortening_m;

    let sign = if wheel == 0 { -0.5 } else { 0.5 };
    let track = Variable::Constant(Constant::Track);
    let track_0 = Interval::point(domain.reference(track));
    let heading = |frame| Variable::Pose(frame, 2);
    let turn_0 = Interval::point(domain.reference(heading(to))) - domain.reference(heading(from));
    let turn_off = domain.deviation(heading(to)) - domain.deviation(heading(from));
    terms.push((heading(to), track_0 * sign));
    terms.push((heading(from), -track_0 * sign));
    terms.push((track, turn_0 * sign));
    sides -= (track_0 * turn_0 + domain.deviation(track) * turn_off) * sign;

    let per_tick = Variable::Constant(Constant::MetresPerTick(wheel));
    let ticks = Interval::point(way.ticks[wheel]);
    terms.push((per_tick, -ticks));
    sides += ticks * domain.reference(per_tick) + Interval::centred(0.0, way.travel_error_m[wheel]);
    let row = Row::new(domain, &terms, sides).with_part(bounds::WHEELS_SLIP, way.slip_m[wheel]);
    by_wheels_and_gyro(row.with_parts(1.0, &way.shortening_parts_m), way)
}

/// l₀·M − along₀·δ = lateral·cos δ + along·sin δ − along₀·δ.
fn lateral_row(way: &Way, frames: [usize; 2], domain: &Domain) -> Row {
    let moved = Displacement::new(frames, domain);
    let along_0 = Interval::point(way.along_m.mid());
    let terms = displacement_terms(frames, moved.left, -along_0);
    let mut sides = -dot(moved.left, moved.at_reference);
    sides += way.lateral_m * (Interval::point(1.0) - cosine_rest(moved.delta));
    sides += (way.along_m - along_0) * moved.delta.sin() + along_0 * sine_rest(moved.delta);
    by_wheels_and_gyro(Row::new(domain, &terms, sides).with_parts(1.0, &way.lateral_parts_m), way)
}

/// The row with the devices whose readings make a way.
fn by_wheels_and_gyro(row: Row, way: &Way) -> Row {
    let row = row.by_device("wheels");
    if way.gyro.is_some() { row.by_device("gyro") } else { row }
}

/// scale·turn + bias·span is within what the gyroscope read: where the bound `gyro.angle` is declared, with the bias of the whole run and the
/// accumulated angle error at both ends; else with the mean bias of this way and the noise of each reading.
pub(super) fn gyro_rows(read: &GyroTurn, span_s: f64, [from, to]: [usize; 2], domain: &Domain) -> Vec<Row> {
    let (scale, heading) = (Variable::Constant(Constant::GyroScale), |frame| Variable::Pose(frame, 2));
    let scale_0 = Interval::point(domain.reference(scale));
    let turn_0 = Interval::point(domain.reference(heading(to))) - domain.reference(heading(from));
    let turn_off = domain.deviation(heading(to)) - domain.deviation(heading(from));
    let row = |bias: Variable, more: &[(Variable, Interval)], sides: Interval| {
        let mut terms =
            vec![(heading(to), scale_0), (heading(from), -scale_0), (scale, turn_0), (bias, Interval::point(span_s))];
        terms.extend_from_slice(more);
        let at_reference = scale_0 * turn_0 + Interval::point(domain.reference(bias)) * span_s;
        Row::new(domain, &terms, sides - at_reference - domain.deviation(scale) * turn_off)
            .with_part(bounds::REACH_ACCELERATION, read.bend_rad)
            .by_device("gyro")
    };
    let by_noise = |read_rad: Interval| read_rad.radius() - read.bend_rad;
    let run_bias = Variable::Constant(Constant::GyroBias);
    let angle = [from, to].map(Variable::GyroAngle);
    if angle.iter().all(|&at| !domain.value(at).is_empty()) {
        let one = Interval::point(1.0);
        let row = row(run_bias, &[(angle[0], -one), (angle[1], one)], read.summed_rad);
        return vec![row.with_part(bounds::GYRO_ANGLE, by_noise(read.summed_rad))];
    }
    let own_bias = Variable::GyroBias(to);
    let bias = if domain.value(own_bias).is_empty() { run_bias } else { own_bias };
    vec![row(bias, &[], read.by_reading_rad).with_part(bounds::GYRO_NOISE, by_noise(read.by_reading_rad))]
}

#[cfg(test)]
mod remainders;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{
        graph::trial::{Draw, Drive, SLIP, domains, gyro, reach, rounds, wheels},
        motion::WheelHistory,
    };

    #[test]
    fn the_true_way_satisfies_every_row_at_the_corners_of_all_bounds() {
        let mut draw = Draw::new(20_261_124);
        for round in 0..rounds(600) {
            let has_gyro = round % 3 > 0;
            let drive = Drive::short(&mut draw, round % 3 == 2);
            let (from_s, to_s) = (drive.stamps_s[0], drive.stamps_s[2]);
            let way = drive.history(has_gyro).way(from_s, to_s, &wheels(), &reach()).unwrap();
            for _ in 0..domains() {
                let (domain, truth) = drive.domain(&mut draw);
                let rows = way_rows(&way, 0, 2, &domain);
                for (idx, row) in rows.iter().enumerate() {
                    let value = row.value_at(|variable| truth[&variable] - domain.reference(variable));
                    // The true drive is itself integrated in steps, which makes errors of some 10⁻⁸ m.
                    assert!(
                        row.sides.inflate(1e-7).contains(value),
                        "round {round}, row {idx}: {value}, {}",
                        row.sides
                    );
                }
                // The same rows, turned into the directions of the world's axes.
                for (axis, row) in displacement_rows(&way, [0, 2], &domain).iter().enumerate() {
                    let value = row.value_at(|variable| truth[&variable]);
                    assert!(
                        row.sides.inflate(1e-7).contains(value),
                        "round {round}, axis {axis}: {value}, {}",
                        row.sides
                    );
                }
            }
        }
    }

    #[test]
    fn wheels_that_slip_ten_times_as_declared_satisfy_rows_whose_slip_is_ten_times_as_wide() {
        let mut draw = Draw::new(20_261_125);
        let declared = crate::robot::WheelModel {
            slip_ratio: SLIP / 10.0,
            side_slip_ratio: SLIP / 10.0,
            slip_floor_m: wheels().slip_floor_m / 10.0,
            side_slip_floor_m: wheels().side_slip_floor_m / 10.0,
            ..wheels()
        };
        let mut n_violated = 0;
        for _ in 0..300 {
            let drive = Drive::short(&mut draw, true);
            let way = drive.history(true).way(drive.stamps_s[0], drive.stamps_s[2], &declared, &reach()).unwrap();
            let (mut domain, truth) = drive.domain(&mut draw);
            for frame in [0, 2] {
                let heading = Variable::Pose(frame, 2);
                domain.put(heading, Interval::centred(truth[&heading], 1e-3));
            }
            for row in way_rows(&way, 0, 2, &domain) {
                assert!(row.named_half() <= row.sides.radius() * (1.0 + 1e-9), "{row:?}");
                let value = row.value_at(|variable| truth[&variable] - domain.reference(variable));
                let slips = row.parts.iter().filter(|(bound, _)| bound.starts_with("wheels."));
                let slip_m: f64 = slips.map(|(_, half)| half).sum();
                n_violated += usize::from(!row.sides.contains(value));
                // What is of second order in the slip has no part.
                assert!(row.sides.inflate(9.09 * slip_m + 1e-6).contains(value), "{value}: {row:?}");
            }
        }
        // Some rows are violated as they are, so that the parts matter.
        assert!(n_violated > 20, "{n_violated}");
    }

    #[test]
    fn a_straight_way_is_known_to_slip_and_quantisation() {
        // 2 s at 0.2 m/s with two equal wheels and a gyroscope: each wheel's row is hardly wider than slip and quantisation make it.
        let mut history = WheelHistory::new(60.0).with_gyro(gyro(false));
        let per_tick_m = wheels().metres_per_tick(0).mid();
        for step in 0..=200_u32 {
            let ticks = (0.2 * 0.01 * f64::from(step) / per_tick_m).floor() as i64;
            history.push(0.01 * f64::from(step), [ticks; 2]);
            history.push_rate(0.01 * f64::from(step), 0.001);
        }
        let way = history.way(0.0, 2.0, &wheels(), &reach()).unwrap();
        // Ten windows of 0.2 s, a slip ratio of 2 % of 0.4 m, and a count.
        let slip_m = 10.0 * wheels().slip_floor_m + SLIP * (0.4 + per_tick_m) + per_tick_m;
        (0..2).for_each(|wheel| assert!((way.travel_error_m[wheel] - slip_m).abs() < 1e-4, "{way:?}"));
        assert!(way.shortening_m.width() < 0.3 * slip_m, "{way:?}");
        // Across the way: the side slip on either side, and 2 s of the gyroscope's noise and bias, each of which turns half of the way on average by
        // half of the whole error, 0.4 m · (4 + 2) mrad/s · 2 s / 4.
        let side_m = SLIP * (0.4 + 2.0 * per_tick_m) + 10.0 * wheels().side_slip_floor_m;
        let across_m = way.lateral_m.width() / 2.0;
        assert!((side_m + 0.0012..1.15 * (side_m + 0.0012)).contains(&across_m), "{across_m} of {side_m}: {way:?}");
    }
}
