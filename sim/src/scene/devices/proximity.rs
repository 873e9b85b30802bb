//! Keys of the rangefinders that detect what is in the robot's way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A fan of rangefinders in a horizontal plane, such as the scanner of a vacuum cleaner or a forklift. The beams leave from above the robot's origin.
/// The program that drives the robot to its goals gets the readings, the localizer does not.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Proximity {
    /// Angle that the fan of rangefinder beams covers, half of it to either side of robot forward.
    #[schemars(range(min = 1.0, max = 360.0))]
    pub field_deg: f64,
    /// Number of rangefinder beams in the fan. The outermost ones lie at the fan's edges.
    #[schemars(range(min = 2, max = 2000))]
    pub beams: usize,
    /// Range of the beams. Things farther away are not noticed.
    #[schemars(range(min = 0.1, max = 50.0))]
    pub range_m: f64,
    /// Height of the fan above the floor. Things lower than this are not noticed.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub height_m: f64,
    /// Time between two readings.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub period_s: f64,
    /// Greatest error of a measured distance, drawn at random for each beam.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub tolerance_m: f64,
}

impl Default for Proximity {
    /// The values of a small scanner for service robots: 240 degrees in steps of 3.
    fn default() -> Self {
        Proximity { field_deg: 240.0, beams: 81, range_m: 2.5, height_m: 0.2, period_s: 0.05, tolerance_m: 0.01 }
    }
}
