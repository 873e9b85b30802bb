//! The JSON schema of a scene: what an editor checks while one types, and what `parse` checks.

use std::{iter, sync::OnceLock};

use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::{Scene, extend::EXTENDS};

/// The schema as `scenes/schema.json` holds it: of one file, which may extend another.
pub fn schema_text() -> String {
    let mut file = schema().clone();
    file["properties"]["extends"] = json!({ "description": EXTENDS, "type": "string" });
    ask_for_nothing(&mut file, "");
    // A `Value` that came from a schema always has a text, since its keys are strings.
    format!("{file:#}\n")
}

/// Leaves away what tables outside of lists must state, as what a file leaves out may stand in the one that it extends. `pointer` leads
/// to a table in `file`.
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

/// The schema of a scene as a whole, generated once.
pub(crate) fn schema() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Scene>().to_value())
}

/// The schema that `node` stands for: references are followed, and `null` drops out of what a key may be.
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

/// The alternatives of an `anyOf` without `null`; none when there is no `anyOf`.
pub(crate) fn alternatives(node: &'static Value) -> Vec<&'static Value> {
    let any_of = node.get("anyOf").and_then(Value::as_array);
    any_of.into_iter().flatten().filter(|option| option.get("type").and_then(Value::as_str) != Some("null")).collect()
}

/// The type a schema asks for, without `null`; empty when it asks for none.
pub(crate) fn type_name(node: &Value) -> &str {
    match &node["type"] {
        Value::String(name) => name,
        Value::Array(names) => names.iter().filter_map(Value::as_str).find(|name| *name != "null").unwrap_or(""),
        _ => "",
    }
}

/// The numbers among which a schema lets choose; `None` when it lists none.
pub(crate) fn numbers(node: &Value) -> Option<Vec<f64>> {
    Some(node.get("enum")?.as_array()?.iter().filter_map(Value::as_f64).collect())
}

/// The texts that a string may be; empty when any will do.
pub(crate) fn choices(node: &'static Value) -> Vec<&'static str> {
    let listed = node.get("enum").and_then(Value::as_array).into_iter().flatten();
    let described =
        node.get("oneOf").and_then(Value::as_array).into_iter().flatten().filter_map(|one| one.get("const"));
    listed.chain(described).filter_map(Value::as_str).collect()
}
