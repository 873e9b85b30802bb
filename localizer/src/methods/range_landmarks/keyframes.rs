//! Raw sightings kept along the way, so that what is learnt late narrows what was seen early.
//!
//! Everything is contracted anew from raw readings: intersections may be repeated without counting anything twice. With wrong
//! matches readings are kept in runs of consecutive ones, as long as a window, because of m consecutive uses of a code at most one in
//! each window is wrong; of readings picked here and there nothing of the kind is known.

use std::collections::BTreeMap;

use crate::{
    Contractor, Interval, IntervalBox, PoseBox,
    contractor::q_intersection,
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
        KeyFrames { frames: Vec::new(), way: None, q_items, window, n_runs: 0, lacking: 0 }
    }

    /// Keeps a reading if it continues a run, or adds to the last one kept.
    pub(super) fn keep(&mut self, stamp_s: f64, pose: PoseBox, seen: Vec<Seen>, motion: MotionBetween) {
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
    /// way, and once back.
    pub(super) fn sweep(&mut self, now_s: f64, atlas: &mut Atlas, freedom: Freedom) {
        for idx in 0..self.frames.len() {
            if let Some((before, frame)) = self.neighbours(idx)
                && let Some(motion) = frame.motion
            {
                let reached = moved(&before.pose, &motion);
                frame.narrow(&reached);
            }
            self.frames[idx].look(atlas, freedom, self.q_items);
            self.teach_at_the_end_of_a_run(idx, idx + 1, now_s, atlas);
        }
        for idx in (0..self.frames.len()).rev() {
            self.frames[idx].look(atlas, freedom, self.q_items);
            self.teach_at_the_end_of_a_run(idx, idx.wrapping_sub(1), now_s, atlas);
            if let Some((before, frame)) = self.neighbours(idx)
                && let Some(motion) = frame.motion
            {
                let left = came_from(&frame.pose, &motion, &before.pose);
                before.narrow(&left);
            }
        }
    }

    /// Narrows the landmarks by a run when `idx` is its last frame on the way to frame `next`.
    fn teach_at_the_end_of_a_run(&self, idx: usize, next: usize, now_s: f64, atlas: &mut Atlas) {
        let run = self.frames[idx].run;
        let is_open = self.lacking > 0 && run == self.n_runs;
        if is_open || self.frames.get(next).is_some_and(|frame| frame.run == run) {
            return;
        }
        let mut uses: BTreeMap<LandmarkId, Vec<[Interval; 2]>> = BTreeMap::new();
        for frame in self.frames.iter().filter(|frame| frame.run == run) {
            for seen in &frame.seen {
                uses.entry(seen.landmark).or_default().push(seen.in_world(&frame.pose));
            }
        }
        for (landmark, places) in uses {
            if self.q_items == 0 {
                places.into_iter().for_each(|place| atlas.narrow(now_s, landmark, place));
                continue;
            }
            let n_wrong = places.len().div_ceil(self.window);
            if places.len() > n_wrong {
                let boxes: Vec<IntervalBox<2>> = places.into_iter().map(IntervalBox::new).collect();
                atlas.narrow(now_s, landmark, q_intersection(&boxes, n_wrong).components());
            }
        }
    }

    /// The frame before one, and that one.
    fn neighbours(&mut self, idx: usize) -> Option<(&mut KeyFrame, &mut KeyFrame)> {
        let (before, from) = self.frames.split_at_mut(idx);
        Some((before.last_mut()?, from.first_mut()?))
    }

    /// Drops frames taken later than `since_s`, and the run that they belong to; the others fall back to what was known when they
    /// were taken.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        let cut = self.frames.iter().find(|frame| frame.stamp_s > since_s).map(|frame| frame.run);
        self.frames.retain(|frame| frame.stamp_s <= since_s && cut.is_none_or(|run| frame.run < run));
        self.interrupt();
        self.frames.iter_mut().for_each(|frame| frame.pose = frame.taken);
        self.way = None;
    }

    /// What is kept stays for good.
    pub(super) fn settle(&mut self) {
        self.interrupt();
        for frame in &mut self.frames {
            frame.stamp_s = f64::NEG_INFINITY;
            frame.taken = frame.pose;
        }
        self.way = None;
    }
}

impl KeyFrame {
    /// An empty intersection says that something is doubtful, and the readings to come will tell what: nothing is narrowed then.
    fn narrow(&mut self, pose: &PoseBox) {
        let narrower = self.pose.intersect(pose);
        if !narrower.is_empty() {
            self.pose = narrower;
        }
    }

    /// The pose by the landmarks.
    fn look(&mut self, atlas: &Atlas, freedom: Freedom, q_items: usize) {
        let bounded = self.seen.iter().filter(|seen| seen.is_bounded());
        let pairs: Vec<_> = bounded.filter_map(|seen| Some((atlas.place(seen.landmark)?, seen.in_robot_m))).collect();
        let mut pose = self.pose;
        PoseFromLandmarks::new(pairs, q_items, freedom, Solver::OneShot).contract(&mut pose);
        self.narrow(&pose);
    }
}

/// Poses of `domain` from which `motion` leads into `reached`: θ = θ′ − turn, t = t′ − R(θ)·(f, l).
fn came_from(reached: &PoseBox, motion: &Motion, domain: &PoseBox) -> PoseBox {
    let heading = domain[2].intersect(reached[2] - motion[2]);
    let (cos, sin) = (heading.cos(), heading.sin());
    let way = [cos * motion[0] - sin * motion[1], sin * motion[0] + cos * motion[1]];
    IntervalBox::from([reached[0] - way[0], reached[1] - way[1], heading])
}
