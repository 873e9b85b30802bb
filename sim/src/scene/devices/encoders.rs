//! Encoders of the wheels.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Wheel encoders.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Encoders {
    /// Ticks in one turn of the wheel.
    #[schemars(range(min = 10, max = 10000000))]
    pub ticks_per_turn: u32,
    /// Time between two readings, a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
}

impl Default for Encoders {
    fn default() -> Self {
        // P3-DX: 500 counts a motor turn through a gear of 38.3.
        Encoders { ticks_per_turn: 19_150, period_s: 0.01 }
    }
}
