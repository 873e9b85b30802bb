//! Keys of the infrared camera that looks up.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Band, Calibration, CameraKeys, Careful, LensKeys, Looks, SharedKeys, camera::define_camera};
use crate::scene::{Sensor, SensorPreset};

define_camera! {
    /// An infrared camera that looks up, with a ring of diodes around its lens. The top of the image is towards the robot's back, the right side of the
    /// image towards the robot's right.
    CeilingCamera at [0.0, 0.0, 0.3] every 0.1 s {
        /// Focal lengths along u and v. The default is that of paper 5's Eq. 16.
        #[schemars(inner(range(min = 10.0, max = 100000.0)))]
        focal_px: [f64; 2] = [755.139, 753.926],
        /// Principal point, where the optical axis meets the image. The default is that of paper 5's Eq. 16.
        #[schemars(inner(range(min = -10000.0, max = 10000.0)))]
        principal_point_px: [f64; 2] = [320.252, 239.661],
        /// Angle by which the optical axis leans forward from the body's vertical.
        #[schemars(range(min = -60.0, max = 60.0))]
        lean_forward_deg: f64 = 0.0,
        /// Angle by which the optical axis leans to the left. The leans forward and to the left are the components of a single rotation.
        #[schemars(range(min = -60.0, max = 60.0))]
        lean_left_deg: f64 = 0.0,
        /// Band of wavelengths that the camera sees.
        band: Band = Band::Infrared,
        /// Radiant intensity of the ring of diodes along the optical axis, at 850 nm; 0 for no ring. The intensity falls with the cosine of the angle
        /// off the axis. By default the ring has twelve diodes of 25 mW/sr each.
        #[schemars(range(min = 0.0, max = 1000.0))]
        ring_intensity_w_per_sr: f64 = 0.3,
        /// Tolerances of the camera's calibration: how far its mount and lens may be from the stated values. Each seed draws errors within them,
        /// distributed as the robot's key `errors` states.
        calibration: Calibration = Calibration::default(),
        /// Greatest number of markers in one image that the localizer assumes to differ from what its map says of them.
        #[schemars(range(min = 0, max = 4))]
        q_items: usize = 0,
    }
}

impl CameraKeys for CeilingCamera {
    fn name(&self) -> Camera {
        Camera::Ceiling
    }

    fn shared(&self) -> SharedKeys<'_> {
        self.shared_keys()
    }

    fn looks(&self) -> Looks {
        Looks::Up { lean_forward_deg: self.lean_forward_deg, lean_left_deg: self.lean_left_deg }
    }

    fn focal_px(&self) -> [f64; 2] {
        self.focal_px
    }

    fn principal_point_px(&self) -> [f64; 2] {
        self.principal_point_px
    }

    fn sensor_preset(&self) -> SensorPreset {
        SensorPreset::Infrared
    }

    fn band(&self) -> Band {
        self.band
    }

    fn ring_intensity_w_per_sr(&self) -> f64 {
        self.ring_intensity_w_per_sr
    }
}

impl CeilingCamera {
    /// Bounds on the ceiling camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        // The camera's ring of diodes flashes with the shutter, so the camera is triggered and its stamps are good.
        Careful::each(json!({ "stamp_tolerance_s": 0.001, "calibration": Calibration::careful() }))
    }
}
