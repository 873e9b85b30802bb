//! What a drive leaves: its verdict, truth, answers and figures.

use std::{
    io::Cursor,
    path::{Path, PathBuf},
    sync::Arc,
};

use image::ImageFormat;
use numpy::{
    PyArray2, PyArray3,
    ndarray::{Array2, Array3},
};
use pyo3::{exceptions::PyRuntimeError, prelude::*, types::PyBytes};
use sim::{
    artefacts::{
        debug_frames,
        run_files::{self, RecordError, Summary, Timing},
    },
    judge::{Verdict, figures, honesty},
    loading::SceneFile,
    run::RunRecord,
};

use crate::{errors, json};

/// What a drive leaves: verdict, truth, answers and figures. In a notebook it shows itself as a map of the drive.
#[pyclass(module = "wherein", frozen)]
#[derive(Clone)]
pub(crate) struct DriveResult {
    inner: Arc<(Arc<SceneFile>, RunRecord, Verdict)>,
}

impl DriveResult {
    pub(crate) fn new(file: Arc<SceneFile>, record: RunRecord, verdict: Verdict) -> DriveResult {
        DriveResult { inner: Arc::new((file, record, verdict)) }
    }

    pub(crate) fn write(&self, out: &Path) -> Result<PathBuf, RecordError> {
        let (file, record, verdict) = &*self.inner;
        run_files::write(out, file, record, verdict)
    }

    /// The map of the drive as a PNG file.
    pub(crate) fn png(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let (file, record, _) = &*self.inner;
        let mut bytes = Cursor::new(Vec::new());
        let drawn = py.detach(|| debug_frames::drive_map(file, record).write_to(&mut bytes, ImageFormat::Png));
        drawn.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        Ok(PyBytes::new(py, bytes.get_ref()).into_any().unbind())
    }
}

#[pymethods]
impl DriveResult {
    /// Whether every expectation of the scene was met.
    #[getter]
    fn passed(&self) -> bool {
        self.inner.2.verdict.passed
    }

    /// The scene's expectations that were not met, one text each.
    #[getter]
    fn failed(&self) -> Vec<String> {
        self.inner.2.verdict.failed.clone()
    }

    /// All figures of the drive: a dict with the content of summary.json.
    #[getter]
    fn summary(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let (file, record, verdict) = &*self.inner;
        let summary = serde_json::to_value(Summary::of(file, record, verdict));
        json::to_python(py, &summary.map_err(|error| PyRuntimeError::new_err(error.to_string()))?)
    }

    /// How long the drive took: a dict with the content of timing.json.
    #[getter]
    fn timing(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        json::to_python(py, &Timing::of(&self.inner.0, &self.inner.1).to_json())
    }

    /// True poses at every step: an array of shape (n, 4), each time (s), x (m), y (m) and heading (rad, not wrapped).
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let truths = &self.inner.1.truths;
        let entry = |(step, column): (usize, usize)| match column {
            0 => truths[step].time_s,
            axis => truths[step].pose.to_array()[axis - 1],
        };
        PyArray2::from_owned_array(py, Array2::from_shape_fn((truths.len(), 4), entry))
    }

    /// Answers at every step, by their means or the middles of their boxes: an array of shape (n, 4) as `truth`.
    #[getter]
    fn estimate<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let record = &self.inner.1;
        let middles: Vec<[f64; 3]> = record.estimates.iter().map(|estimate| estimate.pose.hull().midpoint()).collect();
        let entry = |(step, column): (usize, usize)| match column {
            0 => record.estimates[step].time_s,
            axis => middles[step][axis - 1],
        };
        PyArray2::from_owned_array(py, Array2::from_shape_fn((middles.len(), 4), entry))
    }

    /// Smallest box around the boxes of every answer: an array of shape (n, 3, 2), the least and greatest x (m), y (m) and heading (rad). The box of
    /// a distribution is its mean.
    #[getter]
    fn hulls<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        let hulls: Vec<_> = self.inner.1.estimates.iter().map(|estimate| estimate.pose.hull()).collect();
        let entry = |(step, axis, end): (usize, usize, usize)| match end {
            0 => hulls[step][axis].lo(),
            _ => hulls[step][axis].hi(),
        };
        PyArray3::from_owned_array(py, Array3::from_shape_fn((hulls.len(), 3, 2), entry))
    }

    /// Writes the files that `wherein run` writes into OUT/<scene>/<seed>/, completely or not at all, and returns that folder.
    fn save(&self, py: Python<'_>, out: PathBuf) -> PyResult<PathBuf> {
        let written = || run_files::prepare(&out).and_then(|()| self.write(&out));
        py.detach(written).map_err(|error| errors::of_record(&error))
    }

    /// The map of the drive as the bytes of a PNG file: what was driven in truth, and what was answered.
    fn map_png(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.png(py)
    }

    fn _repr_png_(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.png(py)
    }

    fn __repr__(&self) -> String {
        let (file, record, verdict) = &*self.inner;
        let passed = if verdict.verdict.passed { "passed" } else { "failed" };
        let summary = serde_json::to_value(Summary::of(file, record, verdict)).unwrap_or_default();
        let honest = honesty(&figures::figures(&summary)).map_or_else(String::new, |told| format!(", {told}"));
        format!("<DriveResult of {} seed {}: {passed}{honest}>", file.name, record.seed)
    }
}
