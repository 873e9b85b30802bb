//! Bounds of quantities by a linear program, computed one program after the other.

use interval::{
    Interval,
    linear_program::{Search, Shares, Solver, certified_maximum, certified_minimum, shares},
};

use super::{Related, Variable, width::WidthParts};

/// Steps of the solver at a time. A program takes some fifteen, so that eight programs are solved within sixteen wheel readings. With four at a time,
/// the bounds came later, and the boxes of paper 3's loop were 74.8 mm wide in place of 72.4 (seed 0).
const AT_ONCE: usize = 8;
/// How near to the best bound the solver stops, in half widths of the box that is known. A hundredth of that would take a third more steps, for bounds
/// that are narrower by 0.1 %.
const GAP: f64 = 1e-3;

/// Work on the bounds of chosen quantities over all values that satisfy the rows.
///
/// Each quantity needs two programs, for its least and its greatest value. They are solved one after the other, a few steps of the solver at a time, so
/// that the caller spreads the work over the steps of a drive.
pub struct Hull {
    related: Related,
    solver: Solver,
    /// The work on the present program; `None` before its first step.
    search: Option<Search>,
    /// The quantities with the indices of their variables.
    wanted: Vec<(Variable, usize)>,
    /// The bounds certified so far: the least value of the first quantity, its greatest value, the least of the second, …
    certified: Vec<f64>,
    /// What each of these bounds consists of.
    shares: Vec<Option<Shares>>,
}

impl Hull {
    /// No bounds yet of the quantities given.
    pub fn new(related: Related, wanted: Vec<Variable>) -> Hull {
        let wanted = of_program(&related, wanted);
        let solver = Solver::new(&related.program).stopped_within(GAP);
        Hull { related, solver, search: None, wanted, certified: Vec::new(), shares: Vec::new() }
    }

    /// Takes some steps of the solver. Returns whether the last program is solved.
    pub fn advance(&mut self) -> bool {
        let n_done = self.certified.len();
        let Some(&(_, index)) = self.wanted.get(n_done / 2) else { return true };
        let is_least = n_done.is_multiple_of(2);
        let sign = if is_least { 1.0 } else { -1.0 };
        let search = self.search.get_or_insert_with(|| self.solver.begin(&[(index, sign)]));
        if self.solver.advance(search, AT_ONCE) {
            let duals = self.solver.duals(search);
            let certified = if is_least { certified_minimum } else { certified_maximum };
            self.certified.push(certified(&self.related.program, &[(index, 1.0)], &duals));
            self.shares.push(shares(&self.related.program, &[(index, sign)], &duals));
            self.search = None;
        }
        self.certified.len() == 2 * self.wanted.len()
    }

    /// What makes the widths of the bounds, in the order in which they were asked for.
    pub(super) fn width_parts(&self) -> Vec<WidthParts> {
        let sides = self.shares.chunks_exact(2).filter_map(|sides| Some([sides[0].as_ref()?, sides[1].as_ref()?]));
        sides.map(|sides| WidthParts::new(&self.related, sides)).collect()
    }

    /// What makes the widths of the bounds of a pose, whose coordinates have to be the first three quantities that were asked for.
    pub fn pose_width(&self) -> Option<[WidthParts; 3]> {
        let mut parts = self.width_parts().into_iter();
        Some([parts.next()?, parts.next()?, parts.next()?])
    }

    /// The quantities whose bounds are asked for.
    pub fn wanted(&self) -> impl Iterator<Item = Variable> {
        self.wanted.iter().map(|&(variable, _)| variable)
    }

    /// No bounds yet of other quantities by the same program, which need not be prepared for its solver anew.
    pub fn go_on_with(self, wanted: Vec<Variable>) -> Hull {
        let wanted = of_program(&self.related, wanted);
        Hull { wanted, search: None, certified: Vec::new(), shares: Vec::new(), ..self }
    }

    /// The program and its labels.
    pub fn related(&self) -> &Related {
        &self.related
    }

    /// The program and its labels.
    pub fn into_related(self) -> Related {
        self.related
    }

    /// The bounds of the quantities in the order in which they were asked for; `None` where the rows contradict each other.
    pub fn bounds(&self) -> Option<Vec<Interval>> {
        let sides = self.certified.chunks_exact(2);
        let bounds = self.wanted.iter().zip(sides).map(|(&(variable, _), sides)| {
            let reference = Interval::point(self.related.domain.reference(variable));
            let value = self.related.domain.value(variable);
            let bound = if sides[0] <= sides[1] { Interval::new(sides[0], sides[1]) } else { Interval::EMPTY };
            Some((reference + bound).intersect(value)).filter(|bound| !bound.is_empty())
        });
        bounds.collect()
    }
}

/// Those of some quantities that a program has, with the indices of their variables.
fn of_program(related: &Related, wanted: Vec<Variable>) -> Vec<(Variable, usize)> {
    wanted.into_iter().filter_map(|variable| Some((variable, related.index(variable)?))).collect()
}
