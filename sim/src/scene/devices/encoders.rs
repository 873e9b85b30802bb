//! Keys of the wheel encoders.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Encoders of the wheels.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Encoders {
    /// Number of encoder ticks in one turn of a wheel.
    #[schemars(range(min = 10, max = 10000000))]
    pub ticks_per_turn: u32,
    /// Time between two readings of the encoders; a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
}

impl Default for Encoders {
    fn default() -> Self {
        // The P3-DX has 500 counts per turn of the motor, and a gear that reduces by 38.3.
        Encoders { ticks_per_turn: 19_150, period_s: 0.01 }
    }
}
