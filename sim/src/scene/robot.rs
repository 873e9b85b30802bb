//! The robot: its dimensions with the tolerances of their errors, and the devices fitted to it.

use localizer::reading::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

// The macro `with_every_kind` names the types of the keys of all kinds of devices, so all of them are imported.
use super::{base::Base, devices::*};

/// Defines the struct `Robot`, with a table of keys for every kind of device.
macro_rules! define {
    ($($(#[$doc:meta])+ $name:ident: $keys:ident as $fitted:literal ;)+) => {
        /// A robot on wheels. Its frame `robot` has x forward, y left, z up and its origin under the middle of the wheel axle. The defaults
        /// are the P3-DX's unless another `preset` is stated.
        #[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
        // `Robot` is deserialised in two steps: the keys of its preset are filled in first, and the function derived here does the rest.
        #[serde(deny_unknown_fields, default, remote = "Self")]
        #[schemars(rename = "Robot")]
        pub struct Robot {
            /// Named robot whose values apply where no other key states one.
            pub preset: RobotPreset,
            /// Mass of the robot.
            #[schemars(range(min = 0.5, max = 200.0))]
            pub mass_kg: f64,
            /// Radius of the robot's body about its origin. The body cannot enter walls.
            #[schemars(range(min = 0.05, max = 2.0))]
            pub body_radius_m: f64,
            /// Base of the robot.
            pub base: Base,
            /// Greatest commanded speed.
            #[schemars(range(max = 5.0), extend("exclusiveMinimum" = 0.0))]
            pub max_speed_m_per_s: f64,
            /// Greatest commanded turn rate.
            #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
            pub max_turn_rate_rad_per_s: f64,
            /// Greatest commanded acceleration.
            #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
            pub max_acceleration_m_per_s2: f64,
            /// Distribution, within their tolerances, of all random errors of this robot and its floor.
            pub errors: Distribution,
            /// Encoders of the wheels.
            pub encoders: Encoders,
            $(
                $(#[$doc])+
                #[serde(deserialize_with = "Fitted::into_option")]
                #[schemars(with = $fitted)]
                pub $name: Option<$keys>,
            )+
            /// How readings of wheels, gyroscope, flow sensor and steering encoder reach the localizer: at once and each exactly once, unless
            /// stated otherwise.
            pub delivery: Delivery,
        }

        impl Default for Robot {
            /// Pioneer P3-DX with a floor camera behind its axle.
            fn default() -> Self {
                let bare = Robot {
                    preset: RobotPreset::P3dx,
                    mass_kg: 9.0,
                    body_radius_m: 0.25,
                    base: Base::default(),
                    max_speed_m_per_s: 0.51,
                    max_turn_rate_rad_per_s: 1.0,
                    max_acceleration_m_per_s2: 0.5,
                    errors: Distribution::Uniform,
                    encoders: Encoders::default(),
                    delivery: Delivery::default(),
                    $($name: None,)+
                };
                Robot { floor_camera: Some(FloorCamera::default()), ..bare }
            }
        }
    };
}

with_every_kind!(define);

macro_rules! define_lacks {
    ($($(#[$doc:meta])+ $method:ident reads $device:ident,)+) => {
        impl Robot {
            /// Key of the device that `method` reads if this robot lacks that device, otherwise `None`.
            pub(crate) fn lacks(&self, method: MethodName) -> Option<&'static str> {
                if self.shows_landmarks(method) {
                    return None;
                }
                match method {
                    $(MethodName::$method => self.$device.is_none().then_some(concat!("robot.", stringify!($device))),)+
                }
            }
        }
    };
}

with_every_method!(define_lacks);

impl Robot {
    /// Whether the given method is the one of landmarks in space, and reads the pictures of this robot's forward camera, because there is no point
    /// camera.
    pub(crate) fn shows_landmarks(&self, method: MethodName) -> bool {
        method == MethodName::MappedLandmarks && self.point_camera.is_none() && self.forward_camera.is_some()
    }

    /// Names of the robot's cameras, in the order of [`Camera::ALL`].
    pub fn cameras(&self) -> Vec<Camera> {
        Camera::ALL.into_iter().filter(|name| self.camera(*name).is_some()).collect()
    }

    /// The robot's camera of this name; `None` if the robot does not have it.
    pub fn camera(&self, name: Camera) -> Option<&dyn CameraKeys> {
        fn keys(camera: &Option<impl CameraKeys>) -> Option<&dyn CameraKeys> {
            camera.as_ref().map(|camera| camera as &dyn CameraKeys)
        }
        match name {
            Camera::Floor => keys(&self.floor_camera),
            Camera::Forward => keys(&self.forward_camera),
            Camera::Ceiling => keys(&self.ceiling_camera),
        }
    }
}

/// Named robots that a scene can start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotPreset {
    /// Pioneer P3-DX with a floor camera behind its axle: 9 kg, track 0.33 m, wheel radius 97.5 mm.
    #[default]
    P3dx,
    /// Robot vacuum: 3 kg, track 0.23 m, wheel radius 35 mm, gyroscope and flow sensor, no floor camera.
    Vacuum,
}

/// Distributions of random errors, always inside the tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// Every value within an error's tolerance is equally likely.
    #[default]
    Uniform,
    /// Normal distribution with half the tolerance as standard deviation; values outside the tolerance are drawn again.
    TruncatedGaussian,
    /// Always one of the two ends of the tolerance, never a value between: the adversarial corner.
    Corner,
    /// The worst drift: errors that stay the same are at an end of their tolerance, and errors that may change add up in the worst way. Noise and
    /// stamps always err to one side, delays alternate between the ends, the flow sensor's scale depends on the direction of travel, and joints and
    /// markers are all off alike.
    Drift,
}
