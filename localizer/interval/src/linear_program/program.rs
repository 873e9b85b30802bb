//! The linear program itself: a box of variables, and rows that bound linear functions of them.

use crate::Interval;

/// A linear function Σ aⱼ xⱼ of a program's variables: pairs of a variable's index j and its coefficient aⱼ. The coefficients are exact as
/// they stand; a variable may occur in several terms, which add up.
pub type Terms = [(usize, f64)];

/// The points x of a box X that satisfy rows lo ≤ a·x ≤ hi.
///
/// A program that exists is valid: all variables are bounded, all coefficients are finite, and no row's interval is empty. It may well have no
/// solution.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearProgram {
    variables: Vec<Interval>,
    // Terms of all rows one after the other; those of row i are row_starts[i]..row_starts[i + 1].
    terms: Vec<(usize, f64)>,
    row_starts: Vec<usize>,
    sides: Vec<Interval>,
}

/// Why something is no linear program. The texts follow "failed to …".
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the texts say it")]
pub enum ProgramError {
    #[error("bound variable {variable}: {bounds} is not a bounded, non-empty interval")]
    UnboundedVariable { variable: usize, bounds: Interval },
    #[error("add row {row}: it names variable {variable}, but there are only {n_variables}")]
    UnknownVariable { row: usize, variable: usize, n_variables: usize },
    #[error("add row {row}: the coefficient of variable {variable} is {coefficient}, which is not finite")]
    InfiniteCoefficient { row: usize, variable: usize, coefficient: f64 },
    #[error("add row {row}: its interval is empty (its lower bound above its upper one, or one of them not a number)")]
    EmptyRow { row: usize },
}

impl LinearProgram {
    /// The program without rows, whose solutions are the points of the box X that is the product of the intervals given.
    pub fn new(variables: Vec<Interval>) -> Result<LinearProgram, ProgramError> {
        for (variable, &bounds) in variables.iter().enumerate() {
            if !bounds.is_bounded() {
                return Err(ProgramError::UnboundedVariable { variable, bounds });
            }
        }
        Ok(LinearProgram { variables, terms: Vec::new(), row_starts: vec![0], sides: Vec::new() })
    }

    /// Adds the row that the linear function's value is in the interval `sides`, and returns the row's index. The first row has index 0.
    ///
    /// An equation has an interval of one number. A bound of the interval may be infinite, which leaves that side open.
    pub fn add_row(&mut self, terms: &Terms, sides: Interval) -> Result<usize, ProgramError> {
        let (row, n_variables) = (self.n_rows(), self.n_variables());
        for &(variable, coefficient) in terms {
            if variable >= n_variables {
                return Err(ProgramError::UnknownVariable { row, variable, n_variables });
            }
            if !coefficient.is_finite() {
                return Err(ProgramError::InfiniteCoefficient { row, variable, coefficient });
            }
        }
        if sides.is_empty() {
            return Err(ProgramError::EmptyRow { row });
        }
        self.terms.extend_from_slice(terms);
        self.row_starts.push(self.terms.len());
        self.sides.push(sides);
        Ok(row)
    }

    /// Number of variables.
    pub fn n_variables(&self) -> usize {
        self.variables.len()
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.sides.len()
    }

    /// The box X: an interval for each variable.
    pub fn variables(&self) -> &[Interval] {
        &self.variables
    }

    /// The linear function of a row.
    pub fn terms(&self, row: usize) -> &Terms {
        &self.terms[self.row_starts[row]..self.row_starts[row + 1]]
    }

    /// The interval [lo, hi] that a row's linear function is in.
    pub fn sides(&self, row: usize) -> Interval {
        self.sides[row]
    }

    /// Enclosure of the values that a linear function takes over the box X, without regard to the rows. Empty when the function is not one
    /// of this program's variables, or a coefficient is not finite.
    pub fn range(&self, terms: &Terms) -> Interval {
        terms.iter().fold(Interval::ZERO, |sum, &(variable, coefficient)| {
            let values = self.variables.get(variable).copied().unwrap_or(Interval::EMPTY);
            sum + values * Interval::point(coefficient)
        })
    }

    /// The same program with other intervals: that of a variable becomes `variable(index)`, if that is one, and that of a row is wider by
    /// `row(index)` on either side.
    pub fn widened(&self, variable: impl Fn(usize) -> Option<Interval>, row: impl Fn(usize) -> f64) -> LinearProgram {
        let mut wide = self.clone();
        for (at, values) in wide.variables.iter_mut().enumerate() {
            *values = variable(at).filter(|other| values.is_subset_of(*other) && other.is_bounded()).unwrap_or(*values);
        }
        wide.sides.iter_mut().enumerate().for_each(|(at, sides)| *sides = sides.inflate(row(at)));
        wide
    }

    /// The program with only some of the rows, in the order given, over the same box.
    pub fn with_rows(&self, rows: &[usize]) -> LinearProgram {
        let mut part = LinearProgram {
            variables: self.variables.clone(),
            terms: Vec::new(),
            row_starts: vec![0],
            sides: rows.iter().map(|&row| self.sides[row]).collect(),
        };
        for &row in rows {
            part.terms.extend_from_slice(self.terms(row));
            part.row_starts.push(part.terms.len());
        }
        part
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_program_is_refused_by_name() {
        let unit = Interval::new(0.0, 1.0);
        let unbounded = LinearProgram::new(vec![unit, Interval::new(0.0, f64::INFINITY)]).unwrap_err();
        assert!(matches!(unbounded, ProgramError::UnboundedVariable { variable: 1, .. }), "{unbounded}");
        assert!(LinearProgram::new(vec![Interval::EMPTY]).is_err());
        let mut program = LinearProgram::new(vec![unit; 2]).unwrap();
        assert_eq!(program.add_row(&[(1, 2.0)], unit), Ok(0));
        let unknown = program.add_row(&[(2, 1.0)], unit).unwrap_err();
        assert_eq!(unknown.to_string(), "add row 1: it names variable 2, but there are only 2");
        for coefficient in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let refused = program.add_row(&[(0, coefficient)], unit);
            assert!(matches!(refused, Err(ProgramError::InfiniteCoefficient { row: 1, variable: 0, .. })));
        }
        assert_eq!(program.add_row(&[(0, 1.0)], Interval::new(2.0, 1.0)), Err(ProgramError::EmptyRow { row: 1 }));
        assert_eq!(program.add_row(&[(0, 1.0)], Interval::new(f64::NAN, 1.0)), Err(ProgramError::EmptyRow { row: 1 }));
        assert_eq!(program.n_rows(), 1, "a refused row leaves nothing behind");
        assert_eq!(program.terms(0), [(1, 2.0)]);
    }

    #[test]
    fn the_range_of_a_function_adds_up_over_the_box() {
        let program = LinearProgram::new(vec![Interval::new(-1.0, 2.0), Interval::new(3.0, 4.0)]).unwrap();
        // 2x − y is in [−2 − 4, 4 − 3].
        let range = program.range(&[(0, 2.0), (1, -1.0)]);
        assert!(Interval::new(-6.0, 1.0).is_subset_of(range) && range.width() < 7.0 + 1e-12);
        assert!(program.range(&[(2, 1.0)]).is_empty() && program.range(&[(0, f64::NAN)]).is_empty());
    }
}
