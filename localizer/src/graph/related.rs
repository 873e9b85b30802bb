//! The linear program of related quantities, with what each of its rows and boxes comes from.

use std::collections::BTreeMap;

use interval::linear_program::{LinearProgram, ProgramError};

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
}

/// What a row of the program comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowLabel {
    /// Declared bounds with the part of the half width of the row's sides that each makes.
    pub parts: Vec<(Assumption, f64)>,
    /// The readings that the row is made of.
    pub readings: Vec<Readings>,
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
    /// The reading.
    pub reading: Readings,
    /// Whether the reading makes the box along x, along y and in heading.
    pub axes: [bool; 3],
}

impl Related {
    /// The program of rows, each with the span of the readings that it comes from.
    pub(super) fn new(
        domain: Domain,
        rows: Vec<(Row, [f64; 2])>,
        boxes: BTreeMap<Variable, BoxLabel>,
    ) -> Result<Related, ProgramError> {
        let variables: Vec<Variable> = domain.iter().map(|(variable, _)| variable).collect();
        let index: BTreeMap<Variable, usize> = variables.iter().enumerate().map(|(idx, &one)| (one, idx)).collect();
        let deviations = variables.iter().map(|&variable| domain.deviation(variable)).collect();
        let mut program = LinearProgram::new(deviations)?;
        let mut labels = Vec::with_capacity(rows.len());
        for (row, span_s) in rows {
            let indexed = |&(variable, coefficient): &(Variable, f64)| Some((*index.get(&variable)?, coefficient));
            // A row of a quantity that the domain does not have says nothing here.
            let Some(terms) = row.terms.iter().map(indexed).collect::<Option<Vec<(usize, f64)>>>() else { continue };
            program.add_row(&terms, row.sides)?;
            let readings = row.devices.iter().map(|&device| Readings { device, span_s }).collect();
            labels.push(RowLabel { parts: row.parts, readings });
        }
        Ok(Related { program, variables, domain, rows: labels, boxes })
    }

    /// Index of a quantity among the program's variables.
    pub fn index(&self, variable: Variable) -> Option<usize> {
        self.variables.iter().position(|&one| one == variable)
    }

    /// The declared bound that makes a quantity's box.
    pub fn bound_of(&self, variable: Variable) -> Option<Assumption> {
        variable.bound().or_else(|| self.boxes.get(&variable).map(|label| label.bound))
    }
}
