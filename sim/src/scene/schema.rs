//! The JSON schema of a scene, which an editor checks while a user types and `parse` checks when it reads a scene.

use std::{iter, sync::OnceLock};

use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::Scene;

/// Explanation of the key `extends`, for the schema.
pub(super) const EXTENDS: &str = "A file on whose keys this one builds, as a path from this file's folder. Tables merge key by key, and this file \
wins; any other value, lists included, replaces the whole. `description` is never taken over, `[expect]` only as a whole.";

/// Explanation of the key `adds`, for the schema.
pub(super) const ADDS: &str = "Entries to put at the end of lists of the file that this one extends, each under the key of its list: \
`[[adds.furniture]]` is one more piece of furniture.";

/// Text of the schema, as in `scenes/schema.json`. It describes a single scene file, which may extend another file and then leave out keys.
pub fn schema_text() -> String {
    let mut file = schema().clone();
    file["properties"]["adds"] = json!({ "description": ADDS, "type": "object" });
    file["properties"]["extends"] = json!({ "description": EXTENDS, "type": "string" });
    ask_for_nothing(&mut file, "");
    // A `Value` that came from a schema can always be written as text, since its keys are strings.
    format!("{file:#}\n")
}

/// Makes all keys optional in the table at `pointer` of the schema `file` and in all tables within, except in lists: a scene file that extends
/// another may leave out what the other one states.
fn ask_for_nothing(file: &mut Value, pointer: &str) {
    let Some(table) = file.pointer_mut(pointer).and_then(Value::as_object_mut) else { return };
    table.remove("required");
    let properties =
        table.get("properties").and_then(Value::as_object).into_iter().flat_map(|properties| properties.values());
    let references: Vec<String> = properties
        .flat_map(|property| {
            iter::once(property).chain(property.get("anyOf").and_then(Value::as_array).into_iter().flatten())
        })
        .filter_map(|property| property.get("$ref").and_then(Value::as_str))
        .map(|reference| reference.trim_start_matches('#').to_owned())
        .collect();
    references.iter().for_each(|pointer| ask_for_nothing(file, pointer));
}

/// The schema of a complete scene, generated once.
pub(crate) fn schema() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Scene>().to_value())
}

/// The schema that `node` stands for: references are followed, and `null` is removed from alternatives.
pub(crate) fn resolve(mut node: &'static Value) -> &'static Value {
    loop {
        if let Some(reference) = node.get("$ref").and_then(Value::as_str) {
            node = schema().pointer(reference.trim_start_matches('#')).unwrap_or(&Value::Null);
            continue;
        }
        match alternatives(node).as_slice() {
            [only] => node = only,
            _ => return node,
        }
    }
}

/// The alternatives of an `anyOf` without `null`; empty if there is no `anyOf`.
pub(crate) fn alternatives(node: &'static Value) -> Vec<&'static Value> {
    let any_of = node.get("anyOf").and_then(Value::as_array);
    any_of.into_iter().flatten().filter(|option| option.get("type").and_then(Value::as_str) != Some("null")).collect()
}

/// The type that a schema demands, without `null`; empty if the schema demands none.
pub(crate) fn type_name(node: &Value) -> &str {
    match &node["type"] {
        Value::String(name) => name,
        Value::Array(names) => names.iter().filter_map(Value::as_str).find(|name| *name != "null").unwrap_or(""),
        _ => "",
    }
}

/// The numbers among which a schema lets a user choose; `None` if the schema lists no values.
pub(crate) fn numbers(node: &Value) -> Option<Vec<f64>> {
    Some(node.get("enum")?.as_array()?.iter().filter_map(Value::as_f64).collect())
}

/// The texts among which a schema lets a user choose; empty if any text is allowed.
pub(crate) fn choices(node: &'static Value) -> Vec<&'static str> {
    let listed = node.get("enum").and_then(Value::as_array).into_iter().flatten();
    let described =
        node.get("oneOf").and_then(Value::as_array).into_iter().flatten().filter_map(|one| one.get("const"));
    listed.chain(described).filter_map(Value::as_str).collect()
}
