//! What readings say about the pose, by the vision of the built-in filters, for filters in Python.

use nalgebra::{DMatrix, Matrix3};
use numpy::{PyArray1, PyArray2, ndarray::Array2};
use pyo3::prelude::*;
use sim::{
    scene::Scene,
    subject::{Cue, CueReader, told},
};
use std::sync::Mutex;

use crate::{answers::numbers, drive::Drive, json, reading::PyReading};

/// Residual, Jacobian and noise of one compared cue.
type Linear<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Reads cues from the readings of a drive's robot: markers, joints, walls, lines of a scan, landmarks, positions. It has the vision of the built-in
/// filters.
///
/// Give it every reading in the order of arrival; `for cue in cues.read(reading)` then has what the reading says about the pose.
#[pyclass(module = "wherein", frozen)]
pub(crate) struct Cues {
    reader: Mutex<CueReader>,
}

impl Cues {
    pub(crate) fn of_scene(scene: &Scene) -> Cues {
        Cues { reader: Mutex::new(CueReader::of(scene)) }
    }
}

/// What a localizer is told beforehand about a scene, with new cues.
pub(crate) fn told_with_cues(py: Python<'_>, scene: &Scene) -> PyResult<Py<PyAny>> {
    let told = json::to_python(py, &told(scene))?;
    told.bind(py).set_item("cues", Py::new(py, Cues::of_scene(scene))?)?;
    Ok(told)
}

#[pymethods]
impl Cues {
    /// A reader for the robot of a drive.
    #[new]
    fn new(drive: &Drive) -> Cues {
        Cues::of_scene(&drive.file().scene)
    }

    /// Takes in a reading and returns its cues, mostly none. An image takes some milliseconds.
    fn read(&self, py: Python<'_>, reading: &PyReading) -> Vec<PyCue> {
        let read = || self.reader.lock().unwrap_or_else(std::sync::PoisonError::into_inner).read(&reading.reading);
        py.detach(read).into_iter().map(|cue| PyCue { cue }).collect()
    }

    /// Begins a drive anew, at a further station.
    fn restart(&self) {
        self.reader.lock().unwrap_or_else(std::sync::PoisonError::into_inner).restart();
    }
}

/// One thing that a reading says about the pose.
#[pyclass(name = "Cue", module = "wherein", frozen)]
pub(crate) struct PyCue {
    cue: Cue,
}

#[pymethods]
impl PyCue {
    /// What the cue is: "markers", "joint", "walls" for edges in an image, "line" for a straight part of a scan, "landmark" or "position".
    #[getter]
    fn kind(&self) -> &'static str {
        self.cue.kind()
    }

    /// Stamp of the reading in seconds since the start of the drive. An image arrives later than it was taken, by the latency of its camera.
    #[getter]
    fn measured_s(&self) -> f64 {
        self.cue.measured_s
    }

    /// A landmark that no map gives: its code, its place in the robot frame in metres (2,), and the covariance of the place in m² (2, 2); None for
    /// every other cue.
    #[getter]
    fn landmark(&self) -> Option<(u32, [f64; 2], [[f64; 2]; 2])> {
        let (code, place, covariance) = self.cue.landmark()?;
        Some((code, place.into(), [0, 1].map(|row| [0, 1].map(|column| covariance[(row, column)]))))
    }

    /// Compares the cue with the pose that a filter predicts for the cue's stamp. Returns the residual (measured less predicted) of shape (n,), the
    /// Jacobian of the prediction by x, y and heading of shape (n, 3), and the covariance of the noise of shape (n, n); or None where the cue tells
    /// nothing, as a joint between tiles that may as well be its neighbour, a line of a scan that is no wall, edges that disagree, or a landmark.
    ///
    /// pose: x (m), y (m) and heading (rad), of shape (3,).
    /// covariance: covariance of the pose, of shape (3, 3).
    fn compare<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        covariance: &Bound<'py, PyAny>,
    ) -> PyResult<Option<Linear<'py>>> {
        let pose: [f64; 3] = numbers("pose", "(3,)", pose)?;
        let covariance: [[f64; 3]; 3] = numbers("covariance", "(3, 3)", covariance)?;
        let covariance = Matrix3::from_fn(|row, column| covariance[row][column]);
        let Some(compared) = self.cue.compare(pose, &covariance) else { return Ok(None) };
        let residual = PyArray1::from_iter(py, compared.residual.iter().copied());
        Ok(Some((residual, array(py, &compared.jacobian), array(py, &compared.noise))))
    }

    fn __repr__(&self) -> String {
        format!("<Cue {} of {:.3} s>", self.cue.kind(), self.cue.measured_s)
    }
}

fn array<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    let entries = Array2::from_shape_fn(matrix.shape(), |(row, column)| matrix[(row, column)]);
    PyArray2::from_owned_array(py, entries)
}
