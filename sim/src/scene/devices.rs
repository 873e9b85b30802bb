//! Keys of a robot's devices, in one file for each kind of device.

mod camera;
mod ceiling_camera;
mod delivery;
mod encoders;
mod floor_camera;
mod flow;
mod forward_camera;
mod gnss;
mod gyro;
mod point_camera;
mod range_camera;
mod scanner;
mod steering_encoder;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

pub use camera::{Band, Calibration, CameraKeys, CameraTiming, LensKeys, Looks, SharedKeys};
pub use ceiling_camera::CeilingCamera;
pub use delivery::Delivery;
pub use encoders::Encoders;
pub use floor_camera::FloorCamera;
pub use flow::{Flow, FlowOptics};
pub use forward_camera::ForwardCamera;
pub use gnss::{Gnss, Outage, Reception, Shadow};
pub use gyro::Gyro;
pub use point_camera::PointCamera;
pub use range_camera::RangeCamera;
pub use scanner::Scanner;
pub use steering_encoder::SteeringEncoder;

/// List of all kinds of devices for a macro: for each kind its description, the key of its table under `[robot]`, and the type of that table. Devices
/// that the board of the robot's base reads are read in the order of this list.
macro_rules! with_every_kind {
    ($define:ident) => {
        $define! {
            /// Camera that looks straight down: a table of its keys, `true` for the default one, or `false` for none. Without it the default robot
            /// has no sensor but its wheel encoders.
            floor_camera: FloorCamera as "Fitted<FloorCamera>";
            /// Camera that looks ahead: a table of its keys, `true` for the default one, or `false` for none.
            forward_camera: ForwardCamera as "Fitted<ForwardCamera>";
            /// Camera that looks up: a table of its keys, `true` for the default one, or `false` for none.
            ceiling_camera: CeilingCamera as "Fitted<CeilingCamera>";
            /// Range camera, which measures where landmarks with a code are: a table of its keys, `true` for the default one, or `false` for none.
            range_camera: RangeCamera as "Fitted<RangeCamera>";
            /// Gyroscope about the vertical: a table of its keys, `true` for the default one, or `false` for none.
            gyro: Gyro as "Fitted<Gyro>";
            /// Optical flow sensor that looks at the floor: a table of its keys, `true` for the default one, or `false` for none.
            flow: Flow as "Fitted<Flow>";
            /// Receiver of satellite navigation: a table of its keys, `true` for the default one, or `false` for none.
            gnss: Gnss as "Fitted<Gnss>";
            /// Camera whose front end tells where in its image it sees which landmark: a table of its keys, `true` for the default one, or `false`
            /// for none.
            point_camera: PointCamera as "Fitted<PointCamera>";
            /// Planar range scanner: a table of its keys, `true` for the default one, or `false` for none.
            scanner: Scanner as "Fitted<Scanner>";
            /// Encoder of the steering angle, which only a car can have: a table of its keys, `true` for the default one, or `false` for none.
            #[serde(skip_serializing_if = "Option::is_none")]
            steering_encoder: SteeringEncoder as "Fitted<SteeringEncoder>";
        }
    };
}
pub(crate) use with_every_kind;

/// List of all localization methods for a macro: for each method its description, its name, and the key under `[robot]` of the device whose readings
/// it uses.
macro_rules! with_every_method {
    ($define:ident) => {
        $define! {
            /// Method that locates the robot by the joints of a tiled floor, seen by a camera that looks down (paper 1).
            FloorTiles reads floor_camera,
            /// Method that locates the robot by coded landmarks whose positions are on no map, seen by a range camera (paper 3).
            RangeLandmarks reads range_camera,
            /// Method that locates the robot by dot-matrix markers on the ceiling, seen by a camera that looks up (paper 5).
            CeilingMarkers reads ceiling_camera,
            /// Method that finds the robot's heading, up to quarter turns, by level edges of walls, seen by a camera that looks ahead, also in the
            /// dark (paper 2).
            WallDirections reads forward_camera,
            /// Method that locates the robot by the positions of an antenna that a receiver of satellite navigation reports.
            GnssPositions reads gnss,
            /// Method that locates the robot by landmarks in space whose places an earlier drive or this one has learnt, seen by a camera that knows
            /// them again (paper 4). It reads the point camera or, on a robot without one, the pictures of the forward camera.
            MappedLandmarks reads point_camera,
            /// Method that locates the robot by the distances of walls that a planar range scanner measures.
            WallRanges reads scanner,
            /// Method that locates the robot by upright edges of walls, such as the ends of partitions, seen by a camera that looks ahead.
            WallBearings reads forward_camera,
        }
    };
}
pub(crate) use with_every_method;

macro_rules! define_methods {
    ($($(#[$doc:meta])+ $method:ident reads $device:ident,)+) => {
        /// Localization methods, named by the cue that they read.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum MethodName {
            $($(#[$doc])+ $method,)+
        }

        impl MethodName {
            /// All localization methods.
            pub(crate) const ALL: &[MethodName] = &[$(MethodName::$method,)+];
        }
    };
}

with_every_method!(define_methods);

macro_rules! define {
    ($($(#[$doc:meta])+ $name:ident: $keys:ident as $fitted:literal ;)+) => {
        /// Bounds on the errors of each kind of device that a careful user can know, with the key of the device's table under `[robot]`.
        pub(super) fn careful() -> Vec<(&'static str, Careful)> {
            vec![$((stringify!($name), $keys::careful()),)+]
        }
    };
}

with_every_kind!(define);

/// Bounds on a device's errors that a careful user can know from a data sheet and an afternoon of measuring.
pub(super) struct Careful {
    /// Keys of the device, with the values that a careful user can know.
    pub(super) keys: Value,
    /// Names of keys that mean something only together. A scene that states one of them gets no careful user's value for any of them.
    pub(super) together: &'static [&'static str],
}

impl Careful {
    /// Bounds of a careful user on a device all of whose keys have a meaning on their own, so that a scene may state any of them.
    fn each(keys: Value) -> Self {
        Careful { keys, together: &[] }
    }
}

/// A device as a scene states it. TOML has no null, so `false` states that the robot does not have the device.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Fitted<T> {
    /// The robot has the device, with these keys.
    With(T),
    /// `true`: the robot has the device with default keys. `false`: the robot does not have the device.
    Whether(bool),
}

impl<T: Default> Fitted<T> {
    pub(super) fn into_option<'de, D>(deserializer: D) -> Result<Option<T>, D::Error>
    where
        D: Deserializer<'de>,
        T: Deserialize<'de>,
    {
        Ok(match Fitted::deserialize(deserializer)? {
            Fitted::With(device) => Some(device),
            Fitted::Whether(true) => Some(T::default()),
            Fitted::Whether(false) => None,
        })
    }
}
