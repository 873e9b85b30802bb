//! Cameras that look ahead and up, with their lenses and how well they are calibrated.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Sensor, SensorModel, SensorPreset};

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
    /// What it sees.
    pub band: Band,
    /// What the lens does besides projecting.
    pub lens: LensKeys,
    /// What turns light into grey levels.
    pub sensor: Sensor,
    /// How far mount and lens may be from what these keys state.
    pub calibration: Calibration,
}

/// An infrared camera that looks straight up, with a ring of diodes around its lens. Image up is robot backward, image right is
/// robot right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CeilingCamera {
    /// Image width.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Image height.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Focal lengths along u and v; the default is paper 5's Eq. 16.
    #[schemars(inner(range(min = 10.0, max = 100000.0)))]
    pub focal_px: [f64; 2],
    /// Where the optical axis meets the image; the default is paper 5's Eq. 16.
    #[schemars(inner(range(min = -10000.0, max = 10000.0)))]
    pub principal_point_px: [f64; 2],
    /// Optical centre in the robot frame, forward of the axle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Optical centre in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// What it sees.
    pub band: Band,
    /// Radiant intensity of the ring along the optical axis, at 850 nm; 0 for none. It falls with the cosine of the angle
    /// off the axis.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub ring_intensity_w_per_sr: f64,
    /// What the lens does besides projecting.
    pub lens: LensKeys,
    /// What turns light into grey levels.
    pub sensor: Sensor,
    /// How far mount and lens may be from what these keys state.
    pub calibration: Calibration,
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
    /// Whether the image falls off from its middle by the fourth power of the cosine.
    pub vignetting: bool,
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
    /// The attitude, about each axis of the camera frame.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub angle_tolerance_deg: f64,
    /// Both focal lengths alike, as a share.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub focal_tolerance: f64,
    /// The principal point, along u and v.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub principal_point_tolerance_px: f64,
}

impl ForwardCamera {
    /// Its sensor, nothing left open.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::RobotVacuum)
    }
}

impl CeilingCamera {
    /// Its sensor, nothing left open.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::Infrared)
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
            band: Band::Visible,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            calibration: Calibration::default(),
        }
    }
}

impl Default for CeilingCamera {
    fn default() -> Self {
        CeilingCamera {
            width_px: 640,
            height_px: 480,
            focal_px: [755.139, 753.926],
            principal_point_px: [320.252, 239.661],
            forward_m: 0.0,
            left_m: 0.0,
            height_m: 0.3,
            band: Band::Infrared,
            // Twelve diodes of 25 mW/sr.
            ring_intensity_w_per_sr: 0.3,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            calibration: Calibration::default(),
        }
    }
}

impl Default for LensKeys {
    fn default() -> Self {
        LensKeys { distortion: [0.0; 5], vignetting: true, defocus_px: 0.0, row_time_s: 0.0 }
    }
}

impl Default for Calibration {
    fn default() -> Self {
        Calibration {
            position_tolerance_m: 0.0005,
            angle_tolerance_deg: 0.1,
            focal_tolerance: 0.001,
            principal_point_tolerance_px: 0.5,
        }
    }
}
