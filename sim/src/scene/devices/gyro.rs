//! The gyroscope, with the tolerance of its errors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A gyroscope about the vertical: `read = scale·true + bias + noise`. Its Allan deviation is made of three terms (IEEE Std 952, annex C):
/// angle random walk, bias instability and rate random walk, each truncated to a declared bound.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Gyro {
    /// `gyro.bias`: the bias is drawn within this, and never wanders beyond it.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub bias_tolerance_deg_per_s: f64,
    /// The scale is drawn within this share of 1, once for a run.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub scale_tolerance: f64,
    /// `gyro.noise`: bound of one reading's noise, which is normal.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub noise_deg_per_s: f64,
    /// Whether noise beyond this bound, or beyond `gyro.angle`, is drawn again. If not, the bounds hold but for bad luck, and a run without
    /// it has a broken bound.
    pub noise_redrawn: bool,
    /// Angle random walk N, white noise of the rate; unless stated a third of the bound is one reading's standard deviation.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub angle_random_walk_deg_per_sqrt_h: Option<f64>,
    /// `gyro.angle`: over any span, noise and what the bias has departed from its first value by add up to at most this and
    /// `angle_deg_per_s` times the span; noise is drawn again where it would be more. Unless stated, every reading alone is bounded.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub angle_floor_deg: Option<f64>,
    /// What that grows by.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub angle_deg_per_s: f64,
    /// Bias instability B, flicker noise of correlation times from 1 s to 1 h.
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub bias_instability_deg_per_h: f64,
    /// Rate random walk K.
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub rate_random_walk_deg_per_h_per_sqrt_h: f64,
    /// `gyro.wander`: the bias changes by at most this per time; whatever would be more is cut off.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub bias_wander_deg_per_s2: f64,
    /// Time between two readings, over which each averages; a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
}

impl Gyro {
    /// Standard deviation of one reading's noise for an angle random walk: N/√T for the mean over a period T.
    pub(crate) fn deviation_deg_per_s(&self, walk_deg_per_sqrt_h: f64) -> f64 {
        walk_deg_per_sqrt_h / 60.0 / self.period_s.sqrt()
    }
}

impl Default for Gyro {
    /// A good gyroscope, calibrated at rest: bias within 0.02 °/s, 0.0007 °/s/√Hz at 200 Hz.
    fn default() -> Self {
        Gyro {
            bias_tolerance_deg_per_s: 0.02,
            scale_tolerance: 0.002,
            noise_deg_per_s: 0.03,
            noise_redrawn: true,
            angle_random_walk_deg_per_sqrt_h: None,
            angle_floor_deg: None,
            angle_deg_per_s: 0.0,
            bias_instability_deg_per_h: 0.0,
            rate_random_walk_deg_per_h_per_sqrt_h: 0.0,
            bias_wander_deg_per_s2: 0.0,
            period_s: 0.005,
        }
    }
}

impl Gyro {
    /// What a careful user can know of it.
    pub(super) fn careful() -> Careful {
        Careful {
            keys: json!({
                "bias_tolerance_deg_per_s": 0.1, "scale_tolerance": 0.01, "noise_deg_per_s": 0.6, "noise_redrawn": false,
                "angle_random_walk_deg_per_sqrt_h": 0.3, "angle_floor_deg": 0.06, "angle_deg_per_s": 0.015,
                "rate_random_walk_deg_per_h_per_sqrt_h": 6.0, "bias_wander_deg_per_s2": 0.0005,
            }),
            together: &[
                "noise_deg_per_s",
                "noise_redrawn",
                "angle_random_walk_deg_per_sqrt_h",
                "angle_floor_deg",
                "angle_deg_per_s",
                "bias_wander_deg_per_s2",
                "rate_random_walk_deg_per_h_per_sqrt_h",
            ],
        }
    }
}
