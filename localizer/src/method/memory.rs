//! What a method learns from its readings.

use std::{any::Any, sync::Arc};

use interval::Interval;

use crate::{
    PoseBox, PoseUnion,
    graph::{Relations, Variable},
    map::{SeenAgain, SpacePoint, Views},
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::{OnPose, Shown};

/// What a method knows at one time, as a value of a type of the method's own.
pub type Knowledge = Arc<dyn Any + Send + Sync>;

/// What a method learns from its readings, such as the places of landmarks.
pub trait Memory {
    /// What the method knows now. The localizer asks for it every second and keeps some of the answers, so that it should cost little; `None` for a
    /// method that has nothing to take back.
    fn knowledge(&self) -> Option<Knowledge> {
        None
    }

    /// Takes back all that was learnt since an earlier time, because an assumption has failed and may have been false since then. `known` is what the
    /// method knew at that time.
    fn go_back(&mut self, _known: &Knowledge) {}

    /// Notes that a new drive begins, with the clock set back to 0. What was learnt before is kept.
    fn clock_set_back(&mut self) {}

    /// Learns what outlasts one reading, such as the positions of landmarks. `_shown` is what the reading showed, as its constraint says, and
    /// `_posterior` encloses the pose at its stamp, with the constraint applied; it is `None` while an assumption is doubted, when nothing is to be learnt
    /// from the reading.
    fn learn(&mut self, _shown: &Shown, _posterior: Option<&PoseUnion>) {}

    /// Whether something that the method read or learnt since the last call contradicts what the method knew before, which means that an
    /// assumption failed, perhaps some time ago. Called after each reading. A contradicting reading leaves what the method knows unchanged.
    fn take_contradiction(&mut self) -> bool {
        false
    }

    /// The contractor of an earlier reading, which showed `_shown`, by what is known at the time of the call; `None` if the method's constraints depend
    /// on nothing learnt.
    fn on_pose_again(&self, _shown: &Shown) -> Option<OnPose> {
        None
    }

    /// What an earlier reading, which showed `_shown`, relates by what is known at the time of the call; `None` if that depends on nothing learnt.
    fn relations_again(&self, _shown: &Shown) -> Option<Arc<dyn Relations>> {
        None
    }

    /// Whether the method learns landmarks that its readings relate, so that the graph is to bound them while the robot drives.
    fn learns_landmarks(&self) -> bool {
        false
    }

    /// Narrows what is known of the method's quantities by bounds that follow from its readings. Bounds of other quantities are passed over.
    fn narrow(&mut self, _bounds: &[(Variable, Interval)]) {}

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
