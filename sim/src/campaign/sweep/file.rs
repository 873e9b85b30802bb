//! A sweep as a file with the keys `scene`, `seeds`, `subject` and `baselines` and a table `[vary]`.

use std::path::Path;

use toml::{
    Table, Value,
    de::{DeTable, DeValue},
};

use crate::{
    scene::{SceneError, text_of},
    subject::SubjectChoice,
};

use super::{Seeds, Sweep, SweepError, Variable, variable::values_of};

/// The keys of a sweep file.
const KEYS: [&str; 5] = ["scene", "seeds", "subject", "baselines", "vary"];

impl Sweep {
    /// Reads a sweep file; none when the file is not a sweep but, because it has no key `scene`, presumably a scene.
    ///
    /// The path of the scene in the file is relative to the sweep file.
    pub fn load(path: &Path) -> Result<Option<Sweep>, SweepError> {
        let text = match text_of(path) {
            Ok(text) => text,
            // A file that is not text is no sweep; loading it as a scene reports the error.
            Err(SceneError::NotText { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let Ok(table) = text.parse::<Table>() else { return Ok(None) };
        if !table.contains_key("scene") {
            return Ok(None);
        }
        let wrong = |expected: String| SweepError::BadFile { path: path.to_owned(), expected };
        if let Some(unknown) = table.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return Err(wrong(format!("`{unknown}`: unknown key, expected one of {}", KEYS.join(", "))));
        }
        let scene = table["scene"].as_str().ok_or_else(|| wrong("`scene`: expected a text in quotes".to_owned()))?;
        let seeds = match table.get("seeds") {
            None => 0..1,
            Some(stated) => {
                let text =
                    stated.as_str().ok_or_else(|| wrong("`seeds`: expected a text such as \"0..20\"".to_owned()))?;
                text.parse::<Seeds>().map_err(|expected| wrong(format!("`seeds = \"{text}\"`: {expected}")))?.0
            }
        };
        let baselines = match table.get("baselines") {
            None => false,
            Some(stated) => stated.as_bool().ok_or_else(|| wrong("`baselines`: expected true or false".to_owned()))?,
        };
        let subject = match table.get("subject") {
            None => SubjectChoice::default(),
            Some(stated) => {
                let text =
                    stated.as_str().ok_or_else(|| wrong("`subject`: expected a text such as \"ekf\"".to_owned()))?;
                text.parse().map_err(|expected| wrong(format!("`subject = \"{text}\"`: {expected}")))?
            }
        };
        let vary = variables(&text).map_err(wrong)?;
        let scene = path.parent().unwrap_or(Path::new("")).join(scene);
        Ok(Some(Sweep { scene, vary, seeds, subject, baselines }))
    }
}

/// Returns the variables of the table `[vary]`, in the order of the file.
fn variables(text: &str) -> Result<Vec<Variable>, String> {
    let document = DeTable::parse(text).map_err(|error| error.message().to_owned())?;
    let Some(vary) = document.get_ref().get("vary") else { return Ok(Vec::new()) };
    let DeValue::Table(table) = vary.get_ref() else { return Err("`vary`: expected a table".to_owned()) };
    let mut found = Vec::new();
    collect(table, "", &mut found)?;
    found.sort_by_key(|(start, _)| *start);
    Ok(found.into_iter().map(|(_, variable)| variable).collect())
}

/// Collects the variables of a table. Dotted keys are nested tables; each list, range or single value at the end of a key is a variable.
fn collect(table: &DeTable<'_>, path: &str, found: &mut Vec<(usize, Variable)>) -> Result<(), String> {
    for (name, value) in table.iter() {
        let key = if path.is_empty() { name.get_ref().to_string() } else { format!("{path}.{}", name.get_ref()) };
        let start = value.span().start;
        let stated = match value.get_ref() {
            DeValue::Table(inner) => {
                collect(inner, &key, found)?;
                continue;
            }
            other => owned(other),
        };
        let values = match stated {
            Value::Array(values) => values,
            Value::String(text) => values_of(&text).map_err(|expected| format!("`vary.{key}`: {expected}"))?,
            single => vec![single],
        };
        if values.is_empty() {
            return Err(format!("`vary.{key}`: an empty list, expected at least one value"));
        }
        found.push((start, Variable { key, values }));
    }
    Ok(())
}

fn owned(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => {
            i64::from_str_radix(number.as_str(), number.radix()).map_or(Value::Float(f64::NAN), Value::Integer)
        }
        DeValue::Float(number) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => Value::Boolean(*truth),
        DeValue::Datetime(time) => Value::Datetime(*time),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| owned(item.get_ref())).collect()),
        DeValue::Table(table) => {
            Value::Table(table.iter().map(|(key, value)| (key.get_ref().to_string(), owned(value.get_ref()))).collect())
        }
    }
}
