//! Wheel readings: the counts of the ticks, the dimensions of the axle, slip and side slip.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{
    bounds,
    robot::{Reach, WheelModel},
};

use super::{
    gains::Gains,
    history::{History, Quantity, Step, sums},
    kind::{Broken, Declared, Kind, Linearised, WHEEL, demand, within},
    outline::outline,
};

/// Time by which a window may be longer than declared and still count, because stamps are rounded.
const ROUNDING_S: f64 = 1e-9;
/// Full windows of slip begin at every stamp of this number for the search. Of the windows with the same end that a candidate nearly breaks, the worst
/// is added.
const EACH_WINDOW: usize = 5;
/// Share of a bound above which a window of slip is added to the search on its own.
const NEARLY: f64 = 0.8;
/// Time before the end within which all windows of slip are added. There a candidate uses many of them up to the bound, and if the search knew only
/// those that the last candidate used, the next one would break others.
const LATEST_S: f64 = 1.0;

/// All wheel readings up to an instant.
pub(super) struct Wheels {
    /// Stamp of each reading, with the ticks of both wheels where the reading has arrived.
    pub(super) readings: Vec<(usize, Option<[i64; 2]>)>,
    pub(super) model: WheelModel,
    pub(super) reach: Reach,
}

/// Sums up to each wheel reading: the travel of the left and the right wheel's contact point and of the origin to its left, less what the wheels
/// rolled; and the paths that the left wheel, the right wheel and their mean rolled.
struct Travel {
    error_m: [Vec<Interval>; 3],
    path_m: [Vec<Interval>; 3],
    /// True travel of each wheel's contact point.
    wheel_m: [Vec<Interval>; 2],
}

/// A window over which slip is bounded: the readings at its begin and end, the slip over it, and the greatest slip allowed.
struct Window {
    begin: usize,
    end: usize,
    slip_m: f64,
    most_m: f64,
}

impl Window {
    /// Share of the bound that the slip uses.
    fn used(&self) -> f64 {
        self.slip_m.abs() / self.most_m
    }
}

impl Wheels {
    fn travel(&self, history: &History) -> Travel {
        let steps: Vec<Step<Interval>> = history.steps().collect();
        let along_m = sums(steps.iter().map(|step| step.along_m));
        let left_m = sums(steps.iter().map(|step| step.left_m));
        let half_track_m = Interval::point(history.value(Quantity::Track)) * 0.5;
        let from_rad = Interval::point(history.poses[0].heading_rad);
        let at = |stamp: usize, wheel: usize| {
            let turned_rad = Interval::point(history.poses[stamp].heading_rad) - from_rad;
            let side_m = half_track_m * turned_rad;
            along_m[stamp] + if wheel == 0 { -side_m } else { side_m }
        };
        let radius_m = [0, 1].map(|wheel| Interval::point(history.value(Quantity::WheelRadius(wheel))));
        let angle = |stamp: usize, wheel: usize| Interval::point(history.wheel_angle_rad[stamp][wheel]);
        let stamps: Vec<usize> = self.readings.iter().map(|(stamp, _)| *stamp).collect();
        let wheel_m = [0, 1].map(|wheel| stamps.iter().map(|&stamp| at(stamp, wheel)).collect::<Vec<_>>());
        let slip_m = [0, 1].map(|wheel| {
            let rolled = |&stamp: &usize| radius_m[wheel] * (angle(stamp, wheel) - angle(stamps[0], wheel));
            stamps.iter().zip(&wheel_m[wheel]).map(|(stamp, travel_m)| *travel_m - rolled(stamp)).collect()
        });
        let path_m = [0, 1].map(|wheel| {
            sums(stamps.windows(2).map(|pair| radius_m[wheel] * (angle(pair[1], wheel) - angle(pair[0], wheel)).abs()))
        });
        let mean_m = path_m[0].iter().zip(&path_m[1]).map(|(left, right)| (*left + *right) * 0.5).collect();
        let side_m = stamps.iter().map(|&stamp| left_m[stamp]).collect();
        let ([slip_left, slip_right], [left, right]) = (slip_m, path_m);
        Travel { error_m: [slip_left, slip_right, side_m], path_m: [left, right, mean_m], wheel_m }
    }

    /// Ratio and floor of the bound of a channel, and its name: slip of the left or right wheel, or side slip.
    fn slip_bound(&self, channel: usize) -> (f64, f64, &'static str) {
        let model = &self.model;
        match channel {
            2 => (model.side_slip_ratio, model.side_slip_floor_m, bounds::WHEELS_SIDE_SLIP),
            _ => (model.slip_ratio, model.slip_floor_m, bounds::WHEELS_SLIP),
        }
    }

    /// Calls `with` for every window up to the declared length: the readings at its begin and end.
    fn windows(
        &self,
        history: &History,
        mut with: impl FnMut(usize, usize) -> Result<(), Broken>,
    ) -> Result<(), Broken> {
        let time_s = |reading: usize| history.stamps_s[self.readings[reading].0];
        let mut first = 0;
        for end in 1..self.readings.len() {
            while time_s(end) - time_s(first) > self.model.slip_window_s + ROUNDING_S {
                first += 1;
            }
            (first..end).try_for_each(|begin| with(begin, end))?;
        }
        Ok(())
    }

    /// Checks that each wheel stood somewhere within one tick at the start, such that all its counts are right to within the share `slack` of a tick.
    fn check_ticks(&self, history: &History, slack: f64) -> Result<(), Broken> {
        for wheel in 0..2 {
            let mut phase = Interval::new(0.0, 1.0);
            for (stamp, ticks) in &self.readings {
                let Some(ticks) = ticks else { continue };
                let angle = Interval::point(history.wheel_angle_rad[*stamp][wheel]) * self.model.ticks_per_turn;
                let count = angle / (Interval::PI * 2.0);
                // ticks ≤ count + phase ≤ ticks + 1, whichever number of the interval the count is.
                let below = Interval::point(ticks[wheel] as f64) - count;
                let allowed = Interval::new(below.hi() - slack, (below + Interval::ONE).lo() + slack);
                let left = phase.intersect(allowed);
                if left.is_empty() {
                    let time_s = history.stamps_s[*stamp];
                    return Err(Broken { bound: TICKS, time_s, value: phase, allowed });
                }
                phase = left;
            }
        }
        Ok(())
    }

    /// Checks that no wheel's travel changes its speed faster than declared.
    fn check_acceleration(&self, history: &History, travel: &Travel, slack: f64) -> Result<(), Broken> {
        let most = within(Interval::point(self.reach.acceleration_m_per_s2));
        for at in 2..self.readings.len() {
            let [before_s, now_s, after_s] = [2, 1, 0].map(|back| history.stamps_s[self.readings[at - back].0]);
            for wheel_m in &travel.wheel_m {
                let speed = (wheel_m[at - 1] - wheel_m[at - 2]) / (Interval::point(now_s) - Interval::point(before_s));
                let next = (wheel_m[at] - wheel_m[at - 1]) / (Interval::point(after_s) - Interval::point(now_s));
                let span_s = (Interval::point(after_s) - Interval::point(before_s)) * 0.5;
                demand(slack, bounds::REACH_ACCELERATION, after_s, (next - speed) / span_s, most)?;
            }
        }
        Ok(())
    }
}

/// What is broken when no position of the wheels within a tick explains their counts. It is no declared bound: ticks are counted without error.
const TICKS: &str = "ticks of the wheels";

impl Kind for Wheels {
    fn declared(&self, _history: &History) -> Vec<Declared> {
        let radius = |wheel: usize| Declared {
            quantity: Quantity::WheelRadius(wheel),
            interval: self.model.radius_m[wheel],
            bound: bounds::WHEELS_RADIUS,
        };
        let track = Declared { quantity: Quantity::Track, interval: self.model.track_m, bound: bounds::WHEELS_TRACK };
        vec![radius(0), radius(1), track]
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let travel = self.travel(history);
        self.check_ticks(history, slack)?;
        self.check_acceleration(history, &travel, slack)?;
        for channel in 0..3 {
            let (ratio, floor_m, bound) = self.slip_bound(channel);
            let (error_m, path_m) = (&travel.error_m[channel], &travel.path_m[channel]);
            self.windows(history, |begin, end| {
                let most_m = (path_m[end] - path_m[begin]) * ratio + Interval::point(floor_m);
                let time_s = history.stamps_s[self.readings[end].0];
                demand(slack, bound, time_s, error_m[end] - error_m[begin], within(most_m))
            })?;
        }
        Ok(())
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        let travel = self.travel(history);
        let gains = Gains::along(near);
        let last_s = history.stamps_s[history.stamps_s.len() - 1];
        for channel in 0..3 {
            let (ratio, floor_m, _) = self.slip_bound(channel);
            let (error_m, path_m) = (&travel.error_m[channel], &travel.path_m[channel]);
            let mut chosen = Vec::new();
            let mut nearly_broken: BTreeMap<usize, Window> = BTreeMap::new();
            let mut before = 0;
            // The windows never fail here, since the closure never does.
            let _ = self.windows(history, |begin, end| {
                let slip_m = (error_m[end] - error_m[begin]).mid();
                let most_m = ratio * (path_m[end] - path_m[begin]).mid() + floor_m;
                let window = Window { begin, end, slip_m, most_m };
                let is_full = end != before && begin % EACH_WINDOW == 0 && begin > 0;
                before = end;
                if is_full || last_s - history.stamps_s[self.readings[end].0] < LATEST_S {
                    chosen.push(window);
                } else if window.used() > NEARLY.max(nearly_broken.get(&end).map_or(0.0, Window::used)) {
                    nearly_broken.insert(end, window);
                }
                Ok(())
            });
            chosen.extend(nearly_broken.into_values());
            for Window { begin, end, slip_m, most_m } in chosen {
                let [from, to] = [begin, end].map(|reading| self.readings[reading].0);
                let terms = if channel == 2 {
                    gains.left(near, from, to)
                } else {
                    let mut terms = gains.wheel(near, channel, from, to);
                    let rolled_rad = history.wheel_angle_rad[to][channel] - history.wheel_angle_rad[from][channel];
                    terms.push(near.quantity(Quantity::WheelRadius(channel), -rolled_rad));
                    let radius_m = history.value(Quantity::WheelRadius(channel));
                    terms.extend(near.pose(to, WHEEL + channel, -radius_m));
                    terms.extend(near.pose(from, WHEEL + channel, radius_m));
                    terms
                };
                near.add(terms, slip_m, Interval::new(-most_m, most_m));
            }
        }
        self.add_acceleration_rows(near, &gains, &travel);
        self.add_tick_rows(near);
    }
}

impl Wheels {
    /// Rows of the ticks: at each reading the wheel has turned by its count, by what it stood beyond a tick at the start, and by less than a tick more.
    fn add_tick_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        let per_rad = self.model.ticks_per_turn / std::f64::consts::TAU;
        for wheel in 0..2 {
            let phase = near.helper(Interval::new(0.0, 1.0));
            let most_rad = 1.0 / per_rad;
            for knot in 0..near.knots.len() {
                near.hold(near.at_knot(knot, WHEEL + wheel), 0.0, Interval::new(-most_rad, most_rad));
            }
            // For each reading its knot and place after it, its stamp, and what the wheel turned beyond its count.
            let beyond = |(stamp, ticks): &(usize, Option<[i64; 2]>)| {
                let count = history.wheel_angle_rad[*stamp][wheel] * per_rad - (*ticks)?[wheel] as f64;
                Some((near.place(*stamp), *stamp, count))
            };
            let counts: Vec<((usize, f64), usize, f64)> = self.readings.iter().filter_map(beyond).collect();
            for part in counts.chunk_by(|one, other| one.0.0 == other.0.0) {
                let points: Vec<[f64; 3]> =
                    part.iter().map(|((_, share), _, count)| [*share, count - 0.5, 0.5]).collect();
                for at in outline(&points, points.len()) {
                    let (_, stamp, count) = part[at];
                    let mut terms = near.pose(stamp, WHEEL + wheel, per_rad).to_vec();
                    terms.push((phase, 1.0));
                    near.add(terms, count, Interval::new(0.0, 1.0));
                }
            }
        }
    }

    /// Rows of the acceleration of each wheel's travel. Between two knots a deviation changes it hardly, so that readings around knots count.
    fn add_acceleration_rows(&self, near: &mut Linearised<'_>, gains: &Gains, travel: &Travel) {
        let history = near.history;
        let most = self.reach.acceleration_m_per_s2;
        for at in 2..self.readings.len() {
            let stamps = [2, 1, 0].map(|back| self.readings[at - back].0);
            let next_knot = near.knots.partition_point(|knot| *knot <= stamps[0]);
            if near.knots.get(next_knot).is_none_or(|knot| *knot >= stamps[2]) {
                continue;
            }
            let [before_s, now_s, after_s] = stamps.map(|stamp| history.stamps_s[stamp]);
            let span_s = 0.5 * (after_s - before_s);
            let [first, last] = [-1.0 / ((now_s - before_s) * span_s), 1.0 / ((after_s - now_s) * span_s)];
            for (wheel, wheel_m) in travel.wheel_m.iter().enumerate() {
                let mut terms = Vec::new();
                let mut value = 0.0;
                for (begin, per_m) in [(0, first), (1, last)] {
                    let moved = gains.wheel(near, wheel, stamps[begin], stamps[begin + 1]);
                    terms.extend(moved.into_iter().map(|(unknown, coefficient)| (unknown, per_m * coefficient)));
                    value += per_m * (wheel_m[at - 1 + begin] - wheel_m[at - 2 + begin]).mid();
                }
                near.add(terms, value, Interval::new(-most, most));
            }
        }
    }
}
