//! Bounds on the errors of every device, as a careful user can know them from a data sheet, a standard and an afternoon of measuring. The source of
//! each value is given in the book, on the page `docs/src/where_bounds_come_from.md`.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use serde_json::{Map, Value, json};

use super::{
    RobotPreset, Scene,
    devices::{self, Careful},
    robot_preset::lay_over,
};

/// Where those tolerances and bounds come from that the scene itself does not state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundsFrom {
    /// Each tolerance and bound that the scene does not state has its default. The defaults suit instruments of a laboratory and physics tuned on a
    /// flat floor.
    #[default]
    Laboratory,
    /// Bounds that a careful user of such a robot and place can know from data sheets, standards and an afternoon of measuring. Values that the scene
    /// states itself are kept.
    CarefulUser,
    /// The same bounds as with `careful_user`, but values that the scene states are widened to these bounds where they are narrower.
    CarefulUserThroughout,
}

impl<'de> Deserialize<'de> for Scene {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut stated = Map::deserialize(deserializer)?;
        let states_methods = stated.get("localizer").and_then(|localizer| localizer.get("methods")).is_some();
        let from = stated.get("bounds_from").cloned().unwrap_or_default();
        let keys = match Option::<BoundsFrom>::deserialize(from).map_err(D::Error::custom)?.unwrap_or_default() {
            BoundsFrom::Laboratory => Value::Object(stated),
            BoundsFrom::CarefulUser => {
                let mut keys = careful(&mut stated);
                leave_out_what_is_stated_in_part(&mut keys, &stated);
                leave_out_furniture_if_stated(&mut keys, &stated);
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
        // `Scene::deserialize` is here the function that serde derives for the type itself, not the trait's function of the same name, in which this
        // line stands.
        let mut scene = Scene::deserialize(keys).map_err(D::Error::custom)?;
        scene.localizer.states_methods = states_methods;
        Ok(scene)
    }
}

impl Serialize for Scene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Scene::serialize(self, serializer)
    }
}

/// The bounds that a careful user can know, as keys of a scene, for every part that the scene `stated` has: its robot and devices, floor, markers and
/// walls. A device that `stated` has as `true` becomes an empty table there, so that the bounds can be merged into it.
fn careful(stated: &mut Map<String, Value>) -> Value {
    let preset = stated.get("robot").and_then(|robot| robot.get("preset")).cloned().unwrap_or_default();
    // A preset that the schema does not know is refused later, together with the robot's other keys.
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
    if uses(stated, "wall_directions") {
        keys["localizer"]["wall_directions"] = json!({ "tolerance_deg": 0.3, "askew_deg": 2.0 });
    }
    if uses(stated, "wall_ranges") || uses(stated, "wall_bearings") {
        keys["localizer"]["wall_ranges"] = json!({ "placement_tolerance_m": 0.02 });
    }
    let mut robot = json!({
        "base": { "wheel_radius_tolerance": 0.005, "track_tolerance": 0.005 },
        "delivery": { "stamp_tolerance_s": 0.001 },
    });
    let fitted = serde_json::to_value(preset.robot()).unwrap_or_default();
    for (name, device) in devices::careful() {
        let said = stated.get_mut("robot").and_then(|robot| robot.get_mut(name));
        let is_fitted = match &said {
            None => fitted[name].is_object(),
            Some(said) => said.is_object() || **said == Value::Bool(true),
        };
        if let Some(said) = said.filter(|said| **said == Value::Bool(true)) {
            *said = json!({});
        }
        if is_fitted {
            robot[name] = device.keys;
        }
    }
    if robot["steering_encoder"].is_object() {
        robot["base"]["ackermann"] = json!({ "wheelbase_tolerance": 0.005 });
    }
    keys["robot"] = robot;
    keys
}

/// A careful user's bounds on tilt, heave and slip of the robot on a floor with lippage, that is, with the steps between neighbouring tiles that
/// standards allow, under wheels and casters.
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

/// Whether the scene's localizer uses the method of this name.
fn uses(stated: &Map<String, Value>, name: &str) -> bool {
    let methods = stated.get("localizer").and_then(|localizer| localizer.get("methods")).and_then(Value::as_array);
    methods.into_iter().flatten().any(|method| method == name)
}

fn leave_out_what_is_stated_in_part(keys: &mut Value, stated: &Map<String, Value>) {
    for (device, Careful { together, .. }) in devices::careful() {
        let said = stated.get("robot").and_then(|robot| robot.get(device));
        let is_stated = together.iter().any(|key| said.is_some_and(|said| said.get(key).is_some()));
        let keys = keys.pointer_mut(&format!("/robot/{device}")).and_then(Value::as_object_mut);
        if let Some(keys) = keys.filter(|_| is_stated) {
            keys.retain(|key, _| !together.contains(&key.as_str()));
        }
    }
}

/// Removes two bounds on furniture from the careful user's `keys` if the scene states one of them: the greatest angle by which furniture is turned at
/// random, and the bound that is declared on this angle. They mean something only together.
fn leave_out_furniture_if_stated(keys: &mut Value, stated: &Map<String, Value>) {
    const TOGETHER: [[&str; 2]; 2] =
        [["/building", "furniture_tolerance_deg"], ["/localizer/wall_directions", "askew_deg"]];
    let said = Value::Object(stated.clone());
    let is_stated = |[table, key]: &[&str; 2]| said.pointer(table).is_some_and(|table| table.get(key).is_some());
    if TOGETHER.iter().any(is_stated) {
        for [table, key] in TOGETHER {
            keys.pointer_mut(table).and_then(Value::as_object_mut).map(|table| table.remove(key));
        }
    }
}

/// Widens the bounds in `keys` to those in `least`: smaller numbers are raised, missing keys are added, and values that are no numbers are replaced.
/// For every key in `least` the greater number is the wider bound.
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
