//! How well the distributions that a localizer states agree with the truth: calibration, normalised errors, and the sizes of the stated regions.

use std::sync::LazyLock;

use localizer::Pose;

use crate::{
    run::RunRecord,
    subject::{SHARES, Spread, Stated, chi_squared},
};

use super::{
    share,
    statistics::axis_width_of,
    verdict::{Calibration, Distribution, Nees, Region},
};

/// Share of χ² between the bounds of the corridor of normalised errors; Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2, test at 95 %.
const CORRIDOR_SHARE: f64 = 0.95;

/// Corridor that holds the normalised error of one step with a probability of 95 % if the stated covariance is right: between the quantiles of χ²
/// with 3 degrees of freedom at 2.5 % and at 97.5 %.
static CORRIDOR: LazyLock<[f64; 2]> = LazyLock::new(|| corridor(1));

/// Corridor that holds the mean of the normalised errors of `n_runs` independent runs at one time with a probability of 95 % if the stated
/// covariances are right (Bar-Shalom, Li and Kirubarajan 2001, eq. 5.4.2-9): quantiles of χ² with 3·n_runs degrees of freedom over n_runs.
pub fn corridor(n_runs: usize) -> [f64; 2] {
    let n_runs = n_runs.max(1) as f64;
    [0.5 - 0.5 * CORRIDOR_SHARE, 0.5 + 0.5 * CORRIDOR_SHARE].map(|share| chi_squared(share, 3.0 * n_runs) / n_runs)
}

/// Judges the distributions that a localizer stated during a run; `None` if it stated none.
pub(super) fn distribution(record: &RunRecord) -> Option<Distribution> {
    let steps = record.stated.iter().zip(&record.truths);
    of_steps(&steps.filter_map(|(stated, truth)| Some((stated.as_ref()?, truth.pose))).collect::<Vec<_>>())
}

/// Judges stated distributions, each against the true pose at its time; `None` without any.
pub fn of_steps(steps: &[(&Stated, Pose)]) -> Option<Distribution> {
    let checks = steps.len();
    if checks == 0 {
        return None;
    }
    let usable: Vec<Judged> = steps.iter().filter_map(|(stated, truth)| Judged::of(stated, *truth)).collect();
    // A step without a usable covariance states no region, and so none that holds the truth.
    let holding = |is_held: &dyn Fn(&Judged) -> bool| share(usable.iter().filter(|step| is_held(step)).count(), checks);
    let within: Vec<f64> =
        (0..SHARES.len()).map(|index| holding(&|step| step.nees <= step.spread.squared_radii[index])).collect();
    let [within_50, within_90, within_95, within_99, within_99_7] = [0, 1, 2, 3, 4].map(|index: usize| within[index]);
    let n_usable = usable.len();
    let of_usable = |is_so: &dyn Fn(&Judged) -> bool| share(usable.iter().filter(|step| is_so(step)).count(), n_usable);
    let region = |widths: &dyn Fn(&Spread) -> [f64; 3], area_m2: &dyn Fn(&Spread) -> f64| {
        let along = |axis: usize| axis_width_of(usable.iter().map(|step| widths(step.spread)[axis]).collect());
        Region {
            x_m: along(0),
            y_m: along(1),
            heading_rad: along(2),
            area_m2: usable.iter().map(|step| area_m2(step.spread)).sum::<f64>() / n_usable as f64,
        }
    };
    Some(Distribution {
        checks,
        unusable: checks - n_usable,
        calibration: Calibration { within_50, within_90, within_95, within_99, within_99_7 },
        within_3_sigma_share: holding(&|step| step.is_within_3_sigma),
        nees: Nees {
            mean: usable.iter().map(|step| step.nees).sum::<f64>() / n_usable as f64,
            max: usable.iter().map(|step| step.nees).fold(f64::NAN, f64::max),
            in_corridor_share: of_usable(&|step| (CORRIDOR[0]..=CORRIDOR[1]).contains(&step.nees)),
            above_corridor_share: of_usable(&|step| step.nees > CORRIDOR[1]),
        },
        region_95: region(&|spread| spread.width_95, &|spread| spread.area_95_m2),
        region_3_sigma: region(&Spread::width_3_sigma, &Spread::area_3_sigma_m2),
    })
}

/// A stated distribution compared with the truth.
struct Judged<'a> {
    spread: &'a Spread,
    nees: f64,
    is_within_3_sigma: bool,
}

impl Judged<'_> {
    fn of(stated: &Stated, truth: Pose) -> Option<Judged<'_>> {
        let spread = stated.spread.as_ref()?;
        let error = stated.error(truth);
        let widths = spread.width_3_sigma();
        let is_within_3_sigma = (0..3).all(|axis| error[axis].abs() <= 0.5 * widths[axis]);
        Some(Judged { spread, nees: spread.squared_distance(&error), is_within_3_sigma })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
