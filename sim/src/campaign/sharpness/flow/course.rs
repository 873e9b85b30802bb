//! What a flow sensor counts along a history, with scales that vary within their bound so that every reading agrees.

use interval::Interval;

/// A period of the flow sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Travel of the sensor along its own axes, forward and left; 0 where it was blind.
    pub(super) travel_m: [Interval; 2],
    /// What is read at the period's end, in counts since the start.
    pub(super) counts: [i64; 2],
    /// Whether the sensor counted nothing, as it was blind.
    pub(super) is_blind: bool,
}

/// What was counted up to each reading, and how the scale varied.
#[derive(Debug)]
pub(super) struct Course {
    /// At each reading what was counted since the start, forward and left, together with where each axis stood within a count at the start.
    pub(super) counted: Vec<[f64; 2]>,
    /// For each period the varying part of the scale.
    pub(super) changes: Vec<f64>,
    /// The first reading at which no varying part within the bound was found that agrees, with the part that would be needed and the bound's interval.
    pub(super) stopped: Option<(usize, [Interval; 2])>,
}

/// Distance, in counts, that is kept from the ends of what a reading leaves: far above rounding, and far below what matters.
const HAIR_COUNTS: f64 = 1e-7;

/// Factor by which what a way forth and back adds is less than it may be: it makes up for the roundings of a few operations.
const ROUNDED_DOWN: f64 = 1.0 - 1e-12;

/// How a flow sensor counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) counts_per_m: f64,
    /// Scale of the whole run, as a share of the nominal counts per metre.
    pub(super) constant: Interval,
    /// Greatest share by which the scale varies.
    pub(super) most: f64,
    /// Greatest length of the way forth and back in a period, along each axis.
    pub(super) forth_and_back_m: f64,
}

impl Scale {
    /// Whether the sensor travels farther in a period than it goes forth and back.
    fn moves(&self, span: &Span) -> bool {
        span.travel_m[main_axis(span)].magnitude() > self.forth_and_back_m
    }

    /// Counts that a way forth and back adds along an axis in a period in which the scale varies by `change` in the mean. Forth, the scale is greater
    /// than that by what its bound leaves, and back it is less.
    fn rectified(&self, change: f64) -> f64 {
        (self.most - change.abs()).max(0.0) * self.counts_per_m * self.forth_and_back_m * ROUNDED_DOWN
    }
}

/// Share of its distance from the middle of what may have been counted that a course makes up for in one period. The part of the scale that stays learns
/// at a quarter of the share's square, with which the course comes back without swinging.
const STEER: f64 = 0.05;

impl Course {
    /// Seeks a course that agrees with the reading `first` and those at the ends of `spans`. Whether the course agrees is decided in interval arithmetic.
    /// With `slack` counts and shares may be beyond by so much.
    ///
    /// Backwards in time, the interval of what may have been counted at each reading such that some scales agree with all later ones is found for each
    /// axis by itself. Forwards, the varying part and ways forth and back lead slowly towards the middle of the interval, as far as both axes allow.
    pub(super) fn through(first: [i64; 2], spans: &[Span], scale: &Scale, slack: f64) -> Course {
        let per_m = scale.constant * scale.counts_per_m;
        let scale = &Scale { most: scale.most * (1.0 + slack), ..*scale };
        let cell = |counts: i64| Interval::new(counts as f64 - slack, counts as f64 + 1.0 + slack);
        let later = [0, 1].map(|axis| later(first[axis], spans, axis, scale, &cell));
        let mut at = [0, 1].map(|axis| Interval::point(later[axis][0].mid()));
        let mut course = Course { counted: vec![at.map(|at| at.mid())], changes: Vec::new(), stopped: None };
        let mut change = 0.0;
        for (period, span) in spans.iter().enumerate() {
            let within = Interval::new(-scale.most, scale.most);
            let mut allowed = within;
            // The axis along which the sensor goes farther has its way first.
            let ahead = main_axis(span);
            for axis in [ahead, 1 - ahead] {
                let travel_m = span.travel_m[axis].mid();
                if travel_m == 0.0 {
                    continue;
                }
                let left = later[axis][period + 1] - (at[axis].mid() + per_m.mid() * travel_m);
                let by_axis = left * (1.0 / (scale.counts_per_m * travel_m));
                let both = nearest(allowed, by_axis);
                allowed = if axis == ahead || both.width() > 0.0 { both } else { allowed };
            }
            // Where the sensor hardly moves, a way forth and back does more than a change of the scale.
            let mut change_here = 0.0;
            if scale.moves(span) {
                let per_change = scale.counts_per_m * span.travel_m[ahead].mid();
                let middle = later[ahead][period + 1].mid();
                let off = (middle - at[ahead].mid() - per_m.mid() * span.travel_m[ahead].mid()) / per_change - change;
                change_here = f64::clamp(change + STEER * off, allowed.lo(), allowed.hi());
                change = f64::clamp(change + 0.25 * STEER * STEER * off, within.lo(), within.hi());
            }
            let varied = (scale.constant + change_here) * scale.counts_per_m;
            for axis in 0..2 {
                at[axis] += varied * span.travel_m[axis];
                if !span.is_blind {
                    let most = scale.rectified(change_here);
                    at[axis] += (later[axis][period + 1].mid() - at[axis].mid()).clamp(-most, most);
                }
                let cell = cell(span.counts[axis]);
                // An empty interval stands for a value that could not be computed.
                if at[axis].is_empty() || !at[axis].is_subset_of(cell) {
                    if course.stopped.is_none() {
                        let by = (cell - at[axis]) / (span.travel_m[axis] * scale.counts_per_m);
                        course.stopped = Some((period + 1, [Interval::point(change_here) + by, within]));
                    }
                    // The search goes on from where the reading is.
                    at[axis] = Interval::point(at[axis].mid().clamp(cell.lo(), cell.hi()));
                }
            }
            course.counted.push(at.map(|at| at.mid()));
            course.changes.push(change_here);
        }
        course
    }
}

/// The axis along which the sensor goes farther in a period.
fn main_axis(span: &Span) -> usize {
    usize::from(span.travel_m[1].magnitude() > span.travel_m[0].magnitude())
}

/// What two intervals have in common; of the first one the end next to the second, where they have nothing in common.
fn nearest(one: Interval, other: Interval) -> Interval {
    let both = one.intersect(other);
    match both.is_empty() {
        true if other.lo() > one.hi() => Interval::point(one.hi()),
        true => Interval::point(one.lo()),
        false => both,
    }
}

/// For each reading the interval of what may have been counted along an axis such that scales within their bounds agree with it and all later ones; what
/// the reading itself leaves, where there is none. Half of the way forth and back counts, and only along the axis along which the sensor goes less far:
/// how much it adds depends on what the other axis needs.
fn later(first: i64, spans: &[Span], axis: usize, scale: &Scale, cell: &dyn Fn(i64) -> Interval) -> Vec<Interval> {
    let within = |counts: i64| Interval::new(cell(counts).lo() + HAIR_COUNTS, cell(counts).hi() - HAIR_COUNTS);
    let counts: Vec<i64> = std::iter::once(first).chain(spans.iter().map(|span| span.counts[axis])).collect();
    let mut all: Vec<Interval> = counts.into_iter().map(within).collect();
    for (period, span) in spans.iter().enumerate().rev() {
        let travel_m = span.travel_m[axis].mid();
        let counted = scale.constant.mid() * scale.counts_per_m * travel_m;
        let varied = match scale.moves(span) {
            true if axis == main_axis(span) => scale.most * scale.counts_per_m * travel_m.abs(),
            true => scale.most * scale.counts_per_m * travel_m.abs() + 0.5 * scale.rectified(0.0),
            false if span.is_blind => 0.0,
            false => scale.rectified(0.0),
        };
        let next = all[period + 1];
        let both = all[period].intersect(Interval::new(next.lo() - counted - varied, next.hi() - counted + varied));
        if !both.is_empty() {
            all[period] = both;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten periods of 0.1 m each, at 100 counts per metre and a scale of 1: what is read is the whole part of 10 counts per period, and of `early` counts
    /// more in the first five.
    fn spans(early: i64) -> Vec<Span> {
        let travel_m = [Interval::point(0.1), Interval::ZERO];
        (1..=10_i64).map(|end| Span { travel_m, counts: [10 * end + early * end.min(5), 0], is_blind: false }).collect()
    }

    fn stops(spans: &[Span], most: f64) -> bool {
        let scale = Scale { counts_per_m: 100.0, constant: Interval::ONE, most, forth_and_back_m: 0.0 };
        Course::through([0, 0], spans, &scale, 0.0).stopped.is_some()
    }

    /// By hand: five periods with one count more in ten need 55 counts instead of 50. One count of room leaves 54, a share of 0.08.
    #[test]
    fn a_scale_varies_as_much_as_the_readings_need_and_no_more_than_its_bound() {
        assert!(!stops(&spans(0), 0.0));
        assert!(!stops(&spans(1), 0.0801) && stops(&spans(1), 0.0799));
    }

    /// Travel along both axes with one scale: a tenth more ahead and none more to the side contradict each other.
    #[test]
    fn both_axes_have_one_scale() {
        let both = |early: [i64; 2]| {
            let travel_m = [Interval::point(0.1); 2];
            let counts = |end: i64| early.map(|early| 10 * end + early * end);
            let spans: Vec<Span> =
                (1..=10).map(|end| Span { travel_m, counts: counts(end), is_blind: false }).collect();
            stops(&spans, 0.2)
        };
        assert!(!both([1, 1]) && !both([0, 0]) && both([1, 0]));
    }
}
