//! The infrared camera that looks up.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Band, Calibration, CameraTiming, Careful, LensKeys};
use crate::scene::{Sensor, SensorModel, SensorPreset};

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

impl CeilingCamera {
    /// What a careful user can know of it.
    pub(super) fn careful() -> Careful {
        // Its ring flashes with its shutter, so that it is triggered.
        Careful::each(json!({ "stamp_tolerance_s": 0.001, "calibration": Calibration::careful() }))
    }
}
