//! How far the robot can have gone between a stamp and an instant near it, such as the true instant of a reading whose stamp is not exact.

use crate::robot::{Reach, WheelModel};

use super::{
    WheelHistory,
    gyro::greatest_change_rad_per_s2,
    integral::{KnownTurns, WheelIntegral},
};

/// Greatest number of wheel readings on either side of the stamp by which a speed is told: the more there are, the less the counting matters, and the
/// more the speed can have changed.
const MOST_ASIDE: usize = 10;
/// Factor that makes up for the few roundings of a sum of positive terms.
const ABOVE: f64 = 1.0 + 1e-12;

impl WheelHistory {
    /// Greatest turn of the robot, by the gyroscope, between a stamp and any instant that is at most `within_s` away from it; `None` without a
    /// gyroscope.
    ///
    /// With the change of the turn rate bounded by α, the heading between two instants a time T apart departs from the chord by at most α·T²/8. For a
    /// short time the rate at which the robot turned around it tells more, as the constant part of the gyroscope's error counts once for any span.
    pub fn greatest_turn_about(&self, stamp_s: f64, within_s: f64, wheels: &WheelModel, reach: &Reach) -> Option<f64> {
        let before = self.gyro_turn(stamp_s - within_s, stamp_s, wheels, reach)?;
        let after = self.gyro_turn(stamp_s, stamp_s + within_s, wheels, reach)?;
        let change_rad_per_s2 = greatest_change_rad_per_s2(wheels, reach);
        let bend_rad = change_rad_per_s2 * within_s * within_s / 8.0;
        let directly_rad = before.magnitude().max(after.magnitude()) + bend_rad;
        let around_s = [stamp_s - within_s, stamp_s + within_s];
        let period_s = self.gyro.as_ref()?.period_s();
        let by_rate_over = |aside: usize| {
            let aside_s = aside as f64 * period_s;
            let span_s = [around_s[0] - aside_s, around_s[1] + aside_s];
            let turn_rad = self.gyro_turn(span_s[0], span_s[1], wheels, reach)?.magnitude();
            Some(
                within_s
                    * (turn_rad / (span_s[1] - span_s[0]) + greatest_departure(around_s, span_s, change_rad_per_s2)),
            )
        };
        let by_rate = (1..=MOST_ASIDE).filter_map(by_rate_over);
        Some(by_rate.fold(directly_rad, f64::min) * ABOVE)
    }

    /// Greatest distance, by the wheels, between the robot's position at a stamp and that at any instant that is at most `within_s` away from it;
    /// `None` where the wheel readings in memory do not surround these instants. Spans of time for which `is_believed` says no tell nothing.
    ///
    /// The axle's middle travels no farther than its greatest speed allows, and slips aside by what is declared. As the side slip acts along the
    /// heading of each moment, it counts once more for the turn in that time, by summation by parts.
    pub fn greatest_travel_about(
        &self,
        stamp_s: f64,
        within_s: f64,
        wheels: &WheelModel,
        reach: &Reach,
        is_believed: &dyn Fn([f64; 2]) -> bool,
    ) -> Option<f64> {
        let around_s = [stamp_s - within_s, stamp_s + within_s];
        let travel_m = within_s * self.greatest_speed_over(around_s, wheels, reach, is_believed)?;
        let wheels = &*self.model_over(around_s, wheels);
        let rolled_m = (travel_m + wheels.slip_floor_m) / (1.0 - wheels.slip_ratio).max(0.0);
        let aside_m = wheels.side_slip_ratio * rolled_m + wheels.windows(within_s) * wheels.side_slip_floor_m;
        Some((travel_m + aside_m * (1.0 + reach.turn_rate_rad_per_s * within_s)) * ABOVE)
    }

    /// Greatest speed of the axle's middle at any instant of a span, by the wheel readings around it.
    ///
    /// Over two readings the mean speed is known; the least bound over pairs of readings around the span is taken.
    fn greatest_speed_over(
        &self,
        [from_s, to_s]: [f64; 2],
        wheels: &WheelModel,
        reach: &Reach,
        is_believed: &dyn Fn([f64; 2]) -> bool,
    ) -> Option<f64> {
        let last_before = self.samples.partition_point(|sample| sample.time_s <= from_s).checked_sub(1)?;
        let first_after = self.samples.partition_point(|sample| sample.time_s < to_s);
        let by_readings = |aside: usize| {
            let (first, last) = (last_before.checked_sub(aside)?, first_after + aside);
            let (start, end) = (self.samples.get(first)?, self.samples.get(last)?);
            let (span_s, known_s) = (end.time_s - start.time_s, [start.time_s, end.time_s]);
            if !is_believed(known_s) {
                return None;
            }
            let wheels = &*self.model_over(known_s, wheels);
            let mut integral = WheelIntegral::new(*start);
            let later = self.samples.range(first + 1..=last);
            later.for_each(|sample| integral.advance(sample, KnownTurns::default(), wheels, reach));
            let change = greatest_departure([from_s, to_s], known_s, reach.acceleration_m_per_s2);
            (span_s > 0.0).then(|| integral.travel_of_middle(wheels).magnitude() / span_s + change)
        };
        (0..MOST_ASIDE).map_while(by_readings).reduce(f64::min)
    }
}

/// Greatest departure of a rate, at any instant of a span, from its mean over a longer span around that one, where the rate changes by at most
/// `change` in a second.
///
/// At the instant t the rate departs from its mean from p to q by at most (a/(q − p))·∫ |t − s| ds = a·((t − p)² + (q − t)²)/(2(q − p)), with the
/// greatest change a.
fn greatest_departure([from_s, to_s]: [f64; 2], [p_s, q_s]: [f64; 2], change: f64) -> f64 {
    let uneven_s2 = |at_s: f64| (at_s - p_s).powi(2) + (q_s - at_s).powi(2);
    change * uneven_s2(from_s).max(uneven_s2(to_s)) / (2.0 * (q_s - p_s))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::Interval;

    use super::*;
    use crate::graph::trial::{Draw, gyro, reach, rounds, wheels};

    /// Wheel readings of a robot that drives straight ahead, with its speed greatest or least at the instant 0.
    struct Straight {
        /// Speed at the instant 0, and what it changes by per second of distance from it.
        speed_m_per_s: [f64; 2],
        /// Position along the way and to the side, over the time.
        metres_per_tick: f64,
        slip_ratio: f64,
    }

    impl Straight {
        /// True travel since the instant 0.
        fn travel_m(&self, at_s: f64) -> f64 {
            let [speed, change] = self.speed_m_per_s;
            speed * at_s + 0.5 * change * at_s * at_s.abs()
        }

        fn history(&self, period_s: f64, phase_s: f64) -> WheelHistory {
            let mut history = WheelHistory::new(60.0);
            for step in -40..=40_i32 {
                let at_s = phase_s + period_s * f64::from(step);
                let rolled_m = self.travel_m(at_s) / (1.0 + self.slip_ratio);
                history.push(at_s, [(rolled_m / self.metres_per_tick).floor() as i64; 2]);
            }
            history
        }
    }

    #[test]
    fn no_true_distance_is_greater_whatever_the_course_of_speed() {
        let mut draw = Draw::new(20_261_128);
        let wheels = WheelModel { side_slip_ratio: 0.0, side_slip_floor_m: 0.0, ..wheels() };
        let reach = Reach { acceleration_m_per_s2: 1.5, ..reach() };
        let mut nearest = 0.0_f64;
        for round in 0..rounds(4000) {
            let change = draw.within(Interval::centred(0.0, 1.5));
            let drive = Straight {
                speed_m_per_s: [draw.between(-1.0, 1.0), change],
                metres_per_tick: draw.within(wheels.metres_per_tick(0)),
                slip_ratio: draw.within(Interval::centred(0.0, wheels.slip_ratio)),
            };
            let period_s = draw.size(0.005, 0.05);
            let history = drive.history(period_s, draw.between(0.0, period_s));
            let within_s = draw.size(1e-4, 0.05);
            let stamp_s = draw.between(-0.05, 0.05);
            let greatest_m = history.greatest_travel_about(stamp_s, within_s, &wheels, &reach, &|_| true).unwrap();
            let gone_m = |at_s: f64| (drive.travel_m(at_s) - drive.travel_m(stamp_s)).abs();
            let truly_m = gone_m(stamp_s - within_s).max(gone_m(stamp_s + within_s));
            assert!(truly_m <= greatest_m, "round {round}: {truly_m} of {greatest_m}");
            nearest = nearest.max(truly_m / greatest_m);
        }
        // The bound is no idle one: what it takes for possible comes close to happening.
        assert!(nearest > 0.95, "{nearest}");
    }

    #[test]
    fn no_true_turn_is_greater_whatever_the_course_of_the_turn_rate() {
        let mut draw = Draw::new(20_261_129);
        let (wheels, reach) = (wheels(), reach());
        let most_change = greatest_change_rad_per_s2(&wheels, &reach);
        let mut nearest = 0.0_f64;
        for round in 0..rounds(2000) {
            let model = gyro(draw.unit() < 0.5);
            let (rate, change) = (draw.between(-2.0, 2.0), draw.within(Interval::centred(0.0, most_change)));
            let turned_rad = |at_s: f64| rate * at_s + 0.5 * change * at_s * at_s.abs();
            let (bias, scale) = (draw.within(model.bias_rad_per_s), draw.within(model.scale));
            let mut history = WheelHistory::new(60.0).with_gyro(model);
            let phase_s = draw.between(0.0, model.period_s);
            // The error of the angle wanders within its constant part, by no more than the noise in each reading.
            let mut error_rad = 0.0_f64;
            for step in -20..=20_i32 {
                let [from_s, to_s] = [step - 1, step].map(|step| phase_s + model.period_s * f64::from(step));
                let noise = draw.within(Interval::centred(0.0, model.noise_rad_per_s * model.period_s));
                let half_rad = 0.5 * model.angle_floor_rad;
                let next_rad = (error_rad + noise).clamp(-half_rad, half_rad);
                let sum_rad =
                    scale * (turned_rad(to_s) - turned_rad(from_s)) + bias * model.period_s + next_rad - error_rad;
                error_rad = next_rad;
                history.push_rate(to_s, sum_rad / model.period_s);
            }
            let within_s = draw.size(1e-4, 0.05);
            let stamp_s = draw.between(-0.05, 0.05);
            let greatest_rad = history.greatest_turn_about(stamp_s, within_s, &wheels, &reach).unwrap();
            let turn_rad = |at_s: f64| (turned_rad(at_s) - turned_rad(stamp_s)).abs();
            let truly_rad = turn_rad(stamp_s - within_s).max(turn_rad(stamp_s + within_s));
            assert!(truly_rad <= greatest_rad, "round {round}: {truly_rad} of {greatest_rad}");
            nearest = nearest.max(truly_rad / greatest_rad);
        }
        assert!(nearest > 0.95, "{nearest}");
    }

    #[test]
    fn for_a_short_time_the_constant_part_of_the_angle_error_is_shared_out() {
        let (wheels, reach) = (wheels(), reach());
        let mut history = WheelHistory::new(60.0).with_gyro(gyro(true));
        (-20..=20_i32).for_each(|step| {
            history.push_rate(0.01 * f64::from(step), 0.001);
        });
        // The robot goes straight ahead. 0.4 mrad may be the error of any span; over 20 ms it is one of 20 mrad/s, and the rate changes by some 9.3
        // rad/s² over 5 ms on average.
        let turn_rad = history.greatest_turn_about(0.0, 0.0005, &wheels, &reach).unwrap();
        assert!((0.0005 * 0.05..0.0005 * 0.13).contains(&turn_rad), "{turn_rad}");
    }

    #[test]
    fn side_slip_and_the_turn_meanwhile_count_and_readings_must_surround_the_stamp() {
        let history = Straight { speed_m_per_s: [0.2, 0.0], metres_per_tick: 1e-4, slip_ratio: 0.0 }.history(0.01, 0.0);
        let wheels =
            WheelModel { radius_m: [Interval::point(0.05); 2], ticks_per_turn: 3_141.592_653_589_793, ..wheels() };
        let ahead_m =
            |wheels: &WheelModel| history.greatest_travel_about(0.003, 0.0005, wheels, &reach(), &|_| true).unwrap();
        let straight_m = ahead_m(&WheelModel { side_slip_ratio: 0.0, side_slip_floor_m: 0.0, ..wheels.clone() });
        // By hand, over readings 10, 30, … 210 ms apart: a tick, 2 % and 0.2 mm, for example over 30 ms 6 mm and 0.1 + 0.122 + 0.2 mm, and 1.53 m/s²
        // times 8 ms; the least is near 0.225 m/s.
        assert!((0.0005 * 0.22..0.0005 * 0.235).contains(&straight_m), "{straight_m}");
        // The side slip is 0.2 mm and 2 % of what is rolled, and is turned by 2 mrad.
        let aside_m = ahead_m(&wheels) - straight_m;
        assert!((aside_m - 0.0002 - 0.02 * 0.000_32).abs() < 1e-6 && aside_m > 0.000_206, "{aside_m}");
        let at = |stamp_s: f64| history.greatest_travel_about(stamp_s, 0.0005, &wheels, &reach(), &|_| true);
        assert!(at(0.3999).is_none() && at(-0.3999).is_none() && at(0.3994).is_some());
        // Where only the readings from 0 s on are believed, those over 10 ms tell: a tick, 2 % and 0.2 mm of 2 mm, and what the speed changes by.
        let since_0 = |[from_s, _]: [f64; 2]| from_s >= -1e-9;
        let late_m = history.greatest_travel_about(0.003, 0.0005, &wheels, &reach(), &since_0).unwrap();
        assert!(late_m > straight_m + aside_m + 0.0005 * 0.01, "{late_m}");
        assert!(history.greatest_travel_about(0.003, 0.0005, &wheels, &reach(), &|_| false).is_none());
    }
}
