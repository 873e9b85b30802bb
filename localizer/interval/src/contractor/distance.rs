//! Contractor for a point at a known distance from a known place.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// A point (x, y) at distance `distance` from the place (`centre[0]`, `centre[1]`).
///
/// **Constraint.** √((x − a)² + (y − b)²) = d, where the place's coordinates a and b and the distance d are in intervals; the variables are x
/// and y.
///
/// **Sound.** Each difference and each square root is enclosed before it is used.
///
/// **Optimal.** Every variable and every parameter occurs once, all steps are continuous, and the two signs of each square root are intersected
/// with the known interval before they are joined.
///
/// **Source.** L. Jaulin, M. Kieffer, O. Didrit, É. Walter, *Applied Interval Analysis*, Springer 2001, section 4.2.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Box of the place from which the distance is measured.
    pub centre: [Interval; 2],
    /// Interval of the distance between the place and the point.
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
