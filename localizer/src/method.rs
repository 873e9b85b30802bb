//! What every localization method offers: one reading in, one constraint on the pose out, with what it claims to have seen.

use interval::{Interval, contractor::Contractor};

use crate::{
    PoseUnion, Reading,
    bounds::Assumption,
    markers::{GridPlace, MarkerId},
    motion::{Motion, Twist},
    quota::Quota,
    reading::LandmarkId,
};

/// One cue: reads a sensor once and answers with a constraint.
pub trait Method: Send {
    /// The method's name in scenes, summaries and tables.
    fn name(&self) -> &'static str;

    /// Whether its constraints speak of the heading alone, whatever x and y.
    fn tells_heading_only(&self) -> bool {
        false
    }

    /// Whether readings of this kind are this method's.
    fn reads(&self, reading: &Reading) -> bool;

    /// A constraint on the pose at the reading's stamp, or `None` when the cue is absent.
    ///
    /// `prior` encloses the pose at the stamp as far as known before; `twist` is the body motion at the stamp.
    fn constrain(&mut self, reading: &Reading, prior: &PoseUnion, twist: &Twist) -> Option<Constraint>;

    /// Told before [`constrain`](Self::constrain): the stamp to come, and how the robot moved between two recent stamps, by reach alone
    /// while the wheels are doubted and over spans that began in a doubt or before it.
    fn carry_to(&mut self, _stamp_s: f64, _motion: MotionBetween) {}

    /// Learns what lasts, such as where landmarks are, from the reading last constrained: the pose at its stamp is in `posterior`,
    /// and `motion` tells how the robot moved between two recent stamps, if there was no doubt between them.
    ///
    /// Not called while an assumption is doubted.
    fn learn(&mut self, _posterior: &PoseUnion, _motion: MotionBetween) {}

    /// Unlearns what was learnt from readings stamped later than `since_s`: an assumption failed, perhaps since then.
    fn forget_since(&mut self, _since_s: f64) {}

    /// Whether what was read or learnt since this was last asked contradicts what was known before: an assumption failed, perhaps some
    /// time ago. Asked after each reading; what contradicted has changed nothing that the method knows.
    fn take_contradiction(&mut self) -> bool {
        false
    }

    /// The constraint of a recent reading made anew from what is known now; `None` where it stands on nothing that was learnt.
    fn renewed(&self, _stamp_s: f64) -> Option<Box<dyn Contractor<3> + Send + Sync>> {
        None
    }

    /// The clock is set back to 0: what was learnt so far stays for good.
    fn clock_set_back(&mut self) {}

    /// Landmarks as learnt so far: code, and box of world x and y.
    fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        Vec::new()
    }
}

/// Motion from one stamp to a later one in the frame of the first pose; `None` where the memory does not reach.
pub type MotionBetween<'a> = &'a dyn Fn(f64, f64) -> Option<Motion>;

/// What one reading says of the pose at its stamp.
pub struct Constraint {
    /// The method that made it.
    pub method: &'static str,
    /// The stamp it speaks of.
    pub stamp_s: f64,
    /// Shrinks a box of poses at the stamp.
    pub on_pose: Box<dyn Contractor<3> + Send + Sync>,
    /// What the reading tells by itself, where `on_pose` stands besides on earlier readings that were carried to it by the motion in between:
    /// where that motion is doubted, this is all there is.
    pub by_itself: Option<Box<dyn Contractor<3> + Send + Sync>>,
    /// The declared bounds it stands on.
    pub relies_on: Vec<Assumption>,
    /// What was seen, for the simulator to judge.
    pub claims: Vec<Claim>,
    /// How many of the claims may be false.
    pub quota: Quota,
    /// Whether it speaks of x, y and heading: only such a constraint may end a doubt.
    pub decides: bool,
    /// What was looked at and rejected, for debug frames: segments in pixels `[u0, v0, u1, v1]`.
    pub rejected_px: Vec<[f64; 4]>,
    /// Heading that this reading tells without those before it, near the prior's; `None` where it tells no heading of its own.
    pub alone_heading_rad: Option<Interval>,
}

/// What a method says it saw. The simulator projects the true object with its own camera model and knows whether it is so.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// A joint of the tiled floor: at most `share_wrong` of the points lie farther than their bound from the centre line of a true joint.
    FloorJoint {
        /// Points on the image of the claimed centre line with the bound of their distance to it, `[u_px, v_px, bound_px]`, in the image
        /// as taken: lens and shutter bend the joint in it.
        points_px: Vec<[f64; 3]>,
        /// Share of the points that may be farther away.
        share_wrong: f64,
    },
    /// A level line along one of the building's directions runs, in the image, within the bound of both ends.
    WallLine {
        /// First and last point, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line from either end, across the line.
        bound_px: f64,
    },
    /// An upright line runs, in the image, within the bound of both ends.
    UprightLine {
        /// First and last point, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line from either end, across the line.
        bound_px: f64,
    },
    /// At the stamp, this landmark lies in this box of the robot frame.
    Landmark {
        /// Which landmark.
        landmark: LandmarkId,
        /// Forward and left of the robot origin, in metres.
        in_robot_m: [Interval; 2],
    },
    /// The dots of one marker of the ceiling: every one of them is where it is said to be.
    Marker {
        /// Which marker.
        marker: MarkerId,
        /// Place in the grid, and `[u, v, bound]`: the image of the dot's centre lies within the bound of (u, v), along u and along v.
        dots_px: Vec<(GridPlace, [f64; 3])>,
    },
}
