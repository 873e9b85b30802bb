//! A comparison of two sets of results as text for people.

use super::{Comparison, Finding, Line};

/// Greatest number of cases that are listed by name under each heading.
const MOST_NAMED: usize = 10;

/// Writes a comparison of two sets of results as text: a line for each compared quantity, then the cases in which the second set lost or regained the
/// truth.
pub fn as_text(comparison: &Comparison) -> String {
    let headings =
        ["figure", "first", "second", "difference", "interval", "least seen", "second is"].map(str::to_owned);
    let rows: Vec<[String; 7]> = [headings].into_iter().chain(comparison.lines.iter().map(row)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 7] = std::array::from_fn(width);
    let mut text = String::new();
    for row in &rows {
        let cell = |column: usize| {
            let (cell, width) = (&row[column], widths[column]);
            if [0, 6].contains(&column) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        };
        text += format!("  {}", (0..7).map(cell).collect::<Vec<_>>().join("  ")).trim_end();
        text.push('\n');
    }
    text += &named("lost containment, which the first side kept", &comparison.lost);
    text += &named("won containment, which the first side lost", &comparison.won);
    text += &named("unsound or misperceiving more often than in the first side", &comparison.graver);
    text += &named("missing an expectation that the first side met", &comparison.missed);
    text += &named("could not run or are missing in the second, which the first ran", &comparison.failed);
    let [first, second] = &comparison.unpaired;
    text += &named("only in the first side, so that nothing speaks for them", first);
    text += &named("only in the second", second);
    let half_known: Vec<String> = comparison.half_known.iter().map(|figure| format!("`{figure}`")).collect();
    text += &named("figures that one side has no number for", &half_known);
    if comparison.n_of_two_kinds > 0 {
        text += &format!(
            "{} pairs of two localizers of which only one states boxes: compared is what both have, and not boxes or distributions.\n",
            comparison.n_of_two_kinds
        );
    }
    let percent = comparison.demand.confidence * 100.0;
    text += &format!(
        "\n{} pairs of {} seeds; all intervals hold together with {percent} % confidence.\n",
        comparison.n_pairs, comparison.n_seeds
    );
    if comparison.is_inconclusive() {
        let tolerated = comparison.demand.tolerance * 100.0;
        text += &format!(
            "Too few seeds: where the finding is `inconclusive`, the second may be worse by more than {tolerated} % unseen.\n"
        );
    }
    if comparison.n_seeds < 2 {
        text += "One seed says nothing about others: run at least two, better ten.\n";
    }
    text
}

fn row(line: &Line) -> [String; 7] {
    let (scale, unit) = (line.compared.scale, line.compared.unit);
    let show = |value: f64| format!("{:.4}", value * scale);
    let finding = match line.finding {
        Finding::Better => "better",
        Finding::Worse => "WORSE",
        Finding::NotDistinguishable => "not distinguishable",
        Finding::Inconclusive => "inconclusive",
    };
    let [first, second] = line.means;
    [
        format!("{}, {unit}", line.compared.name),
        show(first),
        show(second),
        format!("{:+.4}", (second - first) * scale),
        format!("{:+.4} … {:+.4}", line.difference[0] * scale, line.difference[1] * scale),
        // Differences that do not scatter at all say nothing about how others would.
        if line.least_seen > 0.0 { format!("±{:.4}", line.least_seen * scale) } else { "unknown".to_owned() },
        finding.to_owned(),
    ]
}

fn named(what: &str, cases: &[String]) -> String {
    if cases.is_empty() {
        return String::new();
    }
    let mut text = format!("{} {what}:\n", cases.len());
    text.extend(cases.iter().take(MOST_NAMED).map(|case| format!("  {case}\n")));
    if cases.len() > MOST_NAMED {
        text += &format!("  and {} more\n", cases.len() - MOST_NAMED);
    }
    text
}
