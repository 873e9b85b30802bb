//! Numbers within a range: at the default, at the ends, and each order of magnitude between as likely.

use serde_json::Value as Json;

use crate::{
    campaign::falsify::dice::{Dice, rounded},
    scene::schema::resolve,
};

use super::weights;

/// From where to where a number is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) least: f64,
    pub(super) most: f64,
    /// What the key is when nobody states it, if that is a number.
    pub(super) default: Option<f64>,
    /// From where to where the schema lets it go: seldom it is drawn from all of that.
    allowed: [f64; 2],
}

impl Span {
    /// What the schema allows at `path`, narrowed to what can drive. `property` carries the default.
    pub(super) fn of(node: &'static Json, property: &'static Json, path: &str) -> Span {
        let bound = |name: &str| node.get(name).and_then(Json::as_f64);
        let above = bound("exclusiveMinimum").map(f64::next_up);
        let allowed = [bound("minimum").or(above).unwrap_or(-1.0), bound("maximum").unwrap_or(1.0)];
        let [least, most] = weights::range(path).unwrap_or(allowed);
        let default = property.get("default").or_else(|| resolve(property).get("default")).and_then(Json::as_f64);
        Span { least: least.max(allowed[0]), most: most.min(allowed[1]), default, allowed }
    }
}

/// Orders of magnitude below the greatest value in which numbers that may be 0 are looked for.
const DEPTH: f64 = 1e-4;

/// One number of 250 is drawn from all that the schema allows: a scene states dozens, so that some scenes have such a number and most have none.
const ALLOWED_FROM: f64 = 0.996;

/// A number of `span`; none when nothing is left of it.
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

/// A direction: along an axis, close to one, or any.
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
