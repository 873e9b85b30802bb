//! Contradictions with names: which declared bounds, and which readings, cannot all be true.
//!
//! Where a program has no solution, a vector of duals proves it ([`interval::linear_program::contradicting_rows`]). To find the bounds without which
//! there is no contradiction, each declared bound is tried in turn, the least doubtful first: it is made wider by a factor; if a certificate shows
//! that the others contradict each other all the same, it stays wide, else it is put back and *named*. The named set is irreducible: any one of its
//! bounds, made wider by the factor, resolves the contradiction. And it is proven that one of them is broken, or else another bound by more than the
//! factor; but for what rows lose by linearisation, which is not enclosed anew for the wider boxes.
//!
//! The greater the factor, the stronger the statement, but the more bounds are named. So the factor is the greatest of some for which at most three
//! bounds are named.
//!
//! Source: J. W. Chinneck, E. W. Dravnieks, "Locating minimal infeasible constraint sets in linear programs", ORSA Journal on Computing 3 (1991), the
//! deletion filter, here over groups of rows and of boxes.

use interval::{
    Interval,
    linear_program::{LinearProgram, Search, Solver, certified_minimum, shares},
};

use crate::{bounds, bounds::Assumption};

use super::{Readings, Related, Suspect};

/// Factors by which bounds are made wider, the greatest first, until some are named and not too many. A bound that an event breaks is seldom exceeded
/// more than a hundredfold, and one that is exceeded by less than a tenth hardly contradicts anything.
const FACTORS: [f64; 9] = [100.0, 30.0, 10.0, 5.0, 3.0, 2.0, 1.5, 1.2, 1.1];
/// Greatest number of factors that are tried. Where one names too many bounds and the next one none, factors between are tried.
const MOST_FACTORS: usize = 16;
/// Greatest number of bounds that are named.
const MOST_NAMED: usize = 3;
/// Steps of the solver at a time, as for the bounds of a key frame's pose.
const AT_ONCE: usize = 8;
/// Greatest number of trials at a time that earlier proofs decide, and the number of latest proofs that are asked: a certificate costs about as much
/// as a step of the solver.
const PROVEN_AT_ONCE: usize = 4;
const PROOFS: usize = 4;
/// Share of the greatest part in a certificate from which on a reading counts as one that contradicts.
const LEAST_SHARE: f64 = 1e-3;

/// Bounds of which not all can be true, and the readings that show it.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// The named bounds, the most doubtful first.
    pub bounds: Vec<Assumption>,
    /// The readings that contradict each other.
    pub readings: Vec<Readings>,
    /// Whether what followed from earlier readings can be false instead: where the robot and landmarks were, and what was learnt of the gyroscope.
    pub is_earlier: bool,
    /// Factor by which another bound would have to be exceeded if all named bounds, and what followed from earlier readings where that is named, were
    /// true. `None` where more bounds than can be named contradict each other with any factor, so that the named ones are only the most doubtful of
    /// them.
    pub factor: Option<f64>,
}

/// Search for the bounds that contradict each other in a program without a solution, a few steps of the solver at a time.
pub struct ConflictSearch {
    related: Related,
    /// What may be false: what followed from earlier readings, and all declared bounds of the program, the least doubtful first.
    suspects: Vec<Suspect>,
    /// The factor that is tried, and how many have been tried before.
    factor: f64,
    n_factors: usize,
    /// The greatest factor with which no bound was named, and the least with which too many were, with those bounds.
    too_small: f64,
    too_great: Option<(f64, Vec<Suspect>)>,
    /// For the present factor: number of bounds that have been tried, and those that were named.
    n_tried: usize,
    named: Vec<Suspect>,
    /// Duals that prove that the declared bounds, or some of them made wider, contradict each other.
    proofs: Vec<Vec<f64>>,
    /// The solver on the present trial.
    solving: Option<(LinearProgram, Solver, Search)>,
    answer: Option<Option<Conflict>>,
}

impl ConflictSearch {
    /// A search that has not begun.
    pub fn new(related: Related) -> ConflictSearch {
        let of_rows = related.rows.iter().flat_map(|row| {
            let learnt = row.is_learnt.then_some(Suspect::Earlier).into_iter();
            learnt.chain(row.parts.iter().map(|part| part.0).chain(row.void_without).map(Suspect::Bound))
        });
        let of_boxes = related.made_by.values().flatten().map(|(suspect, _)| *suspect);
        let mut suspects: Vec<Suspect> = of_rows.chain(of_boxes).collect();
        suspects.sort_by_key(|&suspect| match suspect {
            Suspect::Earlier => (std::cmp::Reverse(usize::MAX), suspect),
            Suspect::Bound(bound) => (std::cmp::Reverse(bounds::doubtfulness(bound)), suspect),
        });
        suspects.dedup();
        ConflictSearch {
            related,
            suspects,
            factor: FACTORS[0],
            n_factors: 0,
            too_small: 1.0,
            too_great: None,
            n_tried: 0,
            named: Vec::new(),
            proofs: Vec::new(),
            solving: None,
            answer: None,
        }
    }

    /// Takes some steps of the solver. Returns whether the search is over.
    pub fn advance(&mut self) -> bool {
        for _ in 0..PROVEN_AT_ONCE {
            if self.answer.is_some() || self.solving.is_some() || !self.is_proven() {
                break;
            }
            self.tried(true);
        }
        if self.answer.is_none() {
            let (_, solver, search) = self.solving.get_or_insert_with(|| {
                let program = widened(&self.related, &trial(&self.suspects, &self.named, self.n_tried), self.factor);
                let solver = Solver::new(&program);
                let search = solver.begin(&[]);
                (program, solver, search)
            });
            if solver.advance(search, AT_ONCE)
                && let Some((program, solver, search)) = self.solving.take()
            {
                let duals = solver.duals(&search);
                let contradicts = certified_minimum(&program, &[], &duals) > 0.0;
                if contradicts {
                    self.proofs.push(duals);
                }
                self.tried(contradicts);
            }
        }
        self.answer.is_some()
    }

    /// The bounds that contradict each other; `None` where none have been found.
    pub fn found(&self) -> Option<&Conflict> {
        self.answer.as_ref()?.as_ref()
    }

    /// Whether one of the proofs so far shows that the bounds of the present trial contradict each other.
    fn is_proven(&self) -> bool {
        let program = widened(&self.related, &trial(&self.suspects, &self.named, self.n_tried), self.factor);
        self.proofs.iter().rev().take(PROOFS).any(|duals| certified_minimum(&program, &[], duals) > 0.0)
    }

    /// Goes on after a trial. The first trial of all is with the bounds as they were declared.
    fn tried(&mut self, contradicts: bool) {
        if self.n_tried == 0 && !contradicts {
            // The declared bounds as they are do not contradict each other.
            self.answer = Some(None);
            return;
        }
        if let Some(&bound) = self.n_tried.checked_sub(1).and_then(|at| self.suspects.get(at))
            && !contradicts
        {
            self.named.push(bound);
        }
        self.n_tried += 1;
        let is_over = self.n_tried > self.suspects.len();
        if self.named.len() > MOST_NAMED {
            self.too_great = Some((self.factor, std::mem::take(&mut self.named)));
            self.try_other_factor();
        } else if is_over && self.named.is_empty() {
            // Even with the factor the bounds contradict each other.
            self.too_small = self.factor;
            self.try_other_factor();
        } else if is_over {
            let named = std::mem::take(&mut self.named);
            self.answer = Some(self.conflict(&named, Some(self.factor)));
        }
    }

    /// Begins anew with the next smaller factor, or with one between a factor that is too small and one that is too great.
    fn try_other_factor(&mut self) {
        let next = match &self.too_great {
            Some((great, _)) if self.too_small > 1.0 => Some((self.too_small * great).sqrt()),
            Some((great, _)) => FACTORS.into_iter().find(|factor| factor < great),
            // What has no name contradicts itself, or a bound is exceeded by far more than is sought.
            None => None,
        };
        self.n_factors += 1;
        self.n_tried = 1;
        match next.filter(|_| self.n_factors < MOST_FACTORS) {
            Some(factor) => self.factor = factor,
            None => {
                let most = self.too_great.take().map(|(_, named)| named);
                self.answer = Some(most.and_then(|named| self.conflict(&named, None)));
            }
        }
    }

    /// The answer with bounds that were named in the order in which they were tried. The proof is the latest one that does not need the other bounds.
    fn conflict(&self, named: &[Suspect], factor: Option<f64>) -> Option<Conflict> {
        let wide: Vec<Suspect> = self.suspects.iter().copied().filter(|one| !named.contains(one)).collect();
        let program =
            if factor.is_some() { widened(&self.related, &wide, self.factor) } else { self.related.program.clone() };
        let proof = self.proofs.iter().rev().find(|duals| certified_minimum(&program, &[], duals) > 0.0)?;
        let bounds = named.iter().rev().filter_map(|suspect| match suspect {
            Suspect::Earlier => None,
            Suspect::Bound(bound) => Some(*bound),
        });
        let bounds = bounds.take(MOST_NAMED).collect();
        let is_earlier = named.contains(&Suspect::Earlier);
        Some(Conflict { bounds, is_earlier, readings: self.readings(&program, proof), factor })
    }

    /// The readings of the rows and boxes that a proof needs.
    fn readings(&self, program: &LinearProgram, proof: &[f64]) -> Vec<Readings> {
        let Some(shares) = shares(program, &[], proof) else { return Vec::new() };
        let most = shares.rows.iter().chain(&shares.variables).fold(0.0, |most: f64, share| most.max(*share));
        let mut readings: Vec<Readings> = Vec::new();
        let by_rows = self.related.rows.iter().zip(&shares.rows).filter(|(_, share)| **share >= LEAST_SHARE * most);
        let variables = self.related.variables.iter().zip(&shares.variables);
        let by_boxes = variables
            .filter(|(_, share)| **share >= LEAST_SHARE * most)
            .filter_map(|(variable, _)| self.related.boxes.get(variable));
        let all = by_rows.flat_map(|(label, _)| &label.readings).chain(by_boxes.map(|label| &label.reading));
        for reading in all {
            // The readings of a device that is read all the time are one span; those of a camera are named one by one.
            let same = readings.iter_mut().find(|other| {
                let lasts = |span_s: [f64; 2]| span_s[1] > span_s[0];
                other.device == reading.device
                    && (other.span_s == reading.span_s || lasts(other.span_s) && lasts(reading.span_s))
            });
            match same {
                Some(other) => {
                    let [from_s, to_s] = other.span_s;
                    other.span_s = [from_s.min(reading.span_s[0]), to_s.max(reading.span_s[1])];
                }
                None => readings.push(*reading),
            }
        }
        readings.sort_by(|a, b| a.device.cmp(b.device).then(a.span_s[0].total_cmp(&b.span_s[0])));
        readings
    }
}

/// The bounds that are wide in a trial: of those tried before, the ones that were not named, and the one that is tried now. None in trial number 0.
fn trial(suspects: &[Suspect], named: &[Suspect], n_tried: usize) -> Vec<Suspect> {
    suspects[..n_tried].iter().copied().filter(|one| !named.contains(one)).collect()
}

/// The program with what some suspects make wider by a factor. A row that says nothing without one of them becomes so wide that it says nothing.
fn widened(related: &Related, wide: &[Suspect], factor: f64) -> LinearProgram {
    let more = factor - 1.0;
    let is_wide = |bound: Assumption| wide.contains(&Suspect::Bound(bound));
    let boxes = related.variables.iter().zip(related.program.variables()).map(|(variable, values)| {
        let makers = related.made_by.get(variable).into_iter().flatten();
        let half: f64 = makers.filter(|(suspect, _)| wide.contains(suspect)).map(|(_, half)| half).sum();
        (half > 0.0).then(|| values.inflate(more * half))
    });
    let boxes: Vec<Option<Interval>> = boxes.collect();
    let rows = related.rows.iter().enumerate().map(|(at, row)| {
        if row.void_without.is_some_and(is_wide) {
            let terms = related.program.terms(at).iter();
            let reach = terms.map(|&(variable, coefficient)| {
                let values = boxes[variable].unwrap_or(related.program.variables()[variable]);
                values.magnitude() * coefficient.abs()
            });
            return 2.0 * (reach.sum::<f64>() + related.program.sides(at).magnitude());
        }
        let learnt =
            if row.is_learnt && wide.contains(&Suspect::Earlier) { related.program.sides(at).radius() } else { 0.0 };
        more * (learnt + row.parts.iter().filter(|(bound, _)| is_wide(bound)).map(|(_, half)| half).sum::<f64>())
    });
    let rows: Vec<f64> = rows.collect();
    related.program.widened(|at| boxes[at], |row| rows[row])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::graph::{Constant, Domain, Row, Variable, related::Origin, trial::Draw};

    /// A program over the x of three poses, each between −10 and 10 m, and the track, which is 1 ± 0.001 m.
    fn related(rows: Vec<Row>) -> Related {
        let mut domain = Domain::default();
        (0..3).for_each(|frame| domain.put(Variable::Pose(frame, 0), Interval::new(-10.0, 10.0)));
        domain.put(Variable::Constant(Constant::Track), Interval::centred(1.0, 0.001));
        let rows =
            rows.into_iter().enumerate().map(|(at, row)| (row, Origin::over([at as f64, at as f64 + 1.0]))).collect();
        Related::new(domain, rows, BTreeMap::new()).unwrap()
    }

    /// A row that the x of pose 0, with so many times the deviation of the track, is within half of the middle, with the parts given.
    fn row(tracks: f64, middle: f64, half: f64, device: &'static str, parts: &[(Assumption, f64)]) -> Row {
        let terms = vec![(Variable::Pose(0, 0), 1.0), (Variable::Constant(Constant::Track), tracks)];
        let row = Row { terms, sides: Interval::centred(middle, half), parts: Vec::new(), devices: Vec::new() };
        row.with_parts(1.0, parts).by_device(device)
    }

    fn found(related: Related) -> Option<Conflict> {
        let mut search = ConflictSearch::new(related);
        let mut n_calls = 0;
        while !search.advance() {
            n_calls += 1;
            assert!(n_calls < 5000);
        }
        search.found().cloned()
    }

    #[test]
    fn only_what_is_needed_for_the_contradiction_is_named() {
        // By the wheels x is 1 ± 0.1, by the flow sensor 2 ± 0.1: 0.8 apart. Neither the track, of which a hundredfold bound moves the row by 0.1, nor
        // the gyroscope, which says nothing else, can resolve that.
        let rows = vec![
            row(1.0, 1.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]),
            row(0.0, 2.0, 0.1, "flow", &[(bounds::FLOW_SCALE, 0.1)]),
            row(0.0, 1.5, 5.0, "gyro", &[(bounds::GYRO_NOISE, 5.0)]),
        ];
        let found = found(related(rows)).unwrap();
        assert_eq!(found.bounds, [bounds::WHEELS_SLIP, bounds::FLOW_SCALE]);
        assert_eq!(found.factor, Some(100.0));
        let wheels = Readings { device: "wheels", span_s: [0.0, 1.0] };
        assert_eq!(found.readings, [Readings { device: "flow", span_s: [1.0, 2.0] }, wheels]);
    }

    #[test]
    fn at_most_three_bounds_are_named_with_the_greatest_factor_that_allows_it() {
        // Two rows, each with two parts of 0.1, that are 0.12 apart. Made wider threefold, each part alone resolves that; twofold, it takes two of
        // them, so that the first one stays wide and the three others are named.
        let parts = |a, b| [(a, 0.1), (b, 0.1)];
        let rows = vec![
            row(0.0, 0.0, 0.2, "wheels", &parts(bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP)),
            row(0.0, 0.52, 0.2, "flow", &parts(bounds::FLOW_SCALE, bounds::FLOW_POSITION)),
        ];
        let found = found(related(rows)).unwrap();
        assert_eq!(found.factor, Some(2.0));
        assert_eq!(found.bounds, [bounds::WHEELS_SLIP, bounds::WHEELS_SIDE_SLIP, bounds::FLOW_SCALE]);
    }

    #[test]
    fn what_was_known_before_is_named_only_where_the_contradiction_needs_it() {
        // The box of pose 0 is by nothing in the program: x is within 10 m. By the wheels it is 1012 ± 0.1: a box a hundred times as wide, or slip a
        // hundred times as great, resolves that if it is slip of 11 m. By the flow sensor it is 1012 ± 0.1, too, so that only the box is left.
        let wheels = || row(0.0, 900.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]);
        let by_one = found(related(vec![wheels()])).unwrap();
        assert!(by_one.is_earlier && by_one.bounds.is_empty() && by_one.factor == Some(100.0), "{by_one:?}");
        // Of two rows that contradict each other by themselves the box says nothing.
        let other = row(0.0, 5.0, 0.1, "flow", &[(bounds::FLOW_SCALE, 0.1)]);
        let nearer = row(0.0, 3.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]);
        let by_two = found(related(vec![nearer, other])).unwrap();
        assert!(!by_two.is_earlier && by_two.bounds == [bounds::WHEELS_SLIP, bounds::FLOW_SCALE], "{by_two:?}");
    }

    #[test]
    fn what_displaces_a_reading_is_named_by_the_bounds_that_make_it() {
        // A reading shows a pose that is displaced by up to 0.02 m by the body's tilt: x is 1.06 ± 0.001 less the displacement. By the wheels it is
        // 1 ± 0.01. A displacement of 0.049 m, made by 2.5 times the tilt, resolves that, and so does five times the slip.
        let (x, shift) = (Variable::Pose(0, 0), Variable::Shift(0, 0));
        let mut domain = Domain::default();
        domain.put(x, Interval::new(-10.0, 10.0));
        domain.put(shift, Interval::centred(0.0, 0.02));
        let shown = |middle: f64, half: f64, terms: &[(Variable, f64)]| Row {
            terms: terms.to_vec(),
            sides: Interval::centred(middle, half),
            parts: Vec::new(),
            devices: Vec::new(),
        };
        let reading = shown(1.06, 0.001, &[(x, 1.0), (shift, 1.0)]).with_part(bounds::RANGE_CAMERA_COLUMNS, 0.001);
        let way = shown(1.0, 0.01, &[(x, 1.0)]).with_part(bounds::WHEELS_SLIP, 0.01);
        let rows = vec![(reading, Origin::over([1.0; 2])), (way, Origin::over([0.0, 1.0]))];
        let mut related = Related::new(domain, rows, BTreeMap::new()).unwrap();
        related.made_by.insert(shift, vec![(Suspect::Bound(bounds::BODY_TILT), 0.02)]);
        let found = found(related).unwrap();
        assert_eq!(found.bounds, [bounds::WHEELS_SLIP, bounds::BODY_TILT, bounds::RANGE_CAMERA_COLUMNS]);
    }

    #[test]
    fn a_row_that_says_nothing_without_a_bound_names_it() {
        // x is 5 ± 0.01 if the code of the one reading is right, and 1 ± 0.01 by the wheels.
        let rows = [
            (row(0.0, 5.0, 0.01, "range_camera", &[(bounds::RANGE_CAMERA_COLUMNS, 0.01)]), true),
            (row(0.0, 1.0, 0.01, "wheels", &[(bounds::WHEELS_SLIP, 0.01)]), false),
        ];
        let rows = rows.map(|(row, has_code)| {
            let void_without = has_code.then_some(bounds::RANGE_LANDMARKS_Q_ITEMS);
            (row, Origin { void_without, ..Origin::over([1.0; 2]) })
        });
        let mut domain = Domain::default();
        domain.put(Variable::Pose(0, 0), Interval::new(-10.0, 10.0));
        domain.put(Variable::Constant(Constant::Track), Interval::centred(1.0, 0.001));
        let found = found(Related::new(domain, rows.to_vec(), BTreeMap::new()).unwrap()).unwrap();
        assert_eq!(found.bounds, [bounds::RANGE_LANDMARKS_Q_ITEMS]);
        assert_eq!((found.factor, found.is_earlier), (Some(100.0), false));
    }

    #[test]
    fn rows_that_agree_name_nothing() {
        let rows = vec![
            row(0.0, 1.0, 0.1, "wheels", &[(bounds::WHEELS_SLIP, 0.1)]),
            row(0.0, 1.1, 0.1, "flow", &[(bounds::FLOW_SCALE, 0.1)]),
        ];
        assert_eq!(found(related(rows)), None);
    }

    #[test]
    fn the_broken_bound_is_named_unless_it_is_exceeded_by_more_than_the_factor() {
        let mut draw = Draw::new(20_261_124);
        let names = [
            bounds::WHEELS_SLIP,
            bounds::WHEELS_SIDE_SLIP,
            bounds::FLOW_SCALE,
            bounds::GYRO_NOISE,
            bounds::FLOW_POSITION,
            bounds::BODY_TILT,
        ];
        let (mut n_found, mut n_proven) = (0, 0);
        for round in 0..400 {
            let broken = names[round % names.len()];
            let exceeded = draw.size(1.1, 60.0);
            let truth = [0; 3].map(|_| draw.between(-1.0, 1.0));
            // Each row is a sum of two poses with errors of two bounds, one of which is exceeded in one sense or the other.
            let rows = (0..12).map(|at| {
                let terms: Vec<(Variable, f64)> =
                    (0..2).map(|term| (Variable::Pose((at + term) % 3, 0), draw.between(-2.0, 2.0))).collect();
                let parts = [names[at % 6], names[(at + 1 + at / 6) % 6]].map(|name| (name, draw.size(1e-3, 0.1)));
                let value: f64 = (0..2).map(|term| terms[term].1 * truth[(at + term) % 3]).sum();
                let error: f64 = parts
                    .iter()
                    .map(|&(name, half)| {
                        let most = if name == broken { half * exceeded } else { half };
                        draw.within(Interval::centred(0.0, most))
                    })
                    .sum();
                let half: f64 = parts.iter().map(|part| part.1).sum();
                let row = Row {
                    terms,
                    sides: Interval::centred(value + error, half * (1.0 + 1e-9)),
                    parts: Vec::new(),
                    devices: Vec::new(),
                };
                row.with_parts(1.0, &parts).by_device("wheels")
            });
            let Some(conflict) = found(related(rows.collect())) else { continue };
            n_found += 1;
            n_proven += usize::from(conflict.factor.is_some());
            assert!((1..=3).contains(&conflict.bounds.len()), "round {round}: {conflict:?}");
            let is_named = conflict.bounds.contains(&broken);
            assert!(
                is_named || conflict.factor.is_none_or(|factor| exceeded > factor),
                "round {round}: {broken} by {exceeded}, {conflict:?}"
            );
        }
        assert!(n_found > 150 && n_proven * 20 > n_found * 19, "{n_proven} of {n_found}");
    }
}
