//! What a method learns from its readings.

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseBox, PoseUnion,
    graph::{Relations, Variable},
    map::{SeenAgain, SpacePoint, Views},
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::{MotionBetween, OnPose};

/// What a method learns from its readings, such as the places of landmarks.
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
