//! Benchmark of linear programs of the size of a drive with 100 key frames and 40 landmarks, on one core.

use std::time::Instant;

use interval::{
    Interval,
    linear_program::{LinearProgram, Solver, certified_minimum},
};

const N_FRAMES: usize = 100;
const N_LANDMARKS: usize = 40;
const N_CONSTANTS: usize = 12;

fn main() {
    let Some(program) = program() else { return };
    let started = Instant::now();
    let mut solver = Solver::new(&program);
    let prepared_s = started.elapsed().as_secs_f64();
    let (mut solved_s, mut certified_s) = (0.0, 0.0);
    let costs = [0, 1, 2].map(|axis| [1.0, -1.0].map(|sign| (3 * (N_FRAMES - 1) + axis, sign)));
    for cost in costs.as_flattened() {
        let started = Instant::now();
        let duals = solver.minimise(&[*cost]);
        solved_s += started.elapsed().as_secs_f64();
        let started = Instant::now();
        std::hint::black_box(certified_minimum(&program, &[*cost], &duals));
        certified_s += started.elapsed().as_secs_f64();
    }
    let (n_rows, n_variables) = (program.n_rows(), program.n_variables());
    println!("linear program, {n_rows} rows, {n_variables} variables: prepared in {:.1} ms", 1e3 * prepared_s);
    println!("linear program, a bound    {:8.2} ms", 1e3 * (solved_s + certified_s) / 6.0);
    println!("  of which the certificate {:8.2} %", 100.0 * certified_s / (solved_s + certified_s));
}

/// A number from 0 to 1, by the generator xorshift64.
fn unit(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// A program with a planted solution: five rows for each way from a key frame to the next, and three for each of four landmarks seen from it.
fn program() -> Option<LinearProgram> {
    let state = &mut 77;
    let landmark = |landmark: usize, axis: usize| 3 * N_FRAMES + 2 * landmark + axis;
    let constant = |state: &mut u64| landmark(N_LANDMARKS, 0) + (unit(state) * N_CONSTANTS as f64) as usize;
    let n_variables = landmark(N_LANDMARKS, 0) + N_CONSTANTS;
    let solution: Vec<f64> = (0..n_variables).map(|_| 0.2 * unit(state) - 0.1).collect();
    let mut program = LinearProgram::new(vec![Interval::centred(0.0, 0.2); n_variables]).ok()?;
    let mut add = |state: &mut u64, members: Vec<usize>| {
        let terms: Vec<(usize, f64)> = members.into_iter().map(|at| (at, 2.0 * unit(state) - 1.0)).collect();
        let at: f64 = terms.iter().map(|&(at, a)| a * solution[at]).sum();
        let sides = Interval::new(at - 0.02 * unit(state), at + 0.02 * unit(state));
        program.add_row(&terms, sides).ok()
    };
    for frame in 0..N_FRAMES {
        let pose = |frame: usize| (0..3).map(move |axis| 3 * frame + axis);
        for _ in 0..5 {
            let mut members: Vec<usize> = pose(frame).chain(frame.checked_sub(1).into_iter().flat_map(pose)).collect();
            members.extend((0..3).map(|_| constant(state)));
            add(state, members)?;
        }
        for row in 0..12 {
            let seen = (frame * N_LANDMARKS / N_FRAMES + row / 3 * 2) % N_LANDMARKS;
            let mut members: Vec<usize> = pose(frame).chain([landmark(seen, 0), landmark(seen, 1)]).collect();
            members.extend((0..4).map(|_| constant(state)));
            add(state, members)?;
        }
    }
    Some(program)
}
