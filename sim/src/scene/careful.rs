//! Bounds that a person can know: what a data sheet, a standard and an afternoon give of every device. Where each value comes from stands in
//! the book, on the page `docs/src/where_bounds_come_from.md`.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use serde_json::{Map, Value, json};

use super::{RobotPreset, Scene, robot_preset::lay_over};

/// From where tolerances and bounds come that a scene does not state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundsFrom {
    /// The defaults of the keys: instruments of a laboratory, physics tuned on a flat floor.
    #[default]
    Laboratory,
    /// What a careful user can know of the scene's devices and place; whatever the scene itself states stays.
    CarefulUser,
    /// The same, and nothing that the scene states is narrower.
    CarefulUserThroughout,
}

/// Keys that mean something only together: a scene that states one of them says what all of them are.
const TOGETHER: [(&str, &[&str]); 2] = [
    (
        "gyro",
        &[
            "noise_deg_per_s",
            "noise_redrawn",
            "angle_random_walk_deg_per_sqrt_h",
            "angle_floor_deg",
            "angle_deg_per_s",
            "bias_wander_deg_per_s2",
            "rate_random_walk_deg_per_h_per_sqrt_h",
        ],
    ),
    ("flow", &["calibration_tolerance", "surface_tolerance", "noise_tolerance", "scale_tolerance"]),
];

impl<'de> Deserialize<'de> for Scene {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut stated = Map::deserialize(deserializer)?;
        let from = stated.get("bounds_from").cloned().unwrap_or_default();
        let keys = match Option::<BoundsFrom>::deserialize(from).map_err(D::Error::custom)?.unwrap_or_default() {
            BoundsFrom::Laboratory => Value::Object(stated),
            BoundsFrom::CarefulUser => {
                let mut keys = careful(&mut stated);
                leave_out_what_is_stated_in_part(&mut keys, &stated);
                lay_over(&mut keys, Value::Object(stated));
                keys
            }
            BoundsFrom::CarefulUserThroughout => {
                let widest = careful(&mut stated);
                let mut keys = Value::Object(stated);
                widen(&mut keys, widest);
                keys
            }
        };
        // The derived function of the same name, not this one.
        Scene::deserialize(keys).map_err(D::Error::custom)
    }
}

impl Serialize for Scene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Scene::serialize(self, serializer)
    }
}

/// The careful keys of all that a scene has. A device that is `true` becomes a table without keys, over which they can be laid.
fn careful(stated: &mut Map<String, Value>) -> Value {
    let preset = stated.get("robot").and_then(|robot| robot.get("preset")).cloned().unwrap_or_default();
    // What the schema does not know of is refused with the robot itself.
    let preset = RobotPreset::deserialize(preset).unwrap_or_default();
    let mut keys = json!({ "bounds": posture(preset), "building": { "furniture_tolerance_deg": 2.0 } });
    if stated.get("floor").is_some_and(|floor| floor.get("tiles").is_some()) {
        keys["floor"] = json!({ "tiles": { "laying_tolerance_m": 0.003, "corner_tolerance_m": 0.001 } });
    }
    if stated.contains_key("markers") {
        keys["markers"] = json!({
            "placement_tolerance_m": 0.004, "rotation_tolerance_deg": 0.5, "print_tolerance_m": 0.0003, "height_tolerance_m": 0.005,
        });
    }
    if reads_walls(stated) {
        keys["localizer"] = json!({ "wall_directions": { "tolerance_deg": 0.3, "askew_deg": 2.0 } });
    }
    let mut robot = json!({
        "wheel_radius_tolerance": 0.005,
        "track_tolerance": 0.005,
        "delivery": { "stamp_tolerance_s": 0.001 },
    });
    let fitted = serde_json::to_value(preset.robot()).unwrap_or_default();
    for (name, device) in devices() {
        let said = stated.get_mut("robot").and_then(|robot| robot.get_mut(name));
        let is_fitted = match &said {
            None => fitted[name].is_object(),
            Some(said) => said.is_object() || **said == Value::Bool(true),
        };
        if let Some(said) = said.filter(|said| **said == Value::Bool(true)) {
            *said = json!({});
        }
        if is_fitted {
            robot[name] = device;
        }
    }
    keys["robot"] = robot;
    keys
}

/// A floor with lippage: joints that the standards allow under wheels and casters.
fn posture(preset: RobotPreset) -> Value {
    let body_tilt_deg = match preset {
        RobotPreset::P3dx => 0.35,
        RobotPreset::Vacuum => 0.5,
    };
    json!({
        "body_tilt_deg": body_tilt_deg, "body_heave_m": 0.0008,
        "slip_ratio": 0.01, "slip_floor_m": 0.0002, "side_slip_ratio": 0.015, "side_slip_floor_m": 0.00025,
    })
}

/// Each device with its careful keys.
fn devices() -> [(&'static str, Value); 6] {
    let calibration = json!({
        "position_tolerance_m": 0.002, "angle_tolerance_deg": 0.3, "focal_tolerance": 0.003,
        "principal_point_tolerance_px": 3.0, "distortion_tolerance_px": 0.3,
    });
    [
        (
            "floor_camera",
            json!({
                "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3,
                "tilt_tolerance_deg": 0.3, "scale_tolerance": 0.003, "distortion_tolerance_px": 0.3,
            }),
        ),
        // A camera of a home robot hangs on USB and is stamped by who reads it.
        (
            "forward_camera",
            json!({ "stamp_tolerance_s": 0.02, "latency_tolerance_s": 0.01, "calibration": calibration }),
        ),
        // Its ring flashes with its shutter, so that it is triggered.
        ("ceiling_camera", json!({ "stamp_tolerance_s": 0.001, "calibration": calibration })),
        (
            "range_camera",
            json!({
                "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3,
                "tilt_tolerance_deg": 0.3, "focal_tolerance": 0.003, "baseline_tolerance": 0.003, "column_noise_px": 0.3,
            }),
        ),
        (
            "gyro",
            json!({
                "bias_tolerance_deg_per_s": 0.1, "scale_tolerance": 0.01,
                "noise_deg_per_s": 0.6, "noise_redrawn": false, "angle_random_walk_deg_per_sqrt_h": 0.3,
                "angle_floor_deg": 0.06, "angle_deg_per_s": 0.015,
                "rate_random_walk_deg_per_h_per_sqrt_h": 6.0, "bias_wander_deg_per_s2": 0.0005,
            }),
        ),
        (
            "flow",
            json!({
                "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3,
                "calibration_tolerance": 0.01, "surface_tolerance": 0.01, "noise_tolerance": 0.005, "scale_tolerance": 0.03,
            }),
        ),
    ]
}

fn reads_walls(stated: &Map<String, Value>) -> bool {
    let methods = stated.get("localizer").and_then(|localizer| localizer.get("methods")).and_then(Value::as_array);
    methods.into_iter().flatten().any(|method| method == "wall_directions")
}

fn leave_out_what_is_stated_in_part(keys: &mut Value, stated: &Map<String, Value>) {
    for (device, group) in TOGETHER {
        let said = stated.get("robot").and_then(|robot| robot.get(device));
        let is_stated = group.iter().any(|key| said.is_some_and(|said| said.get(key).is_some()));
        let keys = keys.pointer_mut(&format!("/robot/{device}")).and_then(Value::as_object_mut);
        if let Some(keys) = keys.filter(|_| is_stated) {
            keys.retain(|key, _| !group.contains(&key.as_str()));
        }
    }
}

/// Numbers become at least those of `least`, and what is not stated becomes as there. More is wider for every careful key.
fn widen(keys: &mut Value, least: Value) {
    match (keys, least) {
        (Value::Object(keys), Value::Object(least)) => {
            for (key, value) in least {
                widen(keys.entry(key).or_insert(Value::Null), value);
            }
        }
        (keys, least) => {
            let is_wider = keys.as_f64().zip(least.as_f64()).is_some_and(|(stated, least)| stated >= least);
            if !is_wider {
                *keys = least;
            }
        }
    }
}
