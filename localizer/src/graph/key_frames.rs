//! Key frames of a drive, and the linear program that relates them.

mod program;

use std::{collections::VecDeque, sync::Arc};

use interval::Interval;

use crate::{
    PoseBox, RobotModel,
    motion::{FlowWay, Way},
    robot::{GyroModel, cayley_radius},
};

use super::{
    BoxLabel, Constant, Disc, Domain, Relations, Stray, Variable,
    link::{Link, Read},
};

/// Greatest number of key frames that are kept. With one every two seconds these are the last 200 seconds; older ones are farther apart.
const MOST: usize = 100;
/// Greatest time from a key frame to the next one, if there are readings: the latest key frame is replaced by the next until that would be exceeded.
const APART_S: f64 = 2.3;

/// Box of a landmark's world x and y.
pub type Place = [Interval; 2];

/// One stamp of the drive at which the pose is bounded.
#[derive(Clone)]
struct KeyFrame {
    number: usize,
    stamp_s: f64,
    /// Box of the pose: as it was known when the key frame was made, narrowed since by bounds of the linear program.
    pose: PoseBox,
    /// The reading that makes the pose's box, if it is of one.
    label: Option<BoxLabel>,
    /// The way from the key frame before; `None` for the first one, and where no reading of the motion is to be believed.
    link: Option<Link>,
    /// What a reading at this stamp relates, if there is one.
    relations: Option<Arc<dyn Relations>>,
    /// How far the robot can have gone between the reading's stamp and its true instant.
    stray: Stray,
    /// The greatest error of the flow sensor's place by its counts, and the stamps of the readings that the counts are of.
    place: Option<(f64, [f64; 2])>,
}

/// The key frames of a drive.
#[derive(Clone)]
pub struct KeyFrames {
    frames: VecDeque<KeyFrame>,
    constants: Domain,
    /// Pairs of constants that are together within a radius of (0, 0).
    discs: Vec<Disc>,
    gyro: Option<GyroModel>,
    flow_scale_change: f64,
    /// Corners (bias, scale) of a polygon that contains the gyroscope's bias over the whole run and its scale; none where only their intervals are
    /// known.
    gyro_errors: Vec<[f64; 2]>,
    next_number: usize,
}

impl KeyFrames {
    /// No key frames yet, for a robot with the given constants.
    pub fn new(robot: &RobotModel) -> KeyFrames {
        KeyFrames {
            frames: VecDeque::new(),
            constants: Domain::of_constants(robot),
            discs: discs_of_constants(robot),
            gyro: robot.gyro,
            flow_scale_change: robot.flow.map_or(0.0, |flow| flow.scale_change),
            gyro_errors: Vec::new(),
            next_number: 0,
        }
    }

    /// Stamp of the latest key frame.
    pub fn latest_s(&self) -> Option<f64> {
        self.frames.back().map(|latest| latest.stamp_s)
    }

    /// Number of the latest key frame; 0 before the first one.
    pub fn latest_number(&self) -> usize {
        self.frames.back().map_or(0, |latest| latest.number)
    }

    /// Stamps of the last but one and of the latest key frame.
    pub fn span_before_latest_s(&self) -> Option<[f64; 2]> {
        let before = self.frames.len().checked_sub(2)?;
        Some([self.frames[before].stamp_s, self.frames[before + 1].stamp_s])
    }

    /// Box of the headings at the last but one key frame.
    pub fn heading_before_latest(&self) -> Interval {
        self.frames.len().checked_sub(2).map_or(Interval::EMPTY, |before| self.frames[before].pose[2])
    }

    /// Adds a key frame with a later stamp than all others. It takes the place of the latest one where the key frame before that is near. `pose`
    /// encloses the pose at its stamp. The way to it is not known yet.
    pub fn push(&mut self, stamp_s: f64, pose: PoseBox, stray: Stray, relations: Option<Arc<dyn Relations>>) {
        if self.span_before_latest_s().is_some_and(|[before_s, _]| stamp_s - before_s <= APART_S) {
            self.frames.pop_back();
        }
        self.push_beside(stamp_s, pose, stray, relations);
        if self.frames.len() > MOST {
            self.drop_one();
        }
    }

    /// Adds a key frame with a later stamp than all others, however near to them.
    pub fn push_beside(&mut self, stamp_s: f64, pose: PoseBox, stray: Stray, relations: Option<Arc<dyn Relations>>) {
        let number = self.next_number;
        self.next_number += 1;
        let (label, link, place) = (None, None, None);
        self.frames.push_back(KeyFrame { number, stamp_s, pose, label, link, relations, stray, place });
    }

    /// Says which reading makes the box of the latest key frame's pose.
    pub fn label_latest(&mut self, label: Option<BoxLabel>) {
        if let Some(latest) = self.frames.back_mut() {
            latest.label = label;
        }
    }

    /// Sets what is known of the gyroscope's bias over the whole run and of its scale, by the corners of a polygon that contains both.
    pub fn know_gyro(&mut self, corners: Vec<[f64; 2]>) {
        self.gyro_errors = corners;
    }

    /// Whether a reading at the latest key frame relates its pose to other quantities.
    pub fn latest_relates(&self) -> bool {
        self.frames.back().is_some_and(|latest| latest.relations.is_some())
    }

    /// Greatest error of the stamp of the latest key frame's reading.
    pub fn latest_stamp_error_s(&self) -> f64 {
        self.frames.back().and_then(|latest| latest.relations.as_ref()).map_or(0.0, |latest| latest.stamp_error_s())
    }

    /// Sets the way from the last but one key frame to the latest one, and how far the robot can have gone within the error of the latter's stamp.
    pub fn set_latest(&mut self, way: Option<Way>, flow: Option<FlowWay>, stray: Stray) {
        let Some(mut latest) = self.frames.pop_back() else { return };
        latest.stray = stray;
        if let Some(before) = self.frames.back_mut().filter(|_| way.is_some() || flow.is_some()) {
            let place = flow.as_ref().map(|flow| [0, 1].map(|end| (flow.end_error_m[end], flow.end_readings_s[end])));
            let shares_error = place.is_some_and(|[first, _]| *before.place.get_or_insert(first) == first);
            latest.place = place.map(|[_, last]| last);
            let scale_change = self.flow_scale_change;
            latest.link = Some(Link::Read(Read { way, flow, shares_error, scale_change }));
        }
        if latest.link.is_none() && self.frames.iter().all(|frame| frame.relations.is_none()) {
            // Nothing relates the key frames before to this one.
            self.frames.clear();
        }
        self.frames.push_back(latest);
    }

    /// The gap between two key frames into which a late reading with the given stamp fits: at least `apart_s` from any other reading that relates
    /// something, and before the latest key frame.
    pub fn gap_for(&self, stamp_s: f64, apart_s: f64) -> Option<Gap> {
        let at = self.frames.iter().position(|frame| frame.stamp_s > stamp_s).filter(|&at| at > 0)?;
        let is_near = |frame: &KeyFrame| frame.relations.is_some() && (frame.stamp_s - stamp_s).abs() < apart_s;
        let [before, after] = [&self.frames[at - 1], &self.frames[at]];
        let is_free = !self.frames.iter().any(is_near) && before.stamp_s < stamp_s && after.link.is_some();
        is_free.then_some(Gap { at, span_s: [before.stamp_s, after.stamp_s], heading: before.pose[2] })
    }

    /// Adds a key frame for a late reading between two others, with the ways to it and on from it. Returns whether it was added: the ways have to
    /// tell the motion as fully as the way between the two others did.
    pub fn insert(&mut self, gap: &Gap, stamp_s: f64, late: LateFrame, ways: [Ways; 2]) -> bool {
        let [before, after] = [&self.frames[gap.at - 1], &self.frames[gap.at]];
        let place = |flow: &Option<FlowWay>| {
            flow.as_ref().map(|flow| [0, 1].map(|end| (flow.end_error_m[end], flow.end_readings_s[end])))
        };
        let [to, on] = [place(&ways[0].1), place(&ways[1].1)];
        let had = after.link.as_ref().map(Link::tells);
        let tells = |(way, flow): &Ways| [flow.is_some(), way.is_some()];
        let keeps_places = to.is_none_or(|[first, _]| before.place.is_none_or(|place| place == first))
            && on.map(|[_, last]| last) == after.place;
        if !keeps_places || had.is_none_or(|had| ways.iter().any(|ways| had != tells(ways))) {
            return false;
        }
        let number = self.next_number;
        self.next_number += 1;
        let scale_change = self.flow_scale_change;
        let LateFrame { pose, stray, relations } = late;
        let [first, second] = ways;
        let link =
            |(way, flow): Ways, shares_error: bool| Some(Link::Read(Read { way, flow, shares_error, scale_change }));
        if let (Some([first, _]), None) = (to, before.place) {
            self.frames[gap.at - 1].place = Some(first);
        }
        let shares_error = to.zip(on).is_some_and(|([_, last], [first, _])| last == first);
        self.frames[gap.at].link = link(second, shares_error);
        let place = to.map(|[_, last]| last);
        let relations = Some(relations);
        let frame =
            KeyFrame { number, stamp_s, pose, label: None, link: link(first, to.is_some()), relations, stray, place };
        self.frames.insert(gap.at, frame);
        if self.frames.len() > MOST {
            self.drop_one();
        }
        true
    }

    /// Narrows the pose of the latest key frame.
    pub fn narrow_latest(&mut self, pose: &PoseBox) {
        if let Some(latest) = self.frames.back_mut() {
            latest.pose = latest.pose.intersect(pose);
        }
    }

    /// Number of the key frame that is so many key frames older than the latest one.
    pub fn number_before_latest(&self, n_frames: usize) -> Option<usize> {
        Some(self.frames.get(self.frames.len().checked_sub(n_frames + 1)?)?.number)
    }

    /// Narrows the heading at the key frame with the given number.
    pub fn narrow_heading(&mut self, number: usize, heading: Interval) {
        if let Some(frame) = self.frames.iter_mut().find(|frame| frame.number == number) {
            frame.pose[2] = frame.pose[2].intersect(heading);
        }
    }

    /// Forgets all key frames, and what was known of the gyroscope.
    pub fn clear(&mut self) {
        self.frames.clear();
        self.gyro_errors.clear();
    }

    /// Drops the key frame whose neighbours are nearest in time, measured by their age, so that older key frames are farther apart than newer ones.
    /// The first one stays: where the drive began is often known best.
    fn drop_one(&mut self) {
        let Some(latest_s) = self.latest_s() else { return };
        let gap = |idx: usize| {
            let (before, after) = (&self.frames[idx - 1], &self.frames[idx + 1]);
            (after.stamp_s - before.stamp_s) / (latest_s - before.stamp_s)
        };
        let Some(at) = (1..self.frames.len() - 1).min_by(|&a, &b| gap(a).total_cmp(&gap(b))) else { return };
        let link = match (&self.frames[at].link, &self.frames[at + 1].link) {
            (Some(before), Some(after)) => {
                let numbers = [at - 1, at, at + 1].map(|at| self.frames[at].number);
                before.join(after, numbers, &self.domain(&[]))
            }
            _ => None,
        };
        self.frames[at + 1].link = link;
        self.frames.remove(at);
    }
}

/// The ways between two stamps: by the wheels with the gyroscope, and by the flow sensor with the gyroscope.
pub type Ways = (Option<Way>, Option<FlowWay>);

/// A place between two key frames.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// Index of the key frame after the gap.
    at: usize,
    /// Stamps of the key frames before and after it.
    pub span_s: [f64; 2],
    /// Headings at the key frame before it.
    pub heading: Interval,
}

/// A late reading as a key frame.
pub struct LateFrame {
    /// Box of the pose at the reading's stamp.
    pub pose: PoseBox,
    /// How far the robot can have gone within the error of the stamp.
    pub stray: Stray,
    /// What the reading relates.
    pub relations: Arc<dyn Relations>,
}

impl KeyFrame {
    /// How far the pose that a reading shows may be from the pose at its stamp.
    fn displaced(&self) -> Stray {
        let of_reading =
            |relations: &Arc<dyn Relations>| Stray { metres: relations.shift_m(&self.stray), ..self.stray };
        self.relations.as_ref().map_or(Stray::default(), of_reading)
    }
}

/// The tilts of the cameras' mounts, which are within discs.
fn discs_of_constants(robot: &RobotModel) -> Vec<Disc> {
    let pair = |of_axis: fn(usize) -> Constant| [0, 1].map(|axis| Variable::Constant(of_axis(axis)));
    let floor = robot.floor_camera.iter().map(|camera| (pair(Constant::FloorTilt), cayley_radius(camera.tilt_rad)));
    let ceiling =
        robot.ceiling_camera.iter().map(|camera| (pair(Constant::CeilingTilt), cayley_radius(camera.tilt_rad)));
    floor.chain(ceiling).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
