//! What the terminal shows of the replay of a log.

use std::fmt::Write;

use serde_json::Value;

use crate::artefacts::wording::outside_by;

/// Greatest number of lines for one kind of finding; the summary has them all.
const MOST_LINES: usize = 8;

/// What the terminal shows of the replay of a log with this summary, but for the verdict. Writing to a `String` cannot fail.
pub fn text(summary: &Value) -> String {
    let mut text = String::new();
    let number = |pointer: &str| summary.pointer(pointer).and_then(Value::as_f64);
    let count = |pointer: &str| number(pointer).unwrap_or(0.0);
    let name = summary["scene"].as_str().unwrap_or_default();
    let (estimates, duration_s) = (count("/metrics/estimates"), count("/duration_s"));
    let _ = writeln!(text, "{name}: {estimates} estimates over {duration_s:.1} s by {}", word(&summary["subject"]));
    topics(&mut text, &summary["log"]["topics"]);
    damage(&mut text, &summary["log"]);
    for device in summary["log"]["without_readings"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        let _ = writeln!(text, "`robot.{device}` is described, and the log has no reading of it that can be used");
    }
    if let (Some(x_m), Some(y_m), Some(rad)) =
        (number("/width/x_m/mean"), number("/width/y_m/mean"), number("/width/heading_rad/mean"))
    {
        let most_m = count("/width/x_m/max").max(count("/width/y_m/max"));
        let _ = writeln!(
            text,
            "boxes: {:.1} mm × {:.1} mm × {:.2}° wide on average, at most {:.1} mm",
            1e3 * x_m,
            1e3 * y_m,
            rad.to_degrees(),
            1e3 * most_m
        );
    }
    match summary["containment"].as_object() {
        Some(_) => {
            let (checks, contained) = (count("/containment/checks"), count("/containment/contained"));
            let _ = writeln!(text, "truth: inside the boxes in {contained} of {checks} checks");
            if let (Some(at_s), Some(margin)) =
                (number("/containment/first_outside/time_s"), number("/containment/first_outside/margin"))
            {
                let axis = word(&summary["containment"]["first_outside"]["axis"]);
                let _ = writeln!(text, "  first outside at {at_s:.3} s: {}", outside_by(&axis, margin));
            }
        }
        None if summary["error"].is_null() => {
            text.push_str("truth: none is given, so that nothing tells whether the boxes hold it\n")
        }
        None => {}
    }
    if let Some(error_m) = number("/error/position_m/mean") {
        let _ = writeln!(text, "error of the middle: {:.1} mm on average", 1e3 * error_m);
    }
    if let Some(nees) = number("/distribution/nees/mean") {
        let (within, checks) = (count("/distribution/within_3_sigma_share"), count("/distribution/checks"));
        let _ = writeln!(
            text,
            "distributions: the truth within 3σ along every axis in {:.1} % of {checks} checks, mean NEES {nees:.2} where 3 is right",
            1e2 * within
        );
    }
    bounds(&mut text, &summary["bounds"]);
    text
}

/// The last lines of the text: the verdict.
pub(super) fn verdict(text: &mut String, failed: &[String]) {
    if failed.is_empty() {
        text.push_str("nothing speaks against what is declared\n");
        return;
    }
    text.push_str("against what is declared:\n");
    for line in failed.iter().take(MOST_LINES) {
        let _ = writeln!(text, "  {line}");
    }
    if failed.len() > MOST_LINES {
        let _ = writeln!(text, "  and {} more, in summary.json", failed.len() - MOST_LINES);
    }
}

fn topics(text: &mut String, topics: &Value) {
    for (name, topic) in topics.as_object().into_iter().flatten() {
        let messages = topic["messages"].as_f64().unwrap_or(0.0);
        let Some(read_as) = topic["read_as"].as_str() else {
            let _ = writeln!(text, "{name}: {messages} messages of {}, which nothing reads", word(&topic["type"]));
            continue;
        };
        let rate = topic["period_s"].as_f64().filter(|period_s| *period_s > 0.0).map(|period_s| 1.0 / period_s);
        let rate = rate.map_or_else(String::new, |rate| format!(", {rate:.1} a second"));
        let _ = writeln!(text, "{name}: {messages} messages read as {read_as}{rate}");
        for (reason, dropped) in topic["dropped_by_reason"].as_object().into_iter().flatten() {
            let (count, at_s) = (dropped["count"].as_f64().unwrap_or(0.0), dropped["first_s"].as_f64().unwrap_or(0.0));
            let first = word(&dropped["first"]);
            let first = if first.is_empty() { String::new() } else { format!(": {first}") };
            let _ = writeln!(text, "  {count} dropped, the first at {at_s:.3} s, because {reason}{first}");
        }
        let gaps = topic["gaps_s"].as_array().map_or(&[][..], Vec::as_slice);
        for gap in gaps.iter().take(MOST_LINES) {
            let [from_s, to_s] = [0, 1].map(|end| gap[end].as_f64().unwrap_or(0.0));
            let _ = writeln!(text, "  no message from {from_s:.3} s to {to_s:.3} s");
        }
        if gaps.len() > MOST_LINES {
            let _ = writeln!(text, "  and {} more gaps", gaps.len() - MOST_LINES);
        }
        if let Some(count) = topic["out_of_order"].as_f64().filter(|count| *count > 0.0) {
            let _ = writeln!(text, "  {count} came later than one with a later stamp, and were put into order");
        }
    }
}

fn damage(text: &mut String, log: &Value) {
    for one in log["damage"].as_array().into_iter().flatten() {
        let after = match (one["after_topic"].as_str(), one["after_s"].as_f64()) {
            (Some(topic), Some(at_s)) => format!(", after a message of {topic} at {at_s:.3} s"),
            _ => String::new(),
        };
        let _ = writeln!(text, "damage: {}{after}", word(&one["what"]));
    }
    for jump in log["jumps_of_wheels_s"].as_array().into_iter().flatten().take(MOST_LINES) {
        let [from_s, to_s] = [0, 1].map(|end| jump[end].as_f64().unwrap_or(0.0));
        let _ = writeln!(text, "wheels: a jump from {from_s:.3} s to {to_s:.3} s, in which they are not relied on");
    }
    for lens in log["lenses"].as_array().into_iter().flatten() {
        if let Some(why) = lens["unread"].as_str() {
            let _ = writeln!(text, "{} lens: {why}", word(&lens["camera"]));
        }
    }
    if let Some(aside_m) = log["sideways_odometry_m"].as_f64().filter(|aside_m| *aside_m > LEAST_ASIDE_M) {
        let _ =
            writeln!(text, "odometry: it counts {aside_m:.3} m sideways in all, which a differential drive cannot go");
    }
}

/// Sideways way of odometry from which on it is told: less is rounding and the arcs between poses.
const LEAST_ASIDE_M: f64 = 0.01;

fn bounds(text: &mut String, bounds: &Value) {
    for one in bounds.as_array().into_iter().flatten() {
        let number = |key: &str| one[key].as_f64().unwrap_or(0.0);
        let (name, unit) = (word(&one["bound"]), word(&one["unit"]));
        let verdict = if number("exceeded") > 0.0 { "too tight" } else { "kept" };
        let _ = writeln!(
            text,
            "{name}: {verdict}, at least {:.4} {unit} where {:.4} {unit} is declared, from {:.3} s to {:.3} s",
            number("at_least"),
            number("declared"),
            number("from_s"),
            number("to_s")
        );
    }
}

fn word(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}
