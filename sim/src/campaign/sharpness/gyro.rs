//! Gyroscope readings: scale, bias, the noise of each reading, and the angle that the noise adds up to over any span.

use interval::Interval;
use localizer::{bounds, robot::GyroModel};

use super::{
    history::{History, Quantity},
    kind::{Broken, Declared, Kind, Linearised, demand, within},
};

/// One gyroscope reading: the mean turn rate between two stamps.
pub(super) struct TurnRate {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) rate_rad_per_s: f64,
}

/// All gyroscope readings that have arrived by an instant.
///
/// Where the bias wanders, the history's bias is the constant one from which errors count for the angle that they add up to. The bias at each reading is
/// then any within its bounds that changes no faster than declared.
pub(super) struct Gyro {
    pub(super) readings: Vec<TurnRate>,
    pub(super) model: GyroModel,
}

impl Gyro {
    /// The error of a reading beyond scale and bias.
    fn noise_rad_per_s(&self, history: &History, reading: &TurnRate) -> Interval {
        let heading = |stamp: usize| Interval::point(history.poses[stamp].heading_rad);
        let turned_rad = heading(reading.to) - heading(reading.from);
        let true_rad_per_s = turned_rad / span_s(history, reading);
        Interval::point(reading.rate_rad_per_s)
            - Interval::point(history.value(Quantity::GyroScale)) * true_rad_per_s
            - Interval::point(history.value(Quantity::GyroBias))
    }

    /// Sum of the readings' errors up to each reading's end, as an angle.
    fn angles_rad(&self, history: &History) -> Vec<Interval> {
        let mut sum = Interval::ZERO;
        let errors = self.readings.iter().map(|reading| {
            sum += self.noise_rad_per_s(history, reading) * span_s(history, reading);
            sum
        });
        errors.collect()
    }
}

fn span_s(history: &History, reading: &TurnRate) -> Interval {
    Interval::point(history.stamps_s[reading.to]) - Interval::point(history.stamps_s[reading.from])
}

impl Kind for Gyro {
    fn declared(&self, _history: &History) -> Vec<Declared> {
        let model = &self.model;
        vec![
            Declared { quantity: Quantity::GyroBias, interval: model.bias_rad_per_s, bound: bounds::GYRO_BIAS },
            Declared { quantity: Quantity::GyroScale, interval: model.scale, bound: bounds::GYRO_SCALE },
        ]
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        if self.model.bias_wander_rad_per_s2 > 0.0 {
            self.check_wander(history, slack)?;
        } else {
            self.check_noise(history, slack)?;
        }
        if !self.model.bounds_angle() {
            return Ok(());
        }
        // W(t) − W(s) ≤ floor + rate·(t − s) for all s < t is W(t) − rate·t ≤ floor + min over s of (W(s) − rate·s), and likewise below.
        let floor = within(Interval::point(self.model.angle_floor_rad));
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        let begin = self.readings.first().map(|reading| (history.stamps_s[reading.from], Interval::ZERO));
        let ends = self.readings.iter().map(|reading| history.stamps_s[reading.to]).zip(self.angles_rad(history));
        for (time_s, angle_rad) in begin.into_iter().chain(ends) {
            let grown_rad = Interval::point(self.model.angle_rad_per_s) * time_s;
            let [low, high] = [angle_rad - grown_rad, angle_rad + grown_rad];
            if least.is_finite() {
                let beyond = (low - Interval::point(least)).hi().max((Interval::point(greatest) - high).hi());
                demand(slack, bounds::GYRO_ANGLE, time_s, Interval::point(beyond.max(0.0)), floor)?;
            }
            (least, greatest) = (least.min(low.lo()), greatest.max(high.hi()));
        }
        Ok(())
    }

    /// Evens the noise out between two knots. The heading between them changes by some microradians.
    fn ease(&self, history: &mut History, knots: &[usize]) {
        let scale = history.value(Quantity::GyroScale);
        let angles_rad: Vec<f64> = self.angles_rad(history).iter().map(|angle| angle.mid()).collect();
        let until = |stamp: usize| {
            let n_before = self.readings.partition_point(|reading| reading.to <= stamp);
            n_before.checked_sub(1).map_or(0.0, |last| angles_rad[last])
        };
        for pair in knots.windows(2) {
            let [from_s, to_s] = [pair[0], pair[1]].map(|knot| history.stamps_s[knot]);
            let [from_rad, to_rad] = [pair[0], pair[1]].map(until);
            for stamp in pair[0] + 1..pair[1] {
                let share = (history.stamps_s[stamp] - from_s) / (to_s - from_s);
                history.poses[stamp].heading_rad += (until(stamp) - from_rad - share * (to_rad - from_rad)) / scale;
            }
        }
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        self.add_noise_rows(near);
        if self.model.bounds_angle() {
            self.add_angle_rows(near);
        }
    }
}

impl Gyro {
    /// Checks the noise of each reading about the constant bias.
    fn check_noise(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let most = within(Interval::point(self.model.noise_rad_per_s));
        for reading in &self.readings {
            let time_s = history.stamps_s[reading.to];
            demand(slack, bounds::GYRO_NOISE, time_s, self.noise_rad_per_s(history, reading), most)?;
        }
        Ok(())
    }

    /// Checks that some bias which wanders no faster than declared leaves each reading no more noise than declared: the biases are followed from reading to
    /// reading that the readings so far allow.
    fn check_wander(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let widened = 1.0 + slack;
        let within_rad_per_s = self.model.bias_rad_per_s.inflate(slack * self.model.bias_rad_per_s.magnitude());
        let constant = Interval::point(history.value(Quantity::GyroBias));
        let mut bias = within_rad_per_s;
        for reading in &self.readings {
            let time_s = history.stamps_s[reading.to];
            let value = self.noise_rad_per_s(history, reading) + constant;
            // Inner intervals: their ends are rounded inwards.
            let inner = |low: Interval, high: Interval| Interval::new(low.hi(), high.lo());
            let noise = Interval::point(self.model.noise_rad_per_s) * widened;
            let by_noise = inner(Interval::point(value.hi()) - noise, Interval::point(value.lo()) + noise);
            let allowed = within_rad_per_s.intersect(by_noise);
            if allowed.is_empty() {
                return Err(Broken { bound: bounds::GYRO_NOISE, time_s, value, allowed: within_rad_per_s });
            }
            let wander = span_s(history, reading) * self.model.bias_wander_rad_per_s2 * widened;
            let reached = inner(Interval::point(bias.lo()) - wander, Interval::point(bias.hi()) + wander);
            bias = reached.intersect(allowed);
            if bias.is_empty() {
                return Err(Broken { bound: bounds::GYRO_WANDER, time_s, value: allowed, allowed: reached });
            }
        }
        Ok(())
    }

    /// Rows of the noise: between two knots a deviation changes the noise of all readings alike, so that the readings with the least and the greatest
    /// noise count.
    fn add_noise_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        let noises: Vec<f64> =
            self.readings.iter().map(|reading| self.noise_rad_per_s(history, reading).mid()).collect();
        let mut begin = 0;
        while begin < self.readings.len() {
            let knot = near.place(self.readings[begin].from).0;
            let n_here = self.readings[begin..].iter().take_while(|reading| near.place(reading.from).0 == knot).count();
            let here = begin..begin + n_here;
            let least = here.clone().min_by(|&a, &b| noises[a].total_cmp(&noises[b]));
            let most = here.clone().max_by(|&a, &b| noises[a].total_cmp(&noises[b]));
            for at in least.into_iter().chain(most) {
                let reading = &self.readings[at];
                let span_s = span_s(history, reading).mid();
                let rate = -history.value(Quantity::GyroScale) / span_s;
                let turned_rad = history.poses[reading.to].heading_rad - history.poses[reading.from].heading_rad;
                let mut terms = near.pose(reading.to, 2, rate).to_vec();
                terms.extend(near.pose(reading.from, 2, -rate));
                terms.push(near.quantity(Quantity::GyroScale, -turned_rad / span_s));
                terms.push(near.quantity(Quantity::GyroBias, -1.0));
                let noise = self.model.noise_rad_per_s;
                near.add(terms, noises[at], Interval::new(-noise, noise));
            }
            begin = here.end;
        }
    }

    /// Rows of the sum of all errors: it stays within half of the floor of an angle that grows at most at the declared rate. That says the bound over
    /// any span.
    fn add_angle_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        let angles_rad: Vec<f64> = self.angles_rad(history).iter().map(|angle| angle.mid()).collect();
        let Some(first) = self.readings.first() else { return };
        let half_floor_rad = 0.5 * self.model.angle_floor_rad;
        let from_s = history.stamps_s[first.from];
        // For each knot the sum there, and the least and the greatest difference of the sum near it from a linear change between the knots.
        let n_knots = near.knots.len();
        let at_knot: Vec<f64> = near
            .knots
            .iter()
            .map(|&knot| {
                let n_before = self.readings.partition_point(|reading| reading.to <= knot);
                n_before.checked_sub(1).map_or(0.0, |last| angles_rad[last])
            })
            .collect();
        let mut strays = vec![[0.0f64; 2]; n_knots];
        for (reading, angle_rad) in self.readings.iter().zip(&angles_rad) {
            let (knot, share) = near.place(reading.to);
            let next = knot + 1;
            let stray = angle_rad - at_knot[knot] - share * (at_knot[next] - at_knot[knot]);
            for knot in [knot, next] {
                strays[knot] = [strays[knot][0].min(stray), strays[knot][1].max(stray)];
            }
        }
        let mut before = None;
        for knot in 0..n_knots {
            let stamp = near.knots[knot];
            let span_s = history.stamps_s[stamp] - from_s;
            let most_rad = 2.0 * half_floor_rad + self.model.angle_rad_per_s * span_s;
            let drift = near.helper(Interval::new(-most_rad, most_rad));
            let turned_rad = history.poses[stamp].heading_rad - history.poses[first.from].heading_rad;
            let scale = history.value(Quantity::GyroScale);
            let mut terms = near.pose(stamp, 2, -scale).to_vec();
            terms.extend(near.pose(first.from, 2, scale));
            terms.push(near.quantity(Quantity::GyroScale, -turned_rad));
            terms.push(near.quantity(Quantity::GyroBias, -span_s));
            terms.push((drift, -1.0));
            let [least, greatest] = strays[knot];
            near.add(terms, at_knot[knot], Interval::new(-half_floor_rad - least, half_floor_rad - greatest));
            if let Some((drift_before, time_before_s)) = before {
                let grown_rad: f64 = self.model.angle_rad_per_s * (history.stamps_s[stamp] - time_before_s);
                near.add(vec![(drift, 1.0), (drift_before, -1.0)], 0.0, Interval::new(-grown_rad, grown_rad));
            }
            before = Some((drift, history.stamps_s[stamp]));
        }
    }
}
