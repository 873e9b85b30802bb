//! The search for witnesses at one instant: histories that keep every bound and end as far out along one axis as possible.
//!
//! The bounds are linearised about a history, a linear program finds the farthest history that keeps the linear rows, and the rows are made anew
//! about that one. Whether a history is a witness is decided by the exact check alone.

use interval::{
    Interval,
    linear_program::{LinearProgram, Solver},
};

use super::{
    history::History,
    kind::{Broken, Declared, Kind, Linearised, N_AT_KNOT, Trust, demand},
};

/// Least time between two knots, the stamps at which a candidate's motion may depart from the truth in another way than before.
const KNOT_S: f64 = 0.39;
/// Time before the end within which knots may be closer: there the latest looks, one by one, decide where a history may end.
const LATEST_S: f64 = 2.0;
/// Least time between two knots there. Closer ones would leave wheels hardly any time to change their speed.
const LATEST_KNOT_S: f64 = 0.09;
/// Time between two knots where nothing is looked at.
const LONGEST_S: f64 = 0.8;
/// Number of the first programs for one direction of one axis, which go as far as they can. What the second leaves is of fourth order, but where a
/// quantity may deviate in many ways without a change of the distance, each program chooses another one, and none of the first ends at a witness.
const N_FAR_PROGRAMS: usize = 3;
/// Number of the first programs in which all quantities move. Later ones hold those that enter in products only, so that the rows become exact.
const N_PROGRAMS_WITH_PRODUCTS: usize = 2;
/// For each further program the share of all ranges within which it stays near the candidate before it. It corrects what is not linear, which is of
/// second order in this share.
const CORRECTIONS: [f64; 5] = [0.1, 0.03, 0.01, 0.003, 0.001];
/// Share of the width of each row's interval that is left free at both ends, for what is not linear. After minutes there are so many readings that hardly
/// any history keeps away from all ends of their intervals: at some instants after 180 s the first programs had no solution with 1 per mille left free.
const MARGIN: f64 = 0.0003;
/// Greatest number of steps of the solver; after these the point is within a few per mille of the optimum.
const MOST_STEPS: usize = 24;
/// Share of the distance by which a step of the solver may still change it when the program counts as solved.
const SETTLED: f64 = 2e-3;
/// Number of steps in a row that must change the distance so little.
const N_SETTLED: usize = 2;
/// Share of the distance that a correction may give up, so that it ends as soon as its rows hold.
const GIVEN_UP: f64 = 3e-3;
/// Share of the distance from the truth below which what a program changed shows that a further one is not worth its time.
const LEAST_GAIN: f64 = 0.03;
/// Number of halvings when a candidate is drawn back towards a witness.
const N_HALVINGS: usize = 7;

/// Share of a bound by which the truth may exceed it. Errors that are drawn at the ends of their tolerances are there to within rounding, and sums of
/// them over a drive to within many roundings. Witnesses have no such allowance.
pub(super) const TRUTH_SLACK: f64 = 1e-6;

/// Checks every bound of every kind on a history, each widened by the share `slack`.
pub(super) fn check(history: &History, kinds: &[Box<dyn Kind>], slack: f64) -> Result<(), Broken> {
    let end_s = history.stamps_s[history.stamps_s.len() - 1];
    for kind in kinds {
        for Declared { quantity, interval, bound } in kind.declared(history) {
            demand(slack, bound, end_s, Interval::point(history.value(quantity)), interval)?;
        }
        kind.check(history, slack)?;
    }
    Ok(())
}

/// Moves a history to where it keeps the equations of all kinds that linear rows keep to first order only.
fn settle(history: &mut History, kinds: &[Box<dyn Kind>]) {
    kinds.iter().for_each(|kind| kind.settle(history));
}

/// What the search at one instant found.
pub(super) struct Found {
    /// For each axis of the pose the interval from the least to the greatest value of a witness at the instant.
    pub(super) spanned: [Interval; 3],
    /// The bound that the last candidate broke, for each direction in which no candidate is a witness.
    pub(super) broken: Vec<Broken>,
}

/// Searches for witnesses that end as far out as possible. `truth` is the true history up to the instant, and deviations of the pose are sought
/// within `reach` on each axis.
///
/// Errors with the bound that the truth breaks: then there is nothing to compare with.
pub(super) fn search(truth: &History, kinds: &[Box<dyn Kind>], reach: [f64; 3]) -> Result<Found, Broken> {
    check(truth, kinds, TRUTH_SLACK)?;
    let knots = knots(truth);
    let mut spanned = last_pose(truth).map(Interval::point);
    let mut broken = Vec::new();
    let mut eased = truth.clone();
    kinds.iter().for_each(|kind| kind.ease(&mut eased, &knots));
    settle(&mut eased, kinds);
    let truth = if check(&eased, kinds, TRUTH_SLACK).is_ok() { &eased } else { truth };
    let first = Program::about([truth, truth], kinds, &knots, reach, Stage::of(1, 0.0));
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut climb = Climb { kinds, knots: &knots, reach, axis, side, witness: truth.clone(), broken: None };
            climb.go(first.as_ref());
            let ends = last_pose(&climb.witness);
            (0..3).for_each(|axis| spanned[axis] = spanned[axis].hull(Interval::point(ends[axis])));
            broken.extend(climb.broken);
        }
    }
    Ok(Found { spanned, broken })
}

fn last_pose(history: &History) -> [f64; 3] {
    history.poses.last().copied().unwrap_or_default().to_array()
}

/// The first and the last stamp, and those between at which something was looked at, at least so far apart but for the latest.
fn knots(history: &History) -> Vec<usize> {
    let last = history.stamps_s.len() - 1;
    let mut knots = vec![0];
    for stamp in history.looks().filter(|stamp| *stamp < last) {
        let is_late = history.stamps_s[last] - history.stamps_s[stamp] < LATEST_S;
        let after_s = history.stamps_s[stamp] - history.stamps_s[knots[knots.len() - 1]];
        if after_s >= KNOT_S || (is_late && after_s >= LATEST_KNOT_S) {
            knots.push(stamp);
        }
    }
    // Without looks, or long after the last one, stamps as far apart take their place.
    for stamp in knots[knots.len() - 1]..last {
        if history.stamps_s[stamp] - history.stamps_s[knots[knots.len() - 1]] >= LONGEST_S {
            knots.push(stamp);
        }
    }
    knots.push(last);
    knots
}

/// The search in one direction of one axis.
struct Climb<'a> {
    kinds: &'a [Box<dyn Kind>],
    knots: &'a [usize],
    reach: [f64; 3],
    axis: usize,
    /// 1 for the greatest value, −1 for the least.
    side: f64,
    /// The farthest witness so far; the truth before there is another.
    witness: History,
    /// The bound that the last candidate broke, if it was no witness.
    broken: Option<Broken>,
}

impl Climb<'_> {
    fn go(&mut self, first: Option<&Program<'_>>) {
        let truth = self.witness.clone();
        let Some(mut candidate) = first.and_then(|first| first.farthest(self.axis, self.side)) else { return };
        settle(&mut candidate, self.kinds);
        let mut far_before = 0.0;
        for program in 1.. {
            self.broken = check(&candidate, self.kinds, 0.0).err();
            let is_witness = self.broken.is_none();
            let gain = self.height(&candidate) - self.height(&self.witness);
            let far = self.height(&candidate) - self.height(&truth);
            if is_witness && gain > 0.0 {
                self.witness = candidate.clone();
            }
            let changes_little = program > N_FAR_PROGRAMS || (far - far_before).abs() < LEAST_GAIN * far.abs();
            far_before = far;
            if (is_witness && changes_little) || program == N_FAR_PROGRAMS + CORRECTIONS.len() {
                break;
            }
            let stage = Stage::of(program + 1, far.abs());
            let again = Program::about([&candidate, &truth], self.kinds, self.knots, self.reach, stage);
            match again.and_then(|program| program.farthest(self.axis, self.side)) {
                Some(next) => candidate = next,
                None => break,
            }
            settle(&mut candidate, self.kinds);
        }
        if self.broken.is_some() {
            self.draw_back(&candidate);
        }
    }

    /// Seeks the farthest witness on the straight way from the best one to a candidate.
    fn draw_back(&mut self, candidate: &History) {
        let (mut reached, mut too_far) = (0.0, 1.0);
        let from = self.witness.clone();
        for _ in 0..N_HALVINGS {
            let share = 0.5 * (reached + too_far);
            let mut between = from.towards(candidate, share);
            settle(&mut between, self.kinds);
            if check(&between, self.kinds, 0.0).is_ok() {
                reached = share;
                if self.height(&between) > self.height(&self.witness) {
                    self.witness = between;
                }
            } else {
                too_far = share;
            }
        }
    }

    fn height(&self, history: &History) -> f64 {
        self.side * last_pose(history)[self.axis]
    }
}

/// What a program of the search may change.
#[derive(Clone, Copy, Debug)]
struct Stage {
    moves_products: bool,
    /// For a correction the share of all ranges within which it stays.
    correction: Option<f64>,
    /// How far from the truth the history is about which the program is made.
    far: f64,
}

impl Stage {
    /// The stage of the program with this number, counted from 1.
    fn of(program: usize, far: f64) -> Stage {
        let correction = program.checked_sub(N_FAR_PROGRAMS + 1).and_then(|at| CORRECTIONS.get(at).copied());
        Stage { moves_products: program <= N_PROGRAMS_WITH_PRODUCTS, correction, far }
    }
}

/// The linear program about a history.
struct Program<'a> {
    near: Linearised<'a>,
    solver: Solver,
    stage: Stage,
}

impl<'a> Program<'a> {
    /// The program about a history of a search that began at `start`; `None` where a row is none, which a history that can be computed never causes.
    fn about(
        [history, start]: [&'a History; 2],
        kinds: &[Box<dyn Kind>],
        knots: &'a [usize],
        reach: [f64; 3],
        stage: Stage,
    ) -> Option<Self> {
        let share = stage.correction.unwrap_or(1.0);
        let reach = reach.map(|reach| share * reach);
        // The kind of the wheels narrows the ranges of their angles.
        let [x_m, y_m, heading_rad] = reach;
        let most: [f64; N_AT_KNOT] = [x_m, y_m, heading_rad, 1.0, 1.0];
        let knot_ranges = knots.iter().flat_map(|_| most.map(|most| Interval::new(-most, most))).collect();
        let declared: Vec<Declared> = kinds.iter().flat_map(|kind| kind.declared(history)).collect();
        let most = reach[0].max(reach[1]);
        let trust = Trust { most, share, moves_products: stage.moves_products, margin: MARGIN };
        let mut near = Linearised::new([history, start], knots, knot_ranges, &declared, trust);
        kinds.iter().for_each(|kind| kind.add_rows(&mut near));
        let mut program = LinearProgram::new(near.ranges.clone()).ok()?;
        for (terms, interval) in &near.rows {
            program.add_row(terms, *interval).ok()?;
        }
        let solver = Solver::new(&program).stopped_after(MOST_STEPS);
        Some(Program { near, solver, stage })
    }

    /// The history that the program puts farthest out along an axis; `None` where the solver's point is no number.
    fn farthest(&self, axis: usize, side: f64) -> Option<History> {
        let mut solver = self.solver.clone();
        let last = self.near.at_knot(self.near.knots.len() - 1, axis);
        let mut search = solver.begin(&[(last, -side)]);
        let far = self.stage.far;
        let mut farthest: Option<Vec<f64>> = None;
        let mut n_settled = 0;
        // The last steps may be lost in rounding, so that the last point of finite numbers counts.
        // A correction goes on until its rows hold.
        let is_correction = self.stage.correction.is_some();
        while (is_correction || n_settled < N_SETTLED) && !solver.advance(&mut search, 1) {
            let point = solver.point(&search);
            if !point.iter().all(|value| value.is_finite()) {
                break;
            }
            let gained = farthest.as_ref().map_or(f64::INFINITY, |before| (point[last] - before[last]).abs());
            n_settled = if gained < SETTLED * point[last].abs().max(far) { n_settled + 1 } else { 0 };
            let is_corrected = is_correction && side * point[last] > -GIVEN_UP * far && self.near.keeps_rows(&point);
            farthest = Some(point);
            if is_corrected {
                break;
            }
        }
        farthest.map(|point| self.near.moved(&point))
    }
}
