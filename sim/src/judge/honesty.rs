//! What the distributions that a localizer states are worth, in a sentence.

use super::figures::Figures;

/// Least share of steps with the truth in the stated 95 % regions of a localizer that is not called overconfident. Even if all the errors of a drive
/// were one draw, a right filter would have less in one drive out of twenty only.
const OVERCONFIDENT: f64 = 0.9;
/// Greatest mean normalised error squared, of 3 for a right filter, from which on a localizer states its errors twice as great as they are: 3 / 2².
const CAUTIOUS: f64 = 0.75;

/// Whether a localizer is overconfident, from the figures of one run or of several; `None` where it stated no distributions.
///
/// | verdict | of what is measured |
/// |---|---|
/// | overconfident | the truth is within its 95 % regions at less than 90 % of steps |
/// | overcautious | not that, and its mean normalised error squared (NEES) is below 0.75, where 3 is right |
/// | about right | neither |
///
/// A localizer that states a distribution without an extent, or none at all, is overconfident at these steps, whatever it states at others.
pub fn honesty(figures: &Figures) -> Option<String> {
    let number = |name: &str| figures.get(name).copied().filter(|number| *number > 0.0);
    let unusable = number("distribution.unusable").zip(number("distribution.checks")).map(|(unusable, checks)| {
        format!("its covariance is of no use at {:.1} % of steps", 100.0 * unusable / checks)
    });
    let Some(&nees) = figures.get("distribution.nees.mean") else {
        return unusable.map(|told| format!("overconfident: {told}"));
    };
    let within = *figures.get("distribution.calibration.within_95")?;
    let verdict = match () {
        () if within < OVERCONFIDENT => "overconfident",
        () if nees < CAUTIOUS => "overcautious",
        () => "about right",
    };
    let unusable = unusable.map_or_else(String::new, |told| format!("; {told}"));
    Some(format!(
        "{verdict}: truth in its 95 % regions at {:.1} % of steps; NEES {nees:.1}, right is 3.0{unusable}",
        100.0 * within
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn told(nees: f64, within_95: f64) -> String {
        let figures = [("distribution.nees.mean", nees), ("distribution.calibration.within_95", within_95)];
        honesty(&figures.map(|(name, value)| (name.to_owned(), value)).into_iter().collect()).unwrap()
    }

    #[test]
    fn a_filter_that_states_half_its_errors_is_overconfident_and_one_that_states_twice_them_overcautious() {
        // Errors of k stated deviations have a NEES of 3k², and are within the stated 95 % region, of the radius √7.815, with the probability that a
        // χ² of three degrees of freedom is below 7.815/k²: 0.418 for k = 2 and above 0.9999 for k = ½.
        assert!(
            told(12.0, 0.418)
                .starts_with("overconfident: truth in its 95 % regions at 41.8 % of steps; NEES 12.0, right is 3.0")
        );
        assert!(told(0.74, 0.9999).starts_with("overcautious"));
        assert!(told(3.0, 0.95).starts_with("about right"));
        assert_eq!(honesty(&Figures::new()), None);
    }

    #[test]
    fn a_filter_without_a_usable_covariance_is_overconfident() {
        let figures = |more: &[(&str, f64)]| -> Figures {
            let counts = [("distribution.checks", 200.0), ("distribution.unusable", 50.0)];
            counts.iter().chain(more).map(|(name, value)| ((*name).to_owned(), *value)).collect()
        };
        assert_eq!(honesty(&figures(&[])).unwrap(), "overconfident: its covariance is of no use at 25.0 % of steps");
        // Regions without a use hold no truth, so that they are counted among those that miss it.
        let rest = [("distribution.nees.mean", 3.0), ("distribution.calibration.within_95", 0.71)];
        let told = honesty(&figures(&rest)).unwrap();
        assert!(told.starts_with("overconfident: ") && told.ends_with("no use at 25.0 % of steps"), "{told}");
    }
}
