//! Interval analysis: intervals, boxes, contractors, separators and pavings. Names are those of the field, as Codac has them.

use std::sync::Arc;

use interval::{
    Interval, IntervalBox,
    contractor::{Contractor, Distance, ForwardBackward, OnAxes, Outcome, Polar, QRelaxed, Within},
    paving::{Paving, cover},
    separator::Separator,
};
use numpy::{PyArray3, ndarray::Array3};
use pyo3::{exceptions::PyValueError, prelude::*};

/// An interval: all real numbers from a lower to an upper bound. Results of operations hold every result on members; rounding is outward.
#[pyclass(name = "Interval", module = "wherein", frozen, from_py_object)]
#[derive(Clone, Copy)]
pub(crate) struct PyInterval(pub(crate) Interval);

/// An interval, or a number, which stands for itself, or a pair of bounds.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Interval(PyInterval),
    Number(f64),
    Pair([f64; 2]),
}

impl Given {
    pub(crate) fn interval(&self) -> PyResult<Interval> {
        match self {
            Given::Interval(PyInterval(interval)) => Ok(*interval),
            Given::Number(value) => between(*value, *value),
            Given::Pair([low, high]) => between(*low, *high),
        }
    }
}

fn between(low: f64, high: f64) -> PyResult<Interval> {
    if low <= high {
        Ok(Interval::new(low, high))
    } else {
        Err(PyValueError::new_err(format!(
            "expected a lower bound that is not above the upper one, found {low} and {high}"
        )))
    }
}

#[pymethods]
impl PyInterval {
    /// Interval(lower, upper), or Interval(value) for one number.
    #[new]
    #[pyo3(signature = (lower, upper=None))]
    fn new(lower: f64, upper: Option<f64>) -> PyResult<PyInterval> {
        between(lower, upper.unwrap_or(lower)).map(PyInterval)
    }

    /// The interval of the numbers that are at most `radius` from `middle`.
    #[staticmethod]
    fn centred(middle: f64, radius: f64) -> PyResult<PyInterval> {
        if radius >= 0.0 {
            Ok(PyInterval(Interval::centred(middle, radius)))
        } else {
            Err(PyValueError::new_err(format!("expected a radius of at least 0, found {radius}")))
        }
    }

    /// The interval without any number.
    #[staticmethod]
    fn empty() -> PyInterval {
        PyInterval(Interval::EMPTY)
    }

    /// Lower bound.
    #[getter]
    fn lb(&self) -> f64 {
        self.0.lo()
    }

    /// Upper bound.
    #[getter]
    fn ub(&self) -> f64 {
        self.0.hi()
    }

    /// A number near the middle.
    fn mid(&self) -> f64 {
        self.0.mid()
    }

    /// Width, rounded up.
    fn diam(&self) -> f64 {
        self.0.width()
    }

    /// Whether no number is in the interval.
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn __contains__(&self, value: f64) -> bool {
        self.0.contains(value)
    }

    /// Intersection.
    fn __and__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0.intersect(other.interval()?)))
    }

    /// Smallest interval that holds both.
    fn __or__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0.hull(other.interval()?)))
    }

    fn __add__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0 + other.interval()?))
    }

    fn __radd__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(other.interval()? + self.0))
    }

    fn __sub__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0 - other.interval()?))
    }

    fn __rsub__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(other.interval()? - self.0))
    }

    fn __mul__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0 * other.interval()?))
    }

    fn __rmul__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(other.interval()? * self.0))
    }

    fn __truediv__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0 / other.interval()?))
    }

    fn __rtruediv__(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(other.interval()? / self.0))
    }

    fn __neg__(&self) -> PyInterval {
        PyInterval(-self.0)
    }

    /// Interval of the squares.
    fn sqr(&self) -> PyInterval {
        PyInterval(self.0.sqr())
    }

    /// Interval of the square roots of the members that are not negative.
    fn sqrt(&self) -> PyInterval {
        PyInterval(self.0.sqrt())
    }

    /// Interval of the cosines; the interval is in radians.
    fn cos(&self) -> PyInterval {
        PyInterval(self.0.cos())
    }

    /// Interval of the sines; the interval is in radians.
    fn sin(&self) -> PyInterval {
        PyInterval(self.0.sin())
    }

    /// Interval of √(x² + y²).
    fn hypot(&self, other: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0.hypot(other.interval()?)))
    }

    fn __eq__(&self, other: &PyInterval) -> bool {
        self.0 == other.0
    }

    fn __repr__(&self) -> String {
        if self.0.is_empty() { "Interval.empty()".to_owned() } else { format!("[{}, {}]", self.0.lo(), self.0.hi()) }
    }
}

/// A box: one interval for each of several variables, such as x and y.
#[pyclass(name = "IntervalVector", module = "wherein", frozen, sequence, from_py_object)]
#[derive(Clone)]
pub(crate) struct PyBox(pub(crate) Vec<Interval>);

#[pymethods]
impl PyBox {
    /// IntervalVector([[0, 8], [0, 6]]): intervals, pairs of bounds, or numbers.
    #[new]
    fn new(components: Vec<Given>) -> PyResult<PyBox> {
        if components.is_empty() {
            return Err(PyValueError::new_err("expected at least one interval, found none"));
        }
        components.iter().map(Given::interval).collect::<PyResult<_>>().map(PyBox)
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __getitem__(&self, index: usize) -> PyResult<PyInterval> {
        let found = self.0.get(index).copied().map(PyInterval);
        found
            .ok_or_else(|| pyo3::exceptions::PyIndexError::new_err(format!("expected an index below {}", self.0.len())))
    }

    /// Whether no point is in the box.
    fn is_empty(&self) -> bool {
        self.0.iter().any(|side| side.is_empty())
    }

    fn __contains__(&self, point: Vec<f64>) -> bool {
        point.len() == self.0.len() && self.0.iter().zip(point).all(|(side, value)| side.contains(value))
    }

    /// Middle of the box.
    fn mid(&self) -> Vec<f64> {
        self.0.iter().map(|side| side.mid()).collect()
    }

    /// Widths of the box.
    fn diam(&self) -> Vec<f64> {
        self.0.iter().map(|side| side.width()).collect()
    }

    /// Intersection.
    fn __and__(&self, other: &PyBox) -> PyResult<PyBox> {
        same_size(self, other)?;
        Ok(PyBox(self.0.iter().zip(&other.0).map(|(one, two)| one.intersect(*two)).collect()))
    }

    /// Smallest box that holds both.
    fn __or__(&self, other: &PyBox) -> PyResult<PyBox> {
        same_size(self, other)?;
        match (self.is_empty(), other.is_empty()) {
            (true, _) => Ok(other.clone()),
            (_, true) => Ok(self.clone()),
            _ => Ok(PyBox(self.0.iter().zip(&other.0).map(|(one, two)| one.hull(*two)).collect())),
        }
    }

    fn __repr__(&self) -> String {
        let sides = self.0.iter().map(|side| PyInterval(*side).__repr__()).collect::<Vec<_>>();
        format!("({})", sides.join(" × "))
    }
}

fn same_size(one: &PyBox, other: &PyBox) -> PyResult<()> {
    let (first, second) = (one.0.len(), other.0.len());
    if first == second {
        Ok(())
    } else {
        Err(PyValueError::new_err(format!("expected boxes of {first} intervals, found {second}")))
    }
}

/// A contractor on boxes of x and y that threads may share.
type Shared = Arc<dyn Contractor<2> + Send + Sync>;

/// A contractor: a constraint on x and y, which makes boxes smaller and never loses a solution. `&` is for both of two constraints, `|` for one or
/// the other.
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
    /// The part of a box of x and y that the constraint leaves: a smaller box, empty where the constraint has no solution in it.
    fn contract(&self, domain: &PyBox) -> PyResult<PyBox> {
        let mut left = plane(domain)?;
        self.contractor.contract(&mut left);
        Ok(PyBox(left.components().to_vec()))
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
        Ok(array(py, &py.detach(|| cover(&self.contractor, domain, &[0, 1], eps))))
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
    let paving = py.detach(|| Paving::new(set, domain, &[0, 1], eps));
    Ok((array(py, &paving.inner), array(py, &paving.outer), array(py, &paving.boundary)))
}

/// A contractor of poses by one of x and y.
pub(crate) fn on_pose(contractor: Ctc) -> OnAxes<Kept, 2> {
    contractor.contractor.on_axes([0, 1])
}

fn plane(given: &PyBox) -> PyResult<IntervalBox<2>> {
    match given.0[..] {
        [x, y] => Ok(IntervalBox::new([x, y])),
        _ => Err(PyValueError::new_err(format!("expected a box of x and y, found {} intervals", given.0.len()))),
    }
}

fn resolution(eps: f64) -> PyResult<f64> {
    if eps > 0.0 { Ok(eps) } else { Err(PyValueError::new_err(format!("eps: expected more than 0, found {eps}"))) }
}

fn array<'py>(py: Python<'py>, boxes: &[IntervalBox<2>]) -> Bound<'py, PyArray3<f64>> {
    let entry = |(index, axis, end): (usize, usize, usize)| match end {
        0 => boxes[index][axis].lo(),
        _ => boxes[index][axis].hi(),
    };
    PyArray3::from_owned_array(py, Array3::from_shape_fn((boxes.len(), 2, 2), entry))
}
