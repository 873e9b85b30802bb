//! The verdict's figures, field by field as `summary.json` holds them.

use std::collections::BTreeMap;

use serde::Serialize;

/// How an estimate stands to the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The truth is in the union.
    Contained,
    /// The truth is outside because a declared bound on which the estimate relies was exceeded: with the bound kept it is inside.
    BoundBroken,
    /// The truth is outside because more claims were false than declared: without those it is inside.
    Perception,
    /// The truth is outside though every bound held and the claims were true, or would be outside if they were.
    Unsound,
}

/// Everything that `summary.json` holds of a run, in its order.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Counts of judgements over all steps; none of a subject that answers with points.
    pub containment: Option<Containment>,
    /// The judgement of every step; `steps.csv` holds them.
    #[serde(skip)]
    pub judgements: Vec<Judgement>,
    /// Every declared bound that was exceeded, whether or not the truth stayed inside.
    pub violations: Vec<Violation>,
    /// Errors of the midpoint of the hull.
    pub error: ErrorTable,
    /// Full widths of the hull, over all steps; none of points.
    pub width: Option<WidthTable>,
    /// |error| over half the width: how much narrower the boxes could have been; none of points.
    pub power: Option<PowerTable>,
    /// Share of steps that are sound, hold the truth and are narrower than declared; none of points.
    pub availability: Option<f64>,
    /// By method, what it read and said.
    pub methods: BTreeMap<String, MethodCounts>,
    /// By baseline, its errors.
    pub baselines: BTreeMap<String, Baseline>,
    /// What a scene measures besides.
    pub metrics: BTreeMap<String, f64>,
    /// Whether the scene's expectations were met.
    pub verdict: Passed,
}

impl Judgement {
    /// All of them, from best to worst.
    pub const ALL: [Judgement; 4] =
        [Judgement::Contained, Judgement::BoundBroken, Judgement::Perception, Judgement::Unsound];

    /// Its name in every file.
    pub fn name(self) -> &'static str {
        match self {
            Judgement::Contained => "contained",
            Judgement::BoundBroken => "bound_broken",
            Judgement::Perception => "perception",
            Judgement::Unsound => "unsound",
        }
    }
}

/// Counts of judgements over all steps.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Containment {
    /// Steps judged.
    pub checks: usize,
    /// Steps with the truth in the union.
    pub contained: usize,
    /// Steps outside with a broken bound.
    pub bound_broken: usize,
    /// Steps outside with too many false claims.
    pub perception: usize,
    /// Steps outside without a cause.
    pub unsound: usize,
    /// How many times the run was simulated again to find whose fault they are.
    pub replays: usize,
    /// The first step that was not contained.
    pub first_failure: Option<FirstFailure>,
}

/// The first step whose union did not contain the truth.
#[derive(Clone, Debug, Serialize)]
pub struct FirstFailure {
    /// When.
    pub time_s: f64,
    /// Axis with the greatest distance to the hull: `x_m`, `y_m` or `heading_rad`; `between branches` when inside the hull.
    pub axis: &'static str,
    /// That distance; 0 between branches.
    pub margin: f64,
    /// The judgement.
    pub outcome: Judgement,
    /// Name of the broken bound, or what was false.
    pub blame: String,
    /// How much was exceeded, and without what the truth is held.
    pub because: String,
}

/// A time range in which a quantity exceeded its declared bound.
///
/// A bound of displacement, such as `wheels.slip`, is one over a window of at most `bounds.slip_window_s`: its value is the greatest
/// over such windows, not the sum over a longer push.
#[derive(Clone, Debug, Serialize)]
pub struct Violation {
    /// Name of the bound.
    pub bound: String,
    /// Start of the excess.
    pub from_s: f64,
    /// End of the excess.
    pub to_s: f64,
    /// Declared bound at the moment of the greatest excess.
    pub declared: f64,
    /// True value at that moment.
    #[serde(rename = "true")]
    pub true_value: f64,
}

impl Violation {
    /// True value over declared bound; infinite where that is 0.
    pub fn ratio(&self) -> f64 {
        self.true_value / self.declared
    }

    /// By how much the true value is beyond.
    pub(super) fn excess(&self) -> f64 {
        self.true_value - self.declared
    }
}

/// What another method made of the same readings: points have errors, boxes contain the truth or not and have widths.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Baseline {
    /// Errors of a point method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorTable>,
    /// How many of a solver's answers contain the truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub containment: Option<BaselineContainment>,
    /// Widths of a solver's answers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<BaselineWidth>,
}

/// Containment of a solver's answers.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BaselineContainment {
    /// Problems put to it.
    pub checks: usize,
    /// Answers that contain the truth.
    pub contained: usize,
}

/// Widths of a solver's answers.
#[derive(Clone, Debug, Default, Serialize)]
pub struct BaselineWidth {
    /// Over all problems it answered.
    pub at_fix: FixWidth,
}

/// |error of the hull's midpoint| over half the hull's width. At 1 the truth is at a face of the box; boxes 1 / max times as wide would
/// have held it too. Not a number where no step had a box with sides.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PowerTable {
    /// Over all steps.
    #[serde(flatten)]
    pub over_all: Power,
    /// Over those from 5 s of each drive on, when the start is forgotten.
    pub after_5_s: Power,
}

/// |error| over half the width along each axis.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Power {
    /// World x.
    pub x_m: AxisPower,
    /// World y.
    pub y_m: AxisPower,
    /// Heading.
    pub heading_rad: AxisPower,
}

/// |error| over half the width along one axis.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AxisPower {
    /// Greatest.
    pub max: f64,
    /// Only one step in a thousand has more.
    pub p999: f64,
}

/// Errors of x, y, heading and position.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ErrorTable {
    /// World x.
    pub x_m: AxisError,
    /// World y.
    pub y_m: AxisError,
    /// Heading.
    pub heading_rad: AxisError,
    /// Distance in the plane.
    pub position_m: PositionError,
    /// The same just after each fix, at the stamp of the reading that made it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_fix: Option<Box<ErrorTable>>,
}

/// Errors along one axis.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AxisError {
    /// Root mean square over all steps.
    pub rmse: f64,
    /// Mean magnitude.
    pub mean: f64,
    /// Greatest magnitude.
    pub max: f64,
    /// Root mean square of each third of the run.
    pub rmse_by_third: [f64; 3],
}

/// Errors in the plane.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PositionError {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Greatest.
    pub max: f64,
}

/// Full widths of the hull.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WidthTable {
    /// World x.
    pub x_m: AxisWidth,
    /// World y.
    pub y_m: AxisWidth,
    /// Heading.
    pub heading_rad: AxisWidth,
    /// The same just after a fix.
    pub at_fix: FixWidth,
}

/// Mean widths at the stamps of images, just after their constraint.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FixWidth {
    /// World x.
    pub x_m: AxisWidth,
    /// World y.
    pub y_m: AxisWidth,
    /// Heading.
    pub heading_rad: AxisWidth,
}

/// Widths along one axis.
#[derive(Clone, Debug, Serialize)]
pub struct AxisWidth {
    /// Mean.
    pub mean: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Greatest.
    pub max: f64,
    /// Mean of each third.
    pub mean_by_third: [f64; 3],
    /// Mean of the last third over that of the second: above 1 what is known gets lost; 1 when nothing was measured.
    pub growth: f64,
}

impl Default for AxisWidth {
    /// Nothing measured.
    fn default() -> Self {
        AxisWidth { mean: 0.0, p95: 0.0, max: 0.0, mean_by_third: [0.0; 3], growth: 1.0 }
    }
}

/// What a method read and said.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MethodCounts {
    /// Readings given to it.
    pub readings: usize,
    /// Constraints made.
    pub constraints: usize,
    /// Constraints that emptied the union.
    pub empty: usize,
    /// Claims made.
    pub claims: usize,
    /// Claims that were false.
    pub false_claims: usize,
    /// How many times over it halved the hull's width at its readings' stamps.
    pub halved: Halvings,
}

/// How many times over widths were halved: the sum of log₂ of the width before over the width after.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Halvings {
    /// Along world x.
    pub x_m: f64,
    /// Along world y.
    pub y_m: f64,
    /// Of the heading.
    pub heading_rad: f64,
}

/// Whether the scene's expectations were met.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Passed {
    /// All of them.
    pub passed: bool,
    /// One line for each that was not: name, value, limit.
    pub failed: Vec<String>,
}
