//! Keys of a scene that are set to other values than its file states, as `--set` and `--vary` demand.

use std::{collections::BTreeMap, fmt, str::FromStr};

use toml::{Table, Value};

/// One key of a scene and the value to which it is set.
///
/// The key is a dotted path, as error messages write it. An item of a list is selected by its `name` or its index: `floor.region.carpet.friction`,
/// `route.waypoint[2].x_m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Dotted path of the scene's key to set.
    pub key: String,
    /// Value to which a key of the scene is set.
    pub value: Value,
}

impl Setting {
    /// Sets a key to a number, to six significant digits as a person would write it.
    pub fn number(key: &str, value: f64) -> Setting {
        Setting { key: key.to_owned(), value: Value::Float(rounded(value)) }
    }
}

fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// The text of a scene that extends the scene file `base` by settings of keys outside of lists.
pub fn extending(base: &str, settings: &[Setting]) -> String {
    let mut tables: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for Setting { key, value } in settings {
        let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
        tables.entry(table).or_default().push(format!("{name} = {value}\n"));
    }
    let mut text = format!("extends = {}\n", Value::from(base));
    for (table, lines) in tables {
        let head = if table.is_empty() { String::new() } else { format!("\n[{table}]\n") };
        text.push_str(&head);
        text.extend(lines);
    }
    text
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key, shown(&self.value))
    }
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => {
                Ok(Setting { key: key.trim().to_owned(), value: value_of(value.trim()) })
            }
            _ => Err("expected KEY=VALUE, such as light.illuminance_at_floor_lux=0.1".to_owned()),
        }
    }
}

/// Reads a value as a user types it: as TOML, or else as a number or as a text without quotes.
pub fn value_of(text: &str) -> Value {
    let as_toml = || format!("v = {text}").parse::<Table>().ok()?.remove("v");
    let as_number = || text.parse::<f64>().ok().map(Value::Float);
    as_toml().or_else(as_number).unwrap_or_else(|| Value::String(text.to_owned()))
}

/// Writes a value so that `value_of` reads it back.
pub fn shown(value: &Value) -> String {
    match value {
        Value::String(text) if value_of(text) == *value && !text.contains([',', ' ', '=']) => text.clone(),
        Value::Float(number) => number.to_string(),
        _ => value.to_string(),
    }
}
