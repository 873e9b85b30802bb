//! Key frames of a drive, and the linear program that relates them.

mod frame;
mod late;
mod program;

use std::{borrow::Cow, collections::VecDeque};

use interval::Interval;

use crate::{
    PoseBox, RobotModel,
    motion::{FlowWay, Way},
    robot::{GyroModel, cayley_radius},
};

use super::{
    BoxLabel, Constant, Disc, Domain, Stray, Variable,
    link::{Link, Read},
};

pub use frame::FrameReading;
use frame::KeyFrame;

/// Greatest number of key frames that are kept, where one whose readings relate more than the map counts as two: with one every two seconds on the map
/// those of 200 seconds, with one every 0.6 s among landmarks those of 30 seconds. In longer drives the older ones are farther apart.
const MOST: usize = 100;
/// Greatest time from a key frame to the next one, if there are readings: the latest key frame is replaced by the next until that would be exceeded.
const APART_S: f64 = 0.7;
/// The same for a key frame that has no reading, or whose readings show nothing but the map: their rows tell little more than the box of the pose.
const APART_ON_MAP_S: f64 = 2.3;

/// Widest heading of a pose in a linear program: what is not linear in the rows grows with the square of it.
pub const WIDEST_RAD: f64 = 0.3;

/// Box of a landmark's world x and y.
pub type Place = [Interval; 2];

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
    /// Whether the key frames of the whole drive are kept, and not only so many.
    keeps_all: bool,
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
            keeps_all: false,
        }
    }

    /// Keeps all key frames of the drive from now on, so that memory grows with its length.
    pub fn keep_all(&mut self) {
        self.keeps_all = true;
    }

    /// Whether all key frames of the drive are kept.
    pub fn keeps_all(&self) -> bool {
        self.keeps_all
    }

    /// Number of key frames.
    pub fn n_frames(&self) -> usize {
        self.frames.len()
    }

    /// Stamps of all key frames, from the first one on, with boxes of the poses.
    pub fn poses(&self) -> impl Iterator<Item = (f64, PoseBox)> {
        self.frames.iter().map(|frame| (frame.stamp_s, frame.pose))
    }

    /// Numbers and stamps of all key frames.
    pub fn stamps(&self) -> impl Iterator<Item = (usize, f64)> {
        self.frames.iter().map(|frame| (frame.number, frame.stamp_s))
    }

    /// So many key frames, from that with the given place among all on, without what came before.
    pub fn window(&self, first: usize, n_frames: usize) -> KeyFrames {
        let mut frames: VecDeque<KeyFrame> = self.frames.iter().skip(first).take(n_frames).cloned().collect();
        if let Some(first) = frames.front_mut() {
            first.link = None;
        }
        let (constants, discs, gyro_errors) = (self.constants.clone(), self.discs.clone(), self.gyro_errors.clone());
        KeyFrames { frames, constants, discs, gyro_errors, ..*self }
    }

    /// The latest key frames, of which programs are made while the robot drives.
    pub fn latest(&self) -> Cow<'_, KeyFrames> {
        match self.frames.len().checked_sub(MOST) {
            None | Some(0) => Cow::Borrowed(self),
            Some(n_older) => Cow::Owned(self.window(n_older, MOST)),
        }
    }

    /// All readings at key frames, with their stamps.
    pub fn readings_mut(&mut self) -> impl Iterator<Item = (f64, &mut FrameReading)> {
        self.frames.iter_mut().flat_map(|frame| {
            let stamp_s = frame.stamp_s;
            frame.readings.iter_mut().map(move |reading| (stamp_s, reading))
        })
    }

    /// Narrows the poses among the quantities of which bounds are given, which follow from all key frames and from what was known at `known_s`.
    pub fn narrow(&mut self, bounds: &[(Variable, Interval)], known_s: f64) {
        for &(variable, bound) in bounds {
            if let Variable::Pose(number, axis) = variable
                && let Some(frame) = self.frames.iter_mut().find(|frame| frame.number == number)
            {
                frame.narrow(axis, bound, known_s);
            }
        }
    }

    /// Forgets the key frames after a stamp, and what followed from them for the poses of those before, and the ways that were made with the boxes of
    /// these poses.
    pub fn forget_since(&mut self, since_s: f64) {
        self.frames.retain(|frame| frame.stamp_s <= since_s);
        self.frames.iter_mut().for_each(|frame| frame.take_back_since(since_s));
    }

    /// Stamp of the latest key frame.
    pub fn latest_s(&self) -> Option<f64> {
        self.frames.back().map(|latest| latest.stamp_s)
    }

    /// Time by which all was known that the boxes of the poses follow from.
    fn known_s(&self) -> Option<f64> {
        let narrowed_s = self.frames.iter().filter_map(|frame| frame.wider.last()).map(|(known_s, _)| *known_s);
        self.latest_s().map(|latest_s| narrowed_s.fold(latest_s, f64::max))
    }

    /// Box of the pose at the latest key frame.
    pub fn latest_pose(&self) -> Option<PoseBox> {
        self.frames.back().map(|latest| latest.pose)
    }

    /// Whether the rows of the latest key frame can be made about several boxes that its pose may be in.
    pub fn is_found_anew(&self) -> bool {
        self.frames.back().is_some_and(|latest| latest.readings.iter().all(|one| one.relations.is_found_anew()))
    }

    /// The key frames if the pose at the latest one is within a box.
    pub fn within(&self, pose: &PoseBox) -> KeyFrames {
        let mut frames = self.clone();
        if let Some(latest) = frames.frames.back_mut() {
            latest.pose = latest.pose.intersect(pose);
        }
        frames
    }

    /// Number of the latest key frame; 0 before the first one.
    pub fn latest_number(&self) -> usize {
        self.frames.back().map_or(0, |latest| latest.number)
    }

    /// Stamps of the last but one and of the latest key frame.
    fn span_before_latest_s(&self) -> Option<[f64; 2]> {
        let before = self.frames.len().checked_sub(2)?;
        Some([self.frames[before].stamp_s, self.frames[before + 1].stamp_s])
    }

    /// Adds a key frame with a later stamp than all others. `pose` encloses the pose at its stamp. The way to it is not known yet. It takes the place of
    /// the latest one where the key frame before that is near, and where one of these two has a reading of each source that the latest one has. It also
    /// does where the heading of the latest one is still too wide for the rows of a program.
    pub fn push(&mut self, stamp_s: f64, pose: PoseBox, reading: Option<FrameReading>) {
        if self.latest_pose().is_some_and(|latest| latest[2].width() > WIDEST_RAD) {
            self.frames.pop_back();
        }
        let relates_more = self.frames.back().is_some_and(KeyFrame::relates_more_than_the_map);
        let apart_s = if relates_more { APART_S } else { APART_ON_MAP_S };
        let is_near =
            !self.keeps_all && self.span_before_latest_s().is_some_and(|[before_s, _]| stamp_s - before_s <= apart_s);
        if let (true, Some(before), Some(latest)) = (is_near, self.frames.iter().nth_back(1), self.frames.back()) {
            let is_read = |source| before.has(source) || reading.as_ref().is_some_and(|new| new.source == source);
            if latest.readings.iter().all(|one| is_read(one.source)) {
                self.frames.pop_back();
            }
        }
        self.push_beside(stamp_s, pose, reading);
        while self.is_too_many() {
            self.drop_one();
        }
    }

    /// Whether there are more key frames than are kept.
    fn is_too_many(&self) -> bool {
        !self.keeps_all && self.frames.iter().map(KeyFrame::counts).sum::<usize>() > MOST
    }

    /// Adds a key frame with a later stamp than all others, however near to them.
    pub fn push_beside(&mut self, stamp_s: f64, pose: PoseBox, reading: Option<FrameReading>) {
        let number = self.new_number();
        let readings = reading.into_iter().map(|reading| FrameReading { number, ..reading }).collect();
        self.frames.push_back(KeyFrame::new(number, stamp_s, pose, readings));
    }

    /// Adds a reading to the key frame with exactly this stamp, if there is one without a reading of this source. Returns whether it was added.
    pub fn join(&mut self, stamp_s: f64, reading: FrameReading) -> bool {
        let is_open = |frame: &KeyFrame| frame.stamp_s == stamp_s && !frame.has(reading.source);
        let Some(at) = self.frames.iter().rposition(is_open) else { return false };
        let number = if self.frames[at].readings.is_empty() { self.frames[at].number } else { self.new_number() };
        self.frames[at].readings.push(FrameReading { number, ..reading });
        self.frames[at].is_linked = false;
        true
    }

    fn new_number(&mut self) -> usize {
        self.next_number += 1;
        self.next_number - 1
    }

    /// Stamp of the latest key frame that has a reading of a source.
    pub fn latest_of_s(&self, source: &str) -> Option<f64> {
        self.frames.iter().rev().find(|frame| frame.has(source)).map(|frame| frame.stamp_s)
    }

    /// Box of the pose at the latest key frame that has a reading of a source.
    pub fn latest_of(&self, source: &str) -> Option<PoseBox> {
        self.frames.iter().rev().find(|frame| frame.has(source)).map(|frame| frame.pose)
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
        self.frames.back().is_some_and(|latest| !latest.readings.is_empty())
    }

    /// The oldest key frame whose way from the key frame before has not been asked for.
    pub fn unlinked(&self) -> Option<Unlinked> {
        let at = self.frames.iter().position(|frame| !frame.is_linked)?;
        let before = at.checked_sub(1).map(|before| &self.frames[before]);
        let KeyFrame { number, stamp_s, readings, .. } = &self.frames[at];
        Some(Unlinked {
            number: *number,
            stamp_s: *stamp_s,
            before: before.map(|one| (one.stamp_s, one.pose[2])),
            stamp_errors_s: readings.iter().map(|reading| reading.relations.stamp_error_s()).collect(),
        })
    }

    /// Sets the way to a key frame from the one before, if it is known, and how far the robot can have gone within the errors of its readings' stamps,
    /// as far as that is known.
    pub fn link(&mut self, number: usize, way: Option<Way>, flow: Option<FlowWay>, strays: &[Stray]) {
        let Some(at) = self.frames.iter().position(|frame| frame.number == number) else { return };
        let is_told = at > 0 && (way.is_some() || flow.is_some());
        if is_told {
            let place = places(&flow);
            let before = &mut self.frames[at - 1];
            let shares_error = place.is_some_and(|[first, _]| *before.place.get_or_insert(first) == first);
            let scale_change = self.flow_scale_change;
            self.frames[at].way_known_s = self.known_s().filter(|_| flow.is_some());
            self.frames[at].place = place.map(|[_, last]| last);
            self.frames[at].link = Some(Link::Read(Read { way, flow, shares_error, scale_change }));
        }
        // The way on from it may be by counts of other readings.
        let place = self.frames[at].place.map(|(_, readings_s)| readings_s);
        if let Some(Link::Read(next)) = self.frames.get_mut(at + 1).and_then(|next| next.link.as_mut()) {
            next.shares_error &= next.flow.as_ref().map(|flow| flow.end_readings_s[0]) == place;
        }
        let frame = &mut self.frames[at];
        frame.is_linked = true;
        frame.readings.iter_mut().zip(strays).for_each(|(reading, &stray)| reading.stray = stray);
        if frame.link.is_none() && self.frames.iter().take(at).all(|frame| frame.readings.is_empty()) {
            // Nothing relates the key frames before to this one.
            self.frames.drain(..at);
        }
    }

    /// Stamp of the key frame with the given number.
    pub fn stamp_s(&self, number: usize) -> Option<f64> {
        self.frames.iter().find(|frame| frame.number == number).map(|frame| frame.stamp_s)
    }

    /// Number of the key frame that is so many key frames older than the latest one.
    pub fn number_before_latest(&self, n_frames: usize) -> Option<usize> {
        Some(self.frames.get(self.frames.len().checked_sub(n_frames + 1)?)?.number)
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
        let known_s = self.known_s();
        let after = &mut self.frames[at + 1];
        after.way_known_s = known_s.filter(|_| link.is_some());
        after.link = link;
        self.frames.remove(at);
    }
}

/// The ways between two stamps: by the wheels with the gyroscope, and by the flow sensor with the gyroscope.
pub type Ways = (Option<Way>, Option<FlowWay>);

/// A key frame whose way from the key frame before has not been asked for.
#[derive(Clone, Debug)]
pub struct Unlinked {
    /// Number of the key frame.
    pub number: usize,
    /// Stamp of the key frame.
    pub stamp_s: f64,
    /// Stamp of the key frame before, and the headings there; `None` for the first key frame.
    pub before: Option<(f64, Interval)>,
    /// Greatest errors of the stamps of its readings.
    pub stamp_errors_s: Vec<f64>,
}

/// The errors of the flow sensor's places at both ends of a way by its counts, each with the stamps of the readings that the counts are of.
fn places(flow: &Option<FlowWay>) -> Option<[(f64, [f64; 2]); 2]> {
    let flow = flow.as_ref()?;
    Some([0, 1].map(|end| (flow.end_error_m[end], flow.end_readings_s[end])))
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
