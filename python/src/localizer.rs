//! The interval localizer on readings of one's own.

use std::sync::{Mutex, PoisonError};

use ::localizer::{
    Constraint, Localizer, Map, Method, PoseBox, Reading, RobotModel, Status,
    method::Context,
    robot::{Reach, WheelModel},
};
use interval::Interval;
use numpy::{PyArray3, ndarray::Array3};
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    types::PyDict,
};

use crate::{
    answers::sides,
    intervals::{Ctc, Given, PyBox, on_pose, raised},
    own_robot::{error_law, gyro_model, limit, track, within},
    reading::PyReading,
};

/// A union of boxes of poses, one of which surely holds the robot's pose as long as the declared bounds hold.
#[pyclass(module = "wherein", frozen)]
pub(crate) struct PoseUnion {
    sides: Vec<[[f64; 2]; 3]>,
    /// Time in seconds for which the union holds.
    #[pyo3(get)]
    time_s: f64,
    /// Whether an assumption is doubted.
    #[pyo3(get)]
    recovering: bool,
    /// Names of the bounds that the union relies on.
    #[pyo3(get)]
    relies_on: Vec<String>,
}

#[pymethods]
impl PoseUnion {
    /// The boxes: an array of shape (n, 3, 2), the least and greatest x (m), y (m) and heading (rad) of each.
    #[getter]
    fn boxes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        let entry = |(index, axis, end): (usize, usize, usize)| self.sides[index][axis][end];
        PyArray3::from_owned_array(py, Array3::from_shape_fn((self.sides.len(), 3, 2), entry))
    }

    /// Smallest box around all boxes.
    #[getter]
    fn hull(&self) -> PyBox {
        let side = |axis: usize| {
            let of = |one: &[[f64; 2]; 3]| Interval::new(one[axis][0], one[axis][1]);
            self.sides.iter().map(of).fold(Interval::EMPTY, Interval::hull)
        };
        PyBox(vec![side(0), side(1), side(2)])
    }

    fn __contains__(&self, pose: [f64; 3]) -> bool {
        let holds =
            |one: &[[f64; 2]; 3]| one.iter().zip(pose).all(|([low, high], value)| *low <= value && value <= *high);
        self.sides.iter().any(holds)
    }

    fn __repr__(&self) -> String {
        format!("<PoseUnion of {} boxes at {:.3} s>", self.sides.len(), self.time_s)
    }
}

/// The interval localizer of a robot of one's own, from its odometry and from devices that constrain its place.
#[pyclass(name = "Localizer", module = "wherein", frozen)]
pub(crate) struct PyLocalizer(Mutex<Localizer>);

/// A device whose readings a function in Python turns into constraints on x and y.
struct Device {
    name: &'static str,
    constrain: Py<PyAny>,
}

impl Method for Device {
    fn name(&self) -> &'static str {
        self.name
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Other { device, .. } if device == self.name)
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let made = Python::attach(|py| {
            let made = self.constrain.bind(py).call1((numbers.clone(),))?;
            made.extract::<Option<Ctc>>().map_err(PyErr::from)
        });
        match made {
            Ok(contractor) => Some(Constraint::new(self.name, *measured_s, on_pose(contractor?))),
            Err(error) => {
                raised::keep(error);
                None
            }
        }
    }
}

#[pymethods]
impl PyLocalizer {
    /// A localizer for a robot in a room.
    ///
    /// room: box of x and y in metres.
    /// start: box of x (m), y (m) and heading (rad) in which the robot starts.
    /// track_m: distance between the wheels, an interval.
    /// along, aside: greatest error of a wheel's travel ahead and of the robot's travel to the side: (metres at any time, share of the way, metres per
    ///     second).
    /// speed_m_per_s, turn_rate_rad_per_s, acceleration_m_per_s2: limits that no motion exceeds.
    /// gyro: the gyroscope whose GyroReadings are given, a dict with the keys that `Drive.told` has for it: `bias_rad_per_s` and `scale`, intervals,
    ///     `noise_rad_per_s`, greatest noise of one reading, and `period_s`, over which a reading averages. Further keys may bound what noise and bias
    ///     do over longer times: `angle_floor_rad`, `angle_rad_per_s`, `bias_wander_rad_per_s2`.
    /// devices: for each further device a function from the numbers of its reading to a contractor of x and y, or to None.
    #[new]
    #[pyo3(signature = (room, start, *, track_m, along=(0.002, 0.02, 0.0), aside=(0.002, 0.01, 0.0), speed_m_per_s=0.5,
        turn_rate_rad_per_s=1.0, acceleration_m_per_s2=1.0, gyro=None, devices=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        room: &PyBox,
        start: &PyBox,
        track_m: Given,
        along: (f64, f64, f64),
        aside: (f64, f64, f64),
        speed_m_per_s: f64,
        turn_rate_rad_per_s: f64,
        acceleration_m_per_s2: f64,
        gyro: Option<&Bound<'_, PyDict>>,
        devices: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyLocalizer> {
        let ([x, y], [start_x, start_y, heading]) = (&room.0[..], &start.0[..]) else {
            return Err(PyValueError::new_err("expected a room of 2 intervals and a start of 3"));
        };
        within("room", room)?;
        within("start", start)?;
        let wheels = WheelModel::of_odometry(track(&track_m)?, error_law("along", along)?, error_law("aside", aside)?);
        let reach = Reach {
            speed_m_per_s: limit("speed_m_per_s", speed_m_per_s)?,
            turn_rate_rad_per_s: limit("turn_rate_rad_per_s", turn_rate_rad_per_s)?,
            acceleration_m_per_s2: limit("acceleration_m_per_s2", acceleration_m_per_s2)?,
        };
        let gyro = gyro.map(gyro_model).transpose()?;
        let mut methods: Vec<Box<dyn Method>> = Vec::new();
        for (name, constrain) in devices.into_iter().flatten() {
            // Names of methods last as long as the program, as those of the built-in ones do.
            let name: &'static str = Box::leak(name.extract::<String>()?.into_boxed_str());
            if !constrain.is_callable() {
                let found = constrain.repr()?;
                return Err(PyTypeError::new_err(format!(
                    "devices: {name}: expected a function from a list of numbers to a contractor, found {found}"
                )));
            }
            methods.push(Box::new(Device { name, constrain: constrain.unbind() }));
        }
        let start = PoseBox::new([*start_x, *start_y, *heading]);
        let robot = RobotModel { gyro, ..RobotModel::new(wheels, reach) };
        let localizer = Localizer::new(Map::of_room([*x, *y]), robot, methods, start);
        Ok(PyLocalizer(Mutex::new(localizer)))
    }

    /// Takes in a reading: one of `WheelsReading.of_odometry`, a `GyroReading` or an `OtherReading`. Returns why it was dropped, or None.
    fn observe(&self, py: Python<'_>, reading: &PyReading) -> PyResult<Option<String>> {
        let observed = py.detach(|| self.0.lock().unwrap_or_else(PoisonError::into_inner).observe(&reading.reading));
        raised::after(observed.dropped.map(|dropped| format!("{dropped:?}")))
    }

    /// Where the robot is at a time in seconds, which is not before the newest reading: a union of boxes.
    fn estimate_at(&self, py: Python<'_>, time_s: f64) -> PyResult<PoseUnion> {
        // Contractors may be functions in Python, so that whoever waits for the localizer must not hold Python's lock.
        let estimate = py.detach(|| self.0.lock().unwrap_or_else(PoisonError::into_inner).estimate_at(time_s));
        raised::after(PoseUnion {
            sides: sides(&estimate.pose),
            time_s,
            recovering: estimate.status == Status::Recovering,
            relies_on: estimate.relies_on.iter().map(|name| (*name).to_owned()).collect(),
        })
    }
}
