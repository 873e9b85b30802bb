//! The planar pose from matched landmarks without bisection: from constraints that are linearised in the heading, the unknowns are eliminated one
//! after the other; then the heading is cut into thin slices, and each slice is contracted.

use interval::contractor::{Contractor, Outcome, settle};
use interval::{Interval, IntervalBox};

use super::RigidPlanar;
use super::rigid_planar::{CAUSE, common};
use super::rigid_rows::{About, LANES, Row, SLACK};

/// Contractor of the planar pose from matched landmarks, which needs no bisection.
///
/// **Constraint.** That of [`RigidPlanar`]: aᵢ = t + R(θ) bᵢ for all landmarks i, with the pose t, θ. This is a stronger contractor for it, because
/// it compares pairs of landmarks.
///
/// **Sound.** A row (`rigid_rows`) is the linearised constraint that one landmark puts on the translation's coordinate along one direction:
/// coordinate ∈ mᵢ + δ gᵢ ± eᵢ, where δ is the heading's deviation from the middle of its interval, and the coordinate is the *same* for all
/// landmarks i. The difference of two rows does not contain the coordinate, so it bounds δ. A convex combination of two rows with slopes g of
/// opposite sign does not contain δ, so it bounds the coordinate. Both are consequences of the rows, whatever the multipliers. The slices of
/// heading cover the whole heading interval.
///
/// **Optimal** for the linearised rows along x and y: in a linear problem with two unknowns (the coordinate and δ) a bound is always given by two
/// rows. What is lost is Lagrange's remainder (the error of the linearisation), which slices make as small as wanted: the more slices, the closer
/// the result is to the hull of the solutions.
///
/// **Source.** The elimination is Fourier and Motzkin's; its use on a linearisation with a rigorous remainder is that of A. Neumaier, *Interval
/// Methods for Systems of Equations*, Cambridge 1990, chapter 5.
#[derive(Clone, Debug)]
pub struct LinearPose {
    /// The matched landmarks, each as a box in the world frame and a box in the robot frame.
    pub motion: RigidPlanar,
    /// Number of slices into which the heading interval is cut once its bounds no longer improve by combining pairs of linearised constraints
    /// (elimination); 0 to leave the slices out.
    pub n_slices: usize,
}

/// Bounding the heading by pairs of linearised constraints is repeated, linearised about the new middle heading, as long as it narrows the heading
/// interval to less than this fraction of its width.
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
            // Where the vectors between landmarks leave a heading interval more than 3 rad wide, the error of linearising in the heading
            // (Lagrange's remainder) would exceed everything that combining pairs of landmarks can gain, so the interval is halved instead.
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
        // The translation can be counted from any point; a point near the solution makes the remainders of the linearisation small.
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

/// Range of δ, the heading's deviation from the middle heading. A row is one landmark's linearised constraint, coordinate of the translation ∈ mᵢ +
/// δ gᵢ ± eᵢ along one of four directions. The difference of every two rows of the same direction gives δ (gᵢ − gⱼ) ∈ mⱼ − mᵢ ± (eᵢ + eⱼ).
fn turn_by_pairs(rows: &[[Row; 4]], reach: f64) -> (f64, f64) {
    let mut turn = (-reach, reach);
    for direction in 0..4 {
        for i in 1..rows.len() * LANES {
            let (m, g, e) = entry(rows, direction, i);
            for j in 0..i {
                let (other_m, other_g, other_e) = entry(rows, direction, j);
                let slope = g - other_g;
                // Where the slopes gᵢ and gⱼ of two rows are nearly equal, their difference says nothing about δ and is mostly rounding error.
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

/// Range of the translation's coordinate along a direction, from the landmarks' rows coordinate ∈ mᵢ + δ gᵢ ± eᵢ: by each row for all heading
/// deviations δ in `turn`, and by convex combinations of two rows in which δ cancels.
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
            // The weight λ of the first of two rows solves λ gᵢ + (1 − λ) gⱼ = 0, so that δ cancels. What rounding leaves of that sum multiplies δ;
            // the term with `SLACK` covers it.
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
