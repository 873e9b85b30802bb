//! What became of a reading of a camera.

use interval::Interval;

use crate::{Constraint, PoseUnion, method::Claim, quota::Quota, reading::LandmarkId};

/// What became of a camera's reading.
#[derive(Clone, Debug)]
pub struct Account {
    /// The method that read it.
    pub method: &'static str,
    /// What the method claimed; empty when the cue was absent.
    pub claims: Vec<Claim>,
    /// How many of them may be false.
    pub quota: Quota,
    /// Segments looked at and rejected, `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Heading that this reading told without those before it.
    pub alone_heading_rad: Option<Interval>,
    /// Whether a constraint was hung.
    pub constrained: bool,
    /// Whether it left nothing of the union.
    pub emptied: bool,
    /// Union at the stamp without this reading.
    pub prior: PoseUnion,
    /// Union at the stamp, just after.
    pub posterior: PoseUnion,
    /// Landmarks as the method knows them now: code, and box of world x and y.
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
