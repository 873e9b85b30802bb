//! A run simulated again by its recorded commands, with one thing otherwise: what the localizer is told, what was drawn, or what it sees.

use std::borrow::Cow;

use localizer::{Reading, bounds, motion::SlipExcess, reading::Camera};

use crate::{drawn::Drawn, scene::Scene};

use super::STEP_S;

/// What is otherwise when a run is simulated again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counterfactual {
    /// Each of them is made.
    pub changes: Vec<Change>,
    /// The run ends after the first step at or after this time.
    pub until_s: Option<f64>,
    /// The run ends at the first step, so far into its drive or later, at which the truth is outside or an assumption doubted.
    pub until_lost_after_s: Option<f64>,
}

/// One thing that is otherwise.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// The localizer is told a bound as wide as its true value, where it was exceeded if that can be told it, and else all the run; the world
    /// is as it was.
    Told {
        /// Name of the bound.
        bound: String,
        /// What the scene declares.
        declared: f64,
        /// What was true.
        true_value: f64,
        /// Each span in which it was exceeded, and by how much.
        exceeded: Vec<([f64; 2], f64)>,
    },
    /// What was drawn or placed beyond a bound is moved back to it; what the localizer is told stays.
    Clipped {
        /// Name of the bound.
        bound: String,
    },
    /// These readings never reach the localizer.
    Withheld {
        /// The camera that took it, none of what is no picture, and its stamp.
        readings: Vec<(Option<Camera>, f64)>,
    },
    /// Every bound that the localizer is told is narrower by this factor.
    Weakened {
        /// Below 1.
        factor: f64,
    },
}

/// The scene and its draws as a counterfactual has them.
pub(super) struct Otherwise<'a> {
    /// What is simulated.
    pub(super) world: Cow<'a, Scene>,
    /// What the localizer is told.
    pub(super) told: Cow<'a, Scene>,
    /// What is true.
    pub(super) drawn: Drawn,
}

impl Counterfactual {
    /// Applies the changes to a scene and to what its seed has drawn.
    pub(super) fn of<'a>(&self, scene: &'a Scene, drawn: &Drawn) -> Otherwise<'a> {
        let mut otherwise = Otherwise { world: Cow::Borrowed(scene), told: Cow::Borrowed(scene), drawn: drawn.clone() };
        for change in &self.changes {
            match change {
                // Told by spans, in each drive's own time.
                Change::Told { bound, .. } if is_slip(bound) => {}
                Change::Told { bound, declared, true_value, .. } => {
                    otherwise.told.to_mut().widen(bound, *declared, *true_value);
                }
                Change::Clipped { bound } => {
                    otherwise.drawn.clip(bound, scene);
                    otherwise.world.to_mut().clip_placed(bound);
                    otherwise.told.to_mut().clip_mapped(bound, drawn);
                }
                Change::Withheld { .. } => {}
                Change::Weakened { factor } => otherwise.told.to_mut().weaken(*factor),
            }
        }
        otherwise
    }

    /// Where the localizer is told that the wheels slip by more than declared, in the time of a drive that began at `offset_s`, whose stamps
    /// may be off by `stamp_error_s`.
    pub(super) fn slips(&self, offset_s: f64, stamp_error_s: f64) -> Vec<SlipExcess> {
        // The truth is looked at every step only, and a window may begin between two of them.
        let margin_s = stamp_error_s + 2.0 * STEP_S;
        let told = self.changes.iter().filter_map(|change| match change {
            Change::Told { bound, exceeded, .. } if is_slip(bound) => Some((bound.as_str(), exceeded)),
            _ => None,
        });
        told.flat_map(|(bound, exceeded)| exceeded.iter().map(move |excess| (bound, *excess)))
            .map(|(bound, ([from_s, to_s], excess_m))| {
                // A share more than the comparison of a bound leaves to rounding.
                let excess_m = excess_m * (1.0 + 1e-6);
                let [slip_m, side_slip_m] =
                    if bound == bounds::WHEELS_SLIP { [excess_m, 0.0] } else { [0.0, excess_m] };
                let span_s = [from_s - offset_s - margin_s, to_s - offset_s + margin_s];
                SlipExcess { span_s, slip_m, side_slip_m }
            })
            .collect()
    }

    /// Whether a reading stamped at `measured_s` of the run's own time never reaches the localizer.
    pub(super) fn withholds(&self, reading: &Reading, measured_s: f64) -> bool {
        self.changes.iter().any(|change| match change {
            Change::Withheld { readings } => {
                let taken_by = match reading {
                    Reading::Camera { camera, .. } => Some(*camera),
                    Reading::Range { .. } | Reading::Other { .. } => None,
                    _ => return false,
                };
                readings.contains(&(taken_by, measured_s))
            }
            _ => false,
        })
    }
}

/// Whether a bound is one over windows of the wheels' motion, of which the localizer can be told in which spans it is exceeded.
fn is_slip(bound: &str) -> bool {
    [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP].contains(&bound)
}
