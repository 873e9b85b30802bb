//! The camera that looks straight down.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{CameraTiming, Careful, LensKeys};
use crate::scene::{Sensor, SensorModel, SensorPreset};

/// A global-shutter camera that looks straight down. Image up is robot forward, image right is robot right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloorCamera {
    /// Image width.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Image height.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Width of the floor that the image shows.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub footprint_width_m: f64,
    /// Height of the optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Optical centre in the robot frame, forward of the axle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Optical centre in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Time between two images.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub period_s: f64,
    /// Mid-exposure to delivery.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Each delivery is drawn within this of the latency.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// Each stamp is drawn within this of the true middle of the exposure.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// The mount is drawn within this of its nominal place, forward and left each.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// The mount's yaw is drawn within this.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// The angle of the optical axis to the body's vertical is drawn within this, in any direction.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tilt_tolerance_deg: f64,
    /// Pixels per metre are drawn within this share of nominal.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub scale_tolerance: f64,
    /// Anywhere in the image, the place of a pixel by the lens's coefficients is within this: the true k1 is drawn.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub distortion_tolerance_px: f64,
    /// What the lens does besides projecting.
    pub lens: LensKeys,
    /// What turns light into grey levels.
    pub sensor: Sensor,
    /// At most this many wrong lines are assumed in one image.
    #[schemars(range(min = 0, max = 20))]
    pub q_items: usize,
}

impl FloorCamera {
    /// Its sensor, nothing left open.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::GlobalShutter)
    }

    /// When it exposes, stamps and delivers.
    pub fn timing(&self) -> CameraTiming {
        CameraTiming {
            period_s: self.period_s,
            latency_s: self.latency_s,
            latency_tolerance_s: self.latency_tolerance_s,
            stamp_tolerance_s: self.stamp_tolerance_s,
            longest_s: self.sensor_model().longest_exposure_s + self.lens.row_time_s * f64::from(self.height_px - 1),
        }
    }
}

impl Default for FloorCamera {
    fn default() -> Self {
        FloorCamera {
            width_px: 640,
            height_px: 480,
            footprint_width_m: 0.48,
            height_m: 0.25,
            forward_m: -0.15,
            left_m: 0.0,
            period_s: 0.2,
            latency_s: 0.030,
            latency_tolerance_s: 0.002,
            stamp_tolerance_s: 0.0001,
            position_tolerance_m: 0.0005,
            yaw_tolerance_deg: 0.1,
            tilt_tolerance_deg: 0.1,
            scale_tolerance: 0.001,
            distortion_tolerance_px: 0.0,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            q_items: 0,
        }
    }
}

impl FloorCamera {
    /// What a careful user can know of it.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3, "tilt_tolerance_deg": 0.3,
            "scale_tolerance": 0.003, "distortion_tolerance_px": 0.3,
        }))
    }
}
