//! Answers as Python gives them: arrays, lists or tuples of numbers.

use ::localizer::PoseUnion;
use pyo3::{exceptions::PyTypeError, prelude::*, types::PyDict};
use sim::subject::{Answer, ForeignAnswer, newest_stamp};

use crate::errors::AnswerError;

/// The numbers of an array, or of nested lists or tuples.
pub(crate) fn numbers<'py, T: FromPyObjectOwned<'py>>(
    what: &str,
    shape: &str,
    given: &Bound<'py, PyAny>,
) -> PyResult<T> {
    let listed = given.call_method0("tolist").unwrap_or_else(|_| given.clone());
    listed.extract().map_err(|_| {
        let found = given.getattr("shape").map(|shape| format!("shape {shape}")).unwrap_or_else(|_| format!("{given}"));
        AnswerError::new_err(format!("{what}: expected numbers of shape {shape}, found {found}"))
    })
}

pub(crate) fn gaussian(mean: &Bound<'_, PyAny>, covariance: Option<&Bound<'_, PyAny>>) -> PyResult<ForeignAnswer> {
    let mean: [f64; 3] = numbers("mean", "(3,)", mean)?;
    match covariance {
        None => Ok(ForeignAnswer::Point(mean)),
        Some(covariance) => {
            Ok(ForeignAnswer::Gaussian { mean, covariance: numbers("covariance", "(3, 3)", covariance)? })
        }
    }
}

pub(crate) fn samples(poses: &Bound<'_, PyAny>, weights: Option<&Bound<'_, PyAny>>) -> PyResult<ForeignAnswer> {
    let poses: Vec<[f64; 3]> = numbers("poses", "(n, 3)", poses)?;
    let weights = match weights {
        Some(weights) => numbers("weights", "(n,)", weights)?,
        None => vec![1.0; poses.len()],
    };
    if weights.len() != poses.len() {
        let (n_weights, n_poses) = (weights.len(), poses.len());
        return Err(AnswerError::new_err(format!("weights: expected {n_poses} as there are poses, found {n_weights}")));
    }
    let sample = |([x_m, y_m, heading_rad], weight): ([f64; 3], f64)| [x_m, y_m, heading_rad, weight];
    Ok(ForeignAnswer::Samples(poses.into_iter().zip(weights).map(sample).collect()))
}

pub(crate) fn boxes(
    given: &Bound<'_, PyAny>,
    is_recovering: bool,
    relies_on: Option<Vec<String>>,
) -> PyResult<ForeignAnswer> {
    let given = match given.getattr("boxes") {
        Ok(boxes) => boxes,
        Err(_) => given.clone(),
    };
    let boxes = match numbers::<[[f64; 2]; 3]>("boxes", "(3, 2)", &given) {
        Ok(one) => vec![one],
        Err(_) => numbers("boxes", "(n, 3, 2) or (3, 2)", &given)?,
    };
    Ok(ForeignAnswer::Boxes { boxes, is_recovering, relies_on })
}

/// The answer as the run takes it.
pub(crate) fn checked(answer: ForeignAnswer, time_s: f64) -> PyResult<Answer> {
    answer
        .checked(time_s)
        .map_err(|reason| AnswerError::new_err(format!("the step at {time_s:.2} s was answered with {reason}")))
}

/// The stamp of the newest reading that an answer takes into account, if it is told.
pub(crate) fn newest(newest_s: Option<f64>, time_s: f64) -> PyResult<Option<f64>> {
    newest_stamp(newest_s, time_s)
        .map_err(|reason| AnswerError::new_err(format!("the step at {time_s:.2} s was answered with {reason}")))
}

/// The answer that a method `answer` of a localizer returns: a pair of mean and covariance, a mean alone, or a dict with the keys of an answer by JSON.
/// A dict may also tell `newest_s`, the stamp of the newest reading that the answer takes into account.
pub(crate) fn returned(given: &Bound<'_, PyAny>) -> PyResult<(ForeignAnswer, Option<f64>)> {
    let newest_s = match given.cast::<PyDict>() {
        Ok(dict) => dict.get_item("newest_s")?.map(|stamp_s| stamp_s.extract()).transpose()?,
        Err(_) => None,
    };
    Ok((answer_in(given)?, newest_s))
}

/// Keys of a dict that is an answer, each kind of which has one of the first four.
const KEYS: [&str; 8] = ["boxes", "samples", "pose", "mean", "covariance", "status", "relies_on", "newest_s"];

/// Refuses a dict with keys that no answer has, or with answers of several kinds.
fn check_keys(dict: &Bound<'_, PyDict>) -> PyResult<()> {
    let names: Vec<String> = dict.keys().extract()?;
    if let Some(unknown) = names.iter().find(|name| !KEYS.contains(&name.as_str())) {
        return Err(AnswerError::new_err(format!("`{unknown}`: unknown key, expected one of {}", KEYS.join(", "))));
    }
    let kinds: Vec<&str> = KEYS[..4].iter().filter(|kind| names.iter().any(|name| name == *kind)).copied().collect();
    if kinds.len() > 1 {
        return Err(AnswerError::new_err(format!("an answer with {}, expected one of them", kinds.join(" and "))));
    }
    match dict.get_item("status")?.map(|status| status.extract::<String>()) {
        None => Ok(()),
        Some(Ok(status)) if ["sound", "recovering"].contains(&status.as_str()) => Ok(()),
        Some(_) => Err(AnswerError::new_err("`status`: expected \"sound\" or \"recovering\"")),
    }
}

fn answer_in(given: &Bound<'_, PyAny>) -> PyResult<ForeignAnswer> {
    if let Ok(dict) = given.cast::<PyDict>() {
        check_keys(dict)?;
    }
    if let Ok(boxes) = given.getattr("boxes") {
        return self::boxes(&boxes, false, None);
    }
    if let Ok(item) = given.get_item("boxes") {
        let recovering =
            given.get_item("status").and_then(|status| status.extract::<String>()).is_ok_and(|s| s == "recovering");
        let relies_on = given.get_item("relies_on").ok().map(|names| names.extract()).transpose();
        let relies_on =
            relies_on.map_err(|_| AnswerError::new_err("`relies_on`: expected a list of names of bounds"))?;
        return self::boxes(&item, recovering, relies_on);
    }
    if let Ok(item) = given.get_item("samples") {
        return Ok(ForeignAnswer::Samples(numbers("samples", "(n, 4)", &item)?));
    }
    if let Ok(pose) = given.get_item("pose") {
        return gaussian(&pose, None);
    }
    if let Ok(mean) = given.get_item("mean") {
        return gaussian(&mean, Some(&given.get_item("covariance")?));
    }
    if let Ok((mean, covariance)) = given.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>() {
        return gaussian(&mean, Some(&covariance));
    }
    gaussian(given, None).map_err(|_| {
        PyTypeError::new_err("expected a pair of mean and covariance, a pose, or a dict of boxes or samples")
    })
}

/// Sides of the boxes of a union: least and greatest x, y and heading of each.
pub(crate) fn sides(union: &PoseUnion) -> Vec<[[f64; 2]; 3]> {
    union.branches.iter().map(|branch| branch.components().map(|side| [side.lo(), side.hi()])).collect()
}
