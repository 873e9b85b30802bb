//! Consistency corridors, as paper 4 draws them (figures 12 and 13): the interval error, box minus truth, over time. The outer band is the box as it was
//! known in real time, the inner one that by post-localization. A band holds the line at zero where the box holds the truth.

use std::{fmt::Write, fs, path::Path};

use crate::artefacts::run_files::POST_LOCALIZATION;

use super::corridor::{BOTTOM, GAP, LEFT, PANEL, WIDTH};

/// A key frame that was looked back at: for post-localization and in real time, the bounds of the interval error along x in m, y in m and heading in
/// rad.
pub(super) struct KeyFrame {
    time_s: f64,
    bounds: [[[f64; 2]; 3]; 2],
}

/// Reads the key frames of the run in `folder`; none when the run has no `post_localization.csv` that can be read.
pub(super) fn read(folder: &Path) -> Vec<KeyFrame> {
    let Ok(text) = fs::read_to_string(folder.join(POST_LOCALIZATION)) else { return Vec::new() };
    text.lines().skip(1).filter_map(key_frame).collect()
}

fn key_frame(line: &str) -> Option<KeyFrame> {
    let mut numbers = line.split(',').map(|field| field.parse::<f64>().ok().filter(|number| number.is_finite()));
    let time_s = numbers.next()??;
    let mut bounds = [[[0.0; 2]; 3]; 2];
    for bound in bounds.iter_mut().flatten().flatten() {
        *bound = numbers.next()??;
    }
    Some(KeyFrame { time_s, bounds })
}

/// Draws the corridors of x and y in mm and of the heading in degrees, one above the other. The result is empty without key frames.
pub(super) fn to_svg(frames: &[KeyFrame]) -> String {
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return String::new() };
    let span_s = [first.time_s, last.time_s.max(first.time_s + 1e-3)];
    let height = 3.0 * PANEL + 2.0 * GAP + BOTTOM + 4.0;
    let mut svg = format!(r#"<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="consistency corridors">"#);
    let axes = [("x, mm", 1e3), ("y, mm", 1e3), ("heading, °", 180.0 / std::f64::consts::PI)];
    for (axis, (name, scale)) in axes.into_iter().enumerate() {
        svg += &panel(frames, axis, scale, name, 4.0 + axis as f64 * (PANEL + GAP), span_s);
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

fn panel(frames: &[KeyFrame], axis: usize, scale: f64, name: &str, top: f64, span_s: [f64; 2]) -> String {
    let reach =
        |frame: &KeyFrame| frame.bounds.iter().flat_map(|kind| kind[axis]).fold(0.0, |a: f64, b| a.max(b.abs()));
    let most = (frames.iter().map(reach).fold(1e-9, f64::max) * scale * 1.05 - 1e-6).ceil();
    let (middle, bottom) = (top + PANEL / 2.0, top + PANEL);
    let x = |time_s: f64| LEFT + (WIDTH - LEFT) * (time_s - span_s[0]) / (span_s[1] - span_s[0]);
    let y = |value: f64| middle - PANEL / 2.0 * value * scale / most;
    let band = |kind: usize| {
        let upper = frames.iter().map(|frame| (frame.time_s, frame.bounds[kind][axis][1]));
        let lower = frames.iter().rev().map(|frame| (frame.time_s, frame.bounds[kind][axis][0]));
        let points: Vec<String> =
            upper.chain(lower).map(|(time_s, bound)| format!("{:.1} {:.1}", x(time_s), y(bound))).collect();
        format!(r#"<path class="band" d="M{}Z"/>"#, points.join("L"))
    };
    let mut svg = band(1) + &band(0);
    let _ = write!(svg, r#"<path class="axis" d="M{LEFT} {top:.1}V{bottom:.1}"/>"#);
    let _ = write!(svg, r#"<path class="error" d="M{LEFT} {middle:.1}H{WIDTH}"/>"#);
    for (y, label) in [(top + 9.0, format!("{most}")), (bottom, format!("−{most}"))] {
        let _ = write!(svg, r#"<text class="faint" x="{:.1}" y="{y:.1}" text-anchor="end">{label}</text>"#, LEFT - 4.0);
    }
    let _ = write!(svg, r#"<text class="faint" x="{:.1}" y="{:.1}">{name}</text>"#, LEFT + 4.0, top + 9.0);
    svg
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_corridor_by_post_localization_is_inside_that_in_real_time() {
        let line = "1.5,-0.1,0.2,-0.1,0.1,-0.02,0.02,-0.3,0.4,-0.2,0.2,-0.05,0.05";
        let frame = key_frame(line).unwrap();
        assert_eq!((frame.time_s, frame.bounds[0][0], frame.bounds[1][0]), (1.5, [-0.1, 0.2], [-0.3, 0.4]));
        // The greatest bound is 420 mm with some room, so that 400 mm is at 33 · 400/420 above the middle at 37, and 200 mm half as far.
        let svg = to_svg(&[frame, key_frame(&line.replace("1.5,", "2.5,")).unwrap()]);
        assert!(svg.contains("M44.0 5.6L360.0 5.6L360.0 60.6L44.0 60.6Z"), "{svg}");
        assert!(svg.contains("M44.0 21.3L360.0 21.3L360.0 44.9L44.0 44.9Z"), "{svg}");
    }

    #[test]
    fn a_damaged_line_is_left_out() {
        assert!(key_frame("1.5,-0.1,0.2").is_none() && key_frame("").is_none() && key_frame("1,a").is_none());
        assert_eq!(to_svg(&[]), "");
    }
}
