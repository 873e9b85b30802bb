//! What went wrong in a run, as its report tells it: the scene's events, and every declared bound that was broken.

use maud::{Markup, html};
use serde_json::Value;

use crate::artefacts::wording::of_bound;

/// Greatest number of spans of time that are listed for one bound; more are counted.
const MOST_SPANS: usize = 6;

/// One of the scene's events: the time at which it began and ended, and what happened where, in words.
pub(super) struct Event {
    pub(super) span_s: [f64; 2],
    pub(super) text: String,
}

/// A declared bound that was broken, as often as it was in one run.
pub(super) struct Broken {
    name: String,
    /// Spans of time in which the bound was exceeded, each with the declared and the true value.
    spans: Vec<([f64; 2], [f64; 2])>,
}

/// The scene's events in a run, in the order of time.
pub(super) fn events(summary: &Value) -> Vec<Event> {
    let told = |event: &Value| {
        let number = |name: &str| event[name].as_f64();
        let (span_s, what) = ([number("from_s")?, number("to_s")?], event["what"].as_str()?);
        let (x_m, y_m) = (number("x_m")?, number("y_m")?);
        Some(Event { span_s, text: format!("{}: {what}, robot at ({x_m:.2} m, {y_m:.2} m)", span(span_s)) })
    };
    summary["events"].as_array().into_iter().flatten().filter_map(told).collect()
}

/// The declared bounds that were broken in a run, in the order in which they were first.
pub(super) fn broken(summary: &Value) -> Vec<Broken> {
    let mut found: Vec<Broken> = Vec::new();
    for violation in summary["violations"].as_array().into_iter().flatten() {
        let number = |name: &str| violation[name].as_f64().unwrap_or(f64::NAN);
        let Some(name) = violation["bound"].as_str() else { continue };
        let one = ([number("from_s"), number("to_s")], [number("declared"), number("true")]);
        match found.iter_mut().find(|broken| broken.name == name) {
            Some(broken) => broken.spans.push(one),
            None => found.push(Broken { name: name.to_owned(), spans: vec![one] }),
        }
    }
    found.sort_by(|one, other| one.begins_s().total_cmp(&other.begins_s()));
    found
}

impl Broken {
    fn begins_s(&self) -> f64 {
        self.spans.iter().map(|([from_s, _], _)| *from_s).fold(f64::INFINITY, f64::min)
    }

    /// The declared bound, and the true value at the time when it exceeded the bound most, both with their unit.
    fn greatest(&self) -> [String; 2] {
        let excess = |values: &[f64; 2]| values[1] - values[0];
        let worst =
            self.spans.iter().map(|(_, values)| *values).max_by(|one, other| excess(one).total_cmp(&excess(other)));
        worst.unwrap_or([f64::NAN; 2]).map(|value| of_bound(&self.name, value))
    }

    /// The spans of time in which the bound was broken.
    fn when(&self) -> String {
        let mut told: Vec<String> = self.spans.iter().take(MOST_SPANS).map(|(span_s, _)| span(*span_s)).collect();
        told.extend(self.spans.len().checked_sub(MOST_SPANS).filter(|n| *n > 0).map(|n| format!("and {n} times more")));
        told.join(", ")
    }

    /// One sentence about the bound.
    pub(super) fn text(&self) -> String {
        let [declared, most] = self.greatest();
        format!("{} broken at {}: {most} where {declared} is declared", self.name, self.when())
    }
}

/// Lists the events and the broken bounds of a run.
pub(super) fn incidents(summary: &Value) -> Markup {
    let (events, broken) = (events(summary), broken(summary));
    html! {
        @if !events.is_empty() {
            p { strong { "Events of the scene" } }
            ul.events { @for event in &events { li { (event.text) } } }
        }
        @if !broken.is_empty() {
            p { strong { "Broken bounds" } }
            div.table { table {
                thead { tr { th.text { "bound" } th { "declared" } th { "greatest" } th.text { "when" } } }
                tbody.broken { @for bound in &broken {
                    @let [declared, most] = bound.greatest();
                    tr { td.text { (bound.name) } td { (declared) } td { (most) } td.text.when { (bound.when()) } }
                } }
            } }
        }
    }
}

fn span([from_s, to_s]: [f64; 2]) -> String {
    if to_s > from_s { format!("{from_s:.2} s to {to_s:.2} s") } else { format!("{from_s:.2} s") }
}
