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
/// A cart has gone some 2 m from one post to a second, and some 3 m on to a third, each distance known to 0.1 m. The third post is then found to be
/// at 5.2 m. Where are the others?
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
mod tests;
