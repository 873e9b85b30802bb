//! The native part of the Python package `wherein`: drives step by step, results, cues and interval analysis.

mod answers;
mod asked;
mod called;
mod cues;
mod drive;
mod errors;
mod experiments;
mod intervals;
mod json;
mod localizer;
mod own_robot;
mod reading;
mod result;
mod stop;

/// The native part of the package `wherein`.
#[pyo3::pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::{
        cues::{Cues, PyCue},
        drive::{Drive, PyStep},
        errors::{AnswerError, RunError, SceneError, WhereinError},
        experiments::{be_library, compare_results, report_folder, run_scenes, run_sweep},
        intervals::{
            Ctc, PyBox, PyInterval, Sep, ctc_box, ctc_dist, ctc_inter, ctc_polar, ctc_q_inter, ctc_union, sep_dist,
            sivia,
        },
        localizer::{PoseUnion, PyLocalizer},
        reading::{FlowReading, GyroReading, ImageReading, OtherReading, PyReading, RangeReading, WheelsReading},
        result::DriveResult,
    };

    use numpy::PyArray1;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // numpy is loaded now, because an interrupt while it is loaded at its first use would be a panic.
        module.py().import("numpy")?;
        PyArray1::<f64>::zeros(module.py(), [0], false);
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
