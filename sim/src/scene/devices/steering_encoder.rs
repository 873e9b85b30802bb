//! Keys of a car's steering encoder, with the bounds on the car's steering.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// An absolute encoder of a car's steering angle, which is that of a wheel in the middle of the front axle:
/// `read = round((scale·angle + zero)·ticks_per_turn/360°)`. With it the localizer knows the car's turn without the difference of the rear wheels.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SteeringEncoder {
    /// Number of the steering encoder's ticks in one turn.
    #[schemars(range(min = 100, max = 10000000))]
    pub ticks_per_turn: u32,
    /// Time between two readings of the steering encoder; a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
    /// Bound `steering_encoder.zero`: greatest steering angle that the encoder reads when the car is steered straight ahead; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub zero_tolerance_deg: f64,
    /// Angle by which the encoder's zero is displaced, in addition to its random error, as after the wheels have hit a kerb. The localizer is not
    /// given it.
    #[schemars(range(min = -30.0, max = 30.0))]
    pub zero_shift_deg: f64,
    /// Bound `steering_encoder.scale`: greatest error of the encoder's scale factor, whose nominal value is 1; drawn at random.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub scale_tolerance: f64,
    /// Bound `wheels.steering_rate`: greatest rate of the steering angle. Between two readings the angle is known by it alone.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub rate_deg_per_s: f64,
    /// Bound `wheels.steering_slip` on how far the tyres' sideways slip turns the car, part proportional to the turn. In a time window of
    /// `bounds.slip_window_s`, |turn − turn by steering angle and travel| ≤ this share of |turn by steering angle and travel| + `slip_deg_per_m` of what
    /// the rear wheels roll + `slip_floor_deg`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_share: f64,
    /// Part of the bound `wheels.steering_slip` that is proportional to the distance, as rear wheels of different radii turn a car that is steered
    /// straight ahead.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub slip_deg_per_m: f64,
    /// Constant part of the bound `wheels.steering_slip` in a time window of `bounds.slip_window_s`.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub slip_floor_deg: f64,
}

impl Default for SteeringEncoder {
    /// A magnetic encoder of 14 bits, calibrated by driving straight ahead along a wall. The bounds on the slip are those of the car of half a
    /// metre that is the default.
    fn default() -> Self {
        SteeringEncoder {
            ticks_per_turn: 16_384,
            period_s: 0.01,
            zero_tolerance_deg: 0.1,
            zero_shift_deg: 0.0,
            scale_tolerance: 0.002,
            rate_deg_per_s: 90.0,
            slip_share: 0.015,
            slip_deg_per_m: 0.21,
            slip_floor_deg: 0.025,
        }
    }
}

impl SteeringEncoder {
    /// Bounds on the steering encoder that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({ "zero_tolerance_deg": 0.25, "scale_tolerance": 0.01 }))
    }
}
