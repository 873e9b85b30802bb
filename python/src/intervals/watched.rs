//! Pavings that a user may interrupt.

use std::cell::Cell;

use interval::{
    IntervalBox,
    contractor::{Contractor, Outcome},
    separator::Separator,
};
use numpy::{PyArray3, ndarray::Array3};
use pyo3::{exceptions::PyValueError, prelude::*};

use super::raised;

/// Number of boxes between two looks at whether the user has interrupted the program. A box takes a microsecond, and with many constraints a hundred.
const BOXES_BETWEEN_LOOKS: u32 = 1024;

/// A contractor or a separator that leaves nothing undecided any more once the user has interrupted the program or a function in Python has raised an
/// exception, so that a paving ends soon. The paving is then void.
pub(super) struct Watched<'a, Of> {
    of: &'a Of,
    n_boxes: Cell<u32>,
}

impl<Of> Watched<'_, Of> {
    pub(super) fn new(of: &Of) -> Watched<'_, Of> {
        Watched { of, n_boxes: Cell::new(0) }
    }

    fn is_ended(&self) -> bool {
        self.n_boxes.set((self.n_boxes.get() + 1) % BOXES_BETWEEN_LOOKS);
        if self.n_boxes.get() == 0
            && let Err(interrupt) = Python::attach(|py| py.check_signals())
        {
            raised::keep(interrupt);
        }
        raised::is_raised()
    }
}

impl<Of: Contractor<2>> Contractor<2> for Watched<'_, Of> {
    fn contract(&self, domain: &mut IntervalBox<2>) -> Outcome {
        if self.is_ended() {
            *domain = IntervalBox::EMPTY;
            return Outcome::Empty("interrupted");
        }
        self.of.contract(domain)
    }
}

impl<Of: Separator<2>> Separator<2> for Watched<'_, Of> {
    fn separate(&self, domain: &IntervalBox<2>) -> (IntervalBox<2>, IntervalBox<2>) {
        if self.is_ended() {
            return (IntervalBox::EMPTY, IntervalBox::EMPTY);
        }
        self.of.separate(domain)
    }
}

/// The width down to which boxes are bisected.
pub(super) fn resolution(eps: f64) -> PyResult<f64> {
    if eps > 0.0 { Ok(eps) } else { Err(PyValueError::new_err(format!("eps: expected more than 0, found {eps}"))) }
}

/// Least and greatest x and y of each box, as an array of shape (n, 2, 2).
pub(super) fn array<'py>(py: Python<'py>, boxes: &[IntervalBox<2>]) -> Bound<'py, PyArray3<f64>> {
    let entry = |(index, axis, end): (usize, usize, usize)| match end {
        0 => boxes[index][axis].lo(),
        _ => boxes[index][axis].hi(),
    };
    PyArray3::from_owned_array(py, Array3::from_shape_fn((boxes.len(), 2, 2), entry))
}
