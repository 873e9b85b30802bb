//! What a user asks for, as the arguments of functions: scenes with set keys, frames, localizers under test.

use std::{path::Path, sync::Arc};

use pyo3::{exceptions::PyValueError, prelude::*, types::PyDict};
use sim::{
    loading::{SceneFile, SceneTemplate, Setting},
    run::FramesPolicy,
    subject::{Added, SubjectChoice},
};

use crate::{called::Called, errors, stop::Stop};

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

/// The localizer under test: a name or a command as after `--subject`, or a class or function that makes a localizer in Python. An exception of that
/// localizer which is no error of it, such as KeyboardInterrupt, sets `stop`.
pub(crate) fn subject_choice(subject: Option<&Bound<'_, PyAny>>, stop: &Stop) -> PyResult<SubjectChoice> {
    let Some(subject) = subject else { return Ok(SubjectChoice::default()) };
    if let Ok(name) = subject.extract::<String>() {
        return name.parse().map_err(|reason| PyValueError::new_err(format!("subject: {name}: {reason}")));
    }
    if !subject.is_callable() {
        let found = subject.repr()?;
        return Err(PyValueError::new_err(format!("subject: expected a name, a command or a class, found {found}")));
    }
    let name = subject.getattr("__name__").and_then(|name| name.extract()).unwrap_or_else(|_| "python".to_owned());
    let make = Arc::new(subject.clone().unbind());
    let (called, stop) = (name.clone(), stop.clone());
    Ok(SubjectChoice::Added(Added::of_user(name, move |scene| Box::new(Called::new(&make, &called, scene, &stop)))))
}
