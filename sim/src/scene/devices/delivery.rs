//! Keys for how readings of wheels, gyroscope, flow sensor and steering encoder reach the localizer.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How readings of wheels, gyroscope, flow sensor and steering encoder reach the localizer: at once and each exactly once, unless stated otherwise.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Delivery {
    /// Bound `base.stamp`: greatest error of the clock of the board that reads wheels, gyroscope, flow sensor and steering encoder. All its stamps
    /// in a run are off by the same error, drawn at random. It sends each reading later than it was taken, by this tolerance, so that none arrives
    /// before its stamp.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// Greatest delay of a reading after its stamp, drawn at random for each, so that one reading may overtake another.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub late_s: f64,
    /// Share of the readings that never arrive.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub dropped_share: f64,
    /// Share of the readings that arrive twice. The second copy is late as well.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub duplicated_share: f64,
}

impl Delivery {
    /// Whether every reading arrives at once and exactly once.
    pub fn is_perfect(&self) -> bool {
        self.late_s == 0.0 && self.dropped_share == 0.0 && self.duplicated_share == 0.0
    }
}
