//! Bounds of the pose by the items of a reading, such as the sightings of an image, of which a few may be wrong.
//!
//! **Choices.** The items are dealt into groups. If at most q items are wrong, at most q groups have a wrong one, so that the truth satisfies the rows of
//! all others for some choice of q groups. Bounds over all choices enclose it.
//!
//! **Switches.** Where q is greater, choices are many. Of an item that is right, every row holds: lo ≤ a·x ≤ hi. Of a wrong one nothing is known but that
//! x is in its box, over which a·x is between r and s. With t = 0 for an item that is right and t = 1 for a wrong one, both cases are
//!
//! a·x − (s − hi)·t ≤ hi and a·x + (lo − r)·t ≥ lo,
//!
//! and Σ t ≤ q. One linear program takes any t from 0 to 1, so that its bounds hold for every choice of wrong items. They are the closer, the narrower
//! the box of x is and the more items say the same.
//!
//! Quantities of one item alone, such as the place of its landmark, are enclosed over their intervals, and two rows of the item are combined so that
//! the quantity drops out which they share most of.
//!
//! Source: choices are those of L. Jaulin, "Robust set-membership state estimation; application to underwater robotics", Automatica 45 (2009), by groups;
//! switches are the usual relaxation ("big M") of integer programming. Duals certify all bounds, as [`interval::linear_program`] describes.

use std::collections::BTreeMap;

use interval::{
    Interval,
    linear_program::{LinearProgram, ProgramError, Solver, Terms},
};

use crate::PoseBox;

use super::{Domain, Relations, Row, Variable, related::certified_bounds};

/// Greatest number of wrong items with which groups are left out: for one wrong item there are five programs, for two fifteen.
const MOST_LEFT_OUT: usize = 2;
/// Groups beyond those that may have a wrong item. With eight, and so nine programs for one wrong item, the boxes of the furnished room of
/// `scenes/landmarks` are 1 to 7 % wider. With switches in place of choices they are up to a third wider.
const MORE_GROUPS: usize = 4;

/// The items of a reading at a pose of which a box is known, as linear programs. Rows are made about the middle of the box.
pub(crate) struct DespiteWrong {
    domain: Domain,
    variables: Vec<Variable>,
    /// In each of the programs the wrong items are left out or have a switch: the truth satisfies one of them at least.
    programs: Vec<LinearProgram>,
    /// Rows of the pose alone, for each the coefficients of x, y and heading and the half width of its sides: what the items say of the pose, if all
    /// other quantities are enclosed.
    pub(crate) on_pose: Vec<([f64; 3], f64)>,
}

impl DespiteWrong {
    /// The programs of some items of which at most `most_wrong` are wrong. Items that are next to each other are left out in different programs. `None`
    /// where more items are certainly wrong, or where a quantity is empty.
    pub(crate) fn new(pose: &PoseBox, items: &[&dyn Relations], most_wrong: usize) -> Option<DespiteWrong> {
        let domain = domain_of(pose, items)?;
        let mut left_wrong = most_wrong;
        let mut certain: Vec<Vec<Row>> = Vec::new();
        for item in items {
            let rows = without_own(item.rows(FRAME, &domain), &domain);
            if rows.iter().any(|row| range(row, &domain).intersect(row.sides).is_empty()) {
                left_wrong = left_wrong.checked_sub(1)?;
            } else {
                certain.push(rows);
            }
        }
        let named = certain.iter().flatten().flat_map(|row| &row.terms).map(|&(variable, _)| variable);
        let mut variables: Vec<Variable> = (0..3).map(|axis| Variable::Pose(FRAME, axis)).chain(named).collect();
        variables.sort_unstable();
        variables.dedup();
        let on_pose = certain.iter().flatten().map(|row| of_pose(row, &domain)).collect();
        let n_groups = left_wrong + MORE_GROUPS;
        let mut programs = Vec::new();
        if left_wrong <= MOST_LEFT_OUT && certain.len() >= n_groups {
            for choice in choices(n_groups, left_wrong) {
                let used = certain.iter().enumerate().filter(|(at, _)| !choice.contains(&(at % n_groups)));
                let used: Vec<&[Row]> = used.map(|(_, rows)| rows.as_slice()).collect();
                programs.push(program(&domain, &variables, &used, 0)?);
            }
        } else {
            let all: Vec<&[Row]> = certain.iter().map(Vec::as_slice).collect();
            programs.push(program(&domain, &variables, &all, left_wrong)?);
        }
        Some(DespiteWrong { domain, variables, programs, on_pose })
    }

    /// Bounds of linear functions c·(x, y, heading) of the pose, in the order of the coefficients given. `None` where no pose satisfies the rows.
    pub(crate) fn bounds(&self, functions: &[[f64; 3]]) -> Option<Vec<Interval>> {
        let of_pose = |c: &[f64; 3]| (0..3).map(|axis| (Variable::Pose(FRAME, axis), c[axis])).collect();
        self.bounds_of_all(&functions.iter().map(of_pose).collect::<Vec<_>>())
    }

    /// Bounds of linear functions of the pose and of other quantities of the items, in the order given. `None` where nothing satisfies the rows.
    pub(crate) fn bounds_of_all(&self, functions: &[Vec<(Variable, f64)>]) -> Option<Vec<Interval>> {
        let mut hull: Option<Vec<Interval>> = None;
        for program in &self.programs {
            let Some(bounds) = self.bounds_of(program, functions) else { continue };
            hull = Some(match hull {
                Some(hull) => hull.into_iter().zip(bounds).map(|(hull, bound)| hull.hull(bound)).collect(),
                None => bounds,
            });
        }
        hull
    }

    fn bounds_of(&self, program: &LinearProgram, functions: &[Vec<(Variable, f64)>]) -> Option<Vec<Interval>> {
        let mut solver = Solver::new(program);
        let bound = |function: &Vec<(Variable, f64)>| {
            let named = function.iter().filter(|(_, a)| *a != 0.0);
            let index = |&(variable, a): &(Variable, f64)| Some((self.variables.binary_search(&variable).ok()?, a));
            // A quantity that no item names is within its interval.
            let (terms, unnamed): (Vec<_>, Vec<_>) = named.partition(|one| index(one).is_some());
            let terms: Vec<(usize, f64)> = terms.into_iter().filter_map(index).collect();
            let rest = unnamed.into_iter().map(|&(variable, a)| self.domain.value(variable) * a);
            let rest = rest.fold(Interval::ZERO, |sum, part| sum + part);
            let reference = terms
                .iter()
                .fold(rest, |sum, &(at, a)| sum + Interval::point(self.domain.reference(self.variables[at])) * a);
            certified_bounds(program, &mut solver, &terms).map(|bounds| reference + bounds)
        };
        functions.iter().map(bound).collect()
    }
}

/// All choices of `most` of the numbers below `n`.
pub(crate) fn choices(n: usize, most: usize) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for _ in 0..most {
        let longer = |choice: &Vec<usize>| {
            let first = choice.last().map_or(0, |last| last + 1);
            (first..n).map(|next| [&choice[..], &[next]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// Number of the key frame in a program of one reading.
const FRAME: usize = 0;

/// The pose and the items' quantities; `None` where nothing is left of one of them.
fn domain_of(pose: &PoseBox, items: &[&dyn Relations]) -> Option<Domain> {
    let of_pose = (0..3).map(|axis| (Variable::Pose(FRAME, axis), pose[axis]));
    let mut values: BTreeMap<Variable, Interval> = of_pose.collect();
    for (variable, value) in items.iter().flat_map(|item| item.quantities(FRAME, pose)) {
        let known = values.entry(variable).or_insert(Interval::ENTIRE);
        *known = known.intersect(value);
    }
    if values.values().any(|value| value.is_empty()) {
        return None;
    }
    let mut domain = Domain::default();
    values
        .into_iter()
        .filter(|(_, value)| value.is_bounded())
        .for_each(|(variable, value)| domain.put(variable, value));
    Some(domain)
}

/// The rows of an item without the quantities that are its own, and the combination of two of them in which the one drops out that makes most of both.
fn without_own(rows: Vec<Row>, domain: &Domain) -> Vec<Row> {
    let rows = if rows.len() > 2 { with_view(&rows, domain) } else { rows };
    let is_own = |variable: Variable| matches!(variable, Variable::Point(..) | Variable::Landmark(..));
    let share = |row: &Row, variable| (row.coefficient(variable) * domain.value(variable).radius()).abs();
    let values: Vec<Row> = rows.iter().map(|row| row.in_values(domain)).collect();
    let mut left: Vec<Row> = values.iter().map(|row| Row::sum(&[(1.0, row)], is_own, domain)).collect();
    if let [first, second] = values.as_slice() {
        let own = first.terms.iter().map(|&(variable, _)| variable).filter(|&variable| is_own(variable));
        let of_both = |&variable: &Variable| share(first, variable).min(share(second, variable));
        let most = own.max_by(|a, b| of_both(a).total_cmp(&of_both(b)));
        if let Some(variable) = most.filter(|variable| of_both(variable) > 0.0) {
            let [a, b] = [first, second].map(|row| row.coefficient(variable));
            let longest = a.abs().max(b.abs());
            left.push(Row::sum(&[(b / longest, first), (-a / longest, second)], is_own, domain));
        }
    }
    left.into_iter().map(|row| row.about(domain)).collect()
}

/// Two rows of a picture and two of another picture of the same point: the first two with such multiples of the others that both slopes of the point drop
/// out, which leave its depth.
fn with_view(rows: &[Row], domain: &Domain) -> Vec<Row> {
    let [.., first, second] = rows else { return rows.to_vec() };
    let slopes: Vec<Variable> = rows.iter().flat_map(|row| &row.terms).map(|&(variable, _)| variable).collect();
    let slope = |k: usize| slopes.iter().copied().find(|one| matches!(one, Variable::Point(_, of) if *of == k));
    let (Some(alpha), Some(beta)) = (slope(0), slope(1)) else { return rows[..2].to_vec() };
    let a = [first, second].map(|row| [alpha, beta].map(|one| row.coefficient(one)));
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    let values: Vec<Row> = rows.iter().map(|row| row.in_values(domain)).collect();
    let combined = |row: &Row| {
        let b = [alpha, beta].map(|one| row.coefficient(one));
        let by_first = (b[1] * a[1][0] - b[0] * a[1][1]) / determinant;
        let by_second = (b[0] * a[0][1] - b[1] * a[0][0]) / determinant;
        let is_told = by_first.is_finite() && by_second.is_finite();
        is_told.then(|| {
            let parts = [(1.0, row), (by_first, &values[2]), (by_second, &values[3])];
            Row::sum(&parts, |one| one == alpha || one == beta, domain).about(domain)
        })
    };
    let left: Option<Vec<Row>> = values[..2].iter().map(combined).collect();
    left.unwrap_or_else(|| rows[..2].to_vec())
}

/// Values of a row's left side over the domain.
fn range(row: &Row, domain: &Domain) -> Interval {
    let parts = row.terms.iter().map(|&(variable, a)| domain.deviation(variable) * a);
    parts.fold(Interval::ZERO, |sum, part| sum + part)
}

/// What a row says of the pose if all other quantities are enclosed but those of the pose of a view, relative to which it tells most.
fn of_pose(row: &Row, domain: &Domain) -> ([f64; 3], f64) {
    let coefficients = [0, 1, 2].map(|axis| row.coefficient(Variable::Pose(FRAME, axis)));
    let others =
        row.terms.iter().filter(|(variable, _)| !matches!(variable, Variable::Pose(..) | Variable::ViewPose(..)));
    let rest: f64 = others.map(|&(variable, a)| a.abs() * domain.deviation(variable).magnitude()).sum();
    (coefficients, row.sides.radius() + rest)
}

/// The program: the variables in the given order, then one switch for each item that may be wrong.
fn program(domain: &Domain, variables: &[Variable], items: &[&[Row]], most_wrong: usize) -> Option<LinearProgram> {
    let n_switches = if most_wrong == 0 { 0 } else { items.len() };
    let deviations = variables.iter().map(|&variable| domain.deviation(variable));
    let switches = std::iter::repeat_n(Interval::new(0.0, 1.0), n_switches);
    let mut program = LinearProgram::new(deviations.chain(switches).collect()).ok()?;
    for (at, row) in items.iter().enumerate().flat_map(|(at, rows)| rows.iter().map(move |row| (at, row))) {
        let index = |&(variable, a): &(Variable, f64)| Some((variables.binary_search(&variable).ok()?, a));
        let terms: Option<Vec<(usize, f64)>> = row.terms.iter().map(index).collect();
        let mut terms = terms?;
        let sides = row.sides;
        if n_switches == 0 {
            add(&mut program, &terms, sides)?;
            continue;
        }
        let range = range(row, domain);
        let above = (Interval::point(range.hi()) - sides.hi()).hi();
        let below = (Interval::point(sides.lo()) - range.lo()).hi();
        terms.push((variables.len() + at, 0.0));
        let last = terms.len() - 1;
        if above > 0.0 {
            terms[last].1 = -above;
            add(&mut program, &terms, Interval::new((Interval::point(range.lo()) - above).lo(), sides.hi()))?;
        }
        if below > 0.0 {
            terms[last].1 = below;
            add(&mut program, &terms, Interval::new(sides.lo(), (Interval::point(range.hi()) + below).hi()))?;
        }
    }
    if n_switches > 0 {
        let all: Vec<(usize, f64)> = (variables.len()..variables.len() + n_switches).map(|at| (at, 1.0)).collect();
        let all: &Terms = &all;
        add(&mut program, all, Interval::new(0.0, most_wrong as f64))?;
    }
    Some(program)
}

/// Adds a row to a program; `None` where nothing can satisfy it. A row whose coefficients are no finite numbers says nothing, and is left out.
fn add(program: &mut LinearProgram, terms: &Terms, sides: Interval) -> Option<()> {
    match program.add_row(terms, sides) {
        Err(ProgramError::EmptyRow { .. }) => None,
        Ok(_) | Err(_) => Some(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::{bounds, bounds::Assumption, graph::Stray, graph::trial::Draw};

    /// An item that says a·(x, y, heading) ∈ sides.
    struct Says([f64; 3], Interval);

    impl Relations for Says {
        fn quantities(&self, _frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
            Vec::new()
        }

        fn stamp_error_s(&self) -> f64 {
            0.0
        }

        fn stamp_bound(&self) -> Assumption {
            bounds::FORWARD_CAMERA_STAMP
        }

        fn shift_m(&self, _stray: &Stray) -> f64 {
            0.0
        }

        fn shift_parts(&self, _stray: &Stray) -> Vec<(Assumption, f64)> {
            Vec::new()
        }

        fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
            let terms = [0, 1, 2].map(|axis| (Variable::Pose(frame, axis), Interval::point(self.0[axis])));
            vec![Row::new(domain, &terms, self.1).about(domain)]
        }
    }

    fn bounds_of(items: &[Says], most_wrong: usize, function: [f64; 3]) -> Option<Interval> {
        let pose = PoseBox::from([Interval::new(-10.0, 10.0), Interval::new(-10.0, 10.0), Interval::new(-0.1, 0.1)]);
        let items: Vec<&dyn Relations> = items.iter().map(|one| one as &dyn Relations).collect();
        Some(DespiteWrong::new(&pose, &items, most_wrong)?.bounds(&[function])?[0])
    }

    fn is_near(found: Option<Interval>, [lo, hi]: [f64; 2]) -> bool {
        found.is_some_and(|found| (found.lo() - lo).abs() < 1e-3 && (found.hi() - hi).abs() < 1e-3)
    }

    #[test]
    fn one_of_five_items_may_be_wrong() {
        let along_x = |lo, hi| Says([1.0, 0.0, 0.0], Interval::new(lo, hi));
        let items =
            || vec![along_x(0.0, 1.0), along_x(0.5, 2.0), along_x(0.4, 3.0), along_x(-1.0, 4.0), along_x(0.2, 5.0)];
        // Without the first x is in [0.5, 2], without the second in [0.4, 1], without any other in [0.5, 1].
        assert!(is_near(bounds_of(&items(), 1, [1.0, 0.0, 0.0]), [0.4, 2.0]));
        assert!(is_near(bounds_of(&items(), 0, [1.0, 0.0, 0.0]), [0.5, 1.0]));
        // Twice x.
        assert!(is_near(bounds_of(&items(), 1, [2.0, 0.0, 0.0]), [0.8, 4.0]));
        // One that agrees with no other is the wrong one, so that all others hold but the first, which is of its group. Two of them are too many.
        let far = |mut items: Vec<Says>| {
            items.push(along_x(7.0, 8.0));
            items
        };
        assert!(is_near(bounds_of(&far(items()), 1, [1.0, 0.0, 0.0]), [0.5, 2.0]));
        assert_eq!(bounds_of(&far(far(items())), 1, [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn switches_leave_what_few_items_tell_when_one_of_them_may_be_wrong() {
        // Three items are too few for choices. All say x ∈ [0, 1], in a box of [−10, 10]. Each may be relaxed by a third of what the box leaves: to 4.
        let items: Vec<Says> = (0..3).map(|_| Says([1.0, 0.0, 0.0], Interval::new(0.0, 1.0))).collect();
        let found = bounds_of(&items, 1, [1.0, 0.0, 0.0]);
        assert!(is_near(found, [-10.0 / 3.0, 1.0 + 9.0 / 3.0]), "{found:?}");
        // As many wrong ones as there are say nothing.
        assert!(is_near(bounds_of(&items, 3, [1.0, 0.0, 0.0]), [-10.0, 10.0]));
    }

    #[test]
    fn the_truth_stays_whatever_a_declared_number_of_items_says() {
        let mut draw = Draw::new(20_261_127);
        for round in 0..300 {
            let most_wrong = round % 5;
            let truth = [draw.between(-9.0, 9.0), draw.between(-9.0, 9.0), draw.between(-0.09, 0.09)];
            let dot = |a: [f64; 3]| a[0] * truth[0] + a[1] * truth[1] + a[2] * truth[2];
            let items: Vec<Says> = (0..8)
                .map(|at| {
                    let a = [draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-3.0, 3.0)];
                    let half = draw.size(0.01, 1.0);
                    let off = if at < most_wrong {
                        draw.between(-9.0, 9.0)
                    } else {
                        draw.within(Interval::centred(0.0, half))
                    };
                    Says(a, Interval::centred(dot(a) + off, half * (1.0 + 1e-9)))
                })
                .collect();
            for function in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, -0.4, 1.0]] {
                let found = bounds_of(&items, most_wrong, function).unwrap();
                assert!(found.inflate(1e-9).contains(dot(function)), "round {round}: {found} {}", dot(function));
            }
        }
    }

    #[test]
    fn a_row_that_no_program_takes_says_nothing_and_one_without_sides_excludes_all() {
        let mut program = LinearProgram::new(vec![Interval::new(-1.0, 1.0)]).unwrap();
        assert_eq!(add(&mut program, &[(0, f64::NAN)], Interval::ONE), Some(()));
        assert_eq!(program.n_rows(), 0);
        assert_eq!(add(&mut program, &[(0, 1.0)], Interval::ONE), Some(()));
        assert_eq!(program.n_rows(), 1);
        assert_eq!(add(&mut program, &[(0, 1.0)], Interval::EMPTY), None);
    }

    #[test]
    fn the_choices_of_two_of_four_are_six() {
        assert_eq!(choices(4, 2), [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
        assert_eq!(choices(5, 1).len(), 5);
        assert_eq!(choices(5, 0), [[0; 0]]);
    }
}
