//! Containment and blame, step by step.

use crate::run::RunRecord;

use super::verdict::{Containment, FirstFailure, Judgement, Violation};

/// A cause may lie so long before the step at which the truth is found outside: as long as the localizer remembers.
const CAUSE_WITHIN_S: f64 = 3.0;

/// The judgement of every step, their counts, and the first step outside.
///
/// A step outside inherits the cause of the step before it: a box that went wrong stays wrong until something resolves it. What was
/// learnt wrongly misleads for as long as it is believed: in one of the spans `misled`, whatever was broken before it is a cause. What is
/// learnt of the gyroscope is believed to the end: at rest, and from headings, which mislead where they were outside themselves.
pub(super) fn containment(
    record: &RunRecord,
    violations: &[Violation],
    misperceived: &[bool],
    false_claims: &[usize],
    misled: &[[f64; 2]],
    learns_gyro: bool,
) -> (Containment, Vec<Judgement>) {
    let mut judgements = Vec::with_capacity(record.truths.len());
    let mut counts = Containment { checks: record.truths.len().min(record.estimates.len()), ..Containment::default() };
    let mut last_contained_s = 0.0;
    let mut standing: Option<(Judgement, String)> = None;
    let rests: Vec<Violation> = violations.iter().filter(|broken| broken.bound == "wheels.rest").cloned().collect();
    // Why the truth was outside before.
    let mut earlier: Option<(Judgement, String)> = None;
    for (truth, estimate) in record.truths.iter().zip(&record.estimates) {
        if estimate.pose.contains(truth.pose) {
            counts.contained += 1;
            judgements.push(Judgement::Contained);
            last_contained_s = truth.time_s;
            standing = None;
            continue;
        }
        let explained = standing.as_ref().is_some_and(|(judgement, _)| *judgement != Judgement::Unsound);
        if !explained {
            let span_s = [last_contained_s - CAUSE_WITHIN_S, truth.time_s];
            let found = blame(record, violations, misperceived, false_claims, &estimate.relies_on, span_s);
            let learnt = misled.iter().find(|span_s| span_s[0] <= truth.time_s && truth.time_s <= span_s[1]);
            standing = Some(match (found, learnt) {
                ((Judgement::Unsound, _), Some([from_s, _])) => {
                    let relied_on = relied_on_at(record, *from_s);
                    // Key frames keep the way since the start of the drive: a push hides in them until a landmark comes into view again.
                    blame(record, violations, misperceived, false_claims, relied_on, [0.0, *from_s])
                }
                ((Judgement::Unsound, _), None) if learns_gyro => earlier
                    .clone()
                    .unwrap_or_else(|| blame(record, &rests, &[], &[], &estimate.relies_on, [0.0, truth.time_s])),
                (found, _) => found,
            });
            earlier = standing.clone().filter(|(judgement, _)| *judgement != Judgement::Unsound).or(earlier);
        }
        let Some((judgement, cause)) = &standing else { continue };
        judgements.push(*judgement);
        match judgement {
            Judgement::Contained => {}
            Judgement::BoundBroken => counts.bound_broken += 1,
            Judgement::Perception => counts.perception += 1,
            Judgement::Unsound => counts.unsound += 1,
        }
        if counts.first_failure.is_none() {
            let (axis, margin) = farthest_axis(&estimate.pose.hull(), truth.pose);
            counts.first_failure =
                Some(FirstFailure { time_s: truth.time_s, axis, margin, outcome: *judgement, blame: cause.clone() });
        }
    }
    (counts, judgements)
}

/// The cause of a truth outside: a bound that the estimate relies on, exceeded in `span_s`; else too many false claims; else our own.
fn blame(
    record: &RunRecord,
    violations: &[Violation],
    misperceived: &[bool],
    false_claims: &[usize],
    relies_on: &[&str],
    span_s: [f64; 2],
) -> (Judgement, String) {
    let overlaps = |from_s: f64, to_s: f64| from_s <= span_s[1] && to_s >= span_s[0];
    let broken = violations
        .iter()
        .filter(|violation| relies_on.contains(&violation.bound.as_str()) && overlaps(violation.from_s, violation.to_s))
        .max_by(|a, b| (a.true_value / a.declared).total_cmp(&(b.true_value / b.declared)));
    if let Some(violation) = broken {
        return (Judgement::BoundBroken, violation.bound.clone());
    }
    let mut images = record.images.iter().zip(false_claims).zip(misperceived);
    let misread = images.find(|((image, _), wrong)| **wrong && overlaps(image.measured_s, image.arrived_s));
    match misread {
        Some(((image, n_false), _)) => {
            (Judgement::Perception, format!("{}: {n_false} false claims in image {}", image.method, image.number))
        }
        None => (Judgement::Unsound, "no declared bound was exceeded and no claim was false".to_string()),
    }
}

/// What the estimate relied on just before a time.
fn relied_on_at(record: &RunRecord, time_s: f64) -> &[&'static str] {
    let before = record.estimates.iter().rev().find(|estimate| estimate.time_s < time_s);
    before.map_or(&[], |estimate| &estimate.relies_on)
}

/// The axis along which a pose lies farthest outside of a box, and how far; between branches the distance is 0.
fn farthest_axis(hull: &localizer::PoseBox, truth: localizer::Pose) -> (&'static str, f64) {
    if hull.is_empty() {
        return ("x_m", f64::MAX);
    }
    let truth = truth.to_array();
    let outside = |axis: usize| (hull[axis].lo() - truth[axis]).max(truth[axis] - hull[axis].hi()).max(0.0);
    // Metres and radians are compared through the widths of the box.
    let relative = |axis: usize| outside(axis) / hull[axis].width().max(1e-9);
    let axis = (0..3).max_by(|&a, &b| relative(a).total_cmp(&relative(b))).unwrap_or(0);
    if outside(axis) == 0.0 {
        return ("between branches", 0.0);
    }
    (["x_m", "y_m", "heading_rad"][axis], outside(axis))
}
