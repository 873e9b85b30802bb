//! Keys of a receiver of satellite navigation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A receiver of satellite navigation that uses correction data. It reports the position of its antenna in the world frame, and the quality of that
/// position.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Gnss {
    /// Time between two positions.
    #[schemars(range(min = 0.01, max = 10.0))]
    pub period_s: f64,
    /// Time from the measurement of the antenna's position to its delivery.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Greatest difference of a reported position's actual latency from `latency_s`, drawn at random for each position.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// Bound `gnss.stamp`: greatest error of a reported position's stamp against the true time, drawn at random for each position.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// Distance of the antenna forward of the wheel axle, in the robot frame: its lever arm.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the antenna to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the antenna above the floor. Where the body leans, the antenna moves sideways by this height times the sine of the lean.
    #[schemars(range(min = 0.0, max = 3.0))]
    pub height_m: f64,
    /// Bound `gnss.antenna`: greatest error of the antenna's mounted position, forward and left each; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Bound `gnss.fixed`: greatest error, in x and y each, of a reported position whose carrier phase ambiguities are resolved.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub fixed_tolerance_m: f64,
    /// Bound `gnss.floating`: greatest error, in x and y each, of a reported position whose carrier phase ambiguities are not resolved.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub floating_tolerance_m: f64,
    /// Periods in which satellite positions have less than the quality `fixed` (carrier phase ambiguities resolved), or are missing.
    pub outages: Vec<Outage>,
    /// Areas in which satellite positions have less than the quality `fixed` or are missing, as under trees, beside walls or in a barn. Where several
    /// outages and shadows apply at once, the worst quality counts.
    pub shadows: Vec<Shadow>,
}

/// A period in which satellite positions have less than the quality `fixed` (carrier phase ambiguities resolved), or are missing.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Outage {
    /// Time at which the period with worse or missing satellite positions begins.
    #[schemars(range(min = 0.0, max = 36000.0))]
    pub at_s: f64,
    /// Duration of the period with worse or missing satellite positions.
    #[schemars(range(min = 0.02, max = 36000.0))]
    pub lasts_s: f64,
    /// Quality of the satellite positions that are reported during the outage.
    #[serde(default)]
    pub leaves: Reception,
}

/// A rectangle along the world's axes in which satellite positions have less than the quality `fixed` (carrier phase ambiguities resolved), or are
/// missing.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shadow {
    /// World x of the middle of the rectangle in which satellite positions are worse or missing.
    pub x_m: f64,
    /// World y of the middle of the rectangle in which satellite positions are worse or missing.
    pub y_m: f64,
    /// Lengths, along world x and world y, of the rectangle in which satellite positions are worse or missing.
    #[schemars(inner(range(min = 0.1, max = 200.0)))]
    pub size_m: [f64; 2],
    /// Quality of the satellite positions that are reported in the rectangle.
    #[serde(default)]
    pub leaves: Reception,
}

/// Quality of satellite positions, from the worst to the best.
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
    /// Bounds on the satellite navigation receiver that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.005,
            "fixed_tolerance_m": 0.04, "floating_tolerance_m": 1.0,
        }))
    }
}

impl Default for Gnss {
    /// Ten positions per second by real-time kinematics, with the antenna in the middle of the robot, 0.4 m above the floor.
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
