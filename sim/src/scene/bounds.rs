//! Declared bounds on quantities that emerge from the simulated physics.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declared bounds, given to the localizer, on quantities that come out of the simulated physics and are not drawn at random for a seed.
///
/// The defaults hold for the P3-DX on tiles with friction 0.8. They are the greatest values of 18 tuning drives of 180 s (52 m each; 12 seeds with
/// uniformly distributed errors, 6 with every error at an end of its tolerance), enlarged by half and fixed after that: side slip fitted 0.18 % +
/// 0.02 mm, tilt 0.022°, wheel acceleration 0.71 m/s², heave below 1 µm. `wheels.slip` is set by the experiment (0.5 % + 0.1 mm per time window); the
/// drives used 60 % of it. The bounds `reach` on the robot's speed, turn rate and acceleration are wider, since they must hold when it is pushed.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Bounds {
    /// Bound `wheels.slip` on the slip of each wheel, part proportional to the distance. In a time window of `slip_window_s`, |true travel of the
    /// wheel − distance it rolled| ≤ this share of |distance it rolled| + `slip_floor_m`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_ratio: f64,
    /// Constant part of the bound `wheels.slip` on the slip of each wheel in a time window of `slip_window_s`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub slip_floor_m: f64,
    /// Bound `wheels.side_slip` on the robot's slip sideways, part proportional to the distance. In a time window of `slip_window_s`, |sideways
    /// travel of the axle's middle| ≤ this share of |distance rolled| + `side_slip_floor_m`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub side_slip_ratio: f64,
    /// Constant part of the bound `wheels.side_slip` on the robot's slip sideways in a time window of `slip_window_s`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub side_slip_floor_m: f64,
    /// Length of the time windows for which the bounds `wheels.slip` and `wheels.side_slip` limit the slip.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub slip_window_s: f64,
    /// Bound `reach.speed`: greatest speed of the robot, also while it is pushed.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_speed_m_per_s: f64,
    /// Bound `reach.turn_rate`: greatest turn rate of the robot, also while it is pushed.
    #[schemars(range(max = 50.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_turn_rate_rad_per_s: f64,
    /// Bound `reach.acceleration`: greatest acceleration of the travel of either wheel. The localizer relies on it only together with the bounds on
    /// the wheels' slip.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub reach_acceleration_m_per_s2: f64,
    /// Bound `wheels.rest`: greatest turn of the robot's body while it rests, that is, from half a second after the encoders' last count until their
    /// next count. Unless stated, the localizer learns nothing about the gyroscope's errors while the robot rests.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 360.0))]
    pub rest_turn_deg: Option<f64>,
    /// Bound `body.tilt`: greatest angle between the vertical axis of the robot's body and the floor's vertical.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub body_tilt_deg: f64,
    /// Bound `body.heave`: greatest vertical displacement, up or down, of the robot frame's origin from its height at rest.
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
