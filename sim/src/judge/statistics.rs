//! Statistics of errors and widths over a run.

use localizer::{Pose, PoseBox};

use crate::run::RunRecord;

use super::verdict::{
    AxisError, AxisPower, AxisWidth, ErrorTable, FixWidth, PositionError, Power, PowerTable, WidthTable,
};

/// Midpoint of a box; not a number (NaN) when the box is empty.
pub(crate) fn midpoint(hull: &PoseBox) -> Pose {
    let middle = |axis: usize| if hull.is_empty() { f64::NAN } else { hull[axis].mid() };
    Pose { x_m: middle(0), y_m: middle(1), heading_rad: middle(2) }
}

/// Errors of `estimates` against `truths`, step by step; steps without an estimate are left out.
pub(crate) fn errors(estimates: &[Pose], truths: &[Pose]) -> ErrorTable {
    let pairs = || estimates.iter().zip(truths);
    let axis = |component: fn(&Pose) -> f64| {
        axis_error(&pairs().map(|(estimate, truth)| component(estimate) - component(truth)).collect::<Vec<_>>())
    };
    let distances: Vec<f64> = pairs()
        .map(|(estimate, truth)| (estimate.x_m - truth.x_m).hypot(estimate.y_m - truth.y_m))
        .filter(|distance| distance.is_finite())
        .collect();
    ErrorTable {
        x_m: axis(|pose| pose.x_m),
        y_m: axis(|pose| pose.y_m),
        heading_rad: axis(|pose| pose.heading_rad),
        position_m: position_error(&distances),
        at_fix: None,
    }
}

/// Errors of the midpoint of the estimate's hull (the smallest box around its boxes), just after each reading that constrained the pose.
pub(super) fn errors_at_fix(record: &RunRecord) -> ErrorTable {
    let fixes = record.images.iter().filter(|image| image.constrained && !image.emptied);
    let (midpoints, truths): (Vec<Pose>, Vec<Pose>) =
        fixes.map(|image| (midpoint(&image.posterior.hull()), image.truth.pose)).unzip();
    errors(&midpoints, &truths)
}

/// Full widths of the estimate's hull (the smallest box around its boxes) over all steps, and just after each reading that constrained the pose.
pub(super) fn widths(record: &RunRecord) -> WidthTable {
    let hulls: Vec<PoseBox> = record.estimates.iter().map(|estimate| estimate.pose.hull()).collect();
    let fixes: Vec<PoseBox> = record
        .images
        .iter()
        .filter(|image| image.constrained && !image.emptied)
        .map(|image| image.posterior.hull())
        .collect();
    let [x_m, y_m, heading_rad] = [0, 1, 2].map(|axis| axis_width(&hulls, axis));
    WidthTable { x_m, y_m, heading_rad, at_fix: fix_width(&fixes) }
}

/// Full widths of boxes, axis by axis.
pub(crate) fn fix_width(hulls: &[PoseBox]) -> FixWidth {
    let [x_m, y_m, heading_rad] = [0, 1, 2].map(|axis| axis_width(hulls, axis));
    FixWidth { x_m, y_m, heading_rad }
}

/// Time into a drive after which the localizer's knowledge comes from its sensors rather than from the start box.
pub(crate) const SETTLED_S: f64 = 5.0;

/// |error of the midpoint| over half the width at each step, over the whole run and from 5 s after the start of each drive.
pub(super) fn power(record: &RunRecord) -> PowerTable {
    let mut drive_began_s = 0.0;
    let (mut all, mut settled): (Vec<[f64; 3]>, Vec<[f64; 3]>) = (Vec::new(), Vec::new());
    for (step, (truth, estimate)) in record.truths.iter().zip(&record.estimates).enumerate() {
        if record.restarts.contains(&step) {
            drive_began_s = truth.time_s;
        }
        let (hull, truth_at) = (estimate.pose.hull(), truth.pose.to_array());
        let middle = midpoint(&hull).to_array();
        // A box of width 0 with an error of 0 is exact, so that its ratio is 0.
        let ratio = |axis: usize| (middle[axis] - truth_at[axis]).abs() / (0.5 * hull.width(axis)).max(1e-12);
        let ratios = [0, 1, 2].map(ratio);
        all.push(ratios);
        if truth.time_s - drive_began_s >= SETTLED_S {
            settled.push(ratios);
        }
    }
    let table = |ratios: &[[f64; 3]]| {
        let [x_m, y_m, heading_rad] =
            [0, 1, 2].map(|axis| axis_power(ratios.iter().map(|ratios| ratios[axis]).collect()));
        Power { x_m, y_m, heading_rad }
    };
    PowerTable { over_all: table(&all), after_5_s: table(&settled) }
}

/// The greatest ratio of |error| to half the box's width, and the least of these ratios that at most one in a thousand exceeds. Empty and unbounded
/// boxes have no ratio.
fn axis_power(mut ratios: Vec<f64>) -> AxisPower {
    ratios.retain(|ratio| ratio.is_finite());
    ratios.sort_by(f64::total_cmp);
    let Some(&max) = ratios.last() else { return AxisPower { max: f64::NAN, p999: f64::NAN } };
    let rank = (0.999 * ratios.len() as f64).ceil() as usize;
    AxisPower { max, p999: ratios[rank.clamp(1, ratios.len()) - 1] }
}

/// Statistics of the errors along one axis. Without any error they are not a number, which JSON writes as null and which meets no expectation.
fn axis_error(errors: &[f64]) -> AxisError {
    let n_steps = errors.len();
    let third = |index: usize| rmse(&errors[index * n_steps / 3..(index + 1) * n_steps / 3]);
    AxisError {
        rmse: rmse(errors),
        mean: mean_magnitude(errors),
        max: errors.iter().filter(|error| error.is_finite()).fold(f64::NAN, |max, error| error.abs().max(max)),
        rmse_by_third: [third(0), third(1), third(2)],
    }
}

fn rmse(errors: &[f64]) -> f64 {
    let finite = errors.iter().filter(|error| error.is_finite());
    let (sum, count) = finite.fold((0.0, 0_usize), |(sum, count), error| (sum + error * error, count + 1));
    if count == 0 { f64::NAN } else { (sum / count as f64).sqrt() }
}

fn mean_magnitude(errors: &[f64]) -> f64 {
    let finite: Vec<f64> = errors.iter().filter(|error| error.is_finite()).map(|error| error.abs()).collect();
    finite.iter().sum::<f64>() / finite.len() as f64
}

fn position_error(distances: &[f64]) -> PositionError {
    if distances.is_empty() {
        return PositionError { mean: f64::NAN, sd: f64::NAN, max: f64::NAN };
    }
    let mean = distances.iter().sum::<f64>() / distances.len() as f64;
    let variance = distances.iter().map(|distance| (distance - mean).powi(2)).sum::<f64>() / distances.len() as f64;
    PositionError { mean, sd: variance.sqrt(), max: distances.iter().copied().fold(0.0, f64::max) }
}

/// Statistics of the widths along one axis. An empty hull has no width and is left out; an unbounded one counts with the greatest finite number.
fn axis_width(hulls: &[PoseBox], axis: usize) -> AxisWidth {
    axis_width_of(hulls.iter().filter(|hull| !hull.is_empty()).map(|hull| hull[axis].width().min(f64::MAX)).collect())
}

/// Statistics of widths in the order of time.
pub(super) fn axis_width_of(mut widths: Vec<f64>) -> AxisWidth {
    if widths.is_empty() {
        let none = f64::NAN;
        return AxisWidth { mean: none, p95: none, max: none, mean_by_third: [none; 3], growth: none };
    }
    let n_widths = widths.len();
    let mean = |widths: &[f64]| widths.iter().sum::<f64>() / widths.len() as f64;
    let third = |index: usize| mean(&widths[index * n_widths / 3..(index + 1) * n_widths / 3]);
    let mean_by_third = [third(0), third(1), third(2)];
    widths.sort_by(f64::total_cmp);
    let last = widths.len() - 1;
    AxisWidth {
        mean: mean(&widths),
        p95: widths[(last as f64 * 0.95).round() as usize],
        max: widths[last],
        mean_by_third,
        growth: if mean_by_third[1] > 0.0 { mean_by_third[2] / mean_by_third[1] } else { 1.0 },
    }
}

/// Pearson's correlation of the pairs; `None` where one of the two quantities does not vary.
pub(super) fn correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    let count = pairs.len() as f64;
    let mean = [0, 1].map(|side| pairs.iter().map(|pair| pair[side]).sum::<f64>() / count);
    let product = |first: usize, second: usize| -> f64 {
        pairs.iter().map(|pair| (pair[first] - mean[first]) * (pair[second] - mean[second])).sum()
    };
    let spread = (product(0, 0) * product(1, 1)).sqrt();
    (spread > 0.0).then(|| product(0, 1) / spread)
}
