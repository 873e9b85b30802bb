//! The steps of a run as `steps.csv` tells them.

use std::{fs, path::Path};

use crate::judge::Judgement;

/// One step of a run at which there was an estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) time_s: f64,
    pub(super) judgement: Judgement,
    /// Midpoint of the hull less the truth: x in m, y in m, heading in rad.
    pub(super) error: [f64; 3],
    /// Full width of the hull, same axes.
    pub(super) width: [f64; 3],
}

/// All steps of the run in `folder` at which a pose was left; none when the run left no steps that can be read.
pub(super) fn read(folder: &Path) -> Vec<Step> {
    // A report shows what there is; a run that is damaged has no curve, and its figures still stand in the table.
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
    /// Error over half the width: above 1 the truth is outside the hull along this axis.
    pub(super) fn ratio(&self, axis: usize) -> f64 {
        // A box without width that errs by nothing is exact.
        self.error[axis].abs() / (0.5 * self.width[axis]).max(1e-12)
    }
}
