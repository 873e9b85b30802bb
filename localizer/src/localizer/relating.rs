//! The graph of key frames in the localizer: when a reading becomes a key frame, how the work on the linear program is spread over the steps, and how
//! the program's bounds come back to the stored poses.
//!
//! At each wheel reading the solver takes a few steps on the programs for the least and the greatest x, y and heading of the latest key frame and for
//! the heading of an older one. So the bounds apply from a number of wheel readings after the key frame on that does not depend on the computer's speed.

use std::sync::Arc;

use interval::{Interval, IntervalBox};

use crate::{
    PoseBox, PoseUnion, RobotModel,
    graph::{Hull, KeyFrames, LateFrame, Related, Relations, Stray, Variable, Ways, WidthParts},
};

use super::{Localizer, naming::Intersected, ring::Slot};

/// Least time between two key frames.
const PERIOD_S: f64 = 1.0;
/// Least time from a key frame with a reading that relates something to one without. Readings of the motion are remembered for 3 s, within which both
/// the next key frame and its readings have to arrive.
const LONGEST_S: f64 = 1.6;
/// Least time between two stamps that are not the same.
const SLACK_S: f64 = 1e-6;
/// Widest heading of a key frame: what is not linear in the rows grows with the square of it.
const WIDEST_RAD: f64 = 0.3;
/// Number of wheel readings that are awaited after a key frame before its program is made, so that what wheels and gyroscope read at its stamp has
/// arrived.
const AWAITED: usize = 10;
/// Number of key frames after which the heading of an older one is bounded once more, with all that was read since: what is not linear in the rows
/// about it grows with the heading's interval.
const SMOOTHED: usize = 15;
/// One key frame in so many has its heading bounded once more.
const SMOOTHED_EVERY: usize = 2;

/// The key frames, and the work on the program of the latest one.
pub(super) struct Graph {
    frames: KeyFrames,
    work: Option<Work>,
    /// What makes the width of the latest key frame whose bounds are known.
    width: Option<PoseWidth>,
}

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

/// Work on the linear program of the latest key frame: each stage is entered at a wheel reading of its own, so that no reading takes long.
enum Work {
    /// Readings of the key frame's instant are awaited: the number of wheel readings since the key frame was taken in.
    Awaiting(usize),
    /// The program is made, and not prepared for its solver yet.
    Made(Box<Related>),
    /// The program is being solved: the bounds so far.
    Solving(Box<Hull>),
}

impl Graph {
    pub(super) fn new(robot: &RobotModel) -> Graph {
        Graph { frames: KeyFrames::new(robot), work: None, width: None }
    }

    /// Forgets all key frames: an assumption failed, and it is not known since when what they tell is false.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
        self.work = None;
    }

    /// Whether a stamp becomes a key frame: after some time, which is longer where a reading that relates something may follow soon, and none at all
    /// where such a reading follows a key frame without one.
    fn is_due(&self, stamp_s: f64, relates: bool) -> bool {
        let wait_s = match (relates, self.frames.latest_relates()) {
            (true, false) => SLACK_S,
            (false, true) => LONGEST_S,
            _ => PERIOD_S,
        };
        self.frames.latest_s().is_none_or(|latest_s| stamp_s >= latest_s + wait_s - 0.5 * SLACK_S)
    }

    /// Number of the older key frame whose heading is bounded once more with the latest key frame's pose, if there is one.
    fn older_number(&self) -> Option<usize> {
        self.frames.number_before_latest(SMOOTHED).filter(|number| number.is_multiple_of(SMOOTHED_EVERY))
    }

    /// The quantities whose bounds are wanted: the latest key frame's pose, and the heading of an older one.
    fn wanted(&self) -> Vec<Variable> {
        let number = self.frames.latest_number();
        let older = self.older_number();
        let pose = (0..3).map(|axis| Variable::Pose(number, axis));
        pose.chain(older.map(|number| Variable::Pose(number, 2))).collect()
    }
}

impl Localizer {
    /// What makes the width of the pose's bounds by the graph of key frames: for each declared bound, its part of the width at the latest key frame
    /// whose bounds are known. `None` before the first one.
    pub fn width_by_bound(&self) -> Option<&PoseWidth> {
        self.graph.width.as_ref()
    }

    /// Keeps a reading as a key frame if one is due. `posterior` encloses the pose at its stamp.
    pub(super) fn relate(&mut self, stamp_s: f64, posterior: &PoseUnion, relations: Option<Arc<dyn Relations>>) {
        let relations = relations.filter(|relations| relations.is_worth_a_key_frame());
        let pose = posterior.hull();
        let is_known = !pose.is_empty() && pose[2].width() <= WIDEST_RAD;
        let is_believed = !self.is_doubted() && stamp_s >= self.doubts.ended_s;
        if !is_known || !is_believed {
            return;
        }
        if !self.graph.is_due(stamp_s, relations.is_some()) {
            if let Some(relations) = relations {
                self.relate_late(stamp_s, pose, relations);
            }
            return;
        }
        let stamp_error_s = relations.as_ref().map_or(0.0, |relations| relations.stamp_error_s());
        let stray = Stray::by_reach(stamp_error_s, &self.robot.reach);
        self.graph.frames.push(stamp_s, pose, stray, relations);
        self.graph.frames.label_latest(self.ring.at(stamp_s).and_then(Slot::label));
        self.graph.work = Some(Work::Awaiting(0));
    }

    /// Keeps a late reading as a key frame between two others where there is room for it. Then the latest pose is bounded anew with it.
    fn relate_late(&mut self, stamp_s: f64, pose: PoseBox, relations: Arc<dyn Relations>) {
        let Some(gap) = self.graph.frames.gap_for(stamp_s, PERIOD_S - 0.5 * SLACK_S) else { return };
        let [from_s, to_s] = gap.span_s;
        if from_s < self.doubts.ended_s {
            return;
        }
        let ways = [self.ways([from_s, stamp_s], gap.heading), self.ways([stamp_s, to_s], pose[2])];
        let stray = self.stray_at(stamp_s, relations.stamp_error_s());
        let late = LateFrame { pose, stray, relations };
        if self.graph.frames.insert(&gap, stamp_s, late, ways) {
            self.graph.work.get_or_insert(Work::Awaiting(0));
        }
    }

    /// The ways between two stamps by the readings that have arrived; `heading` encloses the heading at the first of them.
    fn ways(&self, [from_s, to_s]: [f64; 2], heading: Interval) -> Ways {
        let (wheels, reach) = (&self.robot.wheels, &self.robot.reach);
        let is_believed = !self.slip.covers([from_s, to_s]);
        let way = is_believed.then(|| self.wheels.way(from_s, to_s, wheels, reach)).flatten();
        (way, self.wheels.flow_way(from_s, to_s, heading, wheels, reach))
    }

    /// How far the robot can have gone within the error of a stamp.
    fn stray_at(&self, stamp_s: f64, error_s: f64) -> Stray {
        let mut stray = Stray::by_reach(error_s, &self.robot.reach);
        if let Some(turn_rad) = self.wheels.greatest_turn_about(stamp_s, error_s, &self.robot.wheels, &self.robot.reach)
        {
            stray.radians = stray.radians.min(turn_rad);
        }
        stray
    }

    /// Goes on with the work on the latest key frame's program: a fixed part of it at each wheel reading.
    pub(super) fn work_on_graph(&mut self) {
        let Some(work) = self.graph.work.take() else { return };
        self.graph.work = match work {
            Work::Awaiting(n_readings) if n_readings + 1 < AWAITED => Some(Work::Awaiting(n_readings + 1)),
            Work::Awaiting(_) => self.related().map(Box::new).map(Work::Made),
            Work::Made(related) => Some(Work::Solving(Box::new(Hull::new(*related, self.graph.wanted())))),
            Work::Solving(mut hull) => {
                if hull.advance() {
                    self.apply(*hull);
                    return;
                }
                Some(Work::Solving(hull))
            }
        };
    }

    /// The program of all key frames, with what has been read and learnt by now; `None` where a quantity of it is not bounded.
    fn related(&mut self) -> Option<Related> {
        self.learn_way();
        self.graph.frames.know_gyro(self.fixes.as_ref().and_then(|fixes| fixes.corners()).unwrap_or_default());
        let known = self.landmarks();
        self.graph.frames.related(&known).ok()
    }

    /// Computes, from the readings that have arrived, the way to the latest key frame, and how far the robot can have gone within the error of its
    /// stamp.
    fn learn_way(&mut self) {
        let Some(stamp_s) = self.graph.frames.latest_s() else { return };
        let span_s = self.graph.frames.span_before_latest_s().filter(|span_s| span_s[0] >= self.doubts.ended_s);
        let heading = self.graph.frames.heading_before_latest();
        let (way, flow) = span_s.map_or((None, None), |span_s| self.ways(span_s, heading));
        let stray = self.stray_at(stamp_s, self.graph.frames.latest_stamp_error_s());
        self.graph.frames.set_latest(way, flow, stray);
    }

    /// Brings the bounds of a program back to the stored pose of its key frame.
    fn apply(&mut self, hull: Hull) {
        let Some(stamp_s) = self.graph.frames.latest_s() else { return };
        let bounds = hull.bounds().unwrap_or_default();
        let &[x, y, heading, ref older @ ..] = bounds.as_slice() else {
            self.note_contradiction(Intersected::Known, Some(hull.into_related()));
            self.begin_doubt(None);
            return;
        };
        let parts = hull.width_parts();
        if let [x_m, y_m, heading_rad, ..] = parts.as_slice() {
            let [x_m, y_m, heading_rad] = [x_m, y_m, heading_rad].map(WidthParts::clone);
            self.graph.width = Some(PoseWidth { stamp_s, x_m, y_m, heading_rad });
        }
        // Late readings may have become key frames since the program was made, so that the older one is no longer as many key frames old.
        if let (Some(Variable::Pose(number, _)), &[heading]) = (hull.wanted().nth(3), older) {
            self.graph.frames.narrow_heading(number, heading);
        }
        let pose = IntervalBox::from([x, y, heading]);
        self.graph.frames.narrow_latest(&pose);
        let Some(slot) = self.ring.iter_mut().find(|slot| slot.stamp_s == stamp_s) else { return };
        slot.related = Some(pose);
        if !self.replay_all(stamp_s) {
            self.restart_integral();
            self.predict();
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
