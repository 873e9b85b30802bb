//! The planar pose from matched landmarks without bisection: linear elimination, then thin slices of heading.

use interval::contractor::{Contractor, Outcome, settle};
use interval::{Interval, IntervalBox};

use super::RigidPlanar;
use super::rigid_planar::{CAUSE, common};
use super::rigid_rows::{About, LANES, Row, SLACK};

/// Contractor of the planar pose from matched landmarks, which needs no bisection.
///
/// **Constraint.** That of [`RigidPlanar`]. This is a stronger contractor for it, because it compares pairs of landmarks.
///
/// **Sound.** Each row (`rigid_rows`) says value ∈ mᵢ + δ gᵢ ± eᵢ with the *same* value for all landmarks i, where δ is the heading's deviation
/// from the middle. The difference of two rows does not contain the translation and bounds δ. A convex combination of two rows with slopes of
/// opposite sign does not contain δ and bounds the translation. Both are consequences of the rows, whatever the multipliers. The slices of
/// heading cover the whole heading interval.
///
/// **Optimal** for the linearised rows along x and y: in a linear problem with two unknowns a bound is always given by two rows. What is lost is
/// Lagrange's remainder, which slices make as small as wanted: the more slices, the closer the result is to the hull of the solutions.
///
/// **Source.** The elimination is Fourier and Motzkin's; its use on a linearisation with a rigorous remainder is that of A. Neumaier, *Interval
/// Methods for Systems of Equations*, Cambridge 1990, chapter 5.
#[derive(Clone, Debug)]
pub struct LinearPose {
    /// The matched landmarks in both frames.
    pub motion: RigidPlanar,
    /// Number of slices into which the heading is cut after the linear elimination; 0 for the elimination alone.
    pub n_slices: usize,
}

/// The elimination is repeated about the new middle heading as long as it narrows the heading to less than this fraction of its width.
const WORTHWHILE: f64 = 0.9;

impl Contractor<3> for LinearPose {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let left = self.branches(domain).iter().fold(IntervalBox::EMPTY, |hull, branch| hull.hull(branch));
        settle(domain, left, CAUSE)
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        if domain.is_empty() {
            return Vec::new();
        }
        let mut branches = Vec::with_capacity(1);
        for heading in self.motion.turns(domain[2]) {
            let part = self.motion.bound_by_lengths(&IntervalBox::new([domain[0], domain[1], heading]));
            // Where no baseline between landmarks decides the heading, Lagrange's remainder would exceed everything that the elimination can
            // gain.
            let left = if part.is_empty() || part[2].width() > 3.0 {
                self.motion.contract_turn(&part)
            } else {
                self.sliced(&self.eliminate(part))
            };
            if !left.is_empty() {
                branches.push(left);
            }
        }
        branches
    }
}

impl LinearPose {
    fn eliminate(&self, mut domain: IntervalBox<3>) -> IntervalBox<3> {
        // Any point can be the origin of the translation; a point near the solution makes the remainders small.
        let mut origin = self.motion.aligned_centroids(domain[2].mid());
        for _ in 0..6 {
            let about = About {
                translation: origin,
                translation_radius: [0.0; 2],
                ..About::new(domain[2], [Interval::ZERO; 2])
            };
            let rows: Vec<[Row; 4]> = self.motion.groups().iter().map(|lanes| lanes.rows(&about)).collect();
            let turn = turn_by_pairs(&rows, about.reach);
            let heading = domain[2].intersect(Interval::new(turn.0, turn.1) + about.heading);
            let shrank = heading.width() < WORTHWHILE * domain[2].width();
            domain[2] = heading;
            if heading.is_empty() {
                return IntervalBox::EMPTY;
            }
            if !shrank {
                for axis in 0..2 {
                    let (lo, hi) = value_by_pairs(&rows, axis, turn);
                    domain[axis] = domain[axis].intersect(Interval::new(lo, hi) + origin[axis]);
                }
                return domain;
            }
            origin = self.motion.aligned_centroids(heading.mid());
        }
        domain
    }

    fn sliced(&self, domain: &IntervalBox<3>) -> IntervalBox<3> {
        if self.n_slices == 0 || domain.is_empty() {
            return *domain;
        }
        let (lo, width) = (domain[2].lo(), domain[2].width());
        let end = |idx: usize| match idx {
            0 => lo,
            _ if idx == self.n_slices => domain[2].hi(),
            _ => (lo + width * idx as f64 / self.n_slices as f64).min(domain[2].hi()),
        };
        let mut hull = IntervalBox::EMPTY;
        for idx in 0..self.n_slices {
            let slice = IntervalBox::new([domain[0], domain[1], Interval::new(end(idx), end(idx + 1))]);
            hull = hull.hull(&self.motion.pass(&slice));
        }
        hull
    }
}

fn entry(rows: &[[Row; 4]], direction: usize, idx: usize) -> (f64, f64, f64) {
    let row = &rows[idx / LANES][direction];
    (row.m[idx % LANES], row.g[idx % LANES], row.e[idx % LANES])
}

/// Range of the heading's deviation δ by the differences of every two rows of a direction: δ (gᵢ − gⱼ) ∈ mⱼ − mᵢ ± (eᵢ + eⱼ).
fn turn_by_pairs(rows: &[[Row; 4]], reach: f64) -> (f64, f64) {
    let mut turn = (-reach, reach);
    for direction in 0..4 {
        for i in 1..rows.len() * LANES {
            let (m, g, e) = entry(rows, direction, i);
            for j in 0..i {
                let (other_m, other_g, other_e) = entry(rows, direction, j);
                let slope = g - other_g;
                // Nearly equal slopes say nothing about δ, and would magnify the rounding error of their difference.
                if slope.abs() < 1e-3 {
                    continue;
                }
                let inverse = 1.0 / slope;
                let quotient = (other_m - m) * inverse;
                let slack = SLACK * (m.abs() + other_m.abs() + reach * (g.abs() + other_g.abs()));
                let spread = (e + other_e + slack) * inverse.abs() * (1.0 + SLACK) + SLACK * quotient.abs();
                turn = common(turn, (quotient - spread, quotient + spread));
            }
        }
    }
    turn
}

/// Range of the translation along a direction, by single rows over all δ, and by convex combinations of two rows in which δ cancels.
fn value_by_pairs(rows: &[[Row; 4]], direction: usize, turn: (f64, f64)) -> (f64, f64) {
    let mut value = (f64::NEG_INFINITY, f64::INFINITY);
    let reach = turn.0.abs().max(turn.1.abs());
    for i in 0..rows.len() * LANES {
        let (m, g, e) = entry(rows, direction, i);
        let slack = SLACK * (m.abs() + g.abs() * reach + e);
        let (at_lo, at_hi) = (g * turn.0, g * turn.1);
        value = common(value, (m - e + at_lo.min(at_hi) - slack, m + e + at_lo.max(at_hi) + slack));
        for j in 0..i {
            let (other_m, other_g, other_e) = entry(rows, direction, j);
            if g * other_g >= 0.0 {
                continue;
            }
            // The share λ solves λ gᵢ + (1 − λ) gⱼ = 0. What rounding leaves of that sum multiplies δ and is covered by the slack.
            let share = other_g.abs() / (g.abs() + other_g.abs());
            let rest = 1.0 - share;
            let middle = share * m + rest * other_m;
            let size = m.abs() + other_m.abs() + (g.abs() + other_g.abs()) * reach;
            let spread = (share * e + rest * other_e) * (1.0 + SLACK) + SLACK * size;
            value = common(value, (middle - spread, middle + spread));
        }
    }
    value
}
