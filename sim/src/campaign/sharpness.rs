//! Sharpness: how wide the localizer's boxes are, compared with what the readings and the declared bounds leave open.
//!
//! A *witness* is a whole history of robot and sensors, other than the truth, that keeps every declared bound on the very readings of a run that have
//! arrived by an instant. A localizer cannot know that it is not the truth, so that a guaranteed box has to contain where it ends. Along each axis the
//! distance between the outermost witnesses therefore bounds the exact set's width from below, and the box's width over that distance bounds the
//! sharpness from above: 1 is a box that cannot be narrower.
//!
//! Every witness is checked by code that shares nothing with the localizer's measurements: it computes each reading from the history by its own
//! formulas, in interval arithmetic, and compares it with the declared bound. Where the search ends early, witnesses are weak and the figure is too
//! great, never too small.

mod dots;
mod eye;
mod floor;
mod flow;
mod gains;
mod gyro;
mod history;
mod joints;
mod kind;
mod motion;
mod number;
mod outline;
mod perceived;
mod range;
mod readings;
mod rest;
mod search;
mod walls;
mod wheels;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

use interval::Interval;
use localizer::{Estimate, Pose, PoseBox};
use serde::Serialize;
use thiserror::Error;

use crate::{
    devices::Observation,
    run::{RunRecord, Witness},
    scene::Scene,
    truth::Truth,
};

use readings::{Readings, unsupported};

/// Number of instants at which `wherein sharpness` searches for witnesses, evenly over the drive.
pub const N_INSTANTS: usize = 20;
/// Time of a drive beyond which no instant lies: the work for one instant grows with the time before it.
const LONGEST_S: f64 = 200.0;

/// Time below which two instants are the same and differ by rounding alone: no device measures twice within it.
const SAME_S: f64 = 1e-9;

/// Names of the axes of a pose with their units, in the order of every array of this module.
pub const AXES: [&str; 3] = ["x_m", "y_m", "heading_rad"];

/// An observer that keeps the readings of a run, with the truth behind each, but for images.
#[derive(Default)]
pub struct ReadingLog {
    observations: Vec<Observation>,
    truths: Vec<Truth>,
}

impl Witness for ReadingLog {
    fn start(&mut self, _offset_s: f64, _station: Option<usize>) {}

    fn sense(&mut self, observation: &Observation) {
        if !matches!(observation.reading, localizer::Reading::Camera { .. }) {
            self.observations.push(observation.clone());
        }
    }

    fn account(&mut self, _reading: &localizer::Reading, _accounts: &[localizer::localizer::Account]) {}

    fn step(&mut self, truth: &Truth, _estimate: &Estimate, _odometry: Pose) {
        self.truths.push(*truth);
    }
}

/// Sharpness at one instant, per axis in the order of [`AXES`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Instant {
    /// Time since the start of the run.
    pub time_s: f64,
    /// Full width of the box around the localizer's estimate.
    pub width: [f64; 3],
    /// From the outermost witness on one side of the truth to that on the other one, in the world, with the heading as a real number. Where no witness
    /// was found it is the truth alone, and empty before the first reading.
    pub witnesses: [Interval; 3],
    /// Greatest distance of a witness from the middle of the box over half the box's width; `None` where none but the truth was found. At 1 a witness
    /// lies on a face of the box.
    pub power: [Option<f64>; 3],
    /// Whether all witnesses are in the localizer's box. If not, the box is wrong, however the truth lies.
    pub in_box: bool,
    /// Where no witness was found: the bound that the truth or the last candidate broke.
    pub broken: Option<String>,
    /// Along each axis what makes most of the width at the latest key frame of the graph; `None` before the first one.
    pub dominant: [Option<Dominant>; 3],
}

/// The declared bound that makes most of a width: the one to calibrate next.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dominant {
    /// Name of the bound; `None` where the width comes from boxes alone.
    pub bound: Option<&'static str>,
    /// The part of the width that the bound makes, in the unit of the width; 0 without a bound.
    pub part: f64,
    /// The part that the boxes of poses and landmarks make, which come from many bounds.
    pub boxes: f64,
    /// The width at the key frame, before it is intersected with what other readings tell.
    pub width: f64,
}

impl Instant {
    /// Distance between the outermost witnesses along an axis; 0 where none but the truth was found.
    pub fn spanned(&self, axis: usize) -> f64 {
        let witnesses = self.witnesses[axis];
        if witnesses.is_empty() { 0.0 } else { witnesses.width() }
    }

    /// Whether a box contains all witnesses along each axis. Those of different branches of an estimate need not be in one branch, so that a box is the
    /// hull of an estimate.
    pub fn are_witnesses_in(&self, hull: &PoseBox) -> bool {
        (0..3).all(|axis| self.witnesses[axis].is_subset_of(hull[axis]))
    }

    /// The box's width over the distance of the witnesses; `None` where there is no pair of witnesses.
    pub fn ratio(&self, axis: usize) -> Option<f64> {
        let spanned = self.spanned(axis);
        (spanned > 0.0).then(|| self.width[axis] / spanned)
    }

    /// Whether there is a pair of witnesses along every axis.
    pub fn has_pair(&self) -> bool {
        (0..3).all(|axis| self.spanned(axis) > 0.0)
    }
}

/// Sharpness of the boxes of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sharpness {
    /// The instants, in ascending order.
    pub instants: Vec<Instant>,
}

impl Sharpness {
    /// Means of an axis over the instants with a pair of witnesses: of the box's width, and of the witnesses' distance; `None` where there is none.
    pub fn means(&self, axis: usize) -> Option<[f64; 2]> {
        let with_pair: Vec<&Instant> = self.instants.iter().filter(|instant| instant.spanned(axis) > 0.0).collect();
        let mean = |of: &dyn Fn(&Instant) -> f64| {
            with_pair.iter().map(|instant| of(instant)).sum::<f64>() / with_pair.len() as f64
        };
        (!with_pair.is_empty()).then(|| [mean(&|instant| instant.width[axis]), mean(&|instant| instant.spanned(axis))])
    }

    /// Greatest distance of a witness from the middle of its box along an axis, over half the box's width; `None` where there is no witness. A fault that
    /// leaves a smaller share of every width than this excludes a witness.
    pub fn power(&self, axis: usize) -> Option<f64> {
        self.instants.iter().filter_map(|instant| instant.power[axis]).max_by(f64::total_cmp)
    }

    /// Median of the ratios of an axis, over the instants with a pair of witnesses; `None` where there is none.
    pub fn median(&self, axis: usize) -> Option<f64> {
        let mut ratios: Vec<f64> = self.instants.iter().filter_map(|instant| instant.ratio(axis)).collect();
        ratios.sort_by(f64::total_cmp);
        let middle = ratios.len() / 2;
        match ratios.len() {
            0 => None,
            n if n % 2 == 1 => Some(ratios[middle]),
            _ => Some(0.5 * (ratios[middle - 1] + ratios[middle])),
        }
    }
}

/// Why no sharpness can be measured for a scene. The text follows "failed to".
#[derive(Debug, Error)]
pub enum SharpnessError {
    /// The scene has something of which no witness can be checked yet.
    #[error("measure the sharpness of {scene}: `{key}` is {value}, expected {expected}")]
    Unsupported {
        /// Name of the scene.
        scene: String,
        /// Key of the scene.
        key: &'static str,
        /// Its value.
        value: String,
        /// What was expected instead.
        expected: &'static str,
    },
}

/// Instants at which sharpness is measured, for a drive that lasts `duration_s` or its first 200 s: one in each of equally long spans, at places that
/// fall evenly over the span. So they fall evenly over the periods of all sensors, too, and means over them are means over the drive.
pub fn instants_s(duration_s: f64, n_instants: usize) -> Vec<f64> {
    /// Multiples of the golden ratio are spread over the whole numbers' remainders as evenly as any numbers can be.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let span_s = duration_s.min(LONGEST_S) / n_instants as f64;
    let place = |at: usize| at as f64 + (GOLDEN * (at + 1) as f64).fract();
    // Estimates are made every 10 ms.
    (0..n_instants).map(|at| (place(at) * span_s * 100.0).floor() / 100.0).collect()
}

/// Measures the sharpness of a recorded run of a scene, whose readings are in the log, at so many instants. `progress` is called with the number of
/// instants done.
pub fn measure(
    scene: &Scene,
    name: &str,
    record: &RunRecord,
    log: &ReadingLog,
    n_instants: usize,
    progress: &mut dyn FnMut(usize),
) -> Result<Sharpness, SharpnessError> {
    refuse_unsupported(scene, name)?;
    let last_s = record.truths.last().map_or(0.0, |truth| truth.time_s);
    let readings = Readings::of(scene, record, log);
    let mut instants = Vec::new();
    for time_s in instants_s(last_s.min(scene.duration_s), n_instants) {
        let at = record.estimates.partition_point(|estimate| estimate.time_s < time_s - 0.005);
        let Some(estimate) = record.estimates.get(at) else { break };
        let mut instant = at_instant(&readings, estimate, record.truths[at].time_s);
        instant.dominant = dominant(record, instant.time_s);
        instants.push(instant);
        progress(instants.len());
    }
    Ok(Sharpness { instants })
}

/// Errors for a scene with readings or bounds of which no witness can be checked.
pub fn refuse_unsupported(scene: &Scene, name: &str) -> Result<(), SharpnessError> {
    match unsupported(scene) {
        Some((key, value, expected)) => {
            Err(SharpnessError::Unsupported { scene: name.to_owned(), key, value, expected })
        }
        None => Ok(()),
    }
}

/// What makes most of the width along each axis at the latest key frame before a time.
fn dominant(record: &RunRecord, time_s: f64) -> [Option<Dominant>; 3] {
    let known = record.widths.partition_point(|width| width.stamp_s <= time_s);
    let Some(width) = known.checked_sub(1).map(|at| &record.widths[at]) else { return [const { None }; 3] };
    [&width.x_m, &width.y_m, &width.heading_rad].map(|parts| {
        let greatest = parts.greatest();
        let (bound, part) = (greatest.map(|(bound, _)| bound), greatest.map_or(0.0, |(_, part)| part));
        Some(Dominant { bound, part, boxes: parts.by_boxes, width: parts.width() })
    })
}

fn at_instant(readings: &Readings, estimate: &Estimate, time_s: f64) -> Instant {
    let hull = estimate.pose.hull();
    let width = [0, 1, 2].map(|axis| hull[axis].width());
    let (witnesses, dominant) = ([Interval::EMPTY; 3], [const { None }; 3]);
    let mut instant = Instant { time_s, width, witnesses, power: [None; 3], in_box: true, broken: None, dominant };
    let Some((truth, kinds)) = readings.until(time_s) else {
        instant.broken = Some("no reading".to_owned());
        return instant;
    };
    // A witness is in the box, and so is the truth: no witness is farther from the truth than the box is wide.
    match search::search(&truth, &kinds, width.map(|width| 1.5 * width + 1e-3)) {
        Ok(found) => {
            instant.witnesses = found.spanned;
            instant.in_box = instant.are_witnesses_in(&hull);
            let off = |axis: usize| (instant.witnesses[axis] - Interval::point(hull[axis].mid())).magnitude();
            let power = |axis: usize| (instant.spanned(axis) > 0.0).then(|| off(axis) / (0.5 * hull[axis].width()));
            instant.power = [0, 1, 2].map(power);
            instant.broken = found.broken.first().map(|broken| broken.to_string());
        }
        Err(broken) => instant.broken = Some(format!("the truth: {broken}")),
    }
    instant
}
