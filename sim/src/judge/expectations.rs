//! Compares the figures of a run with what its scene expects.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::{
    run::{ForwardBaselines, LandmarkBaselines, MarkerBaselines, needs_baselines},
    scene::{Expect, conform::nearest},
};

use super::{Baseline, ErrorTable, Passed, Verdict, figures::figures};

/// How a figure is compared with its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    Exactly,
    AtMost,
    AtLeast,
}

/// Counts that a scene's expectations may name without the prefix `containment.`.
const SHORTHAND: [&str; 5] = ["checks", "contained", "bound_broken", "perception", "unsound"];

/// Placeholder for the names in a summary that depend on the run, such as those of methods: in the list of known figures any one name matches `*`.
const ANY_NAME: &str = "*";

/// Names of the figures of a summary's table `metrics` that are about the localizer under test and its run.
const OF_THE_RUN: [&str; 47] = [
    "arrival_error_greatest_m",
    "arrival_error_mean_m",
    "arrival_estimate_greatest_m",
    "arrivals_off",
    "branches_at_end",
    "branches_max",
    "clearance_furniture_least_m",
    "clearance_least_m",
    "clearance_people_least_m",
    "collisions",
    "distance_m",
    "errands",
    "goals_missed",
    "goals_reached",
    "heading_error_max_deg",
    "heading_error_p95_deg",
    "landmark_width_m",
    "landmarks_grown",
    "landmarks_known",
    "landmarks_outside",
    "landmarks_outside_longest_s",
    "longest_outside_s",
    "map_box_median_m3",
    "map_boxes_below_0_001_m3_share",
    "map_boxes_below_0_004_m3_share",
    "map_boxes_below_0_008_m3_share",
    "map_landmarks",
    "marker_images",
    "marker_images_read_share",
    "markers_in_view",
    "markers_misread",
    "markers_read_share",
    "path_deviation_greatest_m",
    "path_deviation_p95_m",
    "recovering_share",
    "replans",
    "searched_s",
    "waited_s",
    "wall_fix_contained_share",
    "wall_fix_error_max_deg",
    "wall_fix_error_p95_deg",
    "wall_fix_share",
    "wall_fix_width_mean_deg",
    "wall_images",
    "wall_lines_per_image",
    "wall_spoilt_images_max",
    "wall_wrong_share_max",
];

/// Names of all figures that a summary's table `metrics` may hold; a run has those of the things that it measures.
pub fn metric_names() -> impl Iterator<Item = &'static str> {
    let of_baselines = [MarkerBaselines::FIGURES, ForwardBaselines::FIGURES, LandmarkBaselines::FIGURES];
    OF_THE_RUN.into_iter().chain(of_baselines.into_iter().flatten())
}

/// Beginnings of the names of figures that only a localizer can have which states boxes.
const OF_BOXES: [&str; 13] = [
    "availability",
    "containment.",
    "error.at_fix.",
    "methods.",
    "metrics.branches_",
    "metrics.landmark",
    "metrics.longest_outside_s",
    "metrics.map_",
    "metrics.recovering_share",
    "metrics.wall_fix_",
    "post_localization.",
    "power.",
    "width.",
];

impl Expect {
    /// Checks `summary` against the limits that the scene states as its expectations.
    ///
    /// `summary` is a serialised [`Verdict`] or a whole summary.json. A figure that the run did not measure misses every limit, except for figures of
    /// boxes where the localizer states none, and of distributions where it states none: their limits do not apply.
    pub fn evaluate(&self, summary: &Value) -> Passed {
        let measured = figures(summary);
        let names: Vec<String> = measured.keys().cloned().collect();
        let states_boxes = !summary["containment"].is_null();
        let states_distributions = !summary["distribution"].is_null();
        let known: Vec<String> = figures(&blank_summary()).into_keys().collect();
        // A figure of boxes without boxes, or of distributions without distributions. A localizer that states neither a box nor a distribution is to be
        // measured by its error.
        let is_of_another_kind = |name: &str| {
            let figure = resolve(name, &known).map(|(figure, _)| figure);
            figure.is_some_and(|figure| {
                !states_boxes && OF_BOXES.iter().any(|of_boxes| figure.starts_with(of_boxes))
                    || !states_distributions && figure.starts_with("distribution.")
            })
        };
        let (mut missed, mut not_applicable) = (Vec::new(), Vec::new());
        for (name, limit) in self.named_limits() {
            let Some(limit) = limit.as_f64() else { continue };
            let Some((figure, sense)) = resolve(&name, &names) else {
                if is_of_another_kind(&name) {
                    not_applicable.push(format!("{name} = {limit}"));
                    continue;
                }
                missed.push(format!("{name} = {limit}, but the run did not measure it"));
                continue;
            };
            // Steps of which no normalised error is known would leave the mean of the others.
            let unusable = measured.get("distribution.unusable").filter(|unusable| **unusable > 0.0);
            if let Some(unusable) = unusable.filter(|_| figure.starts_with("distribution.nees.")) {
                missed
                    .push(format!("{name} = {limit}, but {unusable} steps state no distribution that could be judged"));
                continue;
            }
            let value = measured[&figure];
            let (is_met, wanted) = match sense {
                Sense::Exactly => (value == limit, "expected"),
                Sense::AtMost => (value <= limit, "expected at most"),
                Sense::AtLeast => (value >= limit, "expected at least"),
            };
            if !is_met {
                missed.push(format!("{figure} is {value}, {wanted} {limit}"));
            }
        }
        Passed { passed: missed.is_empty(), failed: missed, not_applicable }
    }

    /// Whether a limit is on a figure that a run measures only when the methods to compare with are run, too.
    pub fn needs_baselines(&self) -> bool {
        let known: Vec<String> = figures(&blank_summary()).into_keys().collect();
        self.named_limits()
            .iter()
            .any(|(name, _)| resolve(name, &known).is_some_and(|(figure, _)| needs_baselines(&figure)))
    }

    /// Names of limits that no figure has, and limits that are not numbers, each with what was expected.
    pub(crate) fn unknown(&self) -> Vec<(String, String)> {
        let known: Vec<String> = figures(&blank_summary()).into_keys().collect();
        let mut unknown = Vec::new();
        for (name, limit) in self.named_limits() {
            if resolve(&name, &known).is_none() {
                // A name without a point is more like the shorthands than like any figure's whole name.
                let names = SHORTHAND.into_iter().chain(known.iter().map(String::as_str));
                let stem = ["_max", "_min"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(&name);
                let expected = match nearest(stem, names) {
                    Some(meant) => format!("unknown figure, expected `{meant}`, `{meant}_max` or `{meant}_min`?"),
                    None => "unknown figure, expected one of those in summary.json".to_owned(),
                };
                unknown.push((name, expected));
            } else if !limit.as_f64().is_some_and(f64::is_finite) {
                unknown.push((name, "expected a finite number".to_owned()));
            }
        }
        unknown
    }

    fn named_limits(&self) -> Vec<(String, &Value)> {
        fn collect<'a>(
            table: impl Iterator<Item = (&'a String, &'a Value)>,
            prefix: &str,
            named: &mut Vec<(String, &'a Value)>,
        ) {
            for (key, value) in table {
                let name = format!("{prefix}{key}");
                match value {
                    Value::Object(inner) => collect(inner.iter(), &format!("{name}."), named),
                    _ => named.push((name, value)),
                }
            }
        }
        let mut named = Vec::new();
        collect(self.limits.iter(), "", &mut named);
        named
    }
}

/// The figure that a limit's name refers to, and how the two are compared. A figure's full name is tried first, as some names end in `_max`
/// themselves.
fn resolve(name: &str, known: &[String]) -> Option<(String, Sense)> {
    let suffixes = [("", Sense::Exactly), ("_max", Sense::AtMost), ("_min", Sense::AtLeast)];
    suffixes.into_iter().find_map(|(suffix, sense)| {
        let stem = name.strip_suffix(suffix)?;
        let full = if SHORTHAND.contains(&stem) { format!("containment.{stem}") } else { stem.to_owned() };
        known.iter().any(|figure| matches(figure, &full)).then_some((full, sense))
    })
}

fn matches(figure: &str, name: &str) -> bool {
    let (mut wanted, mut given) = (figure.split('.'), name.split('.'));
    loop {
        match (wanted.next(), given.next()) {
            (None, None) => return true,
            (Some(wanted), Some(given)) if wanted == given || wanted == ANY_NAME => {}
            _ => return false,
        }
    }
}

/// A made-up summary that has every figure that a run may have.
fn blank_summary() -> Value {
    let baseline = Baseline {
        error: Some(Default::default()),
        containment: Some(Default::default()),
        width: Some(Default::default()),
    };
    let verdict = Verdict {
        containment: Some(Default::default()),
        judgements: Vec::new(),
        subject_failure: None,
        violations: Vec::new(),
        error: ErrorTable { at_fix: Some(Default::default()), ..Default::default() },
        width: Some(Default::default()),
        power: Some(Default::default()),
        availability: Some(0.0),
        post_localization: Some(Default::default()),
        distribution: Some(Default::default()),
        latency_s: Some(Default::default()),
        methods: BTreeMap::from([(ANY_NAME.to_owned(), Default::default())]),
        baselines: BTreeMap::from([(ANY_NAME.to_owned(), baseline)]),
        metrics: metric_names().map(|name| (name.to_owned(), 0.0)).collect(),
        verdict: Default::default(),
    };
    // The keys of a verdict are texts, so that serialising it cannot fail.
    serde_json::to_value(&verdict).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_beginning_of_a_figure_of_boxes_begins_a_figure_that_a_run_may_have() {
        let known = figures(&blank_summary());
        for beginning in OF_BOXES {
            assert!(known.keys().any(|figure| figure.starts_with(beginning)), "no figure begins with {beginning}");
        }
    }
}
