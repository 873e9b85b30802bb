//! Tests of the turn enclosed from gyroscope readings against turns integrated in much finer steps, with bias, scale and noise at the
//! corners of their bounds.

use interval::Interval;
use localizer::{
    motion::{GyroHistory, SumSince, WheelHistory},
    robot::{GyroModel, Reach, WheelModel},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PERIOD_S: f64 = 0.01;
const CHANGE_RAD_PER_S2: f64 = 6.0;

fn model() -> GyroModel {
    GyroModel {
        bias_rad_per_s: Interval::centred(0.0, 0.002),
        scale: Interval::centred(1.0, 0.003),
        noise_rad_per_s: 0.004,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: 0.0,
        period_s: PERIOD_S,
    }
}

fn corner(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<f64>() < 0.5 { [-1.0, 1.0][rng.random_range(0..2)] } else { rng.random_range(-1.0..1.0) }
}

/// Headings every 0.1 ms of a turn whose rate changes as fast as allowed, and the gyroscope readings of that turn.
fn turned(rng: &mut ChaCha8Rng, lasts_s: f64) -> (Vec<f64>, Vec<(f64, f64)>) {
    let (bias, scale) = (0.002 * corner(rng), 1.0 + 0.003 * corner(rng));
    let (mut heading, mut rate, mut bend) = (0.0, rng.random_range(-1.0..1.0), 0.0);
    let mut headings = vec![heading];
    let mut readings = Vec::new();
    for step in 1..=(lasts_s * 1e4) as usize {
        if step % 37 == 1 {
            bend = CHANGE_RAD_PER_S2 * corner(rng);
        }
        heading += (rate + 0.5 * bend * 1e-4) * 1e-4;
        rate += bend * 1e-4;
        headings.push(heading);
        if step % 100 == 0 {
            let mean = (heading - headings[step - 100]) / PERIOD_S;
            readings.push((step as f64 * 1e-4, scale * mean + bias + 0.004 * corner(rng)));
        }
    }
    (headings, readings)
}

#[test]
fn turns_to_one_stamp_after_the_other_are_those_asked_for_one_by_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    for _ in 0..200 {
        let mut history = GyroHistory::new(model(), 10.0);
        let (_, mut readings) = turned(&mut rng, 1.0);
        // The gyroscope's readings have gaps, and some stamps are so close that the periods of two readings overlap, but by less than the overlap at
        // which a reading is refused.
        readings.retain(|_| rng.random_range(0..8) > 0);
        readings.iter_mut().for_each(|(time_s, _)| *time_s -= 4e-6 * rng.random::<f64>());
        readings.iter().for_each(|(time_s, rate)| {
            history.push(*time_s, *rate);
        });
        let from_s = rng.random_range(0.0..0.9);
        let mut turns = history.turns_from(from_s, CHANGE_RAD_PER_S2);
        let mut to_s = from_s;
        while to_s < 1.1 {
            assert_eq!(turns.to(to_s), history.turn(from_s, to_s, CHANGE_RAD_PER_S2), "from {from_s} to {to_s}");
            // The next stamp up to which the turn is computed is at the end of a reading's period, within a period, or several periods later.
            to_s = match rng.random_range(0..3) {
                0 => readings.iter().map(|(time_s, _)| *time_s).find(|time_s| *time_s > to_s).unwrap_or(1.2),
                1 => to_s + 0.003 * rng.random::<f64>(),
                _ => to_s + 0.05 * rng.random::<f64>(),
            };
        }
    }
}

#[test]
fn a_sum_that_is_carried_on_is_the_one_from_the_first_reading_and_a_latecomer_leaves_it_true() {
    let mut rng = ChaCha8Rng::seed_from_u64(23);
    for round in 0..200 {
        let (headings, readings) = turned(&mut rng, 1.0);
        let mut history = GyroHistory::new(model(), 10.0);
        let from = rng.random_range(0..5_000);
        let mut since = SumSince::new(from as f64 * 1e-4);
        // In every second round one reading arrives after the next two.
        let late = (round % 2 == 1).then(|| rng.random_range(60..90));
        for (idx, &(time_s, rate)) in readings.iter().enumerate() {
            if Some(idx) == late {
                continue;
            }
            history.push(time_s, rate);
            if let Some(late) = late.filter(|late| idx == late + 2) {
                history.push(readings[late].0, readings[late].1);
            }
            let to = (100 * (idx + 1)).saturating_sub(rng.random_range(0..150));
            if to <= from {
                continue;
            }
            let (from_s, to_s) = (from as f64 * 1e-4, to as f64 * 1e-4);
            let carried = history.sum_since(&mut since, to_s, CHANGE_RAD_PER_S2).unwrap();
            if late.is_none() {
                assert_eq!(carried, history.sum(from_s, to_s, CHANGE_RAD_PER_S2).unwrap(), "from {from_s} to {to_s}");
            }
            let turned = Interval::point(headings[to] - headings[from]) * model().scale;
            let summed = turned + model().bias_rad_per_s * (to_s - from_s);
            assert!(carried.overlaps(summed), "{carried} has nothing of {summed}, from {from_s} to {to_s}");
        }
    }
}

#[test]
fn the_turn_is_inside_for_any_two_stamps() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut widest, mut n) = (0.0_f64, 0);
    for _ in 0..60 {
        let (headings, readings) = turned(&mut rng, 1.0);
        let mut history = GyroHistory::new(model(), 10.0);
        readings.iter().for_each(|(time_s, rate)| {
            history.push(*time_s, *rate);
        });
        for _ in 0..200 {
            let from = rng.random_range(100..headings.len() - 1);
            // The later stamp may also lie up to half a period beyond the last gyroscope reading.
            let to = rng.random_range(from..headings.len());
            let (from_s, to_s) = (from as f64 * 1e-4, to as f64 * 1e-4);
            let turn = history.turn(from_s, to_s, CHANGE_RAD_PER_S2).unwrap();
            let truth = headings[to] - headings[from];
            assert!(turn.contains(truth), "{truth} is not in {turn:?} from {from_s} to {to_s}");
            widest = widest.max(turn.width());
            n += 1;
        }
    }
    // By hand, the turn over a second is at most this wide: 2·(0.002 + 0.004) rad for the gyroscope's bias and noise, 0.6 % of the turned angle for
    // its scale, and twice the deviation of a chord from a bent curve.
    assert!(widest < 0.012 + 0.006 * 4.0 + 0.001, "{widest} rad after {n} turns");
}

#[test]
fn a_missing_reading_is_bridged_by_what_the_rate_can_have_become() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..100 {
        let (headings, readings) = turned(&mut rng, 0.4);
        let lost = rng.random_range(5..30);
        let mut history = GyroHistory::new(model(), 10.0);
        let kept = readings.iter().enumerate().filter(|(idx, _)| !(lost..lost + 3).contains(idx));
        kept.for_each(|(_, (time_s, rate))| {
            history.push(*time_s, *rate);
        });
        for _ in 0..50 {
            // The turn between any two stamps must be contained, whether these are on both sides of the gap in the gyroscope's readings, within the
            // gap, or after the last reading.
            let from = rng.random_range(100..4000);
            let to = rng.random_range(from..=4000);
            let turn = history.turn(from as f64 * 1e-4, to as f64 * 1e-4, CHANGE_RAD_PER_S2).unwrap();
            let truth = headings[to] - headings[from];
            assert!(
                turn.contains(truth),
                "{truth} is not in {turn:?} from step {from} to {to}, {lost} and two more lost"
            );
        }
    }
}

#[test]
fn far_from_a_reading_the_rate_can_have_changed_for_as_long() {
    // The true turn at a steady 5 rad/s² from rest is 5/2·t² rad at time t. Gyroscope readings over periods of 0.1 s are its mean rates: 0.25, 0.75
    // and 1.25 rad/s.
    let exact = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::point(1.0),
        noise_rad_per_s: 0.0,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.1,
    };
    let mut history = GyroHistory::new(exact, 10.0);
    [(0.1, 0.25), (0.2, 0.75), (0.3, 1.25)].into_iter().for_each(|(end_s, rate)| {
        history.push(end_s, rate);
    });
    for (from_s, to_s) in [(0.38, 0.39), (0.36, 0.37), (0.395, 0.399), (0.3, 0.4), (0.22, 0.24)] {
        let truth = 2.5 * (to_s * to_s - from_s * from_s);
        let turn = history.turn(from_s, to_s, 5.0).unwrap();
        assert!(turn.contains(truth), "{truth} is not in {turn:?} from {from_s} to {to_s}");
    }
    // Two gyroscope readings of 0 rad/s are four seconds apart. 1.5 s after the first one the rate may have risen to 1.5 rad/s, in either direction,
    // at 1 rad/s², and still be back at 0 for the second one.
    let mut sparse = GyroHistory::new(GyroModel { period_s: 0.01, ..exact }, 10.0);
    [(1.0, 0.0), (5.0, 0.0)].into_iter().for_each(|(end_s, rate)| {
        sparse.push(end_s, rate);
    });
    let turn = sparse.turn(2.4, 2.6, 1.0).unwrap();
    assert!(turn.contains(0.29) && turn.contains(-0.29), "{turn:?}");
}

#[test]
fn a_pushed_robot_may_turn_about_within_a_period() {
    // Half a period at 1.6 rad/s and half at −1.6 rad/s are read as 0, but the first half turned the robot by 8 mrad.
    let reach = Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 1.0 };
    let exact =
        GyroModel { noise_rad_per_s: 0.0, bias_rad_per_s: Interval::ZERO, scale: Interval::point(1.0), ..model() };
    let mut history = WheelHistory::new(10.0).with_gyro(exact);
    [0.01, 0.02, 0.03].into_iter().for_each(|end_s| {
        history.push_rate(end_s, 0.0);
    });
    let turn = history.reach_motion(0.01, 0.015, &reach)[2];
    assert!(turn.contains(0.008) && turn.contains(-0.008), "{turn:?}");
    // Over whole periods of the gyroscope, the mean rate that it read determines the turn, whatever the robot did within the periods.
    let turn = history.reach_motion(0.01, 0.03, &reach)[2];
    assert!(turn.contains(0.0) && turn.width() < 1e-9, "{turn:?}");
}

#[test]
fn a_duplicate_and_a_latecomer_are_dropped_and_silence_is_no_answer() {
    let mut history = GyroHistory::new(model(), 10.0);
    assert!(history.turn(0.0, 0.01, CHANGE_RAD_PER_S2).is_none());
    history.push(0.01, 0.5);
    history.push(0.02, 0.5);
    let before = history.turn(0.0, 0.02, CHANGE_RAD_PER_S2).unwrap();
    history.push(0.02, 9.0);
    history.push(0.015, 9.0);
    assert_eq!(history.turn(0.0, 0.02, CHANGE_RAD_PER_S2).unwrap(), before);
    // The turn is that of 0.02 s at 0.5 rad/s, the rate of the first two readings: the duplicate and the late reading with 9 rad/s were dropped.
    assert!(before.contains(0.01) && before.width() < 0.0005, "{before:?}");
}

/// Motion, from the wheels and the gyroscope together, of a robot whose wheels roll straight on for a second and may slip by 2 % each, while the
/// gyroscope reads the given rate.
fn rolled(gyro_rad_per_s: f64) -> Option<localizer::motion::Motion> {
    let wheels = WheelModel {
        radius_m: [Interval::centred(0.1, 0.0001); 2],
        track_m: Interval::centred(0.33, 0.001),
        ticks_per_turn: 19_150.0,
        slip_ratio: 0.02,
        slip_floor_m: 0.0001,
        side_slip_ratio: 0.003,
        side_slip_floor_m: 0.00005,
        slip_window_s: 0.2,
    };
    let reach = Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 1.0 };
    let mut history = WheelHistory::new(10.0).with_gyro(model());
    for step in 0..=100 {
        let time_s = f64::from(step) * 0.01;
        let ticks = (0.3 * time_s / 0.1 / std::f64::consts::TAU * 19_150.0) as i64;
        history.push_rate(time_s, gyro_rad_per_s);
        history.push(time_s, [ticks; 2]);
    }
    history.motion(0.1, 0.9, &wheels, &reach)
}

#[test]
fn wheels_and_gyroscope_are_intersected() {
    let motion = rolled(0.0).unwrap();
    // By hand, the turn is known to ±29 mrad from the wheels alone: 0.24 m with 2 % of slip on each side, over a track of 0.33 m. From the gyroscope
    // it is known to ±(0.002 + 0.004)·0.8 s, and the box must be that narrow.
    assert!(motion[2].contains(0.0) && motion[2].width() < 2.0 * 0.0051, "{:?}", motion[2]);
    assert!(motion[0].contains(0.24) && motion[0].width() < 0.013, "{:?}", motion[0]);
    // As the gyroscope narrows the turn, the sideways motion is bounded more narrowly too: by 0.24 m times half of the turn's width, plus what side
    // slip allows.
    assert!(motion[1].contains(0.0) && motion[1].width() < 0.24 * 0.0104 + 0.0035, "{:?}", motion[1]);
}

#[test]
fn a_gyroscope_that_contradicts_the_wheels_leaves_nothing() {
    assert!(rolled(0.3).is_none_or(|motion| motion.is_empty()));
}

#[test]
fn noise_that_is_bounded_over_spans_widens_the_turn_by_floor_and_rate_alone() {
    let (floor_rad, rate_rad_per_s) = (0.0004, 0.0001);
    let model = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::point(1.0),
        angle_floor_rad: floor_rad,
        angle_rad_per_s: rate_rad_per_s,
        ..model()
    };
    // The robot is at rest. The sum of its gyroscope's noise rises to the floor of the declared bound as fast as the bound of one reading allows,
    // goes on at the bound's rate, and comes back.
    let wanted =
        |time_s: f64| if time_s < 5.0 { floor_rad + rate_rad_per_s * time_s } else { rate_rad_per_s * (10.0 - time_s) };
    let (mut sum_rad, mut sums, mut history) = (0.0, vec![0.0], GyroHistory::new(model, 20.0));
    for step in 1..=1000 {
        let time_s = f64::from(step) * PERIOD_S;
        let noise = ((wanted(time_s) - sum_rad) / PERIOD_S).clamp(-0.004, 0.004);
        sum_rad += noise * PERIOD_S;
        sums.push(sum_rad);
        history.push(time_s, noise);
    }
    for from in (0..1000).step_by(7) {
        for to in (from..=1000).step_by(13) {
            let (from_s, to_s) = (f64::from(from) * PERIOD_S, f64::from(to) * PERIOD_S);
            let turn = history.turn(from_s, to_s, 0.0).unwrap();
            assert!(turn.contains(0.0), "{turn:?} from {from_s} to {to_s}");
        }
    }
    // By hand, half of the turn's width is the floor of the bound on accumulated noise, plus 10 s times its rate, plus 0.004·0.01 rad for a part of a
    // reading at either end. With the bound on single readings alone, the width would be 0.08 rad.
    let width = history.turn(0.0, 10.0, 0.0).unwrap().width();
    let expected = 2.0 * (floor_rad + 10.0 * rate_rad_per_s + 2.0 * 0.004 * PERIOD_S);
    assert!((width - expected).abs() < 1e-9, "{width}, expected {expected}");
    assert!(sums.iter().any(|sum| *sum > floor_rad));
}

#[test]
fn a_gap_in_the_readings_costs_the_floor_once_more() {
    let model = GyroModel { noise_rad_per_s: 0.1, angle_floor_rad: 0.0004, angle_rad_per_s: 0.0, ..model() };
    let width = |lost: std::ops::Range<usize>| {
        let mut history = GyroHistory::new(model, 20.0);
        (1..=500).filter(|step| !lost.contains(step)).for_each(|step| {
            history.push(step as f64 * PERIOD_S, 0.0);
        });
        history.turn(0.0, 5.0, 0.0).unwrap().width()
    };
    // A missing reading costs the floor of the bound on accumulated noise once more. In addition the robot may have turned during that reading at the
    // rate read beside it: 0.1 rad/s of noise and 0.002 rad/s of bias for 0.01 s, to both sides.
    let (whole, gap) = (width(0..0), width(200..201));
    let beside = 2.0 * (0.1 + 0.002) * PERIOD_S / 0.997;
    let more = 2.0 * 0.0004 + beside;
    assert!(gap > whole + 0.97 * more && gap < whole + 1.02 * more, "{gap} after {whole}, expected {more} more");
}
