//! Compares a run's estimates with its truth, and finds what was to blame where the truth was outside the boxes. The only side effect is to call the
//! function that the judge is given for simulating the run again.

mod bounds;
mod claims;
mod errands;
mod expectations;
pub mod figures;
mod headings;
mod honesty;
mod containment;
mod distribution;
mod landmarks;
mod markers;
mod methods;
mod named;
mod post;
mod space_points;
mod taught_map;
mod statistics;
mod verdict;

pub use bounds::{violations, watched};
pub(crate) use claims::{FalseClaims, joint_claimed, of_most_things};
pub use claims::{is_true, wall_line_deg};
pub use distribution::{corridor, of_steps as judge_distributions};
pub use errands::{distance_to_way_m, true_distance_m};
pub use expectations::metric_names;
pub use honesty::honesty;
pub(crate) use markers::wholly_in_view;
pub use markers::{MarkerCounts, confidence_correlations, marker_counts};
pub(crate) use methods::{Quotable, exceeding, false_claims, misperceived};
pub use post::{PostStep, post_steps};
pub(crate) use statistics::{SETTLED_S, errors, fix_width, midpoint};
pub use verdict::{
    AxisError, AxisPower, AxisWidth, Baseline, BaselineContainment, BaselineWidth, Calibration, Containment,
    Distribution, ErrorTable, FirstFailure, FixWidth, Halvings, Judgement, Latency, MethodCounts, NamedClaim,
    NamedClaims, Nees, Passed, PositionError, PostLocalization, Power, PowerTable, Region, Verdict, Violation,
    WidthTable,
};

use std::collections::BTreeMap;

use localizer::{Estimate, Pose, Status};

use crate::{
    render::RenderError,
    run::{Counterfactual, RunRecord, Told},
    scene::Scene,
    subject::half_turn,
    truth::Truth,
};

/// A function that simulates the judged run again, with its recorded commands and with given changes: [`run_otherwise`](crate::run::run_otherwise).
pub type Replay<'a> = dyn FnMut(&Counterfactual) -> Result<RunRecord, RenderError> + 'a;

/// Judges a run: containment and blame at every step, errors, widths, counts, and the scene's expectations.
///
/// `replay` simulates the run again with changes. It is called only when the truth was outside the boxes: a cause is to blame if the run without it
/// holds the truth. Returns an error when `replay` does.
pub fn judge(scene: &Scene, record: &RunRecord, replay: &mut Replay<'_>) -> Result<Verdict, RenderError> {
    let violations = violations(scene, record);
    let judged = methods::false_claims(scene, record);
    let misperceived = methods::misperceived(record, &judged);
    let false_claims: Vec<usize> = judged.iter().map(|judged| judged.total()).collect();
    let (containment, judgements) = match record.has_boxes {
        true => {
            let (containment, judgements) =
                containment::containment(scene, record, &violations, &misperceived, replay)?;
            (Some(containment), judgements)
        }
        false => (None, Vec::new()),
    };
    let truths: Vec<Pose> = record.truths.iter().map(|truth| truth.pose).collect();
    let midpoints = midpoints(record);
    let baselines = baselines(record);
    let mut verdict = Verdict {
        containment,
        judgements,
        subject_failure: record.subject_failure.clone(),
        violations,
        error: ErrorTable {
            at_fix: Some(Box::new(statistics::errors_at_fix(record))),
            ..statistics::errors(&midpoints, &truths)
        },
        width: record.has_boxes.then(|| statistics::widths(record)),
        power: record.has_boxes.then(|| statistics::power(record)),
        availability: record.has_boxes.then(|| availability(scene, record)),
        post_localization: post::post_localization(record),
        distribution: distribution::distribution(record),
        latency_s: latency(&record.ages_s),
        methods: methods::counts(record, &false_claims),
        baselines,
        metrics: metrics(scene, record, &judged),
        verdict: Passed::default(),
    };
    // A verdict consists of numbers and strings and can always be serialised; if that failed, every expectation would be reported as unmet.
    let mut passed = scene.expect.evaluate(&serde_json::to_value(&verdict).unwrap_or_default());
    if let Some(failure) = &record.subject_failure {
        passed.failed.insert(0, failure.to_string());
        passed.passed = false;
    }
    verdict.verdict = passed;
    Ok(verdict)
}

/// The middle of the box around each estimate, or the point or mean that the localizer states. A localizer that states points or distributions may
/// count its turns from anywhere, so that its headings are put within half a turn of the true ones.
fn midpoints(record: &RunRecord) -> Vec<Pose> {
    let steps = record.estimates.iter().zip(&record.truths);
    let of = |(estimate, truth): (&Estimate, &Truth)| {
        let middle = statistics::midpoint(&estimate.pose.hull());
        if record.has_boxes {
            return middle;
        }
        let off_rad = half_turn(middle.heading_rad - truth.pose.heading_rad);
        Pose { heading_rad: truth.pose.heading_rad + off_rad, ..middle }
    };
    steps.map(of).collect()
}

/// Mean and greatest of the ages that are known.
fn latency(ages_s: &[Option<f64>]) -> Option<Latency> {
    let known: Vec<f64> = ages_s.iter().copied().flatten().collect();
    let greatest = known.iter().copied().reduce(f64::max)?;
    Some(Latency { mean: known.iter().sum::<f64>() / known.len() as f64, max: greatest })
}

/// The figures of the methods to compare with, by their names.
fn baselines(record: &RunRecord) -> BTreeMap<String, Baseline> {
    let figures = |told: &Told<'_>| match told {
        Told::Poses(poses, truths) => {
            Baseline { error: Some(statistics::errors(poses, truths)), ..Baseline::default() }
        }
        Told::Boxes(answers) => {
            let containment = BaselineContainment { checks: answers.problems, contained: answers.contained };
            let width = BaselineWidth { at_fix: statistics::fix_width(&answers.hulls) };
            Baseline { error: None, containment: Some(containment), width: Some(width) }
        }
    };
    record.baselines().iter().map(|answers| (answers.name.to_owned(), figures(&answers.told))).collect()
}

/// Share of the steps at which the localizer doubts no assumption (its status is sound), its boxes hold the truth, and the box around them is
/// narrower than the scene's declared width.
fn availability(scene: &Scene, record: &RunRecord) -> f64 {
    let (width_m, width_rad) = (scene.localizer.declared_width_m, scene.localizer.declared_width_deg.to_radians());
    let available = record.estimates.iter().zip(&record.truths).filter(|(estimate, truth)| {
        let hull = estimate.pose.hull();
        estimate.status == Status::Sound
            && estimate.pose.contains(truth.pose)
            && hull[0].width() <= width_m
            && hull[1].width() <= width_m
            && hull[2].width() <= width_rad
    });
    share(available.count(), record.estimates.len())
}

/// Further figures that help to understand a run, such as the distance driven, the number of boxes in the estimate, the time in which the localizer
/// doubted its assumptions, and the time with the truth outside the boxes.
fn metrics(scene: &Scene, record: &RunRecord, judged: &[FalseClaims]) -> BTreeMap<String, f64> {
    let distance_m: f64 = record
        .truths
        .windows(2)
        .map(|pair| (pair[1].pose.x_m - pair[0].pose.x_m).hypot(pair[1].pose.y_m - pair[0].pose.y_m))
        .sum();
    let n_branches =
        |index: usize| record.estimates.get(index).map_or(0, |estimate| estimate.pose.branches.len()) as f64;
    let most = record.estimates.iter().map(|estimate| estimate.pose.branches.len()).max().unwrap_or(0);
    let recovering = record.estimates.iter().filter(|estimate| estimate.status == Status::Recovering).count();
    let mut metrics = BTreeMap::from([("distance_m".to_string(), distance_m)]);
    if record.has_boxes {
        metrics.extend([
            ("branches_max".to_string(), most as f64),
            ("branches_at_end".to_string(), n_branches(record.estimates.len().saturating_sub(1))),
            ("recovering_share".to_string(), share(recovering, record.estimates.len())),
            ("longest_outside_s".to_string(), longest_outside_s(record)),
        ]);
        if scene.start.anywhere {
            metrics.insert("searched_s".to_string(), searched_s(record));
        }
    }
    metrics.extend(landmarks::metrics(scene, record));
    metrics.extend(taught_map::metrics(scene, record));
    metrics.extend(errands::metrics(record));
    metrics.extend(markers::metrics(scene, record));
    metrics.extend(headings::metrics(record, judged));
    metrics.extend(space_points::metrics(scene, record));
    metrics
}

/// Width of the box in x and in y from which on a robot that was put down anywhere counts as found.
const FOUND_M: f64 = 0.2;

/// Time until the robot's place was first known; the whole run if it never was.
fn searched_s(record: &RunRecord) -> f64 {
    let is_found = |estimate: &&Estimate| {
        let hull = estimate.pose.hull();
        !hull.is_empty() && hull.width(0).max(hull.width(1)) <= FOUND_M
    };
    let found = record.estimates.iter().find(is_found).or(record.estimates.last());
    found.map_or(0.0, |estimate| estimate.time_s)
}

/// Longest time for which the truth was continuously outside the union of boxes.
fn longest_outside_s(record: &RunRecord) -> f64 {
    let mut longest_s = 0.0_f64;
    let mut since_s = None;
    for (truth, estimate) in record.truths.iter().zip(&record.estimates) {
        if estimate.pose.contains(truth.pose) {
            since_s = None;
        } else {
            let from_s = *since_s.get_or_insert(truth.time_s);
            longest_s = longest_s.max(truth.time_s - from_s);
        }
    }
    longest_s
}

fn share(part: usize, whole: usize) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}
