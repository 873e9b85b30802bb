//! The interface of a localization method: from one reading to one constraint on the pose, with the claims of what the method saw.

use interval::{Interval, contractor::Contractor};

use crate::{
    PoseUnion, Reading,
    bounds::Assumption,
    markers::{GridPlace, MarkerId},
    motion::{Motion, Twist},
    quota::Quota,
    reading::LandmarkId,
};

/// A localization method for one cue: it reads a sensor once and returns a constraint on the pose.
pub trait Method: Send {
    /// The method's name in scenes, summaries and tables.
    fn name(&self) -> &'static str;

    /// Whether the method's constraints restrict the heading alone, at any x and y.
    fn tells_heading_only(&self) -> bool {
        false
    }

    /// Whether the method reads readings of this kind.
    fn reads(&self, reading: &Reading) -> bool;

    /// A constraint on the pose at the reading's stamp, or `None` when the reading does not show the method's cue.
    ///
    /// `prior` encloses the pose at the stamp as known without this reading; `twist` is the body's velocity at the stamp.
    fn constrain(&mut self, reading: &Reading, prior: &PoseUnion, twist: &Twist) -> Option<Constraint>;

    /// Carries what the method keeps from earlier readings to the stamp of the next one; called before [`constrain`](Self::constrain). `_motion`
    /// gives the robot's motion between two recent stamps. While the wheels are doubted, and over spans that began during a doubt or before it,
    /// that motion comes from the robot's limits of speed and turn rate.
    fn carry_to(&mut self, _stamp_s: f64, _motion: MotionBetween) {}

    /// Learns lasting quantities, such as the positions of landmarks, from the reading that was constrained last. `posterior` encloses the pose at
    /// its stamp, and `motion` gives the robot's motion between two recent stamps, if no assumption was doubted between them.
    ///
    /// Not called while an assumption is doubted.
    fn learn(&mut self, _posterior: &PoseUnion, _motion: MotionBetween) {}

    /// Unlearns everything that was learnt from readings stamped later than `since_s`, because an assumption failed, perhaps as early as then.
    fn forget_since(&mut self, _since_s: f64) {}

    /// Whether something that the method read or learnt since the last call contradicts what the method knew before, which means that an
    /// assumption failed, perhaps some time ago. Called after each reading. A contradicting reading leaves what the method knows unchanged.
    fn take_contradiction(&mut self) -> bool {
        false
    }

    /// The constraint of a recent reading, computed again from what the method knows when called; `None` if the constraint depends on nothing
    /// learnt.
    fn renewed(&self, _stamp_s: f64) -> Option<Box<dyn Contractor<3> + Send + Sync>> {
        None
    }

    /// Notifies the method that the clock is set back to 0: what it has learnt until then is kept for good.
    fn clock_set_back(&mut self) {}

    /// Landmarks that the method has learnt: code, and box of world x and y.
    fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        Vec::new()
    }
}

/// The robot's motion from one stamp to a later one, in the frame of the first pose; `None` where the remembered readings do not cover the span.
pub type MotionBetween<'a> = &'a dyn Fn(f64, f64) -> Option<Motion>;

/// Constraint that one reading puts on the pose at its stamp.
pub struct Constraint {
    /// Name of the method that made the constraint.
    pub method: &'static str,
    /// The stamp at which the constraint on the pose holds.
    pub stamp_s: f64,
    /// Contractor that shrinks a box of poses at the stamp.
    pub on_pose: Box<dyn Contractor<3> + Send + Sync>,
    /// Contractor from this reading alone. Present where `on_pose` also uses earlier readings, which were carried to the stamp by the motion in
    /// between: while that motion is doubted, only this part is used.
    pub by_itself: Option<Box<dyn Contractor<3> + Send + Sync>>,
    /// The declared bounds that the constraint relies on.
    pub relies_on: Vec<Assumption>,
    /// Claims of what the method has seen, for the simulator to judge.
    pub claims: Vec<Claim>,
    /// How many of the constraint's claims may be false.
    pub quota: Quota,
    /// Whether the constraint restricts x, y and heading all together: only such a constraint can end the doubt about an assumption.
    pub decides: bool,
    /// Line segments that the method examined and rejected, for debug images: `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Interval for the heading by this reading without the earlier ones, near the prior's heading; `None` where the reading gives no heading of
    /// its own.
    pub alone_heading_rad: Option<Interval>,
}

/// An assertion by a method about what it saw. The simulator projects the true object with its own camera model and so knows whether the claim is
/// true.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// A joint of the tiled floor: at most `share_wrong` of the claimed points lie farther than their bound from the centre line of a true joint.
    FloorJoint {
        /// Points on the image of the joint's claimed centre line, each with the bound of its distance to that line, `[u_px, v_px, bound_px]`.
        /// They are given in the image as taken, in which lens and shutter bend the joint.
        points_px: Vec<[f64; 3]>,
        /// Share of the claimed points that may be farther from the true joint than their bound.
        share_wrong: f64,
    },
    /// A level line along one of the building's directions, whose image passes both given end points within the bound.
    WallLine {
        /// First and last point of the line in the image, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line from either end point, across the line.
        bound_px: f64,
    },
    /// An upright line, whose image passes both given end points within the bound.
    UprightLine {
        /// First and last point of the line in the image, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line from either end point, across the line.
        bound_px: f64,
    },
    /// A landmark that, at the stamp, lies in the given box of the robot frame.
    Landmark {
        /// The landmark that is claimed to be seen.
        landmark: LandmarkId,
        /// Box of the claimed landmark's position: forward and left of the robot origin, in metres.
        in_robot_m: [Interval; 2],
    },
    /// A claim that a certain marker of the ceiling was seen, with every one of its dots within a bound of the given image point.
    Marker {
        /// The marker that is claimed to be seen.
        marker: MarkerId,
        /// For each dot its place in the marker's grid and `[u, v, bound]`: the image of the dot's centre differs from (u, v) by at most the bound
        /// along u and along v.
        dots_px: Vec<(GridPlace, [f64; 3])>,
    },
}
