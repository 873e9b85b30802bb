//! What a user asks for, as the arguments of functions: scenes with set keys, and frames.

use std::path::Path;

use pyo3::{exceptions::PyValueError, prelude::*, types::PyDict};
use sim::{
    loading::{SceneFile, SceneTemplate, Setting},
    run::FramesPolicy,
};

use crate::errors;

/// The scene of a file, with some keys set: a dict of values by key, or texts `key=value` as the command has them.
pub(crate) fn scene_file(path: &Path, set: Option<&Bound<'_, PyAny>>) -> PyResult<SceneFile> {
    let template = SceneTemplate::load(path).map_err(|error| errors::of_scene(&error))?;
    template.with(&settings(set)?).map_err(|error| errors::of_scene(&error))
}

/// Keys that are set, from a dict of values by key.
pub(crate) fn settings(set: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Setting>> {
    let Some(set) = set else { return Ok(Vec::new()) };
    let texts: Vec<String> = match set.cast::<PyDict>() {
        Ok(dict) => {
            dict.iter().map(|(key, value)| Ok(format!("{key}={}", toml_of(&value)?))).collect::<PyResult<_>>()?
        }
        Err(_) => set.extract()?,
    };
    let setting =
        |text: &String| text.parse().map_err(|reason| PyValueError::new_err(format!("set: `{text}`: {reason}")));
    texts.iter().map(setting).collect()
}

/// A value as the command has it after `key=`.
pub(crate) fn toml_of(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(truth) = value.extract::<bool>() {
        return Ok(truth.to_string());
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(text);
    }
    if let Ok(items) = value.extract::<Vec<Bound<'_, PyAny>>>() {
        let items = items.iter().map(|item| match item.extract::<String>() {
            Ok(text) => Ok(format!("{text:?}")),
            Err(_) => toml_of(item),
        });
        return Ok(format!("[{}]", items.collect::<PyResult<Vec<_>>>()?.join(", ")));
    }
    Ok(value.str()?.to_string())
}

pub(crate) fn frames_policy(frames: &str) -> PyResult<FramesPolicy> {
    frames.parse().map_err(|reason| PyValueError::new_err(format!("frames: {reason}")))
}
