//! A receiver of satellite navigation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A receiver of satellite navigation with corrections: it tells the place of its antenna in the world frame, and how good that is.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Gnss {
    /// Time between two positions.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub period_s: f64,
    /// Measurement to delivery.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Each delivery is drawn within this of the latency.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// `gnss.stamp`: each stamp is drawn within this of the true time.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// The antenna in the robot frame, forward of the axle: its lever arm.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// The antenna in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the antenna above the floor: where the body leans, the antenna is beside its place by this times the sine of the lean.
    #[schemars(range(min = 0.0, max = 3.0))]
    pub height_m: f64,
    /// `gnss.antenna`: the antenna is drawn within this of its nominal place, forward and left each.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// `gnss.fixed`: either coordinate of a position whose ambiguities are resolved is within this of the antenna's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub fixed_tolerance_m: f64,
    /// `gnss.floating`: either coordinate of a position without resolved ambiguities is within this of the antenna's.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub floating_tolerance_m: f64,
    /// When positions are worse than fixed, or there are none.
    pub outages: Vec<Outage>,
    /// Where they are: under trees, beside walls, in a barn. The worst of what holds at a time and a place counts.
    pub shadows: Vec<Shadow>,
}

/// A time at which positions are worse.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Outage {
    /// When it begins.
    #[schemars(range(min = 0.0, max = 36000.0))]
    pub at_s: f64,
    /// How long it lasts.
    #[schemars(range(min = 0.02, max = 36000.0))]
    pub lasts_s: f64,
    /// What is left of positions.
    #[serde(default)]
    pub leaves: Reception,
}

/// A rectangle along the world's axes above which positions are worse.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shadow {
    /// World x of its middle.
    pub x_m: f64,
    /// World y of its middle.
    pub y_m: f64,
    /// Extent along world x and y.
    #[schemars(inner(range(min = 0.1, max = 200.0)))]
    pub size_m: [f64; 2],
    /// What is left of positions.
    #[serde(default)]
    pub leaves: Reception,
}

/// What the sky lets through, the worst first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reception {
    /// No position at all.
    #[default]
    None,
    /// Positions without resolved ambiguities.
    Floating,
    /// Positions whose ambiguities are resolved.
    Fixed,
}

impl Gnss {
    /// What a careful user can know of it.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.005,
            "fixed_tolerance_m": 0.04, "floating_tolerance_m": 1.0,
        }))
    }
}

impl Default for Gnss {
    /// Ten positions in a second by real-time kinematics, the antenna in the middle of the robot, 0.4 m above the floor.
    fn default() -> Self {
        Gnss {
            period_s: 0.1,
            latency_s: 0.05,
            latency_tolerance_s: 0.01,
            stamp_tolerance_s: 0.0001,
            forward_m: 0.0,
            left_m: 0.0,
            height_m: 0.4,
            position_tolerance_m: 0.001,
            fixed_tolerance_m: 0.01,
            floating_tolerance_m: 0.5,
            outages: Vec::new(),
            shadows: Vec::new(),
        }
    }
}
