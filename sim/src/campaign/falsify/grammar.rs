//! Random scenes, drawn from everything that the schema of scenes allows.
//!
//! The schema defines the keys and their possible values, so that a key that is added to scenes is searched without any change here. The module
//! `weights` defines how often keys are stated, and narrower ranges where the schema's range is wider than what a robot can drive with. The module
//! `settled` ensures what a schema cannot: that things stand in the room, events lie within the time of the run, and methods have the devices that
//! they read.

mod building;
mod car;
mod ceiling;
mod drive;
mod far_room;
mod numbers;
mod robot;
mod settled;
mod tables;
mod weights;

use serde_json::Value as Json;
use toml::{Table, Value};

use crate::scene::schema::{alternatives, choices, numbers as listed, resolve, schema, type_name};

use super::dice::{Draws, rounded};
use numbers::{Span, number};

/// Kinds of scenes that a search draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// A scene has cameras with a probability of 0.1 only, as a run with cameras takes some ten times longer.
    Mixed,
    /// No scene has a camera that renders images; the sensors are wheels, gyroscope, flow sensor, range camera and satellite navigation.
    WithoutCameras,
    /// Every scene has at least one camera that renders images.
    WithCameras,
}

impl Profile {
    /// Returns the name of this kind of scenes, as files and the command line have it.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Mixed => "mixed",
            Profile::WithoutCameras => "without_cameras",
            Profile::WithCameras => "with_cameras",
        }
    }

    /// Draws whether the scene of a case has cameras.
    fn has_cameras(self, draws: &Draws) -> bool {
        match self {
            Profile::Mixed => draws.dice("has cameras").chance(0.1),
            Profile::WithoutCameras => false,
            Profile::WithCameras => true,
        }
    }
}

/// Draws a scene at random, and the seed of its run. The scene may be invalid and be refused.
pub(super) fn scene(draws: &Draws, profile: Profile) -> (Table, u64) {
    let has_cameras = profile.has_cameras(draws);
    let mut dice = draws.dice("room");
    // Most rooms are small enough that a robot crosses them within a run; one in ten may be as large as a hall.
    let most_m = if dice.chance(0.1) { 15.0 } else { 6.0 };
    let room_m = [0, 1].map(|_| rounded(dice.log_uniform(1.2, most_m), 3));
    let walk = Walk { draws, room_m, boldness: *draws.dice("boldness").choose(&BOLDNESS) };
    let mut scene = walk.table(resolve(schema()), "");
    settled::settle(&mut scene, draws, room_m, has_cameras);
    // The seed of the run is a number of at most two digits, which is easy for a person to type.
    (scene, draws.dice("seed of the run").whole(0, 99) as u64)
}

/// Probabilities with which a scene states a key that is a plain value. For each scene one of these probabilities is drawn and applies to all such
/// keys. A scene that states few keys tests them singly, a scene that states many tests combinations.
const BOLDNESS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];

/// State of a recursive walk through the schema of scenes, in which a scene is generated at random.
struct Walk<'a> {
    draws: &'a Draws,
    room_m: [f64; 2],
    boldness: f64,
}

impl Walk<'_> {
    /// Draws a table of the scene with some of its keys. `path` is the table's place in the scene as dotted keys, with indices for items of lists.
    fn table(&self, node: &'static Json, path: &str) -> Table {
        let mut table = Table::new();
        let Some(properties) = node.get("properties").and_then(Json::as_object) else { return table };
        let required = required(node);
        for (name, property) in properties {
            let inner = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let is_required = required.contains(&name.as_str());
            let share = weights::chance(&inner).unwrap_or_else(|| self.usual_chance(property));
            if (is_required || self.draws.dice(&format!("{inner} stated")).chance(share))
                && let Some(value) = self.value(property, &inner)
            {
                table.insert(name.clone(), value);
            }
        }
        table
    }

    /// Returns the probability that a scene states a key for which `weights` lists none.
    fn usual_chance(&self, property: &'static Json) -> f64 {
        let node = resolve(property);
        match type_name(node) {
            // Lists of any length, such as furniture or events, are stated seldom: many things make a run longer, and one hides the effect of
            // another.
            "array" if node.get("minItems") != node.get("maxItems") => 0.15,
            "object" => 0.5,
            "" if !alternatives(node).is_empty() => 0.5,
            _ => self.boldness,
        }
    }

    /// Draws a value that the schema allows for a key; none where the schema does not say which values are possible.
    fn value(&self, property: &'static Json, path: &str) -> Option<Value> {
        let stated = resolve(property);
        // The keys of a device may be stated as a table, or as true or false. Always the table is drawn, as it can express everything that true or
        // false stand for.
        let options = alternatives(stated);
        let mut tables = options.into_iter().map(resolve).filter(|option| option.get("properties").is_some());
        let node = tables.next().unwrap_or(stated);
        if let Some(variants) = variants(node) {
            return Some(self.variant(variants, path));
        }
        let mut dice = self.draws.dice(path);
        match type_name(node) {
            "object" => node.get("properties").map(|_| Value::Table(self.table(node, path))),
            "array" => self.list(node, path),
            "boolean" => Some(Value::Boolean(dice.chance(0.5))),
            "integer" | "number" if listed(node).is_some() => {
                let options = listed(node).filter(|options| !options.is_empty())?;
                Some(Value::Integer(*dice.choose(&options) as i64))
            }
            "integer" => {
                let drawn = number(&mut dice, &Span::of(node, property, path))?;
                Some(Value::Integer(drawn.round() as i64))
            }
            "number" => Some(Value::Float(self.number(node, property, path)?)),
            _ if !choices(node).is_empty() => Some(Value::String((*dice.choose(&choices(node))).to_owned())),
            // A key with a free text is a name, such as that of a floor region. Names have to differ, so that the path of the key is used.
            "string" => Some(Value::String(path.to_owned())),
            _ => None,
        }
    }

    /// Draws the value of a numerical key. A coordinate without a greatest value is drawn within the room, an angle in degrees without a greatest
    /// value as a direction, and any other number within the key's range.
    fn number(&self, node: &'static Json, property: &'static Json, path: &str) -> Option<f64> {
        let mut dice = self.draws.dice(path);
        let last = path.rsplit('.').next().unwrap_or(path);
        let is_free = node.get("maximum").is_none();
        match last {
            "x_m" if is_free => Some(rounded(dice.uniform(0.0, self.room_m[0]), 4)),
            "y_m" if is_free => Some(rounded(dice.uniform(0.0, self.room_m[1]), 4)),
            _ if is_free && last.ends_with("_deg") => Some(numbers::direction_deg(&mut dice)),
            _ => number(&mut dice, &Span::of(node, property, path)),
        }
    }

    fn list(&self, node: &'static Json, path: &str) -> Option<Value> {
        let items = node.get("items")?;
        let last = path.rsplit('.').next().unwrap_or(path);
        let mut dice = self.draws.dice(&format!("{path} length"));
        let bound = |name: &str| node.get(name).and_then(Json::as_i64);
        let [least, most] = match (bound("minItems"), bound("maxItems")) {
            (Some(least), Some(most)) if least == most => [least, most],
            (least, most) => {
                let [usual_least, usual_most] = weights::count(path);
                [least.unwrap_or(0).max(usual_least), most.unwrap_or(usual_most).min(usual_most.max(1))]
            }
        };
        let length = dice.whole(least, most);
        let is_place = matches!(last, "from_m" | "to_m") || last.starts_with("waypoints_m[");
        let item = |index: i64| {
            let path = format!("{path}[{index}]");
            if is_place {
                let extent_m = self.room_m[usize::from(index == 1)];
                return Some(Value::Float(rounded(self.draws.dice(&path).uniform(0.0, extent_m), 4)));
            }
            self.value(items, &path)
        };
        Some(Value::Array((0..length).filter_map(item).collect()))
    }

    /// Draws one of the several tables that the schema allows for a key and that differ by their key `kind`.
    fn variant(&self, variants: Vec<&'static Json>, path: &str) -> Value {
        let chosen = self.draws.dice(&format!("{path} kind")).choose(&variants);
        let kind = chosen["properties"]["kind"]["const"].as_str().unwrap_or_default();
        let mut table = self.table(chosen, path);
        table.insert("kind".to_owned(), Value::String(kind.to_owned()));
        Value::Table(table)
    }
}

/// Returns the tables that the schema allows for a key and that differ by their key `kind`; none when there is no such choice.
fn variants(node: &'static Json) -> Option<Vec<&'static Json>> {
    let listed = node.get("oneOf")?.as_array()?;
    let variants: Vec<&Json> = listed.iter().filter(|one| one.get("properties").is_some()).collect();
    (!variants.is_empty()).then_some(variants)
}

fn required(node: &Json) -> Vec<&str> {
    node.get("required").and_then(Json::as_array).into_iter().flatten().filter_map(Json::as_str).collect()
}

/// Returns the dotted path of a key without the indices of list items.
fn without_indices(path: &str) -> String {
    let mut plain = String::with_capacity(path.len());
    let mut is_index = false;
    for c in path.chars() {
        match c {
            '[' => is_index = true,
            ']' => is_index = false,
            _ if !is_index => plain.push(c),
            _ => {}
        }
    }
    plain
}

/// Returns every key of the schema as a path without indices, for tests that every key is drawn.
pub(super) fn paths() -> Vec<String> {
    fn collect(node: &'static Json, path: &str, found: &mut Vec<String>) {
        let stated = resolve(node);
        let options = alternatives(stated);
        let mut nodes: Vec<&'static Json> = if options.is_empty() { vec![stated] } else { options };
        nodes.extend(variants(stated).into_iter().flatten());
        for node in nodes.into_iter().map(resolve) {
            for (name, property) in node.get("properties").and_then(Json::as_object).into_iter().flatten() {
                let inner = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                found.push(inner.clone());
                collect(property, &inner, found);
            }
            if let Some(items) = node.get("items") {
                collect(items, path, found);
            }
        }
    }
    let mut found = Vec::new();
    collect(schema(), "", &mut found);
    found.sort();
    found.dedup();
    found
}
