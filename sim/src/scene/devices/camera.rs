//! Keys that cameras have in common: lens, calibration tolerances, and times of exposure and delivery.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{CeilingCamera, FloorCamera, ForwardCamera};
use crate::scene::Robot;

impl Robot {
    /// The robot's cameras, in the order of [`Camera::ALL`].
    pub fn cameras(&self) -> Vec<Camera> {
        Camera::ALL.into_iter().filter(|camera| self.camera_timing(*camera).is_some()).collect()
    }

    /// Times at which one of the robot's cameras exposes, stamps and delivers images; `None` if the robot does not have this camera.
    pub fn camera_timing(&self, camera: Camera) -> Option<CameraTiming> {
        match camera {
            Camera::Floor => self.floor_camera.as_ref().map(FloorCamera::timing),
            Camera::Forward => self.forward_camera.as_ref().map(ForwardCamera::timing),
            Camera::Ceiling => self.ceiling_camera.as_ref().map(CeilingCamera::timing),
        }
    }
}

/// Bands of wavelengths that pass the filter before a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// Visible light, 400 to 700 nm.
    Visible,
    /// Near infrared light, 800 to 900 nm.
    Infrared,
}

/// Distortion, vignetting and defocus of the lens, and the time in which the rows of the sensor are read out.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LensKeys {
    /// Distortion coefficients k1, k2, p1, p2, k3 of Brown and Conrady, in the order of OpenCV.
    #[schemars(inner(range(min = -2.0, max = 2.0)))]
    pub distortion: [f64; 5],
    /// Whether the image darkens away from its middle by the fourth power of the cosine of the angle off the optical axis. Unless stated, images of
    /// forward and ceiling cameras do and those of the floor camera do not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vignetting: Option<bool>,
    /// Diameter of the disc into which defocus blurs a point.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub defocus_px: f64,
    /// Time from the start of one row's exposure to the start of the next row's; 0 for a global shutter.
    #[schemars(range(min = 0.0, max = 0.001))]
    pub row_time_s: f64,
}

/// Tolerances of the camera's calibration: how far its mount and lens may be from the stated values. Each seed draws errors within them,
/// distributed as the robot's key `errors` states.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Calibration {
    /// Greatest error of the optical centre's position, along each axis of the robot frame.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Greatest error of the camera's attitude. The camera may be tilted by this about any level axis and, at the same time, turned by this about the
    /// vertical.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub angle_tolerance_deg: f64,
    /// Greatest relative error of the focal lengths along u and v, which is the same for both.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub focal_tolerance: f64,
    /// Greatest error of the principal point, along u and along v.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub principal_point_tolerance_px: f64,
    /// Greatest error, anywhere in the image, of the position at which the stated distortion coefficients put a pixel. The true coefficient k1 is
    /// drawn at random within this.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub distortion_tolerance_px: f64,
}

/// Times at which a camera exposes, stamps and delivers images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraTiming {
    /// Time between two images.
    pub period_s: f64,
    /// Time from the middle of an exposure to the delivery of its image.
    pub latency_s: f64,
    /// Greatest difference of an image's actual latency from `latency_s`.
    pub latency_tolerance_s: f64,
    /// Greatest error of an image's stamp against the true middle of the exposure.
    pub stamp_tolerance_s: f64,
    /// Longest time in which an image is exposed, from the start of the first row's exposure to the end of the last row's.
    pub longest_s: f64,
}

impl CameraTiming {
    /// Latest time, counted from the start of the run, at which the camera's first image is delivered.
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
    /// Calibration tolerances of a camera that a careful user can know.
    pub(super) fn careful() -> Value {
        json!({
            "position_tolerance_m": 0.002, "angle_tolerance_deg": 0.3, "focal_tolerance": 0.003,
            "principal_point_tolerance_px": 3.0, "distortion_tolerance_px": 0.3,
        })
    }
}
