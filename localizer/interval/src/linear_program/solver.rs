//! An interior-point solver, whose duals make certificates.
//!
//! **Problem.** Each row i gets a slack sᵢ = aᵢ·x, so that both x and s are in boxes. Variables are scaled to [−1, 1], rows then by their largest
//! coefficient. Where a row's side is open, or beyond all values of the row over the box, the end of these values takes its place; its dual is then
//! near 0.
//!
//! **Step.** With multipliers z of the bounds of x, and w of those of s, the dual of a row is y = w_lower − w_upper. The products of all gaps and
//! multipliers are driven to a common value μ → 0 by Newton steps, with a predictor and a corrector. A step solves (Dx + AᵀDsA) Δx = …, with diagonal
//! Dx and Ds: as many unknowns as variables, in the structure of the rows.
//!
//! The dual with the best bound so far is kept, so that the solver can be stopped after any step.
//!
//! Source: S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM Journal on Optimization 2 (1992); S. J. Wright,
//! "Primal-Dual Interior-Point Methods", SIAM 1997, chapter 10.

use std::ops::Range;

use super::{
    factor::Factor,
    program::{LinearProgram, Terms},
};

/// Greatest number of steps; about 12 are usual.
const MOST_STEPS: usize = 40;
/// Gap between the values of the primal and the dual problem at which the solver stops unless asked otherwise, in half widths of the cost's largest
/// term.
const GAP: f64 = 1e-5;
/// Share of the way to the nearest bound that a step goes at most.
const SHARE: f64 = 0.995;
/// Least half width of a row's sides after scaling: an equation has no interior otherwise.
const LEAST_HALF: f64 = 1e-9;

/// Solves linear programs with the same variables and rows and different costs.
#[derive(Clone, Debug)]
pub struct Solver {
    /// Middle and half width of each variable.
    scales: Vec<[f64; 2]>,
    rows: Rows,
    n_rows: usize,
    factor: Factor,
    /// Places of the diagonal in the factor's matrix.
    diagonal: Vec<usize>,
    most_steps: usize,
    gap: f64,
}

/// Rows that are not satisfied everywhere in the box, scaled. Their terms stand one after the other, as every step of the solver reads all of them
/// several times.
#[derive(Clone, Debug, Default)]
struct Rows {
    heads: Vec<Head>,
    /// Variable and coefficient of each term of each row.
    variables: Vec<u32>,
    coefficients: Vec<f64>,
    /// For each row and each of its terms: the places in the factor's matrix of the products of its coefficient with those of all terms up to itself.
    places: Vec<u32>,
}

/// What there is of a row besides its terms.
#[derive(Clone, Debug)]
struct Head {
    row: usize,
    lo: f64,
    hi: f64,
    /// By what the row was divided.
    divisor: f64,
    /// Which of all terms are the row's.
    terms: Range<usize>,
}

impl Solver {
    /// Prepares to solve programs with the variables and rows of the one given.
    pub fn new(program: &LinearProgram) -> Solver {
        let scales: Vec<[f64; 2]> =
            program.variables().iter().map(|values| [values.mid(), 0.5 * values.width()]).collect();
        let mut rows = Rows::default();
        (0..program.n_rows()).for_each(|row| rows.add(program, row, &scales));
        let factor = Factor::new(scales.len(), rows.heads.iter().map(|head| &rows.variables[head.terms.clone()]));
        for head in &rows.heads {
            let members = &rows.variables[head.terms.clone()];
            for (at, &a) in members.iter().enumerate() {
                for &b in &members[..=at] {
                    let guess = rows.places.last().map_or(0, |&last| last as usize + 1);
                    rows.places.push(factor.position(a as usize, b as usize, guess) as u32);
                }
            }
        }
        let diagonal = (0..scales.len()).map(|at| factor.position(at, at, 0)).collect();
        Solver { scales, rows, n_rows: program.n_rows(), factor, diagonal, most_steps: MOST_STEPS, gap: GAP }
    }

    /// The same solver, stopped after the given number of steps.
    pub fn stopped_after(self, most_steps: usize) -> Solver {
        Solver { most_steps, ..self }
    }

    /// The same solver, stopped once the values of the primal and the dual problem differ by at most the given number of half widths of the cost's
    /// largest term.
    pub fn stopped_within(self, gap: f64) -> Solver {
        Solver { gap, ..self }
    }

    /// Duals of the program that minimises a cost, one for each row; for [`certified_minimum`](super::certified_minimum). Where no point satisfies
    /// all rows, they tend to certify that.
    pub fn minimise(&mut self, cost: &Terms) -> Vec<f64> {
        let mut search = self.begin(cost);
        while !self.advance(&mut search, self.most_steps) {}
        self.duals(&search)
    }

    /// Begins to minimise a cost, for a caller that spreads the steps over time.
    pub fn begin(&self, cost: &Terms) -> Search {
        let mut scaled = vec![0.0; self.scales.len()];
        for &(variable, coefficient) in cost {
            scaled[variable] += coefficient * self.scales[variable][1];
        }
        let largest = scaled.iter().fold(0.0, |largest: f64, one| largest.max(one.abs()));
        let unit = if largest > 0.0 { largest } else { 1.0 };
        scaled.iter_mut().for_each(|one| *one /= unit);
        Search { state: State::new(self, scaled), unit, n_left: self.most_steps, is_done: false }
    }

    /// Takes at most the given number of steps. Returns whether no further step brings anything.
    pub fn advance(&mut self, search: &mut Search, n_steps: usize) -> bool {
        for _ in 0..n_steps {
            search.is_done |= search.n_left == 0 || search.state.is_done(self) || !search.state.step(self);
            if search.is_done {
                return true;
            }
            search.n_left -= 1;
        }
        // The last step's bound counts, too.
        search.is_done |= search.state.is_done(self) || search.n_left == 0;
        search.is_done
    }

    /// The duals with the best bound so far, one for each row.
    pub fn duals(&self, search: &Search) -> Vec<f64> {
        let mut duals = vec![0.0; self.n_rows];
        let best = self.rows.heads.iter().zip(&search.state.best.1);
        best.for_each(|(head, dual)| duals[head.row] = dual * search.unit / head.divisor);
        duals
    }

    /// The point that the minimisation has come to: inside the box, and once it is done, near a solution with the least cost. Nothing is certified of
    /// it; whoever needs a point that satisfies the rows checks that.
    pub fn point(&self, search: &Search) -> Vec<f64> {
        let values = self.scales.iter().zip(&search.state.x);
        values.map(|(&[middle, half], x)| middle + half * x.value).collect()
    }
}

/// The minimisation of one cost by a [`Solver`], as far as it has come.
#[derive(Clone, Debug)]
pub struct Search {
    state: State,
    /// By what the cost was divided.
    unit: f64,
    n_left: usize,
    is_done: bool,
}

impl Rows {
    /// Adds a row of the program in scaled variables, unless every point of the box satisfies it.
    fn add(&mut self, program: &LinearProgram, row: usize, scales: &[[f64; 2]]) {
        let (mut variables, mut coefficients) = (Vec::<u32>::new(), Vec::<f64>::new());
        let mut at_middle = 0.0;
        for &(variable, coefficient) in program.terms(row) {
            let [middle, half] = scales[variable];
            at_middle += coefficient * middle;
            let scaled = coefficient * half;
            match variables.iter().position(|&other| other as usize == variable) {
                Some(at) => coefficients[at] += scaled,
                None if scaled != 0.0 => {
                    variables.push(variable as u32);
                    coefficients.push(scaled);
                }
                None => {}
            }
        }
        let divisor = coefficients.iter().fold(0.0, |largest: f64, one| largest.max(one.abs()));
        if divisor == 0.0 {
            return;
        }
        coefficients.iter_mut().for_each(|one| *one /= divisor);
        let most: f64 = coefficients.iter().map(|one| one.abs()).sum();
        let [lo, hi] = [program.sides(row).lo(), program.sides(row).hi()].map(|side| (side - at_middle) / divisor);
        if lo <= -most && hi >= most {
            return;
        }
        let (mut lo, mut hi) = (lo.max(-most - 1.0), hi.min(most + 1.0));
        if hi - lo < 2.0 * LEAST_HALF {
            // An equation, or a row that no point of the box satisfies.
            let middle = if lo > most || hi < -most { if lo > most { lo } else { hi } } else { 0.5 * (lo + hi) };
            (lo, hi) = (middle - LEAST_HALF, middle + LEAST_HALF);
        }
        let first = self.variables.len();
        self.variables.append(&mut variables);
        self.coefficients.append(&mut coefficients);
        self.heads.push(Head { row, lo, hi, divisor, terms: first..self.variables.len() });
    }

    /// Value of a row at a point.
    fn value(&self, head: &Head, x: &[f64]) -> f64 {
        let (variables, coefficients) = (&self.variables[head.terms.clone()], &self.coefficients[head.terms.clone()]);
        variables.iter().zip(coefficients).map(|(&variable, coefficient)| coefficient * x[variable as usize]).sum()
    }

    /// Adds a multiple of a row to a vector of the variables' length.
    fn add_to(&self, head: &Head, vector: &mut [f64], times: f64) {
        let (variables, coefficients) = (&self.variables[head.terms.clone()], &self.coefficients[head.terms.clone()]);
        for (&variable, coefficient) in variables.iter().zip(coefficients) {
            vector[variable as usize] += coefficient * times;
        }
    }
}

/// A number between two bounds, with the multipliers of the bounds.
#[derive(Clone, Copy, Debug)]
struct Bounded {
    value: f64,
    lo: f64,
    hi: f64,
    /// Multipliers of the lower and of the upper bound.
    multipliers: [f64; 2],
}

/// A step of a [`Bounded`].
#[derive(Clone, Copy, Debug, Default)]
struct Move {
    value: f64,
    multipliers: [f64; 2],
}

impl Bounded {
    fn gaps(&self) -> [f64; 2] {
        [self.value - self.lo, self.hi - self.value]
    }

    fn complementarity(&self, step: &Move, [primal, dual]: [f64; 2]) -> f64 {
        let [lower, upper] = self.gaps();
        (lower + primal * step.value) * (self.multipliers[0] + dual * step.multipliers[0])
            + (upper - primal * step.value) * (self.multipliers[1] + dual * step.multipliers[1])
    }

    /// Stiffness: the sum of multiplier/gap.
    fn stiffness(&self) -> f64 {
        let [lower, upper] = self.gaps();
        self.multipliers[0] / lower + self.multipliers[1] / upper
    }

    /// The products of gap and multiplier that are still to be gained to reach `target`, after what a predictor's step makes of second order.
    fn wanted(&self, target: f64, predictor: &Move) -> [f64; 2] {
        let [lower, upper] = self.gaps();
        [
            target - lower * self.multipliers[0] - predictor.value * predictor.multipliers[0],
            target - upper * self.multipliers[1] + predictor.value * predictor.multipliers[1],
        ]
    }

    /// The force on the number by the products wanted.
    fn force(&self, wanted: [f64; 2]) -> f64 {
        let [lower, upper] = self.gaps();
        wanted[0] / lower - wanted[1] / upper
    }

    /// The whole step, from that of the number.
    fn moved(&self, value: f64, wanted: [f64; 2]) -> Move {
        let [lower, upper] = self.gaps();
        let multipliers =
            [(wanted[0] - self.multipliers[0] * value) / lower, (wanted[1] + self.multipliers[1] * value) / upper];
        Move { value, multipliers }
    }

    /// The greatest parts of a step for which gaps and multipliers stay positive.
    fn longest(&self, step: &Move) -> [f64; 2] {
        let [lower, upper] = self.gaps();
        let part = |left: f64, change: f64| if change < 0.0 { -left / change } else { f64::INFINITY };
        let primal = part(lower, step.value).min(part(upper, -step.value));
        let dual = part(self.multipliers[0], step.multipliers[0]).min(part(self.multipliers[1], step.multipliers[1]));
        [primal, dual]
    }

    fn go(&mut self, step: &Move, [primal, dual]: [f64; 2]) {
        self.value += primal * step.value;
        (0..2).for_each(|side| self.multipliers[side] += dual * step.multipliers[side]);
    }
}

/// An iterate of the solver.
#[derive(Clone, Debug)]
struct State {
    cost: Vec<f64>,
    x: Vec<Bounded>,
    s: Vec<Bounded>,
    y: Vec<f64>,
    /// The best dual bound so far with its duals.
    best: (f64, Vec<f64>),
}

/// What both Newton steps of an iterate have in common, for each row.
struct Present {
    /// Stiffness of the row's slack.
    stiffnesses: Vec<f64>,
    /// By what the slack exceeds the row's value.
    lacks: Vec<f64>,
}

/// A Newton step.
struct Step {
    x: Vec<Move>,
    s: Vec<Move>,
    y: Vec<f64>,
}

impl State {
    /// The middle of all boxes.
    fn new(solver: &Solver, cost: Vec<f64>) -> State {
        let x = vec![Bounded { value: 0.0, lo: -1.0, hi: 1.0, multipliers: [1.0; 2] }; cost.len()];
        let s = solver.rows.heads.iter().map(|head| {
            let middle = 0.5 * (head.lo + head.hi);
            Bounded { value: middle, lo: head.lo, hi: head.hi, multipliers: [1.0; 2] }
        });
        let n_rows = solver.rows.heads.len();
        let best = (f64::NEG_INFINITY, vec![0.0; n_rows]);
        State { cost, x, s: s.collect(), y: vec![0.0; n_rows], best }
    }

    /// Notes the bound that the present duals give, and tells whether the gap is closed.
    fn is_done(&mut self, solver: &Solver) -> bool {
        let mut reduced = self.cost.clone();
        let mut bound = 0.0;
        for (head, &dual) in solver.rows.heads.iter().zip(&self.y) {
            solver.rows.add_to(head, &mut reduced, -dual);
            bound += dual * if dual > 0.0 { head.lo } else { head.hi };
        }
        bound -= reduced.iter().map(|one| one.abs()).sum::<f64>();
        if bound > self.best.0 {
            self.best = (bound, self.y.clone());
        }
        let value: f64 = self.cost.iter().zip(&self.x).map(|(cost, x)| cost * x.value).sum();
        // A bound above all values of the cost certifies that there is no solution.
        let most: f64 = self.cost.iter().map(|cost| cost.abs()).sum();
        (value - self.best.0 < solver.gap && self.residual(solver) < solver.gap) || self.best.0 > most + 1.0
    }

    /// Greatest difference between a slack and its row's value.
    fn residual(&self, solver: &Solver) -> f64 {
        let x: Vec<f64> = self.x.iter().map(|x| x.value).collect();
        let rows = &solver.rows;
        let differences = rows.heads.iter().zip(&self.s).map(|(head, s)| (rows.value(head, &x) - s.value).abs());
        differences.fold(0.0, f64::max)
    }

    /// Mean product of gap and multiplier, after part of a step.
    fn mean_product(&self, step: &Step, parts: [f64; 2]) -> f64 {
        let both = self.x.iter().zip(&step.x).chain(self.s.iter().zip(&step.s));
        let sum: f64 = both.map(|(one, step)| one.complementarity(step, parts)).sum();
        sum / (2 * (self.x.len() + self.s.len())) as f64
    }

    /// One step with predictor and corrector. Returns whether it led on.
    fn step(&mut self, solver: &mut Solver) -> bool {
        let rest = Step {
            x: vec![Move::default(); self.x.len()],
            s: vec![Move::default(); self.s.len()],
            y: vec![0.0; self.y.len()],
        };
        let product = self.mean_product(&rest, [0.0; 2]);
        let present = self.present(solver);
        self.factorise(solver, &present);
        let predictor = self.newton(solver, &present, 0.0, &rest);
        let parts = self.longest(&predictor).map(|part| part.min(1.0));
        let centring = (self.mean_product(&predictor, parts) / product).powi(3);
        let step = self.newton(solver, &present, centring * product, &predictor);
        let parts = self.longest(&step).map(|part| (SHARE * part).min(1.0));
        if !parts.iter().all(|part| *part > 1e-12) || !product.is_finite() {
            return false;
        }
        self.x.iter_mut().zip(&step.x).for_each(|(one, step)| one.go(step, parts));
        self.s.iter_mut().zip(&step.s).for_each(|(one, step)| one.go(step, parts));
        self.y.iter_mut().zip(&step.y).for_each(|(one, step)| *one += parts[1] * step);
        true
    }

    fn present(&self, solver: &Solver) -> Present {
        let values: Vec<f64> = self.x.iter().map(|x| x.value).collect();
        let rows = &solver.rows;
        Present {
            stiffnesses: self.s.iter().map(Bounded::stiffness).collect(),
            lacks: self.s.iter().zip(&rows.heads).map(|(s, head)| s.value - rows.value(head, &values)).collect(),
        }
    }

    /// Computes Dx + AᵀDsA and its factors.
    fn factorise(&self, solver: &mut Solver, present: &Present) {
        let numbers = solver.factor.numbers();
        numbers.fill(0.0);
        for (&at, x) in solver.diagonal.iter().zip(&self.x) {
            numbers[at] += x.stiffness();
        }
        let mut places = solver.rows.places.as_slice();
        for (head, stiffness) in solver.rows.heads.iter().zip(&present.stiffnesses) {
            let coefficients = &solver.rows.coefficients[head.terms.clone()];
            for (at, a) in coefficients.iter().enumerate() {
                let stiffened = stiffness * a;
                let (these, others) = places.split_at(at + 1);
                these.iter().zip(coefficients).for_each(|(&place, b)| numbers[place as usize] += stiffened * b);
                places = others;
            }
        }
        solver.factor.factorise();
    }

    /// The step towards products `target`, with the second order of a predictor's step.
    fn newton(&self, solver: &Solver, present: &Present, target: f64, predictor: &Step) -> Step {
        let wanted_x: Vec<[f64; 2]> =
            self.x.iter().zip(&predictor.x).map(|(x, before)| x.wanted(target, before)).collect();
        // Forces on x: those of its bounds, less the residual of the dual equation c − Aᵀy − z_lower + z_upper = 0.
        let mut move_x: Vec<f64> = (0..self.x.len())
            .map(|at| {
                let x = &self.x[at];
                x.force(wanted_x[at]) - self.cost[at] + x.multipliers[0] - x.multipliers[1]
            })
            .collect();
        let n_rows = self.s.len();
        let mut forces = Vec::with_capacity(n_rows);
        let rows = &solver.rows;
        let heads = || rows.heads.iter().zip(&self.s).zip(present.stiffnesses.iter().zip(&present.lacks));
        for (((head, s), (stiffness, lack)), (before, y)) in heads().zip(predictor.s.iter().zip(&self.y)) {
            let force = s.force(s.wanted(target, before)) - y + s.multipliers[0] - s.multipliers[1];
            rows.add_to(head, &mut move_x, y + force + stiffness * lack);
            forces.push(force);
        }
        solver.factor.solve(&mut move_x);
        let mut step = Step { x: Vec::new(), s: Vec::with_capacity(n_rows), y: Vec::with_capacity(n_rows) };
        for (((head, s), (stiffness, lack)), (before, force)) in heads().zip(predictor.s.iter().zip(&forces)) {
            let moved = rows.value(head, &move_x) - lack;
            step.y.push(force - stiffness * moved);
            step.s.push(s.moved(moved, s.wanted(target, before)));
        }
        step.x =
            self.x.iter().zip(&wanted_x).zip(&move_x).map(|((x, &wanted), &value)| x.moved(value, wanted)).collect();
        step
    }

    /// The greatest parts of a step that leave gaps and multipliers positive.
    fn longest(&self, step: &Step) -> [f64; 2] {
        let both = self.x.iter().zip(&step.x).chain(self.s.iter().zip(&step.s));
        both.map(|(one, step)| one.longest(step))
            .fold([f64::INFINITY; 2], |least, parts| [least[0].min(parts[0]), least[1].min(parts[1])])
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
