//! Bounds by the graph of key frames: how the work on its linear programs is spread over the steps, and how their bounds come back to the stored poses
//! and to the landmarks that methods learn.
//!
//! At each wheel reading the solver takes a few steps on the programs for the least and the greatest x, y and heading of the latest key frame and for
//! the heading of an older one, and then for the place of a landmark, all of which take turns. So the bounds apply from a number of wheel readings after
//! the key frame on that does not depend on the computer's speed.

use interval::Interval;

use crate::{
    PoseUnion, RobotModel,
    graph::{Hull, KeyFrames, Related, Variable, WidthParts},
    reading::LandmarkId,
};

use super::{Localizer, branches::Branches, naming::Intersected, ring::Slot};

/// Number of wheel readings that are awaited after a key frame before its program is made, so that what wheels and gyroscope read at its stamp has
/// arrived.
const AWAITED: usize = 10;
/// Number of key frames after which the heading of an older one is bounded once more, with all that was read since: what is not linear in the rows
/// about it grows with the heading's interval.
const SMOOTHED: usize = 15;
/// One key frame in so many has its heading bounded once more.
const SMOOTHED_EVERY: usize = 2;
/// Greatest number of coordinates of landmarks that are bounded with a key frame's program: those of two landmarks in the plane, or of one in space.
/// What dropped key frames knew of a landmark is kept by its box alone: with one landmark in place of two, and key frames 0.4 s apart, the boxes of paper
/// 3's loop were 62.6 mm wide over 195 s in place of 52.6 mm.
const COORDINATES: usize = 4;

/// What makes the widths of the pose's bounds at a key frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseWidth {
    /// Stamp of the key frame.
    pub stamp_s: f64,
    /// Along world x.
    pub x_m: WidthParts,
    /// Along world y.
    pub y_m: WidthParts,
    /// In heading.
    pub heading_rad: WidthParts,
}

/// The key frames, and the work on the program of the latest one.
pub(super) struct Graph {
    pub(super) frames: KeyFrames,
    work: Option<Work>,
    /// The landmark that was bounded last.
    bounded_last: Option<LandmarkId>,
    /// What makes the width of the latest key frame whose bounds are known.
    width: Option<PoseWidth>,
}

/// Work on the linear programs of the latest key frame: each stage is entered at a wheel reading of its own, so that no reading takes long.
enum Work {
    /// Readings of the key frame's instant are awaited: the number of wheel readings since the key frame was taken in.
    Awaiting(usize),
    /// The program of the pose's next branch is to be made.
    Next(Branches),
    /// The program of a branch is made, and not prepared for its solver yet.
    Made(Box<Related>, Branches),
    /// Poses are being bounded: the bounds so far.
    Poses(Box<Hull>, Branches),
    /// Landmarks are being bounded: the bounds so far.
    Landmarks(Box<Hull>),
}

impl Graph {
    pub(super) fn new(robot: &RobotModel) -> Graph {
        Graph { frames: KeyFrames::new(robot), work: None, bounded_last: None, width: None }
    }

    /// Forgets all key frames.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
        (self.work, self.bounded_last, self.width) = (None, None, None);
    }

    /// Forgets the key frames after a stamp, since which an assumption may have been false. No way leads from those before it to later ones, but landmarks
    /// and the robot's constants still relate them.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        self.frames.forget_since(since_s);
        self.work = None;
    }

    /// Has the latest key frame's pose bounded once its readings have arrived, after the work on poses if their programs are being solved.
    pub(super) fn await_readings(&mut self) {
        if !matches!(self.work, Some(Work::Poses(..) | Work::Next(_))) {
            self.work = Some(Work::Awaiting(0));
        }
    }

    /// Has the latest pose bounded anew unless that is under way.
    pub(super) fn begin_work(&mut self) {
        if matches!(self.work, None | Some(Work::Landmarks(_))) {
            self.work = Some(Work::Awaiting(0));
        }
    }

    /// Number of the older key frame whose heading is bounded once more with the latest key frame's pose, if there is one.
    fn older_number(&self) -> Option<usize> {
        self.frames.number_before_latest(SMOOTHED).filter(|number| number.is_multiple_of(SMOOTHED_EVERY))
    }

    /// The poses whose bounds are wanted: the latest key frame's, and the heading of an older one.
    fn wanted_poses(&self) -> Vec<Variable> {
        let number = self.frames.latest_number();
        let older = self.older_number();
        let pose = (0..3).map(|axis| Variable::Pose(number, axis));
        pose.chain(older.map(|number| Variable::Pose(number, 2))).collect()
    }

    /// The coordinates of the landmarks of a program whose turn it is to be bounded.
    fn wanted_landmarks(&mut self, related: &Related) -> Vec<Variable> {
        let landmark = |variable: &Variable| match variable {
            Variable::Landmark(landmark, _) | Variable::Point(landmark, _) => Some(*landmark),
            _ => None,
        };
        let mut all: Vec<LandmarkId> = related.variables.iter().filter_map(landmark).collect();
        all.sort_unstable();
        all.dedup();
        // The next ones after the landmark that was bounded last, from the first one on again.
        let first = all.partition_point(|one| self.bounded_last.is_some_and(|last| *one <= last));
        all.rotate_left(first);
        let mut wanted: Vec<Variable> = Vec::new();
        for one in all {
            let of_it: Vec<Variable> =
                related.variables.iter().filter(|variable| landmark(variable) == Some(one)).copied().collect();
            if wanted.len() + of_it.len() > COORDINATES {
                break;
            }
            wanted.extend(of_it);
            self.bounded_last = Some(one);
        }
        wanted
    }
}

impl Localizer {
    /// What makes the width of the pose's bounds by the graph of key frames: for each declared bound, its part of the width at the latest key frame
    /// whose bounds are known. `None` before the first one.
    pub fn width_by_bound(&self) -> Option<&PoseWidth> {
        self.graph.width.as_ref()
    }

    /// Goes on with the work on the latest key frame's programs: a fixed part of it at each wheel reading.
    pub(super) fn work_on_graph(&mut self) {
        let Some(work) = self.graph.work.take() else { return };
        self.graph.work = match work {
            Work::Awaiting(n_readings) if n_readings + 1 < AWAITED => Some(Work::Awaiting(n_readings + 1)),
            Work::Awaiting(_) => made_next(self.branches()),
            Work::Next(branches) => made_next(branches),
            Work::Made(related, branches) => Some(Work::Poses(Box::new(branches.hull(*related)), branches)),
            Work::Poses(mut hull, mut branches) => match hull.advance() {
                false => Some(Work::Poses(hull, branches)),
                true if branches.take(*hull) => self.go_on_after(branches),
                true => Some(Work::Next(branches)),
            },
            Work::Landmarks(mut hull) => {
                if hull.advance() {
                    self.narrow_landmarks(&hull);
                    None
                } else {
                    Some(Work::Landmarks(hull))
                }
            }
        };
    }

    /// The branches of the latest key frame's pose, of each of which a program is made of what has been read and learnt by now.
    pub(super) fn branches(&mut self) -> Branches {
        self.learn_ways();
        self.graph.frames.know_gyro(self.fixes.as_ref().and_then(|fixes| fixes.corners()).unwrap_or_default());
        let wanted = self.graph.wanted_poses();
        let frames = self.graph.frames.latest().into_owned();
        let slot = frames.latest_s().and_then(|stamp_s| self.ring.at(stamp_s));
        let union = slot.map_or_else(PoseUnion::default, Slot::merged);
        Branches::new(frames, (self.now_s, self.landmarks()), wanted, &union)
    }

    /// Applies the bounds by the programs of all branches. Returns what is to be done then.
    fn go_on_after(&mut self, branches: Branches) -> Option<Work> {
        if branches.poses().is_empty() {
            self.note_contradiction(Intersected::Known, branches.into_whole());
            self.begin_doubt(None);
            return None;
        }
        // A key frame that was made meanwhile has its turn.
        let next = self.graph.frames.unlinked().map(|_| Work::Awaiting(0));
        if !self.apply(&branches) {
            return None;
        }
        next.or_else(|| self.go_on_with_landmarks(branches.into_only()?))
    }

    /// The work on the landmarks whose turn it is, by the program by which poses were bounded.
    fn go_on_with_landmarks(&mut self, hull: Hull) -> Option<Work> {
        if !self.memories().any(|memory| memory.learns_landmarks()) {
            return None;
        }
        let wanted = self.graph.wanted_landmarks(hull.related());
        (!wanted.is_empty()).then(|| Work::Landmarks(Box::new(hull.go_on_with(wanted))))
    }

    /// Brings the bounds of landmarks back to the methods that learn them.
    fn narrow_landmarks(&mut self, hull: &Hull) {
        let bounds: Vec<(Variable, Interval)> = hull.wanted().zip(hull.bounds().unwrap_or_default()).collect();
        self.memories().filter(|memory| memory.learns_landmarks()).for_each(|memory| memory.narrow(&bounds));
    }

    /// Brings the bounds of poses back to the stored pose of their key frame. Returns whether they agree with what is known.
    fn apply(&mut self, branches: &Branches) -> bool {
        // Another key frame may have taken the place of the one that was bounded.
        let Some(stamp_s) = branches.number().and_then(|number| self.graph.frames.stamp_s(number)) else { return true };
        if let Some([x_m, y_m, heading_rad]) = branches.only().and_then(Hull::pose_width) {
            self.graph.width = Some(PoseWidth { stamp_s, x_m, y_m, heading_rad });
        }
        self.graph.frames.narrow(&branches.bounds(), branches.known_s());
        let Some(slot) = self.ring.iter_mut().find(|slot| slot.stamp_s == stamp_s) else { return true };
        slot.related = Some(branches.poses());
        if self.replay_all(stamp_s) {
            return false;
        }
        self.restart_integral();
        self.predict();
        !self.is_doubted()
    }
}

/// The work on the program of the next branch of which one can be made.
fn made_next(mut branches: Branches) -> Option<Work> {
    branches.next_program().map(|related| Work::Made(Box::new(related), branches))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
