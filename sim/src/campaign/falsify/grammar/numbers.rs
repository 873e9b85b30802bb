//! Draws the values of numerical scene keys within a range: near the key's default, at the ends of the range, or between them with every order of
//! magnitude equally likely.

use serde_json::Value as Json;

use crate::{
    campaign::falsify::dice::{Dice, rounded},
    scene::schema::resolve,
};

use super::weights;

/// Range from which a number is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) least: f64,
    pub(super) most: f64,
    /// Default value of the key, if the key has one that is a number.
    pub(super) default: Option<f64>,
    /// Whole range that the schema allows for the key. The value is seldom drawn from all of it.
    allowed: [f64; 2],
}

impl Span {
    /// Returns the range that the schema allows for the key at `path`, narrowed to values with which a robot can drive. `property` is the schema's
    /// entry that states the key's default.
    pub(super) fn of(node: &'static Json, property: &'static Json, path: &str) -> Span {
        let bound = |name: &str| node.get(name).and_then(Json::as_f64);
        let above = bound("exclusiveMinimum").map(f64::next_up);
        let allowed = [bound("minimum").or(above).unwrap_or(-1.0), bound("maximum").unwrap_or(1.0)];
        let [least, most] = weights::range(path).unwrap_or(allowed);
        let default = property.get("default").or_else(|| resolve(property).get("default")).and_then(Json::as_f64);
        Span { least: least.max(allowed[0]), most: most.min(allowed[1]), default, allowed }
    }
}

/// Least magnitude that is drawn on a logarithmic scale, relative to the greatest one. Ranges that include 0 need such a limit.
const DEPTH: f64 = 1e-4;

/// Threshold of a uniform random number in 0..1: at or above it, in one draw of 250, a key's value is drawn from the whole range that the schema
/// allows. A scene states dozens of numbers, so that some scenes have such a value and most have none.
const ALLOWED_FROM: f64 = 0.996;

/// Draws a key's value from its range `span`; none when the range is empty.
pub(super) fn number(dice: &mut Dice, span: &Span) -> Option<f64> {
    let Span { mut least, mut most, default, allowed } = *span;
    if least >= most {
        return (least == most).then_some(least);
    }
    let which = dice.uniform(0.0, 1.0);
    if which >= ALLOWED_FROM {
        [least, most] = allowed;
    }
    let drawn = if which < 0.07 {
        least
    } else if which < 0.14 {
        most
    } else if let Some(default) = default.filter(|default| *default != 0.0 && which < 0.6) {
        default * dice.log_uniform(0.1, 10.0)
    } else if least >= 0.0 {
        dice.log_uniform(least.max(most * DEPTH), most)
    } else if which < 0.7 {
        dice.uniform(least, most)
    } else {
        let reach = least.abs().max(most.abs());
        dice.log_uniform(reach * DEPTH, reach) * if dice.chance(0.5) { 1.0 } else { -1.0 }
    };
    Some(rounded(drawn, 4).clamp(least, most))
}

/// Draws a direction in degrees: along the x or y axis, close to one of them, or any.
pub(super) fn direction_deg(dice: &mut Dice) -> f64 {
    let quarter = 90.0 * dice.whole(-2, 2) as f64;
    let which = dice.uniform(0.0, 1.0);
    if which < 0.3 {
        quarter
    } else if which < 0.5 {
        rounded(quarter + dice.uniform(-3.0, 3.0), 4)
    } else {
        rounded(dice.uniform(-180.0, 180.0), 4)
    }
}
