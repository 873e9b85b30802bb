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
mod tests;
