//! A known distance to a known place.
//!
//! **Constraint.** √((x − a)² + (y − b)²) = d with a, b, d in intervals; the variables are x and y.
//! **Sound.** Each difference and each square root is enclosed before it is used.
//! **Optimal.** Every variable and every parameter occurs once, all steps are continuous, and the two signs of each square root
//! are intersected with what is known before they are joined.
//! **Source.** L. Jaulin, M. Kieffer, O. Didrit, É. Walter, *Applied Interval Analysis*, Springer 2001, section 4.2.4.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// At distance `distance` from the place (`landmark[0]`, `landmark[1]`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Where the landmark may be.
    pub landmark: [Interval; 2],
    /// How far away it may be.
    pub distance: Interval,
}

impl Contractor<2> for Distance {
    fn contract(&self, domain: &mut IntervalBox<2>) -> Outcome {
        let across = domain[0] - self.landmark[0];
        let along = domain[1] - self.landmark[1];
        let squared = self.distance.intersect(Interval::new(0.0, f64::INFINITY)).sqr();
        let across = (squared - along.sqr()).sqr_rev(across);
        let along = (squared - across.sqr()).sqr_rev(along);
        let left = IntervalBox::new([
            domain[0].intersect(across + self.landmark[0]),
            domain[1].intersect(along + self.landmark[1]),
        ]);
        settle(domain, left, "no point of the box is at that distance")
    }
}
