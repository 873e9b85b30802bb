//! Long work that a user may interrupt: in a thread of its own, with a flag that asks it to stop.

use std::{
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{RecvTimeoutError, channel},
    },
    thread,
    time::Duration,
};

use pyo3::{exceptions::PyKeyboardInterrupt, prelude::*};
use sim::campaign::sweep::SweepError;

use crate::errors::{self, WhereinError};

/// Time between two looks at whether the user has interrupted the program.
pub(crate) const LOOK_PERIOD: Duration = Duration::from_millis(100);

/// Asks long work to stop, and keeps the exception because of which it was asked.
#[derive(Clone, Default)]
pub(crate) struct Stop {
    is_set: Arc<AtomicBool>,
    because: Arc<Mutex<Option<PyErr>>>,
}

impl Stop {
    pub(crate) fn is_set(&self) -> bool {
        self.is_set.load(Ordering::Relaxed)
    }

    /// The flag itself, for work that knows nothing of Python.
    pub(crate) fn flag(&self) -> &Arc<AtomicBool> {
        &self.is_set
    }

    /// Asks the work to stop because of an exception, which then reaches whoever asked for the work. Of several the first one counts.
    pub(crate) fn stop_because(&self, error: PyErr) {
        self.because.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        self.is_set.store(true, Ordering::Relaxed);
    }

    fn reason(&self) -> Option<PyErr> {
        self.because.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Works in a thread of its own without Python's lock, and looks now and then whether the user has interrupted the program. Work that is stopped
/// returns `None`. Its thread has ended before the interrupt leaves this function: a thread that calls Python while Python ends would take the
/// whole program down. Only a second interrupt does not wait for that.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    stop: &Stop,
    work: impl FnOnce() -> Result<Option<T>, SweepError> + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = channel();
    let worker = thread::spawn(move || sender.send(work()));
    let receiver = Mutex::new(receiver);
    let outcome = loop {
        match py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK_PERIOD)) {
            Err(RecvTimeoutError::Timeout) => {
                if let Err(interrupt) = py.check_signals() {
                    if stop.is_set() {
                        return Err(interrupt);
                    }
                    stop.stop_because(interrupt);
                }
            }
            outcome => break outcome,
        }
    };
    // The panic of a thread is told below, where nothing was received of it.
    let _ = py.detach(|| worker.join());
    if let Some(error) = stop.reason() {
        return Err(error);
    }
    match outcome {
        Ok(outcome) => {
            outcome.map_err(|error| errors::of_sweep(&error))?.ok_or_else(|| PyKeyboardInterrupt::new_err(()))
        }
        Err(_) => Err(WhereinError::new_err("the simulation panicked; its message is above")),
    }
}
