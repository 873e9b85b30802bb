//! Post-localization: bounds of the poses and of the landmarks of a whole drive, once it is over, by all of its key frames.
//!
//! Paper 4 (section 4.2) calls PL(n) what n key frames tell together, those after a pose as well as those before it. The key frames of the drive are
//! taken in windows that overlap. The linear program of a window has all that the graph relates: the readings at the key frames, the ways between
//! them, and the constants of the robot, each with one value. It bounds every pose and every landmark in space of the window. With each pass over the
//! drive the boxes become narrower, so that rows that are made anew lose less.
//!
//! A map is made in this way where it is taught. A drive by the map can be looked at in this way, too ([`Localizer::post_localizing`]).

use std::sync::Arc;

use interval::{Interval, linear_program::Solver};

use crate::{
    PoseBox, PoseUnion,
    graph::{Hull, KeyFrames, Relations, Variable},
    map::{SeenAgain, SpacePoint, ViewPicture, Views},
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::Localizer;

/// Number of key frames of a window in which a map is made: with two sensors some twelve seconds. With 40 the landmarks of `scenes/landmarks` have
/// 0.0077 m³ at the median, in place of 0.0091 m³, where one image a second is a key frame.
const WINDOW: usize = 24;
/// Greatest number of passes over the drive. There the second one makes the volumes smaller by a tenth to a sixth, the third by some hundredths; where
/// the ways between key frames tell little, ten passes are worth their while.
const MOST_PASSES: usize = 12;
/// A further pass is made where the last one made headings or depths of landmarks narrower by more than this share.
const WORTHWHILE: f64 = 0.05;
/// Number of earlier pictures to each of which a map keeps the turn.
const MOST_TURNS: usize = 8;

/// Poses of a drive, by what was read after them as well as before.
#[derive(Clone, Debug, PartialEq)]
pub struct PostLocalized {
    /// Number of key frames of a window.
    pub window: usize,
    /// Stamps of key frames, in seconds, with boxes that contain the pose at that time. None is of the seconds before a doubt about an assumption, nor
    /// of the doubt itself. `None` if the readings contradict each other.
    pub poses: Option<Vec<(f64, PoseBox)>>,
}

impl Localizer {
    /// Keeps all key frames from now on, so that their poses can be bounded once more at the end of the drive ([`Localizer::post_localized`]), in
    /// windows of so many of them. Memory grows with the length of the drive.
    pub fn post_localizing(mut self, window: usize) -> Self {
        self.post_window = Some(window);
        self.graph.frames.keep_all();
        self
    }

    /// The poses at the key frames of the drive so far, bounded by all key frames of their windows; `None` for a localizer that was not made for that.
    /// The time that this takes grows with the drive and with the square of the window.
    pub fn post_localized(&mut self) -> Option<PostLocalized> {
        let window = self.post_window?;
        let at_stamps = |localizer: &Localizer| -> Vec<(f64, PoseBox)> {
            let in_true_time = |pose| localizer.in_true_time(&PoseUnion::single(pose)).hull();
            localizer.graph.frames.poses().map(|(stamp_s, pose)| (stamp_s, in_true_time(pose))).collect()
        };
        let poses = self.post_localize(window).then(|| at_stamps(self));
        Some(PostLocalized { window, poses })
    }

    /// The landmarks in space that all methods know, from a map or learnt. Where a method keeps the whole drive, they are first bounded by all of it,
    /// which takes about as long as the drive's own work did; there are none then if the readings contradict each other.
    pub fn space_points(&mut self) -> Vec<(LandmarkId, SpacePoint)> {
        if self.memories().any(|memory| memory.keeps_drive()) {
            if !self.post_localize(WINDOW) {
                return Vec::new();
            }
            self.learn_of_drive();
        }
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.space_points()).collect()
    }

    /// Pictures of the drive so far with the places in them of landmarks in space, where a method keeps the drive. To be asked for after
    /// [`Localizer::space_points`], by which the poses are bounded.
    pub fn views(&self) -> Option<Views> {
        let shown: Vec<(f64, PoseBox)> = self.graph.frames.poses().collect();
        let mut views = self.methods.iter().filter_map(|method| method.memory()?.views(&shown)).next()?;
        self.bound_turns(&mut views);
        Some(views)
    }

    /// Bounds the turns from picture to picture of this drive's views.
    fn bound_turns(&self, views: &mut Views) {
        let camera = views.cameras.len() - 1;
        for first in self.firsts(WINDOW) {
            let frames = self.graph.frames.window(first, WINDOW);
            let Ok(related) = frames.related(&self.landmarks()) else { continue };
            let mut solver = Solver::new(&related.program);
            let mut shown: Vec<(usize, usize, f64)> = Vec::new();
            for (frame, stamp_s) in frames.stamps() {
                let is_it = |picture: &ViewPicture| picture.camera == camera && picture.stamp_s == stamp_s;
                let Some(here) = views.pictures.iter().position(is_it) else { continue };
                let known = related.domain.value(Variable::Pose(frame, 2));
                // The heading that the picture shows may differ from that at its stamp.
                let stray_rad = 0.5 * (views.pictures[here].pose[2].width() - known.width()).max(0.0);
                for &(there, earlier, earlier_rad) in shown.iter().rev().take(MOST_TURNS) {
                    let function = [(Variable::Pose(frame, 2), 1.0), (Variable::Pose(earlier, 2), -1.0)];
                    let Some(turn) = related.bounds_of(&mut solver, &function) else { continue };
                    let turn = turn.inflate(stray_rad + earlier_rad);
                    let turns = &mut views.pictures[here].turned_since;
                    match turns.iter_mut().find(|(since, _)| *since == there) {
                        Some((_, bound)) => *bound = bound.intersect(turn),
                        None => turns.push((there, turn)),
                    }
                }
                shown.push((here, frame, stray_rad));
            }
        }
        views.pictures.iter_mut().for_each(|picture| picture.turned_since.sort_by_key(|(since, _)| *since));
    }

    /// How often the landmarks of a map in space that were looked for were found on this drive.
    pub fn seen_again(&self) -> Vec<SeenAgain> {
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.seen_again()).collect()
    }

    /// How the landmarks in space look that a method knows by their looks.
    pub fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        self.methods.iter().filter_map(|method| method.memory()).flat_map(|memory| memory.looks()).collect()
    }

    /// Bounds the poses at all key frames and the landmarks in space by each other, in windows of so many key frames of which each shares half with
    /// the next. Returns whether they agree with each other.
    fn post_localize(&mut self, window: usize) -> bool {
        self.learn_ways();
        self.graph.frames.know_gyro(self.fixes.as_ref().and_then(|fixes| fixes.corners()).unwrap_or_default());
        let firsts = self.firsts(window);
        let mut before = [f64::INFINITY; 2];
        for _ in 0..MOST_PASSES {
            if !firsts.iter().all(|&first| self.bound_window(first, window)) {
                return false;
            }
            let left = self.left_open();
            if !is_worthwhile(before, left) {
                break;
            }
            before = left;
        }
        true
    }

    /// How much is left open of the headings at all key frames, and of the inverse depths of all landmarks in space: their mean widths.
    fn left_open(&self) -> [f64; 2] {
        let memories = self.methods.iter().filter_map(|method| method.memory());
        let points = memories.flat_map(|memory| memory.space_points());
        let mean = |widths: Vec<f64>| widths.iter().sum::<f64>() / widths.len().max(1) as f64;
        let headings = self.graph.frames.poses().map(|(_, pose)| pose[2].width());
        [mean(headings.collect()), mean(points.map(|(_, point)| point.value[2].width()).collect())]
    }

    /// The places, among all key frames, of the first ones of windows of which each shares half with the next.
    fn firsts(&self, window: usize) -> Vec<usize> {
        let last = self.graph.frames.n_frames().saturating_sub(window);
        // The last window ends with the last key frame.
        (0..last).step_by((window / 2).max(1)).chain([last]).collect()
    }

    /// Bounds the landmarks that methods learn by what pictures of a whole window show of them together. Poses do not rely on it: where parts
    /// contradict the rest, nothing is learnt of them.
    fn learn_of_drive(&mut self) {
        let mut before = [f64::INFINITY; 2];
        for _ in 0..MOST_PASSES {
            for first in self.firsts(WINDOW) {
                let frames = self.graph.frames.window(first, WINDOW);
                let shown: Vec<(f64, PoseBox)> = frames.poses().collect();
                for at in 0..self.methods.len() {
                    let parts =
                        self.methods[at].memory().map_or_else(Vec::new, |memory| memory.learns_of_together(&shown));
                    for part in parts {
                        self.learn_part(at, frames.clone(), &part);
                    }
                }
            }
            let left = self.left_open();
            if !is_worthwhile(before, left) {
                break;
            }
            before = left;
        }
    }

    /// Bounds the landmarks of a part of what the method with the given place sees at the key frames of a window.
    fn learn_part(&mut self, at: usize, mut frames: KeyFrames, part: &[(f64, Arc<dyn Relations>)]) {
        let source = self.methods[at].name();
        for (stamp_s, reading) in frames.readings_mut().filter(|(_, reading)| reading.source == source) {
            if let Some((_, relations)) = part.iter().find(|(part_s, _)| *part_s == stamp_s) {
                reading.relations = Arc::clone(relations);
            }
        }
        let Ok(related) = frames.related(&[]) else { return };
        let is_point = |one: &Variable| matches!(one, Variable::Point(..));
        let wanted: Vec<Variable> = related.variables.iter().copied().filter(is_point).collect();
        let mut hull = Hull::new(related, wanted.clone());
        while !hull.advance() {}
        let Some(bounds) = hull.bounds() else { return };
        let bounds: Vec<(Variable, Interval)> = wanted.into_iter().zip(bounds).collect();
        if let Some(memory) = self.methods[at].memory_mut() {
            memory.narrow(&bounds);
        }
    }

    /// Bounds all that so many key frames relate, from that with the given place among all on.
    fn bound_window(&mut self, first: usize, window: usize) -> bool {
        let mut frames = self.graph.frames.window(first, window);
        for (_, reading) in frames.readings_mut() {
            let method = self.methods.iter().find(|method| method.name() == reading.source);
            let memory = method.and_then(|method| method.memory());
            let shown = reading.shown.as_ref();
            if let Some(anew) = memory.zip(shown).and_then(|(memory, shown)| memory.relations_again(shown)) {
                reading.relations = anew;
            }
        }
        // Where a quantity is not bounded, nothing can be told.
        let Ok(related) = frames.related(&self.landmarks()) else { return true };
        let is_wanted = |one: &Variable| matches!(one, Variable::Pose(..) | Variable::Point(..));
        let wanted: Vec<Variable> = related.variables.iter().copied().filter(is_wanted).collect();
        let mut hull = Hull::new(related, wanted.clone());
        while !hull.advance() {}
        let Some(bounds) = hull.bounds() else { return false };
        let bounds: Vec<(Variable, Interval)> = wanted.into_iter().zip(bounds).collect();
        self.graph.frames.narrow(&bounds, self.now_s);
        self.memories().for_each(|memory| memory.narrow(&bounds));
        true
    }
}

/// Whether a pass over the drive left so much less open than before that another one is worth its while.
fn is_worthwhile(before: [f64; 2], left: [f64; 2]) -> bool {
    (0..2).any(|at| left[at] < (1.0 - WORTHWHILE) * before[at])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
