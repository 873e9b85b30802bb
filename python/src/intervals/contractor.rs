//! Contractors of places x and y.

use std::sync::Arc;

use interval::{
    Interval, IntervalBox,
    contractor::{Contractor, Distance, OnAxes, Outcome, Polar, QRelaxed, Within, settle},
    paving::cover,
};
use numpy::PyArray3;
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
};

use super::{
    interval::Given,
    raised,
    vector::{PyBox, components, plane},
    watched::{Watched, array, resolution},
};

/// A contractor on boxes of x and y that threads may share.
type Shared = Arc<dyn Contractor<2> + Send + Sync>;

/// A contractor: a constraint on x and y, which makes boxes smaller and never loses a solution. `&` is for both of two constraints, `|` for one or
/// the other.
///
/// Ctc(function) is a contractor of one's own, for which one derives from `Ctc` in Codac: the function is called with an IntervalVector of x and y, and
/// returns the smaller IntervalVector that it leaves of it. It must never lose a place that satisfies its constraint; what it returns outside of the box
/// that it was given counts for nothing.
#[pyclass(module = "wherein", frozen, from_py_object)]
#[derive(Clone)]
pub(crate) struct Ctc {
    pub(crate) contractor: Kept,
}

/// A contractor that is shared.
#[derive(Clone)]
pub(crate) struct Kept(Shared);

impl Contractor<2> for Kept {
    fn contract(&self, domain: &mut IntervalBox<2>) -> Outcome {
        self.0.contract(domain)
    }

    fn branches(&self, domain: &IntervalBox<2>) -> Vec<IntervalBox<2>> {
        self.0.branches(domain)
    }
}

impl Ctc {
    fn of(contractor: impl Contractor<2> + Send + Sync + 'static) -> Ctc {
        Ctc { contractor: Kept(Arc::new(contractor)) }
    }
}

#[pymethods]
impl Ctc {
    #[new]
    fn new(function: Bound<'_, PyAny>) -> PyResult<Ctc> {
        if function.is_callable() {
            Ok(Ctc::of(Own { function: function.unbind() }))
        } else {
            let found = function.repr()?;
            Err(PyTypeError::new_err(format!(
                "expected a function from an IntervalVector to an IntervalVector, found {found}"
            )))
        }
    }

    /// The part of a box of x and y that the constraint leaves: a smaller box, empty where the constraint has no solution in it.
    fn contract(&self, domain: &PyBox) -> PyResult<PyBox> {
        let mut left = plane(domain)?;
        self.contractor.contract(&mut left);
        raised::after(PyBox(left.components().to_vec()))
    }

    fn __and__(&self, other: &Ctc) -> Ctc {
        Ctc::of(self.contractor.clone().then(other.contractor.clone()).fixpoint(0.01))
    }

    fn __or__(&self, other: &Ctc) -> Ctc {
        Ctc::of(self.contractor.clone().union(other.contractor.clone()))
    }

    /// Covers the solutions in a box by boxes of which no side is wider than `eps`: an array of shape (n, 2, 2), least and greatest x and y of each.
    fn pave<'py>(&self, py: Python<'py>, domain: &PyBox, eps: f64) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let domain = plane(domain)?;
        let eps = resolution(eps)?;
        let boxes = py.detach(|| cover(&Watched::new(&self.contractor), domain, &[0, 1], eps));
        Ok(array(py, &raised::after(boxes)?))
    }
}

/// A point at a distance in `range` from `centre`.
#[pyfunction(name = "CtcDist")]
pub(crate) fn ctc_dist(centre: (Given, Given), range: Given) -> PyResult<Ctc> {
    let centre = [centre.0.interval()?, centre.1.interval()?];
    Ok(Ctc::of(Distance { centre, distance: range.interval()? }))
}

/// A point at a distance in `range` and in a direction in `bearing` (rad, counter-clockwise from x) from `centre`.
#[pyfunction(name = "CtcPolar")]
pub(crate) fn ctc_polar(centre: (Given, Given), range: Given, bearing: Given) -> PyResult<Ctc> {
    let (centre, polar) = ([centre.0.interval()?, centre.1.interval()?], [range.interval()?, bearing.interval()?]);
    Ok(Ctc::of(Seen { centre, polar }))
}

/// Points of all constraints but at most `q`, whichever these are: the intersection that allows for outliers.
#[pyfunction(name = "CtcQInter")]
pub(crate) fn ctc_q_inter(contractors: Vec<Ctc>, q: usize) -> Ctc {
    let contractors = contractors.into_iter().map(|one| Box::new(one.contractor) as Box<_>).collect();
    Ctc::of(QRelaxed { contractors, q })
}

/// Points of all constraints, as by `&`.
#[pyfunction(name = "CtcInter")]
pub(crate) fn ctc_inter(contractors: Vec<Ctc>) -> PyResult<Ctc> {
    joined(contractors, Ctc::__and__)
}

/// Points of at least one constraint, as by `|`.
#[pyfunction(name = "CtcUnion")]
pub(crate) fn ctc_union(contractors: Vec<Ctc>) -> PyResult<Ctc> {
    joined(contractors, Ctc::__or__)
}

fn joined(contractors: Vec<Ctc>, join: impl Fn(&Ctc, &Ctc) -> Ctc) -> PyResult<Ctc> {
    let all = contractors.into_iter().reduce(|one, other| join(&one, &other));
    all.ok_or_else(|| PyValueError::new_err("contractors: expected at least one, found none"))
}

/// Points of a box.
#[pyfunction(name = "CtcBox")]
pub(crate) fn ctc_box(inside: &PyBox) -> PyResult<Ctc> {
    Ok(Ctc::of(Within(plane(inside)?)))
}

/// A place in polar coordinates around a centre.
struct Seen {
    centre: [Interval; 2],
    polar: [Interval; 2],
}

impl Contractor<2> for Seen {
    fn contract(&self, domain: &mut IntervalBox<2>) -> Outcome {
        let across = [0, 1].map(|axis| domain[axis] - self.centre[axis]);
        let mut all = IntervalBox::new([across[0], across[1], self.polar[0], self.polar[1]]);
        let outcome = Polar.contract(&mut all);
        let left = [0, 1].map(|axis| domain[axis].intersect(all[axis] + self.centre[axis]));
        *domain = IntervalBox::new(left);
        match domain.is_empty() {
            true => Outcome::Empty("no place of the box is seen so"),
            false => outcome,
        }
    }
}

/// A constraint that is a function in Python.
struct Own {
    function: Py<PyAny>,
}

impl Own {
    fn left_of(&self, domain: &IntervalBox<2>) -> PyResult<IntervalBox<2>> {
        Python::attach(|py| {
            let left = self.function.bind(py).call1((PyBox(domain.components().to_vec()),))?;
            let components = components(&left).map_err(|_| {
                PyTypeError::new_err(format!(
                    "expected an IntervalVector from the function of a contractor, found {left}"
                ))
            })?;
            plane(&PyBox(components))
        })
    }
}

impl Contractor<2> for Own {
    fn contract(&self, domain: &mut IntervalBox<2>) -> Outcome {
        // After an exception the whole computation is void, and the domain as it is loses no solution.
        if domain.is_empty() || raised::is_raised() {
            return settle(domain, *domain, "the domain is empty");
        }
        match self.left_of(domain) {
            Ok(left) => settle(domain, domain.intersect(&left), "the function of a contractor leaves no place"),
            Err(error) => {
                raised::keep(error);
                Outcome::Feasible
            }
        }
    }
}

/// A contractor of poses by one of x and y.
pub(crate) fn on_pose(contractor: Ctc) -> OnAxes<Kept, 2> {
    contractor.contractor.on_axes([0, 1])
}
