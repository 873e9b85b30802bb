//! Contractor between the Cartesian and the polar coordinates of a vector, for an angle interval over any number of quadrants.

use super::{Contractor, Outcome, settle};
use crate::{Interval, IntervalBox};

/// The Cartesian and polar coordinates of one vector: (x, y) = r (cos θ, sin θ) with r ≥ 0.
///
/// **Constraint.** x = r cos θ, y = r sin θ, r ≥ 0; the variables are x, y, r, θ, and θ is on the real line (not wrapped).
///
/// **Sound.** The interval of θ is cut at enclosures of the multiples of π/2. In each quadrant, turned into the first one, every function is
/// monotone, and every variable is contracted by outward-rounded inverses. The quadrants' results are joined.
///
/// **Optimal** on boxes within a quadrant as far as tested. The source proves its own order of steps minimal, and taking the hull over quadrants
/// keeps that.
///
/// **Source.** B. Desrochers, L. Jaulin, "A minimal contractor for the polar equation", Engineering Applications of Artificial Intelligence 55
/// (2016).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Polar;

const NON_NEGATIVE: Interval = Interval::new(0.0, f64::INFINITY);

/// Greatest number of quarter turns that an angle interval may touch to be cut at their ends; a wider angle interval stays as it is, and contracts
/// only the other variables (x, y and the radius).
const MOST_QUARTERS: i64 = 64;

impl Contractor<4> for Polar {
    fn contract(&self, domain: &mut IntervalBox<4>) -> Outcome {
        let left = match quarters(domain[3]) {
            Some((first, last)) => {
                (first..=last).fold(IntervalBox::EMPTY, |hull, quarter| hull.hull(&in_quarter(domain, quarter)))
            }
            None => {
                // The angle interval is so wide, or so far from 0, that it is taken to hold all directions: one turn decides about x, y and r,
                // and the angle is left as it is.
                let turn = IntervalBox::new([domain[0], domain[1], domain[2], Interval::ENTIRE]);
                let mut hull = (0..4).fold(IntervalBox::EMPTY, |hull, quarter| hull.hull(&in_quarter(&turn, quarter)));
                if !hull.is_empty() {
                    hull[3] = domain[3];
                }
                hull
            }
        };
        settle(domain, left, "no vector of that length and direction is in the box")
    }

    fn branches(&self, domain: &IntervalBox<4>) -> Vec<IntervalBox<4>> {
        match quarters(domain[3]) {
            Some((first, last)) => {
                let quarters = (first..=last).map(|quarter| in_quarter(domain, quarter));
                quarters.filter(|branch| !branch.is_empty()).collect()
            }
            None => {
                let mut contracted = *domain;
                self.contract(&mut contracted);
                if contracted.is_empty() { Vec::new() } else { vec![contracted] }
            }
        }
    }
}

/// First and last k of the quarter turns [k π/2, (k + 1) π/2] that an interval of angles touches; `None` when there are too many of them, or when
/// they are too far from 0.
fn quarters(angle: Interval) -> Option<(i64, i64)> {
    let quotient = angle / (Interval::PI / 2.0);
    let (first, last) = (quotient.lo().floor(), quotient.hi().floor());
    (last - first < MOST_QUARTERS as f64 && first.abs() < 1e9).then_some((first as i64, last as i64))
}

/// Contracts the domain by the polar equation with θ in [k π/2, (k + 1) π/2], where k is `quarter`.
fn in_quarter(domain: &IntervalBox<4>, quarter: i64) -> IntervalBox<4> {
    let [x, y, r, angle] = domain.components();
    // Turns the vector back by `quarter` quarter turns, into the first quadrant. This is exact, since coordinates only change place and sign.
    let (x, y) = match quarter.rem_euclid(4) {
        0 => (x, y),
        1 => (y, -x),
        2 => (-x, -y),
        _ => (-y, x),
    };
    let start = quarter as f64 * (Interval::PI / 2.0);
    let [x, y, r, turned] = in_first_quadrant(x, y, r, angle - start).components();
    let (x, y) = match quarter.rem_euclid(4) {
        0 => (x, y),
        1 => (-y, x),
        2 => (-x, -y),
        _ => (y, -x),
    };
    let left = IntervalBox::new([x, y, r, angle.intersect(turned + start)]);
    if left.is_empty() { IntervalBox::EMPTY } else { left }
}

fn in_first_quadrant(x: Interval, y: Interval, r: Interval, angle: Interval) -> IntervalBox<4> {
    let quarter = Interval::new(0.0, (Interval::PI / 2.0).hi());
    let (mut x, mut y) = (x.intersect(NON_NEGATIVE), y.intersect(NON_NEGATIVE));
    let mut r = r.intersect(NON_NEGATIVE);
    let mut angle = angle.intersect(quarter);
    // The contractions are applied twice, so that each variable profits from those of all others.
    for _ in 0..2 {
        r = r.intersect(x.hypot(y));
        // The zero vector has every direction, so the angle is contracted only if the vector cannot be zero.
        if !(x.contains_zero() && y.contains_zero()) {
            angle = angle.intersect(y.atan2(x));
        }
        let (cosine, sine) = (angle.cos().max(Interval::ZERO), angle.sin().max(Interval::ZERO));
        x = x.intersect(r * cosine);
        y = y.intersect(r * sine);
        x = (r.sqr() - y.sqr()).sqr_rev(x);
        y = (r.sqr() - x.sqr()).sqr_rev(y);
        x = (y * cosine).mul_rev(sine, x);
        y = (x * sine).mul_rev(cosine, y);
        r = x.mul_rev(cosine, r);
        r = y.mul_rev(sine, r);
    }
    IntervalBox::new([x, y, r, angle])
}
