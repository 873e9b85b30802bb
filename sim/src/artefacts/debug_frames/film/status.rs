//! What a film tells in words: whether the truth is inside, how wide the boxes are, and at the end the outcome.

use image::Rgb;
use localizer::Status;

use crate::{
    driver::Outcome,
    judge::{Judgement, Verdict},
    run::RunRecord,
    subject::half_turn,
};

use super::{
    super::{canvas::Canvas, palette},
    widths::{distance_m, middle_at, widths_at},
};

/// A line of text with its height and colour.
pub(super) struct Line {
    pub(super) text: String,
    pub(super) height_px: f32,
    pub(super) colour: Rgb<u8>,
}

const LARGE_PX: f32 = 21.0;
const SMALL_PX: f32 = 15.0;
/// Greatest number of lines about expectations that were not met.
const MOST_FAILED: usize = 2;

fn large(text: String, colour: Rgb<u8>) -> Line {
    Line { text, height_px: LARGE_PX, colour }
}

fn small(text: String) -> Line {
    Line { text, height_px: SMALL_PX, colour: palette::INK }
}

/// Whether what the localizer states at a step holds the truth; `None` for a point, which holds nothing.
pub(super) fn holds_truth(record: &RunRecord, step: usize) -> Option<bool> {
    let (estimate, truth) = (record.estimates.get(step)?, record.truths.get(step)?.pose);
    match record.stated.get(step)? {
        Some(stated) => stated.spread.as_ref().map(|spread| spread.holds_at_95(&stated.error(truth))),
        None => record.has_boxes.then(|| estimate.pose.contains(truth)),
    }
}

/// The lines about one step of a run.
pub(super) fn of_step(record: &RunRecord, verdict: &Verdict, step: Option<usize>) -> Vec<Line> {
    let Some((step, estimate)) = step.and_then(|step| Some((step, record.estimates.get(step)?))) else {
        return vec![large("no answer".to_owned(), palette::MISS)];
    };
    let Some(middle) = middle_at(record, step) else {
        return vec![large("no pose left".to_owned(), palette::MISS)];
    };
    let is_distribution = record.stated[step].is_some();
    let truth = record.truths[step].pose;
    let off_deg = half_turn(middle.heading_rad - truth.heading_rad).to_degrees().abs();
    let off = format!("middle {:.1} mm and {off_deg:.2}° from the truth", 1e3 * distance_m(middle, truth));
    let first = match (holds_truth(record, step), is_distribution) {
        (Some(true), true) => large("truth in the 95 % region".to_owned(), palette::TRUTH),
        (Some(false), true) => large("truth outside the 95 % region".to_owned(), palette::MISS),
        (Some(true), false) => {
            let doubt = if estimate.status == Status::Recovering { ", assumptions doubted" } else { "" };
            large(format!("truth inside{doubt}"), palette::TRUTH)
        }
        (Some(false), false) => {
            let cause = verdict.judgements.get(step).map_or("", |judgement| cause(*judgement));
            large(format!("TRUTH OUTSIDE{cause}"), palette::MISS)
        }
        (None, _) => return vec![large(off.replace("middle ", ""), palette::INK)],
    };
    let wide = widths_at(record, step).map(|[x_m, y_m, heading_rad]| {
        let n_boxes = estimate.pose.branches.len();
        let boxes = if n_boxes > 1 { format!("{n_boxes} boxes, ") } else { String::new() };
        let wide_deg = heading_rad.to_degrees();
        small(format!("{boxes}{:.1} mm × {:.1} mm × {wide_deg:.2}° wide", 1e3 * x_m, 1e3 * y_m))
    });
    [first].into_iter().chain(wide).chain([small(off)]).collect()
}

fn cause(judgement: Judgement) -> &'static str {
    match judgement {
        Judgement::Contained => "",
        Judgement::BoundBroken => ", bound broken",
        Judgement::Perception => ", perception",
        Judgement::Unsound => ", unsound",
    }
}

impl Line {
    /// Height of the line with the gap below it.
    pub(super) fn pitch_px(&self) -> f64 {
        (1.3 * f64::from(self.height_px)).round()
    }
}

/// The lines about the outcome of a run, the most important first: none wider than this, and as many as this height has room for.
pub(super) fn of_outcome(record: &RunRecord, verdict: &Verdict, [width_px, height_px]: [f64; 2]) -> Vec<Line> {
    let mut lines = Vec::new();
    if verdict.verdict.passed {
        lines.push(large("passed".to_owned(), palette::TRUTH));
    } else {
        lines.push(large("FAILED".to_owned(), palette::MISS));
        let failed = verdict.verdict.failed.iter();
        lines.extend(failed.take(MOST_FAILED).map(|text| Line { colour: palette::MISS, ..small(text.clone()) }));
        let more = verdict.verdict.failed.len().saturating_sub(MOST_FAILED);
        lines.extend((more > 0).then(|| small(format!("and {more} expectations more"))));
    }
    if let Some(containment) = &verdict.containment {
        lines.push(small(format!("truth inside in {} of {} checks", containment.contained, containment.checks)));
    }
    if let Some(distribution) = &verdict.distribution {
        let share = 1e2 * distribution.calibration.within_95;
        lines.push(small(format!("truth in the 95 % region at {share:.1} % of the steps")));
    }
    if let Some(width) = &verdict.width {
        let wide_mm = 1e3 * width.x_m.mean.max(width.y_m.mean);
        lines.push(small(format!("on average {wide_mm:.1} mm and {:.2}° wide", width.heading_rad.mean.to_degrees())));
    }
    if let Some(log) = &record.errands {
        let reached = log.errands.iter().filter(|errand| errand.outcome == Outcome::Reached).count();
        lines.push(small(format!("{reached} of {} goals reached", log.errands.len())));
    }
    lines.iter_mut().for_each(|line| line.text = cut(&line.text, line.height_px, width_px));
    while lines.iter().map(Line::pitch_px).sum::<f64>() > height_px && lines.pop().is_some() {}
    lines
}

/// The beginning of a text that fits into a width, with three dots where something is missing.
pub(super) fn cut(text: &str, height_px: f32, width_px: f64) -> String {
    if Canvas::text_width_px(height_px, text) <= width_px {
        return text.to_owned();
    }
    let mut shorter = text.to_owned();
    while shorter.pop().is_some() && Canvas::text_width_px(height_px, &format!("{shorter}...")) > width_px {}
    format!("{}...", shorter.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_is_too_long_is_cut_to_the_width() {
        let long = "containment.unsound is 12, expected at most 0";
        let width_px = 0.5 * Canvas::text_width_px(SMALL_PX, long);
        let short = cut(long, SMALL_PX, width_px);
        assert!(short.starts_with("containment.") && short.ends_with("..."), "{short}");
        assert!(Canvas::text_width_px(SMALL_PX, &short) <= width_px);
        assert_eq!(cut(long, SMALL_PX, 10.0 * width_px), long);
    }
}
