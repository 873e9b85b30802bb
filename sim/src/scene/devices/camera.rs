//! What cameras have in common: their lenses, how well they are calibrated, when they expose and deliver.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{CeilingCamera, FloorCamera, ForwardCamera};
use crate::scene::Robot;

impl Robot {
    /// The cameras that it has, in the order of [`Camera::ALL`].
    pub fn cameras(&self) -> Vec<Camera> {
        Camera::ALL.into_iter().filter(|camera| self.camera_timing(*camera).is_some()).collect()
    }

    /// When one of its cameras exposes, stamps and delivers; `None` if it has no such camera.
    pub fn camera_timing(&self, camera: Camera) -> Option<CameraTiming> {
        match camera {
            Camera::Floor => self.floor_camera.as_ref().map(FloorCamera::timing),
            Camera::Forward => self.forward_camera.as_ref().map(ForwardCamera::timing),
            Camera::Ceiling => self.ceiling_camera.as_ref().map(CeilingCamera::timing),
        }
    }
}

/// Filters before a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// 400 to 700 nm.
    Visible,
    /// 800 to 900 nm.
    Infrared,
}

/// What a lens does besides projecting, and how its sensor is read out.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LensKeys {
    /// Brown and Conrady's coefficients k1, k2, p1, p2, k3, in the order of OpenCV.
    #[schemars(inner(range(min = -2.0, max = 2.0)))]
    pub distortion: [f64; 5],
    /// Whether the image falls off from its middle by the fourth power of the cosine. Where nothing is stated, forward and ceiling cameras
    /// do so and the floor camera does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vignetting: Option<bool>,
    /// Diameter of the disc into which a point is blurred.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub defocus_px: f64,
    /// From the start of one row's exposure to that of the next; 0 for a global shutter.
    #[schemars(range(min = 0.0, max = 0.001))]
    pub row_time_s: f64,
}

/// Tolerances of a camera's calibration. Each seed draws within them, by the robot's `errors`.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Calibration {
    /// The optical centre, along each axis of the robot frame.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// The attitude: as much by a tilt about any level axis, and as much by a turn about the vertical.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub angle_tolerance_deg: f64,
    /// Both focal lengths alike, as a share.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub focal_tolerance: f64,
    /// The principal point, along u and v.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub principal_point_tolerance_px: f64,
    /// Anywhere in the image, the place of a pixel by the lens's coefficients: the true k1 is another.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub distortion_tolerance_px: f64,
}

/// When a camera exposes, stamps and delivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraTiming {
    /// Time between two images.
    pub period_s: f64,
    /// Mid-exposure to delivery.
    pub latency_s: f64,
    /// Each delivery is within this of the latency.
    pub latency_tolerance_s: f64,
    /// Each stamp is within this of the true middle of the exposure.
    pub stamp_tolerance_s: f64,
    /// Longest time from the start of the first row's exposure to the end of the last row's.
    pub longest_s: f64,
}

impl CameraTiming {
    /// Latest time after the start at which the first image has arrived.
    pub fn first_arrival_s(&self) -> f64 {
        self.longest_s + self.latency_s + self.latency_tolerance_s
    }
}

impl Default for LensKeys {
    fn default() -> Self {
        LensKeys { distortion: [0.0; 5], vignetting: None, defocus_px: 0.0, row_time_s: 0.0 }
    }
}

impl Default for Calibration {
    fn default() -> Self {
        Calibration {
            position_tolerance_m: 0.0005,
            angle_tolerance_deg: 0.1,
            focal_tolerance: 0.001,
            principal_point_tolerance_px: 0.5,
            distortion_tolerance_px: 0.0,
        }
    }
}

impl Calibration {
    /// What a careful user can know of one.
    pub(super) fn careful() -> Value {
        json!({
            "position_tolerance_m": 0.002, "angle_tolerance_deg": 0.3, "focal_tolerance": 0.003,
            "principal_point_tolerance_px": 3.0, "distortion_tolerance_px": 0.3,
        })
    }
}
