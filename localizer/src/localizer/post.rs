//! Post-localization: bounds of the poses and of the landmarks of a whole drive, once it is over, by all of its key frames.
//!
//! Paper 4 (section 4.2) calls PL(n) what n key frames tell together, those after a pose as well as those before it. The key frames of the drive are
//! taken in windows that overlap. The linear program of a window has all that the graph relates: the readings at the key frames, the ways between
//! them, and the constants of the robot, each with one value. It bounds every pose and every landmark in space of the window. With each pass over the
//! drive the boxes become narrower, so that rows that are made anew lose less.

use interval::Interval;

use crate::{
    graph::{Hull, Variable},
    map::{SeenAgain, SpacePoint},
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::Localizer;

/// Number of key frames of a window: with two sensors some twelve seconds. With 40 the landmarks of `scenes/landmarks` have 0.0077 m³ at the median, in
/// place of 0.0091 m³.
const WINDOW: usize = 24;
/// Number of key frames from one window to the next.
const STRIDE: usize = 12;
/// Number of passes over the drive. There the second one makes the volumes smaller by a tenth to a sixth, the third by some hundredths.
const PASSES: usize = 3;

impl Localizer {
    /// The landmarks in space that all methods know, from a map or learnt. Where a method keeps the whole drive, they are first bounded by all of it,
    /// which takes about as long as the drive's own work did; there are none then if the readings contradict each other.
    pub fn space_points(&mut self) -> Vec<(LandmarkId, SpacePoint)> {
        if self.memories().any(|memory| memory.keeps_drive()) && !self.post_localize() {
            return Vec::new();
        }
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.space_points()).collect()
    }

    /// How often the landmarks of a map in space that were looked for were found on this drive.
    pub fn seen_again(&self) -> Vec<SeenAgain> {
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.seen_again()).collect()
    }

    /// How the landmarks in space look that a method knows by their looks.
    pub fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.looks()).collect()
    }

    /// Bounds the poses at all key frames and the landmarks in space by each other. Returns whether they agree with each other.
    fn post_localize(&mut self) -> bool {
        self.learn_ways();
        self.graph.frames.know_gyro(self.fixes.as_ref().and_then(|fixes| fixes.corners()).unwrap_or_default());
        let last = self.graph.frames.n_frames().saturating_sub(WINDOW);
        // The last window ends with the last key frame.
        let firsts: Vec<usize> = (0..last).step_by(STRIDE).chain([last]).collect();
        (0..PASSES).all(|_| firsts.iter().all(|&first| self.bound_window(first)))
    }

    /// Bounds all that the key frames of one window relate, from that with the given place among all on.
    fn bound_window(&mut self, first: usize) -> bool {
        let mut frames = self.graph.frames.window(first, WINDOW);
        for (stamp_s, reading) in frames.readings_mut() {
            let method = self.methods.iter().find(|method| method.name() == reading.source);
            if let Some(anew) = method.and_then(|method| method.memory()?.relations_again(stamp_s)) {
                reading.relations = anew;
            }
        }
        let newest_s = frames.latest_s();
        // Where a quantity is not bounded, nothing can be told.
        let (Ok(related), Some(newest_s)) = (frames.related(&self.landmarks()), newest_s) else { return true };
        let is_wanted = |one: &Variable| matches!(one, Variable::Pose(..) | Variable::Point(..));
        let wanted: Vec<Variable> = related.variables.iter().copied().filter(is_wanted).collect();
        let mut hull = Hull::new(related, wanted.clone());
        while !hull.advance() {}
        let Some(bounds) = hull.bounds() else { return false };
        let bounds: Vec<(Variable, Interval)> = wanted.into_iter().zip(bounds).collect();
        self.graph.frames.narrow(&bounds);
        self.memories().for_each(|memory| memory.narrow(&bounds, newest_s));
        true
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
