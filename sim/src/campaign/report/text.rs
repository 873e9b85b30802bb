//! The report as text for a terminal.

use serde_json::Value;

use crate::{
    artefacts::wording::{outside_by, significant},
    campaign::cases::{CaseResult, Replay, Results},
};

use super::{Overview, chosen::Combinations, incidents::broken};

/// Greatest number of combinations that are printed; a sweep with more has its HTML report and its CSV file.
const MOST_GROUPS: usize = 60;
/// Greatest number of failed cases that are printed in full.
const MOST_WORST: usize = 5;

/// Writes a table of the combinations, then every case that is missing or could not run, then the worst of those that missed an
/// expectation, with the command that runs each again, and at last the verdict.
pub fn as_text(overview: &Overview, results: &Results) -> String {
    let mut text = table(overview);
    for case in results.missing() {
        text += &format!("MISSING {}\n", case.describe(overview.has_scenes));
    }
    let n_unlisted = overview.n_missing - results.missing().count();
    if n_unlisted > 0 {
        text += &format!("and {n_unlisted} MISSING more\n");
    }
    for (case, reason) in results.failed() {
        text += &format!("COULD NOT RUN {}: {reason}\n", case.describe(overview.has_scenes));
        text += &format!("  replay: {}\n", Replay::of(case, "renders"));
    }
    let n_unlisted = overview.n_failed - results.failed().count();
    if n_unlisted > 0 {
        text += &format!("and {n_unlisted} more that COULD NOT RUN\n");
    }
    let missed = overview.worst.iter().map(|index| &results.cases[*index]).filter(|case| case.passed() == Some(false));
    for case in missed.take(MOST_WORST) {
        text += &failure(case, overview.has_scenes);
    }
    if overview.n_missed > MOST_WORST {
        text += &format!("and {} more that missed an expectation\n", overview.n_missed - MOST_WORST);
    }
    if let Some(sketched) = &overview.sketched {
        text += &format!("\n{}\n", sketched.note());
    }
    for told in overview.honesty() {
        text += &format!("\n{told}.\n");
    }
    let verdict = if overview.has_passed() { "passed" } else { "FAILED" };
    text += &format!("\n{verdict}: {}.", overview.headline());
    if overview.outside().is_empty() {
        return text + "\n";
    }
    let outside: Vec<String> = overview.outside().iter().map(|(name, n)| format!("{n} {name}")).collect();
    let checks = overview.figures.get("containment.checks").copied().unwrap_or_default();
    text += &format!(" Of {checks} checks, outside the box: {}.\n", outside.join(", "));
    text
}

/// Describes a failed case: the expectations that it missed, its first failure, and the command that runs it again.
fn failure(case: &CaseResult, with_scene: bool) -> String {
    let mut text = format!("FAILED {}\n", case.describe(with_scene));
    for line in case.missed_expectations() {
        text += &format!("  {line}\n");
    }
    if let Some(first) = first_outside(case) {
        text += &format!("  {first}\n");
    }
    let bounds = case.summary().map(broken_bounds).unwrap_or_default();
    for found in bounds.into_iter().chain(contradictions(case)) {
        text += &format!("  {found}\n");
    }
    text + &format!("  replay: {}\n", Replay::of(case, "renders"))
}

/// Describes the first step at which the truth was outside: when, along which axis, by how much and why.
pub fn first_outside(case: &CaseResult) -> Option<String> {
    first_outside_of(case.first_failure())
}

/// Describes the first step at which the truth was outside, as the table `first_failure` of a summary tells it.
pub fn first_outside_of(first: &Value) -> Option<String> {
    let (time_s, margin) = (first["time_s"].as_f64()?, first["margin"].as_f64()?);
    let (axis, outcome, blame) = (first["axis"].as_str()?, first["outcome"].as_str()?, first["blame"].as_str()?);
    let outcome = outcome.replace('_', " ");
    Some(format!("first outside at {time_s:.2} s: {}, {outcome}: {blame}", outside_by(axis, margin)))
}

/// Describes every declared bound that was broken: when, and by how much.
pub fn broken_bounds(summary: &Value) -> Vec<String> {
    broken(summary).iter().map(|bound| bound.text()).collect()
}

/// Describes the contradictions between readings that the localizer found: when, and which bounds cannot all be true.
pub(super) fn contradictions(case: &CaseResult) -> Vec<String> {
    let found = case.summary().and_then(|summary| summary["contradictions"].as_array());
    found.into_iter().flatten().filter_map(contradiction).collect()
}

fn contradiction(found: &Value) -> Option<String> {
    let bounds: Vec<&str> = found["bounds"].as_array()?.iter().filter_map(Value::as_str).collect();
    let is_earlier = found["earlier"].as_bool() == Some(true);
    let earlier = is_earlier.then(|| "what was known before was false".to_owned());
    let named = (!bounds.is_empty()).then(|| format!("one of {} is broken", bounds.join(", ")));
    let either: Vec<String> = named.into_iter().chain(earlier).collect();
    let (time_s, bounds, either) = (found["time_s"].as_f64()?, bounds.join(", "), either.join(", or "));
    Some(match found["factor"].as_f64() {
        Some(factor) => format!(
            "readings contradict each other at {time_s:.2} s: {either}, or another bound is exceeded more than {}-fold",
            significant(factor)
        ),
        None => format!("readings contradict each other at {time_s:.2} s: most likely one of {bounds} is broken"),
    })
}

/// Describes, for each axis, the declared bound that makes most of the boxes' mean width at the localizer's key frames.
pub(super) fn greatest_parts(case: &CaseResult) -> Vec<String> {
    let axes = [("x_m", "x", 1e3, "mm"), ("y_m", "y", 1e3, "mm"), ("heading_rad", "heading", 1e3, "mrad")];
    let of_axis = |(key, axis, per_unit, unit): (&str, &str, f64, &str)| {
        let parts = case.summary()?["width_by_bound"][key].as_object()?;
        let width = parts.values().filter_map(Value::as_f64).sum::<f64>();
        // The names of bounds have a dot; the other parts are no bounds.
        let bounds = parts.iter().filter(|(name, _)| name.contains('.'));
        let (bound, part) = bounds
            .filter_map(|(name, part)| Some((name, part.as_f64()?)))
            .max_by(|one, other| one.1.total_cmp(&other.1))?;
        let [part, width] = [part, width].map(|one| one * per_unit);
        Some(format!("{bound} makes {part:.1} {unit} of the {width:.1} {unit} of mean width in {axis} at key frames"))
    };
    axes.into_iter().filter_map(of_axis).collect()
}

fn table(overview: &Overview) -> String {
    let Combinations { headings, n_labels, rows, n_left_out } = overview.combinations();
    let lines: Vec<Vec<String>> = [headings].into_iter().chain(rows.into_iter().take(MOST_GROUPS)).collect();
    let mut text = aligned(&lines, n_labels);
    if n_left_out > 0 {
        text += &format!("  --columns all shows {n_left_out} more figures of each line\n");
    }
    if overview.groups.len() > MOST_GROUPS {
        text += &format!("  and {} combinations more\n", overview.groups.len() - MOST_GROUPS);
    }
    text
}

/// Aligns the first `n_texts` columns of a table at the left, the others at the right.
fn aligned(rows: &[Vec<String>], n_texts: usize) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let cell = |(column, text): (usize, &String)| {
        let width = widths[column];
        if column < n_texts { format!("{text:<width$}") } else { format!("{text:>width$}") }
    };
    let line = |row: &Vec<String>| row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ");
    rows.iter().map(|row| format!("  {}\n", line(row).trim_end())).collect()
}
