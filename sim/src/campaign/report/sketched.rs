//! What a report says of more cases than it keeps: how its figures spread over the cases, and what is left out.

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::Measure;

/// Names of the columns of the table that shows how a figure spreads over the cases.
const HEADINGS: [&str; 7] = ["least", "1 %", "5 %", "median", "95 %", "99 %", "greatest"];

/// What a report knows of cases whose results were added up one by one and not kept.
#[derive(Clone, Debug)]
pub struct Sketched {
    /// Greatest number of cases of which a report keeps all.
    pub most_whole: usize,
    /// Number of the worst cases that the report keeps.
    pub n_kept: usize,
    /// Greatest relative error of a quantile.
    pub accuracy: f64,
    /// For each shown result that any case has, its quantiles over the cases at [`Sketched::SHARES`].
    pub spreads: Vec<(&'static Measure, [f64; Sketched::SHARES.len()])>,
    /// Number of cases of combinations that are not listed, because there are too many combinations.
    pub n_unlisted: usize,
    /// Versions of the program that ran the cases.
    pub versions: BTreeSet<String>,
    /// Graphics adapters that rendered the cases' images.
    pub adapters: BTreeSet<String>,
}

impl Sketched {
    /// Shares of the cases that do not exceed the quantiles.
    pub const SHARES: [f64; 7] = [0.0, 0.01, 0.05, 0.5, 0.95, 0.99, 1.0];

    /// Says how the report was made.
    pub(super) fn note(&self) -> String {
        let Sketched { most_whole, n_kept, n_unlisted, .. } = self;
        let mut note = format!(
            "A report on more than {most_whole} cases, or on tables alone, is made of sketches: counts, means and extremes are those of all cases, quantiles are \
             within {} %, and of the cases themselves only the {n_kept} worst are kept.",
            1e2 * self.accuracy
        );
        if *n_unlisted > 0 {
            note += &format!(
                " There are too many combinations to list all: {n_unlisted} cases are of other ones, and are in the figures of all cases only."
            );
        }
        note
    }

    /// Shows how the figures spread over the cases.
    pub(super) fn to_html(&self) -> Markup {
        html! {
            h2 { "How the cases spread" }
            p.note { (self.note()) }
            div.table { table {
                thead { tr { th.text { "per case" } @for heading in HEADINGS { th { (heading) } } } }
                tbody id="spread" { @for (measure, quantiles) in &self.spreads { tr {
                    td.text { (measure.name) ", " (measure.unit) }
                    @for value in quantiles { td { (measure.show(Some(*value))) } }
                } } }
            } }
        }
    }

    /// The same as Markdown.
    pub(super) fn to_markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let headings = ["per case"].into_iter().chain(HEADINGS).map(str::to_owned).collect();
        let mut text = format!("\n### How the cases spread\n\n{}\n\n", self.note());
        text += &(line(headings) + "| :-- |" + &" --: |".repeat(HEADINGS.len()) + "\n");
        for (measure, quantiles) in &self.spreads {
            let name = format!("{}, {}", measure.name, measure.unit);
            let values = quantiles.iter().map(|value| measure.show(Some(*value)));
            text += &line([name].into_iter().chain(values).collect());
        }
        text
    }
}
