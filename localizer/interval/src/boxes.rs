//! Axis-aligned boxes: one interval for each of `N` variables.

use std::ops::{Index, IndexMut};

use crate::Interval;

/// An axis-aligned box: the Cartesian product of `N` intervals. It is empty as soon as one of the intervals is empty.
///
/// With the feature `serde` the box is serialised as the list of its intervals.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "Vec<Interval>", try_from = "Vec<Interval>"))]
pub struct IntervalBox<const N: usize> {
    components: [Interval; N],
}

impl<const N: usize> IntervalBox<N> {
    /// The empty box, which contains no point.
    pub const EMPTY: Self = IntervalBox { components: [Interval::EMPTY; N] };
    /// The box of all points of ℝᴺ.
    pub const ENTIRE: Self = IntervalBox { components: [Interval::ENTIRE; N] };

    /// The box that is the product of the given intervals.
    #[inline]
    pub const fn new(components: [Interval; N]) -> Self {
        IntervalBox { components }
    }

    /// The box that contains exactly one point.
    pub fn point(coordinates: &[f64; N]) -> Self {
        IntervalBox { components: coordinates.map(Interval::point) }
    }

    /// Whether the box contains no point.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.components.iter().any(|component| component.is_empty())
    }

    /// Whether the box contains the given point.
    pub fn contains(&self, point: &[f64; N]) -> bool {
        self.components.iter().zip(point).all(|(component, &value)| component.contains(value))
    }

    /// Smallest box that contains both boxes. The result is exact.
    pub fn hull(&self, other: &Self) -> Self {
        if self.is_empty() {
            return *other;
        }
        if other.is_empty() {
            return *self;
        }
        self.zip_with(other, Interval::hull)
    }

    /// Box of the points that two boxes have in common; the canonical empty box when there is none. The result is exact.
    pub fn intersect(&self, other: &Self) -> Self {
        let common = self.zip_with(other, Interval::intersect);
        if common.is_empty() { Self::EMPTY } else { common }
    }

    /// Whether the two boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.components.iter().zip(&other.components).all(|(mine, theirs)| mine.overlaps(*theirs))
    }

    /// Whether every point of this box is in `other`; true when this box is empty.
    pub fn is_subset_of(&self, other: &Self) -> bool {
        self.is_empty()
            || self.components.iter().zip(&other.components).all(|(mine, theirs)| mine.is_subset_of(*theirs))
    }

    /// Midpoints of the box's intervals; NaN for an empty interval.
    pub fn midpoint(&self) -> [f64; N] {
        self.components.map(Interval::mid)
    }

    /// Width of the box along one axis, rounded up.
    #[inline]
    pub fn width(&self, axis: usize) -> f64 {
        self.components[axis].width()
    }

    /// Greatest width of the box over all axes; 0 when the box has no axis, NaN when it is empty.
    pub fn max_width(&self) -> f64 {
        if self.is_empty() {
            return f64::NAN;
        }
        self.components.iter().fold(0.0, |greatest, component| component.width().max(greatest))
    }

    /// Cuts the box in two at the midpoint of `axis`. Both halves contain that midpoint, and their union is the box.
    pub fn bisect(&self, axis: usize) -> (Self, Self) {
        let (mut left, mut right) = (*self, *self);
        let component = self.components[axis];
        let mid = component.mid();
        left.components[axis] = Interval::new(component.lo(), mid);
        right.components[axis] = Interval::new(mid, component.hi());
        (left, right)
    }

    /// Iterates over the box's intervals, in the order of the axes.
    pub fn iter(&self) -> std::slice::Iter<'_, Interval> {
        self.components.iter()
    }

    /// The box's intervals as an array.
    #[inline]
    pub const fn components(&self) -> [Interval; N] {
        self.components
    }

    fn zip_with(&self, other: &Self, operation: impl Fn(Interval, Interval) -> Interval) -> Self {
        IntervalBox { components: std::array::from_fn(|axis| operation(self.components[axis], other.components[axis])) }
    }
}

/// All empty boxes are equal, whichever of their intervals are empty.
impl<const N: usize> PartialEq for IntervalBox<N> {
    fn eq(&self, other: &Self) -> bool {
        (self.is_empty() && other.is_empty()) || self.components == other.components
    }
}

impl<const N: usize> From<[Interval; N]> for IntervalBox<N> {
    fn from(components: [Interval; N]) -> Self {
        IntervalBox { components }
    }
}

impl<const N: usize> From<IntervalBox<N>> for Vec<Interval> {
    fn from(interval_box: IntervalBox<N>) -> Vec<Interval> {
        interval_box.components.to_vec()
    }
}

impl<const N: usize> TryFrom<Vec<Interval>> for IntervalBox<N> {
    type Error = String;
    fn try_from(components: Vec<Interval>) -> Result<Self, String> {
        let n_components = components.len();
        let components =
            components.try_into().map_err(|_| format!("read a box of {N} intervals: got {n_components}"))?;
        Ok(IntervalBox { components })
    }
}

impl<const N: usize> Index<usize> for IntervalBox<N> {
    type Output = Interval;
    #[inline]
    fn index(&self, axis: usize) -> &Interval {
        &self.components[axis]
    }
}

impl<const N: usize> IndexMut<usize> for IntervalBox<N> {
    #[inline]
    fn index_mut(&mut self, axis: usize) -> &mut Interval {
        &mut self.components[axis]
    }
}

impl<'a, const N: usize> IntoIterator for &'a IntervalBox<N> {
    type Item = &'a Interval;
    type IntoIter = std::slice::Iter<'a, Interval>;
    fn into_iter(self) -> Self::IntoIter {
        self.components.iter()
    }
}
