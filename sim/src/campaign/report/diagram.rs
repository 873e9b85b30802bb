//! Diagram of the estimate's error against its width: every step of every case is counted at half the width of its box and at the error of the box's
//! midpoint.
//!
//! Below the diagonal the error is less than half the width, so that the truth is inside the box. Bins are squares on logarithmic scales, darker
//! where they hold more steps. Steps with the truth outside the box are drawn last and fully opaque, so that a single one is visible among millions.

use std::{collections::BTreeMap, fmt::Write};

use crate::judge::Judgement;

use super::steps::Step;

const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 290.0;
const LEFT: f64 = 50.0;
const BOTTOM: f64 = 34.0;
const TOP: f64 = 8.0;
/// Half the width of the axis label `1000`, in units of the drawing.
const LABEL_HALF: f64 = 13.0;
/// Number of bins in a decade of the logarithmic scales.
const BINS: f64 = 20.0;

/// A diagram of either the position or the heading: the number of steps in each bin, counted separately by whether the truth is in the box and, if
/// not, by the cause.
#[derive(Clone, Debug)]
pub(super) struct Diagram {
    unit: &'static str,
    /// Factor from metres or radians to `unit`.
    scale: f64,
    axes: &'static [usize],
    bins: BTreeMap<(Judgement, i32, i32), usize>,
}

impl Diagram {
    /// Creates an empty diagram of the position. Each step is counted once, along x or y, whichever error is the greater share of half the box's
    /// width.
    pub(super) fn position() -> Diagram {
        Diagram { unit: "mm", scale: 1e3, axes: &[0, 1], bins: BTreeMap::new() }
    }

    /// Creates an empty diagram of the heading.
    pub(super) fn heading() -> Diagram {
        Diagram { unit: "°", scale: 180.0 / std::f64::consts::PI, axes: &[2], bins: BTreeMap::new() }
    }

    /// Adds the steps of one run to the diagram's counts.
    pub(super) fn add(&mut self, steps: &[Step]) {
        for step in steps {
            let Some(&axis) = self.axes.iter().max_by(|one, other| step.ratio(**one).total_cmp(&step.ratio(**other)))
            else {
                continue;
            };
            let half_width = (0.5 * step.width[axis] * self.scale).max(1e-9);
            // Errors below a hundredth of half the box's width are raised to that value, as their exact size on a logarithmic scale means nothing.
            let error = (step.error[axis].abs() * self.scale).max(half_width * 1e-2);
            let bin = |value: f64| (value.log10() * BINS).floor() as i32;
            let Some(judgement) = step.judgement else { continue };
            *self.bins.entry((judgement, bin(half_width), bin(error))).or_default() += 1;
        }
    }

    /// Returns the diagram as SVG; the text is empty if no step was counted.
    pub(super) fn to_svg(&self) -> String {
        let Some(range) = self.range() else { return String::new() };
        let mut svg =
            format!(r#"<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="error against half width">"#);
        svg += &self.scales(&range);
        for judgement in Judgement::ALL {
            svg += &self.squares(judgement, &range);
        }
        let corner = |bin: f64| [range.x(bin), range.y(bin)];
        let (low, high) = (range.across[0].max(range.up[0]), range.across[1].min(range.up[1]));
        if high > low {
            let ([x0, y0], [x1, y1]) = (corner(low), corner(high));
            // Writing to a `String` cannot fail, here and in the other places of this file.
            let _ = write!(svg, r#"<path class="limit" d="M{x0:.1} {y0:.1}L{x1:.1} {y1:.1}"/>"#);
        }
        svg + "</svg>"
    }

    /// Returns the range of each of the diagram's two scales that holds all filled bins, in numbers of bins, rounded outwards to multiples of four
    /// bins.
    fn range(&self) -> Option<Range> {
        let ends = |bins: &dyn Fn(&(Judgement, i32, i32)) -> i32| {
            let (least, most) = (self.bins.keys().map(bins).min()?, self.bins.keys().map(bins).max()?);
            Some([(f64::from(least) / 4.0).floor() * 4.0, (f64::from(most + 1) / 4.0).ceil() * 4.0])
        };
        Some(Range { across: ends(&|key| key.1)?, up: ends(&|key| key.2)? })
    }

    /// Draws the bins of all steps with one judgement (truth in the box, or a cause for which it is not) as squares, grouped by opacity so that each
    /// group is one SVG path.
    fn squares(&self, judgement: Judgement, range: &Range) -> String {
        const LEVELS: f64 = 4.0;
        let own = || self.bins.iter().filter(|((kind, _, _), _)| *kind == judgement);
        let most = own().map(|(_, count)| *count).max().unwrap_or(1) as f64;
        let mut paths: BTreeMap<u8, String> = BTreeMap::new();
        let [width, height] = [range.x(1.0) - range.x(0.0), range.y(0.0) - range.y(1.0)];
        for ((_, across, up), count) in own() {
            let strength = (*count as f64).ln_1p() / most.ln_1p();
            let level = if judgement == Judgement::Contained { (strength * LEVELS).ceil() as u8 } else { LEVELS as u8 };
            let (x, y) = (range.x(f64::from(*across)), range.y(f64::from(*up) + 1.0));
            let path = paths.entry(level).or_default();
            let _ = write!(path, "M{x:.1} {y:.1}h{width:.1}v{height:.1}h-{width:.1}z");
        }
        let class = judgement.name();
        let draw = |(level, path): (u8, String)| {
            let opacity = 0.1 + 0.9 * f64::from(level) / LEVELS;
            format!(r#"<path class="{class}" fill-opacity="{opacity:.2}" d="{path}"/>"#)
        };
        paths.into_iter().map(draw).collect()
    }

    fn scales(&self, range: &Range) -> String {
        let mut svg = String::new();
        let (right, floor) = (range.x(range.across[1]), range.y(range.up[0]));
        for (bin, label) in ticks(range.across) {
            let x = range.x(bin);
            let _ = write!(svg, r#"<path class="axis" d="M{x:.1} {TOP}V{floor:.1}"/>"#);
            let y = floor + 13.0;
            // A label that would reach over the right edge of the drawing is moved to the left.
            let (x, anchor) = if x + LABEL_HALF > WIDTH { (WIDTH, "end") } else { (x, "middle") };
            let _ = write!(svg, r#"<text class="faint" x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{label}</text>"#);
        }
        for (bin, label) in ticks(range.up) {
            let y = range.y(bin);
            let _ = write!(svg, r#"<path class="axis" d="M{LEFT} {y:.1}H{right:.1}"/>"#);
            let (x, y) = (LEFT - 5.0, y + 3.5);
            let _ = write!(svg, r#"<text class="faint" x="{x:.1}" y="{y:.1}" text-anchor="end">{label}</text>"#);
        }
        let (middle, below, unit) = ((LEFT + right) / 2.0, HEIGHT - 4.0, self.unit);
        let _ = write!(svg, r#"<text x="{middle:.1}" y="{below}" text-anchor="middle">half width, {unit}</text>"#);
        let centre = (TOP + floor) / 2.0;
        let _ = write!(
            svg,
            r#"<text transform="translate(11 {centre:.1}) rotate(-90)" text-anchor="middle">error, {unit}</text>"#
        );
        svg
    }
}

/// Ranges of the diagram's horizontal and vertical scale, in numbers of bins.
struct Range {
    across: [f64; 2],
    up: [f64; 2],
}

impl Range {
    fn x(&self, bin: f64) -> f64 {
        let [least, most] = self.across;
        LEFT + (WIDTH - LEFT - 6.0) * (bin - least) / (most - least)
    }

    fn y(&self, bin: f64) -> f64 {
        let [least, most] = self.up;
        HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (bin - least) / (most - least)
    }
}

/// Returns the positions, in numbers of bins, and the labels of the ticks of a scale: 1, 2 and 5 of each decade, or only the beginnings of decades on
/// a long scale.
fn ticks([least, most]: [f64; 2]) -> Vec<(f64, String)> {
    let steps: &[f64] = if most - least > 2.0 * BINS { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let decades = (least / BINS).floor() as i32..=(most / BINS).ceil() as i32;
    let tick = |decade: i32, step: f64| {
        let value = step * 10_f64.powi(decade);
        (value.log10() * BINS, format!("{value:.*}", usize::try_from(-decade).unwrap_or(0)))
    };
    let all = decades.flat_map(|decade| steps.iter().map(move |step| tick(decade, *step)));
    all.filter(|(bin, _)| (least..=most).contains(bin)).collect()
}
