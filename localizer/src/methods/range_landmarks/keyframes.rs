//! Raw sightings kept along the way, so that what is learnt late narrows what was seen early.
//!
//! Everything is contracted anew from raw readings: intersections may be repeated without counting anything twice. With wrong
//! matches readings are kept in runs of consecutive ones, as long as a window, because of m consecutive uses of a code at most one in
//! each window is wrong; of readings picked here and there nothing of the kind is known.

use std::collections::BTreeMap;

use interval::contractor::{Contractor, Outcome, q_intersection};
use interval::{Interval, IntervalBox};

use crate::{
    PoseBox,
    method::MotionBetween,
    motion::{Motion, moved},
    reading::LandmarkId,
};

use super::{Freedom, PoseFromLandmarks, Seen, Solver, atlas::Atlas};

/// A run begins when the robot has since moved or turned by this much: nearer ones see the same.
const APART_M: f64 = 0.15;
/// See `APART_M`.
const APART_RAD: f64 = 0.15;

/// When so many readings are kept, every second run goes.
const MOST: usize = 200;

/// Readings kept.
#[derive(Clone, Debug)]
pub(super) struct KeyFrames {
    frames: Vec<KeyFrame>,
    /// Motion since the last frame, up to a stamp; none when the wheels' memory does not reach.
    way: Option<(f64, Motion)>,
    /// Stamp of the latest reading.
    latest_s: f64,
    q_items: usize,
    /// Readings in a run.
    window: usize,
    n_runs: usize,
    /// Readings that the last run still lacks.
    lacking: usize,
}

#[derive(Clone, Debug)]
struct KeyFrame {
    stamp_s: f64,
    run: usize,
    /// Pose box when it was taken, from what was known then.
    taken: PoseBox,
    /// The same, narrowed by what was learnt since.
    pose: PoseBox,
    /// Motion from the frame before.
    motion: Option<Motion>,
    seen: Vec<Seen>,
}

impl KeyFrames {
    /// None yet. With `q_items` wrong matches in a reading, `wrong_spacing` right ones lie between two wrong ones of a code.
    pub(super) fn new(q_items: usize, wrong_spacing: usize) -> Self {
        let window = if q_items == 0 { 1 } else { wrong_spacing + 1 };
        KeyFrames { frames: Vec::new(), way: None, latest_s: f64::NEG_INFINITY, q_items, window, n_runs: 0, lacking: 0 }
    }

    /// Keeps a reading if it continues a run, or adds to the last one kept. One that was overtaken is not kept: the way to it from the last
    /// one leads back, and motion is known forward only.
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
        self.frames.push(KeyFrame { stamp_s, run: self.n_runs, taken: pose, pose, motion, seen });
        self.way = Some((stamp_s, IntervalBox::point(&[0.0; 3])));
        self.lacking -= 1;
    }

    /// A reading went by that was not learnt from: what there is of the last run is no run.
    pub(super) fn interrupt(&mut self) {
        if self.lacking > 0 {
            let open = self.n_runs;
            self.frames.retain(|frame| frame.run != open);
            self.lacking = 0;
            self.way = None;
        }
    }

    /// Drops every second run and joins the motions across it.
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
            // The first run stays: it is what the landmarks were defined from.
            if nth % 2 == 0 {
                across = Some(frame.motion);
            } else {
                kept.push(frame);
            }
        }
        // The way since the last frame began at one that may be gone.
        if kept.last().map(|frame| frame.stamp_s) != self.way.map(|(since_s, _)| since_s) {
            self.way = None;
        }
        self.frames = kept;
    }

    /// Contracts the pose of every key frame by the landmarks and by its neighbours, and the landmarks by the poses: once along the
    /// way, and once back. Where a frame can have been nowhere, or a landmark can be nowhere, all stays as it was.
    pub(super) fn sweep(&mut self, now_s: f64, atlas: &mut Atlas, freedom: Freedom) -> Outcome {
        let (mut frames, mut known) = (self.clone(), atlas.clone());
        let outcome = frames.contract(now_s, &mut known, freedom);
        if outcome == Outcome::Feasible {
            (*self, *atlas) = (frames, known);
        }
        outcome
    }

    fn contract(&mut self, now_s: f64, atlas: &mut Atlas, freedom: Freedom) -> Outcome {
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
                outcome = self.teach_at_the_end_of_a_run(idx, direction, now_s, atlas);
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

    /// Contracts a frame by the one before it, or the other way about.
    fn contract_by_way(&mut self, idx: usize, direction: Direction) -> Outcome {
        let Some((before, frame)) = self.neighbours(idx) else { return Outcome::Feasible };
        let Some(motion) = frame.motion else { return Outcome::Feasible };
        match direction {
            Direction::Forth => frame.narrow(&moved(&before.pose, &motion)),
            Direction::Back => before.narrow(&came_from(&frame.pose, &motion, &before.pose)),
        }
    }

    /// Narrows the landmarks by a run when `idx` is its last frame on the way.
    fn teach_at_the_end_of_a_run(&self, idx: usize, direction: Direction, now_s: f64, atlas: &mut Atlas) -> Outcome {
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
            for seen in &frame.seen {
                uses.entry(seen.landmark).or_default().push(seen.in_world(&frame.pose));
            }
        }
        for (landmark, places) in uses {
            let n_wrong = if self.q_items == 0 { 0 } else { places.len().div_ceil(self.window) };
            if places.len() > n_wrong {
                let boxes: Vec<IntervalBox<2>> = places.into_iter().map(IntervalBox::new).collect();
                let outcome = atlas.narrow(now_s, landmark, q_intersection(&boxes, n_wrong).components());
                if outcome != Outcome::Feasible {
                    return outcome;
                }
            }
        }
        Outcome::Feasible
    }

    /// The frame before one, and that one.
    fn neighbours(&mut self, idx: usize) -> Option<(&mut KeyFrame, &mut KeyFrame)> {
        let (before, from) = self.frames.split_at_mut(idx);
        Some((before.last_mut()?, from.first_mut()?))
    }

    /// Drops key frames taken later than `since_s`, together with the whole sequence of key frames that the first of them belongs to. The pose boxes
    /// of all frames that stay are reset to what they were when each frame was taken.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        let cut = self.frames.iter().find(|frame| frame.stamp_s > since_s).map(|frame| frame.run);
        self.frames.retain(|frame| frame.stamp_s <= since_s && cut.is_none_or(|run| frame.run < run));
        self.interrupt();
        self.frames.iter_mut().for_each(|frame| frame.pose = frame.taken);
        self.way = None;
        self.latest_s = self.latest_s.min(since_s);
    }

    /// What is kept stays for good.
    pub(super) fn settle(&mut self) {
        self.interrupt();
        for frame in &mut self.frames {
            frame.stamp_s = f64::NEG_INFINITY;
            frame.taken = frame.pose;
        }
        self.way = None;
        self.latest_s = f64::NEG_INFINITY;
    }
}

/// Along the way, or against it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Forth,
    Back,
}

/// What contradicts says that an assumption failed, perhaps long ago.
const CAUSE: &str = "no pose of a key frame fits the landmarks and the way";

impl KeyFrame {
    fn narrow(&mut self, pose: &PoseBox) -> Outcome {
        self.pose = self.pose.intersect(pose);
        if self.pose.is_empty() { Outcome::Empty(CAUSE) } else { Outcome::Feasible }
    }

    /// The pose by the landmarks.
    fn look(&mut self, atlas: &Atlas, freedom: Freedom, q_items: usize) -> Outcome {
        let bounded = self.seen.iter().filter(|seen| seen.is_bounded());
        let pairs: Vec<_> = bounded.filter_map(|seen| Some((atlas.place(seen.landmark)?, seen.in_robot_m))).collect();
        let mut pose = self.pose;
        PoseFromLandmarks::new(pairs, q_items, freedom, Solver::OneShot).contract(&mut pose);
        self.narrow(&pose)
    }
}

/// Poses of `domain` from which `motion` leads into `reached`: θ = θ′ − turn, t = t′ − R(θ)·(f, l).
fn came_from(reached: &PoseBox, motion: &Motion, domain: &PoseBox) -> PoseBox {
    let heading = domain[2].intersect(reached[2] - motion[2]);
    let (cos, sin) = (heading.cos(), heading.sin());
    let way = [cos * motion[0] - sin * motion[1], sin * motion[0] + cos * motion[1]];
    IntervalBox::from([reached[0] - way[0], reached[1] - way[1], heading])
}
