//! Tests of networks on chains worked out by hand, and of their laws on random networks.
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::super::{ForwardBackward, Within};
use super::*;

fn difference(by: f64) -> ForwardBackward<2> {
    ForwardBackward::new(|[from, to]| to - from, Interval::point(by))
}

/// A chain x₀, x₁, … of variables in [0, 100], each one more than the one before.
fn chain(n_variables: usize) -> (Network, Vec<VariableId>) {
    let mut network = Network::new(0.01);
    let ids: Vec<_> = (0..n_variables).map(|_| network.add_variable(Interval::new(0.0, 100.0))).collect();
    for pair in ids.windows(2) {
        network.add_contractor([pair[0], pair[1]], difference(1.0)).unwrap();
    }
    (network, ids)
}

#[test]
fn what_is_learnt_at_one_end_of_a_chain_reaches_the_other() {
    let (mut network, ids) = chain(20);
    assert_eq!(network.contract(), Outcome::Feasible);
    // By hand: x₀ ≥ 0 makes x₁₉ ≥ 19, and x₁₉ ≤ 100 makes x₀ ≤ 81.
    assert!((network.domain(ids[0]).unwrap().hi() - 81.0).abs() < 1e-9);
    assert!((network.domain(ids[19]).unwrap().lo() - 19.0).abs() < 1e-9);
    network.narrow(ids[19], Interval::point(30.0)).unwrap();
    network.contract();
    let first = network.domain(ids[0]).unwrap();
    assert!(first.contains(11.0) && first.width() < 1e-9, "{first}");
}

#[test]
fn what_has_left_the_network_acts_no_more() {
    let (mut network, ids) = chain(4);
    network.contract();
    let before = network.domain(ids[0]);
    network.remove_variable(ids[1]);
    assert_eq!((network.n_variables(), network.n_contractors()), (3, 1));
    network.narrow(ids[3], Interval::point(50.0)).unwrap();
    network.contract();
    assert_eq!(network.domain(ids[0]), before, "nothing links it to the others");
    assert!(network.domain(ids[2]).unwrap().width() < 1e-9, "which are still linked");
    assert_eq!(network.domain(ids[1]), None);
    assert_eq!(network.narrow(ids[1], Interval::ONE), Err(UnknownVariable(ids[1])));
    assert_eq!(network.add_contractor([ids[1], ids[2]], difference(1.0)), Err(UnknownVariable(ids[1])));
}

#[test]
fn a_contractor_is_applied_again_only_when_its_variables_have_shrunk() {
    let n_applied = Arc::new(AtomicUsize::new(0));
    let counting = |n_applied: Arc<AtomicUsize>| {
        struct Counting(Arc<AtomicUsize>);
        impl Contractor<1> for Counting {
            fn contract(&self, _: &mut IntervalBox<1>) -> Outcome {
                self.0.fetch_add(1, Ordering::Relaxed);
                Outcome::Feasible
            }
        }
        Counting(n_applied)
    };
    let mut network = Network::new(0.1);
    let [x, y] = [(); 2].map(|()| network.add_variable(Interval::new(0.0, 100.0)));
    network.add_contractor([x], counting(n_applied.clone())).unwrap();
    let n_after = |network: &mut Network| {
        network.contract();
        n_applied.load(Ordering::Relaxed)
    };
    assert_eq!(n_after(&mut network), 1);
    assert_eq!(n_after(&mut network), 1);
    network.narrow(y, Interval::ONE).unwrap();
    assert_eq!(n_after(&mut network), 1, "the other variable is none of its own");
    // Three times 4 % are more than 10 %, though none of them is.
    for (to, n_applied) in [(96.0, 1), (92.0, 1), (88.0, 2), (80.0, 2), (79.0, 3)] {
        network.narrow(x, Interval::new(0.0, to)).unwrap();
        assert_eq!(n_after(&mut network), n_applied, "at {to}");
    }
}

#[test]
fn a_contradiction_empties_every_variable_and_stays() {
    let (mut network, ids) = chain(3);
    network.add_contractor([ids[2], ids[0]], difference(1.0)).unwrap();
    assert_ne!(network.contract(), Outcome::Feasible);
    assert!(ids.iter().all(|&id| network.domain(id).unwrap().is_empty()));
    let late = network.add_variable(Interval::ONE);
    network.add_contractor([late], Within(IntervalBox::new([Interval::ONE]))).unwrap();
    assert_ne!(network.contract(), Outcome::Feasible);
    assert!(network.domain(late).unwrap().is_empty());
}

#[test]
fn a_variable_may_occur_twice_in_one_contractor() {
    let mut network = Network::new(0.01);
    let x = network.add_variable(Interval::new(-5.0, 5.0));
    // x·x = 4 with x ≥ 0, stated of two variables that are the same one.
    network.add_contractor([x, x], ForwardBackward::new(|[a, b]| a * b, Interval::point(4.0))).unwrap();
    network.narrow(x, Interval::new(0.0, 5.0)).unwrap();
    network.contract();
    let left = network.domain(x).unwrap();
    // By hand: x ∈ [0.8, 5] after one pass, and the limit is 2; a share of 1 % is where it may stop.
    assert!(left.contains(2.0) && left.hi() < 5.0 + 1e-9 && left.lo() > 0.79, "{left}");
}

/// A number from 0 to 1, by the generator xorshift64.
fn next(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// An interval around a value, which is often at an end of it, widened by the rounding of a value that was computed in doubles.
fn around(value: f64, state: &mut u64) -> Interval {
    let [below, above] = [(); 2].map(|()| if next(state) < 0.3 { 0.0 } else { 10f64.powf(3.0 * next(state) - 2.0) });
    Interval::new(value - below, value + above).inflate(1e-12 * (1.0 + value.abs()))
}

/// One of four constraints that the values x, y and z satisfy.
fn constraint(kind: usize, [x, y, z]: [f64; 3], state: &mut u64) -> ForwardBackward<3> {
    match kind {
        0 => ForwardBackward::new(|[x, y, z]| x + y - 2.0 * z, around(x + y - 2.0 * z, state)),
        1 => ForwardBackward::new(|[x, y, z]| x * y - z, around(x * y - z, state)),
        2 => ForwardBackward::new(|[x, y, z]| (x - y).hypot(z), around((x - y).hypot(z), state)),
        _ => ForwardBackward::new(|[x, y, z]| x * z.cos() - y * z.sin(), around(x * z.cos() - y * z.sin(), state)),
    }
}

#[test]
fn random_networks_never_grow_and_never_lose_a_planted_solution() {
    let state = &mut 20_261_124;
    let n_contractions = 20_000;
    let mut n_shrunk = 0;
    for _ in 0..n_contractions / 10 {
        let mut network = Network::new(if next(state) < 0.5 { 0.01 } else { 0.3 });
        let mut solution: Vec<(VariableId, f64)> = Vec::new();
        let mut contractors = Vec::new();
        for _ in 0..10 {
            for _ in 0..3 {
                let value = 6.0 * next(state) - 3.0;
                let known = if next(state) < 0.3 { Interval::ENTIRE } else { around(value, state) };
                solution.push((network.add_variable(known), value));
            }
            for _ in 0..4 {
                let on = [(); 3].map(|()| solution[(next(state) * solution.len() as f64) as usize]);
                let contractor = constraint((4.0 * next(state)) as usize, on.map(|(_, value)| value), state);
                contractors.push(network.add_contractor(on.map(|(id, _)| id), contractor).unwrap());
            }
            let before: Vec<Interval> = solution.iter().map(|&(id, _)| network.domain(id).unwrap()).collect();
            assert_eq!(network.contract(), Outcome::Feasible);
            for (&(id, value), before) in solution.iter().zip(before) {
                let after = network.domain(id).unwrap();
                assert!(after.contains(value), "{value} is not in {after}, which was {before}");
                assert!(after.is_subset_of(before), "{before} has become {after}");
                n_shrunk += usize::from(after != before);
            }
            // The window slides: what is removed may take any of the constraints with it.
            let leaving = (next(state) * solution.len() as f64) as usize;
            network.remove_variable(solution.remove(leaving).0);
            network.remove_contractor(contractors[(next(state) * contractors.len() as f64) as usize]);
        }
    }
    assert!(n_shrunk > 2 * n_contractions, "only {n_shrunk} intervals were contracted");
}

#[test]
fn the_worklist_leaves_no_more_than_all_contractors_applied_in_turn() {
    let state = &mut 7;
    for _ in 0..300 {
        let values: [f64; 5] = array::from_fn(|_| 6.0 * next(state) - 3.0);
        let domain = IntervalBox::<5>::new(values.map(|value| around(value, state)));
        let mut network = Network::new(1e-9);
        let ids = domain.components().map(|known| network.add_variable(known));
        let all: Vec<_> = (0..6)
            .map(|_| {
                let on = [(); 3].map(|()| (next(state) * 5.0) as usize);
                (on, constraint((4.0 * next(state)) as usize, on.map(|at| values[at]), state))
            })
            .filter(|([a, b, c], _)| a != b && b != c && a != c)
            .collect();
        for (on, contractor) in &all {
            network.add_contractor(on.map(|at| ids[at]), contractor.clone()).unwrap();
        }
        network.contract();
        let mut in_turn = domain;
        for _ in 0..Network::MOST_PASSES {
            all.iter().for_each(|(on, contractor)| {
                contractor.on_axes(*on).contract(&mut in_turn);
            });
        }
        for (axis, id) in ids.into_iter().enumerate() {
            let (by_list, in_turn) = (network.domain(id).unwrap(), in_turn[axis]);
            let slack = 1e-3 * (in_turn.width() + 1e-6);
            assert!(by_list.is_subset_of(in_turn.inflate(slack)), "{by_list} is wider than {in_turn}");
        }
    }
}
