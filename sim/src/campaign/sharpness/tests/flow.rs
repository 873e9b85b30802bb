//! Counts of the flow sensor, turns at rest and a bias that wanders, on drives made by hand.

use interval::Interval;
use localizer::{Pose, bounds, bounds::Assumption};

use super::super::{
    flow::{COUNTS, Counts, Flow},
    gyro::Gyro,
    history::{Counted, History, Quantity},
    kind::{Declared, Kind, demand},
    rest::Rest,
};
use super::{
    HAIR,
    drive::{Drive, N_STEPS, SPEED_M_PER_S, STEP_S},
    pushed, turned,
};
use crate::scene;

fn broken(kind: &dyn Kind, history: &History) -> Option<Assumption> {
    for Declared { quantity, interval, bound } in kind.declared(history) {
        if demand(0.0, bound, 0.0, Interval::point(history.value(quantity)), interval).is_err() {
            return Some(bound);
        }
    }
    kind.check(history, 0.0).err().map(|broken| broken.bound)
}

/// Nominal counts per metre.
const COUNTS_PER_M: f64 = 20_000.0;
/// Way of the straight drive.
const WAY_M: f64 = SPEED_M_PER_S * N_STEPS as f64 * STEP_S;

/// Two seconds straight ahead, 0.4 m, with a nominal flow sensor that counts 20000 in a metre and stood in the middle of a count.
fn straight() -> (History, Flow) {
    let mut history = Drive::on_circle(&[]).history;
    for (stamp, pose) in history.poses.iter_mut().enumerate() {
        *pose = Pose { x_m: 1.0 + SPEED_M_PER_S * stamp as f64 * STEP_S, y_m: 1.0, heading_rad: 0.0 };
    }
    let keys = scene::Flow { back_and_forth_m: 0.0, ..scene::Flow::default() };
    let model = keys.model();
    let counts = |stamp: usize| [(stamp as f64 * SPEED_M_PER_S * STEP_S * COUNTS_PER_M + 0.5).floor() as i64, 0];
    let readings =
        (0..=N_STEPS).map(|stamp| Counts { stamp, counts: counts(stamp), is_blind: false, beyond_m: [0.0; 2] });
    let flow = Flow { readings: readings.collect(), keys, model, truly: Vec::new() };
    for Declared { quantity, interval, .. } in flow.declared(&history) {
        history.quantities.insert(quantity, interval.mid());
    }
    history.counted = counted([0.5; 2], [WAY_M, 0.0], 0.0, [0.0; 2]);
    (history, flow)
}

/// What is counted on a way of constant speed by a scale that varies by `change` in each period, and with so many counts gained in each.
fn counted(first: [f64; 2], way_m: [f64; 2], change: f64, gained: [f64; 2]) -> Vec<Counted> {
    let counts = |step: usize| {
        let in_step = |axis: usize| (1.0 + change) * COUNTS_PER_M * way_m[axis] / N_STEPS as f64 + gained[axis];
        [0, 1].map(|axis| first[axis] + step as f64 * in_step(axis))
    };
    (0..=N_STEPS).map(|step| Counted { counts: counts(step), change, gained }).collect()
}

#[test]
fn a_constant_of_the_flow_sensor_a_hair_beyond_its_bound_is_refused_by_name() {
    let (history, flow) = straight();
    assert_eq!(broken(&flow, &history), None);
    let cases = [
        (Quantity::FlowPosition(0), bounds::FLOW_POSITION),
        (Quantity::FlowPosition(1), bounds::FLOW_POSITION),
        (Quantity::FlowYaw, bounds::FLOW_YAW),
        (Quantity::FlowScale, bounds::FLOW_CALIBRATION),
    ];
    for Declared { quantity, interval, .. } in flow.declared(&history) {
        let bound = cases.iter().find(|(named, _)| *named == quantity).unwrap().1;
        for (end, outwards) in [(interval.lo(), -1.0), (interval.hi(), 1.0)] {
            let at = |hairs: f64| {
                let mut changed = history.clone();
                changed.quantities.insert(quantity, end + outwards * hairs * HAIR * interval.width());
                broken(&flow, &changed)
            };
            assert_eq!(at(1.0), Some(bound), "{quantity:?}");
            assert_ne!(at(-1.0), Some(bound), "{quantity:?}");
        }
    }
}

/// By hand: 8000 counts are read, so that 7999 to 8001 were counted. With 0.2 % less to the metre, 8001 counts are 0.85170 mm more than 0.4 m.
#[test]
fn a_scale_that_would_vary_a_hair_more_than_declared_is_refused() {
    let (history, flow) = straight();
    // The sensor counts from one number to another on a way that is longer by so much.
    let ahead = |by_m: f64, [from, to]: [f64; 2]| {
        let mut changed = history.clone();
        pushed(&mut changed, 0, 0, N_STEPS, by_m);
        let way_m = WAY_M + by_m;
        changed.counted = counted([from, 0.5], [way_m, 0.0], (to - from) / (COUNTS_PER_M * way_m) - 1.0, [0.0; 2]);
        broken(&flow, &changed)
    };
    const TINY: f64 = 1e-7;
    let (most, least) = ([TINY, 8001.0 - TINY], [1.0 - TINY, 8000.0 + TINY]);
    let most_m = 8001.0 / (0.998 * COUNTS_PER_M) - WAY_M;
    assert_eq!([1.0001, 0.9999].map(|share| ahead(share * most_m, most)), [Some(bounds::FLOW_SCALE), None]);
    let least_m = 7999.0 / (1.002 * COUNTS_PER_M) - WAY_M;
    assert_eq!([1.0001, 0.9999].map(|share| ahead(share * least_m, least)), [Some(bounds::FLOW_SCALE), None]);
    // What was counted is what is read.
    assert_eq!(ahead(most_m, [TINY, 8001.0 + 1e-5]), Some(COUNTS));
    assert_eq!(ahead(most_m, [-1e-5, 8001.0 - TINY]), Some(COUNTS));
}

/// To the side, readings of 0 counts mean that less than one count was counted. By hand: forth and back by 0.1 mm in each of 200 periods, 0.2 % more one
/// way and less the other, adds up to 0.8 counts, or to 0.4 where the scale itself is 0.1 % more.
#[test]
fn one_scale_counts_along_both_axes_and_ways_forth_and_back_add_no_more_than_declared() {
    let (history, mut flow) = straight();
    let aside = |flow: &Flow, counts: f64, change: f64, gained: f64| {
        let mut changed = history.clone();
        let way_m = [WAY_M / (1.0 + change), counts / COUNTS_PER_M];
        pushed(&mut changed, 0, 0, N_STEPS, way_m[0] - WAY_M);
        pushed(&mut changed, 1, 0, N_STEPS, way_m[1]);
        changed.counted = counted([0.5, 1e-9], way_m, change, [0.0, gained / N_STEPS as f64]);
        broken(flow, &changed)
    };
    assert_eq!([1.0001, 0.9999].map(|counts| aside(&flow, counts, 0.0, 0.0)), [Some(COUNTS), None]);
    assert_eq!([1.0001, 0.9999].map(|counts| aside(&flow, counts / 1.001, 1e-3, 0.0)), [Some(COUNTS), None]);
    assert_eq!(aside(&flow, 1.5, 0.0, -0.7), Some(bounds::FLOW_BACK_AND_FORTH));
    flow.keys.back_and_forth_m = 1e-4;
    assert_eq!(
        [-0.8001, -0.7999].map(|gained| aside(&flow, 1.7, 0.0, gained)),
        [Some(bounds::FLOW_BACK_AND_FORTH), None]
    );
    assert_eq!(
        [-0.4001, -0.3999].map(|gained| aside(&flow, 1.3, 1e-3, gained)),
        [Some(bounds::FLOW_BACK_AND_FORTH), None]
    );
    assert_eq!(aside(&flow, 1.85, 0.0, -0.7999), Some(COUNTS));
}

#[test]
fn while_it_is_blind_the_flow_sensor_counts_nothing() {
    let (history, mut flow) = straight();
    for reading in &mut flow.readings[100..] {
        (reading.counts, reading.is_blind) = ([3960, 0], true);
    }
    assert_eq!(broken(&flow, &history), None);
    flow.readings[100].is_blind = false;
    assert_eq!(broken(&flow, &history), Some(COUNTS));
    // A history that does not say what was counted counts nothing that could be read.
    assert_eq!(broken(&flow, &History { counted: Vec::new(), ..history }), Some(COUNTS));
}

/// Two seconds on a circle, and what the sensor counts. A place 60 mm behind the axle goes to the right as the robot turns to the left: 0.3 rad/s for 2 s
/// are 36 mm, 720 counts.
fn on_circle() -> (History, Flow) {
    let (straight, mut flow) = straight();
    let mut history = Drive::on_circle(&[]).history;
    history.quantities = straight.quantities;
    history.counted = counted([0.5; 2], [WAY_M, -0.036], 0.0, [0.0; 2]);
    for reading in &mut flow.readings {
        reading.counts[1] = (-720.0 * reading.stamp as f64 / N_STEPS as f64 + 0.5).floor() as i64;
    }
    (history, flow)
}

#[test]
fn in_a_turn_the_place_of_the_flow_sensor_counts_too() {
    let (history, mut flow) = on_circle();
    assert_eq!(broken(&flow, &history), None);
    flow.readings.iter_mut().for_each(|reading| reading.counts[1] = 0);
    assert_eq!(broken(&flow, &history), Some(COUNTS));
}

/// A history on a circle whose headings and constants are others than those with which the counts were made: settled, the robot counts again what the
/// history says, and its headings are as they were.
#[test]
fn a_settled_history_counts_what_it_says() {
    let (mut history, flow) = on_circle();
    turned(&mut history, |time_s| 0.02 + 0.01 * time_s * time_s);
    history.quantities.insert(Quantity::FlowPosition(0), -0.0605);
    history.quantities.insert(Quantity::FlowYaw, 0.003);
    history.quantities.insert(Quantity::FlowScale, 1.0005);
    for (step, counted) in history.counted.iter_mut().enumerate() {
        counted.counts[0] += 0.3 * step as f64 / N_STEPS as f64;
        counted.change = -5e-4;
    }
    assert!(broken(&flow, &history).is_some());
    let before = history.clone();
    flow.settle(&mut history);
    assert_eq!(flow.check(&history, 0.0), Ok(()));
    let headings = |history: &History| history.poses.iter().map(|pose| pose.heading_rad).collect::<Vec<_>>();
    assert_eq!((headings(&history), history.poses[0]), (headings(&before), before.poses[0]));
}

#[test]
fn a_turn_at_rest_is_refused_once_the_wheels_have_settled() {
    let history = straight().0;
    let most_rad = 1e-4;
    // Ticks come until 0.3 s, and one more at 1.5 s; so the wheels have settled at 0.8 s and at 2 s.
    let ticks = |stamp: usize| [(stamp.min(30) + usize::from(stamp >= 150)) as i64; 2];
    let readings: Vec<(usize, [i64; 2])> = (0..=N_STEPS).map(|stamp| (stamp, ticks(stamp))).collect();
    let rest = Rest::of(&readings, &history, most_rad);
    let by = |turn_rad: f64, from_s: f64| {
        let mut changed = history.clone();
        turned(&mut changed, |time_s| if time_s > from_s { turn_rad } else { 0.0 });
        broken(&rest, &changed)
    };
    assert_eq!([most_rad, -most_rad].map(|turn_rad| by(turn_rad * 1.0001, 1.0)), [Some(bounds::WHEELS_REST); 2]);
    assert_eq!(by(most_rad * 0.9999, 1.0), None);
    assert_eq!((by(1.0, 0.795), by(1.0, 1.495)), (None, None));
    assert_eq!(by(most_rad * 1.0001, 0.805), Some(bounds::WHEELS_REST));
}

/// By hand: with errors that grow by k in a second, over the 1.99 s from the middle of the first reading to that of the last, a bias that begins with the
/// noise against it and ends with the noise behind it needs k·1.99 s ≤ wander·1.99 s + 2·noise.
#[test]
fn a_bias_that_would_wander_faster_than_declared_is_refused() {
    let drive = Drive::on_circle(&[]);
    let mut gyro = drive.gyro();
    gyro.model.angle_floor_rad = f64::INFINITY;
    gyro.model.bias_wander_rad_per_s2 = 1e-3;
    gyro.model.bias_rad_per_s = Interval::new(-1.0, 1.0);
    let grown = |gyro: &Gyro, growth: f64| {
        let mut changed = drive.history.clone();
        turned(&mut changed, |time_s| 0.5 * growth * time_s * time_s);
        gyro.check(&changed, 0.0).err().map(|broken| broken.bound)
    };
    let most = 1e-3 + 2.0 * gyro.model.noise_rad_per_s / 1.99;
    assert_eq!((grown(&gyro, most * 1.0001), grown(&gyro, most * 0.9999)), (Some(bounds::GYRO_WANDER), None));
    assert_eq!((grown(&gyro, -most * 1.0001), grown(&gyro, -most * 0.9999)), (Some(bounds::GYRO_WANDER), None));
    // The bias itself is bounded: the last reading's error is k·1.995 s.
    gyro.model.bias_wander_rad_per_s2 = 1.0;
    gyro.model.bias_rad_per_s = Interval::new(-0.01, 0.01);
    let most = (0.01 + gyro.model.noise_rad_per_s) / 1.995;
    assert_eq!((grown(&gyro, most * 1.0001), grown(&gyro, most * 0.9999)), (Some(bounds::GYRO_NOISE), None));
}
