//! How errands went in truth: which goals were reached, what was touched, and how far the robot was from its planned path.

use std::collections::BTreeMap;

use crate::{
    driver::{ErrandLog, ErrandRecord, Outcome},
    run::RunRecord,
};

/// Greatest distance at which two bodies count as touching. The collider of the physics is 1 mm wider than the body, and its contacts are soft.
const TOUCH_M: f64 = 0.002;

/// Figures of a run's errands; empty for a run that follows a route.
///
/// `arrivals_off` counts goals that the robot reached according to its estimate although its true distance exceeds the goal's tolerance plus half the
/// diagonal of the estimate's box.
pub(super) fn metrics(record: &RunRecord) -> BTreeMap<String, f64> {
    let Some(log) = &record.errands else { return BTreeMap::new() };
    let reached = || log.errands.iter().filter(|errand| errand.outcome == Outcome::Reached);
    let true_m: Vec<f64> = reached().filter_map(|errand| true_distance_m(record, errand)).collect();
    let estimated_m = reached().filter_map(|errand| errand.estimated_distance_m);
    let is_off = |errand: &&ErrandRecord| {
        let allowed_m = errand.tolerance_m + errand.box_reach_m.unwrap_or(0.0);
        true_distance_m(record, errand).is_none_or(|distance_m| distance_m > allowed_m)
    };
    let deviations_m = deviations_m(log, record);
    let total = |count: fn(&ErrandRecord) -> f64| log.errands.iter().map(count).sum::<f64>();
    let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let mut metrics = BTreeMap::from([
        ("errands".to_owned(), log.errands.len() as f64),
        ("goals_reached".to_owned(), reached().count() as f64),
        ("goals_missed".to_owned(), (log.errands.len() - reached().count()) as f64),
        ("arrivals_off".to_owned(), reached().filter(is_off).count() as f64),
        ("replans".to_owned(), total(|errand| errand.plans.saturating_sub(1) as f64)),
        ("waited_s".to_owned(), total(|errand| errand.waited_s)),
        ("collisions".to_owned(), collisions(record) as f64),
        ("path_deviation_p95_m".to_owned(), p95(&deviations_m)),
        ("path_deviation_greatest_m".to_owned(), greatest(&deviations_m)),
    ]);
    if !true_m.is_empty() {
        metrics.extend([
            ("arrival_error_mean_m".to_owned(), true_m.iter().sum::<f64>() / true_m.len() as f64),
            ("arrival_error_greatest_m".to_owned(), greatest(&true_m)),
            ("arrival_estimate_greatest_m".to_owned(), estimated_m.fold(0.0, f64::max)),
        ]);
    }
    let least = |of: fn(&crate::run::Clearance) -> f64| record.clearances.iter().map(of).fold(f64::INFINITY, f64::min);
    let clearances = [
        ("clearance_least_m", least(|clearance| clearance.least_m())),
        ("clearance_furniture_least_m", least(|clearance| clearance.furniture_m)),
        ("clearance_people_least_m", least(|clearance| clearance.people_m)),
    ];
    // Where a scene has no obstacles of a kind, such as people, there is no least distance to them, and the figure is left out.
    let stated = clearances.into_iter().filter(|(_, least_m)| least_m.is_finite());
    metrics.extend(stated.map(|(name, least_m)| (name.to_owned(), least_m)));
    metrics
}

/// Distance of the robot's true position from an errand's goal when the errand ended; `None` for an errand that has not ended.
pub fn true_distance_m(record: &RunRecord, errand: &ErrandRecord) -> Option<f64> {
    let ended_s = errand.ended_s?;
    // The command that ends an errand acts after the true state of the same time, so that state is the one in which the errand ended.
    let truth = record.truths.iter().find(|truth| truth.time_s > ended_s - 0.005)?;
    Some((truth.pose.x_m - errand.goal_m[0]).hypot(truth.pose.y_m - errand.goal_m[1]))
}

/// How many times the robot began to touch something.
fn collisions(record: &RunRecord) -> usize {
    let touches = |step: usize| record.clearances.get(step).is_some_and(|clearance| clearance.least_m() <= TOUCH_M);
    (0..record.clearances.len()).filter(|&step| touches(step) && (step == 0 || !touches(step - 1))).count()
}

/// Distance of the robot's true position from the path that it followed, at each step of each leg.
fn deviations_m(log: &ErrandLog, record: &RunRecord) -> Vec<f64> {
    let of_leg = |leg: &crate::driver::Leg| {
        let (from_s, until_s, corners_m) = (leg.from_s, leg.until_s, leg.corners_m.clone());
        let steps = record.truths.iter().filter(move |truth| (from_s..=until_s).contains(&truth.time_s));
        steps.map(move |truth| distance_to_way_m([truth.pose.x_m, truth.pose.y_m], &corners_m)).collect::<Vec<_>>()
    };
    log.legs.iter().flat_map(of_leg).collect()
}

/// Distance of a point from a polyline through the given corners.
pub fn distance_to_way_m(place_m: [f64; 2], corners_m: &[[f64; 2]]) -> f64 {
    let to_piece = |pair: &[[f64; 2]]| {
        let along = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let from = [place_m[0] - pair[0][0], place_m[1] - pair[0][1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let share =
            if square > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
        (from[0] - share * along[0]).hypot(from[1] - share * along[1])
    };
    corners_m.windows(2).map(to_piece).fold(f64::INFINITY, f64::min)
}

fn p95(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * 0.95).round() as usize).copied().unwrap_or(0.0)
}
