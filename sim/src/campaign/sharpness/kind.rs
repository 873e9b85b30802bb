//! What a kind of reading demands of a history: an exact check of every bound, and the same bounds as linear rows for the search.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{Pose, bounds::Assumption};

use super::history::{History, Quantity};

/// A kind of reading with all its readings, or a kind of bound that holds without readings.
///
/// A new kind is one file that implements this, and one line of [`kinds`](super::kinds).
pub(super) trait Kind {
    /// The quantities that this kind adds to a history, each with the interval that is declared for it and the bound's name.
    fn declared(&self, history: &History) -> Vec<Declared>;

    /// Checks every declared bound of this kind on the history, with outward rounding; errors with a bound that is, or may be, exceeded by more than
    /// the share `slack` of it.
    fn check(&self, history: &History, slack: f64) -> Result<(), Broken>;

    /// Adds to the true history what it keeps of this kind besides its quantities.
    fn complete(&self, _history: &mut History) {}

    /// Moves a history by as little as it takes to where it keeps equations that linear rows keep to first order only.
    fn settle(&self, _history: &mut History) {}

    /// Moves a history a little to where the bounds of this kind leave more room, without moving its knots.
    fn ease(&self, _history: &mut History, _knots: &[usize]) {}

    /// Adds linear rows that stand for the bounds near the history. They only guide the search, so that they may leave out bounds that hardly matter.
    fn add_rows(&self, near: &mut Linearised<'_>);
}

/// The interval that is declared for a quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Declared {
    pub(super) quantity: Quantity,
    pub(super) interval: Interval,
    pub(super) bound: Assumption,
}

/// A declared bound that a history does not keep, or that rounding leaves in doubt.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Broken {
    /// Name of the bound.
    pub(super) bound: Assumption,
    /// End of the span over which the bound is exceeded.
    pub(super) time_s: f64,
    /// Value of the quantity that the bound limits.
    pub(super) value: Interval,
    /// The interval in which the bound demands the value.
    pub(super) allowed: Interval,
}

impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} at {:.3} s: {} instead of {}", self.bound, self.time_s, self.value, self.allowed)
    }
}

/// Demands that a value is surely within the interval that a bound allows, widened by the share `slack` of its greatest number.
pub(super) fn demand(
    slack: f64,
    bound: Assumption,
    time_s: f64,
    value: Interval,
    allowed: Interval,
) -> Result<(), Broken> {
    // An empty interval stands for a value that could not be computed, so that it keeps no bound.
    let widened = if slack > 0.0 { allowed.inflate(slack * allowed.magnitude()) } else { allowed };
    if !value.is_empty() && value.is_subset_of(widened) {
        return Ok(());
    }
    Err(Broken { bound, time_s, value, allowed })
}

/// The interval of all numbers whose magnitude is at most the least number of `most`.
pub(super) fn within(most: Interval) -> Interval {
    Interval::new(-most.lo(), most.lo())
}

/// How far a program may go from its history.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trust {
    /// Greatest deviation of a quantity without a bound of its own.
    pub(super) most: f64,
    /// Share of the width of its bound by which a quantity with a bound may deviate.
    pub(super) share: f64,
    /// Whether quantities move that are multiplied by others, so that linear rows are good only near the history.
    pub(super) moves_products: bool,
    /// Share of the width of each row's interval by which it is narrowed at both ends. The room is for what is not linear.
    pub(super) margin: f64,
}

/// Share of a value by which the range of its deviation is narrowed at both ends, so that their sum rounds to a number in the declared interval.
const ROUNDING: f64 = 1e-12;

/// Number of unknowns at each knot: the pose's x, y and heading, and the angles of the left and of the right wheel.
pub(super) const N_AT_KNOT: usize = 5;
/// First of a knot's unknowns that is the angle of a wheel.
pub(super) const WHEEL: usize = 3;

/// A linear program in the deviations from a history, as far as its rows are known.
///
/// Deviations of pose and wheels are unknowns at some of the stamps, the *knots*, and change linearly in time from one knot to the next. In addition, a
/// deviation of the gyroscope's scale stretches the turn between two knots, so that it agrees with every reading between them.
pub(super) struct Linearised<'a> {
    /// The history from which deviations count.
    pub(super) history: &'a History,
    /// The history from which the search started.
    pub(super) start: &'a History,
    /// Stamps of the knots in ascending order; the first and the last stamp are knots.
    pub(super) knots: &'a [usize],
    /// For each stamp the knot at or before it, and the share of the way from that knot to the next.
    places: Vec<(usize, f64)>,
    /// For each stamp how the heading changes per deviation of the gyroscope's scale.
    stretches_rad: Vec<f64>,
    quantities: BTreeMap<Quantity, usize>,
    margin: f64,
    /// For each reading of the flow sensor how what it has counted changes; empty where the history does not tell that.
    pub(super) counted: Vec<CountedTerms>,
    /// Interval of each unknown.
    pub(super) ranges: Vec<Interval>,
    /// Terms and interval of each row.
    pub(super) rows: Vec<(Vec<(usize, f64)>, Interval)>,
}

/// Terms of how what the flow sensor has counted at one of its readings changes with the deviations.
pub(super) struct CountedTerms {
    /// Terms of the counts, forward and left.
    pub(super) counts: [Vec<(usize, f64)>; 2],
    /// Term of the varying part of the scale in the period before.
    pub(super) change: (usize, f64),
}

impl<'a> Linearised<'a> {
    /// The program without rows: the unknowns of each knot, within `knot_ranges`, then one for each quantity that is declared.
    pub(super) fn new(
        [history, start]: [&'a History; 2],
        knots: &'a [usize],
        knot_ranges: Vec<Interval>,
        declared: &[Declared],
        trust: Trust,
    ) -> Self {
        let mut places = Vec::with_capacity(history.stamps_s.len());
        let mut knot = 0;
        for stamp in 0..history.stamps_s.len() {
            while knot + 2 < knots.len() && knots[knot + 1] <= stamp {
                knot += 1;
            }
            let [from_s, to_s] = [knots[knot], knots[knot + 1]].map(|knot| history.stamps_s[knot]);
            places.push((knot, (history.stamps_s[stamp] - from_s) / (to_s - from_s)));
        }
        let scale = history.value(Quantity::GyroScale);
        let stretches_rad = places
            .iter()
            .zip(&history.poses)
            .map(|(&(knot, share), pose)| {
                let [from, to] = [knots[knot], knots[knot + 1]].map(|knot| history.poses[knot].heading_rad);
                let stretch = -(pose.heading_rad - from - share * (to - from)) / scale;
                if stretch.is_finite() { stretch } else { 0.0 }
            })
            .collect();
        let n_at_knots = knot_ranges.len();
        let indices = declared.iter().enumerate().map(|(at, declared)| (declared.quantity, n_at_knots + at)).collect();
        let mut near = Linearised {
            history,
            start,
            knots,
            places,
            stretches_rad,
            quantities: indices,
            margin: trust.margin,
            counted: Vec::new(),
            ranges: knot_ranges,
            rows: Vec::new(),
        };
        for Declared { quantity, interval, .. } in declared {
            let is_free = trust.moves_products || !quantity.is_in_products();
            // A quantity that is bounded goes as far as its bound where it may.
            let most = match (is_free, interval.is_bounded()) {
                (false, _) => 0.0,
                (true, false) => trust.most,
                (true, true) => trust.share * interval.width(),
            };
            let unknown = near.helper(Interval::new(-most, most));
            near.hold(unknown, history.value(*quantity), *interval);
        }
        near
    }

    /// The knot at or before a stamp, and the share of the way from that knot to the next.
    pub(super) fn place(&self, stamp: usize) -> (usize, f64) {
        self.places[stamp]
    }

    /// A further unknown that is no quantity of the history.
    pub(super) fn helper(&mut self, range: Interval) -> usize {
        self.ranges.push(range);
        self.ranges.len() - 1
    }

    /// Index of a knot's unknown.
    pub(super) fn at_knot(&self, knot: usize, axis: usize) -> usize {
        N_AT_KNOT * knot + axis
    }

    /// Terms of a coefficient times the deviation of a pose's x (0), y (1) or heading (2), or of the left (3) or the right (4) wheel's angle, at a stamp.
    pub(super) fn pose(&self, stamp: usize, axis: usize, coefficient: f64) -> [(usize, f64); 3] {
        let (knot, share) = self.places[stamp];
        let stretch = if axis == 2 { self.stretches_rad[stamp] } else { 0.0 };
        [
            (self.at_knot(knot, axis), coefficient * (1.0 - share)),
            (self.at_knot(knot + 1, axis), coefficient * share),
            self.quantity(Quantity::GyroScale, coefficient * stretch),
        ]
    }

    /// The history that deviates from this one by a point of the program.
    pub(super) fn moved(&self, point: &[f64]) -> History {
        let mut moved = self.history.clone();
        for (stamp, (pose, angles_rad)) in moved.poses.iter_mut().zip(&mut moved.wheel_angle_rad).enumerate() {
            let by: [f64; N_AT_KNOT] = std::array::from_fn(|axis| {
                self.pose(stamp, axis, 1.0).iter().map(|&(at, coefficient)| coefficient * point[at]).sum::<f64>()
            });
            (0..2).for_each(|wheel| angles_rad[wheel] += by[WHEEL + wheel]);
            let [x_m, y_m, heading_rad] = [pose.x_m + by[0], pose.y_m + by[1], pose.heading_rad + by[2]];
            *pose = Pose { x_m, y_m, heading_rad };
        }
        for (counted, terms) in moved.counted.iter_mut().zip(&self.counted) {
            let deviation =
                |terms: &[(usize, f64)]| terms.iter().map(|&(at, coefficient)| coefficient * point[at]).sum::<f64>();
            (0..2).for_each(|axis| counted.counts[axis] += deviation(&terms.counts[axis]));
            counted.change += deviation(&[terms.change]);
        }
        for (quantity, at) in &self.quantities {
            if let Some(value) = moved.quantities.get_mut(quantity) {
                *value += point[*at];
            }
        }
        moved
    }

    /// Term of a coefficient times the deviation of a quantity; of 0 times the first unknown where the history does not have it.
    pub(super) fn quantity(&self, quantity: Quantity, coefficient: f64) -> (usize, f64) {
        self.quantities.get(&quantity).map_or((0, 0.0), |&at| (at, coefficient))
    }

    /// Adds the row that a value, which is `value` at the history and changes by the terms, stays in an interval.
    pub(super) fn add(&mut self, mut terms: Vec<(usize, f64)>, value: f64, allowed: Interval) {
        terms.retain(|(_, coefficient)| *coefficient != 0.0);
        let narrowed_by = self.margin * allowed.width();
        let (lo, hi) = (allowed.lo() + narrowed_by - value, allowed.hi() - narrowed_by - value);
        if lo <= hi {
            self.rows.push((terms, Interval::new(lo, hi)));
        }
    }

    /// Whether a point keeps all rows.
    pub(super) fn keeps_rows(&self, point: &[f64]) -> bool {
        self.rows.iter().all(|(terms, allowed)| {
            let change: f64 = terms.iter().map(|&(at, coefficient)| coefficient * point[at]).sum();
            allowed.contains(change)
        })
    }

    /// Narrows the range of an unknown, so that a value that is `value` at the history and changes as the unknown does stays in an interval. Unlike a
    /// row, this keeps an interval that is a single number exactly.
    pub(super) fn hold(&mut self, unknown: usize, value: f64, allowed: Interval) {
        let hair = ROUNDING * (1.0 + value.abs());
        let (lo, hi) = (allowed.lo() - value + hair, allowed.hi() - value - hair);
        let left = self.ranges[unknown].intersect(Interval::new(lo, hi));
        self.ranges[unknown] = if lo > hi || left.is_empty() { Interval::ZERO } else { left };
    }

    /// Adds rows that keep a vector of two quantities shorter than `most`: a polygon of 16 sides with its corners on the circle.
    pub(super) fn add_disc(&mut self, quantities: [Quantity; 2], most: f64) {
        if most <= 0.0 {
            return;
        }
        let half_corner_rad = std::f64::consts::PI / 16.0;
        let side = most * half_corner_rad.cos();
        for direction in 0..8 {
            let (sin, cos) = (f64::from(2 * direction + 1) * half_corner_rad).sin_cos();
            let [a, b] = quantities;
            let value = cos * self.history.value(a) + sin * self.history.value(b);
            let terms = vec![self.quantity(a, cos), self.quantity(b, sin)];
            self.add(terms, value, Interval::new(-side, side));
        }
    }
}
