//! Makes the documentation page with every key of a scene from the schema.

use std::{collections::VecDeque, fmt::Write};

use serde_json::Value;

use super::schema::{ADDS, EXTENDS, alternatives, choices, numbers, resolve, schema, type_name};

const HEAD: &str = "\
# Keys of a scene

One TOML file is one situation. Every key has a default that a user would expect, or is marked *needed*; every number has a range, and what lies
outside of it is refused with the range. `scenes/schema.json` says the same to an editor. A table that may be left out, such as a camera, is put in by
its header alone.

This page is made by `wherein schema --markdown`.
";

/// A table of keys that is still to be written to the page.
struct Table {
    path: String,
    is_list: bool,
    /// Value of the key `kind`, for a table that is one of several kinds.
    kind: Option<&'static str>,
    description: String,
    node: &'static Value,
}

/// Text of the page, in Markdown.
pub fn keys_markdown() -> String {
    let root = Table { path: String::new(), is_list: false, kind: None, description: String::new(), node: schema() };
    let (mut text, mut tables) = (HEAD.to_owned(), VecDeque::from([root]));
    while let Some(table) = tables.pop_front() {
        let found = write_table(&mut text, &table);
        // Tables inside the table just written come directly after it on the page.
        found.into_iter().rev().for_each(|inner| tables.push_front(inner));
    }
    text
}

/// Writes a table's own keys to the page, and returns the tables inside it.
fn write_table(text: &mut String, table: &Table) -> Vec<Table> {
    let header = match (table.path.as_str(), table.is_list, table.kind) {
        ("", ..) => "First of all".to_owned(),
        (path, true, Some(kind)) => format!("`[[{path}]]` of `kind = \"{kind}\"`"),
        (path, true, None) => format!("`[[{path}]]`"),
        (path, false, _) => format!("`[{path}]`"),
    };
    // Writing to a `String` cannot fail.
    let _ = write!(text, "\n## {header}\n\n{}", paragraph(&table.description));
    let needed: Vec<&str> = table.node["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let (mut inner, mut rows) = (Vec::new(), String::new());
    if table.path.is_empty() {
        let _ = writeln!(rows, "| `extends` | {EXTENDS} See [Scenes that build on others](extends.md). | text |  |");
        let _ = writeln!(rows, "| `adds` | {ADDS} | table of lists |  |");
    }
    for (key, property) in table.node["properties"].as_object().into_iter().flatten() {
        let tables = tables_of(property);
        // The key of a table has one description, and the type of the table another. If both are equal, only one is written.
        let node =
            tables.first().filter(|(_, is_list, _)| !is_list).map_or_else(|| resolve(property), |(node, ..)| node);
        let said = [&property["description"], &node["description"]].map(|text| text.as_str().unwrap_or_default());
        let description = if said[0] == said[1] { said[0].to_owned() } else { said.join(" ") };
        let description = description.trim().replace('\n', " ");
        let path = if table.path.is_empty() { key.clone() } else { format!("{}.{key}", table.path) };
        if !tables.is_empty() {
            inner.extend(tables.into_iter().map(|(node, is_list, kind)| {
                let own = kind.and_then(|_| node["description"].as_str()).map(str::to_owned);
                let description = own.unwrap_or_else(|| description.clone());
                Table { path: path.clone(), is_list, kind, description, node }
            }));
            continue;
        }
        let default = match property.get("default") {
            Some(Value::Null) | None if needed.contains(&key.as_str()) => "*needed*".to_owned(),
            Some(Value::Null) | None => String::new(),
            Some(value) => format!("`{value}`"),
        };
        let _ = writeln!(
            rows,
            "| `{key}` | {} | {} | {default} |",
            description.replace('|', "\\|"),
            range(resolve(property))
        );
    }
    if !rows.is_empty() {
        let _ = write!(text, "| key | what it is | may be | default |\n|---|---|---|---|\n{rows}");
    }
    inner
}

fn paragraph(description: &str) -> String {
    if description.is_empty() { String::new() } else { format!("{description}\n\n") }
}

/// The tables that a key may hold, alone or as an alternative to a value such as `true`. Returns for each its schema, whether it stands in a list,
/// and its kind.
fn tables_of(property: &'static Value) -> Vec<(&'static Value, bool, Option<&'static str>)> {
    let node = resolve(property);
    let is_table = |node: &&'static Value| type_name(node) == "object";
    if type_name(node) == "array" {
        let items = resolve(&node["items"]);
        let kinds = items["oneOf"].as_array().into_iter().flatten().filter(is_table);
        let kinds = kinds.map(|one| (one, true, one["properties"]["kind"]["const"].as_str()));
        return Some(items).filter(is_table).map(|items| (items, true, None)).into_iter().chain(kinds).collect();
    }
    let found = Some(node).filter(is_table).or_else(|| alternatives(node).into_iter().map(resolve).find(is_table));
    found.map(|table| (table, false, None)).into_iter().collect()
}

/// Describes in words what values a key may have.
fn range(node: &'static Value) -> String {
    let words = choices(node);
    if !words.is_empty() {
        return words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
    }
    if let Some(only) = node["const"].as_str() {
        return format!("`{only}`");
    }
    let several = alternatives(node);
    if !several.is_empty() {
        return several.into_iter().map(|one| range(resolve(one))).collect::<Vec<_>>().join(", or ");
    }
    match type_name(node) {
        "number" | "integer" if numbers(node).is_some() => {
            let listed = numbers(node).into_iter().flatten().map(|number| format!("`{number}`"));
            listed.collect::<Vec<_>>().join(", ")
        }
        "number" => format!("number{}", bounds(node)),
        "integer" => format!("whole number{}", bounds(node)),
        "boolean" => "`true`, `false`".to_owned(),
        "string" => "text".to_owned(),
        "array" => {
            let items = range(resolve(&node["items"]));
            match (node["minItems"].as_u64(), node["maxItems"].as_u64()) {
                (Some(least), Some(most)) if least == most => format!("{least} of: {items}"),
                _ => format!("list of: {items}"),
            }
        }
        _ => String::new(),
    }
}

fn bounds(node: &Value) -> String {
    let number = |key: &str| node[key].as_f64();
    match (number("minimum"), number("exclusiveMinimum"), number("maximum")) {
        (Some(least), _, Some(most)) => format!(", {least} to {most}"),
        (None, Some(above), Some(most)) => format!(", above {above}, at most {most}"),
        (Some(least), _, None) => format!(", at least {least}"),
        (None, Some(above), None) => format!(", above {above}"),
        (None, None, Some(most)) => format!(", at most {most}"),
        (None, None, None) => String::new(),
    }
}
