//! Robots by name: the values of each preset, and how a scene's keys are laid over them.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use serde_json::{Map, Value};

use super::{Base, Differential, Encoders, Flow, Gyro, Robot, RobotPreset};

impl RobotPreset {
    /// The robot that the preset names.
    pub fn robot(self) -> Robot {
        match self {
            RobotPreset::P3dx => Robot::default(),
            RobotPreset::Vacuum => vacuum(),
        }
    }
}

/// A robot vacuum of the kind in paper 2. Soft casters let the robot climb onto carpets.
fn vacuum() -> Robot {
    Robot {
        preset: RobotPreset::Vacuum,
        mass_kg: 3.0,
        body_radius_m: 0.17,
        base: Base {
            wheel_radius_m: 0.035,
            track_m: 0.23,
            differential: Differential { caster_stiffness: 0.3 },
            ..Base::default()
        },
        max_speed_m_per_s: 0.3,
        max_turn_rate_rad_per_s: 1.5,
        // The motor's encoder has 12 counts per turn, and the gear reduces by 1:60.
        encoders: Encoders { ticks_per_turn: 720, ..Encoders::default() },
        floor_camera: None,
        gyro: Some(Gyro::default()),
        flow: Some(Flow::default()),
        ..Robot::default()
    }
}

impl<'de> Deserialize<'de> for Robot {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stated = Map::deserialize(deserializer)?;
        let preset = stated.get("preset").cloned().unwrap_or_default();
        let preset = Option::<RobotPreset>::deserialize(preset).map_err(D::Error::custom)?.unwrap_or_default();
        let mut keys = serde_json::to_value(preset.robot()).map_err(D::Error::custom)?;
        if let Value::Object(devices) = &mut keys {
            // In a scene `false` states that the robot does not have a device.
            devices.values_mut().filter(|device| device.is_null()).for_each(|device| *device = Value::Bool(false));
        }
        lay_over(&mut keys, Value::Object(stated));
        // `Robot::deserialize` is the function that serde derives, not the trait's function of the same name around this line.
        Robot::deserialize(keys).map_err(D::Error::custom)
    }
}

impl Serialize for Robot {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Robot::serialize(self, serializer)
    }
}

/// Replaces the keys of `under` by those that `over` states, table by table.
pub(super) fn lay_over(under: &mut Value, over: Value) {
    match (under, over) {
        (Value::Object(under), Value::Object(over)) => {
            for (key, value) in over {
                lay_over(under.entry(key).or_insert(Value::Null), value);
            }
        }
        (under, over) => *under = over,
    }
}
