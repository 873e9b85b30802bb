//! Declared bounds of quantities that come out of the physics.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the localizer is told about quantities that nobody draws.
///
/// The defaults hold for the P3-DX on tiles with friction 0.8. They are the greatest values of 18 tuning drives of 180 s (52 m each;
/// 12 uniform seeds, 6 with every error in a corner) with half as much again, and frozen since: side slip fitted 0.18 % + 0.02 mm,
/// tilt 0.022°, wheel acceleration 0.71 m/s², heave below 1 µm. `wheels.slip` is stated by the experiment (0.5 % + 0.1 mm a window)
/// and was used to 60 %. Reach is wider, since it must hold under a push.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Bounds {
    /// `wheels.slip`: |true travel − rolled| ≤ this share of |rolled| + floor, per wheel and window.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_ratio: f64,
    /// Additive part of `wheels.slip`, once per window.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_floor_m: f64,
    /// `wheels.side_slip`: |lateral travel of the axle middle| ≤ this share of |rolled| + floor, per window.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub side_slip_ratio: f64,
    /// Additive part of `wheels.side_slip`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub side_slip_floor_m: f64,
    /// Window of both slip bounds.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub slip_window_s: f64,
    /// `reach.speed`: no motion is faster, pushes included.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_speed_m_per_s: f64,
    /// `reach.turn_rate`: no motion turns faster, pushes included.
    #[schemars(range(max = 50.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_turn_rate_rad_per_s: f64,
    /// `reach.acceleration`: no wheel accelerates harder while the wheel bounds hold.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_acceleration_m_per_s2: f64,
    /// `wheels.rest`: from half a second after the encoders' last count until the next one, the body turns by at most this. Unless
    /// stated, a gyroscope learns nothing at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 360.0))]
    pub rest_turn_deg: Option<f64>,
    /// `body.tilt`: angle of the body's vertical to the floor's.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub body_tilt_deg: f64,
    /// `body.heave`: rise or sink of the robot origin from rest.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub body_heave_m: f64,
}

impl Default for Bounds {
    fn default() -> Self {
        Bounds {
            slip_ratio: 0.005,
            slip_floor_m: 0.0001,
            side_slip_ratio: 0.003,
            side_slip_floor_m: 0.00005,
            slip_window_s: 0.2,
            reach_speed_m_per_s: 0.7,
            reach_turn_rate_rad_per_s: 1.6,
            reach_acceleration_m_per_s2: 1.2,
            rest_turn_deg: None,
            body_tilt_deg: 0.035,
            body_heave_m: 0.00001,
        }
    }
}
