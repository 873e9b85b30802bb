//! A localizer that is an object in Python, whose methods a run calls: `start`, `observe` and `answer`.

use std::{
    cell::{Cell, OnceCell, RefCell},
    sync::Arc,
};

use ::localizer::{Pose, PoseBox, Reading};
use numpy::{PyArray2, ndarray::Array2};
use pyo3::{
    exceptions::{PyException, PyValueError},
    prelude::*,
};
use sim::{
    scene::Scene,
    subject::{Added, Answer, Failure, GivenReading, Subject, SubjectChoice, device, turned_to},
};

use crate::{answers, cues, reading, stop::Stop};

/// A localizer in Python as the subject of a run. An exception in one of its methods is its failure, which ends the run. An exception that is no error
/// of a program, such as KeyboardInterrupt, ends all runs instead.
pub(crate) struct Called {
    name: String,
    object: Option<Py<PyAny>>,
    given: (usize, Option<GivenReading>),
    failure: OnceCell<Failure>,
    /// What Python says of the failure, line by line.
    log: OnceCell<String>,
    latest: RefCell<Option<(f64, Answer)>>,
    heading_rad: RefCell<f64>,
    newest_s: Cell<Option<f64>>,
    stop: Stop,
}

impl Called {
    /// Makes the localizer by calling `make` with what it is told.
    pub(crate) fn new(make: &Arc<Py<PyAny>>, name: &str, scene: &Scene, stop: &Stop) -> Called {
        let mut called = Called {
            name: name.to_owned(),
            object: None,
            given: (0, None),
            failure: OnceCell::new(),
            log: OnceCell::new(),
            latest: RefCell::new(None),
            heading_rad: RefCell::new(0.0),
            newest_s: Cell::new(None),
            stop: stop.clone(),
        };
        let made = Python::attach(|py| make.bind(py).call1((cues::told_with_cues(py, scene)?,)).map(Bound::unbind));
        match made {
            Ok(object) => called.object = Some(object),
            Err(error) => called.fail(0.0, &error),
        }
        called
    }

    fn fail(&self, time_s: f64, error: &PyErr) {
        let (reason, log) = Python::attach(|py| {
            if !error.is_instance_of::<PyException>(py) {
                self.stop.stop_because(error.clone_ref(py));
            }
            let trace = error.traceback(py).and_then(|trace| trace.format().ok()).unwrap_or_default();
            (error.to_string(), format!("{trace}{error}\n"))
        });
        self.failure.get_or_init(|| Failure { time_s, reading: self.given.1.clone(), reason });
        self.log.get_or_init(|| log);
    }

    /// Calls a method of the localizer, if it has it and has not failed.
    fn call(&self, time_s: f64, call: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>) {
        let Some(object) = self.object.as_ref().filter(|_| self.failure.get().is_none()) else { return };
        if let Err(error) = Python::attach(|py| call(object.bind(py))) {
            self.fail(time_s, &error);
        }
    }
}

impl Subject for Called {
    fn name(&self) -> &str {
        &self.name
    }

    fn is_elsewhere(&self) -> bool {
        true
    }

    fn start(&mut self, start: &PoseBox) {
        (*self.latest.get_mut(), *self.heading_rad.get_mut()) = (None, start[2].mid());
        self.call(0.0, |object| {
            let side = |(axis, end): (usize, usize)| if end == 0 { start[axis].lo() } else { start[axis].hi() };
            let sides = PyArray2::from_owned_array(object.py(), Array2::from_shape_fn((3, 2), side));
            object.call_method1("start", (sides,)).map(drop)
        });
    }

    fn observe(&mut self, reading: &Reading) {
        let (number, measured_s, arrived_s) = (self.given.0 + 1, reading.measured_s(), reading.arrived_s());
        let device = device(reading).to_owned();
        self.given = (number, Some(GivenReading { number, device, measured_s, arrived_s }));
        *self.latest.get_mut() = None;
        self.call(arrived_s, |object| {
            let reading = reading::to_python(object.py(), reading.clone())?;
            object.call_method1("observe", (reading,)).map(drop)
        });
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        if let Some((at_s, answer)) = &*self.latest.borrow()
            && *at_s == time_s
        {
            return answer.clone();
        }
        let mut found = Answer::Point(Pose::default());
        self.call(time_s, |object| {
            let (given, newest_s) = answers::returned(&object.call_method1("answer", (time_s,))?)?;
            found = turned_to(answers::checked(given, time_s)?, *self.heading_rad.borrow());
            self.newest_s.set(answers::newest(newest_s, time_s)?);
            Ok(())
        });
        let middle_rad = match &found {
            Answer::Boxes(estimate) => estimate.pose.hull()[2].mid(),
            Answer::Point(pose) => pose.heading_rad,
            Answer::Gaussian(gaussian) => gaussian.mean.heading_rad,
            _ => *self.heading_rad.borrow(),
        };
        if middle_rad.is_finite() {
            *self.heading_rad.borrow_mut() = middle_rad;
        }
        *self.latest.borrow_mut() = Some((time_s, found.clone()));
        found
    }

    fn knows_until_s(&self) -> Option<f64> {
        self.newest_s.get()
    }

    fn failure(&self) -> Option<&Failure> {
        self.failure.get()
    }

    fn end(&mut self) -> Option<String> {
        self.log.get().cloned()
    }
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
