//! Drives step by step: the closed loop of a run in a thread of its own, which hands its readings to a loop in Python and waits for each answer.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread::{self, JoinHandle},
    time::Duration,
};

use numpy::{PyArray2, ndarray::Array2};
use pyo3::{exceptions::PyRuntimeError, prelude::*, types::PyList};
use sim::{
    artefacts::run_files,
    judge::{Verdict, judge},
    loading::SceneFile,
    render::{RenderError, Renderer},
    run::{FramesPolicy, RunOptions, RunRecord, run},
    subject::{Answer, AnswerKind, ForeignAnswer, Step, Steps, stepped},
};

use crate::{
    answers,
    asked::{frames_policy, scene_file},
    cues,
    errors::{self, AnswerError},
    reading,
    result::DriveResult,
    stop::LOOK_PERIOD,
};

type Done = Result<(RunRecord, Verdict), RenderError>;

/// One drive of a scene, which a loop answers step by step:
///
///     for step in wherein.Drive("scenes/home.toml", seed=3):
///         for reading in step.readings:
///             ...
///         step.answer(mean, covariance)
///
/// Every 10 ms of simulated time is a step. The robot's driver steers by the answers, unless the scene drives by other means. The truth can be had
/// only after the drive, from `result`.
///
/// As a `with` block the drive ends where the block ends. A drive that is left early, by `break` or by an exception, has no result and writes no file.
#[pyclass(module = "wherein", frozen)]
pub(crate) struct Drive {
    file: Arc<SceneFile>,
    seed: u64,
    out: Option<PathBuf>,
    state: Mutex<State>,
}

/// An answer, and the stamp of the newest reading that it takes into account, if the loop tells it.
type Told = (ForeignAnswer, Option<f64>);

/// Where a drive stands.
enum State {
    /// The renderer waits for the first step.
    Ready {
        renderer: Option<Box<Renderer>>,
        options: RunOptions,
        name: String,
    },
    Driving(Driving),
    Done(Arc<DriveResult>),
    /// It was left before its end.
    Left,
}

struct Driving {
    steps: Steps,
    thread: JoinHandle<Done>,
    /// Time of the step that is being answered, with the answer.
    open: Option<(f64, Option<Told>)>,
    /// Kind of the answers so far.
    kind: Option<AnswerKind>,
}

#[pymethods]
impl Drive {
    /// Loads a scene and opens the graphics adapter if the robot has cameras. The drive begins with the first step.
    ///
    /// scene: path of the scene's file.
    /// seed: everything that is drawn at random follows from it.
    /// set: keys of the scene to set to other values, such as {"duration_s": 30}.
    /// name: what results call the localizer under test.
    /// out: folder into which the end of the drive writes the files that `wherein run` writes, in OUT/<scene>/<seed>/.
    /// frames: images for which debug frames are kept for `out`: "none", "failures", "every=N" or "all".
    /// adapter: graphics adapter, by a part of its name.
    #[new]
    #[pyo3(signature = (scene, seed=0, *, set=None, name="python".to_owned(), out=None, frames="none", adapter=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        scene: PathBuf,
        seed: u64,
        set: Option<&Bound<'_, PyAny>>,
        name: String,
        out: Option<PathBuf>,
        frames: &str,
        adapter: Option<String>,
    ) -> PyResult<Drive> {
        let file = scene_file(&scene, set)?;
        let keep_images: FramesPolicy = frames_policy(frames)?;
        if let Some(out) = &out {
            run_files::prepare(out).map_err(|error| errors::of_record(&error))?;
        }
        let has_camera = file.scene.has_camera();
        let open = || has_camera.then(|| Renderer::on_adapter(adapter.as_deref())).transpose();
        let renderer = py.detach(open).map_err(|error| errors::of_render(&error))?.map(Box::new);
        let state = State::Ready { renderer, options: RunOptions { keep_images, baselines: false }, name };
        Ok(Drive { file: Arc::new(file), seed, out, state: Mutex::new(state) })
    }

    /// Seed of the drive.
    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }

    /// Name of the scene.
    #[getter]
    fn scene(&self) -> &str {
        &self.file.name
    }

    /// Longest simulated time of the drive in seconds.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.file.scene.simulated_s()
    }

    /// What a localizer is told beforehand: a dict of `map` and `robot`, with the keys of the page "A localizer in any language", and of `cues`, new
    /// Cues for the drive. Intervals are lists of their least and greatest value.
    #[getter]
    fn told(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        cues::told_with_cues(py, &self.file.scene)
    }

    /// Box of poses in which the drive starts: an array of shape (3, 2), the least and greatest x (m), y (m) and heading (rad).
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let start = self.file.scene.start_box();
        let side = |(axis, end): (usize, usize)| if end == 0 { start[axis].lo() } else { start[axis].hi() };
        PyArray2::from_owned_array(py, Array2::from_shape_fn((3, 2), side))
    }

    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    /// Hands over the answer to the step before, and waits for the next step.
    fn __next__(slf: &Bound<'_, Self>) -> PyResult<Option<PyStep>> {
        let py = slf.py();
        let this = slf.get();
        this.begin();
        if let Err(error) = this.hand_over() {
            this.leave(py);
            return Err(error);
        }
        let step = loop {
            match py.detach(|| this.next_within(LOOK_PERIOD)) {
                Some(step) => break step?,
                None => {
                    if let Err(interrupt) = py.check_signals() {
                        this.leave(py);
                        return Err(interrupt);
                    }
                }
            }
        };
        match step {
            Some(step) => Ok(Some(PyStep::of(slf, step)?)),
            None => {
                this.conclude(py)?;
                Ok(None)
            }
        }
    }

    fn __enter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, pyo3::types::PyTuple>) {
        self.leave(py);
    }

    /// Ends the drive where it stands, if it has not ended. It then has no result and writes no file.
    fn close(&self, py: Python<'_>) {
        self.leave(py);
    }

    /// Whether the drive has come to its end, so that `result` can be had.
    #[getter]
    fn is_done(&self) -> bool {
        matches!(&*self.locked(), State::Done(_))
    }

    /// Verdict, truth, answers and figures of the drive. Raises WhereinError before its end, because the truth comes only after the drive.
    #[getter]
    fn result(&self) -> PyResult<DriveResult> {
        match &*self.locked() {
            State::Done(result) => Ok(DriveResult::clone(result)),
            State::Left => {
                Err(errors::WhereinError::new_err("the drive was left before its end, so that it has no result"))
            }
            State::Ready { .. } | State::Driving(_) => Err(errors::WhereinError::new_err(
                "the drive has not ended: its result, with the truth, comes after the last step",
            )),
        }
    }

    fn _repr_png_(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        match &*self.locked() {
            State::Done(result) => Ok(Some(result.png(py)?)),
            _ => Ok(None),
        }
    }

    fn __repr__(&self) -> String {
        let stands = match &*self.locked() {
            State::Ready { .. } => "not begun",
            State::Driving(_) => "driving",
            State::Done(_) => "done",
            State::Left => "left",
        };
        format!("<Drive of {} seed {}: {stands}>", self.file.name, self.seed)
    }
}

impl Drive {
    pub(crate) fn file(&self) -> &SceneFile {
        &self.file
    }

    fn locked(&self) -> MutexGuard<'_, State> {
        // Each change of the state is one assignment, so that a panic leaves it whole.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts the thread of the drive, if it is not started.
    fn begin(&self) {
        let mut state = self.locked();
        let State::Ready { renderer, options, name } = &mut *state else { return };
        let (mut renderer, options, name) = (renderer.take(), *options, std::mem::take(name));
        let (mut subject, steps) = stepped(name);
        let (file, seed) = (Arc::clone(&self.file), self.seed);
        let thread = thread::spawn(move || {
            let record = run(&file.scene, seed, &mut subject, renderer.as_deref_mut(), &options, &mut |_| {})?;
            drop(subject);
            // A loop cannot be run again. A record without steps says that no change explains a loss of the truth.
            let verdict = judge(&file.scene, &record, &mut |_| {
                Ok(RunRecord::new(seed, record.adapter.clone(), record.drawn.clone()))
            })?;
            Ok((record, verdict))
        });
        *state = State::Driving(Driving { steps, thread, open: None, kind: None });
    }

    /// Refuses an answer of another kind than those before.
    fn hold_to_kind(&self, answer: &Answer, time_s: f64) -> PyResult<()> {
        let mut state = self.locked();
        let State::Driving(driving) = &mut *state else { return Ok(()) };
        AnswerKind::hold(&mut driving.kind, answer)
            .map_err(|reason| AnswerError::new_err(format!("the step at {time_s:.2} s was answered with {reason}")))
    }

    /// Hands the answer to the open step over.
    fn hand_over(&self) -> PyResult<()> {
        let mut state = self.locked();
        let State::Driving(driving) = &mut *state else { return Ok(()) };
        let Some((time_s, answer)) = driving.open.take() else { return Ok(()) };
        let expected = "expected step.answer(mean, covariance), or one of its like, before the next step";
        let (answer, newest_s) = answer
            .ok_or_else(|| AnswerError::new_err(format!("the step at {time_s:.2} s was not answered: {expected}")))?;
        driving.steps.answer(answers::checked(answer, time_s)?, newest_s);
        Ok(())
    }

    /// Waits for the next step: `None` where the limit has passed before, and `Some(Ok(None))` where the drive has ended.
    fn next_within(&self, limit: Duration) -> Option<PyResult<Option<Step>>> {
        let mut state = self.locked();
        match &mut *state {
            State::Driving(driving) => {
                let step = driving.steps.next_within(limit).ok()?;
                driving.open = step.as_ref().map(|step| (step.time_s, None));
                Some(Ok(step))
            }
            State::Done(_) => Some(Ok(None)),
            State::Ready { .. } | State::Left => {
                Some(Err(PyRuntimeError::new_err("the drive was left, expected a new Drive for another one")))
            }
        }
    }

    /// Keeps the answer to a step until the next step is asked for.
    fn answer(&self, time_s: f64, answer: Told) -> PyResult<()> {
        let mut state = self.locked();
        match &mut *state {
            State::Driving(Driving { open: Some((open_s, kept)), .. }) if *open_s == time_s => {
                *kept = Some(answer);
                Ok(())
            }
            _ => Err(AnswerError::new_err(format!(
                "the step at {time_s:.2} s is over, expected an answer before the next step"
            ))),
        }
    }

    /// Takes the result of the drive that has ended, and writes its files if they are wanted.
    fn conclude(&self, py: Python<'_>) -> PyResult<()> {
        let driving = {
            let mut state = self.locked();
            if !matches!(&*state, State::Driving(_)) {
                return Ok(());
            }
            // The state is not locked while Python's lock is let go and taken again.
            std::mem::replace(&mut *state, State::Left)
        };
        let State::Driving(driving) = driving else { return Ok(()) };
        let joined = py.detach(|| driving.thread.join());
        let done = joined.map_err(|_| PyRuntimeError::new_err("the simulation panicked; its message is above"))?;
        let (record, verdict) = done.map_err(|error| errors::of_render(&error))?;
        let result = DriveResult::new(Arc::clone(&self.file), record, verdict);
        if let Some(out) = &self.out {
            py.detach(|| result.write(out)).map_err(|error| errors::of_record(&error))?;
        }
        *self.locked() = State::Done(Arc::new(result));
        Ok(())
    }

    /// Ends the drive where it stands, unless it has ended.
    fn leave(&self, py: Python<'_>) {
        py.detach(|| self.end_early());
    }

    fn end_early(&self) {
        let mut state = self.locked();
        if matches!(&*state, State::Done(_)) {
            return;
        }
        if let State::Driving(Driving { steps, thread, .. }) = std::mem::replace(&mut *state, State::Left) {
            // Without its other side the run ends with its next question. What it then returns is of a drive that nobody wants.
            drop(steps);
            let _ = thread.join();
        }
    }
}

impl Drop for Drive {
    fn drop(&mut self) {
        self.end_early();
    }
}

/// One step of a drive: the readings that have arrived since the step before, and the question where the robot is.
#[pyclass(name = "Step", module = "wherein", frozen)]
pub(crate) struct PyStep {
    drive: Py<Drive>,
    /// Time in seconds since the start of the drive for which to answer.
    #[pyo3(get)]
    time_s: f64,
    /// Readings that have arrived since the step before, in the order of their arrival.
    #[pyo3(get)]
    readings: Py<PyList>,
    /// Box of poses in which a drive starts with this step, an array of shape (3, 2) as `Drive.start`, or None. Every station of a scene with stations
    /// is a start, with which times begin at 0 again.
    #[pyo3(get)]
    start: Option<Py<PyArray2<f64>>>,
}

impl PyStep {
    fn of(drive: &Bound<'_, Drive>, step: Step) -> PyResult<PyStep> {
        let py = drive.py();
        let readings: Vec<Py<PyAny>> =
            step.readings.into_iter().map(|one| reading::to_python(py, one)).collect::<PyResult<_>>()?;
        let start = step.start.map(|start| {
            let side = |(axis, end): (usize, usize)| if end == 0 { start[axis].lo() } else { start[axis].hi() };
            PyArray2::from_owned_array(py, Array2::from_shape_fn((3, 2), side)).unbind()
        });
        let readings = PyList::new(py, readings)?.unbind();
        Ok(PyStep { drive: drive.clone().unbind(), time_s: step.time_s, readings, start })
    }
}

#[pymethods]
impl PyStep {
    /// Answers the step by a Gaussian distribution of the pose, or without a covariance by a single pose. A later answer to the step replaces it.
    ///
    /// mean: x (m), y (m) and heading (rad), an array of shape (3,). Headings may be wrapped to one turn.
    /// covariance: an array of shape (3, 3), in m², m·rad and rad².
    /// newest_s: stamp of the newest reading that the answer takes into account, from which results count the age of the answer.
    #[pyo3(signature = (mean, covariance=None, *, newest_s=None))]
    fn answer(
        &self,
        py: Python<'_>,
        mean: &Bound<'_, PyAny>,
        covariance: Option<&Bound<'_, PyAny>>,
        newest_s: Option<f64>,
    ) -> PyResult<()> {
        let answer = answers::gaussian(mean, covariance)?;
        self.take(py, answer, newest_s)
    }

    /// Answers the step by a weighted sample of poses, as a particle filter has it.
    ///
    /// poses: an array of shape (n, 3), each x (m), y (m) and heading (rad).
    /// weights: an array of shape (n,), at least 0 each; without it all weigh the same.
    /// newest_s: as for `answer`.
    #[pyo3(signature = (poses, weights=None, *, newest_s=None))]
    fn answer_samples(
        &self,
        py: Python<'_>,
        poses: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
        newest_s: Option<f64>,
    ) -> PyResult<()> {
        let answer = answers::samples(poses, weights)?;
        self.take(py, answer, newest_s)
    }

    /// Answers the step by a union of boxes of which one surely holds the pose.
    ///
    /// boxes: an array of shape (n, 3, 2) or (3, 2), the least and greatest x (m), y (m) and heading (rad); or a PoseUnion.
    /// recovering: whether an assumption is doubted.
    /// relies_on: names of the declared bounds that the boxes rely on; without it they rely on all.
    /// newest_s: as for `answer`.
    #[pyo3(signature = (boxes, *, recovering=false, relies_on=None, newest_s=None))]
    fn answer_boxes(
        &self,
        py: Python<'_>,
        boxes: &Bound<'_, PyAny>,
        recovering: bool,
        relies_on: Option<Vec<String>>,
        newest_s: Option<f64>,
    ) -> PyResult<()> {
        let answer = answers::boxes(boxes, recovering, relies_on)?;
        self.take(py, answer, newest_s)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<Step at {:.2} s with {} readings>", self.time_s, self.readings.bind(py).len())
    }
}

impl PyStep {
    fn take(&self, py: Python<'_>, answer: ForeignAnswer, newest_s: Option<f64>) -> PyResult<()> {
        // An answer is checked when it is given, so that the mistake is shown where it is made.
        let checked = answers::checked(answer.clone(), self.time_s)?;
        let newest_s = answers::newest(newest_s, self.time_s)?;
        self.drive.bind(py).get().hold_to_kind(&checked, self.time_s)?;
        self.drive.bind(py).get().answer(self.time_s, (answer, newest_s))
    }
}
