//! `wherein compare`: tells whether a second set of results is better or worse than a first one.

use std::process::ExitCode;

use crate::campaign::comparison::{Side, as_text, compare};

use super::{CommandError, CompareArguments, print};

/// Prints the comparison of two sets of results. The exit code is 1 when anything is worse in the second.
pub(super) fn compare_sides(arguments: &CompareArguments) -> Result<ExitCode, CommandError> {
    let (first, second) = (Side::load(&arguments.first)?, Side::load(&arguments.second)?);
    let comparison = compare(&first, &second, arguments.confidence);
    if comparison.n_pairs == 0 {
        return Err(CommandError::NoPairs(arguments.first.clone(), arguments.second.clone()));
    }
    print(&as_text(&comparison))?;
    Ok(ExitCode::from(u8::from(comparison.is_worse())))
}
