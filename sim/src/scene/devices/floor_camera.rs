//! Keys of the camera that looks straight down.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{CameraTiming, Careful, LensKeys};
use crate::scene::{Sensor, SensorModel, SensorPreset};

/// A global-shutter camera that looks straight down. The top of the image is towards the robot's front, the right side of the image towards the
/// robot's right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloorCamera {
    /// Width of the camera's image.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Height of the camera's image.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Width of the area of floor that the image shows.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub footprint_width_m: f64,
    /// Height of the camera's optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Distance of the camera's optical centre forward of the wheel axle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the camera's optical centre to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Time between two images.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub period_s: f64,
    /// Time from the middle of an exposure to the delivery of its image.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Greatest difference of an image's actual latency from `latency_s`, drawn at random for each image.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// Greatest error of an image's stamp against the true middle of the exposure, drawn at random for each image.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// Greatest error of the floor camera's mounted position, forward and left each; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Greatest error of the floor camera's yaw on its mount; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// Greatest angle of the floor camera's optical axis to the body's vertical, in any direction; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tilt_tolerance_deg: f64,
    /// Greatest error of the floor image's pixels per metre, as a share of their nominal number; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub scale_tolerance: f64,
    /// Greatest error, anywhere in the image, of the position at which the stated distortion coefficients put a pixel. The true coefficient k1 is
    /// drawn at random within this.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub distortion_tolerance_px: f64,
    /// Distortion, vignetting and defocus of the lens, and the time in which the rows of the sensor are read out.
    pub lens: LensKeys,
    /// Image sensor of the camera, which turns light into grey levels.
    pub sensor: Sensor,
    /// Greatest number of lines seen in one floor image that the localizer assumes not to be joints of the tile grid.
    #[schemars(range(min = 0, max = 20))]
    pub q_items: usize,
}

impl FloorCamera {
    /// Model of the camera's image sensor, with the values of its preset filled in.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::GlobalShutter)
    }

    /// Times at which the camera exposes, stamps and delivers images.
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
    /// Bounds on the floor camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3, "tilt_tolerance_deg": 0.3,
            "scale_tolerance": 0.003, "distortion_tolerance_px": 0.3,
        }))
    }
}
