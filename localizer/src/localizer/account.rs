//! Accounts of readings: what a method and the localizer made of one reading of a camera, a range camera or another device.

use interval::Interval;

use crate::{Constraint, PoseBox, PoseUnion, method::Claim, quota::Quota, reading::LandmarkId};

/// Account of what one method and the localizer made of one reading of a camera, a range camera or another device.
#[derive(Clone, Debug)]
pub struct Account {
    /// Name of the method that used the reading.
    pub method: &'static str,
    /// What the method claimed to see; empty when the reading did not show the method's cue.
    pub claims: Vec<Claim>,
    /// Quota that says how many of the method's claims (assertions of what it saw) may be false.
    pub quota: Quota,
    /// Line segments that the method examined and rejected, `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Box of the poses that this reading allows without the earlier ones; `None` where the method does not tell.
    pub alone: Option<PoseBox>,
    /// Whether the reading is one of those of which later constraints are made together.
    pub is_held: bool,
    /// Whether the method made a constraint on the pose from the reading.
    pub constrained: bool,
    /// Whether the reading's constraint left no pose, which shows that an assumption failed.
    pub emptied: bool,
    /// Pose union at the reading's stamp, before the reading's constraint is applied.
    pub prior: PoseUnion,
    /// Pose union at the reading's stamp, after the reading's constraint is applied.
    pub posterior: PoseUnion,
    /// Landmarks as the method knows them after this reading: code, and box of world x and y.
    pub landmarks: Vec<(LandmarkId, [Interval; 2])>,
}

impl Account {
    pub(super) fn absent(method: &'static str, prior: PoseUnion) -> Self {
        Account {
            method,
            claims: Vec::new(),
            quota: Quota::of_each(0),
            rejected_px: Vec::new(),
            alone: None,
            is_held: false,
            constrained: false,
            emptied: false,
            posterior: prior.clone(),
            prior,
            landmarks: Vec::new(),
        }
    }

    pub(super) fn of(constraint: &Constraint, prior: PoseUnion) -> Self {
        Account {
            method: constraint.method,
            claims: constraint.claims.clone(),
            quota: constraint.quota,
            rejected_px: constraint.rejected_px.clone(),
            alone: constraint.alone,
            is_held: constraint.is_held,
            constrained: true,
            emptied: false,
            prior,
            posterior: PoseUnion::default(),
            landmarks: Vec::new(),
        }
    }
}
