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
        intervals::{Ctc, PyBox, PyInterval, Sep, ctc_box, ctc_dist, ctc_polar, ctc_q_inter, sep_dist, sivia},
        localizer::{PoseUnion, PyLocalizer},
        reading::{FlowReading, GyroReading, ImageReading, OtherReading, PyReading, RangeReading, WheelsReading},
        result::DriveResult,
    };
}
