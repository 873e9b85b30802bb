//! Declared bounds on quantities that emerge from the simulated physics.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declared bounds on quantities that no seed draws, as the localizer is given them.
///
/// The defaults hold for the P3-DX on tiles with friction 0.8. They are the greatest values of 18 tuning drives of 180 s (52 m each; 12 seeds with
/// uniformly distributed errors, 6 with every error at an end of its tolerance), enlarged by half and fixed after that: side slip fitted 0.18 % +
/// 0.02 mm, tilt 0.022°, wheel acceleration 0.71 m/s², heave below 1 µm. `wheels.slip` is set by the experiment (0.5 % + 0.1 mm per window); the
/// drives used 60 % of it. The bounds `reach` are wider, since they must hold under a push.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Bounds {
    /// Bound `wheels.slip`, part proportional to the distance. For each wheel and window: |true travel − rolled distance| ≤ this share of |rolled
    /// distance| + `slip_floor_m`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_ratio: f64,
    /// Constant part of the bound `wheels.slip`, once per window.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_floor_m: f64,
    /// Bound `wheels.side_slip`, part proportional to the distance. For each window: |sideways travel of the axle's middle| ≤ this share of |rolled
    /// distance| + `side_slip_floor_m`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub side_slip_ratio: f64,
    /// Constant part of the bound `wheels.side_slip`, once per window.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub side_slip_floor_m: f64,
    /// Length of the time window of the bounds `wheels.slip` and `wheels.side_slip`.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub slip_window_s: f64,
    /// Bound `reach.speed`: greatest speed of the robot, pushes included.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_speed_m_per_s: f64,
    /// Bound `reach.turn_rate`: greatest turn rate of the robot, pushes included.
    #[schemars(range(max = 50.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_turn_rate_rad_per_s: f64,
    /// Bound `reach.acceleration`: greatest acceleration of any wheel while the bounds on the wheels hold.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_acceleration_m_per_s2: f64,
    /// Bound `wheels.rest`: greatest turn of the body from half a second after the encoders' last count until their next one. Unless stated, a
    /// gyroscope learns nothing while the robot rests.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 360.0))]
    pub rest_turn_deg: Option<f64>,
    /// Bound `body.tilt`: greatest angle of the body's vertical to the floor's.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub body_tilt_deg: f64,
    /// Bound `body.heave`: greatest rise or sinking of the robot's origin from its height at rest.
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
