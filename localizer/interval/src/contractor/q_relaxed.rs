//! All constraints but at most q hold: what outliers ask for.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// At least all but `q` of the constraints.
///
/// **Constraint.** x satisfies at least n − q of n constraints.
///
/// **Sound.** Each constraint is contracted alone; a solution is in at least n − q of the boxes left, hence on each axis in at
/// least n − q of their intervals, and stays so after boxes that miss the hull are dropped (they never contain a solution).
///
/// **Not optimal.** The exact hull of points in n − q of n boxes takes time exponential in the dimension; this one projects on
/// the axes and repeats until nothing changes.
///
/// **Source.** L. Jaulin, "Robust set-membership state estimation", Automatica 45 (2009);
/// the projection is that of C. Carbonnel et al., "Q-intersection algorithms for constraint-based robust parameter estimation", AAAI 2014.
pub struct QRelaxed<const N: usize> {
    /// The constraints, each alone.
    pub contractors: Vec<Box<dyn Contractor<N> + Send + Sync>>,
    /// How many may be violated.
    pub q: usize,
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

/// A box around all points that are in at least `boxes.len() − q` of the boxes; all of space when `q` allows none.
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

/// From the first to the last point of an axis that is in `needed` of the intervals. Closed intervals open before others close.
fn hull_of_depth<const N: usize>(boxes: &[IntervalBox<N>], axis: usize, needed: usize) -> Interval {
    let mut lows: Vec<f64> = boxes.iter().map(|one| one[axis].lo()).collect();
    let mut highs: Vec<f64> = boxes.iter().map(|one| one[axis].hi()).collect();
    lows.sort_by(f64::total_cmp);
    highs.sort_by(f64::total_cmp);
    // Depth at a low end: lows up to it minus highs before it.
    let depth = |x: f64| lows.partition_point(|low| *low <= x) - highs.partition_point(|high| *high < x);
    let first = lows.iter().copied().find(|low| depth(*low) >= needed);
    let last = highs.iter().copied().rev().find(|high| depth(*high) >= needed);
    match (first, last) {
        (Some(lo), Some(hi)) => Interval::new(lo, hi),
        _ => Interval::EMPTY,
    }
}
