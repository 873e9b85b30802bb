//! The figures of a verdict, field by field as `summary.json` holds them.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::subject::Failure;

mod distribution;
mod named;
mod post_localization;

pub use distribution::{Calibration, Distribution, Nees, Region};
pub use named::{NamedClaim, NamedClaims};
pub use post_localization::PostLocalization;

/// How an estimate relates to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The truth is in the union of boxes.
    Contained,
    /// The truth is outside because a declared bound that the estimate relies on was exceeded: when the run is simulated again with the bound kept,
    /// the truth is inside.
    BoundBroken,
    /// The truth is outside because more claims were false than declared: when the run is simulated again without the readings that made them, the
    /// truth is inside.
    Perception,
    /// The truth is outside and no cause is found: every bound held and no more claims were false than declared, or the truth is still outside when
    /// the run is simulated again with the bounds kept and without the readings that made the false claims.
    Unsound,
}

/// Everything about a run that `summary.json` holds, in its order.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Counts of the judge's judgements over all steps; `None` for a localizer that answers with points.
    pub containment: Option<Containment>,
    /// The judge's judgement of every step of the run, which `steps.csv` holds.
    #[serde(skip)]
    pub judgements: Vec<Judgement>,
    /// What the localizer under test did wrong so that the run ended before its time; absent for one that answered to the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subject_failure: Option<Failure>,
    /// Every declared bound that was exceeded, whether or not the truth stayed inside.
    pub violations: Vec<Violation>,
    /// Errors of the midpoint of the estimate's hull, the smallest box around its boxes, or of the point or the mean that the localizer states.
    pub error: ErrorTable,
    /// Full widths of the estimate's hull, the smallest box around its boxes, over all steps; `None` for a tested localizer (subject) that answers
    /// with points.
    pub width: Option<WidthTable>,
    /// |error| of the box's middle over half the box's width, which shows how much narrower the boxes could have been; `None` for a tested localizer
    /// (subject) that answers with points.
    pub power: Option<PowerTable>,
    /// Share of the steps at which the localizer doubts no assumption, its boxes hold the truth, and the box around them is narrower than declared;
    /// `None` for a tested localizer (subject) that answers with points.
    pub availability: Option<f64>,
    /// Boxes at the key frames of the drive by what was read later, too; left out where the scene does not ask for them (`localizer.post_window`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub post_localization: Option<PostLocalization>,
    /// How well the distributions that the localizer states agree with the truth; `None` for a localizer that answers with boxes or points.
    pub distribution: Option<Distribution>,
    /// Age, at each step, of what the localizer's answer takes into account; `None` for a localizer that does not tell.
    pub latency_s: Option<Latency>,
    /// For each method, counts of its readings and claims.
    pub methods: BTreeMap<String, MethodCounts>,
    /// For each baseline, its errors, or the containment and widths of its boxes.
    pub baselines: BTreeMap<String, Baseline>,
    /// Further figures, which depend on the scene.
    pub metrics: BTreeMap<String, f64>,
    /// Whether the scene's expectations were met.
    pub verdict: Passed,
}

impl Judgement {
    /// All judgements that the judge may give a step, from best to worst.
    pub const ALL: [Judgement; 4] =
        [Judgement::Contained, Judgement::BoundBroken, Judgement::Perception, Judgement::Unsound];

    /// Name of the judgement in every output file.
    pub fn name(self) -> &'static str {
        match self {
            Judgement::Contained => "contained",
            Judgement::BoundBroken => "bound_broken",
            Judgement::Perception => "perception",
            Judgement::Unsound => "unsound",
        }
    }
}

/// Counts of the judge's judgements over all steps.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Containment {
    /// Number of steps that were judged.
    pub checks: usize,
    /// Number of steps with the truth in the union of boxes.
    pub contained: usize,
    /// Number of steps with the truth outside because of a broken bound.
    pub bound_broken: usize,
    /// Number of steps with the truth outside because of too many false claims.
    pub perception: usize,
    /// Number of steps with the truth outside and no cause found.
    pub unsound: usize,
    /// How many times the run was simulated again to find what was to blame for the steps outside.
    pub replays: usize,
    /// The first step at which the truth was outside the union of boxes.
    pub first_failure: Option<FirstFailure>,
}

/// The first step of a run at which the truth was outside the union of boxes, and what was to blame.
#[derive(Clone, Debug, Serialize)]
pub struct FirstFailure {
    /// Time of the first step outside.
    pub time_s: f64,
    /// Axis along which the truth is farthest outside the estimate's hull (the smallest box around its boxes): `x_m`, `y_m` or `heading_rad`;
    /// `between branches` when it is inside the hull but in none of the boxes.
    pub axis: &'static str,
    /// Distance of the truth from the estimate's hull (the smallest box around its boxes) along the axis where it is farthest outside; 0 when the
    /// truth is inside the hull but in none of the boxes.
    pub margin: f64,
    /// The judgement of the first step outside.
    pub outcome: Judgement,
    /// Name of the broken bound, or which claims were false.
    pub blame: String,
    /// By how much the bound or the number of false claims was exceeded, and with which change the same commands keep the truth inside the boxes.
    pub because: String,
    /// For false claims that are to blame, those of the last reading with too many of them before the truth was outside, by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_claims: Option<NamedClaims>,
}

/// A time range in which a quantity exceeded its declared bound.
///
/// A bound on displacement, such as `wheels.slip`, applies to every window of at most `bounds.slip_window_s`: the value given is the
/// greatest over such windows, not the sum over a longer push.
#[derive(Clone, Debug, Serialize)]
pub struct Violation {
    /// Name of the bound that was exceeded.
    pub bound: String,
    /// Time at which the excess begins.
    pub from_s: f64,
    /// Time at which the excess ends.
    pub to_s: f64,
    /// Declared bound at the time of the greatest excess.
    pub declared: f64,
    /// True value at the time of the greatest excess.
    #[serde(rename = "true")]
    pub true_value: f64,
}

impl Violation {
    /// True value over declared bound; infinite where the bound is 0.
    pub fn ratio(&self) -> f64 {
        self.true_value / self.declared
    }

    /// By how much the true value exceeds the bound.
    pub(super) fn excess(&self) -> f64 {
        self.true_value - self.declared
    }
}

/// The result of another method on the same readings. A point method has errors; a method that gives boxes has containment and widths.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Baseline {
    /// Errors of a point method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorTable>,
    /// How many of the boxes contain the truth that a baseline gives as an interval solver.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub containment: Option<BaselineContainment>,
    /// Widths of a solver's boxes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<BaselineWidth>,
}

/// Containment of the truth in the boxes of an interval solver that is run as a baseline.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BaselineContainment {
    /// Number of pose problems given to the solver; each is to find the robot's pose from one range reading.
    pub checks: usize,
    /// Number of boxes that contain the truth.
    pub contained: usize,
}

/// Widths of a solver's boxes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BaselineWidth {
    /// Widths of the boxes over all pose problems that the solver answered.
    pub at_fix: FixWidth,
}

/// |error of the hull's midpoint| over half the hull's width. At 1 the truth is on a face of the box; boxes that are narrower by the factor
/// of the greatest value (`max`) would still have held the truth. Not a number where no step had a bounded box.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PowerTable {
    /// |error of the hull's midpoint| over half the hull's width, over all steps.
    #[serde(flatten)]
    pub over_all: Power,
    /// |error of the hull's midpoint| over half the hull's width, over the steps from 5 s after the start of each drive on, when the start box no
    /// longer matters.
    pub after_5_s: Power,
}

/// |error of the hull's midpoint| over half the hull's width along each axis; the hull is the smallest box around the estimate's boxes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Power {
    /// |error of the hull's midpoint| over half the hull's width, along world x.
    pub x_m: AxisPower,
    /// |error of the hull's midpoint| over half the hull's width, along world y.
    pub y_m: AxisPower,
    /// |error of the hull's midpoint| over half the hull's width, in heading.
    pub heading_rad: AxisPower,
}

/// |error of the hull's midpoint| over half the hull's width along one axis; the hull is the smallest box around the estimate's boxes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AxisPower {
    /// Greatest ratio of the midpoint's |error| to half the hull's width over the steps.
    pub max: f64,
    /// Ratio of the midpoint's |error| to half the hull's width that only one step in a thousand exceeds.
    pub p999: f64,
}

/// Errors of x, y, heading and position.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ErrorTable {
    /// Error along world x.
    pub x_m: AxisError,
    /// Error along world y.
    pub y_m: AxisError,
    /// Error in heading.
    pub heading_rad: AxisError,
    /// Distance of the estimated position from the true position in the plane.
    pub position_m: PositionError,
    /// Errors just after each fix (a reading that constrained the pose), at the stamp of that reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_fix: Option<Box<ErrorTable>>,
}

/// Errors along one axis.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AxisError {
    /// Root mean square error over all steps.
    pub rmse: f64,
    /// Mean magnitude of the error.
    pub mean: f64,
    /// Greatest magnitude of the error.
    pub max: f64,
    /// Root mean square error in each third of the run.
    pub rmse_by_third: [f64; 3],
}

/// Errors of the position in the plane.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PositionError {
    /// Mean distance of the estimated position from the true position.
    pub mean: f64,
    /// Standard deviation of the distance of the estimated position from the true position.
    pub sd: f64,
    /// Greatest distance of the estimated position from the true position.
    pub max: f64,
}

/// Full widths of the estimate's hull.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WidthTable {
    /// Width along world x.
    pub x_m: AxisWidth,
    /// Width along world y.
    pub y_m: AxisWidth,
    /// Width in heading.
    pub heading_rad: AxisWidth,
    /// Full widths of the estimate's hull just after a fix, a reading that constrained the pose.
    pub at_fix: FixWidth,
}

/// Full widths of the estimate's hull (the smallest box around its boxes) at the stamps of images, just after the image constrained the pose.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FixWidth {
    /// Width along world x.
    pub x_m: AxisWidth,
    /// Width along world y.
    pub y_m: AxisWidth,
    /// Width in heading.
    pub heading_rad: AxisWidth,
}

/// Widths along one axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisWidth {
    /// Mean width.
    pub mean: f64,
    /// 95th percentile of the width.
    pub p95: f64,
    /// Greatest width.
    pub max: f64,
    /// Mean width of the estimate's hull in each third of the run.
    pub mean_by_third: [f64; 3],
    /// Mean width of the estimate's hull in the last third of the run over that in the second; 1 when nothing was measured. A value above 1 means
    /// that the localizer loses knowledge.
    pub growth: f64,
}

impl Default for AxisWidth {
    /// Widths to report when nothing was measured.
    fn default() -> Self {
        AxisWidth { mean: 0.0, p95: 0.0, max: 0.0, mean_by_third: [0.0; 3], growth: 1.0 }
    }
}

/// Counts of a method's readings, of the constraints on the pose that it made from them, and of what it claimed to see.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MethodCounts {
    /// Number of readings that the method was given.
    pub readings: usize,
    /// Number of the method's readings that gave a constraint on the pose.
    pub constraints: usize,
    /// Number of the method's constraints that contradicted the estimate, so that no box was left.
    pub empty: usize,
    /// Number of claims that the method made.
    pub claims: usize,
    /// Number of claims that were false.
    pub false_claims: usize,
    /// How many times the method halved the widths of the estimate's hull, summed over its readings at their stamps.
    pub halved: Halvings,
}

/// Age of the newest reading that an answer takes into account, since its measurement.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Latency {
    /// Mean over the steps.
    pub mean: f64,
    /// Greatest age at any step.
    pub max: f64,
}

/// How many times the widths of the estimate's hull were halved: the sum of log₂ of the width before a reading over the width after it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Halvings {
    /// How many times the width along world x was halved.
    pub x_m: f64,
    /// How many times the width along world y was halved.
    pub y_m: f64,
    /// How many times the width in heading was halved.
    pub heading_rad: f64,
}

/// Whether the scene's expectations were met.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Passed {
    /// Whether all expectations were met.
    pub passed: bool,
    /// One line for each expectation that was not met: name, value, limit.
    pub failed: Vec<String>,
    /// The expectations that ask for figures of boxes, of a localizer that states none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_applicable: Vec<String>,
}
