//! Key frames: raw sightings of landmarks kept along the drive, so that what is learnt late narrows what was seen early.
//!
//! Everything is contracted anew from raw readings: intersections may be repeated without counting anything twice. Where matches may be
//! wrong, readings are kept in runs of consecutive readings, each run as long as a window: of consecutive sightings with a landmark's code
//! at most one in each window is wrong, but nothing of the kind is known for readings picked here and there.

use std::{collections::BTreeMap, sync::Arc};

use interval::contractor::{Contractor, Outcome, q_intersection};
use interval::{Interval, IntervalBox};

use crate::{
    PoseBox,
    method::MotionBetween,
    motion::{Motion, moved},
    reading::LandmarkId,
};

use super::{Freedom, PoseFromLandmarks, Seen, Solver, atlas::Atlas};

/// Distance by which the robot must have moved since the last key frame for another run of key frames to begin: key frames nearer to each
/// other show the same.
const APART_M: f64 = 0.15;
/// Angle by which the robot may instead have turned for another run of key frames to begin, as in `APART_M`.
const APART_RAD: f64 = 0.15;

/// Greatest number of readings that are kept as key frames; when it is reached, every second run is dropped.
const MOST: usize = 200;

/// Readings that are kept as key frames.
#[derive(Clone, Debug)]
pub(super) struct KeyFrames {
    frames: Vec<KeyFrame>,
    /// Stamp of the latest reading with the motion from the last key frame to it; `None` when the memory of motion does not reach back so
    /// far.
    way: Option<(f64, Motion)>,
    /// Stamp of the latest reading that was offered as a key frame.
    latest_s: f64,
    q_items: usize,
    /// Number of readings in a run of key frames.
    window: usize,
    n_runs: usize,
    /// Number of readings that the last run of key frames still lacks.
    lacking: usize,
}

#[derive(Clone, Debug)]
struct KeyFrame {
    stamp_s: f64,
    run: usize,
    /// Pose box of the key frame, by what was known when its reading was taken.
    taken: PoseBox,
    /// Pose box of the key frame, narrowed by what was learnt since its reading was taken.
    pose: PoseBox,
    /// Motion of the robot from the key frame before to this one, if known.
    motion: Option<Motion>,
    seen: Arc<[Seen]>,
}

impl KeyFrames {
    /// Makes an empty list of key frames. With `q_items` wrong matches in a reading, at least `wrong_spacing` right sightings with a
    /// landmark's code lie between two wrong ones.
    pub(super) fn new(q_items: usize, wrong_spacing: usize) -> Self {
        let window = if q_items == 0 { 1 } else { wrong_spacing + 1 };
        KeyFrames { frames: Vec::new(), way: None, latest_s: f64::NEG_INFINITY, q_items, window, n_runs: 0, lacking: 0 }
    }

    /// Keeps a reading as a key frame if it continues a run, or was taken far enough from the last key frame. A reading that was overtaken
    /// by a later one is not kept: the motion to it from the last key frame would run backwards in time, and motion is only known forwards.
    pub(super) fn keep(&mut self, stamp_s: f64, pose: PoseBox, seen: Vec<Seen>, motion: MotionBetween) {
        if stamp_s < self.latest_s {
            return;
        }
        self.latest_s = stamp_s;
        self.way = self.way.and_then(|(since_s, way)| Some((stamp_s, moved(&way, &motion(since_s, stamp_s)?))));
        if self.lacking == 0 {
            let is_apart = self.frames.last().is_none_or(|last| {
                let ([x, y, heading], [last_x, last_y, last_heading]) = (pose.midpoint(), last.taken.midpoint());
                (x - last_x).hypot(y - last_y) > APART_M || (heading - last_heading).abs() > APART_RAD
            });
            if !is_apart {
                return;
            }
            if self.frames.len() + self.window > MOST {
                self.thin();
            }
            self.n_runs += 1;
            self.lacking = self.window;
        }
        let motion = self.way.map(|(_, way)| way).filter(|_| !self.frames.is_empty());
        self.frames.push(KeyFrame { stamp_s, run: self.n_runs, taken: pose, pose, motion, seen: seen.into() });
        self.way = Some((stamp_s, IntervalBox::point(&[0.0; 3])));
        self.lacking -= 1;
    }

    /// Drops the last run of key frames if it is incomplete: a reading that was not learnt from came between, so its readings are not
    /// consecutive.
    pub(super) fn interrupt(&mut self) {
        if self.lacking > 0 {
            let open = self.n_runs;
            self.frames.retain(|frame| frame.run != open);
            self.lacking = 0;
            self.way = None;
        }
    }

    /// Ends the way since the last key frame: the robot was put elsewhere, or the motion since is doubted.
    pub(super) fn end_way(&mut self) {
        self.interrupt();
        for frame in &mut self.frames {
            frame.stamp_s = f64::NEG_INFINITY;
            frame.taken = frame.pose;
        }
        self.way = None;
        self.latest_s = f64::NEG_INFINITY;
    }

    /// Drops every second run of key frames and joins the motions across it.
    fn thin(&mut self) {
        let mut across: Option<Option<Motion>> = None;
        let mut kept: Vec<KeyFrame> = Vec::with_capacity(self.frames.len() / 2 + self.window);
        let (mut run, mut nth) = (0, 0);
        for mut frame in self.frames.drain(..) {
            if frame.run != run {
                (run, nth) = (frame.run, nth + 1);
            }
            if let Some(before) = across.take() {
                frame.motion = before.zip(frame.motion).map(|(first, then)| moved(&first, &then));
            }
            // The first run of key frames is kept, because the landmarks were first defined from it.
            if nth % 2 == 0 {
                across = Some(frame.motion);
            } else {
                kept.push(frame);
            }
        }
        // The motion since the last key frame began at a frame that may have been dropped.
        if kept.last().map(|frame| frame.stamp_s) != self.way.map(|(since_s, _)| since_s) {
            self.way = None;
        }
        self.frames = kept;
    }

    /// Contracts the pose of every key frame by the landmarks and by its neighbouring frames, and the landmarks by the poses: once along
    /// the drive and once back. Where no pose is left for a frame, or no place for a landmark, everything stays as it was.
    pub(super) fn sweep(&mut self, atlas: &mut Atlas, freedom: Freedom) -> Outcome {
        let (mut frames, mut known) = (self.clone(), atlas.clone());
        let outcome = frames.contract(&mut known, freedom);
        if outcome == Outcome::Feasible {
            (*self, *atlas) = (frames, known);
        }
        outcome
    }

    fn contract(&mut self, atlas: &mut Atlas, freedom: Freedom) -> Outcome {
        let n_frames = self.frames.len();
        let there = (0..n_frames).map(|idx| (idx, Direction::Forth));
        let back = (0..n_frames).rev().map(|idx| (idx, Direction::Back));
        for (idx, direction) in there.chain(back) {
            let mut outcome = Outcome::Feasible;
            if direction == Direction::Forth {
                outcome = self.contract_by_way(idx, direction);
            }
            if outcome == Outcome::Feasible {
                outcome = self.frames[idx].look(atlas, freedom, self.q_items);
            }
            if outcome == Outcome::Feasible {
                outcome = self.teach_at_the_end_of_a_run(idx, direction, atlas);
            }
            if outcome == Outcome::Feasible && direction == Direction::Back {
                outcome = self.contract_by_way(idx, direction);
            }
            if outcome != Outcome::Feasible {
                return outcome;
            }
        }
        Outcome::Feasible
    }

    /// Contracts a key frame by the one before it and the motion between them, or, backwards, the one before by the frame.
    fn contract_by_way(&mut self, idx: usize, direction: Direction) -> Outcome {
        let Some((before, frame)) = self.neighbours(idx) else { return Outcome::Feasible };
        let Some(motion) = frame.motion else { return Outcome::Feasible };
        match direction {
            Direction::Forth => frame.narrow(&moved(&before.pose, &motion)),
            Direction::Back => before.narrow(&came_from(&frame.pose, &motion, &before.pose)),
        }
    }

    /// Narrows the landmarks by the key frames of a run, when `idx` is the last frame of the run in the direction of the sweep.
    fn teach_at_the_end_of_a_run(&self, idx: usize, direction: Direction, atlas: &mut Atlas) -> Outcome {
        let run = self.frames[idx].run;
        let next = match direction {
            Direction::Forth => idx + 1,
            Direction::Back => idx.wrapping_sub(1),
        };
        let is_open = self.lacking > 0 && run == self.n_runs;
        if is_open || self.frames.get(next).is_some_and(|frame| frame.run == run) {
            return Outcome::Feasible;
        }
        let mut uses: BTreeMap<LandmarkId, Vec<[Interval; 2]>> = BTreeMap::new();
        for frame in self.frames.iter().filter(|frame| frame.run == run) {
            for seen in frame.seen.iter() {
                uses.entry(seen.landmark).or_default().push(seen.in_world(&frame.pose));
            }
        }
        for (landmark, places) in uses {
            let n_wrong = if self.q_items == 0 { 0 } else { places.len().div_ceil(self.window) };
            if places.len() > n_wrong {
                let boxes: Vec<IntervalBox<2>> = places.into_iter().map(IntervalBox::new).collect();
                let outcome = atlas.narrow(landmark, q_intersection(&boxes, n_wrong).components());
                if outcome != Outcome::Feasible {
                    return outcome;
                }
            }
        }
        Outcome::Feasible
    }

    /// Key frame before the one with a given index, and that key frame itself.
    fn neighbours(&mut self, idx: usize) -> Option<(&mut KeyFrame, &mut KeyFrame)> {
        let (before, from) = self.frames.split_at_mut(idx);
        Some((before.last_mut()?, from.first_mut()?))
    }
}

/// Direction of a sweep over the key frames: along the drive, or against it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Forth,
    Back,
}

/// Cause reported when no pose is left for a key frame: an assumption failed, perhaps long ago.
const CAUSE: &str = "no pose of a key frame fits the landmarks and the way";

impl KeyFrame {
    fn narrow(&mut self, pose: &PoseBox) -> Outcome {
        self.pose = self.pose.intersect(pose);
        if self.pose.is_empty() { Outcome::Empty(CAUSE) } else { Outcome::Feasible }
    }

    /// Contracts the pose of the key frame by the landmarks seen in it.
    fn look(&mut self, atlas: &Atlas, freedom: Freedom, q_items: usize) -> Outcome {
        let bounded = self.seen.iter().filter(|seen| seen.is_bounded());
        let pairs: Vec<_> = bounded.filter_map(|seen| Some((atlas.place(seen.landmark)?, seen.in_robot_m))).collect();
        let mut pose = self.pose;
        PoseFromLandmarks::new(pairs, q_items, freedom, Solver::OneShot).contract(&mut pose);
        self.narrow(&pose)
    }
}

/// Box of the poses in `domain` from which `motion` leads into `reached`: θ = θ′ − turn, t = t′ − R(θ)·(f, l).
fn came_from(reached: &PoseBox, motion: &Motion, domain: &PoseBox) -> PoseBox {
    let heading = domain[2].intersect(reached[2] - motion[2]);
    let (cos, sin) = (heading.cos(), heading.sin());
    let way = [cos * motion[0] - sin * motion[1], sin * motion[0] + cos * motion[1]];
    IntervalBox::from([reached[0] - way[0], reached[1] - way[1], heading])
}
