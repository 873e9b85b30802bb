//! Keys of the infrared camera that looks up.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Band, Calibration, CameraTiming, Careful, LensKeys};
use crate::scene::{Sensor, SensorModel, SensorPreset};

/// An infrared camera that looks up, with a ring of diodes around its lens. The top of the image is towards the robot's back, the right side of the
/// image towards the robot's right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CeilingCamera {
    /// Width of the camera's image.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Height of the camera's image.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Focal lengths along u and v. The default is that of paper 5's Eq. 16.
    #[schemars(inner(range(min = 10.0, max = 100000.0)))]
    pub focal_px: [f64; 2],
    /// Principal point, where the optical axis meets the image. The default is that of paper 5's Eq. 16.
    #[schemars(inner(range(min = -10000.0, max = 10000.0)))]
    pub principal_point_px: [f64; 2],
    /// Distance of the camera's optical centre forward of the wheel axle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the camera's optical centre to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the camera's optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Angle by which the optical axis leans forward from the body's vertical.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub lean_forward_deg: f64,
    /// Angle by which the optical axis leans to the left. The leans forward and to the left are the components of a single rotation.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub lean_left_deg: f64,
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
    /// Radiant intensity of the ring of diodes along the optical axis, at 850 nm; 0 for no ring. The intensity falls with the cosine of the angle off
    /// the axis.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub ring_intensity_w_per_sr: f64,
    /// Distortion, vignetting and defocus of the lens, and the time in which the rows of the sensor are read out.
    pub lens: LensKeys,
    /// Image sensor of the camera, which turns light into grey levels.
    pub sensor: Sensor,
    /// Tolerances of the camera's calibration: how far its mount and lens may be from the stated values. Each seed draws errors within them,
    /// distributed as the robot's key `errors` states.
    pub calibration: Calibration,
    /// Greatest number of markers in one image that the localizer assumes to differ from what its map says of them.
    #[schemars(range(min = 0, max = 4))]
    pub q_items: usize,
}

impl CeilingCamera {
    /// Model of the camera's image sensor, with the values of its preset filled in.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::Infrared)
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
            // The camera's ring has twelve infrared diodes of 25 mW/sr each.
            ring_intensity_w_per_sr: 0.3,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            calibration: Calibration::default(),
            q_items: 0,
        }
    }
}

impl CeilingCamera {
    /// Bounds on the ceiling camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        // The camera's ring of diodes flashes with the shutter, so the camera is triggered and its stamps are good.
        Careful::each(json!({ "stamp_tolerance_s": 0.001, "calibration": Calibration::careful() }))
    }
}
