//! A network of contractors on any number of variables, contracted by a worklist.

use std::array;
use std::collections::{BTreeMap, VecDeque};

use super::combinators::narrowed;
use super::{Contractor, Outcome};
use crate::{Interval, IntervalBox};

/// Constraints on any number of variables: an interval for each variable, and contractors that each act on a few of them. Both can be added and
/// removed at any time, as a window that slides along the data does it.
///
/// **Constraint.** All constraints of the contractors that are in the network. A contractor that is removed is no longer applied, but what it has
/// contracted stays contracted: a network forgets no bounds.
///
/// **Sound.** Each contractor is. It is applied to the box of its own variables, and every variable keeps the intersection of its interval and the
/// interval that is left.
///
/// **Not optimal**, even if all contractors are: a box does not express how its sides depend on each other. [`LinearProgram`] keeps such relations
/// where they are linear.
///
/// **Worklist.** A contractor is applied when it is new, and again when one of its variables has shrunk by more than a given share of its width since
/// the contractor was last put on the list. Contractors are applied in the order in which they were put there, so that the result is always the same.
///
/// **Source.** A. Mackworth, "Consistency in networks of relations", Artificial Intelligence 8 (1977), algorithm AC-3; for intervals F. Benhamou,
/// F. Goualard, L. Granvilliers, J.-F. Puget, "Revising hull and box consistency", ICLP 1999 (HC4).
///
/// # Example
///
/// A cart has gone some 2 m from one post to a second, and some 3 m on to a third, each distance known to 0.1 m. The third post is then found to be at
/// 5.2 m. Where are the others?
///
/// ```
/// use interval::Interval;
/// use interval::contractor::{ForwardBackward, Network};
///
/// let mut network = Network::new(0.01);
/// let [first_m, second_m, third_m] = [(); 3].map(|()| network.add_variable(Interval::ENTIRE));
/// let way_m = |way_m| ForwardBackward::new(|[from, to]| to - from, Interval::centred(way_m, 0.1));
/// network.add_contractor([first_m, second_m], way_m(2.0))?;
/// network.add_contractor([second_m, third_m], way_m(3.0))?;
/// network.contract();
/// assert_eq!(network.domain(first_m), Some(Interval::ENTIRE));
///
/// // What is known of the third post goes back to the others.
/// network.narrow(third_m, Interval::point(5.2))?;
/// network.contract();
/// let first = network.domain(first_m).unwrap_or(Interval::EMPTY);
/// assert!(first.contains(0.0) && first.is_subset_of(Interval::centred(0.2, 0.2 + 1e-9)));
///
/// // The window slides on: the first post leaves the network together with the contractor that acts on it.
/// network.remove_variable(first_m);
/// assert_eq!((network.n_variables(), network.n_contractors()), (2, 1));
/// # Ok::<(), interval::contractor::UnknownVariable>(())
/// ```
///
/// [`LinearProgram`]: crate::linear_program::LinearProgram
pub struct Network {
    ratio: f64,
    /// How many variables and contractors have been added so far; also the number of the next one.
    n_added: usize,
    variables: BTreeMap<VariableId, Variable>,
    members: BTreeMap<ContractorId, Member>,
    worklist: VecDeque<ContractorId>,
    /// Why no solution is left, once the network has found that.
    contradiction: Option<&'static str>,
}

/// A variable of a [`Network`]. The number is never given to another variable of the same network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VariableId(usize);

/// A contractor in a [`Network`]. The number is never given to another contractor of the same network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContractorId(usize);

/// A network was asked about a variable that it does not have, or has no longer. The text follows "failed to …".
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("find variable {}: the network does not have it, or has it no longer", self.0.0)]
pub struct UnknownVariable(pub VariableId);

struct Variable {
    domain: Interval,
    /// What the domain was when the variable's contractors were last put on the worklist.
    announced: Interval,
    contractors: Vec<ContractorId>,
}

struct Member {
    on: Vec<VariableId>,
    apply: Box<Application>,
    is_listed: bool,
}

/// Contracts the intervals of a contractor's variables.
type Application = dyn Fn(&mut [Interval]) -> Outcome + Send + Sync;

impl Network {
    /// Greatest number of applications in one call of [`contract`](Self::contract), per contractor. Where convergence is so slow, each application
    /// gains little, and the next call goes on where this one has stopped.
    pub const MOST_PASSES: usize = 1000;

    /// A network without variables. A variable's contractors are applied again when it has shrunk by more than the fraction `ratio` of its width.
    pub fn new(ratio: f64) -> Self {
        Network {
            ratio,
            n_added: 0,
            variables: BTreeMap::new(),
            members: BTreeMap::new(),
            worklist: VecDeque::new(),
            contradiction: None,
        }
    }

    /// Adds a variable that is in the interval `domain`.
    pub fn add_variable(&mut self, domain: Interval) -> VariableId {
        let id = VariableId(self.next_number());
        let domain = if self.contradiction.is_some() { Interval::EMPTY } else { domain };
        self.variables.insert(id, Variable { domain, announced: domain, contractors: Vec::new() });
        if domain.is_empty() {
            self.contradict("a variable has no value");
        }
        id
    }

    /// Adds a contractor on the given variables: its variable number i is `on[i]`.
    pub fn add_contractor<const N: usize>(
        &mut self,
        on: [VariableId; N],
        contractor: impl Contractor<N> + Send + Sync + 'static,
    ) -> Result<ContractorId, UnknownVariable> {
        if let Some(&unknown) = on.iter().find(|id| !self.variables.contains_key(id)) {
            return Err(UnknownVariable(unknown));
        }
        let id = ContractorId(self.next_number());
        for variable in &on {
            if let Some(variable) = self.variables.get_mut(variable) {
                variable.contractors.push(id);
            }
        }
        let apply = Box::new(move |domains: &mut [Interval]| {
            let mut domain = IntervalBox::<N>::new(array::from_fn(|at| domains[at]));
            let outcome = contractor.contract(&mut domain);
            domains.copy_from_slice(&domain.components());
            outcome
        });
        self.members.insert(id, Member { on: on.to_vec(), apply, is_listed: true });
        self.worklist.push_back(id);
        Ok(id)
    }

    /// Removes a variable and all contractors that act on it, and returns the variable's interval. The intervals of the other variables stay.
    pub fn remove_variable(&mut self, id: VariableId) -> Option<Interval> {
        let variable = self.variables.remove(&id)?;
        variable.contractors.into_iter().for_each(|contractor| self.remove_contractor(contractor));
        Some(variable.domain)
    }

    /// Removes a contractor, if the network has it. What it has contracted stays contracted.
    pub fn remove_contractor(&mut self, id: ContractorId) {
        let Some(member) = self.members.remove(&id) else { return };
        for variable in member.on {
            if let Some(variable) = self.variables.get_mut(&variable) {
                variable.contractors.retain(|&other| other != id);
            }
        }
        self.worklist.retain(|&other| other != id);
    }

    /// Intersects a variable's interval with one that is known from elsewhere.
    pub fn narrow(&mut self, id: VariableId, known: Interval) -> Result<(), UnknownVariable> {
        let domain = self.domain(id).ok_or(UnknownVariable(id))?;
        self.set(id, domain.intersect(known));
        if domain.intersect(known).is_empty() {
            self.contradict("a variable has no value");
        }
        Ok(())
    }

    /// The interval of a variable; empty when the constraints contradict each other, `None` when the network has no such variable.
    pub fn domain(&self, id: VariableId) -> Option<Interval> {
        self.variables.get(&id).map(|variable| variable.domain)
    }

    /// Number of variables.
    pub fn n_variables(&self) -> usize {
        self.variables.len()
    }

    /// Number of contractors.
    pub fn n_contractors(&self) -> usize {
        self.members.len()
    }

    /// Applies contractors until no variable shrinks by more than the network's share. When no solution is left, all intervals become empty and stay
    /// so.
    pub fn contract(&mut self) -> Outcome {
        for _ in 0..Self::MOST_PASSES * self.members.len() {
            if self.contradiction.is_some() {
                break;
            }
            let Some(id) = self.worklist.pop_front() else { break };
            self.apply(id);
        }
        self.contradiction.map_or(Outcome::Feasible, Outcome::Empty)
    }

    fn apply(&mut self, id: ContractorId) {
        let Some(member) = self.members.get_mut(&id) else { return };
        member.is_listed = false;
        let on = member.on.clone();
        let mut left: Vec<Interval> = on.iter().map(|id| self.variables[id].domain).collect();
        if let Outcome::Empty(cause) = (member.apply)(&mut left) {
            self.contradict(cause);
            return;
        }
        for (variable, left) in on.into_iter().zip(left) {
            // A variable that the contractor acts on twice has two results, of which both hold.
            let left = left.intersect(self.variables[&variable].domain);
            self.set(variable, left);
            if left.is_empty() {
                self.contradict("a contractor left a variable two intervals that do not meet");
                return;
            }
        }
    }

    /// Sets a variable's interval, and puts the variable's contractors on the worklist when it has shrunk enough.
    fn set(&mut self, id: VariableId, domain: Interval) {
        let Some(variable) = self.variables.get_mut(&id) else { return };
        variable.domain = domain;
        if !narrowed(variable.announced, domain, self.ratio) {
            return;
        }
        variable.announced = domain;
        for contractor in &variable.contractors {
            if let Some(member) = self.members.get_mut(contractor).filter(|member| !member.is_listed) {
                member.is_listed = true;
                self.worklist.push_back(*contractor);
            }
        }
    }

    fn contradict(&mut self, cause: &'static str) {
        self.contradiction = self.contradiction.or(Some(cause));
        self.variables.values_mut().for_each(|variable| variable.domain = Interval::EMPTY);
        self.worklist.clear();
    }

    fn next_number(&mut self) -> usize {
        self.n_added += 1;
        self.n_added - 1
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
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
        let [below, above] =
            [(); 2].map(|()| if next(state) < 0.3 { 0.0 } else { 10f64.powf(3.0 * next(state) - 2.0) });
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
}
