//! The interface of a localization method: from one sensor reading it makes one constraint on the robot's pose, with claims, which are checkable
//! assertions of what it saw. The localizer carries the constraint to the present, weighs it when readings contradict each other, and tells the method
//! what to forget.

use std::sync::Arc;

use interval::{Interval, contractor::Contractor};

use crate::{
    PoseBox, PoseUnion, Reading,
    bounds::Assumption,
    graph::{Relations, Variable},
    map::{SeenAgain, SpacePoint, ViewSight, Views},
    markers::{GridPlace, MarkerId},
    motion::{Motion, Twist},
    quota::Quota,
    reading::LandmarkId,
    vision::point_features::Landmark,
};

/// A localization method for one cue, such as floor joints or ceiling markers: it evaluates each reading of its sensor once and returns a constraint
/// on the pose. A method that keeps something from one reading to the next has a [`Memory`] as well.
pub trait Method: Send {
    /// The method's name in scenes, summaries and tables.
    fn name(&self) -> &'static str;

    /// Whether the method uses readings of the given reading's kind.
    fn reads(&self, reading: &Reading) -> bool;

    /// A constraint on the pose at the reading's stamp, or `None` when the reading does not show the method's cue.
    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint>;

    /// What the method keeps from one reading to the next; `None` for a method that evaluates each reading by itself.
    fn memory(&self) -> Option<&dyn Memory> {
        None
    }

    /// The same as [`memory`](Self::memory), to be changed.
    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        None
    }
}

/// What the localizer knows at a reading's stamp without the reading.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Poses of the robot at the reading's stamp.
    pub prior: &'a PoseUnion,
    /// Velocity of the body at the reading's stamp.
    pub twist: &'a Twist,
    /// The robot's motion between two recent stamps. After a contradiction has shown that some assumption failed, the wheels are doubted until it is
    /// known which: for spans during that doubt, and for spans that began before its end, the motion comes from the robot's limits of speed and turn
    /// rate.
    pub motion: MotionBetween<'a>,
    /// Markers that earlier contradictions showed not to be where the map has them. What a reading shows of them is left out.
    pub set_aside: &'a [MarkerId],
}

impl<'a> Context<'a> {
    /// The context of a robot at rest of whose motion before nothing is remembered.
    pub fn at_rest(prior: &'a PoseUnion) -> Context<'a> {
        const REST: Twist = Twist { forward_m_per_s: 0.0, turn_rad_per_s: 0.0 };
        Context { prior, twist: &REST, motion: &|_, _| None, set_aside: &[] }
    }
}

/// Function that gives the robot's motion from one stamp to a later one, in the frame of the robot at the first stamp; `None` where the remembered
/// motion readings do not cover the span between the stamps.
pub type MotionBetween<'a> = &'a dyn Fn(f64, f64) -> Option<Motion>;

/// What a method keeps from one reading to the next, such as earlier images, or landmarks that it has learnt.
pub trait Memory {
    /// Forgets everything that was read or learnt from readings stamped later than `since_s`, because an assumption has failed and may have been false
    /// since then.
    fn forget_since(&mut self, since_s: f64);

    /// Notes that a new drive begins, with the clock set back to 0. What was learnt before is kept and can no longer be unlearnt.
    fn clock_set_back(&mut self);

    /// Learns what outlasts one reading, such as the positions of landmarks, from the reading that was constrained last. `_posterior` encloses the
    /// pose at its stamp, with the reading's constraint applied. `_motion` gives the robot's motion between two recent stamps, or `None` if the first
    /// of them lies before the end of a doubt about a failed assumption.
    ///
    /// Not called while an assumption is doubted.
    fn learn(&mut self, _posterior: &PoseUnion, _motion: MotionBetween) {}

    /// Whether something that the method read or learnt since the last call contradicts what the method knew before, which means that an
    /// assumption failed, perhaps some time ago. Called after each reading. A contradicting reading leaves what the method knows unchanged.
    fn take_contradiction(&mut self) -> bool {
        false
    }

    /// The contractor of a recent reading, computed again from what has been learnt by the time of the call; `None` if the method's constraints
    /// depend on nothing learnt, or if it does not remember the reading.
    fn on_pose_again(&self, _stamp_s: f64) -> Option<OnPose> {
        None
    }

    /// What a reading relates, by what is known of its landmarks at the time of the call; `None` where the method does not remember the reading.
    fn relations_again(&self, _stamp_s: f64) -> Option<Arc<dyn Relations>> {
        None
    }

    /// Narrows what is known of the method's quantities by bounds that follow from readings up to the given stamp. Bounds of other quantities are passed
    /// over.
    fn narrow(&mut self, _bounds: &[(Variable, Interval)], _stamp_s: f64) {}

    /// Whether key frames of the whole drive are to be kept, so that at its end everything is bounded by all of them.
    fn keeps_drive(&self) -> bool {
        false
    }

    /// What the readings at some stamps relate of which learning alone may make use, since nothing bounds how much of it may be wrong: for each part of the
    /// landmarks that is bounded apart from the others, what it has at which stamps. `_shown` are the stamps, with boxes of the poses there.
    fn learns_of_together(&self, _shown: &[(f64, PoseBox)]) -> Vec<Vec<(f64, Arc<dyn Relations>)>> {
        Vec::new()
    }

    /// Pictures of the drive, and where they show landmarks in space, with those that came with a map; `None` for a method that does not keep the drive.
    /// `_shown` are the stamps of key frames, with boxes of the poses there.
    fn views(&self, _shown: &[(f64, PoseBox)]) -> Option<Views> {
        None
    }

    /// Landmarks that have been learnt: code, and box of world x and y.
    fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        Vec::new()
    }

    /// Landmarks in space that are known, from a map or learnt, in the order of their numbers.
    fn space_points(&self) -> Vec<(LandmarkId, SpacePoint)> {
        Vec::new()
    }

    /// How often the landmarks of the map that were looked for were found on this drive, in the order of their numbers.
    fn seen_again(&self) -> Vec<SeenAgain> {
        Vec::new()
    }

    /// How the landmarks in space look that are known by their looks, in the order of their numbers.
    fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        Vec::new()
    }
}

/// Contractor on boxes of poses: x, y and heading.
pub type OnPose = Box<dyn Contractor<3> + Send + Sync>;

/// Constraint that one reading puts on the pose at its stamp.
pub struct Constraint {
    /// Name of the method that made the constraint.
    pub method: &'static str,
    /// The stamp at which the constraint on the pose holds.
    pub stamp_s: f64,
    /// Contractor that removes, from a box of poses at the constraint's stamp, poses that the constraint rules out.
    pub on_pose: OnPose,
    /// Contractor from this reading alone. Present where `on_pose` also uses earlier readings, which were carried to the stamp by the robot's motion
    /// in between: under a hypothesis that this motion was wrong, only this part is used.
    pub by_itself: Option<OnPose>,
    /// For each marker of a reading that shows several, the contractor from it alone: where one of them is taken to be misplaced, the others are used.
    pub by_marker: Vec<(MarkerId, OnPose)>,
    /// Whether the constraint restricts the heading alone, at any x and y.
    pub heading_only: bool,
    /// The declared bounds that the constraint relies on.
    pub relies_on: Vec<Assumption>,
    /// Claims, which are assertions of what the method saw in the reading; the simulator checks them against the truth.
    pub claims: Vec<Claim>,
    /// Quota that says how many of the constraint's claims may be false.
    pub quota: Quota,
    /// Whether the constraint counts as evidence when a doubt about a failed assumption is to be ended. It should, if it restricts x, y and heading,
    /// by itself or together with others of its kind.
    pub decides: bool,
    /// Line segments that the method examined and rejected, for debug images: `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Interval for the heading by this reading without the earlier ones, near the headings that were possible before the reading; `None` where the
    /// reading by itself gives no heading.
    pub alone_heading_rad: Option<Interval>,
    /// What the reading relates, for the graph of key frames; `None` where the method relates nothing, or cannot be sure that no item is wrong.
    pub relations: Option<Arc<dyn Relations>>,
}

impl Constraint {
    /// A constraint of one reading that makes no claims, relies on no declared bound, and relates nothing. It counts as evidence when a doubt is to be
    /// ended.
    pub fn new(method: &'static str, stamp_s: f64, on_pose: impl Contractor<3> + Send + Sync + 'static) -> Constraint {
        Constraint {
            method,
            stamp_s,
            on_pose: Box::new(on_pose),
            by_itself: None,
            by_marker: Vec::new(),
            heading_only: false,
            relies_on: Vec::new(),
            claims: Vec::new(),
            quota: Quota::of_each(0),
            decides: true,
            rejected_px: Vec::new(),
            alone_heading_rad: None,
            relations: None,
        }
    }
}

/// An assertion by a method about what it saw. The simulator projects the true object with its own camera model and so knows whether the claim is
/// true.
#[derive(Clone, Debug, PartialEq)]
pub enum Claim {
    /// A claim that a joint of the tiled floor was seen: at most `share_wrong` of the claimed points lie farther than their bound from the centre
    /// line of a true joint.
    FloorJoint {
        /// Points on the image of the joint's claimed centre line, each with the bound on its distance from the image of the true joint's centre
        /// line, `[u_px, v_px, bound_px]`. They are given in the image as taken, in which lens and shutter bend the joint.
        points_px: Vec<[f64; 3]>,
        /// Share of the claimed points that may be farther from the true joint than their bound.
        share_wrong: f64,
    },
    /// A claim that a level line along one of the building's directions was seen, and that its image passes both given end points within the bound.
    /// As for all claims of edges, the image is that of a global shutter at the stamp, also where the camera's shutter is a rolling one.
    WallLine {
        /// First and last point of the claimed line in the image, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line's image from either end point, across the line, in pixels.
        bound_px: f64,
    },
    /// A claim that an upright line was seen, and that its image passes both given end points within the bound.
    UprightLine {
        /// First and last point of the claimed line in the image, `[u, v]`.
        ends_px: [[f64; 2]; 2],
        /// Greatest distance of the true line's image from either end point, across the line, in pixels.
        bound_px: f64,
    },
    /// A claim that a certain landmark was seen, and that it lies in the given box of the robot frame at the reading's stamp.
    Landmark {
        /// The landmark that is claimed to be seen.
        landmark: LandmarkId,
        /// Box of the claimed landmark's position at the reading's stamp: forward and left of the robot origin, in metres.
        in_robot_m: [Interval; 2],
    },
    /// A claim that a certain marker of the ceiling was seen, with every one of its dots within a bound of the given image point.
    Marker {
        /// The marker that is claimed to be seen.
        marker: MarkerId,
        /// For each of the marker's dots its place in the marker's grid and `[u, v, bound]`: the true image of the dot's centre differs from (u, v)
        /// by at most the bound along u and along v.
        dots_px: Vec<(GridPlace, [f64; 3])>,
    },
    /// A claim that a beam of a planar range scanner ended at the front of a mapped wall.
    WallPoint {
        /// Bearing of the beam from the scanner's forward axis, counter-clockwise.
        bearing_rad: f64,
        /// Distance that the beam measured.
        distance_m: f64,
        /// Greatest distance of the measured point from the nearest mapped wall.
        within_m: f64,
    },
    /// A claim that a point in space was seen: the true image of some point of the given box is at the given place of the image, within the bound along
    /// u and along v.
    SpacePoint {
        /// The landmark that is claimed to be seen.
        landmark: LandmarkId,
        /// Box of the landmark's place in the world.
        point: SpacePoint,
        /// Column u and row v in the image as taken, which the lens bends.
        at_px: [f64; 2],
        /// Greatest error of the image point along u and along v.
        half_width_px: [f64; 2],
        /// Where a picture of the drive that taught the map is claimed to show the same point.
        view: Option<ViewSight>,
        /// The thing that the landmark is on, such as a painting, if the map tells; by a number of its own.
        thing: Option<u32>,
    },
    /// A claim that an upright edge of a mapped wall was seen: at least one of the given image lines is, within its bound, the image of at least one
    /// of the given edges of the map, where that truly stands.
    WallUpright {
        /// First and last point of each image line, `[u, v]`, with the greatest distance of the true edge's image from either of them, across the
        /// line, in pixels.
        lines: Vec<([[f64; 2]; 2], f64)>,
        /// Places of the edges on the map, world x and y.
        posts_m: Vec<[f64; 2]>,
    },
}
