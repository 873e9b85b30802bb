//! A scene file whose keys are set before a scene is made of it.

use std::path::Path;

use serde_json::Value as Json;
use toml::{Table, Value};

use super::{SceneFile, Setting, shown};
use crate::scene::{
    Scene, SceneError,
    moved::place_now,
    schema::{alternatives, resolve, schema},
};

/// A scene file whose keys can be changed before a scene is made of it.
#[derive(Clone, Debug)]
pub struct SceneTemplate {
    file: SceneFile,
    document: Table,
}

impl SceneTemplate {
    /// Reads a scene file, which must be valid as it stands.
    pub fn load(path: &Path) -> Result<SceneTemplate, SceneError> {
        let file = SceneFile::load(path)?;
        let unreadable = |source| SceneError::Unreadable { path: path.to_owned(), source };
        // Parsing this text as TOML cannot fail: the scene was loaded from it before.
        let document = file.text.parse().map_err(|error| unreadable(std::io::Error::other(error)))?;
        Ok(SceneTemplate { file, document })
    }

    /// The scene as its file states it, without any setting.
    pub fn file(&self) -> &SceneFile {
        &self.file
    }

    /// The scene with `settings`, which are checked against the schema like the file's own values.
    pub fn with(&self, settings: &[Setting]) -> Result<SceneFile, SceneError> {
        if settings.is_empty() {
            return Ok(self.file.clone());
        }
        let mut document = self.document.clone();
        for setting in settings {
            if setting.key == "extends" {
                return Err(SceneError::SetBase { path: self.file.path.clone(), value: shown(&setting.value) });
            }
            let steps = self.steps(&setting.key)?;
            // If a setting goes into a table that the schema allows, but the file states something else there, such as `false` for a device, a table
            // replaces it.
            put(&mut document, &steps, setting.value.clone());
        }
        let listed: Vec<String> = settings.iter().map(Setting::to_string).collect();
        let name = format!("{} with {}", self.file.path.display(), listed.join(", "));
        let text = document.to_string();
        let scene = Scene::parse_beside(&text, &name, self.file.path.parent())?;
        Ok(SceneFile { scene, text, settings: settings.to_vec(), ..self.file.clone() })
    }

    /// The steps through tables and lists of the document that lead to a key of the scene.
    fn steps(&self, key: &str) -> Result<Vec<Step>, SceneError> {
        let document = Value::Table(self.document.clone());
        let segments = segments(key);
        walk(resolve(schema()), Some(&document), &segments).ok_or_else(|| {
            let mut known = Vec::new();
            list(resolve(schema()), Some(&document), "", &mut known);
            SceneError::UnknownKey {
                path: self.file.path.clone(),
                key: key.to_owned(),
                nearest: place_now(key).map_or_else(|| nearest_keys(key, known), |now| vec![now.to_owned()]),
            }
        })
    }
}

/// One step into a document: to a key of a table, or to an item of a list.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Key(String),
    Item(usize),
}

/// Splits a dotted path into its parts: `route.waypoint[2].x_m` into `route`, `waypoint`, `2`, `x_m`.
fn segments(key: &str) -> Vec<&str> {
    key.split(['.', '[']).map(|segment| segment.trim_end_matches(']')).collect()
}

/// The steps along the parts `segments` of a dotted path. `None` if the schema `node`, or a list in the value `place` of the document, has no such
/// part.
fn walk(node: &'static Json, place: Option<&Value>, segments: &[&str]) -> Option<Vec<Step>> {
    let Some((segment, rest)) = segments.split_first() else { return Some(Vec::new()) };
    let (step, node, place) = options(node, place).into_iter().find_map(|option| enter(option, place, segment))?;
    let mut steps = vec![step];
    match node {
        Some(node) => steps.extend(walk(node, place, rest)?),
        // Below a table that may have keys of any name, such as `expect`, the scene's own check decides which are allowed.
        None => steps.extend(rest.iter().map(|segment| Step::Key((*segment).to_owned()))),
    }
    Some(steps)
}

/// Takes one step along a dotted path, to the key or list item `segment` of what the schema `node` describes. The returned schema is `None` where
/// keys may have any name.
fn enter<'a>(
    node: &'static Json,
    place: Option<&'a Value>,
    segment: &str,
) -> Option<(Step, Option<&'static Json>, Option<&'a Value>)> {
    if let Some(items) = node.get("items") {
        let present = place?.as_array()?;
        let index = segment.parse().ok().or_else(|| present.iter().position(|item| name_of(item) == Some(segment)))?;
        return Some((Step::Item(index), Some(resolve(items)), Some(present.get(index)?)));
    }
    let inner = place.and_then(|place| place.get(segment));
    let key = || Step::Key(segment.to_owned());
    match node.get("properties").and_then(|properties| properties.get(segment)) {
        Some(property) => Some((key(), Some(resolve(property)), inner)),
        None if is_free(node) => Some((key(), None, inner)),
        None => None,
    }
}

/// The schemas that may hold in place of `node`: its alternatives, or the schema of the `kind` that the document states.
fn options(node: &'static Json, place: Option<&Value>) -> Vec<&'static Json> {
    let mut options: Vec<&'static Json> = alternatives(node).into_iter().map(resolve).collect();
    if options.is_empty() {
        options.push(node);
    }
    let kind = place.and_then(|place| place.get("kind")).and_then(Value::as_str);
    let variants = node.get("oneOf").and_then(Json::as_array).into_iter().flatten();
    options.extend(variants.filter(|variant| variant["properties"]["kind"]["const"].as_str() == kind));
    options
}

fn is_free(node: &Json) -> bool {
    node.get("additionalProperties").is_some_and(|free| *free != Json::Bool(false))
}

fn name_of(item: &Value) -> Option<&str> {
    item.get("name").and_then(Value::as_str)
}

fn put(table: &mut Table, steps: &[Step], value: Value) {
    let Some((Step::Key(key), rest)) = steps.split_first() else { return };
    if rest.is_empty() {
        table.insert(key.clone(), value);
        return;
    }
    put_into(table.entry(key.clone()).or_insert_with(|| Value::Table(Table::new())), rest, value);
}

fn put_into(place: &mut Value, steps: &[Step], value: Value) {
    match steps.split_first() {
        None => *place = value,
        Some((Step::Item(index), rest)) => {
            if let Some(item) = place.as_array_mut().and_then(|items| items.get_mut(*index)) {
                put_into(item, rest, value);
            }
        }
        Some((Step::Key(_), _)) => {
            if !place.is_table() {
                *place = Value::Table(Table::new());
            }
            if let Value::Table(table) = place {
                put(table, steps, value);
            }
        }
    }
}

/// Lists the paths of all keys that the scene could state and that hold a value instead of a table.
fn list(node: &'static Json, place: Option<&Value>, path: &str, known: &mut Vec<String>) {
    let before = known.len();
    for option in options(node, place) {
        for (name, property) in option.get("properties").and_then(Json::as_object).into_iter().flatten() {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            list(resolve(property), place.and_then(|place| place.get(name)), &path, known);
        }
        let items = place.and_then(Value::as_array).into_iter().flatten().enumerate();
        for (index, item) in items.filter(|(_, item)| item.is_table()) {
            let path = match name_of(item) {
                Some(name) => format!("{path}.{name}"),
                None => format!("{path}[{index}]"),
            };
            list(resolve(&option["items"]), Some(item), &path, known);
        }
    }
    if known.len() == before && !path.is_empty() {
        known.push(path.to_owned());
    }
}

/// Up to three known keys that may have been meant by an unknown one. The similarity of a key's last part counts as much as that of the whole path.
fn nearest_keys(key: &str, known: Vec<String>) -> Vec<String> {
    // For a misspelled key the most similar known keys are suggested, up to this difference in similarity from the most similar one: keys beyond
    // it would only distract.
    const SLACK: f64 = 0.4;
    let last = |path: &str| segments(path).last().map_or_else(String::new, |last| (*last).to_owned());
    // If a known key has no parts, and the unknown path goes on below it, that key must have been meant.
    let has_no_parts = |path: &str| key.strip_prefix(path).is_some_and(|rest| rest.starts_with(['.', '[']));
    let similarity = |path: &str| {
        let alike = strsim::jaro_winkler(key, path) + strsim::jaro_winkler(&last(key), &last(path)).powi(2);
        alike + f64::from(u8::from(has_no_parts(path)))
    };
    let mut ranked: Vec<(f64, String)> = known.into_iter().map(|path| (similarity(&path), path)).collect();
    ranked.sort_by(|one, other| other.0.total_cmp(&one.0));
    ranked.dedup();
    let best = ranked.first().map_or(0.0, |(similarity, _)| *similarity);
    ranked.into_iter().filter(|(similarity, _)| *similarity > best - SLACK).map(|(_, path)| path).take(3).collect()
}
