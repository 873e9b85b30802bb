//! Random scenes from a grammar over everything that the schema of scenes allows.
//!
//! The schema says which keys there are and what they may be, so that a key that scenes come to have is searched without a line here.
//! `weights` says how often and how far where the schema's range is wider than what can drive; `settled` says what a schema cannot:
//! that things stand in the room, events lie within the time, and methods have what they read.

mod building;
mod ceiling;
mod drive;
mod numbers;
mod robot;
mod settled;
mod weights;

use serde_json::Value as Json;
use toml::{Table, Value};

use crate::scene::schema::{alternatives, choices, numbers as listed, resolve, schema, type_name};

use super::dice::{Draws, rounded};
use numbers::{Span, number};

/// Which scenes a search draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Every tenth with cameras, as a run with cameras takes some ten times longer.
    Mixed,
    /// Wheels, gyroscope, flow sensor and range camera alone.
    WithoutCameras,
    /// At least one camera in each.
    WithCameras,
}

impl Profile {
    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Profile::Mixed => "mixed",
            Profile::WithoutCameras => "without_cameras",
            Profile::WithCameras => "with_cameras",
        }
    }

    /// Whether a case has cameras.
    fn has_cameras(self, draws: &Draws) -> bool {
        match self {
            Profile::Mixed => draws.dice("has cameras").chance(0.1),
            Profile::WithoutCameras => false,
            Profile::WithCameras => true,
        }
    }
}

/// A scene drawn at random, and the seed of its run. It may be refused.
pub(super) fn scene(draws: &Draws, profile: Profile) -> (Table, u64) {
    let has_cameras = profile.has_cameras(draws);
    let mut dice = draws.dice("room");
    // Rooms that a robot crosses within a run; now and then a hall.
    let most_m = if dice.chance(0.1) { 15.0 } else { 6.0 };
    let room_m = [0, 1].map(|_| rounded(dice.log_uniform(1.2, most_m), 3));
    let walk = Walk { draws, room_m, boldness: *draws.dice("boldness").choose(&BOLDNESS) };
    let mut scene = walk.table(resolve(schema()), "");
    settled::settle(&mut scene, draws, room_m, has_cameras);
    // Whole numbers of TOML have 63 bits; seeds that a person can type are better still.
    (scene, draws.dice("seed of the run").whole(0, 99) as u64)
}

/// How often plain keys are stated: a scene near the defaults breaks one thing, a far one breaks combinations.
const BOLDNESS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];

/// A walk along the schema.
struct Walk<'a> {
    draws: &'a Draws,
    room_m: [f64; 2],
    boldness: f64,
}

impl Walk<'_> {
    /// A table with some of its keys. `path` is dotted, items of lists by their index.
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

    /// How often a key is stated of which nothing else is known.
    fn usual_chance(&self, property: &'static Json) -> f64 {
        let node = resolve(property);
        match type_name(node) {
            // Lists of things lengthen a run and hide each other.
            "array" if node.get("minItems") != node.get("maxItems") => 0.15,
            "object" => 0.5,
            "" if !alternatives(node).is_empty() => 0.5,
            _ => self.boldness,
        }
    }

    /// A value that the schema allows; none where it does not say what there may be.
    fn value(&self, property: &'static Json, path: &str) -> Option<Value> {
        let stated = resolve(property);
        // A device is a table of its keys, or true or false: the table holds all that the others stand for.
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
            // A name of its own, as names have to differ.
            "string" => Some(Value::String(path.to_owned())),
            _ => None,
        }
    }

    /// A number: a place within the room where the key is a coordinate without a range, a direction where it is an angle without one.
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

    /// A table that its key `kind` selects.
    fn variant(&self, variants: Vec<&'static Json>, path: &str) -> Value {
        let chosen = self.draws.dice(&format!("{path} kind")).choose(&variants);
        let kind = chosen["properties"]["kind"]["const"].as_str().unwrap_or_default();
        let mut table = self.table(chosen, path);
        table.insert("kind".to_owned(), Value::String(kind.to_owned()));
        Value::Table(table)
    }
}

/// The tables among which a key `kind` selects; none when nothing is to be selected.
fn variants(node: &'static Json) -> Option<Vec<&'static Json>> {
    let listed = node.get("oneOf")?.as_array()?;
    let variants: Vec<&Json> = listed.iter().filter(|one| one.get("properties").is_some()).collect();
    (!variants.is_empty()).then_some(variants)
}

fn required(node: &Json) -> Vec<&str> {
    node.get("required").and_then(Json::as_array).into_iter().flatten().filter_map(Json::as_str).collect()
}

/// The path of a key whatever the places in lists.
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

/// Every key that the schema has, as a path without indices: for what asserts that all are drawn.
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
