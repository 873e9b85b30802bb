//! Rangefinders that look out for what is in the way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A fan of rangefinders in the plane, such as a vacuum cleaner's or a forklift's scanner. Its beams leave from above the robot's
/// origin; the driver of errands gets them, the localizer does not.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Proximity {
    /// Angle of the fan, half of it to either side of robot forward.
    #[schemars(range(min = 1.0, max = 360.0))]
    pub field_deg: f64,
    /// Number of beams, the outermost at the edges of the field.
    #[schemars(range(min = 2, max = 2000))]
    pub beams: usize,
    /// What is farther off is not noticed.
    #[schemars(range(min = 0.1, max = 50.0))]
    pub range_m: f64,
    /// Height of the fan above the floor; lower things are not noticed.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub height_m: f64,
    /// Time between two readings.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub period_s: f64,
    /// Each distance is drawn within this of the true one.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub tolerance_m: f64,
}

impl Default for Proximity {
    /// As a small scanner for service robots: 240 degrees in steps of 3.
    fn default() -> Self {
        Proximity { field_deg: 240.0, beams: 81, range_m: 2.5, height_m: 0.2, period_s: 0.05, tolerance_m: 0.01 }
    }
}
