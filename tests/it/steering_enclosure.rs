//! What the turn of a car by its steering allows for: each part alone, by readings that are made for it; and all together, against the integral of
//! random drives.

use std::f64::consts::TAU;

use interval::Interval;
use localizer::{
    motion::{SteeringHistory, WheelHistory},
    robot::{Reach, SteeringModel, WheelModel},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const WHEELBASE_M: f64 = 0.5;

/// Wheels that roll a micrometre in a tick, so that a count is nothing beside all else, and do not slip. Their distance is hardly known, so that
/// their difference tells nothing of the turn.
fn exact() -> WheelModel {
    WheelModel {
        radius_m: [Interval::point(0.1); 2],
        track_m: Interval::new(1e-9, 1e3),
        ticks_per_turn: 0.1e6 * TAU,
        slip_ratio: 0.0,
        slip_floor_m: 0.0,
        side_slip_ratio: 0.0,
        side_slip_floor_m: 0.0,
        slip_window_s: 100.0,
    }
}

/// A steering whose encoder reads a nanoradian, and which turns by up to a radian per second.
fn plain() -> SteeringModel {
    SteeringModel {
        wheelbase_m: Interval::point(WHEELBASE_M),
        rad_per_tick: 1e-9,
        zero_rad: Interval::ZERO,
        scale: Interval::point(1.0),
        rate_rad_per_s: 1.0,
        slip_share: 0.0,
        slip_rad_per_m: 0.0,
        slip_floor_rad: 0.0,
    }
}

fn reach(acceleration_m_per_s2: f64) -> Reach {
    Reach { speed_m_per_s: 2.0, turn_rate_rad_per_s: 100.0, acceleration_m_per_s2 }
}

/// The turn over steps of 0.1 s, each given by the travel of both wheels, with the steering angles that are read at the stamps.
fn turn(
    travels_m: &[f64],
    angles_rad: &[f64],
    model: SteeringModel,
    wheels: &WheelModel,
    acceleration_m_per_s2: f64,
) -> Interval {
    let mut history = WheelHistory::new(100.0).with_steering(model);
    let per_tick_m = wheels.metres_per_tick(0).mid();
    let mut at_m = 0.0;
    for (idx, angle_rad) in angles_rad.iter().enumerate() {
        let stamp_s = 0.1 * idx as f64;
        at_m += if idx == 0 { 0.0 } else { travels_m[idx - 1] };
        history.push_steering(stamp_s, (angle_rad / model.rad_per_tick).round());
        history.push(stamp_s, [(at_m / per_tick_m).round() as i64; 2]);
    }
    let end_s = 0.1 * travels_m.len() as f64;
    history.motion(0.0, end_s, wheels, &reach(acceleration_m_per_s2)).expect("in the history")[2]
}

#[test]
fn a_car_that_is_steered_evenly_turns_on_its_circle() {
    // With tan δ = 0.5 and a wheelbase of 0.5 m the circle has a radius of 1 m. Ten steps of 1 cm turn the car by 0.1 rad. The steering may leave its
    // angle by 0.001 · 0.1/4 rad on average between two readings, and each of the ticks of a micrometre may be off by half.
    let slow = SteeringModel { rate_rad_per_s: 0.001, ..plain() };
    let turned = turn(&[0.01; 10], &[0.5_f64.atan(); 11], slow, &exact(), 0.0);
    let allowed = 0.1 / WHEELBASE_M * 1.25 * (0.001 * 0.1 / 4.0) + 1e-6;
    assert!(turned.contains(0.1) && turned.radius() < 1.05 * allowed, "{turned} ± {}", turned.radius());
}

#[test]
fn steering_away_and_back_between_two_readings_turns_the_car() {
    // Within 0.1 s and 0.1 m the angle goes to 0.05 rad and back: 0.025 rad on average, which turns the car by 5 mrad.
    let turned = turn(&[0.1], &[0.0, 0.0], plain(), &exact(), 0.0);
    assert!(turned.contains(0.005) && turned.hi() < 0.00504, "{turned}");
    // From 0 to 0.05 rad it may go by 0.075 rad, 0.04375 rad on average; from 0 to 0.1 rad only evenly.
    let turned = turn(&[0.1], &[0.0, 0.05], plain(), &exact(), 0.0);
    assert!(turned.contains(0.00875) && turned.hi() < 0.0088, "{turned}");
    let turned = turn(&[0.1], &[0.0, 0.1], plain(), &exact(), 0.0);
    assert!(turned.contains(0.01) && turned.hi() < 0.0101, "{turned}");
}

#[test]
fn a_tangent_that_bends_turns_the_car_further() {
    // From 0.5 rad to 0.7 rad and back the mean tangent is (ln cos 0.5 − ln cos 0.7)/0.2 = 0.6883, more than tan 0.6 = 0.6841.
    let quick = SteeringModel { rate_rad_per_s: 4.0, ..plain() };
    let turned = turn(&[0.1], &[0.5, 0.5], quick, &exact(), 0.0);
    let mean = (0.5_f64.cos().ln() - 0.7_f64.cos().ln()) / 0.2;
    assert!(turned.contains(0.2 * mean), "{turned} without {}", 0.2 * mean);
}

#[test]
fn a_car_that_changes_its_speed_while_it_is_steered_turns_further() {
    // In 0.1 s the car goes 0.1 m, at 0.9 m/s first and at 1.1 m/s at the end. It is steered to −0.025 rad and back in the first half, and to
    // 0.025 rad and back in the second, each time 0.0125 rad on average: with the mean speeds of 0.95 and 1.05 m/s the parts differ by
    // 1.25 mrad · 0.1 m/2.
    let turned = turn(&[0.1], &[0.0, 0.0], plain(), &exact(), 2.0);
    let beyond = turned.hi() - turn(&[0.1], &[0.0, 0.0], plain(), &exact(), 0.0).hi();
    assert!(beyond > 0.0125 * 0.05 * 0.1 / WHEELBASE_M, "{beyond}");
    // A car that is at the same place at both readings may have gone back by 2.5 mm and forth again, steered right on the way back and left after it.
    let turned = turn(&[0.0], &[0.0, 0.0], plain(), &exact(), 2.0);
    assert!(turned.hi() > 2.0 * 0.0125 * 0.0025 / WHEELBASE_M, "{turned}");
}

#[test]
fn slip_along_the_way_and_ticks_count_once_for_each_change_of_the_angle() {
    // On a circle of 1 m the wheels slip by 2 mm in all, which turns the car by 2 mrad; and a tick of 4 mm is off by half at either end.
    let still = SteeringModel { rate_rad_per_s: 0.0, ..plain() };
    let (angles, ways) = ([0.5_f64.atan(); 11], [0.04; 10]);
    let whole = turn(&ways, &angles, still, &exact(), 0.0);
    let slipping = WheelModel { slip_floor_m: 0.002, ..exact() };
    let slipped = turn(&ways, &angles, still, &slipping, 0.0);
    assert!((slipped.radius() - whole.radius() - 0.002).abs() < 1e-5, "{slipped} {whole}");
    let coarse = WheelModel { ticks_per_turn: 0.1 * TAU / 0.004, ..exact() };
    let counted = turn(&ways, &angles, still, &coarse, 0.0);
    assert!((counted.radius() - 0.004).abs() < 1e-4, "{counted}");
    // Straight ahead, neither turns the car.
    for wheels in [slipping, coarse] {
        let straight = turn(&ways, &[0.0; 11], still, &wheels, 0.0);
        assert!(straight.radius() < 1e-7, "{straight}");
    }
}

#[test]
fn slip_and_ticks_that_go_one_way_and_back_turn_a_car_that_is_steered_one_way_and_back() {
    // The tangent goes from 0.44 to −0.44 in ten steps, as fast as it can. Wheels that slip by 2 mm by the time it is 0 and back to −2 mm turn the car by
    // about 2 mm · 3 · 0.44/0.5 m = 5.3 mrad; and ticks of 4 mm, each off by half to either side, by 2 mm · 4 · 0.44/0.5 m = 7.1 mrad.
    let most_rad = 0.5_f64.atan();
    let angles: Vec<f64> = (0..11).map(|idx| most_rad * (1.0 - 0.2 * f64::from(idx))).collect();
    let quick = SteeringModel { rate_rad_per_s: 2.0 * most_rad * (1.0 + 1e-6), ..plain() };
    let radius = |wheels: &WheelModel| turn(&[0.04; 10], &angles, quick, wheels, 0.0).radius();
    let whole_rad = radius(&exact());
    let slipped_rad = radius(&WheelModel { slip_floor_m: 0.002, ..exact() }) - whole_rad;
    assert!(slipped_rad > 0.0052 && slipped_rad < 0.0058, "{slipped_rad}");
    let counted_rad = radius(&WheelModel { ticks_per_turn: 0.1 * TAU / 0.004, ..exact() }) - whole_rad;
    assert!(counted_rad > 0.0069 && counted_rad < 0.0077, "{counted_rad}");
}

#[test]
fn errors_of_the_encoder_and_of_the_wheelbase_turn_the_car_by_what_they_are() {
    // 0.4 m, at the tangent 0.5 on a circle of 1 m: 0.4 rad. A zero of 1 mrad turns the car by sec² δ/L · 1 mrad · 0.4 m = 1 mrad, and so does half a
    // tick of 2 mrad; a scale of 1 % by δ times that; a wheelbase that is 1 % too long by 1 % of the whole.
    let angle_rad = 0.5_f64.atan();
    let still = SteeringModel { rate_rad_per_s: 0.0, ..plain() };
    let radius = |model| turn(&[0.1; 4], &[angle_rad; 5], model, &exact(), 0.0).radius();
    let exact_rad = radius(still);
    let zero = radius(SteeringModel { zero_rad: Interval::centred(0.0, 0.001), ..still });
    assert!((zero - exact_rad - 0.001).abs() < 1e-5, "{zero}");
    let tick = radius(SteeringModel { rad_per_tick: 0.002, ..still });
    assert!((tick - exact_rad - 0.001).abs() < 1e-5, "{tick}");
    let scale = radius(SteeringModel { scale: Interval::centred(1.0, 0.01), ..still });
    assert!((scale - exact_rad - 0.01 * angle_rad).abs() < 1e-4, "{scale}");
    let long = radius(SteeringModel { wheelbase_m: Interval::new(0.5, 0.505), ..still });
    assert!((long - exact_rad - 0.002).abs() < 1e-4, "{long}");
    // Two windows of slip: a hundredth of 0.4 rad, 0.4 m at 5 mrad/m, and the constant part twice.
    let windows = WheelModel { slip_window_s: 0.2, ..exact() };
    let aside = SteeringModel { slip_share: 0.01, slip_rad_per_m: 0.005, slip_floor_rad: 0.0003, ..still };
    let aside = turn(&[0.1; 4], &[angle_rad; 5], aside, &windows, 0.0).radius();
    assert!((aside - exact_rad - 0.004 - 0.002 - 0.0006).abs() < 1e-5, "{aside}");
}

#[test]
fn readings_that_are_missing_late_or_doubled_never_make_the_turn_narrower_than_it_may_be() {
    let mut history = SteeringHistory::new(plain(), 100.0);
    assert!(history.between(0.0, 0.1).is_none(), "nothing was read");
    assert!(history.push(0.0, 0.0) && history.push(0.2, 0.0) && !history.push(0.2, 5.0));
    // In the middle of 0.2 s the angle may be 0.1 rad, and on average 0.05 rad.
    let gap = history.between(0.0, 0.2).unwrap();
    assert!(gap.range_rad.contains(0.1) && gap.mean_rad.contains(0.05) && gap.mean_rad.hi() < 0.0501, "{gap:?}");
    // In the half before the reading that comes late it ends at 0.05 rad.
    assert!(history.push(0.1, 0.05e9));
    let half = history.between(0.0, 0.1).unwrap();
    assert!(half.mean_rad.contains(0.0437) && half.range_rad.hi() < 0.0751, "{half:?}");
    // 0.1 s after the latest reading it has gone up to 0.1 rad, on average 0.05 rad.
    let ahead = history.between(0.2, 0.3).unwrap();
    assert!(
        ahead.range_rad.contains(0.1) && ahead.mean_rad.contains(0.05) && ahead.mean_rad.hi() < 0.0501,
        "{ahead:?}"
    );
    // So long after it that the tangent has no bound, nothing is told.
    assert!(history.between(0.2, 1.7).is_none());
    let mut beside = WheelHistory::new(100.0).with_steering(plain());
    (0..3).for_each(|idx| assert!(beside.push(0.1 * f64::from(idx), [0; 2])));
    let untold = beside.motion(0.0, 0.2, &exact(), &reach(1.0)).expect("in the history");
    assert!(untold[2].contains(0.0) && beside.push_steering(0.1, 0.0) == Some(true));
    // Between two readings 4 s apart the angle may have been any, so that the car may have turned by any angle on its way of 4 m.
    let mut rare = WheelHistory::new(100.0).with_steering(plain());
    (0..41).for_each(|idx| assert!(rare.push(0.1 * f64::from(idx), [100_000 * i64::from(idx); 2])));
    assert!(rare.push_steering(0.0, 0.0) == Some(true) && rare.push_steering(4.0, 0.0) == Some(true));
    let unknown = rare.motion(0.0, 4.0, &exact(), &reach(0.0)).expect("in the history")[2];
    assert!(unknown.contains(3.0) && unknown.contains(-3.0), "{unknown}");
}

/// A generator of numbers that prefers the ends of intervals.
struct Draw(ChaCha8Rng);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0.random_range(0.0..1.0)
    }

    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// A size between two, evenly on a logarithmic scale.
    fn size(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }

    fn or_zero(&mut self, value: f64) -> f64 {
        if self.unit() < 0.5 { 0.0 } else { value }
    }

    /// A number in an interval, three times in four at one of its ends.
    fn within(&mut self, values: Interval) -> f64 {
        match self.unit() {
            share if share < 0.375 => values.lo(),
            share if share < 0.75 => values.hi(),
            _ => self.between(values.lo(), values.hi()),
        }
    }
}

/// A random drive of a second with all errors at an end of their bounds or between.
struct Drive {
    history: WheelHistory,
    model: SteeringModel,
    wheels: WheelModel,
    acceleration_m_per_s2: f64,
    /// True headings at the wheels' stamps.
    headings_rad: Vec<f64>,
}

impl Drive {
    fn new(draw: &mut Draw) -> Drive {
        let rate_rad_per_s = draw.size(0.01, 3.0);
        let acceleration_m_per_s2 = draw.size(0.01, 3.0);
        let sizes = [(); 7].map(|()| draw.size(1e-5, 0.02)).map(|size| draw.or_zero(size));
        let [slip_ratio, zero_rad, scale, wheelbase, aside, radius, slip_share] = sizes;
        let around = |nominal: f64, share: f64| Interval::centred(nominal, nominal * share);
        let model = SteeringModel {
            wheelbase_m: around(WHEELBASE_M, wheelbase),
            rad_per_tick: draw.size(1e-5, 0.01),
            zero_rad: Interval::centred(0.0, zero_rad),
            scale: around(1.0, scale),
            rate_rad_per_s,
            slip_share,
            slip_rad_per_m: aside,
            slip_floor_rad: 0.0,
        };
        let ticks_per_turn = draw.size(50.0, 1e6);
        let wheels = WheelModel { radius_m: [around(0.1, radius); 2], ticks_per_turn, slip_ratio, ..exact() };
        let (true_wheelbase_m, true_zero_rad) = (draw.within(model.wheelbase_m), draw.within(model.zero_rad));
        let (true_scale, true_radius_m) = (draw.within(model.scale), wheels.radius_m.map(|radius| draw.within(radius)));
        let [slips, turns_aside, shares] =
            [slip_ratio, aside, slip_share].map(|most| draw.within(Interval::centred(0.0, most)));
        let mut history = WheelHistory::new(100.0).with_steering(model);

        const DENSE_S: f64 = 5e-5;
        let period = [100, 200, 280][(draw.unit() * 2.99) as usize];
        let (mut angle_rad, mut speed_m_per_s) = (draw.between(-0.5, 0.5), draw.between(-1.0, 1.0));
        let (mut steers, mut gathers, mut heading_rad, mut wheel_rad) = (0.0, 0.0, 0.0, [draw.unit(); 2]);
        let (mut headings_rad, mut late) = (Vec::new(), Vec::new());
        for step in 0..=20_000 {
            if step % period == 0 {
                let read = ((true_scale * angle_rad + true_zero_rad) / model.rad_per_tick).round();
                let stamp_s = DENSE_S * f64::from(step);
                match (draw.unit() * 10.0) as usize {
                    0 => {}
                    1 => late.push((stamp_s, read)),
                    _ => assert_eq!(history.push_steering(stamp_s, read), Some(true)),
                }
            }
            if step % 200 == 0 {
                let ticks = wheel_rad.map(|rad| (rad / TAU * ticks_per_turn).floor() as i64);
                history.push(DENSE_S * f64::from(step), ticks);
                headings_rad.push(heading_rad);
            }
            // Changes at the middles of the periods make the steering go away and back between two readings.
            if step % (period / 2) == 0 && draw.unit() < 0.8 {
                steers = [-1.0, 0.0, 1.0][(draw.unit() * 2.99) as usize] * rate_rad_per_s;
            }
            if step % 100 == 0 && draw.unit() < 0.3 {
                gathers = [-1.0, 0.0, 1.0][(draw.unit() * 2.99) as usize] * acceleration_m_per_s2;
            }
            if (angle_rad + steers * DENSE_S).abs() > 0.8 {
                steers = -steers;
            }
            let travel_m = (speed_m_per_s + 0.5 * gathers * DENSE_S) * DENSE_S;
            let rolled_m = travel_m / (1.0 + slips * travel_m.signum());
            let turn_rad = travel_m * (angle_rad + 0.5 * steers * DENSE_S).tan() / true_wheelbase_m;
            heading_rad += turn_rad + shares * turn_rad.abs() + turns_aside * rolled_m.abs();
            (0..2).for_each(|wheel| wheel_rad[wheel] += rolled_m / true_radius_m[wheel]);
            angle_rad += steers * DENSE_S;
            speed_m_per_s += gathers * DENSE_S;
        }
        late.into_iter().for_each(|(stamp_s, read)| assert_eq!(history.push_steering(stamp_s, read), Some(true)));
        Drive { history, model, wheels, acceleration_m_per_s2, headings_rad }
    }
}

/// Three hundred drives, forth and back, with the steering at its rate, and with readings that are missing or late.
#[test]
fn the_turn_of_any_drive_is_enclosed() {
    let mut draw = Draw(ChaCha8Rng::seed_from_u64(21));
    let (mut n_checked, mut nearest) = (0, 0.0_f64);
    for drive_idx in 0..300 {
        let drive = Drive::new(&mut draw);
        for _ in 0..12 {
            let from = (draw.unit() * 99.0) as usize;
            let to = from + 1 + (draw.unit() * (99 - from) as f64) as usize;
            let stamps_s = [from, to].map(|idx| 0.01 * idx as f64);
            let motion =
                drive.history.motion(stamps_s[0], stamps_s[1], &drive.wheels, &reach(drive.acceleration_m_per_s2));
            let turn = motion.expect("in the history")[2];
            let truly_rad = drive.headings_rad[to] - drive.headings_rad[from];
            // The integral over steps of 50 µs is off by less than a microradian.
            assert!(
                turn.inflate(1e-6).contains(truly_rad),
                "{drive_idx}: {turn} without {truly_rad}, {:?}",
                drive.model
            );
            n_checked += 1;
            nearest = nearest.max((truly_rad - turn.mid()).abs() / turn.radius());
        }
    }
    assert!(n_checked == 3600 && nearest > 0.8, "the farthest truth was at {nearest} of the way to the end");
}
