//! Separators of places x and y, and the pavings that they make.

use std::sync::Arc;

use interval::{IntervalBox, contractor::ForwardBackward, paving::Paving, separator::Separator};
use numpy::PyArray3;
use pyo3::prelude::*;

use super::{
    interval::Given,
    raised,
    vector::{PyBox, plane},
    watched::{Watched, array, resolution},
};

/// A separator: a set of places (x, y) that tells boxes inside from boxes outside. `&`, `|` and `~` are intersection, union and complement.
#[pyclass(module = "wherein", frozen, from_py_object)]
#[derive(Clone)]
pub(crate) struct Sep(Arc<dyn Separator<2> + Send + Sync>);

impl Separator<2> for Sep {
    fn separate(&self, domain: &IntervalBox<2>) -> (IntervalBox<2>, IntervalBox<2>) {
        self.0.separate(domain)
    }
}

#[pymethods]
impl Sep {
    fn __and__(&self, other: &Sep) -> Sep {
        Sep(Arc::new(self.clone().and(other.clone())))
    }

    fn __or__(&self, other: &Sep) -> Sep {
        Sep(Arc::new(self.clone().or(other.clone())))
    }

    fn __invert__(&self) -> Sep {
        Sep(Arc::new(self.clone().complement()))
    }

    /// The part of a box that may be in the set, and the part that may be outside of it.
    fn separate(&self, domain: &PyBox) -> PyResult<(PyBox, PyBox)> {
        let (inside, outside) = self.0.separate(&plane(domain)?);
        Ok((PyBox(inside.components().to_vec()), PyBox(outside.components().to_vec())))
    }
}

/// Places at a distance in `range` from `centre`.
#[pyfunction(name = "SepDist")]
pub(crate) fn sep_dist(centre: (f64, f64), range: Given) -> PyResult<Sep> {
    Ok(Sep(Arc::new(ForwardBackward::new(|[x, y]| (x - centre.0).hypot(y - centre.1), range.interval()?))))
}

/// Boxes of a paving: `inner` surely in the set, `outer` surely not, `boundary` undecided, each an array of shape (n, 2, 2).
type Paved<'py> = (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>);

/// Paves a set by SIVIA: returns boxes that are surely inside, boxes that are surely outside, and undecided boxes of which no side is wider than `eps`,
/// each an array of shape (n, 2, 2), the least and greatest x and y of each box.
#[pyfunction]
pub(crate) fn sivia<'py>(py: Python<'py>, domain: &PyBox, set: &Sep, eps: f64) -> PyResult<Paved<'py>> {
    let domain = plane(domain)?;
    let eps = resolution(eps)?;
    let paving = py.detach(|| Paving::new(&Watched::new(set), domain, &[0, 1], eps));
    let paving = raised::after(paving)?;
    Ok((array(py, &paving.inner), array(py, &paving.outer), array(py, &paving.boundary)))
}
