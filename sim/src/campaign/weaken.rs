//! Measures how tight the declared bounds of a run are: the localizer is given ever narrower bounds until it loses the true pose.

use localizer::Status;
use serde::Serialize;

use crate::{
    judge::SETTLED_S,
    render::{RenderError, Renderer},
    run::{Change, Counterfactual, RunRecord, run_otherwise},
    scene::Scene,
    subject::SubjectOf,
};

/// Shares of the declared bounds, in tenths, that the localizer is given in one repetition of the run after the other, from 0.9 to 0.1.
const TENTHS: [u8; 9] = [9, 8, 7, 6, 5, 4, 3, 2, 1];

/// Result of repeating a run while the localizer is given only a share of each declared bound: the share at which the true pose is lost, and how it
/// is lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weakened {
    /// Greatest share of the declared bounds at which the truth is lost: 1 where the run loses the truth with the declared bounds
    /// already, none where the run keeps it even with a tenth of them.
    pub factor: Option<f64>,
    /// Reciprocal of `factor`: 1 for bounds that are used in full, above 3 for a run that keeps the truth with bounds only 0.4 times as wide.
    pub tightness: Option<f64>,
    /// Time since the beginning of a drive from which on a loss of the truth counts.
    pub counted_after_s: f64,
    /// Time of the run at which the truth is lost.
    pub lost_at_s: Option<f64>,
    /// How the truth is lost.
    pub lost: Option<Lost>,
}

/// The ways in which the localizer can lose the true pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Lost {
    /// The true pose is outside every box of the estimate.
    Outside,
    /// The estimate has no box left.
    Empty,
    /// The localizer doubts an assumption.
    Recovering,
}

impl Lost {
    /// Returns the name of this way of losing the truth, as it stands in every output.
    pub fn name(self) -> &'static str {
        match self {
            Lost::Outside => "outside",
            Lost::Empty => "empty",
            Lost::Recovering => "recovering",
        }
    }
}

/// Simulates a recorded run again, with the recorded drive commands and the values that were drawn at random for it, while the localizer is given
/// 0.9, 0.8, … 0.1 of every bound that the scene declares, until it loses the truth. The box of start poses is given unchanged. `progress` is called
/// with the share of the bounds and the simulated time.
///
/// A loss counts if it lies at least 5 s after the beginning of a drive or, in a drive shorter than 10 s, in the drive's second half. Before that,
/// the localizer works with wheels and gyroscope alone, whose errors may be as large as declared, and losses say nothing about the localization
/// methods.
///
/// `subject_of` makes a new localizer from the narrowed bounds and the other values that it is given. Errors when a camera cannot be rendered.
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
    /// Creates the result from the share of the bounds at which the truth was lost, with the time and the way of the loss; `None` when it
    /// was lost at no share.
    fn of(lost: Option<(f64, (f64, Lost))>, counted_after_s: f64) -> Weakened {
        let factor = lost.map(|(factor, _)| factor);
        let (lost_at_s, lost) = lost.map(|(_, lost)| lost).unzip();
        Weakened { factor, tightness: factor.map(f64::recip), counted_after_s, lost_at_s, lost }
    }
}

/// Returns the time and the way of the first loss of the truth that lies at least `after_s` after the beginning of its drive.
fn first_lost(record: &RunRecord, after_s: f64) -> Option<(f64, Lost)> {
    let mut drive_began_s = 0.0;
    record.truths.iter().zip(&record.estimates).enumerate().find_map(|(step, (truth, estimate))| {
        if record.restarts.contains(&step) {
            drive_began_s = truth.time_s;
        }
        // The comparison of times has a small margin, as times are sums of decimal numbers that are not exact in binary.
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
