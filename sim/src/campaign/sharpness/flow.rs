//! Readings of the flow sensor: the counts of its own travel over the floor.
//!
//! Over a period the sensor travels (A − a_l·Δθ, L + a_f·Δθ) in the robot frame, where A and L are the travel of the robot's origin along and across
//! its heading, Δθ its turn and (a_f, a_l) the sensor's place; the sensor's yaw turns that into its own axes. Each metre is counted as n·(s₀ + δ)
//! counts, where n is the nominal number, s₀ the scale of the whole run and δ another number at each instant, but one number for both axes. Within a
//! period the sensor also goes forth and back, as far as declared; as δ may be greater forth than back, that adds to the counts. What is
//! read is the whole part of what was counted since the start and of where each axis stood within a count then.

mod course;

use interval::Interval;
use localizer::{bounds, robot::FlowModel};

use crate::scene;

use super::{
    gains::Gains,
    history::{History, Quantity},
    kind::{Broken, Declared, Kind, Linearised},
    outline::outline,
};
use course::{Course, Scale, Span};

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
}

/// Share of the scale's bound that the linear program uses. What is left makes a way forth and back add to the counts.
const USED: f64 = 0.9;
/// Greatest deviation of what was counted that the linear program allows: what is read leaves less than one count.
const MOST_COUNTS: f64 = 1.5;

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

    /// The periods between readings with the sensor's travel.
    fn spans(&self, travel_m: &[[Interval; 2]]) -> Vec<Span> {
        let of_pair = |pair: &[Counts]| {
            let steps = &travel_m[pair[0].stamp..pair[1].stamp];
            let sum = |axis: usize| steps.iter().fold(Interval::ZERO, |sum, step| sum + step[axis]);
            let travel_m = match pair[1].is_blind {
                true => [Interval::ZERO; 2],
                false => [0, 1].map(|axis| sum(axis) + pair[1].beyond_m[axis]),
            };
            Span { travel_m, counts: pair[1].counts, is_blind: pair[1].is_blind }
        };
        self.readings.windows(2).map(of_pair).collect()
    }

    /// Learns how the sensor truly moved within its periods: from the true history, and from its true travel in the period before each reading.
    pub(super) fn learn(&mut self, truth: &History, travelled_m: &[[f64; 2]]) {
        let spans = self.spans(&self.travel_m(truth));
        for ((reading, span), travelled_m) in self.readings[1..].iter_mut().zip(spans).zip(&travelled_m[1..]) {
            if !reading.is_blind {
                reading.beyond_m = [0, 1].map(|axis| travelled_m[axis] - span.travel_m[axis].mid());
            }
        }
    }

    /// What the sensor counts in the history, with scales that vary so that it agrees with all readings, if they can.
    fn course(&self, history: &History, slack: f64) -> Course {
        let spans = self.spans(&self.travel_m(history));
        let first = self.readings.first().map_or([0; 2], |first| first.counts);
        let scale = Scale {
            counts_per_m: self.keys.counts_per_m,
            constant: Interval::point(history.value(Quantity::FlowScale)),
            most: self.keys.varying_share(),
            forth_and_back_m: self.keys.back_and_forth_m,
        };
        Course::through(first, &spans, &scale, slack)
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
        match self.course(history, slack).stopped {
            None => Ok(()),
            Some((reading, [value, allowed])) => {
                let time_s = history.stamps_s[self.readings[reading].stamp];
                Err(Broken { bound: bounds::FLOW_SCALE, time_s, value, allowed })
            }
        }
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let rows = Rows::of(self, near);
        for knot in 0..near.knots.len() - 1 {
            rows.add_varying(near, knot);
            rows.add_link(near, knot);
        }
        rows.add_counts(near);
    }
}

/// What the rows of the flow sensor are made of.
struct Rows<'a> {
    flow: &'a Flow,
    gains: Gains,
    /// Sum, up to each stamp, of the sensor's travel along its own axes.
    until_m: Vec<[f64; 2]>,
    course: Course,
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
        Rows { flow, gains: Gains::along(near), until_m, course: flow.course(near.history, 0.0), counted, varying }
    }

    /// Readings in the span from one knot to the next, without the first one of all.
    fn readings(&self, near: &Linearised<'_>, knot: usize) -> std::ops::Range<usize> {
        let after = |stamp: usize| self.flow.readings.partition_point(|reading| reading.stamp <= stamp);
        after(near.knots[knot]).max(1)..after(near.knots[knot + 1]).max(1)
    }

    /// The row that the varying part of the scale, in the mean from one knot to the next, keeps its bound.
    fn add_varying(&self, near: &mut Linearised<'_>, knot: usize) {
        let changes = &self.course.changes[self.readings(near, knot).start - 1..];
        let n_here = self.readings(near, knot).len();
        let mean = changes.iter().take(n_here).sum::<f64>() / n_here.max(1) as f64;
        let most = self.flow.keys.varying_share();
        near.add(vec![(self.varying[knot], 1.0)], mean, Interval::new(-most, most) * USED);
    }

    /// Terms of how many counts the sensor counts more along an axis between a knot and a stamp up to the next knot.
    fn terms(&self, near: &Linearised<'_>, knot: usize, stamp: usize, axis: usize) -> Vec<(usize, f64)> {
        let (history, from) = (near.history, near.knots[knot]);
        let value = |quantity: Quantity| history.value(quantity);
        let per_m = self.flow.keys.counts_per_m * value(Quantity::FlowScale);
        let [forward_m, left_m] = [0, 1].map(|axis| value(Quantity::FlowPosition(axis)));
        let (sin, cos) = value(Quantity::FlowYaw).sin_cos();
        let [ahead, aside] = if axis == 0 { [cos, sin] } else { [-sin, cos] };
        let turned_rad = history.poses[stamp].heading_rad - history.poses[from].heading_rad;
        let moved_m = [0, 1].map(|axis| self.until_m[stamp][axis] - self.until_m[from][axis]);

        let scaled = |terms: Vec<(usize, f64)>, by: f64| terms.into_iter().map(move |(at, share)| (at, by * share));
        let mut terms: Vec<(usize, f64)> = scaled(self.gains.along_of(near, from, stamp), per_m * ahead).collect();
        terms.extend(scaled(self.gains.left(near, from, stamp), per_m * aside));
        let per_turn = per_m * (aside * forward_m - ahead * left_m);
        terms.extend(near.pose(stamp, 2, per_turn));
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

    /// Counts by which a way forth and back in each period helps: half of what it adds where the scale's bound is used as far as the program does.
    fn rectified(&self) -> f64 {
        let keys = &self.flow.keys;
        0.5 * (1.0 - USED) * keys.varying_share() * keys.counts_per_m * keys.back_and_forth_m
    }

    /// The rows that counts at a knot and at the next agree with the travel between them, unless the sensor was blind meanwhile.
    fn add_link(&self, near: &mut Linearised<'_>, knot: usize) {
        if self.flow.readings[self.readings(near, knot)].iter().any(|reading| reading.is_blind) {
            return;
        }
        for axis in 0..2 {
            let mut terms = self.terms(near, knot, near.knots[knot + 1], axis);
            terms.extend([(self.counted[knot] + axis, 1.0), (self.counted[knot + 1] + axis, -1.0)]);
            let agree = self.rectified() * self.readings(near, knot).len().max(1) as f64;
            near.add(terms, 0.0, Interval::new(-agree, agree));
        }
    }

    /// The rows that what was counted agrees with the readings.
    fn add_counts(&self, near: &mut Linearised<'_>) {
        for knot in 0..near.knots.len() - 1 {
            let readings = self.readings(near, knot);
            for axis in 0..2 {
                // What was counted beyond the middle of what each reading leaves, by its place in time between the knots.
                let beyond =
                    |at: usize| self.course.counted[at][axis] - self.flow.readings[at].counts[axis] as f64 - 0.5;
                let share = |at: usize| {
                    let (of_knot, share) = near.place(self.flow.readings[at].stamp);
                    if of_knot > knot { 1.0 } else { share }
                };
                let points: Vec<[f64; 3]> = readings.clone().map(|at| [share(at), beyond(at), 0.5]).collect();
                for at in outline(&points, points.len()) {
                    let stamp = self.flow.readings[readings.start + at].stamp;
                    let mut terms = self.terms(near, knot, stamp, axis);
                    terms.push((self.counted[knot] + axis, 1.0));
                    // Ways forth and back since the knot, or until the next one.
                    let helped = self.rectified() * (at + 1).min(points.len() - at) as f64;
                    near.add(terms, points[at][1], Interval::new(-0.5, 0.5).inflate(helped));
                }
            }
        }
    }
}
