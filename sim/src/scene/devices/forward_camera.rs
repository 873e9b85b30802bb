//! Keys of the camera that looks ahead.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Band, Calibration, CameraTiming, Careful, LensKeys};
use crate::scene::{Sensor, SensorModel, SensorPreset};

/// A camera that looks forward over the robot's head, tilted up. The right side of the image is towards the robot's right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ForwardCamera {
    /// Width of the camera's image.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Height of the camera's image.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Angle of view from the left to the right edge of the image, without distortion.
    #[schemars(range(min = 10.0, max = 140.0))]
    pub horizontal_view_deg: f64,
    /// Upward tilt of the camera's optical axis; 8.7 in paper 2.
    #[schemars(range(min = -80.0, max = 80.0))]
    pub tilt_up_deg: f64,
    /// Direction of the camera's optical axis, counter-clockwise from robot forward.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub yaw_deg: f64,
    /// Distance of the camera's optical centre forward of the wheel axle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the camera's optical centre to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the camera's optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
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
    /// Band of wavelengths that the camera sees.
    pub band: Band,
    /// Radiant intensity, along the optical axis and at 850 nm, of a ring of diodes around the lens; 0 for no ring. The intensity falls with the
    /// cosine of the angle off the axis. The camera sees the ring's light only with `band = "infrared"`.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub ring_intensity_w_per_sr: f64,
    /// Distortion, vignetting and defocus of the lens, and the time in which the rows of the sensor are read out.
    pub lens: LensKeys,
    /// Image sensor of the camera, which turns light into grey levels.
    pub sensor: Sensor,
    /// Longest exposure of an image that is taken while the gyroscope reads a turn faster than 0.1 rad/s, as turns blur the image. Unless stated,
    /// turns do not shorten exposures.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.00001, max = 1.0))]
    pub turning_exposure_s: Option<f64>,
    /// Tolerances of the camera's calibration: how far its mount and lens may be from the stated values. Each seed draws errors within them,
    /// distributed as the robot's key `errors` states.
    pub calibration: Calibration,
}

impl ForwardCamera {
    /// Model of the camera's image sensor, with the values of its preset filled in.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::RobotVacuum)
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
    /// Bounds on the forward camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        // The camera of a home robot is connected by USB, and its images are stamped by the program that reads them.
        Careful::each(
            json!({ "stamp_tolerance_s": 0.02, "latency_tolerance_s": 0.01, "calibration": Calibration::careful() }),
        )
    }
}
