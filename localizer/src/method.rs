//! What every localization method offers: one reading in, one constraint on the pose out, with what it claims to have seen.

use crate::{Contractor, PoseUnion, Reading};

/// Name of a declared bound, such as `wheels.slip` or `floor_tiles.laying`.
pub type Assumption = &'static str;

/// One cue: reads a sensor once and answers with a constraint.
pub trait Method: Send {
    /// The method's name in scenes, summaries and tables.
    fn name(&self) -> &'static str;

    /// A constraint on the pose at the reading's stamp, or `None` when the cue is absent or the reading is not this method's.
    ///
    /// `prior` encloses the pose at the stamp as far as known before; `twist` is the body motion at the stamp.
    fn constrain(&mut self, reading: &Reading, prior: &PoseUnion, twist: &Twist) -> Option<Constraint>;
}

/// Body motion at a stamp as the wheels tell it: where the blur in an image comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed.
    pub forward_m_per_s: f64,
    /// Turn rate, counter-clockwise.
    pub turn_rad_per_s: f64,
}

/// What one reading says of the pose at its stamp.
pub struct Constraint {
    /// The method that made it.
    pub method: &'static str,
    /// The stamp it speaks of.
    pub stamp_s: f64,
    /// Shrinks a box of poses at the stamp.
    pub on_pose: Box<dyn Contractor<3> + Send + Sync>,
    /// The declared bounds it stands on.
    pub relies_on: Vec<Assumption>,
    /// What was seen, for the simulator to judge.
    pub claims: Vec<Claim>,
    /// At most this many of the claims may be false.
    pub q_items: usize,
    /// What was looked at and rejected, for debug frames: segments in pixels `[u0, v0, u1, v1]`.
    pub rejected_px: Vec<[f64; 4]>,
}

/// What a method says it saw. The simulator projects the true object with its own camera model and knows whether it is so.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// A joint of the tiled floor: at most `share_wrong` of the points lie farther than their bound from the centre line of a true joint.
    FloorJoint {
        /// Points on the claimed centre line with the bound of their distance to it: `[u_px, v_px, bound_px]`.
        points_px: Vec<[f64; 3]>,
        /// Share of the points that may be farther away.
        share_wrong: f64,
    },
}
