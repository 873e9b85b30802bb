//! How tight a run's bounds are: the localizer is told ever narrower ones until it loses the truth.

use localizer::Status;
use serde::Serialize;

use crate::{
    render::{RenderError, Renderer},
    run::{Change, Counterfactual, RunRecord, run_otherwise},
    scene::Scene,
};

/// Tenths of the declared bounds that the localizer is told, one after the other.
const TENTHS: [u8; 9] = [9, 8, 7, 6, 5, 4, 3, 2, 1];

/// At which share of its bounds a run loses the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weakened {
    /// Greatest share of the declared bounds at which the truth is lost: 1 where the run loses it anyway, nothing where not even a tenth does.
    pub factor: Option<f64>,
    /// 1 / factor: 1 for bounds that are all used, above 3 for a run in which nobody would notice boxes a third as wide.
    pub tightness: Option<f64>,
    /// When it is lost.
    pub lost_at_s: Option<f64>,
    /// How.
    pub lost: Option<Lost>,
}

/// How the truth is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Lost {
    /// It is outside of every box.
    Outside,
    /// No box is left.
    Empty,
    /// An assumption is doubted.
    Recovering,
}

impl Lost {
    /// Its name in every output.
    pub fn name(self) -> &'static str {
        match self {
            Lost::Outside => "outside",
            Lost::Empty => "empty",
            Lost::Recovering => "recovering",
        }
    }
}

/// Simulates a recorded run again by its commands and with its draws, the localizer told 0.9, 0.8, … 0.1 of every bound that the scene
/// declares, until it loses the truth. Where the robot starts is told as it is. `progress` is told which share, and the simulated time.
///
/// Errors when a camera cannot be rendered.
pub fn weaken(
    scene: &Scene,
    record: &RunRecord,
    mut renderer: Option<&mut Renderer>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Weakened, RenderError> {
    if let Some((at_s, lost)) = first_lost(record) {
        return Ok(Weakened::at(1.0, at_s, lost));
    }
    for tenths in TENTHS {
        let factor = f64::from(tenths) / 10.0;
        let asked = Counterfactual { changes: vec![Change::Weakened { factor }], until_s: None, until_lost: true };
        let told = &mut |simulated_s: f64| progress(factor, simulated_s);
        let again = run_otherwise(scene, record, &asked, renderer.as_deref_mut(), told)?;
        if let Some((at_s, lost)) = first_lost(&again) {
            return Ok(Weakened::at(factor, at_s, lost));
        }
    }
    Ok(Weakened { factor: None, tightness: None, lost_at_s: None, lost: None })
}

impl Weakened {
    fn at(factor: f64, at_s: f64, lost: Lost) -> Weakened {
        Weakened { factor: Some(factor), tightness: Some(1.0 / factor), lost_at_s: Some(at_s), lost: Some(lost) }
    }
}

/// The first step at which the truth is lost.
fn first_lost(record: &RunRecord) -> Option<(f64, Lost)> {
    record.truths.iter().zip(&record.estimates).find_map(|(truth, estimate)| {
        let lost = match () {
            () if estimate.pose.is_empty() => Lost::Empty,
            () if !estimate.pose.contains(truth.pose) => Lost::Outside,
            () if estimate.status == Status::Recovering => Lost::Recovering,
            () => return None,
        };
        Some((truth.time_s, lost))
    })
}
