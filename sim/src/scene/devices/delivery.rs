//! How readings of what moves the robot reach the localizer.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How readings of wheels, gyroscope and flow sensor reach the localizer: at once and each once, unless stated otherwise.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Delivery {
    /// `base.stamp`: the board that reads wheels, gyroscope and flow sensor has a clock of its own, whose stamps are all off by the same,
    /// drawn within this. Its readings are sent so much after they were taken.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// Each reading arrives later than its stamp by anything up to this, so that one may overtake another.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub late_s: f64,
    /// Share of the readings that never arrive.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub dropped_share: f64,
    /// Share of the readings that arrive twice, the second time late as well.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub duplicated_share: f64,
}

impl Delivery {
    /// Whether anything can happen to a reading.
    pub fn is_perfect(&self) -> bool {
        self.late_s == 0.0 && self.dropped_share == 0.0 && self.duplicated_share == 0.0
    }
}
