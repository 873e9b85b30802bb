//! The exceptions of the package, with the messages that the command prints.

use pyo3::{PyErr, create_exception, exceptions::PyException};
use sim::{
    artefacts::run_files::RecordError,
    campaign::{comparison::SideError, sweep::SweepError},
    render::RenderError,
};

create_exception!(wherein, WhereinError, PyException, "Anything that Wherein cannot do; base class of its exceptions.");
create_exception!(
    wherein,
    SceneError,
    WhereinError,
    "A scene, a key or a value of it is refused; the message names it."
);
create_exception!(wherein, AnswerError, WhereinError, "A step was answered with what is no answer, or not answered.");
create_exception!(wherein, RunError, WhereinError, "A drive cannot go on: no graphics adapter, a full disk, …");

/// A scene that is refused, with the place in its file.
pub(crate) fn of_scene(error: &sim::scene::SceneError) -> PyErr {
    let place = error.place(false).map(|place| format!("\n{place}")).unwrap_or_default();
    SceneError::new_err(format!("failed to {error}{place}"))
}

pub(crate) fn of_render(error: &RenderError) -> PyErr {
    RunError::new_err(format!("failed to {error}"))
}

pub(crate) fn of_record(error: &RecordError) -> PyErr {
    RunError::new_err(format!("failed to {error}"))
}

pub(crate) fn of_sweep(error: &SweepError) -> PyErr {
    match error {
        SweepError::Scene(error) => of_scene(error),
        other => RunError::new_err(format!("failed to {other}")),
    }
}

pub(crate) fn of_side(error: &SideError) -> PyErr {
    RunError::new_err(format!("failed to {error}"))
}
