use super::*;
use crate::{
    Interval,
    linear_program::{certified_minimum, contradicting_rows},
};

struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    fn below(&mut self, most: usize) -> usize {
        (self.unit() * most as f64) as usize
    }
}

/// A program with a planted solution: sizes from 10⁻³ to 10³, equations, redundant and repeated rows, open sides.
fn planted(draw: &mut Draw, n_variables: usize, n_rows: usize) -> (LinearProgram, Vec<f64>) {
    let mut solution = Vec::new();
    let boxes = (0..n_variables)
        .map(|_| {
            let (size, middle) = (10f64.powf(draw.between(-3.0, 1.0)), draw.between(-2.0, 2.0));
            let values = Interval::new(middle - size * draw.unit(), middle + size * draw.unit());
            solution.push(if draw.unit() < 0.3 { values.lo() } else { draw.between(values.lo(), values.hi()) });
            values
        })
        .collect();
    let mut program = LinearProgram::new(boxes).unwrap();
    for _ in 0..n_rows {
        let n_terms = 1 + draw.below(5);
        let size = 10f64.powf(draw.between(-3.0, 3.0));
        let terms: Vec<(usize, f64)> =
            (0..n_terms).map(|_| (draw.below(n_variables), size * draw.between(-1.0, 1.0))).collect();
        let at: Interval =
            terms.iter().fold(Interval::ZERO, |sum, &(variable, a)| sum + Interval::point(solution[variable]) * a);
        let mut slack = || if draw.unit() < 0.3 { 0.0 } else { size * draw.unit() };
        let (mut lo, mut hi) = (at.lo() - slack(), at.hi() + slack());
        match draw.below(6) {
            0 => lo = f64::NEG_INFINITY,
            1 => hi = f64::INFINITY,
            2 => (lo, hi) = (at.lo(), at.hi()),
            _ => {}
        }
        program.add_row(&terms, Interval::new(lo, hi)).unwrap();
    }
    (program, solution)
}

#[test]
fn no_bound_excludes_a_solution_and_most_are_sharp() {
    let mut draw = Draw(20_261_124);
    let mut n_open = 0;
    let n_programs: usize = std::env::var("WHEREIN_PROGRAMS").map_or(400, |count| count.parse().unwrap());
    for _ in 0..n_programs {
        let (n_variables, n_rows) = (1 + draw.below(12), draw.below(30));
        let (program, solution) = planted(&mut draw, n_variables, n_rows);
        let cost = vec![(draw.below(n_variables), if draw.unit() < 0.5 { 1.0 } else { -1.0 })];
        let truth = cost[0].1 * solution[cost[0].0];
        let solver = Solver::new(&program);
        let best = certified_minimum(&program, &cost, &solver.clone().minimise(&cost));
        assert!(best <= truth, "{best} excludes {truth}");
        let mut before = f64::NEG_INFINITY;
        for steps in [0, 1, 2, 3, 5, 8, 12, 16, 24] {
            let duals = solver.clone().stopped_after(steps).minimise(&cost);
            let bound = certified_minimum(&program, &cost, &duals);
            assert!(bound <= truth, "{bound} excludes {truth} after {steps} steps");
            let perturbed: Vec<f64> = duals.iter().map(|dual| dual * draw.between(-0.5, 2.0)).collect();
            assert!(certified_minimum(&program, &cost, &perturbed) <= truth);
            before = bound;
        }
        // Forty steps bring nothing that twenty-four did not: the gap is closed.
        let width = program.variables()[cost[0].0].width();
        n_open += usize::from(best - before > 1e-5 * width);
    }
    assert!(n_open * 50 < n_programs, "{n_open} of {n_programs} programs need more than 24 steps");
}

#[test]
fn the_point_that_is_reached_is_the_corner_with_the_least_cost() {
    // By hand: 2x + y over x + y ≤ 4, x ≤ 3 in [0, 10]² is greatest at (3, 1).
    let mut program = LinearProgram::new(vec![Interval::new(0.0, 10.0); 2]).unwrap();
    program.add_row(&[(0, 1.0), (1, 1.0)], Interval::new(f64::NEG_INFINITY, 4.0)).unwrap();
    program.add_row(&[(0, 1.0)], Interval::new(f64::NEG_INFINITY, 3.0)).unwrap();
    let mut solver = Solver::new(&program);
    let mut search = solver.begin(&[(0, -2.0), (1, -1.0)]);
    while !solver.advance(&mut search, 5) {}
    let point = solver.point(&search);
    // The gap is 1e-5 of the half width of x₀, which is 5, times its cost of 2.
    assert!((point[0] - 3.0).abs() < 3e-4 && (point[1] - 1.0).abs() < 3e-4, "{point:?}");
}

#[test]
fn rows_that_contradict_each_other_are_found() {
    // x + y ≥ 3 with x ≤ y and y ≤ 1: x + y ≤ 2. The row on z has no part in it.
    let mut program = LinearProgram::new(vec![Interval::new(-10.0, 10.0); 3]).unwrap();
    program.add_row(&[(0, 1.0), (1, 1.0)], Interval::new(3.0, f64::INFINITY)).unwrap();
    program.add_row(&[(0, 1.0), (1, -1.0)], Interval::new(f64::NEG_INFINITY, 0.0)).unwrap();
    program.add_row(&[(1, 1.0)], Interval::new(f64::NEG_INFINITY, 1.0)).unwrap();
    program.add_row(&[(2, 1.0)], Interval::new(0.0, 1.0)).unwrap();
    let duals = Solver::new(&program).minimise(&[]);
    let rows = contradicting_rows(&program, &duals).unwrap();
    assert!([0, 1, 2].iter().all(|row| rows.contains(row)), "{rows:?} by {duals:?}");
    let bound = certified_minimum(&program, &[(2, 1.0)], &Solver::new(&program).minimise(&[(2, 1.0)]));
    assert!(bound > 10.0, "{bound}");
}
