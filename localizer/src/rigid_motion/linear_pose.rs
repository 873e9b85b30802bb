//! The planar pose from matched landmarks in one shot: linear elimination, then thin slices of heading.

use interval::contractor::{Contractor, Outcome, settle};
use interval::{Interval, IntervalBox};

use super::RigidPlanar;
use super::rigid_planar::{CAUSE, common};
use super::rigid_rows::{About, LANES, Row, SLACK};

/// Pose boxes without bisection.
///
/// **Constraint.** That of [`RigidPlanar`], of which this is a stronger contractor: it looks at pairs of landmarks.
///
/// **Sound.** Each row says value ∈ mᵢ + δ gᵢ ± eᵢ (`rigid_rows`) with the *same* value for all landmarks i. The difference of two
/// rows has no translation in it and bounds δ; a convex combination of two rows with slopes of opposite sign has no δ in it and bounds the
/// translation. Both are consequences of the rows, whatever the multipliers. Slices of heading cover the heading.
///
/// **Optimal** for the linearised rows along x and y: in a linear problem with two unknowns a bound is always given by two rows.
/// What is lost is Lagrange's remainder, which slices make as small as wanted: with k slices the result tends to the hull of the solutions.
///
/// **Source.** The elimination is Fourier and Motzkin's; its use on a linearisation with a rigorous remainder is that of
/// A. Neumaier, *Interval Methods for Systems of Equations*, Cambridge 1990, chapter 5.
#[derive(Clone, Debug)]
pub struct LinearPose {
    /// The landmarks in both frames.
    pub motion: RigidPlanar,
    /// Slices of heading after the elimination; 0 for the elimination alone.
    pub n_slices: usize,
}

/// Elimination is repeated about the new middle while the heading shrinks by at least this share.
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
            // Without a baseline that decides the heading, the remainder would swallow everything.
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
        // Any point serves as the origin of the translation; a good one makes the remainders small.
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

/// δ from the difference of every two rows of a direction: δ (gᵢ − gⱼ) ∈ mⱼ − mᵢ ± (eᵢ + eⱼ).
fn turn_by_pairs(rows: &[[Row; 4]], reach: f64) -> (f64, f64) {
    let mut turn = (-reach, reach);
    for direction in 0..4 {
        for i in 1..rows.len() * LANES {
            let (m, g, e) = entry(rows, direction, i);
            for j in 0..i {
                let (other_m, other_g, other_e) = entry(rows, direction, j);
                let slope = g - other_g;
                // Nearly equal slopes tell nothing, and would magnify the rounding of their difference.
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

/// The value of a direction from single rows over all δ, and from convex combinations of two rows that cancel δ.
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
            // λ gᵢ + (1 − λ) gⱼ = 0; what rounding leaves of it multiplies δ and is in the slack.
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
