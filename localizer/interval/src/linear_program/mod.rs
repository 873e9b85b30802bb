//! Linear programs: certified bounds of linear functions over all points of a box that satisfy linear rows.
//!
//! A solver of linear programs computes with rounded numbers, so that its optimum is no bound. Its duals, one number for each row, make one: by
//! weak duality *any* numbers bound the function, and in interval arithmetic they do so in spite of all rounding. The solver need not be trusted, and
//! may be stopped at any time; the nearer its duals are to optimal ones, the sharper the bound is.
//!
//! # Example
//!
//! A robot is between 0 and 4 m along a wall and between 0 and 3 m from it. Both distances together are at least 2 m, and the first is 1 m more than
//! the second. How far along the wall is it at least?
//!
//! ```
//! use interval::Interval;
//! use interval::linear_program::{LinearProgram, certified_minimum};
//!
//! let mut program = LinearProgram::new(vec![Interval::new(0.0, 4.0), Interval::new(0.0, 3.0)])?;
//! program.add_row(&[(0, 1.0), (1, 1.0)], Interval::new(2.0, f64::INFINITY))?;
//! program.add_row(&[(0, 1.0), (1, -1.0)], Interval::point(1.0))?;
//!
//! // Half of the first row and half of the second give the distance along the wall: at least (2 + 1)/2.
//! let least_m = certified_minimum(&program, &[(0, 1.0)], &[0.5, 0.5]);
//! assert!(least_m <= 1.5 && least_m > 1.499_999);
//! // Worse duals give a worse bound, never a wrong one.
//! assert!(certified_minimum(&program, &[(0, 1.0)], &[0.4, 0.5]) <= 1.5);
//! # Ok::<(), interval::linear_program::ProgramError>(())
//! ```

mod certificate;
mod factor;
mod program;
mod solver;

pub use certificate::{
    Shares, certified_maximum, certified_minimum, certified_minimum_despite, contradicting_rows, shares,
};
pub use program::{LinearProgram, ProgramError, Terms};
pub use solver::{Search, Solver};
