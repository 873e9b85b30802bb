//! Keys of the camera that looks ahead.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Band, Calibration, CameraKeys, Careful, LensKeys, Looks, SharedKeys, camera::define_camera};
use crate::scene::{Sensor, SensorPreset};

define_camera! {
    /// A camera that looks forward over the robot's head, tilted up. The right side of the image is towards the robot's right.
    ForwardCamera at [0.12, 0.0, 0.25] every 0.1 s {
        /// Angle of view from the left to the right edge of the image, without distortion.
        #[schemars(range(min = 10.0, max = 140.0))]
        horizontal_view_deg: f64 = 75.0,
        /// Upward tilt of the camera's optical axis; 8.7 in paper 2.
        #[schemars(range(min = -80.0, max = 80.0))]
        tilt_up_deg: f64 = 8.7,
        /// Direction of the camera's optical axis, counter-clockwise from robot forward.
        #[schemars(range(min = -180.0, max = 180.0))]
        yaw_deg: f64 = 0.0,
        /// Band of wavelengths that the camera sees.
        band: Band = Band::Visible,
        /// Radiant intensity, along the optical axis and at 850 nm, of a ring of diodes around the lens; 0 for no ring. The intensity falls with the
        /// cosine of the angle off the axis. The camera sees the ring's light only with `band = "infrared"`.
        #[schemars(range(min = 0.0, max = 1000.0))]
        ring_intensity_w_per_sr: f64 = 0.0,
        /// Longest exposure of an image that is taken while the gyroscope reads a turn faster than 0.1 rad/s, as turns blur the image. Unless stated,
        /// turns do not shorten exposures.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.00001, max = 1.0))]
        turning_exposure_s: Option<f64> = None,
        /// Tolerances of the camera's calibration: how far its mount and lens may be from the stated values. Each seed draws errors within them,
        /// distributed as the robot's key `errors` states.
        calibration: Calibration = Calibration::default(),
    }
}

impl CameraKeys for ForwardCamera {
    fn name(&self) -> Camera {
        Camera::Forward
    }

    fn shared(&self) -> SharedKeys<'_> {
        self.shared_keys()
    }

    fn looks(&self) -> Looks {
        Looks::Ahead { yaw_deg: self.yaw_deg, tilt_up_deg: self.tilt_up_deg }
    }

    /// Half the image width over the tangent of half the angle of view.
    fn focal_px(&self) -> [f64; 2] {
        [f64::from(self.width_px) / 2.0 / (self.horizontal_view_deg.to_radians() / 2.0).tan(); 2]
    }

    fn sensor_preset(&self) -> SensorPreset {
        SensorPreset::RobotVacuum
    }

    fn band(&self) -> Band {
        self.band
    }

    fn ring_intensity_w_per_sr(&self) -> f64 {
        self.ring_intensity_w_per_sr
    }

    fn turning_exposure_s(&self) -> Option<f64> {
        self.turning_exposure_s
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
