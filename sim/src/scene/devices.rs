//! Keys of the devices of a robot, a file for each kind.

mod camera;
mod ceiling_camera;
mod delivery;
mod encoders;
mod floor_camera;
mod flow;
mod forward_camera;
mod gyro;
mod proximity;
mod range_camera;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};
use serde_json::Value;

pub use camera::{Band, Calibration, CameraTiming, LensKeys};
pub use ceiling_camera::CeilingCamera;
pub use delivery::Delivery;
pub use encoders::Encoders;
pub use floor_camera::FloorCamera;
pub use flow::{Flow, FlowOptics};
pub use forward_camera::ForwardCamera;
pub use gyro::Gyro;
pub use proximity::Proximity;
pub use range_camera::RangeCamera;

/// What a careful user can know of each kind of device, by the key of its table under `[robot]`.
pub(super) fn careful() -> [(&'static str, Careful); 6] {
    [
        ("floor_camera", FloorCamera::careful()),
        ("forward_camera", ForwardCamera::careful()),
        ("ceiling_camera", CeilingCamera::careful()),
        ("range_camera", RangeCamera::careful()),
        ("gyro", Gyro::careful()),
        ("flow", Flow::careful()),
    ]
}

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
