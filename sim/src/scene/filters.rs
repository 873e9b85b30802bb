//! Noise settings of the built-in filters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Noise settings of the built-in filters, where a scene wants others than the usual ones: a third of each declared bound is taken for a standard
/// deviation. The interval localizer does not read them.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Filters {
    /// Settings of the extended Kalman filter, `--subject ekf`.
    pub ekf: FilterNoise,
    /// Settings of the particle filter, `--subject particles`.
    pub particles: FilterNoise,
}

impl Filters {
    /// Whether no factor is other than the usual one.
    pub(crate) fn is_usual(&self) -> bool {
        *self == Filters::default()
    }
}

/// Least and greatest factor on a filter's standard deviations.
pub(crate) const FACTORS: [f64; 2] = [0.001, 1000.0];

/// Factors on a filter's standard deviations. The option `--subject` may state others, as in `--subject ekf,motion=2`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilterNoise {
    /// Factor for all errors of wheels, gyroscope and flow sensor: their noise, their slip, and the errors of their constants.
    #[schemars(range(min = FACTORS[0], max = FACTORS[1]))]
    pub motion: f64,
    /// Factor for the noise of all other measurements. The errors of mounts, scales and floor plan, which last, are not multiplied.
    #[schemars(range(min = FACTORS[0], max = FACTORS[1]))]
    pub cues: f64,
}

impl Default for FilterNoise {
    fn default() -> Self {
        FilterNoise { motion: 1.0, cues: 1.0 }
    }
}
