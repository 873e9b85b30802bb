//! The report as one page of HTML without scripts or external files, for light and dark, wide and narrow screens.

use std::collections::BTreeSet;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::{
    artefacts::{
        log::log_text,
        result_table::{self, Shown},
    },
    campaign::cases::{CaseResult, Replay, Results},
    judge::{Judgement, figures::Figures},
};

use super::{
    Overview,
    chosen::Combinations,
    costs::{CALIBRATION, CALIBRATION_NOTE, Cost, HEADINGS, NOTE, costs},
    diagram::Diagram,
    heatmap::heatmaps,
    steps,
    worst::worst_cases,
};

const STYLE: &str = include_str!("style.css");
/// Greatest number of rows in the table of all cases; of a larger sweep only the CSV file lists all cases.
const MOST_ROWS: usize = 2000;

/// Writes the HTML page of the report. The steps of the runs and the debug frames (pictures of what the vision found) are read from the folders of
/// the cases.
pub fn as_html(overview: &Overview, results: &Results) -> String {
    let (tone, word, mark) =
        if overview.has_passed() { ("passed", "Passed", "✓") } else { ("failed", "Failed", "✕") };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (word) ": " (results.title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Wherein · " (results.title) }
                div.verdict.(tone) { strong { (mark) " " (word) } (overview.headline()) "." @for told in overview.honesty() { br; (told) "." } }
                (key_figures(overview))
                (absent(overview, results))
                @if let Some(heatmaps) = heatmaps(overview) { (heatmaps) }
                @match &overview.sketched {
                    None => (diagrams(results)),
                    Some(sketched) => (sketched.to_html()),
                }
                (worst_cases(overview, results))
                (logs(overview, results))
                (groups(overview))
                @if overview.sketched.is_none() { (localizers(results)) }
                (methods(overview))
                (cases(overview, results))
                (origin(overview, results))
            }
        }
    };
    page.into_string()
}

fn key_figures(overview: &Overview) -> Markup {
    let number = |name: &str| overview.figures.get(name).copied().unwrap_or_default();
    html! {
        dl.figures {
            // Pooled over several localizers, a figure would be nobody's.
            @for measure in overview.measures().filter(|measure| !measure.is_detail() && !overview.has_subjects) {
                div title=(measure.meaning) {
                    dt { (measure.name) }
                    dd { (measure.of(&overview.figures)) " " small { (measure.unit) } }
                }
            }
            @for (name, count) in overview.outside() {
                div style=(if count > 0 { "--tone:var(--unsound)" } else { "" }) {
                    dt { (name) }
                    dd { (count) " " small { "of " (number("containment.checks")) " checks" } }
                }
            }
        }
    }
}

/// Lists every case that did not run, by name.
fn absent(overview: &Overview, results: &Results) -> Markup {
    html! {
        @if overview.n_missing + overview.n_failed > 0 {
            h2 { "Not run" }
            ul {
                @for (case, reason) in results.failed() {
                    li { span.bad { "could not run: " } (case.describe(overview.has_scenes)) " – " (reason) }
                }
                @for case in results.missing() {
                    li { span.bad { "missing: " } (case.describe(overview.has_scenes)) }
                }
                @let n_listed = results.failed().count() + results.missing().count();
                @let n_absent = overview.n_missing + overview.n_failed;
                @if n_absent > n_listed { li { "and " (n_absent - n_listed) " more" } }
            }
        }
    }
}

fn diagrams(results: &Results) -> Markup {
    let (mut position, mut heading) = (Diagram::position(), Diagram::heading());
    for case in results.cases.iter().filter(|case| case.summary().is_some()) {
        let steps = steps::read(&case.folder);
        position.add(&steps);
        heading.add(&steps);
    }
    let position = position.to_svg();
    html! {
        @if !position.is_empty() {
            h2 { "Is the error inside the width?" }
            p.note {
                "Every step of every case. Below the line the truth is inside the hull of the boxes; darker is more steps. "
                "Errors below a hundredth of the width are drawn there. A truth between two branches is below the line and "
                "yet not contained."
            }
            div.plots {
                figure { figcaption { strong { "position" } span { " – x or y, whichever is closer to its bound" } } (PreEscaped(position)) }
                figure { figcaption { strong { "heading" } } (PreEscaped(heading.to_svg())) }
            }
            (legend())
        }
    }
}

fn legend() -> Markup {
    html! {
        ul.legend {
            @for judgement in Judgement::ALL {
                @let tone = if judgement == Judgement::Contained { "blue" } else { judgement.name() };
                li { i style=(format!("--tone:var(--{tone})")) {} (judgement.name().replace('_', " ")) }
            }
        }
    }
}

/// Shows what was found in each log that another program recorded: its topics, what was dropped, gaps, damage, and how tight the declared bounds are.
fn logs(overview: &Overview, results: &Results) -> Markup {
    let logs: Vec<(&CaseResult, String)> =
        results.cases.iter().filter_map(|case| Some((case, log_of(case)?))).collect();
    html! {
        @if !logs.is_empty() {
            h2 { "What the logs hold" }
            p.note {
                "Times are seconds since the log's first reading of the wheels. A bound is too tight where the log's true poses show a greater error than "
                "it declares."
            }
            @for (case, text) in logs {
                article {
                    h3 { (case.describe(overview.has_scenes)) }
                    pre { (text) }
                    pre { code { (Replay::of(case, "renders")) } }
                }
            }
        }
    }
}

fn log_of(case: &CaseResult) -> Option<String> {
    let summary = case.summary()?;
    summary["log"].is_object().then(|| log_text(summary))
}

/// Shows the table of all combinations with the figures that were asked for, and below it, to unfold, with all figures.
fn groups(overview: &Overview) -> Markup {
    let usual = overview.combinations();
    let all = Overview { shown: Shown::All, ..overview.clone() }.combinations();
    let table = |id: &str, table: &Combinations| {
        let is_text = |column: usize| column < table.n_labels;
        html! {
            div.table { table {
                thead { tr { @for (column, heading) in table.headings.iter().enumerate() { th.text[is_text(column)] { (heading) } } } }
                tbody id=(id) { @for (group, row) in overview.groups.iter().zip(&table.rows).take(MOST_ROWS) { tr {
                    @for (column, cell) in row.iter().enumerate() {
                        @let is_bad = column == table.n_labels && group.n_passed < group.n_cases;
                        td.text[is_text(column)].bad[is_bad] { (cell) }
                    }
                } } }
            } }
        }
    };
    html! {
        h2 { "Every combination" }
        (table("combinations", &usual))
        @if usual.n_left_out > 0 {
            details {
                summary { "All figures of every combination" }
                (table("all_figures", &all))
            }
        }
    }
}

/// Shows several localizers side by side.
fn localizers(results: &Results) -> Markup {
    let lines = costs(results);
    let cells: Vec<(&Cost, &[String])> = lines.iter().map(|line| (line, &line.cells[..])).collect();
    let calibrated: Vec<(&Cost, &[String])> =
        lines.iter().filter_map(|line| Some((line, &line.calibration.as_ref()?[..]))).collect();
    let table = |id: &str, headings: &[&str], lines: &[(&Cost, &[String])]| {
        html! {
            div.table { table {
                thead { tr {
                    th.text { "scene" } th.text { "localizer" }
                    @for heading in headings { th { (heading) } }
                } }
                tbody id=(id) { @for (line, cells) in lines { tr {
                    td.text { (line.scene) } td.text { (line.subject) }
                    @for cell in *cells { td { (cell) } }
                } } }
            } }
        }
    };
    html! {
        @if !lines.is_empty() {
            h2 { "What a guarantee costs, and what overconfidence costs" }
            p.note { (NOTE) }
            (table("localizers", &HEADINGS, &cells))
        }
        @if !calibrated.is_empty() {
            h2 { "How well the stated distributions are calibrated" }
            p.note { (CALIBRATION_NOTE) }
            (table("calibration", &CALIBRATION, &calibrated))
        }
    }
}

/// Shows how much each localization method contributed, where several methods work together.
fn methods(overview: &Overview) -> Markup {
    let parts = result_table::methods(&overview.figures);
    let count = |part: &Figures, name: &str| part.get(name).copied().unwrap_or_default();
    html! {
        @if !parts.is_empty() {
            h2 { "Which method did it" }
            p.note { "A fix halves the width of the box so many times; a method's share is of all those halvings, in all cases." }
            div.table { table {
                thead { tr { th.text { "method" } th { "readings" } th { "fixes" } th { "of position, %" } th { "of heading, %" } } }
                tbody id="methods" { @for (name, part) in &parts { tr {
                    td.text { (name) }
                    td { (count(part, "method.readings")) }
                    td { (count(part, "method.constraints")) }
                    td { (format!("{:.1}", 1e2 * count(part, "method.position_share"))) }
                    td { (format!("{:.1}", 1e2 * count(part, "method.heading_share"))) }
                } } }
            } }
        }
    }
}

/// Shows every case in a table to unfold: its settings, seed, verdict and some figures, and, where any truth was outside, what is to blame.
fn cases(overview: &Overview, results: &Results) -> Markup {
    let verdict = |case: &CaseResult| match case.passed() {
        Some(true) => "passed",
        Some(false) => "FAILED",
        None => "not run",
    };
    let is_blamed = results.cases.iter().any(|case| case.first_failure()["blame"].is_string());
    let headings = overview.label_headings();
    let labels = |case: &CaseResult| overview.labels(&case.scene, &case.subject, |key| case.value(key));
    // Beside the figures are seed, verdict, and what is to blame.
    let (chosen, _) = overview.chosen(headings.len() + 2 + usize::from(is_blamed));
    html! {
        details {
            summary { @if overview.sketched.is_some() { "The " (results.cases.len()) " cases that are kept" } @else { "All " (results.cases.len()) " cases" } }
            div.table { table {
                thead { tr {
                    @for heading in &headings { th.text { (heading) } }
                    th { "seed" } th { "verdict" }
                    @for measure in &chosen { th { (measure.heading()) } }
                    @if is_blamed { th.text { "blame" } }
                } }
                tbody id="cases" { @for case in results.cases.iter().take(MOST_ROWS) {
                    @let figures = case.figures();
                    tr {
                        @for label in labels(case) { td.text { (label) } }
                        td { (case.seed) }
                        td.bad[case.passed() != Some(true)] { (verdict(case)) }
                        @for measure in &chosen { td { (measure.of(&figures)) } }
                        @if is_blamed { td.text { (case.first_failure()["blame"].as_str().unwrap_or_default()) } }
                    }
                } }
            } }
            @if results.cases.len() > MOST_ROWS { p.note { "The first " (MOST_ROWS) "; results.csv has all." } }
        }
    }
}

fn origin(overview: &Overview, results: &Results) -> Markup {
    let joined = |all: &BTreeSet<String>| all.iter().cloned().collect::<Vec<_>>().join("; ");
    let told = |value: &dyn Fn(&CaseResult) -> Option<String>| -> String {
        joined(&results.cases.iter().filter_map(value).collect())
    };
    let summary = |name: &'static str| move |case: &CaseResult| case.summary()?[name].as_str().map(str::to_owned);
    let timing = |name: &'static str| move |case: &CaseResult| case.timing()?[name].as_str().map(str::to_owned);
    let program = |case: &CaseResult| Some(case.timing()?["program"].as_str()?.chars().take(12).collect());
    let (version, adapter) = match &overview.sketched {
        None => (told(&summary("version")), told(&summary("adapter"))),
        Some(sketched) => (joined(&sketched.versions), joined(&sketched.adapters)),
    };
    html! {
        footer {
            dl {
                dt { "version" } dd { (version) ", program " (told(&program)) }
                dt { "adapter" } dd { @if adapter.is_empty() { "none, as no image was rendered" } @else { (adapter) } }
                dt { "machine" } dd { (told(&timing("machine"))) }
                @if let Some(plan) = &results.plan {
                    dt { "scene" } dd { (plan.path.display()) ", " (plan.scene_digest.chars().take(12).collect::<String>()) }
                    @for variable in &plan.vary {
                        dt { "varied" } dd { (variable.key) ": " (variable.shown_values()) }
                    }
                    dt { "seeds" } dd { (plan.seeds[0]) ".." (plan.seeds[1]) }
                }
            }
            p {
                "A check is one step of 10 ms, and in a log one estimate. Outside the box the cause is named, in a drive of the simulator: "
                strong { "bound broken" }
                ", a declared bound was really exceeded; " strong { "perception" } ", the vision claimed what is not there; "
                strong { "unsound" } ", neither. All figures of all cases are in "
                @if overview.sketched.is_some() { "the tables that the report was made of." } @else { "results.csv." }
            }
        }
    }
}
