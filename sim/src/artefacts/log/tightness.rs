//! Where declared bounds were too tight: quantities of a log that its true poses tell, compared with their declared bounds.

mod scanner;

use localizer::{
    Reading,
    bounds::{self, Assumption},
    methods::gnss_positions::Position,
};
use serde_json::{Value, json};

use super::{
    motion::{Motion, tick_m},
    truth::TruePath,
};
use crate::scene::{LoggedTruth, Scene};

/// Numbers of slip windows over which slip is compared with its bound: short spans show a sudden slip, long ones a steady one that is less than the
/// error of the true poses in a short span.
const WINDOWS: [f64; 3] = [1.0, 10.0, 100.0];
/// Spans over which the mean rate of the gyroscope is compared with the true turn: over longer ones the error of the true headings counts less.
const GYRO_SPANS_S: [f64; 2] = [5.0, 30.0];
/// Span over which speed and turn rate are compared with the robot's limits: over shorter ones the error of the true poses is more than the motion.
const REACH_SPAN_S: f64 = 0.25;

/// A declared bound and the greatest value of what it bounds, as far as the true poses tell it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tightness {
    pub(super) bound: Assumption,
    /// The bound in the span in which the quantity exceeds it most, or comes nearest to it.
    pub(super) declared: f64,
    /// The least value that the quantity can have had there, given the error of the true poses.
    pub(super) least: f64,
    pub(super) span_s: [f64; 2],
    /// Least value of the key that states the bound with which nothing exceeds it for certain: a share of the way, or the bound itself.
    pub(super) needed: f64,
    /// Number of spans in which the bound was exceeded for certain, and number of all that were compared.
    pub(super) exceeded: usize,
    pub(super) compared: usize,
}

impl Tightness {
    fn new(bound: Assumption) -> Tightness {
        Tightness { bound, declared: 0.0, least: 0.0, span_s: [0.0; 2], needed: 0.0, exceeded: 0, compared: 0 }
    }

    /// Compares a quantity in a span: `measured` is its magnitude by the true poses, whose errors may make up to `by_truth` of it. Of the declared
    /// bound, the part `key` times `factor` comes from the key that states it.
    fn compare(&mut self, span_s: [f64; 2], declared: f64, [key, factor]: [f64; 2], [measured, by_truth]: [f64; 2]) {
        let least = (measured - by_truth).max(0.0);
        let beyond = least - declared;
        if beyond + key * factor > 0.0 {
            self.needed = self.needed.max(key + beyond / factor);
        }
        // What is less than a billionth beyond the bound is rounding.
        self.exceeded += usize::from(least > declared * (1.0 + 1e-9) + 1e-12);
        if self.compared == 0 || beyond > self.least - self.declared {
            (self.declared, self.least, self.span_s) = (declared, least, span_s);
        }
        self.compared += 1;
    }

    pub(super) fn to_json(self) -> Value {
        let unit = bounds::ALL.iter().find(|bound| bound.name == self.bound).map_or("", |bound| bound.unit);
        json!({
            "bound": self.bound, "unit": unit, "declared": self.declared, "at_least": self.least,
            "from_s": self.span_s[0], "to_s": self.span_s[1], "exceeded": self.exceeded, "compared": self.compared,
        })
    }
}

/// Everything by which the true poses and the readings are compared.
struct Comparison<'a> {
    told: &'a Scene,
    truth: &'a TruePath,
    /// Spans in which the localizer was told not to rely on the wheels' ways.
    doubted_s: Vec<[f64; 2]>,
    /// Greatest error of a true position along an axis, and of a true heading.
    within_m: f64,
    within_rad: f64,
}

/// Compares the bounds that true poses tell something about. `told` is the robot as the localizer was told it, `others` are the positions
/// of satellite navigation and the scans.
pub(super) fn tightness(
    told: &Scene,
    motion: &Motion,
    others: [&[Reading]; 2],
    truth: &TruePath,
    keys: &LoggedTruth,
) -> Vec<Tightness> {
    let [positions, scans] = others;
    let (within_m, within_rad) = (keys.tolerance_m, keys.tolerance_deg.to_radians());
    let comparison = Comparison {
        told,
        truth,
        doubted_s: motion.excesses.iter().map(|one| one.span_s).collect(),
        within_m,
        within_rad,
    };
    let readings = &motion.readings;
    let wheels: Vec<(f64, [i64; 2])> = readings
        .iter()
        .filter_map(|reading| match reading {
            Reading::Wheels { measured_s, ticks, .. } => Some((*measured_s, *ticks)),
            _ => None,
        })
        .collect();
    let mut all = Vec::from(comparison.slip(&wheels));
    all.extend(comparison.reach(&wheels));
    all.extend(comparison.gyro(readings));
    all.extend(comparison.satellites(positions));
    all.extend(comparison.scans(scans));
    all.retain(|one| one.compared > 0);
    all
}

impl Comparison<'_> {
    /// Slip of either wheel and side slip, over one or several slip windows that begin at each reading of the wheels.
    fn slip(&self, wheels: &[(f64, [i64; 2])]) -> [Tightness; 2] {
        let (base, bounds) = (&self.told.robot.base, &self.told.bounds);
        let tick_m = tick_m(self.told);
        // Distance that each wheel has rolled up to each reading, without regard to sign.
        let mut rolled = vec![[0.0; 2]];
        for pair in wheels.windows(2) {
            let before = rolled.last().copied().unwrap_or_default();
            rolled
                .push([0, 1].map(|wheel| before[wheel] + (pair[1].1[wheel] - pair[0].1[wheel]).abs() as f64 * tick_m));
        }
        let (mut slip, mut aside) = (Tightness::new(bounds::WHEELS_SLIP), Tightness::new(bounds::WHEELS_SIDE_SLIP));
        let by_truth_m = 2.0 * (2.0_f64.sqrt() * self.within_m);
        for (first, (from_s, from)) in wheels.iter().enumerate() {
            for n_windows in WINDOWS {
                let until_s = from_s + n_windows * bounds.slip_window_s + 1e-9;
                let last = wheels.partition_point(|(at_s, _)| *at_s <= until_s) - 1;
                let (to_s, to) = wheels[last];
                // A span that is much shorter than its windows says less than shorter ones do.
                let is_doubted = self.doubted_s.iter().any(|span_s| span_s[0] < to_s && *from_s < span_s[1]);
                if is_doubted || to_s < from_s + 0.5 * n_windows * bounds.slip_window_s {
                    continue;
                }
                let Some([along_m, aside_m, turn_rad]) = self.truth.travelled(*from_s, to_s) else { continue };
                for (wheel, side) in [(0, -1.0), (1, 1.0)] {
                    let true_m = along_m + side * 0.5 * base.track_m * turn_rad;
                    let read_m = (to[wheel] - from[wheel]) as f64 * tick_m;
                    let path_m = rolled[last][wheel] - rolled[first][wheel];
                    let declared_m = (bounds.slip_ratio + base.wheel_radius_tolerance) * path_m
                        + n_windows * bounds.slip_floor_m
                        + 0.5 * base.track_m * base.track_tolerance * turn_rad.abs()
                        + tick_m;
                    let by_turn_m = base.track_m * self.within_rad;
                    let off_m = [(true_m - read_m).abs(), by_truth_m + by_turn_m];
                    slip.compare([*from_s, to_s], declared_m, [bounds.slip_ratio, path_m], off_m);
                }
                let path_m = 0.5 * (0..2).map(|wheel| rolled[last][wheel] - rolled[first][wheel]).sum::<f64>();
                let declared_m = bounds.side_slip_ratio * path_m + n_windows * bounds.side_slip_floor_m;
                // A heading that is off by δ turns a part δ of the way into one aside.
                let by_heading_m = self.within_rad * along_m.abs();
                let off_m = [aside_m.abs(), by_truth_m + by_heading_m];
                aside.compare([*from_s, to_s], declared_m, [bounds.side_slip_ratio, path_m], off_m);
            }
        }
        [slip, aside]
    }

    /// Speed and turn rate between readings of the wheels.
    fn reach(&self, wheels: &[(f64, [i64; 2])]) -> [Tightness; 2] {
        let bounds = &self.told.bounds;
        let (mut speed, mut turn) = (Tightness::new(bounds::REACH_SPEED), Tightness::new(bounds::REACH_TURN_RATE));
        for (from_s, _) in wheels {
            let next = wheels.partition_point(|(at_s, _)| *at_s < from_s + REACH_SPAN_S);
            let Some((to_s, _)) = wheels.get(next) else { break };
            let ends = self.truth.at(*from_s).zip(self.truth.at(*to_s));
            let Some((from, to)) = ends else { continue };
            let lasts_s = to_s - from_s;
            let rate_m_per_s = (to.x_m - from.x_m).hypot(to.y_m - from.y_m) / lasts_s;
            let by_truth = 2.0 * 2.0_f64.sqrt() * self.within_m / lasts_s;
            let limit_m_per_s = bounds.reach_speed_m_per_s;
            speed.compare([*from_s, *to_s], limit_m_per_s, [limit_m_per_s, 1.0], [rate_m_per_s, by_truth]);
            let turn_rad_per_s = (to.heading_rad - from.heading_rad).abs() / lasts_s;
            let by_truth = 2.0 * self.within_rad / lasts_s;
            let limit_rad_per_s = bounds.reach_turn_rate_rad_per_s;
            turn.compare([*from_s, *to_s], limit_rad_per_s, [limit_rad_per_s, 1.0], [turn_rad_per_s, by_truth]);
        }
        [speed, turn]
    }

    /// Mean error of the gyroscope over some seconds, which the bias makes and the other errors hardly.
    fn gyro(&self, readings: &[Reading]) -> Option<Tightness> {
        let gyro = self.told.robot.gyro.as_ref()?;
        let rates: Vec<(f64, f64)> = readings
            .iter()
            .filter_map(|reading| match reading {
                Reading::Gyro { measured_s, rate_rad_per_s, .. } => Some((*measured_s, *rate_rad_per_s)),
                _ => None,
            })
            .collect();
        let mut bias = Tightness::new(bounds::GYRO_BIAS);
        for stretch in rates.chunk_by(|one, next| next.0 - one.0 < 1.5 * gyro.period_s) {
            for span_s in GYRO_SPANS_S {
                let n_readings = (span_s / gyro.period_s).round() as usize;
                for window in stretch.windows(n_readings + 1).step_by((n_readings / 10).max(1)) {
                    let (from_s, to_s) = (window[0].0, window[n_readings].0);
                    let Some([_, _, turn_rad]) = self.truth.travelled(from_s, to_s) else { continue };
                    let lasts_s = to_s - from_s;
                    let read_rad: f64 = window[1..].iter().map(|(_, rate)| rate * gyro.period_s).sum();
                    let noise_deg_per_s = match gyro.angle_floor_deg {
                        Some(floor_deg) => floor_deg / lasts_s + gyro.angle_deg_per_s,
                        None => gyro.noise_deg_per_s,
                    };
                    let declared = (gyro.bias_tolerance_deg_per_s + noise_deg_per_s).to_radians()
                        + gyro.scale_tolerance * turn_rad.abs() / lasts_s;
                    let measured = (read_rad - turn_rad).abs() / lasts_s;
                    let off = [measured, 2.0 * self.within_rad / lasts_s];
                    bias.compare([from_s, to_s], declared, [gyro.bias_tolerance_deg_per_s, f64::to_radians(1.0)], off);
                }
            }
        }
        Some(bias)
    }

    /// Errors of the positions by satellite navigation, along x and y each.
    fn satellites(&self, positions: &[Reading]) -> Vec<Tightness> {
        let Some(receiver) = &self.told.robot.gnss else { return Vec::new() };
        let names = [bounds::GNSS_FIXED, bounds::GNSS_FLOATING];
        let mut all = names.map(Tightness::new);
        let lever_m = receiver.forward_m.hypot(receiver.left_m);
        for reading in positions {
            let Reading::Other { measured_s, numbers, .. } = reading else { continue };
            let (Some(told), Some(pose)) = (Position::of(numbers), self.truth.at(*measured_s)) else { continue };
            let (sin, cos) = pose.heading_rad.sin_cos();
            let antenna_m = [
                pose.x_m + cos * receiver.forward_m - sin * receiver.left_m,
                pose.y_m + sin * receiver.forward_m + cos * receiver.left_m,
            ];
            let key_m = if told.is_fixed { receiver.fixed_tolerance_m } else { receiver.floating_tolerance_m };
            let moved_m = receiver.stamp_tolerance_s * self.told.bounds.reach_speed_m_per_s;
            let declared_m = key_m + receiver.position_tolerance_m + moved_m;
            let off_m = (told.at_m[0] - antenna_m[0]).abs().max((told.at_m[1] - antenna_m[1]).abs());
            let by_truth_m = self.within_m + lever_m * self.within_rad;
            all[usize::from(!told.is_fixed)].compare([*measured_s; 2], declared_m, [key_m, 1.0], [off_m, by_truth_m]);
        }
        all.into()
    }
}
