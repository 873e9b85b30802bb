//! Certificates: bounds that follow from any dual vector, in interval arithmetic, whatever made that vector.
//!
//! For every solution x of a program and every vector y with one number for each row, c·x = y·Ax + r·x with r = c − Aᵀy. Row i says that
//! (Ax)ᵢ is in [loᵢ, hiᵢ], and the box that xⱼ is in Xⱼ, so that
//!
//! c·x ≥ Σᵢ min(yᵢ·[loᵢ, hiᵢ]) + Σⱼ min(rⱼ·Xⱼ).
//!
//! The right side is a lower bound for any y, and the optimum for an optimal y. Computed in interval arithmetic, with r as intervals, it is a lower
//! bound in spite of all rounding. A row with an open side has min(yᵢ·[loᵢ, hiᵢ]) = −∞ for one sign of yᵢ; a yᵢ of that sign counts as 0, and so
//! does one that is infinite or NaN.
//!
//! Sources: A. Neumaier, O. Shcherbina, "Safe bounds in linear and mixed-integer linear programming", Mathematical Programming 99 (2004),
//! section 3; C. Jansson, "Rigorous lower and upper bounds in linear programming", SIAM Journal on Optimization 14 (2004).

use super::program::{LinearProgram, Terms};
use crate::Interval;

/// A lower bound of the cost c·x over all solutions x of the program, for any dual vector `duals`, of which number i belongs to row i.
///
/// Missing duals count as 0, as do infinite duals, NaN, and duals whose sign asks for a side that the row leaves open. The bound is −∞ when the
/// cost is not a function of the program's variables with finite coefficients. It may exceed the cost's greatest value on the box: then
/// the program has no solution.
pub fn certified_minimum(program: &LinearProgram, cost: &Terms, duals: &[f64]) -> f64 {
    let Some(remainder) = reduced_costs(program, cost, duals) else { return f64::NEG_INFINITY };
    let rows = (0..program.n_rows()).filter_map(|row| {
        let (dual, side) = effective(program, row, duals)?;
        Some(Interval::point(side) * dual)
    });
    let columns = remainder.iter().zip(program.variables()).map(|(&reduced, &values)| reduced * values);
    rows.chain(columns).fold(Interval::ZERO, |sum, part| sum + part).lo()
}

/// An upper bound of the cost c·x over all solutions of the program, for duals that belong to the minimum of −c·x.
pub fn certified_maximum(program: &LinearProgram, cost: &Terms, duals: &[f64]) -> f64 {
    let negated: Vec<_> = cost.iter().map(|&(variable, coefficient)| (variable, -coefficient)).collect();
    -certified_minimum(program, &negated, duals)
}

/// A lower bound of c·x over all points of the box that satisfy the rows of all groups but at most `n_wrong`, whichever these are, for any dual
/// vector as in [`certified_minimum`].
///
/// `group_of` gives the group of a row; a row without a group is never wrong. Where each row is a group of its own, as with the function `Some`, up
/// to `n_wrong` rows may be wrong.
///
/// **Rigorous.** Let x be such a point and G the rows of the wrong groups. As above, c·x = Σᵢ yᵢ(Ax)ᵢ + r·x. For i ∉ G the term yᵢ(Ax)ᵢ is at
/// least min(yᵢ·[loᵢ, hiᵢ]). For i ∈ G it is at least min(yᵢ·rangeᵢ), where rangeᵢ are the values of row i over the whole box. Hence
/// c·x ≥ bound − Σ_{i∈G} lossᵢ, with the bound of all rows and lossᵢ = max(0, min(yᵢ·[loᵢ, hiᵢ]) − min(yᵢ·rangeᵢ)). The last sum is over at most
/// `n_wrong` groups, and thus at most the sum of the `n_wrong` greatest losses of a group. No choice of groups needs to be tried.
pub fn certified_minimum_despite(
    program: &LinearProgram,
    cost: &Terms,
    duals: &[f64],
    n_wrong: usize,
    group_of: impl Fn(usize) -> Option<usize>,
) -> f64 {
    let mut losses: Vec<(usize, f64)> = (0..program.n_rows())
        .filter_map(|row| {
            let (group, (dual, side)) = (group_of(row)?, effective(program, row, duals)?);
            let lost = Interval::point(side) * dual - program.range(program.terms(row)) * dual;
            Some((group, lost.hi().max(0.0)))
        })
        .collect();
    losses.sort_by_key(|&(group, _)| group);
    let mut by_group: Vec<Interval> = losses
        .chunk_by(|a, b| a.0 == b.0)
        .map(|group| group.iter().fold(Interval::ZERO, |sum, &(_, loss)| sum + Interval::new(0.0, loss)))
        .collect();
    by_group.sort_by(|a, b| b.hi().total_cmp(&a.hi()));
    let bound = certified_minimum(program, cost, duals);
    if bound == f64::NEG_INFINITY {
        return bound;
    }
    by_group.iter().take(n_wrong).fold(Interval::new(bound, f64::INFINITY), |left, &loss| left - loss).lo()
}

/// The rows that contradict each other, when the duals certify that no point of the box satisfies them all: those with a dual that counts. `None`
/// when these duals certify nothing.
///
/// The certificate is a positive lower bound of the cost 0, which every solution would have.
pub fn contradicting_rows(program: &LinearProgram, duals: &[f64]) -> Option<Vec<usize>> {
    let is_certified = certified_minimum(program, &[], duals) > 0.0;
    is_certified.then(|| (0..program.n_rows()).filter(|&row| effective(program, row, duals).is_some()).collect())
}

/// What a certified bound consists of: the value that the duals give in the middle of all intervals, and by how much the half width of each interval
/// moves the bound away from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    /// Σ yᵢ·mid[loᵢ, hiᵢ] + Σ rⱼ·mid(Xⱼ).
    pub middle: f64,
    /// |yᵢ| times the half width of the row's interval, for each row. A row with an open side has no half width; its other side counts as its
    /// middle.
    pub rows: Vec<f64>,
    /// |rⱼ| times the half width of the variable's interval, for each variable.
    pub variables: Vec<f64>,
}

/// The parts of the bound that [`certified_minimum`] gives for the same duals, but for rounding: it is the middle less all shares. `None` when the
/// cost is not a function of the program's variables.
pub fn shares(program: &LinearProgram, cost: &Terms, duals: &[f64]) -> Option<Shares> {
    let reduced = reduced_costs(program, cost, duals)?;
    let mut shares = Shares { middle: 0.0, rows: vec![0.0; program.n_rows()], variables: Vec::new() };
    for (row, share) in shares.rows.iter_mut().enumerate() {
        let Some((dual, side)) = effective(program, row, duals) else { continue };
        let sides = program.sides(row);
        *share = if sides.is_bounded() { dual.abs() * sides.radius() } else { 0.0 };
        shares.middle += dual * if sides.is_bounded() { sides.mid() } else { side };
    }
    for (reduced, values) in reduced.iter().zip(program.variables()) {
        shares.middle += reduced.mid() * values.mid();
        shares.variables.push(reduced.mid().abs() * values.radius());
    }
    Some(shares)
}

/// The dual of a row with the side of the row that it multiplies, lo for a positive dual and hi for a negative one. `None` for a dual that
/// counts as 0.
fn effective(program: &LinearProgram, row: usize, duals: &[f64]) -> Option<(f64, f64)> {
    let dual = duals.get(row).copied().filter(|dual| dual.is_finite() && *dual != 0.0)?;
    let side = if dual > 0.0 { program.sides(row).lo() } else { program.sides(row).hi() };
    side.is_finite().then_some((dual, side))
}

/// Enclosures of r = c − Aᵀy, one for each variable; `None` when the cost is not a function of the program's variables.
fn reduced_costs(program: &LinearProgram, cost: &Terms, duals: &[f64]) -> Option<Vec<Interval>> {
    let mut reduced = vec![Interval::ZERO; program.n_variables()];
    for &(variable, coefficient) in cost {
        *reduced.get_mut(variable).filter(|_| coefficient.is_finite())? += coefficient;
    }
    for row in 0..program.n_rows() {
        let Some((dual, _)) = effective(program, row, duals) else { continue };
        for &(variable, coefficient) in program.terms(row) {
            reduced[variable] -= Interval::point(coefficient) * dual;
        }
    }
    Some(reduced)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use num_rational::BigRational;
    use num_traits::ToPrimitive;

    use super::*;

    /// x ∈ [0, 4], y ∈ [0, 3]; row 0: x + y ≥ 2, row 1: x − y = 1.
    fn by_hand() -> LinearProgram {
        let mut program = LinearProgram::new(vec![Interval::new(0.0, 4.0), Interval::new(0.0, 3.0)]).unwrap();
        program.add_row(&[(0, 1.0), (1, 1.0)], Interval::new(2.0, f64::INFINITY)).unwrap();
        program.add_row(&[(0, 1.0), (1, -1.0)], Interval::point(1.0)).unwrap();
        program
    }

    fn is_just_below(bound: f64, value: f64) -> bool {
        value - 1e-12 < bound && bound <= value
    }

    #[test]
    fn optimal_duals_certify_the_optimum() {
        // The least x is where both rows are equations: x = 3/2, y = 1/2, with duals (1/2, 1/2), because x = (x + y)/2 + (x − y)/2.
        assert!(is_just_below(certified_minimum(&by_hand(), &[(0, 1.0)], &[0.5, 0.5]), 1.5));
        // The greatest x is 4, where the box ends.
        let greatest = certified_maximum(&by_hand(), &[(0, 1.0)], &[]);
        assert!((4.0..4.0 + 1e-12).contains(&greatest), "{greatest}");
    }

    #[test]
    fn any_duals_certify_some_bound() {
        // With duals (1, 0): x ≥ 2 + min(0·x − y) = 2 − 3.
        assert!(is_just_below(certified_minimum(&by_hand(), &[(0, 1.0)], &[1.0]), -1.0));
        // The dual −1 of row 0 asks for its open side, and NaN is no number: both count as 0, which leaves x ≥ 0.
        assert_eq!(certified_minimum(&by_hand(), &[(0, 1.0)], &[-1.0, f64::NAN]), 0.0);
        assert_eq!(certified_minimum(&by_hand(), &[(0, 1.0)], &[f64::INFINITY, f64::NEG_INFINITY, 7.0]), 0.0);
        assert_eq!(certified_minimum(&by_hand(), &[(2, 1.0)], &[]), f64::NEG_INFINITY);
        assert_eq!(certified_minimum(&by_hand(), &[(0, f64::NAN)], &[]), f64::NEG_INFINITY);
    }

    /// A number from 0 to 1, by the generator xorshift64.
    fn next(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number of either sign whose size is between 10⁻³ and 10³.
    fn any(state: &mut u64) -> f64 {
        let size = 10f64.powf(6.0 * next(state) - 3.0);
        if next(state) < 0.5 { -size } else { size }
    }

    #[test]
    fn no_duals_exclude_a_planted_solution() {
        let state = &mut 20261123;
        for round in 0..10_000 {
            let solution: Vec<f64> = (0..1 + round % 6).map(|_| any(state)).collect();
            let around = |at: &f64, state: &mut u64| match next(state) {
                share if share < 0.3 => Interval::point(*at),
                share => Interval::new(at - share * any(state).abs(), at + any(state).abs()),
            };
            let variables = solution.iter().map(|at| around(at, state)).collect();
            let mut program = LinearProgram::new(variables).unwrap();
            let terms = |state: &mut u64| -> Vec<(usize, f64)> {
                let mut terms: Vec<(usize, f64)> = (0..solution.len()).map(|j| (j, any(state))).collect();
                terms.retain(|_| next(state) < 0.7);
                terms
            };
            let value = |terms: &Terms| -> Interval {
                terms.iter().fold(Interval::ZERO, |sum, &(j, a)| sum + Interval::point(solution[j]) * a)
            };
            // Equations, to rounding; bands; rows with one open side. The solution lies at an end of most of them.
            for _ in 0..round % 9 {
                let (row, kind) = (terms(state), next(state));
                let (at, wide) = (value(&row), any(state).abs());
                let sides = match kind {
                    kind if kind < 0.4 => at,
                    kind if kind < 0.6 => Interval::new(at.lo(), at.hi() + wide),
                    kind if kind < 0.8 => Interval::new(f64::NEG_INFINITY, at.hi()),
                    _ => Interval::new(at.lo() - wide, f64::INFINITY),
                };
                program.add_row(&row, sides).unwrap();
            }
            // One more row that the solution violates by far.
            let (mut spoilt, wrong) = (program.clone(), terms(state));
            spoilt.add_row(&wrong, value(&wrong) + Interval::point(10.0 * any(state))).unwrap();
            let duals: Vec<f64> = (0..spoilt.n_rows()).map(|_| any(state)).collect();
            let cost = terms(state);
            assert!(certified_minimum(&program, &cost, &duals) <= value(&cost).hi(), "round {round}");
            assert!(certified_maximum(&program, &cost, &duals) >= value(&cost).lo(), "round {round}");
            assert_eq!(contradicting_rows(&program, &duals), None, "round {round}");
            assert!(certified_minimum_despite(&spoilt, &cost, &duals, 1, Some) <= value(&cost).hi(), "round {round}");
        }
    }

    /// The least value of Σ yᵢ·[loᵢ, hiᵢ] + (c − Aᵀy)·X, without any rounding. Duals of open sides count as 0.
    fn exact_bound(program: &LinearProgram, cost: &Terms, duals: &[f64]) -> BigRational {
        let exact = |number: f64| BigRational::from_float(number).unwrap();
        let least =
            |factor: &BigRational, range: Interval| (factor * exact(range.lo())).min(factor * exact(range.hi()));
        let mut reduced = vec![exact(0.0); program.n_variables()];
        for &(variable, coefficient) in cost {
            reduced[variable] += exact(coefficient);
        }
        let mut bound = exact(0.0);
        for (row, &dual) in duals.iter().enumerate() {
            let side = if dual > 0.0 { program.sides(row).lo() } else { program.sides(row).hi() };
            if dual == 0.0 || !side.is_finite() {
                continue;
            }
            bound += exact(dual) * exact(side);
            for &(variable, coefficient) in program.terms(row) {
                reduced[variable] -= exact(dual) * exact(coefficient);
            }
        }
        reduced.iter().zip(program.variables()).fold(bound, |bound, (factor, &range)| bound + least(factor, range))
    }

    #[test]
    fn certified_bounds_are_just_below_the_exact_ones() {
        let state = &mut 20261124;
        let (mut n_above, mut worst) = (0, 0.0_f64);
        for round in 0..10_000 {
            let n_variables = 1 + round % 4;
            // A box of one point each now and then: nothing but rounding is then between the certified bound and the exact one.
            let variables = (0..n_variables).map(|_| {
                let at = any(state);
                if next(state) < 0.5 { Interval::point(at) } else { Interval::new(at, at + any(state).abs()) }
            });
            let mut program = LinearProgram::new(variables.collect()).unwrap();
            let terms = |state: &mut u64| (0..n_variables).map(|j| (j, any(state))).collect::<Vec<_>>();
            for _ in 0..round % 5 {
                let (row, at) = (terms(state), any(state));
                let sides = match next(state) {
                    kind if kind < 0.4 => Interval::point(at),
                    kind if kind < 0.8 => Interval::new(at, at + any(state).abs()),
                    kind if kind < 0.9 => Interval::new(at, f64::INFINITY),
                    _ => Interval::new(f64::NEG_INFINITY, at),
                };
                program.add_row(&row, sides).unwrap();
            }
            let cost = terms(state);
            let duals: Vec<f64> = (0..program.n_rows()).map(|_| any(state)).collect();
            let (certified, exact) = (certified_minimum(&program, &cost, &duals), exact_bound(&program, &cost, &duals));
            n_above += usize::from(BigRational::from_float(certified).unwrap() > exact);
            // What rounding costs, in units of the size of the terms that are added up.
            let size = program.n_rows() as f64 * 1e9 + 1e6;
            let gap = (exact - BigRational::from_float(certified).unwrap()).to_f64().unwrap();
            worst = worst.max(gap / size);
        }
        assert_eq!(n_above, 0, "certified bounds above the exact one");
        assert!(worst < 1e-14, "{worst}");
    }

    #[test]
    fn a_bound_is_its_middle_less_the_shares_of_all_intervals() {
        // Duals (1/2, 1/2) bound x from below: half of row 0, whose other side is open, gives 1, and half of the equation of row 1 gives 1/2.
        let by_rows = shares(&by_hand(), &[(0, 1.0)], &[0.5, 0.5]).unwrap();
        assert!((by_rows.middle - 1.5).abs() < 1e-12 && by_rows.rows == [0.0, 0.0], "{by_rows:?}");
        // Without rows the box of x alone bounds it: 2 ± 2.
        let by_box = shares(&by_hand(), &[(0, 1.0)], &[]).unwrap();
        assert!((by_box.middle - 2.0).abs() < 1e-12 && (by_box.variables[0] - 2.0).abs() < 1e-12, "{by_box:?}");
        // With x + y within [2, 3] in a box of half widths 2 and 3/2, the dual 1/2 leaves x/2 − y/2: 1/2·(5/2 ± 1/2) + 1/2·(2 ± 2) − 1/2·(3/2 ± 3/2).
        let mut program = LinearProgram::new(vec![Interval::new(0.0, 4.0), Interval::new(0.0, 3.0)]).unwrap();
        program.add_row(&[(0, 1.0), (1, 1.0)], Interval::new(2.0, 3.0)).unwrap();
        let both = shares(&program, &[(0, 1.0)], &[0.5]).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(close(both.middle, 1.5) && close(both.rows[0], 0.25), "{both:?}");
        assert!(close(both.variables[0], 1.0) && close(both.variables[1], 0.75), "{both:?}");
        let bound = certified_minimum(&program, &[(0, 1.0)], &[0.5]);
        assert!(close(bound, 1.5 - 0.25 - 1.75), "{bound}");
    }

    #[test]
    fn huge_duals_give_an_infinite_bound_and_never_nan() {
        for dual in [f64::MAX, f64::MIN, 1e300, 5e-324] {
            let bound = certified_minimum(&by_hand(), &[(0, 1.0)], &[dual, -dual]);
            assert!(bound <= 1.5, "{dual}: {bound}");
        }
    }

    #[test]
    fn a_contradiction_names_its_rows() {
        let mut program = by_hand();
        program.add_row(&[(1, 1.0)], Interval::new(0.0, 2.5)).unwrap();
        assert_eq!(contradicting_rows(&program, &[0.5, 0.5, 0.0]), None);
        // x ≤ 1/2 contradicts x = 1 + y with y ≥ 0: the dual 1 of row 1 and −1 of row 3 sum up to −y ≥ 1/2.
        program.add_row(&[(0, 1.0)], Interval::new(0.0, 0.5)).unwrap();
        assert_eq!(contradicting_rows(&program, &[0.0, 1.0, 0.0, -1.0]), Some(vec![1, 3]));
        assert_eq!(contradicting_rows(&program, &[0.0, -1.0, 0.0, 1.0]), None);
    }

    #[test]
    fn one_wrong_row_costs_its_loss() {
        // Three readings of x ∈ [0, 10]: at least 4, at least 5, at least 7.
        let mut program = LinearProgram::new(vec![Interval::new(0.0, 10.0)]).unwrap();
        for least in [4.0, 5.0, 7.0] {
            program.add_row(&[(0, 1.0)], Interval::new(least, 10.0)).unwrap();
        }
        // A third of each dual: x ≥ (4 + 5 + 7)/3. Without the third row, whose range begins at 0, 7/3 less; without the last two, 12/3 less.
        let duals = [1.0 / 3.0; 3];
        let least = |n_wrong, groups: [Option<usize>; 3]| {
            certified_minimum_despite(&program, &[(0, 1.0)], &duals, n_wrong, |row| groups[row])
        };
        let each = [Some(0), Some(1), Some(2)];
        assert!((least(0, each) - 16.0 / 3.0).abs() < 1e-12);
        assert!((least(1, each) - 3.0).abs() < 1e-12);
        assert!((least(2, each) - 4.0 / 3.0).abs() < 1e-12);
        assert!(least(3, each).abs() < 1e-12 && least(9, each).abs() < 1e-12);
        // The last two rows as one group: 12/3 less. Rows without a group stay.
        assert!((least(1, [Some(7), Some(3), Some(3)]) - 4.0 / 3.0).abs() < 1e-12);
        assert!((least(2, [None, None, Some(3)]) - 3.0).abs() < 1e-12);
    }
}
