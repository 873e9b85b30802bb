//! Accounts of readings: what a method and the localizer made of one camera reading.

use interval::Interval;

use crate::{Constraint, PoseUnion, method::Claim, quota::Quota, reading::LandmarkId};

/// Account of what one method made of a camera's reading.
#[derive(Clone, Debug)]
pub struct Account {
    /// Name of the method that read the image.
    pub method: &'static str,
    /// What the method claimed to see; empty when the reading did not show the method's cue.
    pub claims: Vec<Claim>,
    /// How many of the method's claims may be false.
    pub quota: Quota,
    /// Segments that the method examined and rejected, `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Heading by this reading alone, without the earlier ones.
    pub alone_heading_rad: Option<Interval>,
    /// Whether the reading gave a constraint on the pose.
    pub constrained: bool,
    /// Whether the constraint left the pose union empty.
    pub emptied: bool,
    /// Pose union at the reading's stamp without this reading.
    pub prior: PoseUnion,
    /// Pose union at the reading's stamp just after this reading.
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
            alone_heading_rad: None,
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
            alone_heading_rad: constraint.alone_heading_rad,
            constrained: true,
            emptied: false,
            prior,
            posterior: PoseUnion::default(),
            landmarks: Vec::new(),
        }
    }
}
