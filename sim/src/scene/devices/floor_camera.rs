//! Keys of the camera that looks straight down.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{CameraKeys, Careful, LensKeys, Looks, SharedKeys, camera::define_camera};
use crate::scene::{Sensor, SensorPreset};

define_camera! {
    /// A global-shutter camera that looks straight down. The top of the image is towards the robot's front, the right side of the image towards the
    /// robot's right. It is calibrated on the floor: by the scale of its image instead of focal length, principal point and height.
    FloorCamera at [-0.15, 0.0, 0.25] every 0.2 s {
        /// Width of the area of floor that the image shows.
        #[schemars(range(min = 0.05, max = 5.0))]
        footprint_width_m: f64 = 0.48,
        /// Greatest error of the floor camera's mounted position, forward and left each; drawn at random.
        #[schemars(range(min = 0.0, max = 0.1))]
        position_tolerance_m: f64 = 0.0005,
        /// Greatest error of the floor camera's yaw on its mount; drawn at random.
        #[schemars(range(min = 0.0, max = 10.0))]
        yaw_tolerance_deg: f64 = 0.1,
        /// Greatest angle of the floor camera's optical axis to the body's vertical, in any direction; drawn at random.
        #[schemars(range(min = 0.0, max = 10.0))]
        tilt_tolerance_deg: f64 = 0.1,
        /// Greatest error of the floor image's pixels per metre, as a share of their nominal number; drawn at random.
        #[schemars(range(min = 0.0, max = 0.1))]
        scale_tolerance: f64 = 0.001,
        /// Greatest error, anywhere in the image, of the position at which the stated distortion coefficients put a pixel. The true coefficient k1 is
        /// drawn at random within this.
        #[schemars(range(min = 0.0, max = 10.0))]
        distortion_tolerance_px: f64 = 0.0,
        /// Greatest number of lines seen in one floor image that the localizer assumes not to be joints of the tile grid.
        #[schemars(range(min = 0, max = 20))]
        q_items: usize = 0,
    }
}

impl CameraKeys for FloorCamera {
    fn name(&self) -> Camera {
        Camera::Floor
    }

    fn shared(&self) -> SharedKeys<'_> {
        self.shared_keys()
    }

    fn looks(&self) -> Looks {
        Looks::Down
    }

    /// The pixels per metre of floor, times the height.
    fn focal_px(&self) -> [f64; 2] {
        [self.pixels_per_m() * self.height_m; 2]
    }

    fn sensor_preset(&self) -> SensorPreset {
        SensorPreset::GlobalShutter
    }

    fn darkens_off_axis(&self) -> bool {
        false
    }
}

impl FloorCamera {
    /// Pixels per metre of floor with the body at rest, according to the calibration.
    pub fn pixels_per_m(&self) -> f64 {
        f64::from(self.width_px) / self.footprint_width_m
    }

    /// Bounds on the floor camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3, "tilt_tolerance_deg": 0.3,
            "scale_tolerance": 0.003, "distortion_tolerance_px": 0.3,
        }))
    }
}
