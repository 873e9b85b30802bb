//! Diagram of the pose error over time. The error of the estimate's midpoint is a line, the width of the estimate's hull a band around zero: the
//! line leaves the band when the truth leaves the hull. For distributions the line is the error of the mean, and the band three standard deviations
//! wide to either side. Stripes show when the scene's events happened.

use std::fmt::Write;

use maud::html;

use crate::judge::Judgement;

use super::{incidents::Event, steps::Step};

pub(super) const WIDTH: f64 = 360.0;
pub(super) const LEFT: f64 = 44.0;
pub(super) const PANEL: f64 = 66.0;
pub(super) const GAP: f64 = 10.0;
pub(super) const BOTTOM: f64 = 18.0;
/// Greatest number of points of a curve: one for every pixel and a half of a phone's screen.
const POINTS: usize = 220;

/// Draws three plots of the error over time, one above the other: x and y in mm and heading in degrees, with the events of the run behind them. The
/// result is empty if the run has no step.
pub(super) fn to_svg(steps: &[Step], events: &[Event]) -> String {
    let (Some(first), Some(last)) = (steps.first(), steps.last()) else { return String::new() };
    let span_s = [first.time_s, last.time_s.max(first.time_s + 1e-3)];
    let height = 3.0 * PANEL + 2.0 * GAP + BOTTOM + 4.0;
    let mut svg = format!(r#"<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="error over time">"#);
    let x = |time_s: f64| LEFT + (WIDTH - LEFT) * ((time_s - span_s[0]) / (span_s[1] - span_s[0])).clamp(0.0, 1.0);
    for Event { span_s: [from_s, to_s], text } in events {
        // An event that is over at once is as wide as a stroke that can be seen.
        let (left, width, tall) = (x(*from_s), (x(*to_s) - x(*from_s)).max(1.2), height - BOTTOM - 4.0);
        let text = html! { (text) }.into_string();
        let _ = write!(
            svg,
            r#"<rect class="event" x="{left:.1}" y="4" width="{width:.1}" height="{tall}"><title>{text}</title></rect>"#
        );
    }
    let axes = [("x, mm", 1e3), ("y, mm", 1e3), ("heading, °", 180.0 / std::f64::consts::PI)];
    for (axis, (name, scale)) in axes.into_iter().enumerate() {
        let top = 4.0 + axis as f64 * (PANEL + GAP);
        svg += &panel(&thinned(steps, axis), axis, scale, name, top, span_s);
    }
    let below = height - 5.0;
    // Writing to a `String` cannot fail, here and in the other places of this file.
    for (x, anchor, text) in
        [(LEFT, "start", format!("{:.0} s", span_s[0])), (WIDTH, "end", format!("{:.1} s", span_s[1]))]
    {
        let _ = write!(svg, r#"<text class="faint" x="{x}" y="{below:.1}" text-anchor="{anchor}">{text}</text>"#);
    }
    svg + "</svg>"
}

/// Reduces the number of steps for drawing. Of the steps that share a point of the curve, the one is kept at which the truth is outside its box or
/// closest to leaving it, so that no failure disappears.
fn thinned(steps: &[Step], axis: usize) -> Vec<Step> {
    let stretch = steps.len().div_ceil(POINTS).max(1);
    let closest = |steps: &[Step]| {
        let rank = |step: &Step| (step.judgement.is_none(), step.judgement, step.ratio(axis));
        steps
            .iter()
            .copied()
            .max_by(|one, other| rank(one).partial_cmp(&rank(other)).unwrap_or(std::cmp::Ordering::Equal))
    };
    steps.chunks(stretch).filter_map(closest).collect()
}

fn panel(steps: &[Step], axis: usize, scale: f64, name: &str, top: f64, span_s: [f64; 2]) -> String {
    let reach = |step: &Step| step.error[axis].abs().max(0.5 * step.width[axis]) * scale;
    let most = round_up(steps.iter().map(reach).fold(1e-6, f64::max));
    let x = |time_s: f64| LEFT + (WIDTH - LEFT) * (time_s - span_s[0]) / (span_s[1] - span_s[0]);
    let y = |value: f64| top + PANEL / 2.0 - PANEL / 2.0 * value * scale / most;
    let line = |value: &dyn Fn(&Step) -> f64, steps: &mut dyn Iterator<Item = &Step>| {
        let points: Vec<String> = steps.map(|step| format!("{:.1} {:.1}", x(step.time_s), y(value(step)))).collect();
        points.join("L")
    };
    let upper = line(&|step| 0.5 * step.width[axis], &mut steps.iter());
    let lower = line(&|step| -0.5 * step.width[axis], &mut steps.iter().rev());
    let error = line(&|step| step.error[axis], &mut steps.iter());
    let (middle, bottom) = (top + PANEL / 2.0, top + PANEL);
    let mut svg = format!(r#"<path class="axis" d="M{LEFT} {top:.1}V{bottom:.1}M{LEFT} {middle:.1}H{WIDTH}"/>"#);
    let _ = write!(svg, r#"<path class="band" d="M{upper}L{lower}Z"/><path class="error" d="M{error}"/>"#);
    let width = (WIDTH - LEFT) / steps.len().max(1) as f64 + 0.8;
    for step in steps.iter().filter(|step| step.judgement != Some(Judgement::Contained)) {
        let (class, x) = (step.judgement.map_or("outside", Judgement::name), x(step.time_s));
        let _ =
            write!(svg, r#"<rect class="{class}" x="{x:.1}" y="{:.1}" width="{width:.1}" height="4"/>"#, bottom - 4.0);
    }
    let labels = [(top + 9.0, format!("{most}")), (bottom, format!("−{most}"))];
    for (y, label) in labels {
        let _ = write!(svg, r#"<text class="faint" x="{:.1}" y="{y:.1}" text-anchor="end">{label}</text>"#, LEFT - 4.0);
    }
    let _ = write!(svg, r#"<text class="faint" x="{:.1}" y="{:.1}">{name}</text>"#, LEFT + 4.0, top + 9.0);
    svg
}

/// Rounds a positive value up to the next of 1, 2, 5, 10, 20, 50, …
fn round_up(value: f64) -> f64 {
    let decade = 10_f64.powf(value.log10().floor());
    let nice = [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * decade).find(|nice| *nice >= value * 0.999_999);
    let nice = nice.unwrap_or(value);
    // Rounding through decimal text turns 0.30000000000000004 into 0.3.
    format!("{nice:.3e}").parse().unwrap_or(nice)
}
