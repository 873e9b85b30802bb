//! The worst cases of a report in detail, and a typical one: what went wrong, errors over time, and a picture.

use maud::{Markup, PreEscaped, html};

use crate::campaign::cases::{CaseResult, Replay, Results};

use super::{
    Overview, corridor,
    incidents::{events, incidents},
    looked_back, picture,
    steps::{self, Step},
    text::{contradictions, first_outside, greatest_parts},
};

/// Greatest number of the worst cases that the page shows in detail.
const MOST_WORST: usize = 4;

/// Shows the worst cases, and the case with the median error as a typical one.
pub(super) fn worst_cases(overview: &Overview, results: &Results) -> Markup {
    let worst = diverse(overview.worst.iter().map(|index| &results.cases[*index]));
    // Where only the worst cases are kept, none of them is a typical one.
    let typical = if overview.sketched.is_some() { None } else { typical(results) };
    let has_boxes = overview.figures.contains_key("width.x_m.mean");
    let has_distributions = overview.figures.keys().any(|name| name.starts_with("distribution."));
    let typical = typical.filter(|typical| worst.iter().all(|case| !std::ptr::eq(*case, *typical)));
    html! {
        @if !worst.is_empty() {
            h2 { "The worst cases" }
            p.note {
                @if overview.n_missed == 0 { "No case failed; these are the worst of those that passed. " }
                "Of different seeds and combinations first. "
                @if has_boxes {
                    "Line: error of the midpoint. Band: the width of the box; the line leaves it when the truth leaves the hull. Grey stripes: the scene's "
                    "events. "
                }
                @if has_distributions {
                    "Of a distribution: the error of its mean, and three standard deviations to either side; marks below are steps with the truth outside."
                }
            }
            @for case in worst { (told(overview, case)) }
            @if let Some(case) = typical {
                h2 { "A typical case" }
                p.note { "The one with the median error." }
                (told(overview, case))
            }
        }
    }
}

/// Selects the first cases of which no two of one scene share their seed or their settings, and fills up with further cases where there are too few.
/// A failure looks alike in cases that differ in one key only, so that one of them is enough.
fn diverse<'a>(cases: impl Iterator<Item = &'a CaseResult>) -> Vec<&'a CaseResult> {
    let (mut told, mut others): (Vec<&CaseResult>, Vec<&CaseResult>) = (Vec::new(), Vec::new());
    for case in cases {
        let is_alike =
            |one: &&CaseResult| one.scene == case.scene && (one.seed == case.seed || one.settings == case.settings);
        let is_full = told.len() >= MOST_WORST;
        if is_full || told.iter().any(is_alike) { others.push(case) } else { told.push(case) }
    }
    told.into_iter().chain(others).take(MOST_WORST).collect()
}

fn typical(results: &Results) -> Option<&CaseResult> {
    let error = |case: &CaseResult| case.figures().get("error.position_m.mean").copied();
    let mut ran: Vec<(f64, &CaseResult)> = results.cases.iter().filter_map(|case| Some((error(case)?, case))).collect();
    ran.sort_by(|one, other| one.0.total_cmp(&other.0));
    ran.get(ran.len() / 2).map(|(_, case)| *case)
}

fn told(overview: &Overview, case: &CaseResult) -> Markup {
    let boxes: Vec<Step> = steps::read(&case.folder);
    let steps = if boxes.is_empty() { steps::of_distributions(&case.folder) } else { boxes };
    let looked_back = looked_back::read(&case.folder);
    html! {
        article {
            h3 { (case.describe(overview.has_scenes)) }
            @if let Some(first) = first_outside(case) { p.bad { (first) } }
            @if let Some(summary) = case.summary() { (incidents(summary)) }
            @for found in contradictions(case) { p { (found) } }
            @for part in greatest_parts(case) { p { (part) } }
            @let missed = case.missed_expectations();
            @if !missed.is_empty() { ul { @for line in missed { li { (line) } } } }
            div.plots {
                figure { (PreEscaped(corridor::to_svg(&steps, &case.summary().map(events).unwrap_or_default()))) }
                @if !looked_back.is_empty() {
                    figure {
                        (PreEscaped(looked_back::to_svg(&looked_back)))
                        figcaption {
                            "Box minus truth at the key frames: as known in real time, and by what was read later, too (inner band)."
                        }
                    }
                }
                @if let Some(address) = picture::data_url(case) {
                    figure { img src=(address) alt="what the camera saw and where the robot is"; }
                }
            }
            pre { code { (Replay::of(case, "renders")) } }
        }
    }
}
