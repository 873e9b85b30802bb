//! `wherein compare`: tells whether a second set of results is better or worse than a first one.

use std::process::ExitCode;

use crate::campaign::comparison::{Demand, Side, as_text, compare};

use super::{CommandError, CompareArguments, print};

/// Prints the comparison of two sets of results. The exit code is 1 when anything is worse in the second, and
/// where that is asked for, when too few seeds leave it open.
pub(super) fn compare_sides(arguments: &CompareArguments) -> Result<ExitCode, CommandError> {
    let (first, second) = (Side::load(&arguments.first)?, Side::load(&arguments.second)?);
    let demand = Demand { confidence: arguments.confidence, tolerance: 0.01 * arguments.tolerance_percent };
    let comparison = compare(&first, &second, demand);
    if comparison.n_pairs == 0 {
        return Err(CommandError::NoPairs(arguments.first.clone(), arguments.second.clone()));
    }
    print(&as_text(&comparison))?;
    let is_refused = comparison.is_worse() || arguments.fail_if_inconclusive && comparison.is_inconclusive();
    Ok(ExitCode::from(u8::from(is_refused)))
}
