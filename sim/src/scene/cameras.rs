//! Cameras that look ahead and up, with their lenses and how well they are calibrated.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FloorCamera, Robot, Sensor, SensorModel, SensorPreset};

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

/// An infrared camera that looks up, with a ring of diodes around its lens. Image up is robot backward, image right is
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
    /// Angle by which the optical axis leans forward from the body's vertical.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub lean_forward_deg: f64,
    /// Angle by which it leans to the left. Both are the components of one turn.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub lean_left_deg: f64,
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
    /// At most this many markers of one image are assumed not to be what the map says.
    #[schemars(range(min = 0, max = 4))]
    pub q_items: usize,
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

impl CeilingCamera {
    /// Its sensor, nothing left open.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::Infrared)
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
            lean_forward_deg: 0.0,
            lean_left_deg: 0.0,
            period_s: 0.1,
            latency_s: 0.03,
            latency_tolerance_s: 0.002,
            stamp_tolerance_s: 0.0001,
            band: Band::Infrared,
            // Twelve diodes of 25 mW/sr.
            ring_intensity_w_per_sr: 0.3,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            calibration: Calibration::default(),
            q_items: 0,
        }
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
