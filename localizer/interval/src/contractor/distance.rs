//! A known distance to a known place.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// At distance `distance` from the place (`centre[0]`, `centre[1]`).
///
/// **Constraint.** √((x − a)² + (y − b)²) = d with a, b, d in intervals; the variables are x and y.
///
/// **Sound.** Each difference and each square root is enclosed before it is used.
///
/// **Optimal.** Every variable and every parameter occurs once, all steps are continuous, and the two signs of each square root
/// are intersected with what is known before they are joined.
///
/// **Source.** L. Jaulin, M. Kieffer, O. Didrit, É. Walter, *Applied Interval Analysis*, Springer 2001, section 4.2.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Where the place may be.
    pub centre: [Interval; 2],
    /// How far from it the point may be.
    pub distance: Interval,
}

impl Contractor<2> for Distance {
    fn contract(&self, domain: &mut IntervalBox<2>) -> Outcome {
        let across = domain[0] - self.centre[0];
        let along = domain[1] - self.centre[1];
        let squared = self.distance.intersect(Interval::new(0.0, f64::INFINITY)).sqr();
        let across = (squared - along.sqr()).sqr_rev(across);
        let along = (squared - across.sqr()).sqr_rev(along);
        let left = IntervalBox::new([
            domain[0].intersect(across + self.centre[0]),
            domain[1].intersect(along + self.centre[1]),
        ]);
        settle(domain, left, "no point of the box is at that distance")
    }
}
