//! Raw sightings kept along the way, so that what is learnt late narrows what was seen early.

use crate::{
    Contractor, IntervalBox, PoseBox,
    method::MotionBetween,
    motion::{Motion, moved},
};

use super::{Freedom, PoseFromLandmarks, Seen, Solver, atlas::Atlas};

/// A reading is kept when the robot has since moved or turned by this much: nearer ones see the same.
const APART_M: f64 = 0.15;
/// See `APART_M`.
const APART_RAD: f64 = 0.15;

/// When so many are kept, every second one goes.
const MOST: usize = 200;

/// Readings kept.
#[derive(Clone, Debug, Default)]
pub(super) struct KeyFrames {
    frames: Vec<KeyFrame>,
    /// Motion since the last frame, up to a stamp; none when the wheels' memory does not reach.
    way: Option<(f64, Motion)>,
}

#[derive(Clone, Debug)]
struct KeyFrame {
    stamp_s: f64,
    /// Pose box when it was taken, from what was known then.
    taken: PoseBox,
    /// The same, narrowed by what was learnt since.
    pose: PoseBox,
    /// Motion from the frame before.
    motion: Option<Motion>,
    seen: Vec<Seen>,
}

impl KeyFrames {
    /// Keeps a reading if it adds to the last one kept.
    pub(super) fn keep(&mut self, stamp_s: f64, pose: PoseBox, seen: Vec<Seen>, motion: MotionBetween) {
        self.way = self.way.and_then(|(since_s, way)| Some((stamp_s, moved(&way, &motion(since_s, stamp_s)?))));
        let is_apart = self.frames.last().is_none_or(|last| {
            let ([x, y, heading], [last_x, last_y, last_heading]) = (pose.midpoint(), last.taken.midpoint());
            (x - last_x).hypot(y - last_y) > APART_M || (heading - last_heading).abs() > APART_RAD
        });
        if !is_apart {
            return;
        }
        let motion = self.way.map(|(_, way)| way).filter(|_| !self.frames.is_empty());
        self.frames.push(KeyFrame { stamp_s, taken: pose, pose, motion, seen });
        self.way = Some((stamp_s, IntervalBox::point(&[0.0; 3])));
        if self.frames.len() > MOST {
            self.thin();
        }
    }

    /// Drops every second frame and joins the motions across it.
    fn thin(&mut self) {
        let mut across = None;
        let mut kept: Vec<KeyFrame> = Vec::with_capacity(self.frames.len() / 2 + 1);
        for (idx, mut frame) in self.frames.drain(..).enumerate() {
            if idx % 2 == 1 {
                across = frame.motion;
                continue;
            }
            if idx > 0 {
                frame.motion = across.zip(frame.motion).map(|(first, then)| moved(&first, &then));
            }
            kept.push(frame);
        }
        // The way since the last frame began at one that may be gone.
        if kept.last().map(|frame| frame.stamp_s) != self.way.map(|(since_s, _)| since_s) {
            self.way = None;
        }
        self.frames = kept;
    }

    /// Contracts the pose of every key frame by the landmarks and by its neighbours, and the landmarks by the pose: once along the
    /// way, and once back.
    pub(super) fn sweep(&mut self, now_s: f64, atlas: &mut Atlas, freedom: Freedom) {
        for idx in 0..self.frames.len() {
            if let Some((before, frame)) = self.neighbours(idx)
                && let Some(motion) = frame.motion
            {
                let reached = moved(&before.pose, &motion);
                frame.narrow(&reached);
            }
            self.frames[idx].look(now_s, atlas, freedom);
        }
        for idx in (0..self.frames.len()).rev() {
            self.frames[idx].look(now_s, atlas, freedom);
            if let Some((before, frame)) = self.neighbours(idx)
                && let Some(motion) = frame.motion
            {
                let left = came_from(&frame.pose, &motion, &before.pose);
                before.narrow(&left);
            }
        }
    }

    /// The frame before one, and that one.
    fn neighbours(&mut self, idx: usize) -> Option<(&mut KeyFrame, &mut KeyFrame)> {
        let (before, from) = self.frames.split_at_mut(idx);
        Some((before.last_mut()?, from.first_mut()?))
    }

    /// Drops frames taken later than `since_s`; the others fall back to what was known when they were taken.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        self.frames.retain(|frame| frame.stamp_s <= since_s);
        self.frames.iter_mut().for_each(|frame| frame.pose = frame.taken);
        self.way = None;
    }

    /// What is kept stays for good.
    pub(super) fn settle(&mut self) {
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

    /// The pose by the landmarks, and the landmarks by the pose.
    fn look(&mut self, now_s: f64, atlas: &mut Atlas, freedom: Freedom) {
        let pairs: Vec<_> =
            self.seen.iter().filter_map(|seen| Some((atlas.place(seen.landmark)?, seen.in_robot_m))).collect();
        let mut pose = self.pose;
        PoseFromLandmarks::new(pairs, 0, freedom, Solver::OneShot).contract(&mut pose);
        self.narrow(&pose);
        for seen in &self.seen {
            atlas.narrow(now_s, seen.landmark, seen.in_world(&self.pose));
        }
    }
}

/// Poses of `domain` from which `motion` leads into `reached`: θ = θ′ − turn, t = t′ − R(θ)·(f, l).
fn came_from(reached: &PoseBox, motion: &Motion, domain: &PoseBox) -> PoseBox {
    let heading = domain[2].intersect(reached[2] - motion[2]);
    let (cos, sin) = (heading.cos(), heading.sin());
    let way = [cos * motion[0] - sin * motion[1], sin * motion[0] + cos * motion[1]];
    IntervalBox::from([reached[0] - way[0], reached[1] - way[1], heading])
}
