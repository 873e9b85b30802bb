//! The linear program of related quantities, with what each of its rows and boxes comes from.

use std::collections::BTreeMap;

use interval::{
    Interval,
    linear_program::{LinearProgram, ProgramError, Solver, Terms, certified_maximum, certified_minimum},
};

use crate::bounds::Assumption;

use super::{Domain, Row, Variable};

/// A linear program over the deviations of all quantities from their reference values.
#[derive(Clone, Debug)]
pub struct Related {
    /// The program, whose variables are in the order of `variables`.
    pub program: LinearProgram,
    /// The quantities.
    pub variables: Vec<Variable>,
    /// The reference values and boxes of the quantities.
    pub domain: Domain,
    /// What each row of the program comes from.
    pub rows: Vec<RowLabel>,
    /// The readings that make the boxes of some poses.
    pub boxes: BTreeMap<Variable, BoxLabel>,
    /// What each quantity's box follows from, with the part of its half width that grows with it: if it is false, the quantity may be outside of its
    /// box. Parts may overlap.
    pub made_by: BTreeMap<Variable, Vec<(Suspect, f64)>>,
}

/// Something that a program takes for true and that may be false.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Suspect {
    /// What followed from readings before those that the program's rows and boxes name: where the robot and landmarks were, and what was learnt of the
    /// gyroscope. It is false only if a declared bound was broken before.
    Earlier,
    /// A declared bound.
    Bound(Assumption),
}

/// What a row of the program comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowLabel {
    /// Declared bounds with the part of the half width of the row's sides that each makes.
    pub parts: Vec<(Assumption, f64)>,
    /// The readings that the row is made of.
    pub readings: Vec<Readings>,
    /// Whether the row follows from what was learnt earlier, from readings that it does not name.
    pub is_learnt: bool,
    /// A declared bound without which the row says nothing at all, such as the number of wrong codes in a reading.
    pub void_without: Option<Assumption>,
}

/// The readings of one device that were taken in a span of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Name of the device, as in the names of bounds: `wheels`, `gyro`, `flow`, `floor_camera`, ….
    pub device: &'static str,
    /// Stamps of the first and of the last reading; the same for a single one.
    pub span_s: [f64; 2],
}

/// The reading that makes the box of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxLabel {
    /// The declared bound that stands for all that the reading relies on.
    pub bound: Assumption,
    /// Whether the box follows from the reading alone, and not from what was known before as well.
    pub is_alone: bool,
    /// The reading.
    pub reading: Readings,
    /// Whether the reading makes the box along x, along y and in heading.
    pub axes: [bool; 3],
}

impl Related {
    /// The program of rows, each with what it comes from. The quantities' boxes are made by the declared bounds that they are named for; poses and
    /// landmarks, which no bound is named for, follow from earlier readings.
    pub(super) fn new(
        domain: Domain,
        rows: Vec<(Row, Origin)>,
        boxes: BTreeMap<Variable, BoxLabel>,
    ) -> Result<Related, ProgramError> {
        let variables: Vec<Variable> = domain.iter().map(|(variable, _)| variable).collect();
        let made_by = |variable: Variable| {
            let half = domain.deviation(variable).magnitude();
            makers(variable, boxes.get(&variable)).into_iter().map(|suspect| (suspect, half)).collect()
        };
        let made_by = variables.iter().map(|&variable| (variable, made_by(variable))).collect();
        let index: BTreeMap<Variable, usize> = variables.iter().enumerate().map(|(idx, &one)| (one, idx)).collect();
        let deviations = variables.iter().map(|&variable| domain.deviation(variable)).collect();
        let mut program = LinearProgram::new(deviations)?;
        let mut labels = Vec::with_capacity(rows.len());
        for (row, Origin { span_s, is_learnt, void_without }) in rows {
            let indexed = |&(variable, coefficient): &(Variable, f64)| Some((*index.get(&variable)?, coefficient));
            // A row of a quantity that the domain does not have says nothing here.
            let Some(terms) = row.terms.iter().map(indexed).collect::<Option<Vec<(usize, f64)>>>() else { continue };
            program.add_row(&terms, row.sides)?;
            let readings = row.devices.iter().map(|&device| Readings { device, span_s }).collect();
            labels.push(RowLabel { parts: row.parts, readings, is_learnt, void_without });
        }
        Ok(Related { program, variables, domain, rows: labels, boxes, made_by })
    }

    /// Bounds of a linear function of quantities, by a solver of this program; `None` where the program does not have one of the quantities, and
    /// where its rows contradict each other.
    pub fn bounds_of(&self, solver: &mut Solver, function: &[(Variable, f64)]) -> Option<Interval> {
        let index = |&(variable, a): &(Variable, f64)| Some((self.index(variable)?, a));
        let terms: Vec<(usize, f64)> = function.iter().map(index).collect::<Option<_>>()?;
        let parts = function.iter().map(|&(variable, a)| Interval::point(self.domain.reference(variable)) * a);
        let reference = parts.fold(Interval::ZERO, |sum, part| sum + part);
        certified_bounds(&self.program, solver, &terms).map(|bounds| reference + bounds)
    }

    /// Index of a quantity among the program's variables.
    pub fn index(&self, variable: Variable) -> Option<usize> {
        self.variables.iter().position(|&one| one == variable)
    }
}

/// Certified bounds of a linear function of a program's variables; `None` where they show that the rows contradict each other.
pub(super) fn certified_bounds(program: &LinearProgram, solver: &mut Solver, terms: &Terms) -> Option<Interval> {
    let negative: Vec<(usize, f64)> = terms.iter().map(|&(at, a)| (at, -a)).collect();
    let least = certified_minimum(program, terms, &solver.minimise(terms));
    let greatest = certified_maximum(program, terms, &solver.minimise(&negative));
    (least <= greatest).then(|| Interval::new(least, greatest))
}

/// Where a row comes from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Origin {
    /// Stamps of the first and of the last reading.
    pub(super) span_s: [f64; 2],
    /// [`RowLabel::is_learnt`].
    pub(super) is_learnt: bool,
    /// [`RowLabel::void_without`].
    pub(super) void_without: Option<Assumption>,
}

impl Origin {
    /// The readings of a span of time.
    pub(super) fn over(span_s: [f64; 2]) -> Origin {
        Origin { span_s, ..Origin::default() }
    }
}

/// What a quantity's box follows from.
fn makers(variable: Variable, label: Option<&BoxLabel>) -> Vec<Suspect> {
    match (variable, variable.bound(), label) {
        (_, Some(bound), _) => vec![Suspect::Bound(bound)],
        (_, None, Some(label)) => {
            let earlier = (!label.is_alone).then_some(Suspect::Earlier);
            earlier.into_iter().chain([Suspect::Bound(label.bound)]).collect()
        }
        (
            Variable::Pose(..)
            | Variable::Landmark(..)
            | Variable::Point(..)
            | Variable::ViewPose(..)
            | Variable::ViewConstant(..),
            None,
            None,
        ) => vec![Suspect::Earlier],
        _ => Vec::new(),
    }
}
