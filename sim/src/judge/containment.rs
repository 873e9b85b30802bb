//! Judges at every step whether the boxes contain the true pose, and finds what was to blame by counterfactual: a broken bound or a false claim is to
//! blame only if the boxes hold the truth when the run is simulated again without it.

mod misread;

use crate::{
    render::RenderError,
    run::{Change, Counterfactual, RunRecord},
    scene::Scene,
    world::is_clipped,
};

use super::{
    NamedClaims, Replay, methods,
    verdict::{Containment, FirstFailure, Judgement, Violation},
};
use misread::{Misread, misread, named};

/// Greatest number of rounds in which the run is simulated again without the readings that have too many false claims. Without them later readings
/// may make other claims, of which again too many may be false and which the next round leaves out.
const MOST_ROUNDS: usize = 3;

/// A sequence of consecutive steps at which the true pose is outside the localizer's union of boxes.
struct Span {
    first: usize,
    last: usize,
    cause: Option<Cause>,
}

/// The cause of a span of steps outside the union: which judgement the steps get, and what is to blame.
#[derive(Clone, Debug)]
struct Cause {
    judgement: Judgement,
    blame: String,
    because: String,
    false_claims: Option<NamedClaims>,
}

/// A declared bound that was exceeded and may be to blame, with its greatest excess.
struct Candidate {
    violation: Violation,
    first_s: f64,
    /// Each time span in which the bound was exceeded, with the excess.
    exceeded: Vec<([f64; 2], f64)>,
}

/// The judgement of every step, the counts of judgements, and the first step at which the truth is outside the boxes. Only a run that lost the truth
/// is simulated again, and only up to its last step outside: with n exceeded bounds at most 2·n − 1 times for the bounds, and up to six times for
/// false claims (three rounds, without and with the exceeded bounds kept), since each round may show further false claims.
pub(super) fn containment(
    scene: &Scene,
    record: &RunRecord,
    violations: &[Violation],
    misperceived: &[bool],
    replay: &mut Replay<'_>,
) -> Result<(Containment, Vec<Judgement>), RenderError> {
    let mut spans = spans_outside(record);
    if !spans.is_empty() {
        let mut trial = Trial { record, candidates: candidates(violations), spans: &mut spans, replay, n_replays: 0 };
        trial.blame_bounds()?;
        trial.blame_perception(scene, misperceived)?;
        let n_replays = trial.n_replays;
        return Ok(judged(record, &spans, n_replays));
    }
    Ok(judged(record, &spans, 0))
}

/// Every bound that was exceeded in the run, each once, sorted by true value over declared bound with the greatest first.
fn candidates(violations: &[Violation]) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = Vec::new();
    for violation in violations {
        let exceeded = ([violation.from_s, violation.to_s], violation.excess());
        match candidates.iter_mut().find(|candidate| candidate.violation.bound == violation.bound) {
            Some(candidate) => {
                candidate.first_s = candidate.first_s.min(violation.from_s);
                candidate.exceeded.push(exceeded);
                if violation.excess() > candidate.violation.excess() {
                    candidate.violation = violation.clone();
                }
            }
            None => candidates.push(Candidate {
                violation: violation.clone(),
                first_s: violation.from_s,
                exceeded: vec![exceeded],
            }),
        }
    }
    candidates.sort_by(|a, b| b.violation.ratio().total_cmp(&a.violation.ratio()));
    candidates
}

impl Candidate {
    /// The change with which the run is simulated again so that the bound holds. A value that the simulator draws or the scene places is moved back
    /// to the bound; for a value that emerges from the physics the localizer is given the true value as its bound.
    fn change(&self) -> Change {
        let Violation { bound, declared, true_value, .. } = &self.violation;
        if is_clipped(bound) {
            Change::Clipped { bound: bound.clone() }
        } else {
            Change::Told {
                bound: bound.clone(),
                declared: *declared,
                true_value: *true_value,
                exceeded: self.exceeded.clone(),
            }
        }
    }

    fn because(&self) -> String {
        let Violation { bound, declared, true_value, .. } = &self.violation;
        let how = if is_clipped(bound) { "moved back to its bound" } else { "told as it was" };
        let ratio = self.violation.ratio();
        let times = if ratio.is_finite() { format!(", {ratio:.2} times as much") } else { String::new() };
        format!("{bound} was {true_value:.6} where {declared:.6} is declared{times}; {how}")
    }
}

/// The search for what was to blame in a run whose boxes lost the truth.
struct Trial<'a, 'r> {
    record: &'a RunRecord,
    candidates: Vec<Candidate>,
    spans: &'a mut [Span],
    replay: &'a mut Replay<'r>,
    n_replays: usize,
}

impl Trial<'_, '_> {
    /// Simulates the run again with each exceeded bound kept alone, then with the first two exceeded bounds kept together, the first three, and so
    /// on.
    fn blame_bounds(&mut self) -> Result<(), RenderError> {
        let n_candidates = self.candidates.len();
        let alone = (0..n_candidates).map(|index| index..index + 1);
        let together = (2..=n_candidates).map(|count| 0..count);
        for set in alone.chain(together) {
            // Each set of candidate bounds adds its last bound to those tried before. If this bound cannot have caused any failure that still lacks a
            // cause, the set is skipped.
            let adds = self.open().any(|span| self.may_have(set.end - 1, span));
            if !adds {
                continue;
            }
            let changes = self.candidates[set.clone()].iter().map(Candidate::change).collect();
            let again = self.again(changes)?;
            for index in 0..self.spans.len() {
                let blamed: Vec<usize> =
                    set.clone().filter(|candidate| self.may_have(*candidate, &self.spans[index])).collect();
                let began = blamed.iter().any(|candidate| self.began(*candidate, &self.spans[index]));
                if self.spans[index].cause.is_none() && began && holds(&again, &self.spans[index]) {
                    self.spans[index].cause = Some(self.cause(Judgement::BoundBroken, &blamed, None));
                }
            }
        }
        Ok(())
    }

    /// Simulates the run again without the readings that have more false claims than declared: first with bounds exceeded as they were in the run,
    /// then with every exceeded bound kept.
    fn blame_perception(&mut self, scene: &Scene, misperceived: &[bool]) -> Result<(), RenderError> {
        for with_bounds in [false, true] {
            if with_bounds && self.candidates.is_empty() {
                return Ok(());
            }
            let mut withheld = misread(self.record, misperceived);
            for _ in 0..MOST_ROUNDS {
                let is_early = |span: &&Span| withheld.iter().any(|misread| misread.arrived_s <= self.end_s(span));
                if !self.open().any(|span| is_early(&span)) {
                    return Ok(());
                }
                let readings = withheld.iter().map(|misread| (misread.camera, misread.measured_s)).collect();
                let mut changes = vec![Change::Withheld { readings }];
                if with_bounds {
                    changes.extend(self.candidates.iter().map(Candidate::change));
                }
                let again = self.again(changes)?;
                for index in 0..self.spans.len() {
                    let end_s = self.end_s(&self.spans[index]);
                    let begin_s = self.begin_s(&self.spans[index]);
                    let first = withheld.iter().find(|misread| misread.arrived_s <= end_s);
                    let with = |candidate: &usize| with_bounds && self.may_have(*candidate, &self.spans[index]);
                    let blamed: Vec<usize> = (0..self.candidates.len()).filter(with).collect();
                    let began = withheld.iter().any(|misread| misread.arrived_s <= begin_s)
                        || blamed.iter().any(|candidate| self.began(*candidate, &self.spans[index]));
                    if self.spans[index].cause.is_none()
                        && first.is_some()
                        && began
                        && holds(&again, &self.spans[index])
                    {
                        let named = named(scene, self.record, misperceived, [begin_s, end_s]);
                        self.spans[index].cause =
                            Some(self.cause(Judgement::Perception, &blamed, first.map(|first| (first, named))));
                    }
                }
                let before = withheld.len();
                let judged = methods::false_claims(scene, &again);
                withheld.extend(misread(&again, &methods::misperceived(&again, &judged)));
                if withheld.len() == before {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Spans of steps at which the truth is outside the boxes and for which no cause has been found.
    fn open(&self) -> impl Iterator<Item = &Span> {
        self.spans.iter().filter(|span| span.cause.is_none())
    }

    fn end_s(&self, span: &Span) -> f64 {
        self.record.truths[span.last].time_s
    }

    /// Time at which a span of steps outside the union begins, with a small margin for the rounding of times that are sums of decimals.
    fn begin_s(&self, span: &Span) -> f64 {
        self.record.truths[span.first].time_s + 1e-6
    }

    /// Whether a candidate bound was exceeded by the time at which the truth is first outside: a later excess cannot have caused that.
    fn began(&self, candidate: usize, span: &Span) -> bool {
        self.candidates[candidate].first_s <= self.begin_s(span)
    }

    /// Whether a candidate bound was exceeded by the end of a span of steps outside, and an estimate up to that time relies on the bound.
    fn may_have(&self, candidate: usize, span: &Span) -> bool {
        let candidate = &self.candidates[candidate];
        let bound = candidate.violation.bound.as_str();
        candidate.first_s <= self.end_s(span)
            && self.record.estimates[..=span.last].iter().rev().any(|estimate| estimate.relies_on.contains(&bound))
    }

    fn again(&mut self, changes: Vec<Change>) -> Result<RunRecord, RenderError> {
        self.n_replays += 1;
        // The run is simulated again only up to the last span of steps outside the boxes that still lacks a cause.
        let until_s = self.open().map(|span| self.end_s(span)).reduce(f64::max);
        (self.replay)(&Counterfactual { changes, until_s, until_lost_after_s: None })
    }

    /// A cause of a failure, in the words in which the verdict reports it.
    fn cause(&self, judgement: Judgement, blamed: &[usize], misread: Option<(&Misread, Option<NamedClaims>)>) -> Cause {
        let candidates = || blamed.iter().map(|index| &self.candidates[*index]);
        let names = candidates().map(|candidate| candidate.violation.bound.clone());
        let reasons = candidates().map(Candidate::because);
        let in_words = |(first, named): &(&Misread, Option<NamedClaims>)| {
            (first.as_blame(named.as_ref()), first.because(named.as_ref()))
        };
        let (told, why) = misread.as_ref().map(in_words).unzip();
        let blame = told.into_iter().chain(names).collect::<Vec<_>>().join(" and ");
        let because = why.into_iter().chain(reasons).collect::<Vec<_>>().join(", and ");
        let because = format!("{because}, the same commands hold the truth");
        Cause { judgement, blame, because, false_claims: misread.and_then(|(_, named)| named) }
    }
}

/// The spans of consecutive steps at which the truth is outside the union of boxes.
fn spans_outside(record: &RunRecord) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for (step, (truth, estimate)) in record.truths.iter().zip(&record.estimates).enumerate() {
        if estimate.pose.contains(truth.pose) {
            continue;
        }
        match spans.last_mut() {
            Some(span) if span.last + 1 == step => span.last = step,
            _ => spans.push(Span { first: step, last: step, cause: None }),
        }
    }
    spans
}

/// Whether the boxes of a run that was simulated again hold the truth at every step of a span.
fn holds(record: &RunRecord, span: &Span) -> bool {
    let steps = span.first..span.last + 1;
    let (truths, estimates) = (record.truths.get(steps.clone()), record.estimates.get(steps));
    let (Some(truths), Some(estimates)) = (truths, estimates) else { return false };
    truths.iter().zip(estimates).all(|(truth, estimate)| estimate.pose.contains(truth.pose))
}

/// The judgement of every step, and the counts of judgements.
fn judged(record: &RunRecord, spans: &[Span], n_replays: usize) -> (Containment, Vec<Judgement>) {
    let checks = record.truths.len().min(record.estimates.len());
    let mut judgements = vec![Judgement::Contained; checks];
    let mut counts = Containment { checks, contained: checks, replays: n_replays, ..Containment::default() };
    for span in spans {
        let (steps, n_steps) = (span.first..=span.last, span.last + 1 - span.first);
        let judgement = span.cause.as_ref().map_or(Judgement::Unsound, |cause| cause.judgement);
        judgements[steps].fill(judgement);
        counts.contained -= n_steps;
        match judgement {
            Judgement::Contained => {}
            Judgement::BoundBroken => counts.bound_broken += n_steps,
            Judgement::Perception => counts.perception += n_steps,
            Judgement::Unsound => counts.unsound += n_steps,
        }
    }
    counts.first_failure = spans.first().map(|span| first_failure(record, span, n_replays));
    (counts, judgements)
}

fn first_failure(record: &RunRecord, span: &Span, n_replays: usize) -> FirstFailure {
    let (truth, estimate) = (&record.truths[span.first], &record.estimates[span.first]);
    let (axis, margin) = farthest_axis(&estimate.pose.hull(), truth.pose);
    let nobody = || {
        let because = match n_replays {
            0 => "no declared bound was exceeded and no claim was false".to_owned(),
            n => format!("none of {n} runs without what was exceeded or falsely claimed holds the truth"),
        };
        Cause { judgement: Judgement::Unsound, blame: because.clone(), because, false_claims: None }
    };
    let Cause { judgement, blame, because, false_claims } = span.cause.clone().unwrap_or_else(nobody);
    FirstFailure { time_s: truth.time_s, axis, margin, outcome: judgement, blame, because, false_claims }
}

/// The axis along which a pose lies farthest outside a hull (the smallest box around a union of boxes), and how far. The distance is 0 for a pose
/// that is inside the hull but in none of the union's boxes.
fn farthest_axis(hull: &localizer::PoseBox, truth: localizer::Pose) -> (&'static str, f64) {
    if hull.is_empty() {
        return ("x_m", f64::MAX);
    }
    let truth = truth.to_array();
    let outside = |axis: usize| (hull[axis].lo() - truth[axis]).max(truth[axis] - hull[axis].hi()).max(0.0);
    // Distances in metres and in radians are made comparable by dividing them by the widths of the box.
    let relative = |axis: usize| outside(axis) / hull[axis].width().max(1e-9);
    let axis = (0..3).max_by(|&a, &b| relative(a).total_cmp(&relative(b))).unwrap_or(0);
    if outside(axis) == 0.0 {
        return ("between branches", 0.0);
    }
    (["x_m", "y_m", "heading_rad"][axis], outside(axis))
}
