//! Tables of a scene under construction, read and written by key.

use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::campaign::falsify::dice::rounded;

/// Returns the table at `key`, which is created if it does not exist.
pub(super) fn table<'a>(of: &'a mut Table, key: &str) -> &'a mut Table {
    if !of.get(key).is_some_and(Value::is_table) {
        of.insert(key.to_owned(), Value::Table(Table::new()));
    }
    match of.get_mut(key) {
        Some(Value::Table(table)) => table,
        _ => unreachable!("a table was put at {key} just now"),
    }
}

/// Returns the tables of the list at `key`.
pub(super) fn items<'a>(of: &'a mut Table, key: &str) -> impl Iterator<Item = &'a mut Table> {
    of.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_table_mut)
}

/// Returns the number at `key`, if the table has one.
pub(super) fn number(of: &Table, key: &str) -> Option<f64> {
    let value = of.get(key)?;
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Returns the text at `key`, if the table has one.
pub(super) fn text(of: &Table, key: &str) -> Option<String> {
    of.get(key)?.as_str().map(str::to_owned)
}

/// Parses a part of a scene, with default values for the keys that it does not state; none when the part is invalid, which makes the whole scene
/// invalid.
pub(super) fn meaning<T: DeserializeOwned>(of: &Table) -> Option<T> {
    Value::Table(of.clone()).try_into().ok()
}

/// Writes a position into a table as the keys `x_m` and `y_m`.
pub(super) fn place(table: &mut Table, at_m: [f64; 2]) {
    for (key, value_m) in [("x_m", at_m[0]), ("y_m", at_m[1])] {
        table.insert(key.to_owned(), Value::Float(rounded(value_m, 4)));
    }
}
