//! Intervals of numbers.

use std::hash::{DefaultHasher, Hash, Hasher};

use interval::Interval;
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

    /// Half of the width, rounded up.
    fn rad(&self) -> f64 {
        self.0.radius()
    }

    /// Greatest absolute value of a member.
    fn mag(&self) -> f64 {
        self.0.magnitude()
    }

    /// Least absolute value of a member.
    fn mig(&self) -> f64 {
        self.0.mignitude()
    }

    /// Width, rounded up.
    fn diam(&self) -> f64 {
        self.0.width()
    }

    /// Whether no number is in the interval.
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether every number of this interval is in the other one.
    fn is_subset(&self, other: Given) -> PyResult<bool> {
        Ok(self.0.is_subset_of(other.interval()?))
    }

    /// The interval of the numbers that are at most `rad` from a number of this one.
    fn inflate(&self, rad: f64) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0.inflate(radius(rad)?)))
    }

    /// Both halves, which share the middle.
    fn bisect(&self) -> PyResult<(PyInterval, PyInterval)> {
        let (below, above) = halves(self.0)?;
        Ok((PyInterval(below), PyInterval(above)))
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

    /// Interval of the absolute values (in Codac the function `abs`).
    fn __abs__(&self) -> PyInterval {
        PyInterval(self.0.abs())
    }

    /// Interval of the powers by a whole number (in Codac the function `pow`). A member 0 has no power by a negative number.
    fn __pow__(&self, exponent: i32, modulo: Option<&Bound<'_, PyAny>>) -> PyResult<PyInterval> {
        match modulo {
            None => Ok(PyInterval(self.0.pown(exponent))),
            Some(_) => Err(PyValueError::new_err("expected a power without a modulus")),
        }
    }

    /// Interval of the exponentials eˣ.
    fn exp(&self) -> PyInterval {
        PyInterval(self.0.exp())
    }

    /// Interval of the natural logarithms of the positive members; empty where there are none.
    fn log(&self) -> PyInterval {
        PyInterval(self.0.log())
    }

    /// Interval of the tangents; the interval is in radians.
    fn tan(&self) -> PyInterval {
        PyInterval(self.0.tan())
    }

    /// Interval of the inverse sines in radians, of the members from −1 to 1.
    fn asin(&self) -> PyInterval {
        PyInterval(self.0.asin())
    }

    /// Interval of the inverse cosines in radians, of the members from −1 to 1.
    fn acos(&self) -> PyInterval {
        PyInterval(self.0.acos())
    }

    /// Interval of the inverse tangents in radians.
    fn atan(&self) -> PyInterval {
        PyInterval(self.0.atan())
    }

    /// Interval of the directions from −π to π of the vectors (x, y), with y in this interval and x in the other: `y.atan2(x)`, as in Codac the
    /// function `atan2(y, x)`. All of [−π, π] where the directions lie on both sides of the cut along negative x.
    fn atan2(&self, x: Given) -> PyResult<PyInterval> {
        Ok(PyInterval(self.0.atan2(x.interval()?)))
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

    fn __hash__(&self) -> u64 {
        hash_of(&[self.0])
    }

    fn __repr__(&self) -> String {
        shown(self.0)
    }
}

/// An interval as Python shows it.
pub(crate) fn shown(one: Interval) -> String {
    if one.is_empty() { "Interval.empty()".to_owned() } else { format!("[{}, {}]", one.lo(), one.hi()) }
}

/// The halves of an interval that has a number between its bounds.
pub(super) fn halves(one: Interval) -> PyResult<(Interval, Interval)> {
    let middle = one.mid();
    if one.lo() < middle && middle < one.hi() {
        Ok((Interval::new(one.lo(), middle), Interval::new(middle, one.hi())))
    } else {
        let found = shown(one);
        Err(PyValueError::new_err(format!("expected an interval with a number between its bounds, found {found}")))
    }
}

/// A radius by which something is made wider.
pub(super) fn radius(rad: f64) -> PyResult<f64> {
    if rad >= 0.0 { Ok(rad) } else { Err(PyValueError::new_err(format!("rad: expected at least 0, found {rad}"))) }
}

/// One number for equal intervals; those of which one is empty are all equal.
pub(super) fn hash_of(intervals: &[Interval]) -> u64 {
    let mut hasher = DefaultHasher::new();
    intervals.len().hash(&mut hasher);
    if !intervals.iter().any(|one| one.is_empty()) {
        for one in intervals {
            // 0 and −0 are equal; a sum with 0 makes them one.
            [one.lo(), one.hi()].map(|bound| (bound + 0.0).to_bits()).hash(&mut hasher);
        }
    }
    hasher.finish()
}
