//! Exceptions that a computation in Rust cannot hand on: kept until the computation has ended, which is by then void.

use std::cell::RefCell;

use pyo3::prelude::*;

thread_local! {
    /// The first exception of the computation that this thread is at.
    static RAISED: RefCell<Option<PyErr>> = const { RefCell::new(None) };
}

/// Keeps an exception for the end of the computation. Of several the first one counts.
pub(crate) fn keep(error: PyErr) {
    RAISED.with_borrow_mut(|raised| {
        raised.get_or_insert(error);
    });
}

pub(crate) fn is_raised() -> bool {
    RAISED.with_borrow(Option::is_some)
}

/// What a computation has found, unless an exception was kept meanwhile.
pub(crate) fn after<T>(found: T) -> PyResult<T> {
    match RAISED.take() {
        Some(error) => Err(error),
        None => Ok(found),
    }
}
