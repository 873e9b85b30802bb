//! The steps of a run, read from its `steps.csv`.

use std::{fs, path::Path};

use crate::judge::Judgement;

/// One step of a run at which there was an estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) time_s: f64,
    pub(super) judgement: Judgement,
    /// Midpoint of the estimate's hull minus the truth: x in m, y in m, heading in rad.
    pub(super) error: [f64; 3],
    /// Full width of the estimate's hull: along x in m, along y in m, in heading in rad.
    pub(super) width: [f64; 3],
}

/// Reads all steps of the run in `folder` that have an estimate; none when the run has no `steps.csv` that can be read.
pub(super) fn read(folder: &Path) -> Vec<Step> {
    // The report shows what can be read: a run with a damaged `steps.csv` has no curve, but its figures are still in the table.
    let Ok(text) = fs::read_to_string(folder.join("steps.csv")) else { return Vec::new() };
    text.lines().skip(1).filter_map(step).collect()
}

fn step(line: &str) -> Option<Step> {
    let mut fields = line.split(',');
    let time_s = fields.next()?.parse().ok()?;
    let name = fields.next()?;
    let judgement = Judgement::ALL.into_iter().find(|judgement| judgement.name() == name)?;
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
