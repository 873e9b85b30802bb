//! A camera of the robot: the keys that all cameras have. Floor, forward and ceiling camera are three presets of it, which differ in where they look,
//! in how their view and their calibration are stated, and in the values of keys that a scene does not state.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::scene::{Sensor, SensorModel, SensorPreset};

/// A camera as a scene states it, whichever of the presets it is.
pub trait CameraKeys {
    /// Name of the camera.
    fn name(&self) -> Camera;

    /// The values of the keys that all cameras have.
    fn shared(&self) -> SharedKeys<'_>;

    /// Attitude of the camera on the robot's body.
    fn looks(&self) -> Looks;

    /// Nominal focal lengths along u and v.
    fn focal_px(&self) -> [f64; 2];

    /// Nominal principal point, where the optical axis meets the image.
    fn principal_point_px(&self) -> [f64; 2] {
        self.shared().size_px.map(|size| (f64::from(size) - 1.0) / 2.0)
    }

    /// Image sensor whose values apply where the scene states none.
    fn sensor_preset(&self) -> SensorPreset;

    /// Whether images darken away from their middle where the scene does not state it.
    fn darkens_off_axis(&self) -> bool {
        true
    }

    /// Band of wavelengths that the camera sees.
    fn band(&self) -> Band {
        Band::Visible
    }

    /// Radiant intensity of a ring of diodes around the lens, along the optical axis and at 850 nm; 0 for no ring.
    fn ring_intensity_w_per_sr(&self) -> f64 {
        0.0
    }

    /// Longest exposure of an image that is taken while the robot turns, if turns shorten exposures.
    fn turning_exposure_s(&self) -> Option<f64> {
        None
    }

    /// Model of the camera's image sensor, with the values of its preset filled in.
    fn sensor_model(&self) -> SensorModel {
        self.shared().sensor.model(self.sensor_preset())
    }

    /// Times at which the camera exposes, stamps and delivers images.
    fn timing(&self) -> CameraTiming {
        let SharedKeys { size_px, period_s, latency_s, latency_tolerance_s, stamp_tolerance_s, lens, .. } =
            self.shared();
        let longest_s = self.sensor_model().longest_exposure_s + lens.row_time_s * f64::from(size_px[1] - 1);
        CameraTiming { period_s, latency_s, latency_tolerance_s, stamp_tolerance_s, longest_s }
    }
}

/// The values of the keys that all cameras have.
#[derive(Clone, Copy, Debug)]
pub struct SharedKeys<'a> {
    /// Width and height of the image.
    pub size_px: [u32; 2],
    /// Position of the optical centre in the robot frame: forward, left and up.
    pub position_m: [f64; 3],
    /// Time between two images.
    pub period_s: f64,
    /// Time from the middle of an exposure to the delivery of its image.
    pub latency_s: f64,
    /// Greatest difference of an image's actual latency from `latency_s`.
    pub latency_tolerance_s: f64,
    /// Greatest error of an image's stamp against the true middle of the exposure.
    pub stamp_tolerance_s: f64,
    /// Keys of the lens.
    pub lens: &'a LensKeys,
    /// Keys of the image sensor.
    pub sensor: &'a Sensor,
}

/// Where a camera looks: its nominal attitude on the robot's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Looks {
    /// Straight down. The top of the image is towards the robot's front, the right side towards the robot's right.
    Down,
    /// Ahead over the robot's front, with the right side of the image towards the robot's right.
    Ahead {
        /// Direction of the optical axis, counter-clockwise from robot forward.
        yaw_deg: f64,
        /// Angle of the optical axis above the level, about the image's u axis.
        tilt_up_deg: f64,
    },
    /// Up. The top of the image is towards the robot's back, the right side towards the robot's right.
    Up {
        /// Angle by which the optical axis leans forward from the body's vertical.
        lean_forward_deg: f64,
        /// Angle by which the optical axis leans to the left. Both leans are the components of a single rotation.
        lean_left_deg: f64,
    },
}

/// Defines the keys of a preset of the camera: the keys that all cameras have, with the preset's own position on the robot and its own period, then
/// the keys and defaults that only this preset has.
macro_rules! define_camera {
    (
        $(#[$doc:meta])+
        $keys:ident at [$forward_m:literal, $left_m:literal, $height_m:literal] every $period_s:literal s
        { $($(#[$own_doc:meta])+ $own:ident: $own_type:ty = $own_default:expr,)+ }
    ) => {
        $(#[$doc])+
        #[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct $keys {
            /// Width of the camera's image.
            #[schemars(range(min = 64, max = 4096))]
            pub width_px: u32,
            /// Height of the camera's image.
            #[schemars(range(min = 64, max = 4096))]
            pub height_px: u32,
            /// Distance of the camera's optical centre forward of the wheel axle, in the robot frame.
            #[schemars(range(min = -2.0, max = 2.0))]
            pub forward_m: f64,
            /// Distance of the camera's optical centre to the left of the robot's middle, in the robot frame.
            #[schemars(range(min = -2.0, max = 2.0))]
            pub left_m: f64,
            /// Height of the camera's optical centre above the floor.
            #[schemars(range(min = 0.02, max = 5.0))]
            pub height_m: f64,
            $($(#[$own_doc])+ pub $own: $own_type,)+
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
            /// Distortion, vignetting and defocus of the lens, and the time in which the rows of the sensor are read out.
            pub lens: LensKeys,
            /// Image sensor of the camera, which turns light into grey levels.
            pub sensor: Sensor,
        }

        impl Default for $keys {
            fn default() -> Self {
                $keys {
                    width_px: 640,
                    height_px: 480,
                    forward_m: $forward_m,
                    left_m: $left_m,
                    height_m: $height_m,
                    $($own: $own_default,)+
                    period_s: $period_s,
                    latency_s: 0.03,
                    latency_tolerance_s: 0.002,
                    stamp_tolerance_s: 0.0001,
                    lens: LensKeys::default(),
                    sensor: Sensor::default(),
                }
            }
        }

        impl $keys {
            fn shared_keys(&self) -> SharedKeys<'_> {
                SharedKeys {
                    size_px: [self.width_px, self.height_px],
                    position_m: [self.forward_m, self.left_m, self.height_m],
                    period_s: self.period_s,
                    latency_s: self.latency_s,
                    latency_tolerance_s: self.latency_tolerance_s,
                    stamp_tolerance_s: self.stamp_tolerance_s,
                    lens: &self.lens,
                    sensor: &self.sensor,
                }
            }
        }
    };
}
pub(super) use define_camera;

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
