//! Readings of wheels and gyroscope from the messages of a log.

use std::f64::consts::{PI, TAU};

use interval::Interval;
use localizer::{
    Pose, Reading,
    motion::SlipExcess,
    robot::{ErrorLaw, WheelModel},
};

use super::gathered::{Gathered, Stamped};
use crate::scene::{Log, OdometryLaw, Scene};

/// Radius of the wheels that stand for odometry, and the ticks in a turn of theirs: a tick is a way of a micrometre, as nothing beside any error of
/// odometry.
const ODOMETRY_WHEEL: (f64, u32) = (0.1, 628_318);
/// Way and turn by which two readings of wheels may differ beyond what the robot's speeds allow, before they count as a jump: stamps of readings are
/// off by some milliseconds.
const JUMP_SLACK: (f64, f64) = (0.05, 0.05);
/// Number of usual periods without a reading of the gyroscope from which on the time between is left without turn rates.
const PERIODS_OF_A_HOLE: f64 = 2.5;

/// What wheels and gyroscope read, in the order of stamps.
#[derive(Clone, Debug, Default)]
pub(super) struct Motion {
    pub(super) readings: Vec<Reading>,
    /// Spans in which the ways that were read are not relied on.
    pub(super) excesses: Vec<SlipExcess>,
    /// Spans in which the readings jump by more than the robot can move.
    pub(super) jumps_s: Vec<[f64; 2]>,
    /// Sum of the magnitudes of the sideways ways that odometry counts. A differential drive has none.
    pub(super) aside_m: f64,
}

/// Ways of both wheels since the first reading, at one stamp.
type Ways = (f64, [f64; 2]);

/// The robot as the localizer is told it: where the wheels' ways come from odometry, its wheels stand for the odometry, and the gyroscope's period is
/// that of the log.
pub(super) fn told(scene: &Scene, keys: &Log, gathered: &Gathered) -> Scene {
    let mut told = scene.clone();
    if !gathered.odometry.is_empty() {
        let base = &mut told.robot.base;
        (base.wheel_radius_m, told.robot.encoders.ticks_per_turn) = ODOMETRY_WHEEL;
        if let Some(law) = &keys.odometry {
            base.wheel_radius_tolerance = 0.0;
            rely_on_law(&mut told, law);
        }
    }
    if let (Some(gyro), Some(period_s)) = (&mut told.robot.gyro, period_s(&gathered.rates)) {
        gyro.period_s = period_s;
    }
    told
}

/// Replaces the declared bounds on the slip of the wheels by ones that the law of the odometry's error implies: wheels whose slip is within them can
/// make every error of the odometry that the law allows.
fn rely_on_law(told: &mut Scene, law: &OdometryLaw) {
    let along = ErrorLaw { floor_m: law.floor_m, share: law.share, m_per_s: law.m_per_s };
    let aside = ErrorLaw { floor_m: law.aside_floor_m, share: law.aside_share, m_per_s: law.aside_m_per_s };
    let wheels = WheelModel::of_odometry(Interval::point(told.robot.base.track_m), along, aside);
    let bounds = &mut told.bounds;
    bounds.slip_ratio = wheels.slip_ratio;
    bounds.slip_floor_m = wheels.slip_floor_m;
    bounds.side_slip_ratio = wheels.side_slip_ratio;
    bounds.side_slip_floor_m = wheels.side_slip_floor_m;
    bounds.slip_window_s = wheels.slip_window_s;
}

impl Motion {
    /// The readings of wheels and gyroscope, with times since the stamp `zero_ns`. `told` is the robot as the localizer is told it.
    pub(super) fn of(gathered: &Gathered, zero_ns: i64, told: &Scene, keys: &Log) -> Motion {
        let mut motion = Motion::default();
        let since_s = |stamp_ns: i64| stamp_ns.saturating_sub(zero_ns) as f64 * 1e-9;
        let ways = if gathered.odometry.is_empty() {
            let metres_per_rad = told.robot.base.wheel_radius_m;
            let angles =
                gathered.joints.iter().map(|one| (since_s(one.stamp_ns), one.value.map(|rad| rad * metres_per_rad)));
            motion.without_jumps(&angles.collect::<Vec<_>>(), told, f64::INFINITY)
        } else {
            let poses: Vec<(f64, Pose)> =
                gathered.odometry.iter().map(|one| (since_s(one.stamp_ns), one.value)).collect();
            let ways = motion.ways_of_poses(&poses, told.robot.base.track_m);
            motion.without_jumps(&ways, told, keys.longest_gap_s)
        };
        let tick_m = tick_m(told);
        // A count is the nearest tick: it is exact where the log has whole ticks, and off by at most half a tick where it does not.
        let wheels = ways.into_iter().map(|(at_s, ways_m)| Reading::Wheels {
            measured_s: at_s,
            arrived_s: at_s,
            ticks: ways_m.map(|way_m| (way_m / tick_m).round() as i64),
        });
        let rates: Vec<(f64, f64)> = gathered.rates.iter().map(|one| (since_s(one.stamp_ns), one.value)).collect();
        let rates = match &told.robot.gyro {
            Some(gyro) => even_rates(&rates, gyro.period_s),
            None => Vec::new(),
        };
        let gyro = rates.into_iter().map(|(at_s, rate_rad_per_s)| Reading::Gyro {
            measured_s: at_s,
            arrived_s: at_s,
            rate_rad_per_s,
        });
        // Of readings with one stamp the gyroscope's comes first, as it says how the wheels' way up to there was bent.
        motion.readings = gyro.chain(wheels).collect();
        motion.readings.sort_by(|one, other| one.measured_s().total_cmp(&other.measured_s()));
        motion
    }

    /// The ways of two wheels at the distance `track_m` that go from one pose of odometry to the next on an arc.
    ///
    /// An arc of the angle θ with the chord c is c·(θ/2)/sin(θ/2) long; it leaves the chord's direction on both sides by θ/2.
    fn ways_of_poses(&mut self, poses: &[(f64, Pose)], track_m: f64) -> Vec<Ways> {
        let mut ways_m = [0.0; 2];
        let mut all = Vec::with_capacity(poses.len());
        all.extend(poses.first().map(|(at_s, _)| (*at_s, ways_m)));
        for pair in poses.windows(2) {
            let [(_, before), (at_s, after)] = [pair[0], pair[1]];
            let turn_rad = (after.heading_rad - before.heading_rad + PI).rem_euclid(TAU) - PI;
            let half_rad = 0.5 * turn_rad;
            let (sin, cos) = (before.heading_rad + half_rad).sin_cos();
            let [dx_m, dy_m] = [after.x_m - before.x_m, after.y_m - before.y_m];
            let chord_m = cos * dx_m + sin * dy_m;
            self.aside_m += (cos * dy_m - sin * dx_m).abs();
            let arc_m = if half_rad.abs() < 1e-6 { chord_m } else { chord_m * half_rad / half_rad.sin() };
            ways_m =
                [ways_m[0] - 0.5 * track_m * turn_rad, ways_m[1] + 0.5 * track_m * turn_rad].map(|way_m| way_m + arc_m);
            all.push((at_s, ways_m));
        }
        all
    }

    /// The ways since the first reading with the jumps taken out: where a counter or an odometry began anew. In a jump the wheels are taken to go on
    /// at their rate before, as far as their greatest acceleration tells. In a span longer than `longest_gap_s` the ways are not relied on: there the
    /// robot may move as fast as its limits allow.
    fn without_jumps(&mut self, ways: &[Ways], told: &Scene, longest_gap_s: f64) -> Vec<Ways> {
        let (bounds, track_m) = (&told.bounds, told.robot.base.track_m);
        let (speed_m_per_s, turn_rad_per_s) = (bounds.reach_speed_m_per_s, bounds.reach_turn_rate_rad_per_s);
        let tick_m = tick_m(told);
        let mut total_m = [0.0; 2];
        // The step before, as its length in time and the ways in it.
        let mut before: Option<Ways> = None;
        let mut all = Vec::with_capacity(ways.len());
        all.extend(ways.first().map(|(at_s, _)| (*at_s, total_m)));
        for pair in ways.windows(2) {
            let [(from_s, from_m), (to_s, to_m)] = [pair[0], pair[1]];
            let mut step_m = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
            let span_s = to_s - from_s;
            let (way_m, turn_rad) = (0.5 * (step_m[0] + step_m[1]), (step_m[1] - step_m[0]) / track_m);
            let jumps = way_m.abs() > speed_m_per_s * span_s + JUMP_SLACK.0
                || turn_rad.abs() > turn_rad_per_s * span_s + JUMP_SLACK.1;
            // In the span each wheel goes at most this far, and what was counted for it goes at most as far the other way.
            let farthest_m = (speed_m_per_s + 0.5 * track_m * turn_rad_per_s) * span_s;
            let mut excess =
                SlipExcess { span_s: [from_s, to_s], slip_m: 2.0 * farthest_m, side_slip_m: speed_m_per_s * span_s };
            if jumps {
                self.jumps_s.push([from_s, to_s]);
                step_m = [0.0; 2];
                if let Some((before_s, before_m)) = before {
                    // The rate of a wheel departs from its mean in the step before by at most the acceleration times both steps' lengths; that mean
                    // is known to a tick.
                    let changed_m = bounds.reach_acceleration_m_per_s2 * (before_s + span_s) * span_s;
                    let off_m = changed_m + tick_m * span_s / before_s;
                    if off_m < excess.slip_m {
                        step_m = before_m.map(|way_m| way_m * span_s / before_s);
                        excess = SlipExcess { slip_m: off_m, side_slip_m: 0.0, ..excess };
                    }
                }
            }
            total_m = [total_m[0] + step_m[0], total_m[1] + step_m[1]];
            if jumps || span_s > longest_gap_s {
                self.excesses.push(excess);
            }
            before = (!jumps && span_s > 0.0).then_some((span_s, step_m));
            all.push((to_s, total_m));
        }
        all
    }
}

/// Way of a wheel in one tick, by its nominal radius.
pub(super) fn tick_m(told: &Scene) -> f64 {
    TAU * told.robot.base.wheel_radius_m / f64::from(told.robot.encoders.ticks_per_turn)
}

/// Usual time between two readings.
fn period_s<T>(values: &[Stamped<T>]) -> Option<f64> {
    let mut periods_ns: Vec<i64> =
        values.windows(2).map(|pair| pair[1].stamp_ns.saturating_sub(pair[0].stamp_ns)).collect();
    periods_ns.sort_unstable();
    periods_ns.get(periods_ns.len() / 2).map(|period_ns| *period_ns as f64 * 1e-9)
}

/// Turn rates at even times: each is the mean since the time before, by readings that each count for the time since the reading before.
///
/// The stamps of a log are some milliseconds off, now more and now less, while the sensor itself is even. Taken at even times the readings have no
/// gaps and no overlaps; the angle that they add up to stays the same but for what the rate changes within the error of a stamp. Where readings are
/// missing for longer than some periods there are none at even times either.
fn even_rates(rates: &[(f64, f64)], period_s: f64) -> Vec<(f64, f64)> {
    let mut even = Vec::with_capacity(rates.len());
    for stretch in rates.chunk_by(|one, next| next.0 - one.0 <= PERIODS_OF_A_HOLE * period_s) {
        let Some(&(first_s, first)) = stretch.first() else { continue };
        even.push((first_s, first));
        let (mut angle_rad, mut before_rad, mut n_even) = (0.0, 0.0, 1_u64);
        for pair in stretch.windows(2) {
            let [(from_s, _), (to_s, rate)] = [pair[0], pair[1]];
            loop {
                let at_s = first_s + n_even as f64 * period_s;
                // A billionth of a period keeps rounding from moving the last even time of a stretch beyond its end.
                if at_s > to_s + 1e-9 * period_s {
                    break;
                }
                let at_rad = angle_rad + rate * (at_s - from_s);
                even.push((at_s, (at_rad - before_rad) / period_s));
                before_rad = at_rad;
                n_even += 1;
            }
            angle_rad += rate * (to_s - from_s);
        }
    }
    even
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn pose(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
        Pose { x_m, y_m, heading_rad }
    }

    #[test]
    fn poses_on_a_circle_give_the_ways_of_its_two_wheels() {
        // A quarter of a circle with the radius 2 m about (0, 2), to the left, by wheels that are 1 m apart: they go a quarter of circles with the
        // radii 1.5 m and 2.5 m.
        let poses: Vec<(f64, Pose)> = (0..=3)
            .map(|step| {
                let angle_rad = f64::from(step) * PI / 6.0;
                (f64::from(step), pose(2.0 * angle_rad.sin(), 2.0 - 2.0 * angle_rad.cos(), angle_rad))
            })
            .collect();
        let mut motion = Motion::default();
        let (_, ways_m) = *motion.ways_of_poses(&poses, 1.0).last().unwrap();
        assert!((ways_m[0] - 1.5 * PI / 2.0).abs() < 1e-12 && (ways_m[1] - 2.5 * PI / 2.0).abs() < 1e-12, "{ways_m:?}");
        assert!(motion.aside_m < 1e-12, "{}", motion.aside_m);
    }

    #[test]
    fn a_heading_that_passes_half_a_turn_goes_on_the_short_way() {
        let poses = [(0.0, pose(0.0, 0.0, PI - 0.1)), (1.0, pose(0.0, 0.0, 0.1 - PI))];
        let (_, ways_m) = Motion::default().ways_of_poses(&poses, 1.0)[1];
        assert!((ways_m[0] + 0.1).abs() < 1e-12 && (ways_m[1] - 0.1).abs() < 1e-12, "{ways_m:?}");
    }

    #[test]
    fn uneven_stamps_keep_the_angle_and_lose_their_holes() {
        // Five readings with a period of 0.1 s whose stamps are off by up to 20 ms, and a rate that grows; then nothing for 1 s.
        let rates = [(0.0, 1.0), (0.12, 2.0), (0.19, 3.0), (0.3, 4.0), (0.4, 5.0), (1.4, 6.0)];
        let even = even_rates(&rates, 0.1);
        let stamps: Vec<f64> = even.iter().map(|(at_s, _)| (at_s * 1e6).round() / 1e6).collect();
        assert_eq!(stamps, [0.0, 0.1, 0.2, 0.3, 0.4, 1.4]);
        // Angle from 0 to 0.4 s by hand: 0.12·2 + 0.07·3 + 0.11·4 + 0.1·5 = 1.39 rad.
        let angle_rad: f64 = even[1..5].iter().map(|(_, rate)| rate * 0.1).sum();
        assert!((angle_rad - 1.39).abs() < 1e-12, "{angle_rad}");
        // From 0.1 to 0.2 s: 0.02·2 + 0.07·3 + 0.01·4 = 0.29 rad.
        assert!((even[2].1 - 2.9).abs() < 1e-9, "{even:?}");
    }

    #[test]
    fn a_counter_that_begins_anew_is_a_jump_and_its_span_is_not_relied_on() {
        let scene = Scene::parse(
            "room = { width_m = 5.0, depth_m = 5.0 }\nstart = { x_m = 2.0, y_m = 2.0, heading_deg = 0.0 }\n[log]\n[localizer]\nmethods = []\n",
            "x.toml",
        )
        .unwrap();
        let ways = [(0.0, [3.0, 3.0]), (0.1, [3.02, 3.02]), (0.2, [0.0, 0.0]), (0.3, [0.02, 0.02])];
        let mut motion = Motion::default();
        let kept = motion.without_jumps(&ways, &scene, f64::INFINITY);
        // In the jump the wheels go on by 2 cm; they may have changed their rate by the acceleration over 0.2 s, for 0.1 s.
        assert!((kept[3].1[0] - 0.06).abs() < 1e-12, "{kept:?}");
        assert_eq!(motion.jumps_s, [[0.1, 0.2]]);
        let changed_m = scene.bounds.reach_acceleration_m_per_s2 * 0.2 * 0.1;
        assert!((motion.excesses[0].slip_m - changed_m).abs() < 1e-4 && motion.excesses[0].slip_m > changed_m);
        // Nothing is known of the rate before where the first step is a jump.
        let mut motion = Motion::default();
        motion.without_jumps(&ways[1..], &scene, f64::INFINITY);
        assert!(motion.excesses[0].slip_m >= 2.0 * 0.1 * scene.bounds.reach_speed_m_per_s);
    }

    /// A robot whose log has odometry.
    fn logged() -> Scene {
        let text = "room = { width_m = 5.0, depth_m = 5.0 }\nstart = { x_m = 2.0, y_m = 2.0, heading_deg = 0.0 }\n\
                    [log]\nlongest_gap_s = 1.0\n[localizer]\nmethods = []\n";
        Scene::parse(text, "x.toml").unwrap()
    }

    /// What is made of odometry with these poses, each with its time in tenths of a second.
    fn of_odometry(poses: &[(i64, Pose)]) -> Motion {
        let scene = logged();
        let odometry = poses.iter().map(|(tenths, value)| {
            let stamp_ns = tenths * 100_000_000;
            Stamped { stamp_ns, logged_ns: stamp_ns, number: 0, value: *value }
        });
        let mut gathered = Gathered::default();
        gathered.odometry = odometry.collect();
        let keys = scene.log.clone().unwrap();
        Motion::of(&gathered, 0, &told(&scene, &keys, &gathered), &keys)
    }

    #[test]
    fn a_heading_that_begins_anew_is_a_jump() {
        let motion = of_odometry(&[(0, pose(0.0, 0.0, 2.0)), (1, pose(0.0, 0.0, 2.0)), (2, pose(0.0, 0.0, 0.0))]);
        assert_eq!(motion.jumps_s, [[0.1, 0.2]]);
        // The robot stood, and so it is taken to stand on.
        let all_ticks: Vec<[i64; 2]> = motion
            .readings
            .iter()
            .filter_map(|reading| if let Reading::Wheels { ticks, .. } = reading { Some(*ticks) } else { None })
            .collect();
        assert_eq!(all_ticks, [[0; 2]; 3]);
    }

    #[test]
    fn odometry_is_not_relied_on_in_its_gaps() {
        let motion = of_odometry(&[(0, pose(0.0, 0.0, 0.0)), (10, pose(0.1, 0.0, 0.0)), (40, pose(0.2, 0.0, 0.0))]);
        assert!(motion.jumps_s.is_empty(), "{:?}", motion.jumps_s);
        // In the 3 s each wheel can have gone to the limit of speed and turn rate in one direction, with the odometry's count in the other.
        let scene = logged();
        let bounds = &scene.bounds;
        let wheel_m_per_s =
            bounds.reach_speed_m_per_s + 0.5 * scene.robot.base.track_m * bounds.reach_turn_rate_rad_per_s;
        let [excess] = motion.excesses.as_slice() else { panic!("{:?}", motion.excesses) };
        assert_eq!(excess.span_s, [1.0, 4.0]);
        assert!((excess.slip_m - 6.0 * wheel_m_per_s).abs() < 1e-9, "{}", excess.slip_m);
        assert!((excess.side_slip_m - 3.0 * bounds.reach_speed_m_per_s).abs() < 1e-9, "{}", excess.side_slip_m);
    }
}
