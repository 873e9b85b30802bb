//! Sensor readings as Python objects: one class for each kind of reading.

use std::sync::Arc;

use ::localizer::{Reading, reading::LandmarkId, reading::Sighting};
use numpy::{
    PyArray2, PyArrayMethods, PyReadonlyArray2,
    ndarray::{ArrayView2, ShapeError},
};
use pyo3::{
    IntoPyObjectExt,
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use sim::subject::device;

/// One reading of one sensor, with the time at which it was measured and the time at which it reached the localizer.
#[pyclass(name = "Reading", module = "wherein", frozen, subclass)]
pub(crate) struct PyReading {
    pub(crate) reading: Arc<Reading>,
}

#[pymethods]
impl PyReading {
    /// Name of the device that measured, such as `wheels`, `gyro` or `floor_camera`.
    #[getter]
    fn device(&self) -> &str {
        device(&self.reading)
    }

    /// Stamp in seconds since the start of the drive: when it was measured.
    #[getter]
    fn measured_s(&self) -> f64 {
        self.reading.measured_s()
    }

    /// Time in seconds since the start of the drive at which the reading reached the localizer.
    #[getter]
    fn arrived_s(&self) -> f64 {
        self.reading.arrived_s()
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let this = slf.get();
        let (device, stamp_s) = (this.device(), this.measured_s());
        Ok(format!("<{} of {device} at {stamp_s:.3} s>", slf.get_type().name()?))
    }
}

/// Encoder counts of both wheels since the start.
#[pyclass(module = "wherein", frozen, extends = PyReading)]
pub(crate) struct WheelsReading {
    /// Ticks of the left and of the right wheel since the start of the drive.
    #[pyo3(get)]
    ticks: (i64, i64),
}

#[pymethods]
impl WheelsReading {
    #[new]
    #[pyo3(signature = (measured_s, ticks, arrived_s=None))]
    fn new(measured_s: f64, ticks: (i64, i64), arrived_s: Option<f64>) -> PyClassInitializer<Self> {
        let arrived_s = arrived_s.unwrap_or(measured_s);
        let reading = Reading::Wheels { measured_s, arrived_s, ticks: [ticks.0, ticks.1] };
        PyClassInitializer::from(PyReading { reading: Arc::new(reading) }).add_subclass(WheelsReading { ticks })
    }

    /// A reading of odometry, in metres that the left and the right wheel have rolled since the start, for `Localizer`.
    #[staticmethod]
    fn of_odometry(py: Python<'_>, measured_s: f64, travel_m: (f64, f64)) -> PyResult<Py<PyAny>> {
        let reading = Reading::odometry(measured_s, measured_s, [travel_m.0, travel_m.1]).ok_or_else(|| {
            let expected = "expected two finite travels of at most 9e9 m";
            PyValueError::new_err(format!("`travel_m` is ({}, {}), {expected}", travel_m.0, travel_m.1))
        })?;
        to_python(py, reading)
    }
}

/// Turn rate of the body by the gyroscope, averaged since the reading before.
#[pyclass(module = "wherein", frozen, extends = PyReading)]
pub(crate) struct GyroReading {
    /// Turn rate in rad/s, counter-clockwise.
    #[pyo3(get)]
    rate_rad_per_s: f64,
}

#[pymethods]
impl GyroReading {
    #[new]
    #[pyo3(signature = (measured_s, rate_rad_per_s, arrived_s=None))]
    fn new(measured_s: f64, rate_rad_per_s: f64, arrived_s: Option<f64>) -> PyClassInitializer<Self> {
        let reading = Reading::Gyro { measured_s, arrived_s: arrived_s.unwrap_or(measured_s), rate_rad_per_s };
        PyClassInitializer::from(PyReading { reading: Arc::new(reading) }).add_subclass(GyroReading { rate_rad_per_s })
    }
}

/// Travel over the floor's surface since the start, as an optical flow sensor counts it.
#[pyclass(module = "wherein", frozen, extends = PyReading)]
pub(crate) struct FlowReading {
    /// Counts along the sensor's forward and its left axis since the start of the drive.
    #[pyo3(get)]
    counts: (i64, i64),
    /// Number of periods since the start in which the sensor found nothing to follow.
    #[pyo3(get)]
    blind_periods: u64,
}

/// Coded landmarks as a range camera measured them.
#[pyclass(module = "wherein", frozen, extends = PyReading)]
pub(crate) struct RangeReading {
    sightings: Vec<Sighting>,
}

#[pymethods]
impl RangeReading {
    /// Seen landmarks: for each its code, and its columns in the left and in the right view in pixels.
    #[getter]
    fn sightings(&self) -> Vec<(u32, f64, f64)> {
        self.sightings
            .iter()
            .map(|Sighting { landmark: LandmarkId(code), left_px, right_px }| (*code, *left_px, *right_px))
            .collect()
    }
}

/// Numbers of any other device.
#[pyclass(module = "wherein", frozen, extends = PyReading)]
pub(crate) struct OtherReading {
    /// The measured numbers in the device's own order and units.
    #[pyo3(get)]
    numbers: Vec<f64>,
}

#[pymethods]
impl OtherReading {
    #[new]
    #[pyo3(signature = (measured_s, device, numbers, arrived_s=None))]
    fn new(measured_s: f64, device: String, numbers: Vec<f64>, arrived_s: Option<f64>) -> PyClassInitializer<Self> {
        let arrived_s = arrived_s.unwrap_or(measured_s);
        let reading = Reading::Other { measured_s, arrived_s, device, numbers: numbers.clone() };
        PyClassInitializer::from(PyReading { reading: Arc::new(reading) }).add_subclass(OtherReading { numbers })
    }
}

/// One image of one camera.
#[pyclass(module = "wherein", frozen, extends = PyReading)]
pub(crate) struct ImageReading {
    image: Arc<image::GrayImage>,
    /// Length of the exposure in seconds, around the stamp.
    #[pyo3(get)]
    exposure_s: f64,
}

#[pymethods]
impl ImageReading {
    /// Grey levels as the sensor gave them: an array of shape (height, width) of uint8, not writable. Pixel (0, 0) is at the top left. The array is
    /// the simulator's own memory, not a copy.
    #[getter]
    fn pixels<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        let image = &slf.get().image;
        let shape = (image.height() as usize, image.width() as usize);
        let view = ArrayView2::from_shape(shape, image.as_raw())
            .map_err(|error: ShapeError| PyRuntimeError::new_err(error.to_string()))?;
        let pixels = borrowed(&view, slf.clone().into_any());
        let _: PyReadonlyArray2<'_, u8> = pixels.readwrite().make_nonwriteable();
        Ok(pixels)
    }

    /// Address of the first pixel in the simulator's memory, to see that `pixels` is no copy.
    #[getter]
    fn address(&self) -> usize {
        self.image.as_raw().as_ptr() as usize
    }
}

/// The array of pixels as numpy sees it, kept alive by its owner.
#[allow(unsafe_code)]
fn borrowed<'py>(view: &ArrayView2<'_, u8>, owner: Bound<'py, PyAny>) -> Bound<'py, PyArray2<u8>> {
    // SAFETY: the pixels belong to the image that the owner shares and never changes, and numpy keeps the owner alive as long as the array. The array
    // is made read-only before Python gets it.
    unsafe { PyArray2::borrow_from_array(view, owner) }
}

/// The Python object of a reading.
pub(crate) fn to_python(py: Python<'_>, reading: Reading) -> PyResult<Py<PyAny>> {
    let reading = Arc::new(reading);
    let base = PyClassInitializer::from(PyReading { reading: Arc::clone(&reading) });
    match &*reading {
        Reading::Wheels { ticks, .. } => {
            Py::new(py, base.add_subclass(WheelsReading { ticks: (ticks[0], ticks[1]) }))?.into_py_any(py)
        }
        Reading::Gyro { rate_rad_per_s, .. } => {
            Py::new(py, base.add_subclass(GyroReading { rate_rad_per_s: *rate_rad_per_s }))?.into_py_any(py)
        }
        Reading::Flow { counts, blind_periods, .. } => {
            let flow = FlowReading { counts: (counts[0], counts[1]), blind_periods: *blind_periods };
            Py::new(py, base.add_subclass(flow))?.into_py_any(py)
        }
        Reading::Range { sightings, .. } => {
            Py::new(py, base.add_subclass(RangeReading { sightings: sightings.clone() }))?.into_py_any(py)
        }
        Reading::Camera { image, exposure_s, .. } => {
            let image = ImageReading { image: Arc::clone(image), exposure_s: *exposure_s };
            Py::new(py, base.add_subclass(image))?.into_py_any(py)
        }
        Reading::Other { numbers, .. } => {
            Py::new(py, base.add_subclass(OtherReading { numbers: numbers.clone() }))?.into_py_any(py)
        }
    }
}
