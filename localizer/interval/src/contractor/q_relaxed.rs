//! Contractor for all but at most q of several constraints, which data with outliers need.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// The constraint that at least all but `q` of several constraints hold.
///
/// **Constraint.** x satisfies at least n − q of n constraints.
///
/// **Sound.** Each constraint contracts the domain alone. A solution is in at least n − q of the boxes that are left, hence on each axis in at
/// least n − q of their intervals. That stays so after boxes that miss the hull are dropped, because they contain no solution.
///
/// **Not optimal.** The exact hull of the points in n − q of n boxes takes time exponential in the dimension. This contractor projects the boxes
/// on the axes, and repeats that until nothing changes.
///
/// **Source.** L. Jaulin, "Robust set-membership state estimation", Automatica 45 (2009); the projection is that of C. Carbonnel et al.,
/// "Q-intersection algorithms for constraint-based robust parameter estimation", AAAI 2014.
pub struct QRelaxed<const N: usize> {
    /// The constraints, each of which contracts the domain alone.
    pub contractors: Vec<Box<dyn Contractor<N> + Send + Sync>>,
    /// Greatest number q of the constraints that may be violated.
    pub q: usize,
}

impl<const N: usize> QRelaxed<N> {
    /// Indices of the constraints that exclude every point of a box, in rising order. After [`contract`](Contractor::contract) has left few points,
    /// these are the constraints that are surely violated if the others are right: the outliers, such as landmarks that are taken for others.
    ///
    /// A constraint that is not listed may be violated nevertheless, because some point of the box agrees with it or because its contractor is not
    /// the sharpest. More than `q` indices prove that the box holds no solution.
    pub fn excluding(&self, domain: &IntervalBox<N>) -> Vec<usize> {
        let excludes = |contractor: &dyn Contractor<N>| {
            let mut alone = *domain;
            contractor.contract(&mut alone);
            alone.is_empty()
        };
        (0..self.contractors.len()).filter(|index| excludes(&*self.contractors[*index])).collect()
    }
}

impl<const N: usize> Contractor<N> for QRelaxed<N> {
    fn contract(&self, domain: &mut IntervalBox<N>) -> Outcome {
        if self.q >= self.contractors.len() {
            return if domain.is_empty() { Outcome::Empty("the domain is empty") } else { Outcome::Feasible };
        }
        let boxes: Vec<IntervalBox<N>> = self
            .contractors
            .iter()
            .map(|contractor| {
                let mut alone = *domain;
                contractor.contract(&mut alone);
                alone
            })
            .collect();
        let left = domain.intersect(&q_intersection(&boxes, self.q));
        settle(domain, left, "more than q constraints exclude every point")
    }
}

/// A box around all points that are in at least `boxes.len() − q` of the boxes; all of space when `q` is at least the number of boxes.
pub fn q_intersection<const N: usize>(boxes: &[IntervalBox<N>], q: usize) -> IntervalBox<N> {
    if q >= boxes.len() {
        return IntervalBox::ENTIRE;
    }
    let needed = boxes.len() - q;
    let mut hull = IntervalBox::ENTIRE;
    loop {
        let candidates: Vec<IntervalBox<N>> =
            boxes.iter().map(|one| one.intersect(&hull)).filter(|one| !one.is_empty()).collect();
        let narrower = IntervalBox::new(std::array::from_fn(|axis| hull_of_depth(&candidates, axis, needed)));
        if narrower.is_empty() {
            return IntervalBox::EMPTY;
        }
        if narrower == hull {
            return hull;
        }
        hull = narrower;
    }
}

/// The interval from the first to the last point of an axis that is in at least `needed` of the boxes' intervals. An interval's end point still
/// counts as inside it where another interval begins at that point.
fn hull_of_depth<const N: usize>(boxes: &[IntervalBox<N>], axis: usize, needed: usize) -> Interval {
    let mut lows: Vec<f64> = boxes.iter().map(|one| one[axis].lo()).collect();
    let mut highs: Vec<f64> = boxes.iter().map(|one| one[axis].hi()).collect();
    lows.sort_by(f64::total_cmp);
    highs.sort_by(f64::total_cmp);
    // Number of the boxes' intervals (along this axis) that contain x: those that begin at or before x, less those that end before x.
    let depth = |x: f64| lows.partition_point(|low| *low <= x) - highs.partition_point(|high| *high < x);
    let first = lows.iter().copied().find(|low| depth(*low) >= needed);
    let last = highs.iter().copied().rev().find(|high| depth(*high) >= needed);
    match (first, last) {
        (Some(lo), Some(hi)) => Interval::new(lo, hi),
        _ => Interval::EMPTY,
    }
}
