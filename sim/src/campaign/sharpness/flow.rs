//! Readings of the flow sensor: the counts of its own travel over the floor.
//!
//! Over a period the sensor travels (A − a_l·Δθ, L + a_f·Δθ) in the robot frame, where A and L are the travel of the robot's origin along and across
//! its heading, Δθ its turn and (a_f, a_l) the sensor's place; the sensor's yaw turns that into its own axes. Each metre is counted as n·(s₀ + δ)
//! counts, where n is the nominal number, s₀ the scale of the whole run and δ another number at each instant, but one number for both axes. Within a
//! period the sensor also goes forth and back, as far as declared; as δ may be greater forth than back, that adds to the counts. What is
//! read is the whole part of what was counted since the start and of where each axis stood within a count then.
//!
//! A history says for each period what δ was in the mean, what ways forth and back added, and so what was counted.

use interval::Interval;
use localizer::{bounds, robot::FlowModel};

use crate::scene;

use super::{
    gains::Gains,
    history::{Counted, History, Quantity, Step},
    kind::{Broken, CountedTerms, Declared, Kind, Linearised, demand, within},
    outline::outline,
};

/// The counts read at a stamp.
pub(super) struct Counts {
    pub(super) stamp: usize,
    /// Counts since the start, forward and left.
    pub(super) counts: [i64; 2],
    /// Whether the sensor saw nothing in the period before, so that it did not count its travel.
    pub(super) is_blind: bool,
    /// By how much the sensor truly travelled farther along its axes in the period before than with constant speed and turn rate between stamps. A
    /// witness moves within the period as the truth does.
    pub(super) beyond_m: [f64; 2],
}

/// All readings of the flow sensor that have arrived by an instant.
pub(super) struct Flow {
    pub(super) readings: Vec<Counts>,
    pub(super) keys: scene::Flow,
    pub(super) model: FlowModel,
    /// What the sensor truly counted up to each reading.
    pub(super) truly: Vec<Counted>,
}

/// What is broken when what was counted is not what is read. It is no declared bound: the sensor reads what it has counted without error.
pub(super) const COUNTS: &str = "counts of the flow sensor";

/// Greatest deviation of what was counted that the linear program allows: what is read leaves less than one count.
const MOST_COUNTS: f64 = 1.5;
/// Counts by which the travel between two knots may differ in the linear program from what is counted between them: an equation would leave the solver
/// no room.
const HAIR_COUNTS: f64 = 1e-4;

impl Flow {
    /// The sensor's travel along its own axes from each stamp to the next.
    fn travel_m(&self, history: &History) -> Vec<[Interval; 2]> {
        let point = |quantity: Quantity| Interval::point(history.value(quantity));
        let [forward_m, left_m] = [0, 1].map(|axis| point(Quantity::FlowPosition(axis)));
        let yaw_rad = point(Quantity::FlowYaw);
        let (cos, sin) = (yaw_rad.cos(), yaw_rad.sin());
        let steps = history.steps::<Interval>().map(|step| {
            let [ahead_m, aside_m] = [step.along_m - left_m * step.turn_rad, step.left_m + forward_m * step.turn_rad];
            [cos * ahead_m + sin * aside_m, cos * aside_m - sin * ahead_m]
        });
        steps.collect()
    }

    /// For each period between two readings the sensor's travel along its own axes.
    fn periods_m(&self, travel_m: &[[Interval; 2]]) -> Vec<[Interval; 2]> {
        let of_pair = |pair: &[Counts]| {
            let steps = &travel_m[pair[0].stamp..pair[1].stamp];
            [0, 1].map(|axis| steps.iter().fold(Interval::point(pair[1].beyond_m[axis]), |sum, step| sum + step[axis]))
        };
        self.readings.windows(2).map(of_pair).collect()
    }

    /// Greatest number of counts that a way forth and back adds along an axis in a period in which the scale varies by `change` in the mean. Forth, the
    /// scale is greater than that by what its bound leaves, and back it is less. Rounded down.
    fn most_gained(&self, change: f64) -> f64 {
        let left = Interval::point(self.keys.varying_share()) - change.abs();
        (left * self.keys.counts_per_m * self.keys.back_and_forth_m).lo().max(0.0)
    }

    /// Learns how the sensor truly moved within its periods and what it counted: from the true history, and for each reading from the sensor's true
    /// travel in the period before it and from what was truly counted since the start.
    pub(super) fn learn(&mut self, truth: &History, travelled: &[([f64; 2], [f64; 2])]) {
        let periods_m = self.periods_m(&self.travel_m(truth));
        let scale = truth.value(Quantity::FlowScale);
        let Some((_, first)) = travelled.first() else { return };
        self.truly = vec![Counted { counts: *first, change: 0.0, gained: [0.0; 2] }];
        for ((reading, period_m), pair) in self.readings[1..].iter_mut().zip(periods_m).zip(travelled.windows(2)) {
            let [(_, before), (travelled_m, counts)] = [pair[0], pair[1]];
            if reading.is_blind {
                self.truly.push(Counted { counts, change: 0.0, gained: [0.0; 2] });
                continue;
            }
            reading.beyond_m = [0, 1].map(|axis| travelled_m[axis] - period_m[axis].mid());
            let more = [0, 1].map(|axis| counts[axis] - before[axis]);
            let ahead = usize::from(travelled_m[1].abs() > travelled_m[0].abs());
            // Where the sensor hardly moves, ways forth and back tell more than a change of the scale.
            let most = self.keys.varying_share();
            let change = match travelled_m[ahead].abs() > self.keys.back_and_forth_m {
                true => (more[ahead] / self.keys.counts_per_m / travelled_m[ahead] - scale).clamp(-most, most),
                false => 0.0,
            };
            let gained = [0, 1].map(|axis| more[axis] - self.keys.counts_per_m * (scale + change) * travelled_m[axis]);
            self.truly.push(Counted { counts, change, gained });
        }
    }
}

impl Kind for Flow {
    fn declared(&self, _history: &History) -> Vec<Declared> {
        let place = |axis: usize| Declared {
            quantity: Quantity::FlowPosition(axis),
            interval: self.model.position_m[axis],
            bound: bounds::FLOW_POSITION,
        };
        let yaw = Declared { quantity: Quantity::FlowYaw, interval: self.model.yaw_rad, bound: bounds::FLOW_YAW };
        let interval = Interval::centred(1.0, self.keys.calibration_share());
        let scale = Declared { quantity: Quantity::FlowScale, interval, bound: bounds::FLOW_CALIBRATION };
        vec![place(0), place(1), yaw, scale]
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let constant = Interval::point(history.value(Quantity::FlowScale));
        let most = within(Interval::point(self.keys.varying_share()));
        let periods_m = self.periods_m(&self.travel_m(history));
        // A history that does not say what was counted counts nothing that could be computed.
        let told = |at: usize| history.counted.get(at).copied();
        let mut counted = told(0).map_or([Interval::EMPTY; 2], |first| first.counts.map(Interval::point));
        for (at, reading) in self.readings.iter().enumerate() {
            let time_s = history.stamps_s[reading.stamp];
            if let Some(period) = at.checked_sub(1).filter(|_| !reading.is_blind) {
                let Some(Counted { change, gained, .. }) = told(at) else {
                    let (value, allowed) = (Interval::EMPTY, Interval::ENTIRE);
                    return Err(Broken { bound: COUNTS, time_s, value, allowed });
                };
                demand(slack, bounds::FLOW_SCALE, time_s, Interval::point(change), most)?;
                let per_m = (constant + change) * self.keys.counts_per_m;
                let most_gained = within(Interval::point(self.most_gained(change)));
                for axis in 0..2 {
                    let allowed = most_gained.inflate(slack);
                    demand(0.0, bounds::FLOW_BACK_AND_FORTH, time_s, Interval::point(gained[axis]), allowed)?;
                    counted[axis] += per_m * periods_m[period][axis] + gained[axis];
                }
            }
            for (value, counts) in counted.into_iter().zip(reading.counts) {
                let cell = Interval::new(counts as f64 - slack, counts as f64 + 1.0 + slack);
                demand(0.0, COUNTS, time_s, value, cell)?;
            }
        }
        Ok(())
    }

    fn complete(&self, history: &mut History) {
        history.counted.clone_from(&self.truly);
    }

    /// Moves the robot within each period by as much as it takes to count what the history says.
    fn settle(&self, history: &mut History) {
        if history.counted.len() != self.readings.len() {
            return;
        }
        for counted in &mut history.counted {
            let most = self.most_gained(counted.change);
            counted.gained = counted.gained.map(|gained| gained.clamp(-most, most));
        }
        let value = |quantity: Quantity| history.value(quantity);
        let (sin, cos) = value(Quantity::FlowYaw).sin_cos();
        let periods_m = self.periods_m(&self.travel_m(history));
        let mut steps: Vec<Step<f64>> = history.steps().collect();
        for (period, pair) in self.readings.windows(2).enumerate() {
            if pair[1].is_blind {
                continue;
            }
            let [before, counted] = [period, period + 1].map(|at| history.counted[at]);
            let per_m = self.keys.counts_per_m * (value(Quantity::FlowScale) + counted.change);
            let short_m = [0, 1].map(|axis| {
                let counts = counted.counts[axis] - before.counts[axis] - counted.gained[axis];
                counts / per_m - periods_m[period][axis].mid()
            });
            let (from, to) = (pair[0].stamp, pair[1].stamp);
            let span_s = history.stamps_s[to] - history.stamps_s[from];
            let within_s = history.stamps_s[from..=to].windows(2).map(|pair| pair[1] - pair[0]);
            for (step, step_s) in steps[from..to].iter_mut().zip(within_s) {
                let share = step_s / span_s;
                step.along_m += share * (cos * short_m[0] - sin * short_m[1]);
                step.left_m += share * (sin * short_m[0] + cos * short_m[1]);
            }
        }
        history.set_steps(&steps);
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let rows = Rows::of(self, near);
        for knot in 0..near.knots.len() - 1 {
            rows.add_varying(near, knot);
            rows.add_link(near, knot);
            rows.add_counts(near, knot);
        }
        near.counted = rows.counted_terms(near);
    }
}

/// What the rows of the flow sensor are made of. What was counted deviates linearly in time from one knot to the next. The robot's travel does not
/// quite do so where it turns or changes its speed, and is settled afterwards.
struct Rows<'a> {
    flow: &'a Flow,
    gains: Gains,
    /// Sum, up to each stamp, of the sensor's travel along its own axes.
    until_m: Vec<[f64; 2]>,
    /// For each knot the first of the two unknowns by how many counts what was counted deviates, forward and left.
    counted: Vec<usize>,
    /// For each knot but the last the unknown by how much the varying part of the scale deviates up to the next knot.
    varying: Vec<usize>,
}

impl<'a> Rows<'a> {
    fn of(flow: &'a Flow, near: &mut Linearised<'_>) -> Rows<'a> {
        let mut until_m = vec![[0.0; 2]];
        for (at, step) in flow.travel_m(near.history).iter().enumerate() {
            until_m.push([0, 1].map(|axis| until_m[at][axis] + step[axis].mid()));
        }
        let n_knots = near.knots.len();
        let counts = Interval::new(-MOST_COUNTS, MOST_COUNTS);
        let counted = (0..n_knots).map(|_| [near.helper(counts), near.helper(counts)][0]).collect();
        let most = 2.0 * flow.keys.varying_share();
        let varying = (1..n_knots).map(|_| near.helper(Interval::new(-most, most))).collect();
        Rows { flow, gains: Gains::along(near), until_m, counted, varying }
    }

    /// Readings in the span from one knot to the next, without the first one of all.
    fn readings(&self, near: &Linearised<'_>, knot: usize) -> std::ops::Range<usize> {
        let after = |stamp: usize| self.flow.readings.partition_point(|reading| reading.stamp <= stamp);
        after(near.knots[knot]).max(1)..after(near.knots[knot + 1]).max(1)
    }

    /// The rows that the varying part of the scale keeps its bound from one knot to the next, where it is least and where it is greatest.
    fn add_varying(&self, near: &mut Linearised<'_>, knot: usize) {
        let most = self.flow.keys.varying_share();
        let changes = || near.history.counted[self.readings(near, knot)].iter().map(|counted| counted.change);
        for change in [changes().reduce(f64::min), changes().reduce(f64::max)].into_iter().flatten() {
            near.add(vec![(self.varying[knot], 1.0)], change, Interval::new(-most, most));
        }
    }

    /// How what was counted at each reading, and the scale before it, deviate.
    fn counted_terms(&self, near: &Linearised<'_>) -> Vec<CountedTerms> {
        let of_reading = |reading: &Counts| {
            let (knot, share) = near.place(reading.stamp);
            CountedTerms {
                counts: [0, 1].map(|axis| self.counted_at(knot, share, axis)),
                change: (self.varying[knot], 1.0),
            }
        };
        // A reading at a knot ends the span before it.
        let mut all: Vec<CountedTerms> = self.flow.readings.iter().map(of_reading).collect();
        for knot in 0..near.knots.len() - 1 {
            for at in self.readings(near, knot) {
                all[at].change = (self.varying[knot], 1.0);
            }
        }
        all
    }

    /// Terms of what was counted at this share of the way from a knot to the next.
    fn counted_at(&self, knot: usize, share: f64, axis: usize) -> Vec<(usize, f64)> {
        vec![(self.counted[knot] + axis, 1.0 - share), (self.counted[knot + 1] + axis, share)]
    }

    /// Terms of how many counts the sensor counts more along an axis between a knot and the next.
    fn terms(&self, near: &Linearised<'_>, knot: usize, axis: usize) -> Vec<(usize, f64)> {
        let (history, from, to) = (near.history, near.knots[knot], near.knots[knot + 1]);
        let value = |quantity: Quantity| history.value(quantity);
        let per_m = self.flow.keys.counts_per_m * value(Quantity::FlowScale);
        let [forward_m, left_m] = [0, 1].map(|axis| value(Quantity::FlowPosition(axis)));
        let (sin, cos) = value(Quantity::FlowYaw).sin_cos();
        let [ahead, aside] = if axis == 0 { [cos, sin] } else { [-sin, cos] };
        let turned_rad = history.poses[to].heading_rad - history.poses[from].heading_rad;
        let moved_m = [0, 1].map(|axis| self.until_m[to][axis] - self.until_m[from][axis]);

        let scaled = |terms: Vec<(usize, f64)>, by: f64| terms.into_iter().map(move |(at, share)| (at, by * share));
        let mut terms: Vec<(usize, f64)> = scaled(self.gains.along_of(near, from, to), per_m * ahead).collect();
        terms.extend(scaled(self.gains.left(near, from, to), per_m * aside));
        let per_turn = per_m * (aside * forward_m - ahead * left_m);
        terms.extend(near.pose(to, 2, per_turn));
        terms.extend(near.pose(from, 2, -per_turn));
        let by_yaw = if axis == 0 { moved_m[1] } else { -moved_m[0] };
        terms.extend([
            near.quantity(Quantity::FlowPosition(0), per_m * aside * turned_rad),
            near.quantity(Quantity::FlowPosition(1), -per_m * ahead * turned_rad),
            near.quantity(Quantity::FlowYaw, per_m * by_yaw),
            near.quantity(Quantity::FlowScale, self.flow.keys.counts_per_m * moved_m[axis]),
            (self.varying[knot], self.flow.keys.counts_per_m * moved_m[axis]),
        ]);
        terms
    }

    /// The rows that counts at a knot and at the next agree with the travel between them. Where the sensor was blind meanwhile, nothing more is counted
    /// than before.
    fn add_link(&self, near: &mut Linearised<'_>, knot: usize) {
        let is_blind = self.flow.readings[self.readings(near, knot)].iter().any(|reading| reading.is_blind);
        for axis in 0..2 {
            let mut terms = Vec::new();
            if !is_blind {
                terms = self.terms(near, knot, axis);
            }
            terms.extend([(self.counted[knot] + axis, 1.0), (self.counted[knot + 1] + axis, -1.0)]);
            near.add(terms, 0.0, Interval::new(-HAIR_COUNTS, HAIR_COUNTS));
        }
    }

    /// The rows that what was counted agrees with the readings from a knot to the next, and with the very first one.
    fn add_counts(&self, near: &mut Linearised<'_>, knot: usize) {
        let from = if knot == 0 { 0 } else { self.readings(near, knot).start };
        let readings = from..self.readings(near, knot).end;
        for axis in 0..2 {
            // What was counted beyond the middle of what each reading leaves, by its place in time between the knots.
            let point = |at: usize| {
                let reading = &self.flow.readings[at];
                let (of_knot, share) = near.place(reading.stamp);
                let share = if of_knot > knot { 1.0 } else { share };
                [share, near.history.counted[at].counts[axis] - reading.counts[axis] as f64 - 0.5, 0.5]
            };
            let points: Vec<[f64; 3]> = readings.clone().map(point).collect();
            for at in outline(&points, points.len()) {
                let [share, beyond, _] = points[at];
                near.add(self.counted_at(knot, share, axis), beyond, Interval::new(-0.5, 0.5));
            }
        }
    }
}
