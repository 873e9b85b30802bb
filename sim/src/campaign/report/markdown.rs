//! The report in short as Markdown, for the summary of a CI job.

use crate::campaign::cases::{CaseResult, Replay, Results};

use super::{
    Overview,
    chosen::Combinations,
    costs::{CALIBRATION, HEADINGS, costs},
    text::{broken_bounds, first_outside},
};

/// Greatest numbers of combinations, failed cases and missing cases in the Markdown report. The summary of a CI job may have a megabyte,
/// but nobody reads more rows than these.
const MOST_GROUPS: usize = 100;
const MOST_WORST: usize = 10;
const MOST_ABSENT: usize = 100;

/// Writes the verdict, a table of the combinations, and the failed cases with the command that runs each again.
pub fn as_markdown(overview: &Overview, results: &Results) -> String {
    let verdict = if overview.has_passed() { "✅ passed" } else { "❌ failed" };
    let mut text = format!("## {verdict}: {}\n\n{}.\n\n", inline(&results.title), overview.headline());
    text.extend(overview.honesty().iter().map(|told| format!("{}.\n\n", inline(told))));
    text += &table(overview);
    match &overview.sketched {
        None => text += &localizers(results),
        Some(sketched) => text += &sketched.to_markdown(),
    }
    let absent = results.missing().map(|case| (case, "missing"));
    let absent: Vec<_> = absent.chain(results.failed()).collect();
    if !absent.is_empty() {
        text += "\n### Not run\n\n";
        for (case, reason) in absent.iter().take(MOST_ABSENT) {
            text += &format!("- {}: {}\n", inline(&case.describe(overview.has_scenes)), inline(reason));
        }
        let n_absent = overview.n_missing + overview.n_failed;
        if n_absent > MOST_ABSENT {
            text += &format!("- and {} more\n", n_absent - absent.len().min(MOST_ABSENT));
        }
    }
    let cases = overview.worst.iter().map(|index| &results.cases[*index]);
    let missed: Vec<&CaseResult> = cases.filter(|case| case.passed() == Some(false)).collect();
    if !missed.is_empty() {
        text += "\n### Failed\n\n";
    }
    for case in missed.iter().take(MOST_WORST) {
        text += &failure(case, overview.has_scenes);
    }
    if overview.n_missed > MOST_WORST {
        text += &format!("and {} more\n", overview.n_missed - MOST_WORST);
    }
    text
}

fn table(overview: &Overview) -> String {
    let Combinations { headings, n_labels, rows, n_left_out } = overview.combinations();
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let rule = headings.iter().map(|_| "--:".to_owned()).collect();
    let mut text = line(headings) + &line(rule);
    for mut row in rows.into_iter().take(MOST_GROUPS) {
        row.iter_mut().take(n_labels).for_each(|label| *label = inline(label));
        text += &line(row);
    }
    if overview.groups.len() > MOST_GROUPS {
        text += &format!("\nand {} combinations more\n", overview.groups.len() - MOST_GROUPS);
    }
    if n_left_out > 0 {
        text += &format!("\n{n_left_out} more figures of each line are shown with `--columns all`.\n");
    }
    text
}

/// The table of several localizers side by side; empty where there is nothing to compare.
fn localizers(results: &Results) -> String {
    let lines = costs(results);
    if lines.is_empty() {
        return String::new();
    }
    let line = |texts: &[&str], cells: &[String]| {
        let all: Vec<String> = texts.iter().map(|text| inline(text)).chain(cells.iter().cloned()).collect();
        format!("| {} |\n", all.join(" | "))
    };
    let head = |title: &str, headings: &[&str]| {
        let headings: Vec<String> = headings.iter().map(|&heading| heading.to_owned()).collect();
        let rule = format!("| :-- | :-- |{}\n", " --: |".repeat(headings.len()));
        format!("\n### {title}\n\n{}{rule}", line(&["scene", "localizer"], &headings))
    };
    let mut text = head("What a guarantee costs, and what overconfidence costs", &HEADINGS);
    text.extend(lines.iter().map(|cost| line(&[&cost.scene, &cost.subject], &cost.cells)));
    let calibrated = lines.iter().filter_map(|cost| Some((cost, cost.calibration.as_ref()?)));
    let rows: Vec<String> = calibrated.map(|(cost, cells)| line(&[&cost.scene, &cost.subject], cells)).collect();
    if !rows.is_empty() {
        text += &head(
            "How often the truth is in the region that is said to hold it, in percent of the steps",
            &CALIBRATION,
        );
        text.extend(rows);
    }
    text
}

fn failure(case: &CaseResult, with_scene: bool) -> String {
    let mut text = format!("- **{}**\n", inline(&case.describe(with_scene)));
    for line in case.missed_expectations() {
        text += &format!("  - {}\n", inline(line));
    }
    let bounds = case.summary().map(broken_bounds).unwrap_or_default();
    for line in first_outside(case).into_iter().chain(bounds) {
        text += &format!("  - {}\n", inline(&line));
    }
    text + &format!("\n  ```sh\n  {}\n  ```\n", Replay::of(case, "renders"))
}

/// Escapes a text so that Markdown shows it unchanged.
fn inline(text: &str) -> String {
    text.chars().fold(String::new(), |mut escaped, character| {
        if "\\`*_[]<>|#".contains(character) {
            escaped.push('\\');
        }
        escaped.push(character);
        escaped
    })
}
