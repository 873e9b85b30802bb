//! How tight a run's bounds are: the localizer is told ever narrower ones until it loses the truth.

use localizer::Status;
use serde::Serialize;

use crate::{
    judge::SETTLED_S,
    render::{RenderError, Renderer},
    run::{Change, Counterfactual, RunRecord, run_otherwise},
    scene::Scene,
    subject::SubjectOf,
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
    /// From when on in a drive a loss counts.
    pub counted_after_s: f64,
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
/// Losses count from 5 s of a drive on, and from half of it where it is shorter than 10 s: before, wheels and gyroscope are alone with errors at
/// their corners, and what they lose says nothing of what methods tell.
///
/// `subject_of` makes the subject of what it is told. Errors when a camera cannot be rendered.
pub fn weaken(
    scene: &Scene,
    record: &RunRecord,
    subject_of: &SubjectOf<'_>,
    mut renderer: Option<&mut Renderer>,
    progress: &mut dyn FnMut(f64, f64),
) -> Result<Weakened, RenderError> {
    let drives_s = record.drives().filter_map(|truths| Some(truths.last()?.time_s - truths.first()?.time_s));
    let after_s = drives_s.map(|lasts_s| 0.5 * lasts_s).fold(SETTLED_S, f64::min);
    if let Some(lost) = first_lost(record, after_s) {
        return Ok(Weakened::of(Some((1.0, lost)), after_s));
    }
    for tenths in TENTHS {
        let factor = f64::from(tenths) / 10.0;
        let changes = vec![Change::Weakened { factor }];
        let asked = Counterfactual { changes, until_s: None, until_lost_after_s: Some(after_s) };
        let told = &mut |simulated_s: f64| progress(factor, simulated_s);
        let again = run_otherwise(scene, record, &asked, subject_of, renderer.as_deref_mut(), told)?;
        if let Some(lost) = first_lost(&again, after_s) {
            return Ok(Weakened::of(Some((factor, lost)), after_s));
        }
    }
    Ok(Weakened::of(None, after_s))
}

impl Weakened {
    /// At which share the truth was lost, when and how, unless at none.
    fn of(lost: Option<(f64, (f64, Lost))>, counted_after_s: f64) -> Weakened {
        let factor = lost.map(|(factor, _)| factor);
        let (lost_at_s, lost) = lost.map(|(_, lost)| lost).unzip();
        Weakened { factor, tightness: factor.map(f64::recip), counted_after_s, lost_at_s, lost }
    }
}

/// The first step, so far into its drive or later, at which the truth is lost.
fn first_lost(record: &RunRecord, after_s: f64) -> Option<(f64, Lost)> {
    let mut drive_began_s = 0.0;
    record.truths.iter().zip(&record.estimates).enumerate().find_map(|(step, (truth, estimate))| {
        if record.restarts.contains(&step) {
            drive_began_s = truth.time_s;
        }
        // A hair for times that are sums of decimals.
        if truth.time_s - drive_began_s < after_s - 1e-6 {
            return None;
        }
        let lost = match () {
            () if estimate.pose.is_empty() => Lost::Empty,
            () if !estimate.pose.contains(truth.pose) => Lost::Outside,
            () if estimate.status == Status::Recovering => Lost::Recovering,
            () => return None,
        };
        Some((truth.time_s, lost))
    })
}
