//! A recorded run simulated again by its commands, with something changed: the bounds that the localizer is given, values that were
//! drawn, or the readings that reach the localizer.

use std::borrow::Cow;

use localizer::{Reading, bounds, motion::SlipExcess, reading::Camera};

use crate::{scene::Scene, world::Drawn};

use super::STEP_S;

/// The changes under which a recorded run is simulated again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counterfactual {
    /// Changes to the recorded run, all of which apply together.
    pub changes: Vec<Change>,
    /// Time of the run that ends the simulation: it stops after the first step at or after this time.
    pub until_s: Option<f64>,
    /// Time of a drive from which on a loss ends the simulation: the run ends at the first step, at or after this time of its drive, at which the
    /// true pose is outside the estimate or the localizer is recovering from a contradiction.
    pub until_lost_after_s: Option<f64>,
}

/// One change under which a run is simulated again.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// The localizer is given a declared bound that is widened to the true value which exceeded it. A bound on slip is widened only in the spans
    /// of time in which it was exceeded, every other bound in the whole run. The simulated world stays as it was.
    Told {
        /// Name of the widened bound.
        bound: String,
        /// Value of the bound that the scene declares.
        declared: f64,
        /// True value behind the bound.
        true_value: f64,
        /// Each span of time in which the bound was exceeded, and by how much.
        exceeded: Vec<([f64; 2], f64)>,
    },
    /// True values that were drawn or placed beyond a declared bound are moved back to the bound. For the bound on wall directions the map is
    /// corrected: directions that it states beyond the bound are moved back, and missing ones are added. Everything else that the localizer is
    /// given stays.
    Clipped {
        /// Name of the bound to which the values are moved back.
        bound: String,
    },
    /// Some readings are withheld from the localizer.
    Withheld {
        /// Each withheld reading, given by the camera that took it (none for a reading that is not a picture) and by its stamp.
        readings: Vec<(Option<Camera>, f64)>,
    },
    /// Every declared bound that the localizer is given is made narrower by one and the same factor.
    Weakened {
        /// Factor by which every bound is multiplied, below 1.
        factor: f64,
    },
}

/// A scene and the true values drawn for it, after the changes under which a run is simulated again (the counterfactual) have been applied.
pub(super) struct Otherwise<'a> {
    /// Scene that is simulated.
    pub(super) world: Cow<'a, Scene>,
    /// Scene that states the values which the localizer is given.
    pub(super) told: Cow<'a, Scene>,
    /// Values drawn for the seed, as they are true in the simulation.
    pub(super) drawn: Drawn,
}

impl Counterfactual {
    /// Applies the changes to a scene and to the values that its seed has drawn.
    pub(super) fn of<'a>(&self, scene: &'a Scene, drawn: &Drawn) -> Otherwise<'a> {
        let mut otherwise = Otherwise { world: Cow::Borrowed(scene), told: Cow::Borrowed(scene), drawn: drawn.clone() };
        for change in &self.changes {
            match change {
                // Bounds on slip are not widened here, in the whole run, but only in single spans of time, which are counted within each drive.
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

    /// Returns the spans in which the localizer is given more slip of the wheels than declared, in the time of a drive that began at
    /// `offset_s`. The stamps of readings may be off by `stamp_error_s`.
    pub(super) fn slips(&self, offset_s: f64, stamp_error_s: f64) -> Vec<SlipExcess> {
        // A margin of two steps is added because the truth is recorded at every step only, and a window over which slip is bounded may begin
        // between two steps.
        let margin_s = stamp_error_s + 2.0 * STEP_S;
        let told = self.changes.iter().filter_map(|change| match change {
            Change::Told { bound, exceeded, .. } if is_slip(bound) => Some((bound.as_str(), exceeded)),
            _ => None,
        });
        told.flat_map(|(bound, exceeded)| exceeded.iter().map(move |excess| (bound, *excess)))
            .map(|(bound, ([from_s, to_s], excess_m))| {
                // The factor exceeds the rounding that is allowed when a true value is compared with its bound, so that the widened bound holds.
                let excess_m = excess_m * (1.0 + 1e-6);
                let [slip_m, side_slip_m] =
                    if bound == bounds::WHEELS_SLIP { [excess_m, 0.0] } else { [0.0, excess_m] };
                let span_s = [from_s - offset_s - margin_s, to_s - offset_s + margin_s];
                SlipExcess { span_s, slip_m, side_slip_m }
            })
            .collect()
    }

    /// Whether a reading stamped at `measured_s`, in the time of the whole run, is withheld from the localizer.
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

/// Whether a bound is on the slip of the wheels. Slip is bounded over windows of motion, so that the localizer can be given the spans in
/// which the bound is exceeded.
fn is_slip(bound: &str) -> bool {
    [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP].contains(&bound)
}
