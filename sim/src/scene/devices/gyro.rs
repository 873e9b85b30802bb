//! Keys of the gyroscope, with the tolerances of its errors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A gyroscope about the vertical: `read = scale·true + bias + noise`. Its Allan deviation consists of three terms (IEEE Std 952, annex C), each
/// truncated at a declared bound: angle random walk, bias instability and rate random walk.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Gyro {
    /// Bound `gyro.bias`: greatest bias of the gyroscope. The bias is drawn at random within this and never wanders beyond it.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub bias_tolerance_deg_per_s: f64,
    /// Greatest error of the gyroscope's scale factor, whose nominal value is 1; drawn at random once for a run.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub scale_tolerance: f64,
    /// Bound `gyro.noise`: greatest noise of one reading of the gyroscope. The noise is normally distributed.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub noise_deg_per_s: f64,
    /// Whether noise beyond `noise_deg_per_s`, or beyond the bound `gyro.angle`, is drawn again. If not, these bounds hold except by bad luck, and a
    /// run with such bad luck has a broken bound.
    pub noise_redrawn: bool,
    /// Angle random walk N, which is white noise of the rate. Unless stated, one reading's standard deviation is a third of `noise_deg_per_s`.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub angle_random_walk_deg_per_sqrt_h: Option<f64>,
    /// Bound `gyro.angle`: greatest angle that the gyroscope's noise and the change of its bias since the start add up to over any span of time. It
    /// is this angle plus `angle_deg_per_s` times the length of the span. Noise that would make it more is drawn again, unless `noise_redrawn` is
    /// false. If no angle is stated, only single readings are bounded.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub angle_floor_deg: Option<f64>,
    /// Growth of the bound `gyro.angle` with the length of the time span: the bound is `angle_floor_deg` plus this times the length.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub angle_deg_per_s: f64,
    /// Bias instability B of the gyroscope: flicker noise with correlation times from 1 s to 1 h.
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub bias_instability_deg_per_h: f64,
    /// Rate random walk K of the gyroscope's bias.
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub rate_random_walk_deg_per_h_per_sqrt_h: f64,
    /// Bound `gyro.wander`: greatest rate at which the gyroscope's bias changes. A faster change is cut off.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub bias_wander_deg_per_s2: f64,
    /// Time between two readings of the gyroscope, each of which is the mean over this time; a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
}

impl Gyro {
    /// Standard deviation of one reading's noise for a given angle random walk: N/√T for the mean over a period T.
    pub(crate) fn deviation_deg_per_s(&self, walk_deg_per_sqrt_h: f64) -> f64 {
        walk_deg_per_sqrt_h / 60.0 / self.period_s.sqrt()
    }
}

impl Default for Gyro {
    /// A good gyroscope, calibrated at rest: bias within 0.02 °/s, noise of 0.0007 °/s/√Hz at 200 Hz.
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
    /// Bounds on the gyroscope that a careful user can know from a data sheet and an afternoon of measuring.
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
