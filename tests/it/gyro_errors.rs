//! Tests of learning the gyroscope's bias and scale together from turns that are known from another source; the true biases, scales and turns are
//! made up by the tests.

use interval::{Interval, contractor::Outcome};
use localizer::{
    motion::{GyroErrors, GyroHistory},
    robot::GyroModel,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SCALE_TOLERANCE: f64 = 0.002;
const BIAS_TOLERANCE_RAD_PER_S: f64 = 0.01;

fn gyro() -> GyroModel {
    GyroModel {
        bias_rad_per_s: Interval::centred(0.0, BIAS_TOLERANCE_RAD_PER_S),
        scale: Interval::centred(1.0, SCALE_TOLERANCE),
        noise_rad_per_s: 0.0005,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.01,
    }
}

#[test]
fn the_bias_shrinks_at_rest_and_between_two_headings() {
    let (bias, scale) = (0.0042, 1.0019);
    for rate in [0.0, 0.3] {
        let mut history = GyroHistory::new(gyro(), 60.0);
        for step in 1..=1000 {
            let noise = 0.00049 * if step % 3 == 0 { 1.0 } else { -1.0 };
            history.push(0.01 * f64::from(step), scale * rate + bias + noise);
        }
        // Heading fixes at the start and at the end bound the robot's true turn to an interval 0.004 rad wide.
        let read = history.sum(0.0, 10.0, 1.0).unwrap();
        let mut errors = GyroErrors::new(&gyro());
        assert_eq!(errors.learn([0.0, 10.0], read, Interval::centred(10.0 * rate, 0.002)), Outcome::Feasible);
        let known = errors.bias_over([10.0, 10.0]);
        assert!(known.contains(bias), "{known:?} at {rate} rad/s");
        // By hand, half of the learnt bias's width is, in rad/s: 0.0005 for the gyroscope's noise, 0.0002 for the turn known from headings, and
        // 0.002·rate for the error of the scale.
        let expected = 2.0 * (0.0005 + 0.0002 * 1.002 + SCALE_TOLERANCE * rate);
        assert!((known.width() - expected).abs() < 1e-5, "{} wide, expected {expected}", known.width());
    }
}

#[test]
fn a_learnt_bias_wanders_and_what_contradicts_it_is_not_learnt() {
    let exact = GyroModel { scale: Interval::point(1.0), bias_wander_rad_per_s2: 1e-5, ..gyro() };
    let mut errors = GyroErrors::new(&exact);
    let still = |errors: &mut GyroErrors, span_s: [f64; 2], bias: [f64; 2]| {
        let lasts_s = span_s[1] - span_s[0];
        errors.learn(span_s, Interval::new(bias[0] * lasts_s, bias[1] * lasts_s), Interval::ZERO)
    };
    assert_eq!(still(&mut errors, [0.0, 10.0], [0.002, 0.006]), Outcome::Feasible);
    assert_eq!(still(&mut errors, [10.0, 20.0], [0.004, 0.005]), Outcome::Feasible);
    let at = |errors: &GyroErrors, stamp_s: f64| errors.bias_over([stamp_s; 2]);
    assert!(at(&errors, 20.0).is_subset_of(Interval::new(0.0039 - 1e-9, 0.0051 + 1e-9)));
    // Since the last learning the bias may have wandered by up to 1e-5 rad/s² for 100 s, so that its interval must be wider by 0.001 rad/s to either
    // side.
    assert!(at(&errors, 120.0).contains(0.0029) && !at(&errors, 120.0).contains(0.0028));
    assert!(matches!(still(&mut errors, [20.0, 21.0], [-0.009, -0.008]), Outcome::Empty(_)));
    // What contradicts it leaves it as it was.
    assert!(at(&errors, 20.0).is_subset_of(Interval::new(0.0039 - 1e-9, 0.0051 + 1e-9)));
}

#[test]
fn what_comes_late_counts_from_when_it_came() {
    let mut errors = GyroErrors::new(&GyroModel { bias_wander_rad_per_s2: 1e-5, ..gyro() });
    let exact = |bias: [f64; 2], lasts_s: f64| Interval::new(bias[0] * lasts_s, bias[1] * lasts_s);
    assert_eq!(errors.learn([10.0, 20.0], exact([0.002, 0.006], 10.0), Interval::ZERO), Outcome::Feasible);
    // The turn over the second time interval, from 0 s to the image stamp of 8 s, becomes known only after that of the first one, from 10 s to 20 s,
    // because the image is evaluated late.
    assert_eq!(errors.learn([0.0, 8.0], exact([0.003, 0.008], 8.0), Interval::ZERO), Outcome::Feasible);
    let known = errors.bias_over([20.0; 2]);
    // By hand: what was learnt from the time interval that begins at 0 s is widened by up to 1e-5·20 rad/s at 20 s, because the bias may wander that
    // far in between.
    assert!(known.contains(0.0029) && !known.contains(0.0027) && known.contains(0.0060), "{known:?}");
}

#[test]
fn laps_of_one_sense_hide_the_scale_in_the_bias_and_the_next_lap_pays_for_neither() {
    let exact = GyroModel { noise_rad_per_s: 0.0, ..gyro() };
    let (bias, scale) = (0.003, 0.9985);
    // The robot drives laps of 40 s, each with a quarter turn in each of four corners, and all turns in the same sense. Headings are known to 2 mrad
    // to either side.
    let lap_rad = std::f64::consts::TAU;
    let read = |turn_rad: f64, lasts_s: f64| Interval::point(scale * turn_rad + bias * lasts_s);
    let mut errors = GyroErrors::new(&exact);
    let known = Interval::centred(0.0, 0.004);
    assert_eq!(
        errors.learn([0.0, 80.0], read(2.0 * lap_rad, 80.0), known + Interval::point(2.0 * lap_rad)),
        Outcome::Feasible
    );
    let next = errors.turn([80.0, 120.0], read(lap_rad, 40.0));
    assert!(next.contains(lap_rad), "{next:?}");
    // By hand: the bias and scale learnt from two laps give the next lap's turn to half of the width to which the turn of two laps was known. The
    // scale, whose error of 0.2 % alone would be 25 mrad a lap, adds nothing.
    assert!(next.width() < 1.05 * 0.5 * known.width(), "{} rad wide", next.width());
    // On a straight of 10 s, a quarter of a lap's time, bias and scale do not compensate each other: the turn's width is 2·0.002·π/2, the error of
    // the scale over a quarter of a lap, plus a quarter of the width for one lap.
    let straight = errors.turn([80.0, 90.0], read(0.0, 10.0));
    let expected = 2.0 * SCALE_TOLERANCE * lap_rad / 4.0 + known.width() / 8.0;
    assert!(straight.contains(0.0), "{straight:?}");
    assert!((straight.width() / expected - 1.0).abs() < 0.02, "{} wide, expected {expected}", straight.width());
}

/// True heading and true sum of gyroscope readings after each second, and the scale. The bias wanders as fast as allowed, or departs from a
/// constant by what the floor and the rate of `gyro.angle` allow.
fn drive(rng: &mut ChaCha8Rng, model: &GyroModel) -> (Vec<[f64; 2]>, f64) {
    let scale = 1.0 + SCALE_TOLERANCE * corner(rng);
    let (wander, floor, rate) = (model.bias_wander_rad_per_s2, model.angle_floor_rad, model.angle_rad_per_s);
    let mut bias = 0.9 * BIAS_TOLERANCE_RAD_PER_S * corner(rng);
    let (constant, slower) = (bias, corner(rng));
    let mut states = vec![[0.0_f64; 2]];
    for second in 1..=300 {
        let turn = [0.0, 0.7, -0.2][rng.random_range(0..3)];
        let [heading, sum] = *states.last().unwrap();
        let next = if floor.is_finite() {
            // The accumulated error is that of a bias that differs from its constant value by the rate of the bound, plus a deviation of up to half
            // of the bound's floor to either side.
            scale * (heading + turn) + (constant + rate * slower) * f64::from(second) + 0.5 * floor * corner(rng)
        } else {
            bias = (bias + wander * corner(rng)).clamp(-BIAS_TOLERANCE_RAD_PER_S, BIAS_TOLERANCE_RAD_PER_S);
            sum + scale * turn + bias
        };
        states.push([heading + turn, next]);
    }
    (states, scale)
}

fn corner(rng: &mut ChaCha8Rng) -> f64 {
    [-1.0, 1.0, rng.random_range(-1.0..1.0)][rng.random_range(0..3)]
}

#[test]
fn biases_and_scales_at_their_corners_and_every_turn_stay_inside() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut widest, mut n_learnt) = (0.0_f64, 0);
    for round in 0..200 {
        let (floor, rate) = if round % 2 == 0 { (0.001, 0.0003) } else { (f64::INFINITY, 0.0) };
        let bias_wander_rad_per_s2 = if round % 4 == 1 { 0.0 } else { 2e-5 };
        let model = GyroModel { angle_floor_rad: floor, angle_rad_per_s: rate, bias_wander_rad_per_s2, ..gyro() };
        let (states, scale) = drive(&mut rng, &model);
        let mut errors = GyroErrors::new(&model);
        for to in 20..=300 {
            let from = to - rng.random_range(1..=to.min(120));
            let [turned, read] = [0, 1].map(|axis| states[to][axis] - states[from][axis]);
            let span_s = [from as f64, to as f64];
            let slack = if floor.is_finite() { floor + rate * (to - from) as f64 } else { 1e-12 };
            let read = Interval::centred(read, slack);
            let turn = errors.turn(span_s, read);
            assert!(turn.contains(turned), "round {round}: {turned} is not in {turn:?} of {span_s:?}");
            if to > 200 {
                widest = widest.max(turn.width() / (to - from) as f64);
            }
            let known = Interval::centred(turned + rng.random_range(-0.005..0.005), 0.005);
            assert_eq!(errors.learn(span_s, read, known), Outcome::Feasible, "round {round}");
            n_learnt += 1;
        }
        assert!(errors.scale().contains(scale), "round {round}: {scale} is not in {:?}", errors.scale());
    }
    assert!(n_learnt > 50_000);
    // If bias and scale were not learnt, a bias of ±0.01 rad/s and a scale error of ±0.002 at 0.7 rad/s would make turns twice as wide as this limit.
    assert!(widest < 0.5 * 2.0 * (BIAS_TOLERANCE_RAD_PER_S + 0.7 * SCALE_TOLERANCE), "{widest} rad/s");
}
