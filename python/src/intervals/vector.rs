//! Boxes: one interval for each of several variables.

use interval::{Interval, IntervalBox};
use pyo3::{
    exceptions::{PyIndexError, PyValueError},
    prelude::*,
};

use super::interval::{Given, PyInterval, halves, hash_of, radius, shown};

/// A box: one interval for each of several variables, such as x and y. Boxes are equal where they hold the same points.
#[pyclass(name = "IntervalVector", module = "wherein", frozen, sequence, from_py_object)]
#[derive(Clone)]
pub(crate) struct PyBox(pub(crate) Vec<Interval>);

#[pymethods]
impl PyBox {
    /// IntervalVector([[0, 8], [0, 6]]): intervals, pairs of bounds, or numbers, in a list, a tuple or an array.
    #[new]
    fn new(components: &Bound<'_, PyAny>) -> PyResult<PyBox> {
        let components = self::components(components)?;
        if components.is_empty() {
            return Err(PyValueError::new_err("expected at least one interval, found none"));
        }
        Ok(PyBox(components))
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __getitem__(&self, index: isize) -> PyResult<PyInterval> {
        self.axis(index).map(|axis| PyInterval(self.0[axis]))
    }

    /// Whether no point is in the box.
    fn is_empty(&self) -> bool {
        self.0.iter().any(|side| side.is_empty())
    }

    fn __contains__(&self, point: &Bound<'_, PyAny>) -> PyResult<bool> {
        let point: Vec<f64> = listed(point).extract()?;
        Ok(point.len() == self.0.len() && self.0.iter().zip(point).all(|(side, value)| side.contains(value)))
    }

    /// Whether every point of this box is in the other one.
    fn is_subset(&self, other: &Bound<'_, PyAny>) -> PyResult<bool> {
        let other = self.like(other)?;
        Ok(self.is_empty() || self.0.iter().zip(&other).all(|(one, two)| one.is_subset_of(*two)))
    }

    /// Middle of the box.
    fn mid(&self) -> Vec<f64> {
        self.0.iter().map(|side| side.mid()).collect()
    }

    /// Half widths of the box.
    fn rad(&self) -> Vec<f64> {
        self.0.iter().map(|side| side.radius()).collect()
    }

    /// Widths of the box.
    fn diam(&self) -> Vec<f64> {
        self.0.iter().map(|side| side.width()).collect()
    }

    /// Greatest width of the box; NaN where it is empty.
    fn max_diam(&self) -> f64 {
        if self.is_empty() { f64::NAN } else { self.0.iter().map(|side| side.width()).fold(0.0, f64::max) }
    }

    /// The box that is wider by `rad` on every side.
    fn inflate(&self, rad: f64) -> PyResult<PyBox> {
        let rad = radius(rad)?;
        Ok(PyBox(self.0.iter().map(|side| side.inflate(rad)).collect()))
    }

    /// Both halves of the box, cut in the middle of an axis: that of its greatest width unless another is stated.
    #[pyo3(signature = (axis=None))]
    fn bisect(&self, axis: Option<isize>) -> PyResult<(PyBox, PyBox)> {
        let widest = || (0..self.0.len()).max_by(|a, b| self.0[*a].width().total_cmp(&self.0[*b].width()));
        let axis = axis.map_or_else(|| Ok(widest().unwrap_or(0)), |axis| self.axis(axis))?;
        let (below, above) = halves(self.0[axis])?;
        let with = |half: Interval| {
            let mut sides = self.0.clone();
            sides[axis] = half;
            PyBox(sides)
        };
        Ok((with(below), with(above)))
    }

    /// Intersection.
    fn __and__(&self, other: &Bound<'_, PyAny>) -> PyResult<PyBox> {
        Ok(self.with(&self.like(other)?, Interval::intersect))
    }

    /// Smallest box that holds both.
    fn __or__(&self, other: &Bound<'_, PyAny>) -> PyResult<PyBox> {
        let other = PyBox(self.like(other)?);
        match (self.is_empty(), other.is_empty()) {
            (true, _) => Ok(other),
            (_, true) => Ok(self.clone()),
            _ => Ok(self.with(&other.0, Interval::hull)),
        }
    }

    /// Box of the sums of points of both.
    fn __add__(&self, other: &Bound<'_, PyAny>) -> PyResult<PyBox> {
        Ok(self.with(&self.like(other)?, |one, two| one + two))
    }

    /// Box of the differences of points of both.
    fn __sub__(&self, other: &Bound<'_, PyAny>) -> PyResult<PyBox> {
        Ok(self.with(&self.like(other)?, |one, two| one - two))
    }

    fn __eq__(&self, other: &PyBox) -> bool {
        self.0.len() == other.0.len() && ((self.is_empty() && other.is_empty()) || self.0 == other.0)
    }

    fn __hash__(&self) -> u64 {
        hash_of(&self.0)
    }

    fn __repr__(&self) -> String {
        let sides = self.0.iter().map(|side| shown(*side)).collect::<Vec<_>>();
        format!("({})", sides.join(" × "))
    }
}

impl PyBox {
    /// The axis of an index, which counts from the end where it is negative.
    fn axis(&self, index: isize) -> PyResult<usize> {
        let n_axes = self.0.len();
        let axis = if index < 0 { n_axes.checked_add_signed(index) } else { usize::try_from(index).ok() };
        axis.filter(|axis| *axis < n_axes).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "expected an index from {} to {}, found {index}",
                -(n_axes as isize),
                n_axes - 1
            ))
        })
    }

    fn with(&self, other: &[Interval], operation: impl Fn(Interval, Interval) -> Interval) -> PyBox {
        PyBox(self.0.iter().zip(other).map(|(one, two)| operation(*one, *two)).collect())
    }

    /// The intervals of another box of as many.
    fn like(&self, other: &Bound<'_, PyAny>) -> PyResult<Vec<Interval>> {
        let other = components(other)?;
        let (first, second) = (self.0.len(), other.len());
        if first == second {
            Ok(other)
        } else {
            Err(PyValueError::new_err(format!("expected boxes of {first} intervals, found {second}")))
        }
    }
}

/// The intervals of a box, or of a list, a tuple or an array of intervals, pairs of bounds or numbers.
pub(super) fn components(given: &Bound<'_, PyAny>) -> PyResult<Vec<Interval>> {
    if let Ok(PyBox(components)) = given.extract() {
        return Ok(components);
    }
    let listed: Vec<Given> = listed(given).extract()?;
    listed.iter().map(Given::interval).collect()
}

/// What was given, as nested lists if it is an array.
fn listed<'py>(given: &Bound<'py, PyAny>) -> Bound<'py, PyAny> {
    given.call_method0("tolist").unwrap_or_else(|_| given.clone())
}

/// A box of x and y.
pub(super) fn plane(given: &PyBox) -> PyResult<IntervalBox<2>> {
    match given.0[..] {
        [x, y] => Ok(IntervalBox::new([x, y])),
        _ => Err(PyValueError::new_err(format!("expected a box of x and y, found {} intervals", given.0.len()))),
    }
}
