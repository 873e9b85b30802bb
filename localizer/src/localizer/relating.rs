//! The graph of key frames in the localizer: when a reading becomes a key frame, and the ways between key frames.

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseBox, PoseUnion,
    graph::{FrameReading, Relations, Stray, Unlinked, WIDEST_RAD, Ways},
    method::Method,
    reading::Shown,
};

use super::{Localizer, bounding::Graph, branches, moves::stray_about, ring::Slot};

/// Least time from a key frame to one without a reading or with one of the map, and between two key frames of a drive that is kept as a whole.
const PERIOD_S: f64 = 1.0;
/// Least time between two key frames with readings of the same source that relate more than the map.
const READ_PERIOD_S: f64 = 0.6;
/// Least time from a key frame with a reading that relates something to one without. Readings of the motion are remembered for 3 s, within which both
/// the next key frame and its readings have to arrive.
const LONGEST_S: f64 = 1.6;
/// Distance in metres and turn in radians after which a reading from which landmarks are learnt becomes a key frame, however soon: what is near the robot
/// passes by within a metre or two.
const FAR_M: f64 = 0.4;
const FAR_RAD: f64 = 0.2;
/// Least time between two stamps that are not the same.
const SLACK_S: f64 = 1e-6;

/// A reading that relates something, for the graph.
pub(super) struct Relating {
    /// The method that read it.
    pub(super) source: &'static str,
    pub(super) relations: Arc<dyn Relations>,
    /// What it showed.
    pub(super) shown: Option<Shown>,
}

impl Graph {
    /// Whether a stamp becomes a key frame. A reading that relates something waits for some time after the latest one of its source, unless no such
    /// reading stands at the latest key frame; a reading of the map, whose rows tell little more than its box of the pose, waits for as long after any
    /// other. A stamp without such a reading waits longer where one may follow soon.
    fn is_due(&self, stamp_s: f64, reading: Option<&FrameReading>, is_far: bool) -> bool {
        let Some(latest_s) = self.frames.latest_s() else { return true };
        let is_past = |from_s: f64, wait_s: f64| stamp_s >= from_s + wait_s - 0.5 * SLACK_S;
        match (reading, self.frames.latest_relates()) {
            (Some(reading), true) if reading.relations.is_of_the_map() => is_past(latest_s, PERIOD_S),
            (Some(reading), true) => {
                let period_s = if self.frames.keeps_all() { PERIOD_S } else { READ_PERIOD_S };
                let was_read_s = self.frames.latest_of_s(reading.source);
                is_past(latest_s, SLACK_S) && (is_far || was_read_s.is_none_or(|read_s| is_past(read_s, period_s)))
            }
            (Some(_), false) => is_past(latest_s, SLACK_S),
            (None, true) => is_past(latest_s, LONGEST_S),
            (None, false) => is_past(latest_s, PERIOD_S),
        }
    }
}

impl Localizer {
    /// Keeps a reading as a key frame if one is due, or at a key frame that there is at its stamp. `posterior` encloses the pose at its stamp.
    pub(super) fn relate(&mut self, stamp_s: f64, posterior: &PoseUnion, reading: Option<Relating>) {
        let reading = reading.filter(|reading| reading.relations.is_worth_a_key_frame());
        let pose = posterior.hull();
        let is_narrow = pose[2].width() <= WIDEST_RAD;
        // Programs about the branches of a pose that is the latest one do with narrow headings of the branches.
        let is_found_anew = reading.as_ref().is_none_or(|reading| reading.relations.is_found_anew());
        let is_in_branches =
            is_found_anew && !self.graph.frames.keeps_all() && branches::for_programs(posterior).is_some();
        let is_known = !pose.is_empty() && (is_narrow || is_in_branches);
        let is_believed = !self.is_doubted() && stamp_s >= self.doubts.ended_s;
        if !is_known || !is_believed {
            return;
        }
        let reading = reading.map(|Relating { source, relations, shown }| {
            let stray = Stray::by_reach(relations.stamp_error_s(), &self.robot.reach);
            FrameReading::new(source, relations, stray).showing(shown)
        });
        let is_far = reading.as_ref().is_some_and(|reading| self.is_far(reading.source, &pose));
        if self.graph.is_due(stamp_s, reading.as_ref(), is_far) {
            self.graph.frames.push(stamp_s, pose, reading);
            self.graph.frames.label_latest(self.ring.at(stamp_s).and_then(Slot::label));
            self.graph.await_readings();
        } else if let Some(reading) = reading.filter(|_| is_narrow)
            && !self.graph.frames.join(stamp_s, reading.clone())
        {
            self.relate_late(stamp_s, pose, reading);
        }
    }

    /// Whether a method that keeps the drive, in order to learn from it, reads from a place far from that of its latest key frame.
    fn is_far(&self, source: &str, pose: &PoseBox) -> bool {
        let keeps_drive = |method: &dyn Method| method.memory().is_some_and(|memory| memory.keeps_drive());
        let learns = self.methods.iter().any(|method| method.name() == source && keeps_drive(&**method));
        let Some(last) = self.graph.frames.latest_of(source).filter(|_| learns) else { return false };
        let [x_m, y_m, turned_rad] = [0, 1, 2].map(|axis| pose[axis].mid() - last[axis].mid());
        x_m.hypot(y_m) >= FAR_M || turned_rad.abs() >= FAR_RAD
    }

    /// Keeps a late reading as a key frame between two others where there is room for it. Then the latest pose is bounded anew with it.
    fn relate_late(&mut self, stamp_s: f64, pose: PoseBox, reading: FrameReading) {
        let least_s = PERIOD_S - 0.5 * SLACK_S;
        let Some(gap) = self.graph.frames.gap_for(stamp_s, reading.source, least_s) else { return };
        let [from_s, to_s] = gap.span_s;
        if from_s < self.doubts.ended_s {
            return;
        }
        let ways = [self.ways([from_s, stamp_s], gap.heading), self.ways([stamp_s, to_s], pose[2])];
        let stray = self.stray_at(stamp_s, reading.relations.stamp_error_s());
        let reading = FrameReading::new(reading.source, reading.relations, stray).showing(reading.shown);
        if self.graph.frames.insert(&gap, stamp_s, pose, reading, ways) {
            self.graph.begin_work();
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
        stray_about(&self.wheels, &self.robot, &self.slip, self.doubts.ended_s, [stamp_s, error_s])
    }

    /// Computes, from the readings that have arrived, the ways to the key frames that have none yet, and how far the robot can have gone within the
    /// errors of their readings' stamps.
    pub(super) fn learn_ways(&mut self) {
        while let Some(Unlinked { number, stamp_s, before, stamp_errors_s }) = self.graph.frames.unlinked() {
            let before = before.filter(|(before_s, _)| *before_s >= self.doubts.ended_s);
            let (way, flow) =
                before.map_or((None, None), |(before_s, heading)| self.ways([before_s, stamp_s], heading));
            let strays: Vec<Stray> =
                stamp_errors_s.into_iter().map(|error_s| self.stray_at(stamp_s, error_s)).collect();
            self.graph.frames.link(number, way, flow, &strays);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
