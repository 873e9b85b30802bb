//! Tests of the flow sensor's motion against motion that is integrated in much finer steps, and of slip that is certain because wheels and flow
//! sensor contradict each other.

use interval::Interval;
use localizer::{
    motion::{Agreement, FlowHistory, FlowIntegral, GyroHistory, Motion, agree},
    robot::{FlowModel, GyroModel, Reach, WheelModel},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const COUNTS_PER_M: f64 = 20_000.0;

fn model() -> FlowModel {
    FlowModel {
        position_m: [Interval::centred(-0.06, 0.0005), Interval::centred(0.03, 0.0005)],
        metres_per_count: Interval::centred(1.0 / COUNTS_PER_M, 0.001 / COUNTS_PER_M),
        scale_change: 0.002,
        yaw_rad: Interval::centred(0.0, 0.003),
        quantisation_counts: 1.0,
        back_and_forth_m: 0.000_05,
        period_s: 0.01,
    }
}

/// True motion of a body that drives, drifts sideways and turns, and the counts of a flow sensor (summed travel in its own frame) whose errors are at
/// the limits of their bounds.
fn drive(rng: &mut ChaCha8Rng, steps: usize) -> ([f64; 3], FlowIntegral) {
    let model = model();
    let mut side = || [-1.0, 1.0][rng.random_range(0..2)];
    let arm = model.position_m.map(|at| at.mid() + 0.99 * at.radius() * side());
    let per_m = COUNTS_PER_M * (1.0 - 0.0009 * side()) * (1.0 - 0.0019 * side());
    let yaw = 0.0029 * side();
    let (mut forward, mut left, mut rate) = (0.25, 0.0, 0.0);
    let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut seen, mut counted) = ([0.0_f64; 2], [0_i64; 2]);
    let mut integral = FlowIntegral::new();
    for step in 0..steps {
        if step % 20 == 0 {
            (forward, left) = (rng.random_range(-0.3..0.3), rng.random_range(-0.05..0.05));
            rate = rng.random_range(-1.5..1.5);
        }
        for _ in 0..20 {
            let (middle, dt) = (heading + rate * 0.00025, 0.0005);
            x += (forward * middle.cos() - left * middle.sin()) * dt;
            y += (forward * middle.sin() + left * middle.cos()) * dt;
            heading += rate * dt;
            // The robot's turning moves the flow sensor at the velocity ω × a, with a the lever arm.
            let speed = [forward - rate * arm[1], left + rate * arm[0]];
            seen[0] += (speed[0] * yaw.cos() + speed[1] * yaw.sin()) * dt;
            seen[1] += (speed[1] * yaw.cos() - speed[0] * yaw.sin()) * dt;
        }
        let counts = seen.map(|travel_m| (travel_m * per_m).floor() as i64);
        let new = [(counts[0] - counted[0]) as f64, (counts[1] - counted[1]) as f64];
        counted = counts;
        integral.advance(new, Interval::centred(heading, 0.0005), rate.abs() * 0.01, model.back_and_forth_m, &model);
    }
    ([x, y, heading], integral)
}

#[test]
fn a_drive_that_drifts_sideways_stays_in_the_flow_sensors_box() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut widest_m = 0.0_f64;
    for _ in 0..300 {
        let steps = rng.random_range(20..100);
        let (truth, integral) = drive(&mut rng, steps);
        let motion = integral.motion(0.0, &model());
        assert!(motion.contains(&truth), "{truth:?} is not in {motion:?}");
        widest_m = widest_m.max(motion.width(0)).max(motion.width(1));
    }
    assert!(widest_m < 0.01, "a second of driving is {widest_m} m wide");
}

#[test]
fn the_lever_arm_is_no_travel_when_the_robot_spins_on_the_spot() {
    let flow = FlowModel { yaw_rad: Interval::ZERO, ..model() };
    let mut integral = FlowIntegral::new();
    // The robot turns by 1 rad in 100 steps: the sensor, 0.06 m behind and 0.03 m left of the axle, travels −0.03 m and −0.06 m in its own frame.
    for step in 1..=100_i64 {
        let counts = [-600 * step / 100 + 600 * (step - 1) / 100, -1200 * step / 100 + 1200 * (step - 1) / 100];
        integral.advance(counts.map(|count| count as f64), Interval::point(0.01 * step as f64), 0.01, 0.0, &flow);
    }
    let motion = integral.motion(0.0, &flow);
    assert!(motion.contains(&[0.0, 0.0, 1.0]), "{motion:?}");
    assert!(motion.width(0) < 0.005 && motion.width(1) < 0.005, "{motion:?}");
}

/// Chooses the change of the flow sensor's scale, as a share from −1 to 1, at an instant at which the sensor moves by the given travel along world
/// x and y.
type Adversary<'a> = &'a dyn Fn([f64; 2]) -> f64;

/// True motion and the flow sensor's box for a body that drives at `forward_m_per_s` and turns at `rate_rad_per_s` for `steps` periods. The
/// sensor's scale is `calibration` times 1 plus the share of the declared change that `adversary` chooses every half millisecond.
fn flipped(
    [forward_m_per_s, rate_rad_per_s]: [f64; 2],
    steps: usize,
    calibration: f64,
    adversary: Adversary,
    model: &FlowModel,
) -> ([f64; 3], Motion) {
    let arm_m = model.position_m.map(Interval::mid);
    let (mut pose, mut seen, mut counted, dt) = ([0.0_f64; 3], [0.3_f64, 0.8], [0_i64; 2], 0.0005);
    let mut integral = FlowIntegral::new();
    for _ in 0..steps {
        for _ in 0..20 {
            let (sin, cos) = (pose[2] + 0.5 * rate_rad_per_s * dt).sin_cos();
            let travel_m = [forward_m_per_s - rate_rad_per_s * arm_m[1], rate_rad_per_s * arm_m[0]].map(|v| v * dt);
            let in_world_m = [cos * travel_m[0] - sin * travel_m[1], sin * travel_m[0] + cos * travel_m[1]];
            let scale = calibration * (1.0 + model.scale_change * adversary(in_world_m));
            (0..2).for_each(|axis| seen[axis] += travel_m[axis] * COUNTS_PER_M * scale);
            pose[0] += forward_m_per_s * cos * dt;
            pose[1] += forward_m_per_s * sin * dt;
            pose[2] += rate_rad_per_s * dt;
        }
        let counts = seen.map(|counts| counts.floor() as i64);
        let new = [0, 1].map(|axis| (counts[axis] - counted[axis]) as f64);
        counted = counts;
        integral.advance(new, Interval::point(pose[2]), rate_rad_per_s.abs() * 0.01, 0.0, model);
    }
    (pose, integral.motion(0.0, model))
}

#[test]
fn a_scale_that_flips_at_its_bounds_keeps_the_truth_in_a_box_as_narrow_as_the_harm_it_does() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for scale_change in [0.002, 0.05, 0.2] {
        for drive in 0..60_u32 {
            // In half of the drives the robot turns on the spot, so that the flow sensor travels along one of its axes; in the other half it drives
            // curves. Each drive has up to two turns.
            let (is_curve, arm_m) = (drive % 2 == 1, 0.18);
            let position_m = [-arm_m, if is_curve { 0.09 } else { 0.0 }].map(Interval::point);
            let model = FlowModel { position_m, yaw_rad: Interval::ZERO, scale_change, ..model() };
            let rate_rad_per_s = rng.random_range(0.5..2.0);
            let speeds = [if is_curve { rng.random_range(-0.3..0.3) } else { 0.0 }, rate_rad_per_s];
            let steps = rng.random_range(50..600);
            let calibration = 1.0 + 0.00099 * [-1.0, 1.0][rng.random_range(0..2)];
            // The flow sensor's scale changes within its bound as an adversary chooses. Four adversaries always shift the counted travel to one side,
            // in either direction along world x and world y; the fifth is random.
            let coin = std::cell::RefCell::new(ChaCha8Rng::seed_from_u64(u64::from(drive)));
            let adversaries: [Adversary; 5] = [
                &|way: [f64; 2]| way[0].signum(),
                &|way: [f64; 2]| -way[0].signum(),
                &|way: [f64; 2]| way[1].signum(),
                &|way: [f64; 2]| -way[1].signum(),
                &|_| coin.borrow_mut().random_range(-1.0..1.0),
            ];
            let runs = adversaries.map(|adversary| flipped(speeds, steps, calibration, adversary, &model));
            for (truth, motion) in &runs {
                assert!(motion.contains(truth), "{truth:?} is not in {motion:?}: {speeds:?}, {steps} steps");
            }
            // The travel counted under two opposite adversaries differs, for the same motion, by an amount that no enclosure can resolve.
            for axis in if is_curve { 0..0 } else { 0..2 } {
                let harm_m = (runs[2 * axis].1[axis].mid() - runs[2 * axis + 1].1[axis].mid()).abs();
                let widest_m = runs.iter().map(|(_, motion)| motion.width(axis)).fold(0.0, f64::max);
                // Besides the harm that the adversaries do, the box for the motion may be wider by the sensor's calibration error, by single counts
                // at both ends and in every step, and by taking the heading at the middle of each step.
                let step_rad = 0.01 * rate_rad_per_s;
                let per_step_m = 2.0e-4 * scale_change + 1.3 * step_rad * (step_rad * arm_m + 1.0e-4);
                let besides_m = 0.004 + per_step_m * steps as f64;
                assert!(widest_m < harm_m * (1.0 + scale_change) + besides_m, "{widest_m} m of {harm_m} m");
            }
        }
    }
}

#[test]
fn a_robot_that_goes_there_and_back_while_readings_are_lost_has_gone_the_whole_way() {
    let (mut model, reach) =
        (model(), Reach { speed_m_per_s: 0.5, turn_rate_rad_per_s: 0.1, acceleration_m_per_s2: 1.0 });
    (model.scale_change, model.position_m) = (0.2, [Interval::ZERO; 2]);
    // The robot moves forward for 0.2 s, accelerating and braking at 1 m/s², and back for as long. Within the flow sensor's bound on its scale more
    // counts are read on the way forward than on the way back. All readings are lost except those at both ends of the motion.
    let ahead_m = 2.0 * 0.5 * 0.1 * 0.1;
    let counts = (ahead_m * COUNTS_PER_M * 1.2) as i64 - (ahead_m * COUNTS_PER_M * 0.8) as i64;
    let mut history = FlowHistory::new(model, 10.0);
    [(0.0, 0), (0.4, counts)].into_iter().for_each(|(time_s, ahead)| {
        history.push(time_s, [ahead, 0], 0);
    });
    let gyro = gyro_told(40, |_| 0.0, 0.0);
    let motion = history.motion([0.0, 0.4], Some(&gyro), &wheels(), &reach).unwrap();
    assert!(motion.contains(&[0.0; 3]), "{motion:?}");
}

#[test]
fn no_motion_is_told_to_an_earlier_stamp() {
    let reach = Reach { speed_m_per_s: 0.5, turn_rate_rad_per_s: 1.0, acceleration_m_per_s2: 1.0 };
    let mut history = FlowHistory::new(model(), 10.0);
    (0..=20).for_each(|step| {
        history.push(0.01 * f64::from(step), [0, 0], 0);
    });
    let gyro = gyro_told(20, |_| 0.0, 0.0);
    assert!(history.motion([0.1, 0.05], Some(&gyro), &wheels(), &reach).is_none());
}

#[test]
fn wheels_that_spin_on_the_spot_are_dropped_by_a_certificate() {
    let box_of =
        |forward: f64| Motion::from([Interval::centred(forward, 0.002), Interval::centred(0.0, 0.002), Interval::ZERO]);
    let (rolled, seen) = (box_of(0.100), box_of(0.090));
    assert_eq!(agree(&rolled, Some(&seen)), Agreement::SlipCertified(seen));
    let Agreement::Both(both) = agree(&rolled, Some(&box_of(0.099))) else { panic!("no slip is certain here") };
    assert!(both[0].is_subset_of(Interval::new(0.0979, 0.1011)));
    assert_eq!(agree(&rolled, None), Agreement::Both(rolled));
}

/// Gyroscope history for headings given as a function of time, with one reading in each of `n_readings` periods of 10 ms, and with `noise_rad_per_s`
/// as the bound on the noise.
fn gyro_told(n_readings: u32, heading_rad: impl Fn(f64) -> f64, noise_rad_per_s: f64) -> GyroHistory {
    let (period_s, scale, bias_rad_per_s) = (0.01, Interval::point(1.0), Interval::ZERO);
    let (angle_floor_rad, angle_rad_per_s, bias_wander_rad_per_s2) = (f64::INFINITY, 0.0, 0.0);
    let model = GyroModel {
        bias_rad_per_s,
        scale,
        noise_rad_per_s,
        angle_floor_rad,
        angle_rad_per_s,
        bias_wander_rad_per_s2,
        period_s,
    };
    let mut gyro = GyroHistory::new(model, 10.0);
    for end_s in (1..=n_readings).map(|n| f64::from(n) * period_s) {
        gyro.push(end_s, (heading_rad(end_s) - heading_rad(end_s - period_s)) / period_s);
    }
    gyro
}

/// Wheel model that the flow sensor's history needs: no wheel is read in these tests, and the track only determines how fast turn rates can change.
fn wheels() -> WheelModel {
    WheelModel {
        radius_m: [Interval::point(0.035); 2],
        track_m: Interval::point(0.23),
        ticks_per_turn: 720.0,
        slip_ratio: 0.0,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 0.2,
    }
}

#[test]
fn between_any_two_stamps_the_truth_is_in_the_box_with_readings_lost_and_out_of_order() {
    let (mut rng, model, reach) = (
        ChaCha8Rng::seed_from_u64(4),
        model(),
        Reach { speed_m_per_s: 0.5, turn_rate_rad_per_s: 1.0, acceleration_m_per_s2: 1.0 },
    );
    let (mut widest_m, mut answered) = (0.0_f64, 0);
    for _ in 0..40 {
        // True motion for the test: speeds forward, sideways and in heading oscillate within the declared limits and are integrated in steps of a
        // millisecond; the flow sensor's mount is at the limits of its bounds.
        let [ahead, aside, about] =
            [0.3, 0.02, 0.4].map(|size: f64| [size, rng.random_range(1.0..2.0), rng.random_range(0.0..6.0)]);
        let swing = |[size, rate, phase]: [f64; 3], time_s: f64| size * (rate * time_s + phase).sin();
        let (mut pose, mut seen, mut poses) = ([0.0_f64; 3], [0.3_f64, 0.7], vec![[0.0; 3]]);
        let mut readings = vec![(0.0, [0, 0])];
        for step in 0..1000 {
            let time_s = (f64::from(step) + 0.5) * 0.001;
            let (forward, left, rate) = (swing(ahead, time_s), swing(aside, time_s), swing(about, time_s));
            let middle = pose[2] + rate * 0.0005;
            pose[0] += (forward * middle.cos() - left * middle.sin()) * 0.001;
            pose[1] += (forward * middle.sin() + left * middle.cos()) * 0.001;
            pose[2] += rate * 0.001;
            let per_step = [(forward - rate * 0.0304) * 0.001, (left - rate * 0.0604) * 0.001];
            (0..2).for_each(|axis| seen[axis] += per_step[axis] * COUNTS_PER_M * 1.0025);
            poses.push(pose);
            if (step + 1) % 10 == 0 {
                readings.push((f64::from(step + 1) * 0.001, seen.map(|counts| counts.floor() as i64)));
            }
        }
        // One flow-sensor reading in ten is lost, and the others arrive in another order than they were measured.
        readings.retain(|_| rng.random_range(0..10) > 0);
        (1..readings.len()).for_each(|idx| readings.swap(idx, rng.random_range(idx.saturating_sub(3)..=idx)));
        let mut history = FlowHistory::new(model, 10.0);
        readings.iter().for_each(|(time_s, counts)| {
            history.push(*time_s, *counts, 0);
        });
        let at = |time_s: f64| poses[(time_s * 1000.0).round() as usize];
        let gyro = gyro_told(100, |time_s| at(time_s)[2], 1e-6);
        for _ in 0..100 {
            let from = rng.random_range(0..900);
            let to = rng.random_range(from + 1..=1000.min(from + 400));
            let (from_s, to_s) = (f64::from(from) * 0.001, f64::from(to) * 0.001);
            let Some(motion) = history.motion([from_s, to_s], Some(&gyro), &wheels(), &reach) else { continue };
            let (start, end) = (at(from_s), at(to_s));
            let (dx, dy, (sin, cos)) = (end[0] - start[0], end[1] - start[1], start[2].sin_cos());
            let truth = [cos * dx + sin * dy, cos * dy - sin * dx, end[2] - start[2]];
            assert!(motion.contains(&truth), "{truth:?} is not in {motion:?} from {from_s} to {to_s}");
            widest_m = widest_m.max(motion.width(0));
            answered += 1;
        }
    }
    // By hand: the box of the motion is a few millimetres wide because of two counts of the flow sensor, some interpolation between readings, 0.6 %
    // of travels of up to 0.12 m, and 0.003 rad of uncertainty in the mount's direction.
    assert!(answered > 3000 && widest_m < 0.006, "{answered} answers, up to {widest_m} m wide");
}

#[test]
fn a_blind_period_leaves_no_motion_across_it() {
    let reach = Reach { speed_m_per_s: 0.5, turn_rate_rad_per_s: 1.0, acceleration_m_per_s2: 1.0 };
    let mut history = FlowHistory::new(model(), 10.0);
    (0..=20).for_each(|step| {
        history.push(0.01 * f64::from(step), [0, 0], u64::from(step > 10));
    });
    let gyro = gyro_told(20, |_| 0.0, 0.0);
    let told = |from_s: f64, to_s: f64| history.motion([from_s, to_s], Some(&gyro), &wheels(), &reach).is_some();
    assert!(told(0.0, 0.1) && told(0.11, 0.2) && !told(0.05, 0.15) && !told(0.104, 0.108));
    // The flow sensor's history gives no motion for times before its first reading or after its last one.
    assert!(!told(-0.01, 0.1) && !told(0.15, 0.21));
}
