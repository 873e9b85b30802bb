//! Heatmap of a numerical result over the values of two scene keys: one cell for each pair of values, coloured by the result, which is also written
//! in the cell.

use std::fmt::Write;

use maud::{Markup, PreEscaped, html};

use super::{Group, Measure, Overview};

const WIDTH: f64 = 360.0;
const LEFT: f64 = 74.0;
const TOP: f64 = 38.0;
const ROW: f64 = 25.0;
/// Greatest number of columns of a heatmap with which its cells are wide enough for numbers.
const MOST_NUMBERED: usize = 9;

/// The two scene keys whose values are the columns and the rows of heatmaps. The key with more values has the rows, as the screen of a phone is
/// higher than wide.
struct Plane {
    across: Axis,
    down: Axis,
}

struct Axis {
    key: String,
    values: Vec<String>,
}

/// Draws heatmaps of the share of steps with the truth in the box, the box's width, its midpoint's error and the goals reached, over the first two
/// scene keys that vary; nothing when no key varies, or when not every combination is known.
pub(super) fn heatmaps(overview: &Overview) -> Option<Markup> {
    if overview.sketched.as_ref().is_some_and(|sketched| sketched.n_unlisted > 0) {
        return None;
    }
    let plane = plane(overview)?;
    let shown = ["contained", "width", "error", "goals"];
    let others: Vec<&String> = overview.keys.iter().skip(2).collect();
    Some(html! {
        h2 { "Where" }
        p.note {
            "Each cell: all seeds of one combination"
            @if !others.is_empty() {
                ", and all values of " @for (index, key) in others.iter().enumerate() {
                    @if index > 0 { ", " } code { (key) }
                }
            }
            "."
        }
        div.plots {
            @for measure in overview.measures().filter(|measure| shown.contains(&measure.name)) {
                figure {
                    figcaption { strong { (measure.name) } ", " (measure.unit) " " span { "– " (measure.meaning) } }
                    (PreEscaped(heatmap(overview, &plane, measure)))
                }
            }
        }
    })
}

fn plane(overview: &Overview) -> Option<Plane> {
    let axis = |key: &String| {
        let mut values: Vec<String> = Vec::new();
        for value in overview.groups.iter().map(|group| group.value(key)) {
            if !values.contains(&value) {
                values.push(value);
            }
        }
        Axis { key: key.clone(), values }
    };
    let mut axes = overview.keys.iter().take(2).map(axis);
    let first = axes.next()?;
    let second = axes.next().unwrap_or(Axis { key: String::new(), values: vec![String::new()] });
    let (across, down) = if first.values.len() > second.values.len() { (second, first) } else { (first, second) };
    Some(Plane { across, down })
}

/// Logarithm of the ratio of the greatest to the least result that the colours span at least, so that results that differ by less look alike.
const LEAST_RANGE: f64 = 0.7;

fn heatmap(overview: &Overview, plane: &Plane, measure: &Measure) -> String {
    let (columns, rows) = (plane.across.values.len(), plane.down.values.len());
    let cell_width = (WIDTH - LEFT) / columns as f64;
    let height = TOP + ROW * rows as f64 + 4.0;
    let values: Vec<Option<f64>> =
        (0..rows * columns).map(|index| value(overview, plane, measure, index % columns, index / columns)).collect();
    let mut svg = format!(r#"<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{}">"#, measure.name);
    let middle = LEFT + (WIDTH - LEFT) / 2.0;
    // Writing to a `String` cannot fail, here and in the other places of this file.
    let _ = write!(
        svg,
        r#"<text x="{middle}" y="11" text-anchor="middle" class="faint">{}</text>"#,
        leaf(&plane.across.key)
    );
    let _ = write!(svg, r#"<text x="0" y="11" class="faint">{}</text>"#, leaf(&plane.down.key));
    for (column, label) in plane.across.values.iter().enumerate() {
        let x = LEFT + cell_width * (column as f64 + 0.5);
        if columns <= MOST_NUMBERED || column % columns.div_ceil(MOST_NUMBERED) == 0 {
            let _ = write!(svg, r#"<text x="{x:.1}" y="30" text-anchor="middle">{}</text>"#, short(label));
        }
    }
    for (row, label) in plane.down.values.iter().enumerate() {
        let y = TOP + ROW * (row as f64 + 0.5) + 4.0;
        let _ = write!(svg, r#"<text x="{:.1}" y="{y:.1}" text-anchor="end">{}</text>"#, LEFT - 8.0, short(label));
        for column in 0..columns {
            let value = values[row * columns + column];
            let place = [LEFT + cell_width * column as f64, TOP + ROW * row as f64];
            svg += &cell(measure, value, tone(measure, value, &values), place, cell_width, columns <= MOST_NUMBERED);
        }
    }
    svg + "</svg>"
}

/// Returns the numerical result that one cell of a heatmap shows, such as the mean width: pooled over all runs with the cell's values of the two
/// keys.
fn value(overview: &Overview, plane: &Plane, measure: &Measure, column: usize, row: usize) -> Option<f64> {
    let belongs = |group: &&Group| {
        (plane.across.key.is_empty() || group.value(&plane.across.key) == plane.across.values[column])
            && (plane.down.key.is_empty() || group.value(&plane.down.key) == plane.down.values[row])
            && !group.figures.is_empty()
    };
    let figures: Vec<_> = overview.groups.iter().filter(belongs).map(|group| &group.figures).collect();
    match figures.as_slice() {
        [] => None,
        [only] => (measure.value)(only),
        several => (measure.value)(&crate::artefacts::result_table::pool(several)),
    }
}

/// Returns the colour of a heatmap's cell and its strength, from 0 to 1. Cells in which the truth was lost or goals were missed stand out; cells of
/// other results are the darker the greater the result.
fn tone(measure: &Measure, value: Option<f64>, all: &[Option<f64>]) -> Option<(&'static str, f64)> {
    let value = value?;
    let worst_lacks = match measure.name {
        "contained" => Some(10.0),
        "goals" => Some(100.0),
        _ => None,
    };
    if let Some(worst_lacks) = worst_lacks {
        return Some(if value >= 100.0 {
            ("--contained", 0.28)
        } else {
            ("--unsound", 0.45 + 0.55 * ((100.0 - value) / worst_lacks).min(1.0))
        });
    }
    let known = || all.iter().flatten().copied().filter(|value| *value > 0.0);
    let (least, most) = (known().fold(f64::INFINITY, f64::min), known().fold(0.0, f64::max));
    // The strength of the colour grows with the logarithm of the result, as widths and errors range over decades.
    let range = (most / least).ln().max(LEAST_RANGE);
    let share = if most > least && value > 0.0 { (value / least).ln() / range } else { 0.0 };
    Some(("--blue", 0.08 + 0.84 * share))
}

fn cell(
    measure: &Measure,
    value: Option<f64>,
    tone: Option<(&str, f64)>,
    [x, y]: [f64; 2],
    width: f64,
    is_numbered: bool,
) -> String {
    let Some((colour, share)) = tone else {
        let (x, y) = (x + width / 2.0, y + ROW / 2.0 + 4.0);
        return format!(r#"<text x="{x:.1}" y="{y:.1}" text-anchor="middle" class="faint">–</text>"#);
    };
    let (fill_width, height) = (width - 1.5, ROW - 1.5);
    let percent = share * 100.0;
    let mut text = format!(
        r#"<rect x="{x:.1}" y="{y:.1}" width="{fill_width:.1}" height="{height:.1}" style="fill:color-mix(in srgb,var({colour}) {percent:.0}%,var(--card))"><title>{}</title></rect>"#,
        measure.show(value)
    );
    if is_numbered {
        let class = if share > 0.5 { "strong" } else { "" };
        let weight = if colour == "--unsound" { " bold" } else { "" };
        let (x, y) = (x + fill_width / 2.0, y + ROW / 2.0 + 3.5);
        let _ = write!(
            text,
            r#"<text x="{x:.1}" y="{y:.1}" text-anchor="middle" class="{class}{weight}">{}</text>"#,
            measure.show(value)
        );
    }
    text
}

/// Returns the last part of a dotted key, as the whole key does not fit above a heatmap's column.
fn leaf(key: &str) -> String {
    escaped(key.rsplit('.').next().unwrap_or(key))
}

/// Shortens the label of a column or row to at most ten characters.
fn short(value: &str) -> String {
    if value.chars().count() <= 10 {
        return escaped(value);
    }
    match value.parse::<f64>() {
        Ok(number) => format!("{number:.3}"),
        Err(_) => escaped(&value.chars().take(9).chain(['…']).collect::<String>()),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
