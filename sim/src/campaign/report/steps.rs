//! The steps of a run, read from its `steps.csv`, or from its `distribution.csv` where the localizer states distributions.

use std::{fs, path::Path};

use crate::judge::Judgement;

/// One step of a run at which there was an estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) time_s: f64,
    /// What the judge said of boxes; none for a distribution with the truth outside of three standard deviations, whose localizer promises nothing.
    pub(super) judgement: Option<Judgement>,
    /// Midpoint of the estimate's hull, or mean of the distribution, minus the truth: x in m, y in m, heading in rad.
    pub(super) error: [f64; 3],
    /// Full width of the estimate's hull, or of three standard deviations to either side: along x in m, along y in m, in heading in rad.
    pub(super) width: [f64; 3],
}

/// Reads all steps of the run in `folder` that have an estimate; none when the run has no `steps.csv` that can be read.
pub(super) fn read(folder: &Path) -> Vec<Step> {
    // The report shows what can be read: a run with a damaged `steps.csv` has no curve, but its figures are still in the table.
    let Ok(text) = fs::read_to_string(folder.join("steps.csv")) else { return Vec::new() };
    text.lines().skip(1).filter_map(step).collect()
}

/// Reads all steps of the run in `folder` that have a distribution; none when the run has no `distribution.csv` that can be read.
pub(super) fn of_distributions(folder: &Path) -> Vec<Step> {
    let Ok(text) = fs::read_to_string(folder.join("distribution.csv")) else { return Vec::new() };
    let mut lines = text.lines();
    let headings: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let columns = |names: [&str; 3]| -> Option<[usize; 3]> {
        let at = names.map(|name| headings.iter().position(|heading| *heading == name));
        Some([at[0]?, at[1]?, at[2]?])
    };
    let errors = columns(["error_x_m", "error_y_m", "error_heading_rad"]);
    let variances = columns(["cov_x_x", "cov_y_y", "cov_heading_heading"]);
    let Some((errors, variances)) = errors.zip(variances) else { return Vec::new() };
    let step = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |at: usize| fields.get(at)?.parse::<f64>().ok().filter(|number| number.is_finite());
        let three = |at: [usize; 3]| Some([number(at[0])?, number(at[1])?, number(at[2])?]);
        let (error, width) = (three(errors)?, three(variances)?.map(|variance| 6.0 * variance.max(0.0).sqrt()));
        let is_within = (0..3).all(|axis| error[axis].abs() <= 0.5 * width[axis]);
        Some(Step { time_s: number(0)?, judgement: is_within.then_some(Judgement::Contained), error, width })
    };
    lines.filter_map(step).collect()
}

fn step(line: &str) -> Option<Step> {
    let mut fields = line.split(',');
    let time_s = fields.next()?.parse().ok()?;
    let name = fields.next()?;
    let judgement = Some(Judgement::ALL.into_iter().find(|judgement| judgement.name() == name)?);
    let mut number = || fields.next()?.parse::<f64>().ok();
    let error = [number()?, number()?, number()?];
    let width = [number()?, number()?, number()?];
    Some(Step { time_s, judgement, error, width })
}

impl Step {
    /// Returns the error of the hull's midpoint divided by half the hull's width along one axis: above 1 the truth is outside the hull.
    pub(super) fn ratio(&self, axis: usize) -> f64 {
        // The lower limit on the width avoids a division by zero: a box without width whose error is 0 is exact, with a ratio of 0.
        self.error[axis].abs() / (0.5 * self.width[axis]).max(1e-12)
    }
}
