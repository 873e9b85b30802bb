//! The columns of the result table: their headings and the figures that they show.

use crate::judge::figures::Figures;

use super::Line;

/// One column of the result table.
pub(super) struct Column {
    /// Name of the column on the command line.
    pub(super) name: &'static str,
    /// Heading of the column.
    pub(super) heading: &'static str,
    /// Unit of the column's figures.
    pub(super) unit: &'static str,
    /// Function that gives the text of the column's cell for a line of the table; the text is empty when the line has no such figure.
    pub(super) cell: fn(&Line) -> String,
    /// Whether the column's cells are aligned to the left, as text is.
    pub(super) is_text: bool,
}

const fn text(name: &'static str, heading: &'static str, cell: fn(&Line) -> String) -> Column {
    Column { name, heading, unit: "", cell, is_text: true }
}

const fn number(name: &'static str, heading: &'static str, unit: &'static str, cell: fn(&Line) -> String) -> Column {
    Column { name, heading, unit, cell, is_text: false }
}

/// All columns of the result table, from left to right. Errors ("rmse") are those of the third of a run in which they were greatest. Widths are full widths of
/// the box around the estimate, the wider of x and y, averaged over the run ("width") and over the instants just after a fix, a reading that
/// constrained the pose ("at fix"). "error / half" is |error| of the box's middle over half the box's width, after the first 5 s: the greatest ratio,
/// and the ratio that one step in a thousand exceeds; over several runs, that of the run where it is greatest. "NEES" is the mean normalised
/// error squared of a localizer that states distributions, "in 3σ" the share of steps with the truth within three standard deviations along x, y and heading,
/// "3σ" the full width of that region. A method's "of position" and "of
/// heading" are its shares of all the times that methods halved the box's widths.
pub(super) const COLUMNS: [Column; 34] = [
    text("scene", "scene", |line| line.scene.clone()),
    text("localizer", "localizer", |line| line.subject.clone()),
    text("run", RUN, |line| line.run.clone()),
    number("checks", "checks", "", |line| show(line, "containment.checks", 1.0, 0)),
    number("contained", "contained", "%", |line| share(line.figures.get("containment.contained_share"))),
    number("bound_broken", "bound broken", "", |line| show(line, "containment.bound_broken", 1.0, 0)),
    number("perception", "perception", "", |line| show(line, "containment.perception", 1.0, 0)),
    number("unsound", "unsound", "", |line| show(line, "containment.unsound", 1.0, 0)),
    number("rmse", "rmse x / y, worst third", "mm", |line| {
        pair(["x_m", "y_m"].map(|axis| show(line, &format!("error.{axis}.rmse_worst_third"), 1e3, 2)))
    }),
    number("rmse_heading", "rmse heading, worst third", "°", |line| {
        show(line, "error.heading_rad.rmse_worst_third", DEGREES, 3)
    }),
    number("width", "width", "mm", |line| wider(&line.figures, "width")),
    number("width_heading", "width", "°", |line| show(line, "width.heading_rad.mean", DEGREES, 2)),
    number("at_fix", "at fix", "mm", |line| wider(&line.figures, "width.at_fix")),
    number("at_fix_heading", "at fix", "°", |line| show(line, "width.at_fix.heading_rad.mean", DEGREES, 2)),
    number("nees", "NEES", "", |line| show(line, "distribution.nees.mean", 1.0, 1)),
    number("in_3_sigma", "in 3σ", "%", |line| share(line.figures.get("distribution.within_3_sigma_share"))),
    number("width_3_sigma", "3σ", "mm", |line| wider(&line.figures, "distribution.region_3_sigma")),
    number("width_3_sigma_heading", "3σ", "°", |line| {
        show(line, "distribution.region_3_sigma.heading_rad.mean", DEGREES, 2)
    }),
    number("power_x", "x error / half", "max, 99.9 %", |line| power(&line.figures, "x_m")),
    number("power_y", "y error / half", "max, 99.9 %", |line| power(&line.figures, "y_m")),
    number("power_heading", "heading error / half", "max, 99.9 %", |line| power(&line.figures, "heading_rad")),
    number("available", "available", "%", |line| share(line.figures.get("availability"))),
    number("readings", "readings", "", |line| show(line, "method.readings", 1.0, 0)),
    number("fixes", "fixes", "", |line| show(line, "method.constraints", 1.0, 0)),
    number("of_position", "of position", "%", |line| show(line, "method.position_share", 1e2, 1)),
    number("of_heading", "of heading", "%", |line| show(line, "method.heading_share", 1e2, 1)),
    number("searched", "searched", "s", |line| show(line, "metrics.searched_s", 1.0, 1)),
    number("goals", "goals reached", "%", |line| share(goals_reached(&line.figures).as_ref())),
    number("arrival", "arrival", "mm", |line| show(line, "metrics.arrival_error_mean_m", 1e3, 1)),
    number("off_path", "off path p95", "mm", |line| show(line, "metrics.path_deviation_p95_m", 1e3, 1)),
    number("collisions", "collisions", "", |line| show(line, "metrics.collisions", 1.0, 0)),
    number("speed", "speed", "× real", |line| show(line, "timing.real_time_factor", 1.0, 1)),
    number("solved_in", "solved in", "µs", |line| show(line, "timing.solve_us", 1.0, 1)),
    text("verdict", "verdict", |line| line.verdict.clone()),
];

/// Names of columns in the order in which they are chosen where a table has room for some only: what runs came to, and then how. Those of methods and
/// of baselines follow.
pub(super) const FIRST: [&str; 25] = [
    "scene",
    "run",
    "verdict",
    "localizer",
    "contained",
    "unsound",
    "bound_broken",
    "perception",
    "in_3_sigma",
    "width",
    "width_heading",
    "nees",
    "width_3_sigma",
    "width_3_sigma_heading",
    "collisions",
    "searched",
    "rmse",
    "goals",
    "rmse_heading",
    "available",
    "readings",
    "fixes",
    "of_position",
    "of_heading",
    "solved_in",
];

/// Names of columns with counts of what went wrong. Where all are 0, others have their room.
pub(super) const FAULTS: [&str; 3] = ["bound_broken", "perception", "collisions"];

/// Heading of the column that names runs.
pub(super) const RUN: &str = "run";

/// Index of the column that names the scene.
pub(super) const SCENE: usize = 0;

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

fn show(line: &Line, figure: &str, scale: f64, digits: usize) -> String {
    line.figures.get(figure).map(|value| format!("{:.digits$}", value * scale)).unwrap_or_default()
}

fn goals_reached(figures: &Figures) -> Option<f64> {
    let (reached, errands) = (figures.get("metrics.goals_reached")?, figures.get("metrics.errands")?);
    (*errands > 0.0).then(|| reached / errands)
}

/// Two figures in one cell.
fn pair([first, second]: [String; 2]) -> String {
    if first.is_empty() && second.is_empty() { String::new() } else { format!("{first} / {second}") }
}

/// |Error| of the middle of the estimate's box over half the box's width along an axis, after the first 5 s: the greatest ratio, and the ratio that
/// one step in a thousand exceeds.
fn power(figures: &Figures, axis: &str) -> String {
    let figure = |which: &str| figures.get(&format!("power.after_5_s.{axis}.{which}"));
    match (figure("max"), figure("p999")) {
        (Some(max), Some(p999)) => format!("{max:.2}, {p999:.2}"),
        _ => String::new(),
    }
}

fn wider(figures: &Figures, width: &str) -> String {
    let mean_m = |axis: &str| figures.get(&format!("{width}.{axis}.mean"));
    match (mean_m("x_m"), mean_m("y_m")) {
        (Some(x_m), Some(y_m)) => format!("{:.1}", 1e3 * x_m.max(*y_m)),
        _ => String::new(),
    }
}

/// A share in percent that reads 100 only when it is complete: smaller shares read at most 99.99.
fn share(share: Option<&f64>) -> String {
    match share {
        None => String::new(),
        Some(share) if *share >= 1.0 => "100".to_owned(),
        Some(share) => format!("{:.2}", (share * 1e2).min(99.99)),
    }
}
