//! Keys of the devices of a robot, a file for each kind.

mod camera;
mod ceiling_camera;
mod delivery;
mod encoders;
mod floor_camera;
mod flow;
mod forward_camera;
mod gnss;
mod gyro;
mod proximity;
mod range_camera;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::Robot;

pub use camera::{Band, Calibration, CameraTiming, LensKeys};
pub use ceiling_camera::CeilingCamera;
pub use delivery::Delivery;
pub use encoders::Encoders;
pub use floor_camera::FloorCamera;
pub use flow::{Flow, FlowOptics};
pub use forward_camera::ForwardCamera;
pub use gnss::{Gnss, Outage, Reception, Shadow};
pub use gyro::Gyro;
pub use proximity::Proximity;
pub use range_camera::RangeCamera;

/// Names every kind of device to a macro: what it is, the key of its table under `[robot]`, and the type of the table. What is read by the board
/// of the base is read in this order.
macro_rules! with_every_kind {
    ($define:ident) => {
        $define! {
            /// Camera that looks straight down: a table of its keys, or `false` for none, which leaves the wheels alone.
            floor_camera: FloorCamera as "Fitted<FloorCamera>";
            /// Camera that looks ahead: a table of its keys, `true` for the default one, or `false` for none.
            forward_camera: ForwardCamera as "Fitted<ForwardCamera>";
            /// Camera that looks up: a table of its keys, `true` for the default one, or `false` for none.
            ceiling_camera: CeilingCamera as "Fitted<CeilingCamera>";
            /// Range camera for coded landmarks: a table of its keys, `true` for the default one, or `false` for none.
            range_camera: RangeCamera as "Fitted<RangeCamera>";
            /// Gyroscope about the vertical: a table of its keys, `true` for the default one, or `false` for none.
            gyro: Gyro as "Fitted<Gyro>";
            /// Optical flow sensor that looks at the floor: a table of its keys, `true` for the default one, or `false` for none.
            flow: Flow as "Fitted<Flow>";
            /// Receiver of satellite navigation: a table of its keys, `true` for the default one, or `false` for none.
            gnss: Gnss as "Fitted<Gnss>";
        }
    };
}
pub(crate) use with_every_kind;

/// Names every method to a macro: what it reads, its name, and the key of the device under `[robot]` that makes it.
macro_rules! with_every_method {
    ($define:ident) => {
        $define! {
            /// Joints of a tiled floor under a camera that looks down (paper 1).
            FloorTiles reads floor_camera,
            /// Coded landmarks that no map names, seen by a range camera (paper 3).
            RangeLandmarks reads range_camera,
            /// Dot-matrix markers on the ceiling under a camera that looks up (paper 5).
            CeilingMarkers reads ceiling_camera,
            /// Level edges of walls before a camera that looks ahead: heading up to quarter turns, in the dark (paper 2).
            WallDirections reads forward_camera,
            /// Positions of an antenna, as a receiver of satellite navigation tells them.
            GnssPositions reads gnss,
        }
    };
}
pub(crate) use with_every_method;

macro_rules! define_methods {
    ($($(#[$doc:meta])+ $method:ident reads $device:ident,)+) => {
        /// Localization methods by the cue they read.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum MethodName {
            $($(#[$doc])+ $method,)+
        }

        impl MethodName {
            /// All of them.
            pub(crate) const ALL: &[MethodName] = &[$(MethodName::$method,)+];
        }

        impl Robot {
            /// The key of the device that a method reads, if this robot has none.
            pub(crate) fn lacks(&self, method: MethodName) -> Option<&'static str> {
                match method {
                    $(MethodName::$method => self.$device.is_none().then_some(concat!("robot.", stringify!($device))),)+
                }
            }
        }
    };
}

with_every_method!(define_methods);

macro_rules! define {
    ($($(#[$doc:meta])+ $name:ident: $keys:ident as $fitted:literal ;)+) => {
        /// What a careful user can know of each kind of device, by the key of its table under `[robot]`.
        pub(super) fn careful() -> Vec<(&'static str, Careful)> {
            vec![$((stringify!($name), $keys::careful()),)+]
        }
    };
}

with_every_kind!(define);

/// What a careful user can know of a device.
pub(super) struct Careful {
    /// Its keys.
    pub(super) keys: Value,
    /// Those of them that mean something only together: a scene that states one of them says what all of them are.
    pub(super) together: &'static [&'static str],
}

impl Careful {
    /// Keys of which each means something alone.
    fn each(keys: Value) -> Self {
        Careful { keys, together: &[] }
    }
}

/// A device as a scene states it. TOML has no null, so `false` says that the robot has none.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Fitted<T> {
    /// Fitted, with these keys.
    With(T),
    /// `true`: fitted as by default. `false`: not fitted.
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
