//! The interface of a localization method: from one sensor reading it makes one constraint on the robot's pose, with claims, which are checkable
//! assertions of what it saw. The localizer carries the constraint to the present, weighs it when readings contradict each other, and holds what earlier
//! readings showed for methods that make their constraints of several readings.

mod claim;
mod memory;
mod window;

use std::{any::Any, sync::Arc};

use interval::contractor::Contractor;

use crate::{
    PoseBox, PoseUnion, Reading,
    bounds::Assumption,
    graph::{Relations, Stray},
    markers::MarkerId,
    motion::{Motion, Twist},
    quota::Quota,
};

pub use crate::reading::Shown;
pub use claim::Claim;
pub use memory::{Knowledge, Memory};
pub use window::{Earlier, Window};

/// A localization method for one cue, such as floor joints or ceiling markers: it evaluates each reading of its sensor once and returns a constraint
/// on the pose. A method that learns something from its readings has a [`Memory`] as well.
pub trait Method: Send {
    /// The method's name in scenes, summaries and tables.
    fn name(&self) -> &'static str;

    /// Whether the method uses readings of the given reading's kind.
    fn reads(&self, reading: &Reading) -> bool;

    /// A constraint on the pose at the reading's stamp, or `None` when the reading does not show the method's cue.
    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint>;

    /// Number of earlier readings of which the method makes its constraints together with the latest one. The localizer holds what they showed,
    /// [`Constraint::shown`], and gives it to the method in [`Context::earlier`].
    fn n_earlier(&self) -> usize {
        0
    }

    /// What the method learns from its readings; `None` for a method that learns nothing.
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
    /// How far the robot can have gone within the error of a stamp.
    pub stray: StrayWithin<'a>,
    /// The method's earlier readings that are held, the oldest first, as seen from the reading's stamp.
    pub earlier: &'a [Earlier],
    /// Markers that earlier contradictions showed not to be where the map has them. What a reading shows of them is left out.
    pub set_aside: &'a [MarkerId],
}

impl<'a> Context<'a> {
    /// The context of a robot at rest of whose motion before nothing is remembered.
    pub fn at_rest(prior: &'a PoseUnion) -> Context<'a> {
        const REST: Twist = Twist { forward_m_per_s: 0.0, turn_rad_per_s: 0.0 };
        let stray: StrayWithin = &|_, _| Stray::default();
        Context { prior, twist: &REST, motion: &|_, _| None, stray, earlier: &[], set_aside: &[] }
    }
}

/// Function that gives the robot's motion from one stamp to a later one, in the frame of the robot at the first stamp; `None` where the remembered
/// motion readings do not cover the span between the stamps.
pub type MotionBetween<'a> = &'a dyn Fn(f64, f64) -> Option<Motion>;

/// Function that gives, for a stamp and its greatest error, how far the robot can have gone between the stamp and the true instant.
pub type StrayWithin<'a> = &'a dyn Fn(f64, f64) -> Stray;

/// Contractor on boxes of poses: x, y and heading.
pub type OnPose = Box<dyn Contractor<3> + Send + Sync>;

/// What of the pose a constraint restricts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restricts {
    /// Place and heading, as far as the reading tells them.
    Pose,
    /// The heading alone, at any x and y.
    Heading,
}

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
    /// What of the pose the constraint restricts.
    pub restricts: Restricts,
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
    /// Box of the poses, near those known before, that this reading allows without the earlier ones if no more of its claims are false than its own
    /// quota says; `None` where the method does not tell.
    pub alone: Option<PoseBox>,
    /// What the reading showed, for all that is made of the reading later: constraints of later readings, what the method learns from it, and the same
    /// constraint anew. `None` where nothing is.
    pub shown: Option<Shown>,
    /// Whether constraints of later readings are made of this reading, too.
    pub is_held: bool,
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
            restricts: Restricts::Pose,
            relies_on: Vec::new(),
            claims: Vec::new(),
            quota: Quota::of_each(0),
            decides: true,
            rejected_px: Vec::new(),
            alone: None,
            shown: None,
            is_held: false,
            relations: None,
        }
    }

    /// The same constraint, with what its reading showed.
    pub fn showing(self, shown: impl Any + Send + Sync) -> Constraint {
        Constraint { shown: Some(Arc::new(shown)), ..self }
    }
}
