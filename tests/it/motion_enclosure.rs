//! Tests of the motion that wheel odometry encloses, against motion integrated in steps a hundred times finer, with
//! slip at the corners of its bounds.

use interval::Interval;
use localizer::{
    PoseBox,
    motion::{WheelHistory, moved},
    robot::{GyroModel, Reach, WheelModel},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const FINE_S: f64 = 1e-4;
const REACH: Reach = Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 2.0 };

fn wheels() -> WheelModel {
    WheelModel {
        radius_m: [Interval::centred(0.0975, 0.0002), Interval::centred(0.0975, 0.0002)],
        track_m: Interval::centred(0.33, 0.001),
        ticks_per_turn: 19_150.0,
        slip_ratio: 0.005,
        slip_floor_m: 0.0001,
        side_slip_ratio: 0.003,
        side_slip_floor_m: 0.00005,
        slip_window_s: 0.2,
    }
}

/// One random drive: true poses and wheel readings every 10 ms.
struct Drive {
    history: WheelHistory,
    ticks: Vec<[i64; 2]>,
    poses: Vec<[f64; 3]>,
}

impl Drive {
    /// The history of wheel readings as the localizer knows it when the reading with index `reading` is the latest that has arrived.
    fn known_up_to(&self, reading: usize) -> WheelHistory {
        let mut history = WheelHistory::new(10.0);
        for (index, ticks) in self.ticks.iter().enumerate().take(reading + 1) {
            history.push(index as f64 * 0.01, *ticks);
        }
        history
    }
}

fn drive(rng: &mut ChaCha8Rng, n_readings: usize, slip_share: f64) -> Drive {
    let model = wheels();
    let radius_m: [f64; 2] = std::array::from_fn(|_| 0.0975 + 0.0002 * corner(rng));
    let track_m = 0.33 + 0.001 * corner(rng);
    let slip: [f64; 2] = std::array::from_fn(|_| slip_share * model.slip_ratio * corner(rng));
    let side = slip_share * model.side_slip_ratio * corner(rng);
    let phase: [f64; 2] = std::array::from_fn(|_| rng.random::<f64>());
    let mut history = WheelHistory::new(10.0);
    let (mut pose, mut rolled_m) = ([0.3, -0.2, rng.random_range(-20.0..20.0)], [0.0; 2]);
    let mut speed: [f64; 2] = std::array::from_fn(|_| rng.random_range(-0.5..0.5));
    let mut acceleration = [0.0; 2];
    let (mut poses, mut all_ticks) = (Vec::new(), Vec::new());
    for reading in 0..n_readings {
        let ticks =
            [0, 1].map(|w| (rolled_m[w] / radius_m[w] / std::f64::consts::TAU * 19_150.0 + phase[w]).floor() as i64);
        history.push(reading as f64 * 0.01, ticks);
        all_ticks.push(ticks);
        poses.push(pose);
        if reading % 7 == 0 {
            // The simulated wheels accelerate with at most 1.9 m/s², a little less than the declared limit, since slip adds to the robot's
            // acceleration.
            acceleration = std::array::from_fn(|_| rng.random_range(-1.9..1.9));
        }
        for _ in 0..100 {
            for w in 0..2 {
                speed[w] = (speed[w] + acceleration[w] * FINE_S).clamp(-0.5, 0.5);
            }
            let travel = [0, 1].map(|w| speed[w] * (1.0 + slip[w]) * FINE_S);
            let (forward, turn) = (0.5 * (travel[0] + travel[1]), (travel[1] - travel[0]) / track_m);
            let lateral = side * 0.5 * (speed[0].abs() + speed[1].abs()) * FINE_S;
            let (sin, cos) = (pose[2] + 0.5 * turn).sin_cos();
            pose = [pose[0] + forward * cos - lateral * sin, pose[1] + forward * sin + lateral * cos, pose[2] + turn];
            (0..2).for_each(|w| rolled_m[w] += speed[w] * FINE_S);
        }
    }
    Drive { history, ticks: all_ticks, poses }
}

fn corner(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<f64>() < 0.5 { [-1.0, 1.0][rng.random_range(0..2)] } else { rng.random_range(-1.0..1.0) }
}

fn start_box(pose: [f64; 3]) -> PoseBox {
    PoseBox::from(pose.map(|value| Interval::centred(value, 1e-9)))
}

#[test]
fn the_true_arc_is_enclosed_with_slip_and_dimensions_at_their_bounds() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..300 {
        let Drive { history, poses, .. } = drive(&mut rng, 60, 1.0);
        let from = rng.random_range(0..20);
        for to in from + 1..60 {
            let motion =
                history.motion(from as f64 * 0.01, to as f64 * 0.01, &wheels(), &REACH).expect("inside the history");
            let reached = moved(&start_box(poses[from]), &motion);
            assert!(reached.contains(&poses[to]), "from {from} to {to}: {reached:?} misses {:?}", poses[to]);
        }
    }
}

#[test]
fn stamps_between_two_readings_are_enclosed() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for _ in 0..200 {
        let Drive { history, poses, .. } = drive(&mut rng, 40, 0.9);
        // The true pose is known only at the times of wheel readings. To test a stamp between two readings, the test predicts from a reading to that
        // stamp, and from there to another reading.
        let middle_s = rng.random_range(0.05..0.15);
        let first = history.motion(0.02, middle_s, &wheels(), &REACH).expect("inside the history");
        let second = history.motion(middle_s, 0.3, &wheels(), &REACH).expect("inside the history");
        let reached = moved(&moved(&start_box(poses[2]), &first), &second);
        assert!(reached.contains(&poses[30]));
    }
}

#[test]
fn ahead_of_the_latest_reading_the_wheels_are_enclosed_by_what_they_can_have_done() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut greatest_use: f64 = 0.0;
    for _ in 0..300 {
        let drive = drive(&mut rng, 60, 0.9);
        let (from, latest) = (rng.random_range(0..25), rng.random_range(25..35));
        let known = drive.known_up_to(latest);
        // Motion can be predicted up to a quarter of a second beyond the latest reading, and no further.
        for to in latest + 1..=latest + 25 {
            let motion =
                known.motion(from as f64 * 0.01, to as f64 * 0.01 - 1e-9, &wheels(), &REACH).expect("near ahead");
            let reached = moved(&start_box(drive.poses[from]), &motion);
            assert!(reached.contains(&drive.poses[to]), "from {from} by {latest} to {to}: misses by the wheels");
            for (side, truth) in reached.iter().zip(drive.poses[to]) {
                greatest_use = greatest_use.max((truth - side.mid()).abs() / (0.5 * side.width()));
            }
        }
        assert!(known.motion(from as f64 * 0.01, latest as f64 * 0.01 + 0.26, &wheels(), &REACH).is_none());
    }
    assert!(greatest_use > 0.5, "a box that is never half used would hide a fault: {greatest_use}");
}

#[test]
fn fifty_milliseconds_ahead_cost_millimetres() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for _ in 0..100 {
        let known = drive(&mut rng, 40, 1.0).known_up_to(30);
        let at_reading = known.motion(0.2, 0.3, &wheels(), &REACH).expect("inside the history");
        let ahead = known.motion(0.2, 0.35, &wheels(), &REACH).expect("near ahead");
        // By hand, what predicting the motion 50 ms beyond the latest wheel reading adds to the box: over the last 10 ms, a tick of 0.032 mm, 0.13 mm
        // of slip and an acceleration of 2 m/s² leave the rate uncertain by 3.2 + 13 + 10 mm/s, which is ±1.3 mm in 50 ms, and its change meanwhile
        // adds ±2.5 mm. The error of the travel acts at the end of the span and, by summation by parts, with the turning: by at most 0.49 rad in 0.15
        // s, or ±2.0 mm more. The heading at the middle of the span, uncertain by 14 mrad, moves 28 mm by ±0.4 mm, and the midpoint rule leaves ±0.2
        // mm. By the physical limits of speed and acceleration alone it would be ±35 mm.
        assert!(ahead[0].width() - at_reading[0].width() < 2.0 * 6.5e-3, "{ahead:?}");
    }
}

#[test]
fn slip_beyond_its_bound_escapes() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let escapes = (0..50)
        .filter(|_| {
            let Drive { history, poses, .. } = drive(&mut rng, 40, 12.0);
            let motion = history.motion(0.0, 0.3, &wheels(), &REACH).expect("inside the history");
            !moved(&start_box(poses[0]), &motion).contains(&poses[30])
        })
        .count();
    assert!(escapes > 10, "a bound that nothing breaks is no bound: {escapes} of 50 escaped");
}

#[test]
fn the_enclosure_of_a_fifth_of_a_second_is_millimetres_wide() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    for _ in 0..100 {
        let Drive { history, .. } = drive(&mut rng, 40, 1.0);
        let motion = history.motion(0.1, 0.3, &wheels(), &REACH).expect("inside the history");
        // By hand, the box of the motion over 0.2 s: the robot moves at most 0.1 m; 0.5 % of slip, 0.2 % of radius, 0.1 mm and a tick make ±0.85 mm,
        // side slip ±0.7 mm; a turn of up to 0.6 rad carries a share of each onto the other axis.
        assert!(motion[0].width() < 3.0e-3 && motion[1].width() < 3.0e-3, "{motion:?}");
        assert!(motion[2].width() < 2.0 * (2.0 * 0.85e-3 / 0.33 + 0.003 * 0.7), "{motion:?}");
    }
}

/// Wheels without any error, so that the box of a predicted motion is only as wide as the curved path makes it.
fn perfect_wheels() -> WheelModel {
    WheelModel {
        radius_m: [Interval::point(0.0975); 2],
        track_m: Interval::point(0.33),
        ticks_per_turn: 1e9,
        slip_ratio: 0.0,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 10.0,
    }
}

/// Pose after a circular arc of length `path_m` that turns by `turn_rad`, starting at the origin.
fn arc(path_m: f64, turn_rad: f64) -> [f64; 3] {
    let radius_m = path_m / turn_rad;
    [radius_m * turn_rad.sin(), radius_m * (1.0 - turn_rad.cos()), turn_rad]
}

/// Enclosure of the motion along a circular arc, from only two wheel readings: one at the arc's start and one at its end, a second later.
fn told_in_one_step(path_m: f64, turn_rad: f64, wheels: &WheelModel) -> PoseBox {
    let ticks = [-0.5, 0.5].map(|side| {
        let travel_m = path_m + side * turn_rad * 0.33;
        (travel_m / 0.0975 / std::f64::consts::TAU * 1e9) as i64
    });
    let mut history = WheelHistory::new(10.0);
    history.push(0.0, [0, 0]);
    history.push(1.0, ticks);
    let steady = Reach { acceleration_m_per_s2: 1e-6, ..REACH };
    let motion = history.motion(0.0, 1.0, wheels, &steady).expect("inside the history");
    moved(&start_box([0.0; 3]), &motion)
}

#[test]
fn a_step_is_as_long_as_its_chord_not_as_its_arc() {
    for turn_rad in [-1.2, -0.4, 0.3, 1.0] {
        let reached = told_in_one_step(0.5, turn_rad, &perfect_wheels());
        assert!(reached.contains(&arc(0.5, turn_rad)), "a turn of {turn_rad}: {reached:?}");
    }
}

#[test]
fn side_slip_that_turns_about_on_the_way_is_enclosed() {
    // The bound on side slip limits its sum at any time, not each step: here the robot slips to the right by the whole bound before the turn, and
    // after the turn to the left as far as the opposite bound.
    let bound_m = 0.01;
    let wheels = WheelModel { side_slip_floor_m: bound_m, ..perfect_wheels() };
    for turn_rad in [-1.0, 0.5, 1.0_f64] {
        let [x_m, y_m, heading_rad] = arc(0.5, turn_rad);
        let (sin, cos) = turn_rad.sin_cos();
        let truth = [x_m - 2.0 * bound_m * sin, y_m - bound_m + 2.0 * bound_m * cos, heading_rad];
        let reached = told_in_one_step(0.5, turn_rad, &wheels);
        assert!(reached.contains(&truth), "a turn of {turn_rad}: {reached:?} misses {truth:?}");
    }
}

#[test]
fn the_way_back_to_an_earlier_stamp_is_no_stand() {
    let gyro = GyroModel {
        bias_rad_per_s: Interval::ZERO,
        scale: Interval::ONE,
        noise_rad_per_s: 0.0,
        angle_floor_rad: f64::INFINITY,
        angle_rad_per_s: 0.0,
        bias_wander_rad_per_s2: 0.0,
        period_s: 0.1,
    };
    let mut history = WheelHistory::new(10.0).with_gyro(gyro);
    for step in 0..=10 {
        history.push(0.1 * f64::from(step), [1000 * i64::from(step); 2]);
        history.push_rate(0.1 * f64::from(step), 1.0);
    }
    assert!(history.motion(0.2, 0.7, &wheels(), &REACH).is_some());
    assert!(history.motion(0.7, 0.2, &wheels(), &REACH).is_none());
    assert!(history.gyro_turn(0.7, 0.2, &wheels(), &REACH).is_none());
    // Where only the limits of speed and turn rate are known, the motion back to an earlier time is bounded as that forwards is: 0.35 m and 0.8 rad
    // in half a second.
    let back = history.reach_motion(0.7, 0.2, &REACH);
    assert!(back.contains(&[-0.35, 0.35, -0.8]) && !back.contains(&[-0.36, 0.0, 0.0]), "{back:?}");
}
