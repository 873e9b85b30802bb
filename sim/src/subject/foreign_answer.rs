//! Answers that come from outside of this program: checking them, and making them answers of a localizer under test.

use std::f64::consts::TAU;

use interval::Interval;
use localizer::{Assumption, Estimate, Pose, PoseBox, PoseUnion, Status, bounds};
use nalgebra::Matrix3;

use super::{Answer, GaussianPose, WeightedPose};

/// Greatest difference between two entries of a covariance that must be equal, and greatest negative eigenvalue, as a share of its greatest entry.
/// Arithmetic with f32 in a filter leaves errors of some 1e-7.
const COVARIANCE_ROUNDING: f64 = 1e-6;

/// An answer from outside, not yet checked. Poses are x and y in metres and the heading in radians.
#[derive(Clone, Debug, PartialEq)]
pub enum ForeignAnswer {
    /// A single pose.
    Point([f64; 3]),
    /// A Gaussian distribution of the pose.
    Gaussian {
        /// The mean.
        mean: [f64; 3],
        /// The covariance, in m², m·rad and rad².
        covariance: [[f64; 3]; 3],
    },
    /// A weighted sample: each a pose and its weight.
    Samples(Vec<[f64; 4]>),
    /// A union of boxes: the least and the greatest x, y and heading of each.
    Boxes {
        /// The boxes.
        boxes: Vec<[[f64; 2]; 3]>,
        /// Whether an assumption of the boxes is doubted.
        is_recovering: bool,
        /// Names of the declared bounds that the boxes rely on; all of them where this is `None`.
        relies_on: Option<Vec<String>>,
    },
}

impl ForeignAnswer {
    /// The answer for `time_s`. The error says what is wrong with it and what was expected, in words that follow "answered with".
    pub fn checked(self, time_s: f64) -> Result<Answer, String> {
        self.are_numbers_finite()?;
        match self {
            ForeignAnswer::Point(at) => Ok(Answer::Point(pose(at))),
            ForeignAnswer::Gaussian { mean, covariance } => {
                checked(covariance)?;
                Ok(Answer::Gaussian(GaussianPose { mean: pose(mean), covariance }))
            }
            ForeignAnswer::Samples(samples) => weighted(&samples).map(Answer::Samples),
            ForeignAnswer::Boxes { boxes, is_recovering, relies_on } => {
                let status = if is_recovering { Status::Recovering } else { Status::Sound };
                let (pose, relies_on) = (union(&boxes)?, known(relies_on)?);
                Ok(Answer::Boxes(Estimate { time_s, pose, status, relies_on, contradicting: None }))
            }
        }
    }

    fn are_numbers_finite(&self) -> Result<(), String> {
        let (what, numbers): (&str, Vec<f64>) = match self {
            ForeignAnswer::Point(at) => ("a pose", at.to_vec()),
            ForeignAnswer::Gaussian { mean, covariance } => {
                ("a mean or covariance", mean.iter().chain(covariance.as_flattened()).copied().collect())
            }
            ForeignAnswer::Samples(samples) => ("samples", samples.as_flattened().to_vec()),
            ForeignAnswer::Boxes { boxes, .. } => ("boxes", boxes.as_flattened().as_flattened().to_vec()),
        };
        match numbers.iter().find(|number| !number.is_finite()) {
            Some(number) => Err(format!("{what} of which one number is {number}, expected finite numbers")),
            None => Ok(()),
        }
    }
}

/// The answer with every heading moved by whole turns to where it is nearest to `heading_rad`. Headings in the simulation count turns, while a process
/// may wrap its headings.
pub fn turned_to(answer: Answer, heading_rad: f64) -> Answer {
    let off_rad = |at_rad: f64| TAU * ((heading_rad - at_rad) / TAU).round();
    let turned = |pose: Pose| Pose { heading_rad: pose.heading_rad + off_rad(pose.heading_rad), ..pose };
    match answer {
        Answer::Point(pose) => Answer::Point(turned(pose)),
        Answer::Gaussian(gaussian) => Answer::Gaussian(GaussianPose { mean: turned(gaussian.mean), ..gaussian }),
        Answer::Samples(samples) => {
            let turned = |sample: WeightedPose| WeightedPose { pose: turned(sample.pose), ..sample };
            Answer::Samples(samples.into_iter().map(turned).collect())
        }
        Answer::Boxes(mut estimate) => {
            for branch in &mut estimate.pose.branches {
                branch[2] = branch[2] + Interval::point(off_rad(branch[2].mid()));
            }
            Answer::Boxes(estimate)
        }
    }
}

fn pose([x_m, y_m, heading_rad]: [f64; 3]) -> Pose {
    Pose { x_m, y_m, heading_rad }
}

/// Greatest time by which the stamp of a reading may be ahead of the answer that takes it into account. No clock of a scene is as far ahead, while a
/// stamp in another count of time is.
const MOST_AHEAD_S: f64 = 1.0;

/// The stamp of the newest reading that an answer for `time_s` takes into account, if it is told. An error says what was given and what was expected.
pub fn newest_stamp(newest_s: Option<f64>, time_s: f64) -> Result<Option<f64>, String> {
    match newest_s {
        Some(stamp_s) if !(stamp_s.is_finite() && stamp_s <= time_s + MOST_AHEAD_S) => Err(format!(
            "the newest_s {stamp_s}, expected the stamp of a reading in seconds, at most {MOST_AHEAD_S} s after the answer's own time {time_s}"
        )),
        newest_s => Ok(newest_s),
    }
}

/// Checks that a matrix can be a covariance: symmetric, and with no direction along which the variance is negative.
fn checked(covariance: [[f64; 3]; 3]) -> Result<(), String> {
    let matrix = Matrix3::from_fn(|row, column| covariance[row][column]);
    let rounding = COVARIANCE_ROUNDING * matrix.amax();
    if (matrix - matrix.transpose()).amax() > rounding {
        return Err(format!("a `covariance` that is not symmetric: {covariance:?}"));
    }
    let least = matrix.symmetric_eigenvalues().min();
    if least.is_nan() || least < -rounding {
        return Err(format!(
            "a `covariance` that has the negative eigenvalue {least:e}, expected none: {covariance:?}"
        ));
    }
    Ok(())
}

fn weighted(samples: &[[f64; 4]]) -> Result<Vec<WeightedPose>, String> {
    if samples.is_empty() {
        return Err("no `samples`, expected at least one".to_owned());
    }
    let weights = || samples.iter().map(|sample| sample[3]);
    if let Some(weight) = weights().find(|weight| *weight < 0.0) {
        return Err(format!("`samples` of which one has the weight {weight}, expected at least 0"));
    }
    let total: f64 = weights().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Err(format!("{} `samples` whose weights add up to {total}, expected more than 0", samples.len()));
    }
    let sample = |[x_m, y_m, heading_rad, weight]: &[f64; 4]| WeightedPose {
        pose: pose([*x_m, *y_m, *heading_rad]),
        weight: *weight,
    };
    Ok(samples.iter().map(sample).collect())
}

fn union(boxes: &[[[f64; 2]; 3]]) -> Result<PoseUnion, String> {
    if boxes.is_empty() {
        return Err("no `boxes`, expected at least one".to_owned());
    }
    if let Some([low, high]) = boxes.iter().flatten().find(|[low, high]| low > high) {
        return Err(format!("`boxes` of which one has the side [{low}, {high}], expected [least, greatest]"));
    }
    let side = |[low, high]: [f64; 2]| Interval::new(low, high);
    Ok(PoseUnion { branches: boxes.iter().map(|sides| PoseBox::from(sides.map(side))).collect() })
}

/// The declared bounds of these names. Boxes that name none rely on all of them.
fn known(names: Option<Vec<String>>) -> Result<Vec<Assumption>, String> {
    let Some(names) = names else { return Ok(bounds::ALL.iter().map(|bound| bound.name).collect()) };
    let of_name = |name: &String| bounds::ALL.iter().map(|bound| bound.name).find(|known| known == name);
    let unknown = |name: &String| format!("`relies_on` that names `{name}`, expected declared bounds");
    names.iter().map(|name| of_name(name).ok_or_else(|| unknown(name))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_with_a_number_that_is_not_finite_is_refused() {
        let diagonal = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut covariance = diagonal;
            covariance[1][1] = wrong;
            for answer in [
                ForeignAnswer::Point([0.0, wrong, 0.0]),
                ForeignAnswer::Gaussian { mean: [wrong, 0.0, 0.0], covariance: diagonal },
                ForeignAnswer::Gaussian { mean: [0.0; 3], covariance },
                ForeignAnswer::Gaussian { mean: [0.0; 3], covariance: [[wrong; 3]; 3] },
                ForeignAnswer::Samples(vec![[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, wrong, 1.0]]),
                ForeignAnswer::Samples(vec![[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, wrong]]),
                ForeignAnswer::Boxes {
                    boxes: vec![[[0.0, 1.0], [0.0, 1.0], [0.0, wrong]]],
                    is_recovering: false,
                    relies_on: None,
                },
            ] {
                let refusal = answer.clone().checked(1.0);
                let is_refused = refusal.as_ref().is_err_and(|reason| reason.ends_with("expected finite numbers"));
                assert!(is_refused, "{answer:?}: {refusal:?}");
            }
        }
        let sound = ForeignAnswer::Gaussian { mean: [0.0; 3], covariance: diagonal };
        assert!(sound.checked(1.0).is_ok());
    }
}
