//! The camera that looks ahead.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Band, Calibration, CameraTiming, Careful, LensKeys};
use crate::scene::{Sensor, SensorModel, SensorPreset};

/// A camera that looks forward over the robot's head, tilted up. Image right is robot right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ForwardCamera {
    /// Image width.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Image height.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Angle of view from the left to the right edge of the image, before distortion.
    #[schemars(range(min = 10.0, max = 140.0))]
    pub horizontal_view_deg: f64,
    /// Upward tilt of the optical axis; 8.7 as in paper 2.
    #[schemars(range(min = -80.0, max = 80.0))]
    pub tilt_up_deg: f64,
    /// Direction of the optical axis from robot forward, counter-clockwise.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub yaw_deg: f64,
    /// Optical centre in the robot frame, forward of the axle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Optical centre in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
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
    /// What it sees.
    pub band: Band,
    /// Radiant intensity of a ring of diodes around the lens along the optical axis, at 850 nm; 0 for none. It falls with the cosine of
    /// the angle off the axis. Only with `band = "infrared"` is it seen.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub ring_intensity_w_per_sr: f64,
    /// What the lens does besides projecting.
    pub lens: LensKeys,
    /// What turns light into grey levels.
    pub sensor: Sensor,
    /// Longest exposure while the gyroscope tells of a turn faster than 0.1 rad/s, which blurs; as otherwise unless stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.00001, max = 1.0))]
    pub turning_exposure_s: Option<f64>,
    /// How far mount and lens may be from what these keys state.
    pub calibration: Calibration,
}

impl ForwardCamera {
    /// Its sensor, nothing left open.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::RobotVacuum)
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

impl Default for ForwardCamera {
    fn default() -> Self {
        ForwardCamera {
            width_px: 640,
            height_px: 480,
            horizontal_view_deg: 75.0,
            tilt_up_deg: 8.7,
            yaw_deg: 0.0,
            forward_m: 0.12,
            left_m: 0.0,
            height_m: 0.25,
            period_s: 0.1,
            latency_s: 0.03,
            latency_tolerance_s: 0.002,
            stamp_tolerance_s: 0.0001,
            band: Band::Visible,
            ring_intensity_w_per_sr: 0.0,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            turning_exposure_s: None,
            calibration: Calibration::default(),
        }
    }
}

impl ForwardCamera {
    /// What a careful user can know of it.
    pub(super) fn careful() -> Careful {
        // A camera of a home robot hangs on USB and is stamped by who reads it.
        Careful::each(
            json!({ "stamp_tolerance_s": 0.02, "latency_tolerance_s": 0.01, "calibration": Calibration::careful() }),
        )
    }
}
